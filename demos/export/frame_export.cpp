#include "frame_export.h"

#include "report/output_file.h"

namespace exporting {

static std::unique_ptr<Writer> make_writer(const ExportOptions& options) {
    if (options.format == "obj") { return make_obj_writer(options.folder); }
    if (options.format == "pc2") { return make_pc2_writer(options.folder, options.every); }
    if (options.format == "vtk") { return make_vtk_writer(options.folder); }
    throw demos::Error("there is no format " + options.format + " to export; there are obj, pc2 and vtk");
}

FrameExport::FrameExport(const ExportOptions& options) : options_(options) {
    if (options.folder.empty()) { return; }
    writer_ = make_writer(options);
    report::make_folder(options.folder);
    // Whether files can be made there is known before the run.
    const report::OutputFile probe((std::filesystem::path(options.folder) / "frame").string());
}

FrameExport::~FrameExport() = default;

void FrameExport::add(const demos::Engine& engine, int frame, double seconds) {
    if (writer_ == nullptr || frame < options_.first || (frame - options_.first) % options_.every != 0) { return; }
    for (int i = 0; i < engine.soft_count(); ++i) {
        writer_->add(take_soft(engine, i), frame, seconds);
    }
    for (int i = static_cast<int>(rigids_.size()); i < engine.rigid_count(); ++i) {
        rigids_.emplace_back(engine, i);
    }
    for (const RigidMesh& rigid : rigids_) {
        writer_->add(rigid.take(engine), frame, seconds);
    }
    ++frames_;
}

void FrameExport::finish() {
    if (writer_ != nullptr) { writer_->finish(); }
}

} // namespace exporting
