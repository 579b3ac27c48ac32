// What the options of a step and of a scene mean to the engines.

#include "commands.h"

namespace app {

demos::EngineOptions engine_options(const StepOptions& options) {
    demos::EngineOptions result;
    if (options.solver.has_value()) {
        result.solver.kind = *options.solver == "implicit" ? demos::SolverKind::implicit
                             : *options.solver == "xpbd"   ? demos::SolverKind::xpbd
                                                           : demos::SolverKind::position_based;
    }
    result.solver.substeps = options.substeps;
    result.solver.iterations = options.iterations;
    if (options.seconds.has_value()) { result.step_seconds = static_cast<float>(*options.seconds); }
    result.threads = options.threads;
    if (options.simd == "portable") { result.simd = PLI_SIMD_PORTABLE; }
    return result;
}

demos::SceneOptions scene_options(const SceneChanges& changes) {
    demos::SceneOptions result;
    if (changes.self_collision == "off") { result.self_collision = SCENE_SELF_NONE; }
    if (changes.self_collision == "nodes") { result.self_collision = SCENE_SELF_NODES; }
    if (changes.self_collision == "grids") { result.self_collision = SCENE_SELF_GRIDS; }
    if (changes.self_collision == "faces") { result.self_collision = SCENE_SELF_FACES; }
    if (!changes.resolution.empty()) {
        const size_t cross = changes.resolution.find('x');
        result.resolution.columns = std::stoi(changes.resolution);
        if (cross != std::string::npos) { result.resolution.rows = std::stoi(changes.resolution.substr(cross + 1)); }
    }
    return result;
}

} // namespace app
