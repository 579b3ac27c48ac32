// PC2, the point cache that Blender's modifier Mesh Cache reads. All numbers are little-endian: "POINTCACHE2" and a
// zero byte, version 1, number of points, first frame and frames per sample as floats, number of samples; then the
// positions as three floats each, sample by sample.

#include "report/output_file.h"
#include "writer.h"

#include <cstdint>
#include <cstring>
#include <map>

namespace exporting {

static void append_word(std::string& bytes, uint32_t word) {
    for (int shift = 0; shift < 32; shift += 8) {
        bytes += static_cast<char>(word >> shift & 0xff);
    }
}

static void append_float(std::string& bytes, float value) {
    uint32_t word;
    std::memcpy(&word, &value, sizeof word);
    append_word(bytes, word);
}

namespace {

// The files are written at the end, when the number of samples is known.
class Pc2Writer : public Writer {
public:
    Pc2Writer(const std::filesystem::path& folder, int every) : folder_(folder), every_(every) {}

    void add(const ExportMesh& mesh, int frame, double) override {
        Cache& cache = caches_[mesh.name];
        if (cache.samples == 0) {
            cache.first = mesh;
            cache.first_frame = frame;
        }
        if (mesh.points.size() != cache.first.points.size()) {
            throw demos::Error("pc2 keeps the number of nodes, but " + mesh.name + " has " +
                               std::to_string(mesh.points.size()) + " in frame " + std::to_string(frame) + " and had " +
                               std::to_string(cache.first.points.size()) + "; obj and vtk can follow a cut");
        }
        if (mesh.triangles != cache.first.triangles || mesh.lines != cache.first.lines) {
            throw demos::Error("pc2 keeps the faces and lines, but those of " + mesh.name + " have changed in frame " +
                               std::to_string(frame) + "; obj and vtk can follow a cut");
        }
        for (const pli_vec3 point : mesh.points) {
            for (const float value : {point.x, point.y, point.z}) {
                append_float(cache.positions, value);
            }
        }
        ++cache.samples;
    }

    void finish() override {
        for (const auto& [name, cache] : caches_) {
            std::string header("POINTCACHE2", 12);
            append_word(header, 1);
            append_word(header, static_cast<uint32_t>(cache.first.points.size()));
            append_float(header, static_cast<float>(cache.first_frame));
            append_float(header, static_cast<float>(every_));
            append_word(header, static_cast<uint32_t>(cache.samples));
            report::OutputFile((folder_ / (name + ".pc2")).string()).write(header + cache.positions);
            report::OutputFile((folder_ / (name + ".obj")).string()).write(obj_text(cache.first));
        }
    }

private:
    struct Cache {
        ExportMesh first;
        int first_frame = 0, samples = 0;
        std::string positions;
    };

    std::filesystem::path folder_;
    int every_;
    std::map<std::string, Cache> caches_;
};

} // namespace

std::unique_ptr<Writer> make_pc2_writer(const std::filesystem::path& folder, int every) {
    return std::make_unique<Pc2Writer>(folder, every);
}

} // namespace exporting
