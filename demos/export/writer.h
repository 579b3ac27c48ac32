#ifndef DEMOS_EXPORT_WRITER_H
#define DEMOS_EXPORT_WRITER_H

// What each format does with the frames of a run. Failures are thrown as demos::Error.

#include "export_mesh.h"

#include <filesystem>
#include <memory>

namespace exporting {

class Writer {
public:
    virtual ~Writer() = default;
    virtual void add(const ExportMesh& mesh, int frame, double seconds) = 0;
    // After the last frame.
    virtual void finish() {}
};

// One OBJ file per body and frame.
std::unique_ptr<Writer> make_obj_writer(const std::filesystem::path& folder);
// A point cache per body, with the mesh of its first frame as OBJ; nodes, triangles and lines must stay what they are.
std::unique_ptr<Writer> make_pc2_writer(const std::filesystem::path& folder, int every);
// A VTU file per body and frame, and a PVD collection of them per body.
std::unique_ptr<Writer> make_vtk_writer(const std::filesystem::path& folder);

std::string obj_text(const ExportMesh& mesh);
// "name_000012.obj"
std::string frame_file_name(const std::string& name, int frame, const char* ending);

} // namespace exporting
#endif
