// Scenes that go back to a moment go the same way again; `pliant compare --snapshots` has all of them.

#include "measure/rollback.h"
#include "scene_records.h"

#include "check.h"

using demos::EngineOptions;
using demos::SolverKind;

namespace {

void expect_same_way(const char* name, SolverKind solver, int threads) {
    EngineOptions options;
    options.solver.kind = solver;
    options.threads = threads;
    const demos::Rollback rollback = compare_rollback(*describe(name), options, 60, 90);
    if (!rollback.is_equal()) {
        fail_msg("%s, %s, %d threads: frame %d", name, demos::solver_name(solver), threads,
                 rollback.first_unequal_frame);
    }
}

} // namespace

static void scenes_go_the_same_way_again(void**) {
    for (const char* name : {"Cloth", "Pressure", "Collide2", "Impact", "RopeAttach", "Cutting1", "Friction"}) {
        for (const SolverKind solver : {SolverKind::position_based, SolverKind::xpbd, SolverKind::implicit}) {
            expect_same_way(name, solver, 1);
        }
    }
    for (const char* name : {"ClusterCollide1", "ClusterCar", "ClusterStackMixed", "TorusMatch"}) {
        expect_same_way(name, SolverKind::position_based, 3);
    }
}

int main() {
    const CMUnitTest tests[] = {cmocka_unit_test(scenes_go_the_same_way_again)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
