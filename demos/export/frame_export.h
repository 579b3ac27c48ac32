#ifndef DEMOS_EXPORT_FRAME_EXPORT_H
#define DEMOS_EXPORT_FRAME_EXPORT_H

// The frames of a run as files of one format, in one folder.

#include "rigid_mesh.h"
#include "writer.h"

#include <memory>
#include <string>
#include <vector>

namespace exporting {

struct ExportOptions {
    std::string folder;         // empty: no export
    std::string format = "obj"; // or "pc2" or "vtk"
    int every = 1;              // frame
    int first = 0;              // frame; 0 is the start of the scene
};

class FrameExport {
public:
    // Makes the folder. Throws demos::Error, as all of this does, when files cannot be written there.
    explicit FrameExport(const ExportOptions& options);
    ~FrameExport();
    // Every frame is shown here, those that are not wanted too.
    void add(const demos::Engine& engine, int frame, double seconds);
    void finish();
    int frames() const { return frames_; } // that were written

private:
    ExportOptions options_;
    std::unique_ptr<Writer> writer_; // null: no export
    std::vector<RigidMesh> rigids_;
    int frames_ = 0;
};

} // namespace exporting
#endif
