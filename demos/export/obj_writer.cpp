// Wavefront OBJ: text; indices begin with 1.

#include "report/output_file.h"
#include "text_buffer.h"
#include "writer.h"

#include <cstdio>

namespace exporting {

static void append_index(std::string& text, int index, bool has_normal) {
    text += ' ';
    append(text, index + 1);
    if (has_normal) {
        text += "//";
        append(text, index + 1);
    }
}

std::string obj_text(const ExportMesh& mesh) {
    std::string text = "o " + mesh.name + "\n";
    for (const pli_vec3 point : mesh.points) {
        text += "v ";
        append(text, point);
        text += '\n';
    }
    if (!mesh.triangles.empty()) {
        for (const pli_vec3 normal : mesh.normals) {
            text += "vn ";
            append(text, normal);
            text += '\n';
        }
    }
    for (size_t i = 0; i + 2 < mesh.triangles.size(); i += 3) {
        text += 'f';
        for (size_t k = 0; k < 3; ++k) {
            append_index(text, mesh.triangles[i + k], true);
        }
        text += '\n';
    }
    for (size_t i = 0; i + 1 < mesh.lines.size(); i += 2) {
        text += 'l';
        append_index(text, mesh.lines[i], false);
        append_index(text, mesh.lines[i + 1], false);
        text += '\n';
    }
    return text;
}

std::string frame_file_name(const std::string& name, int frame, const char* ending) {
    char number[16];
    std::snprintf(number, sizeof number, "_%06d", frame);
    return name + number + ending;
}

namespace {

class ObjWriter : public Writer {
public:
    explicit ObjWriter(const std::filesystem::path& folder) : folder_(folder) {}

    void add(const ExportMesh& mesh, int frame, double) override {
        report::OutputFile((folder_ / frame_file_name(mesh.name, frame, ".obj")).string()).write(obj_text(mesh));
    }

private:
    std::filesystem::path folder_;
};

} // namespace

std::unique_ptr<Writer> make_obj_writer(const std::filesystem::path& folder) {
    return std::make_unique<ObjWriter>(folder);
}

} // namespace exporting
