// What the options of a step mean to the engines.

#include "commands.h"

namespace app {

demos::EngineOptions engine_options(const StepOptions& options) {
    demos::EngineOptions result;
    if (options.solver.has_value()) {
        result.solver.kind = *options.solver == "implicit" ? demos::SolverKind::implicit
                             : *options.solver == "xpbd"   ? demos::SolverKind::xpbd
                                                           : demos::SolverKind::bullet;
    }
    result.solver.substeps = options.substeps;
    result.solver.iterations = options.iterations;
    if (options.seconds.has_value()) { result.step_seconds = static_cast<float>(*options.seconds); }
    return result;
}

} // namespace app
