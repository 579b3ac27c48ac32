// VTK's XML files: an unstructured grid (.vtu, as text) per body and frame, a collection (.pvd) with the times per
// body.

#include "report/output_file.h"
#include "text_buffer.h"
#include "writer.h"

#include <map>

namespace exporting {

static constexpr int line_type = 3, triangle_type = 5, tetra_type = 10; // numbers that VTK gives to kinds of cells

// Cells of one kind.
struct Cells {
    const std::vector<int>& nodes;
    const std::vector<float>& stretch;
    int corners, type;
    size_t count() const { return nodes.size() / static_cast<size_t>(corners); }
};

static void open_array(std::string& text, const char* type, const char* name, int components = 1) {
    text += std::string("<DataArray type=\"") + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
            std::to_string(components) + "\" format=\"ascii\">\n";
}

static void close_array(std::string& text) {
    text += "</DataArray>\n";
}

static void append_vectors(std::string& text, const char* name, const std::vector<pli_vec3>& values) {
    open_array(text, "Float32", name, 3);
    for (const pli_vec3 value : values) {
        append(text, value);
        text += '\n';
    }
    close_array(text);
}

static void append_cells(std::string& text, const std::vector<Cells>& kinds) {
    text += "<Cells>\n";
    open_array(text, "Int32", "connectivity");
    for (const Cells& cells : kinds) {
        for (size_t i = 0; i < cells.nodes.size(); ++i) {
            append(text, cells.nodes[i]);
            text += (i + 1) % static_cast<size_t>(cells.corners) == 0 ? '\n' : ' ';
        }
    }
    close_array(text);
    open_array(text, "Int32", "offsets");
    int offset = 0;
    for (const Cells& cells : kinds) {
        for (size_t i = 0; i < cells.count(); ++i) {
            append(text, offset += cells.corners);
            text += '\n';
        }
    }
    close_array(text);
    open_array(text, "UInt8", "types");
    for (const Cells& cells : kinds) {
        for (size_t i = 0; i < cells.count(); ++i) {
            append(text, cells.type);
            text += '\n';
        }
    }
    close_array(text);
    text += "</Cells>\n";
}

static std::string vtu_text(const ExportMesh& mesh) {
    std::vector<Cells> kinds;
    kinds.push_back({mesh.tetras, mesh.tetra_stretch, 4, tetra_type});
    if (!mesh.triangles_are_surface) { kinds.push_back({mesh.triangles, mesh.triangle_stretch, 3, triangle_type}); }
    kinds.push_back({mesh.lines, mesh.line_stretch, 2, line_type});
    size_t count = 0;
    for (const Cells& cells : kinds) {
        count += cells.count();
    }
    std::string text = "<?xml version=\"1.0\"?>\n"
                       "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
                       "<UnstructuredGrid>\n<Piece NumberOfPoints=\"" +
                       std::to_string(mesh.points.size()) + "\" NumberOfCells=\"" + std::to_string(count) + "\">\n";
    text += "<PointData Vectors=\"velocity\">\n";
    append_vectors(text, "velocity", mesh.velocities);
    text += "</PointData>\n<CellData Scalars=\"stretch\">\n";
    open_array(text, "Float32", "stretch");
    for (const Cells& cells : kinds) {
        for (const float stretch : cells.stretch) {
            append(text, stretch);
            text += '\n';
        }
    }
    close_array(text);
    text += "</CellData>\n<Points>\n";
    append_vectors(text, "position", mesh.points);
    text += "</Points>\n";
    append_cells(text, kinds);
    return text + "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

namespace {

class VtkWriter : public Writer {
public:
    explicit VtkWriter(const std::filesystem::path& folder) : folder_(folder) {}

    void add(const ExportMesh& mesh, int frame, double seconds) override {
        const std::string name = frame_file_name(mesh.name, frame, ".vtu");
        report::OutputFile((folder_ / name).string()).write(vtu_text(mesh));
        std::string& entries = entries_[mesh.name];
        entries += "<DataSet timestep=\"";
        append(entries, static_cast<float>(seconds));
        entries += "\" part=\"0\" file=\"" + name + "\"/>\n";
    }

    void finish() override {
        for (const auto& [name, entries] : entries_) {
            report::OutputFile((folder_ / (name + ".pvd")).string())
                .write("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n" +
                       entries + "</Collection>\n</VTKFile>\n");
        }
    }

private:
    std::filesystem::path folder_;
    std::map<std::string, std::string> entries_; // of the collections, by body
};

} // namespace

std::unique_ptr<Writer> make_vtk_writer(const std::filesystem::path& folder) {
    return std::make_unique<VtkWriter>(folder);
}

} // namespace exporting
