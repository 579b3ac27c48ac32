// Scenes with each solver: what runs, what is refused, what the options do.

#include "measure/compare.h"
#include "scene_records.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "check.h"
#include "measure/measure.h"

using demos::EngineKind;
using demos::EngineOptions;
using demos::SolverKind;

namespace {

constexpr SolverKind all_solvers[] = {SolverKind::position_based, SolverKind::implicit, SolverKind::xpbd};

EngineOptions with_solver(SolverKind kind) {
    EngineOptions options;
    options.solver.kind = kind;
    return options;
}

std::unique_ptr<demos::Engine> run(const demos::Description& description, const EngineOptions& options, int steps) {
    auto engine = make_engine(EngineKind::pliant, description, options);
    for (int i = 0; i < steps; ++i) {
        engine->step();
    }
    return engine;
}

pli_bounds bounds_of(const demos::Engine& engine, int soft) {
    const demos::SoftState state = engine.soft(soft);
    pli_bounds bounds = {state.positions[0], state.positions[0]};
    for (const pli_vec3 p : state.positions) {
        bounds.min =
            pli_vec3_make(std::min(bounds.min.x, p.x), std::min(bounds.min.y, p.y), std::min(bounds.min.z, p.z));
        bounds.max =
            pli_vec3_make(std::max(bounds.max.x, p.x), std::max(bounds.max.y, p.y), std::max(bounds.max.z, p.z));
    }
    return bounds;
}

std::string refusal(const char* name, EngineKind kind, const EngineOptions& options) {
    const auto description = describe(name);
    return error_of([&] { make_engine(kind, *description, options); });
}

} // namespace

static void scenes_stay_finite_with_each_solver(void**) {
    for (int i = 0; i < scene_demo_count; ++i) {
        const auto description = describe(scene_list[i]->name);
        for (const SolverKind solver : all_solvers) {
            const auto engine = run(*description, with_solver(solver), 15);
            if (!measure(*engine).finite) { fail_msg("%s with %s", scene_list[i]->name, solver_name(solver)); }
        }
    }
}

// The material is the same: sizes after the fall, that of Bullet's solver in the first place.
static void bodies_keep_their_shape_with_each_solver(void**) {
    const struct {
        const char* name;
        int frames;
        float least, most; // height over that with Bullet's solver
    } cases[] = {{"Bunny", 80, 0.9f, 1.15f},     {"BunnyMatch", 110, 0.9f, 1.15f}, {"ClusterDeform", 90, 0.9f, 1.1f},
                 {"Torus", 110, 0.9f, 1.15f},    {"Volume", 200, 0.75f, 1.4f},     {"Ropes", 60, 0.9f, 1.1f},
                 {"ClothAttach", 45, 0.9f, 1.1f}};
    for (const auto& each : cases) {
        const auto description = describe(each.name);
        float heights[3];
        for (const SolverKind solver : all_solvers) {
            const pli_bounds bounds = bounds_of(*run(*description, with_solver(solver), each.frames), 0);
            heights[static_cast<int>(solver)] = bounds.max.y - bounds.min.y;
        }
        for (const int solver : {1, 2}) {
            const float ratio = heights[solver] / heights[0];
            if (!(ratio >= each.least && ratio <= each.most)) {
                fail_msg("%s: %g, %g and %g m high", each.name, static_cast<double>(heights[0]),
                         static_cast<double>(heights[1]), static_cast<double>(heights[2]));
            }
        }
    }
}

// A rope that hangs by one end, and is twice as stiff with twice the iterations.
static void hang_build(scene_builder* builder) {
    pli_mesh* mesh = nullptr;
    const pli_vec3 top = pli_vec3_make(0, 0, 0), end = pli_vec3_make(0, -1, 0);
    scene_check(builder, pli_mesh_create_rope(scene_context(builder), top, end, 0, PLI_ROPE_PIN_FIRST, &mesh));
    scene_check(builder, pli_mesh_set_node_mass(mesh, 1, 2));
    scene_soft_def def = scene_soft_def_default();
    def.name = "rope";
    def.solver.position_iterations = 4;
    def.solver.velocity_damping = 0.05f;
    scene_add_soft(builder, mesh, &def);
}

static void links_have_the_stated_stiffness(void**) {
    const scene made = test_scene(hang_build);
    const auto description = demos::Description::build(made, {});
    const double h = 1.0 / 60.0, stiffness = 4.0 * 2.0 / (h * h); // 4 iterations, 2 kg
    for (const SolverKind solver : {SolverKind::implicit, SolverKind::xpbd}) {
        const auto engine = run(*description, with_solver(solver), 600);
        const double stretch = -static_cast<double>(engine->soft(0).positions[1].y) - 1.0;
        if (std::fabs(stretch - 2.0 * 10.0 / stiffness) > 2e-6) { fail_msg("%s: %g m", solver_name(solver), stretch); }
    }
}

static void options_reach_the_solver(void**) {
    const auto description = describe("ClothAttach");
    const auto hash = [&](SolverKind kind, std::optional<int> substeps, std::optional<int> iterations) {
        EngineOptions options = with_solver(kind);
        options.solver.substeps = substeps;
        options.solver.iterations = iterations;
        return measure(*run(*description, options, 20)).state_hash;
    };
    assert_true(hash(SolverKind::position_based, {}, {}) == hash(SolverKind::position_based, {}, 1));
    assert_true(hash(SolverKind::position_based, {}, {}) != hash(SolverKind::position_based, {}, 2));
    assert_true(hash(SolverKind::implicit, {}, {}) == hash(SolverKind::implicit, {}, 5));
    assert_true(hash(SolverKind::implicit, {}, {}) != hash(SolverKind::implicit, {}, 7));
    assert_true(hash(SolverKind::xpbd, {}, {}) == hash(SolverKind::xpbd, 10, 1));
    assert_true(hash(SolverKind::xpbd, {}, {}) != hash(SolverKind::xpbd, 11, 1));
    assert_true(hash(SolverKind::xpbd, {}, {}) != hash(SolverKind::xpbd, 10, 2));
}

static void both_engines_take_iterations_and_the_step(void**) {
    const auto description = describe("Bunny");
    EngineOptions options;
    options.step_seconds = 1.0f / 90.0f;
    options.solver.iterations = 5;
    const demos::OneStep one_step =
        compare_one_step(*description, 60, {}, demos::Witness::bullet, options); // it falls and meets the ground
    assert_true(one_step.bit_equal_share == 1.0);
}

// Cuts come at 0.5, 1 and 1.5 s, however long a step is.
static void a_script_keeps_its_times(void**) {
    const auto description = describe("Cutting1");
    for (const EngineKind kind : {EngineKind::pliant, EngineKind::bullet}) {
        for (const int divisor : {1, 2, 3}) {
            EngineOptions options;
            options.step_seconds = demos::frame_seconds / static_cast<float>(divisor);
            const auto engine = make_engine(kind, *description, options);
            int nodes = measure(*engine).nodes, cuts = 0;
            for (int step = 0; step < 100 * divisor; ++step) {
                engine->step();
                const int present = measure(*engine).nodes;
                if (present == nodes) { continue; }
                assert_int_equal(step, ++cuts * 30 * divisor);
                nodes = present;
            }
            assert_int_equal(cuts, 3);
        }
    }
    EngineOptions long_steps;
    long_steps.step_seconds = 0.1f;
    assert_true(measure(*run(*description, long_steps, 16)).nodes > 256 + 3 * 10);
}

// 0.5 s of free fall: the position differs by g h t / 2 from one step to another, the velocity does not.
static void the_step_is_as_long_as_said(void**) {
    const auto description = describe("Bunny");
    for (const SolverKind solver : all_solvers) {
        for (const int steps_per_second : {30, 60, 240}) {
            EngineOptions options = with_solver(solver);
            options.step_seconds = 1.0f / static_cast<float>(steps_per_second);
            const auto engine = run(*description, options, steps_per_second / 2);
            const demos::SoftState state = engine->soft(0);
            double sum = 0.0;
            for (const pli_vec3 v : state.velocities) {
                sum += static_cast<double>(v.y);
            }
            const double speed = sum / static_cast<double>(state.velocities.size());
            if (std::fabs(speed + 5.0) > 3e-3) { fail_msg("%s: %g m/s", solver_name(solver), speed); }
        }
    }
}

static void what_a_solver_lacks_is_named(void**) {
    assert_string_equal(refusal("Bunny", EngineKind::bullet, with_solver(SolverKind::implicit)).c_str(),
                        "btSoftBody has no solver implicit");
    EngineOptions options = with_solver(SolverKind::xpbd);
    options.reference = true;
    assert_non_null(std::strstr(refusal("Bunny", EngineKind::pliant, options).c_str(), "reference mode"));
    options = with_solver(SolverKind::implicit);
    options.solver.iterations = 0;
    assert_non_null(
        std::strstr(refusal("Bunny", EngineKind::pliant, options).c_str(), "sweeps is 0, at least 1 is needed"));
    options.solver = {};
    options.solver.substeps = 2;
    assert_non_null(std::strstr(refusal("Bunny", EngineKind::pliant, options).c_str(), "--substeps are those of"));
}

static void other_solvers_are_compared_by_free_runs(void**) {
    const auto description = describe("ClothAttach");
    const demos::Comparison result =
        compare(*description, 60, {}, demos::Witness::bullet, with_solver(SolverKind::xpbd));
    assert_false(result.one_step.has_value());
    assert_int_equal(static_cast<int>(result.solver.kind), static_cast<int>(SolverKind::xpbd));
    assert_true(result.free_run.error_60 > 0.0 && result.free_run.error_60 < 0.1);
    assert_true(result.free_run.error_300 < 0.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_stay_finite_with_each_solver),
        cmocka_unit_test(bodies_keep_their_shape_with_each_solver),
        cmocka_unit_test(links_have_the_stated_stiffness),
        cmocka_unit_test(options_reach_the_solver),
        cmocka_unit_test(both_engines_take_iterations_and_the_step),
        cmocka_unit_test(a_script_keeps_its_times),
        cmocka_unit_test(the_step_is_as_long_as_said),
        cmocka_unit_test(what_a_solver_lacks_is_named),
        cmocka_unit_test(other_solvers_are_compared_by_free_runs),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
