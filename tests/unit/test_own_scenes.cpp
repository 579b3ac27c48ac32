// The scenes of our own: finite on both engines and with each solver, moving as the script says, apart from themselves.

#include "measure/compare.h"
#include "scene_records.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "check.h"
#include "measure/measure.h"

using demos::EngineKind;
using demos::EngineOptions;
using demos::SceneOptions;
using demos::SolverKind;

namespace {

const char* const names[] = {"Flag", "FoldingCloth", "Ribbon", "TwistedCloth", "RingPull", "Sleeve"};

SceneOptions coarse(int columns = 16) {
    SceneOptions options;
    options.resolution = {columns, 0};
    return options;
}

void step(demos::Engine& engine, int steps) {
    for (int i = 0; i < steps; ++i) {
        engine.step();
    }
}

pli_vec3 axis_of(const demos::Engine& engine, int rigid, int column) {
    const pli_mat3 rotation = engine.rigid(rigid).pose.rotation;
    const auto at = [&](pli_vec3 row) { return column == 0 ? row.x : column == 1 ? row.y : row.z; };
    return pli_vec3_make(at(rotation.rows[0]), at(rotation.rows[1]), at(rotation.rows[2]));
}

// Smallest distance of nodes that are no near neighbours in the grid of the cloth, which has `columns` columns.
double nearest_layers(const demos::SoftState& state, int columns) {
    double nearest = 1e9;
    const int count = static_cast<int>(state.positions.size());
    for (int a = 0; a < count; ++a) {
        for (int b = a + 1; b < count; ++b) {
            if (std::abs(a % columns - b % columns) <= 2 && std::abs(a / columns - b / columns) <= 2) { continue; }
            const pli_vec3 d =
                pli_vec3_sub(state.positions[static_cast<size_t>(a)], state.positions[static_cast<size_t>(b)]);
            nearest = std::min(nearest, static_cast<double>(pli_vec3_length(d)));
        }
    }
    return nearest;
}

} // namespace

static void own_scenes_come_last(void**) {
    assert_int_equal(scene_count - scene_demo_count, sizeof names / sizeof names[0]);
    for (int i = scene_demo_count; i < scene_count; ++i) {
        assert_string_equal(scene_list[i]->name, names[i - scene_demo_count]);
        assert_true(scene_list[i]->is_own && scene_list[i]->takes_resolution);
    }
}

static void own_scenes_stay_finite(void**) {
    for (const char* name : names) {
        for (const bool has_self_collision : {true, false}) {
            SceneOptions scene_options = coarse(std::strcmp(name, "Ribbon") == 0 ? 8 : 16); // 5,120 nodes
            if (!has_self_collision) { scene_options.self_collision = SCENE_SELF_NONE; }
            const auto description = describe(name, scene_options);
            const auto bullet = make_engine(EngineKind::bullet, *description, {});
            step(*bullet, 90);
            if (!measure(*bullet).finite) { fail_msg("%s on btSoftBody", name); }
            for (const SolverKind solver : {SolverKind::position_based, SolverKind::implicit, SolverKind::xpbd}) {
                EngineOptions options;
                options.solver.kind = solver;
                const auto engine = make_engine(EngineKind::pliant, *description, options);
                step(*engine, 90);
                if (!measure(*engine).finite) { fail_msg("%s with %s", name, solver_name(solver)); }
            }
        }
    }
}

static void every_kind_of_self_collision_runs(void**) {
    uint64_t hashes[4];
    for (const scene_self_collision kind : {SCENE_SELF_NONE, SCENE_SELF_NODES, SCENE_SELF_GRIDS, SCENE_SELF_FACES}) {
        SceneOptions options = coarse();
        options.self_collision = kind;
        const auto description = describe("FoldingCloth", options);
        const auto engine = make_engine(EngineKind::pliant, *description, {});
        assert_int_equal(static_cast<int>(engine->self_collision()), static_cast<int>(kind));
        step(*engine, 75);
        hashes[kind] = measure(*engine).state_hash;
    }
    for (int a = 0; a < 4; ++a) {
        for (int b = a + 1; b < 4; ++b) {
            assert_true(hashes[a] != hashes[b]);
        }
    }
}

// The sheet is in folds at 1.5 s; the nodes of different layers keep their distance, and do not without.
static void layers_stay_apart(void**) {
    const float spacing = 4.0f / 23.0f, thickness = 0.9f * spacing;
    double nearest[2];
    for (const bool has_self_collision : {false, true}) {
        SceneOptions options;
        options.resolution = {24, 24};
        if (!has_self_collision) { options.self_collision = SCENE_SELF_NONE; }
        const auto description = describe("FoldingCloth", options);
        const auto engine = make_engine(EngineKind::pliant, *description, {});
        step(*engine, 60);
        double least = 1e9;
        for (int i = 0; i < 30; ++i) {
            engine->step();
            least = std::min(least, nearest_layers(engine->soft(0), 24));
        }
        nearest[has_self_collision ? 1 : 0] = least;
    }
    print_message("nearest layers %g m, %g without self-collision, thickness %g\n", nearest[1], nearest[0],
                  static_cast<double>(thickness));
    assert_true(nearest[1] > 0.5 * static_cast<double>(thickness));
    assert_true(nearest[0] < 0.5 * static_cast<double>(thickness));
}

// Two turns against each other; with faces nothing crosses on the way, without them it does.
static void bars_twist_the_sheet(void**) {
    for (const bool has_self_collision : {true, false}) {
        SceneOptions options;
        options.resolution = {24, 14};
        if (!has_self_collision) { options.self_collision = SCENE_SELF_NONE; }
        const auto description = describe("TwistedCloth", options);
        const auto engine = make_engine(EngineKind::pliant, *description, {});
        step(*engine, 150);
        // A quarter of a turn after a quarter of the time: bars along z have turned to -y and y.
        const pli_vec3 left = axis_of(*engine, 1, 2), right = axis_of(*engine, 2, 2);
        check_near(left.y, 1, 1e-3);
        check_near(right.y, -1, 1e-3);
        step(*engine, 250);
        const int crossings = engine->crossings().value();
        print_message("%d crossing pairs %s self-collision\n", crossings, has_self_collision ? "with" : "without");
        if (has_self_collision) {
            assert_int_equal(crossings, 0);
        } else {
            assert_true(crossings > 20);
            step(*engine, 120);
            check_near(axis_of(*engine, 1, 2).z, 1, 1e-3);
        }
    }
}

static void the_sheet_goes_through_the_ring(void**) {
    SceneOptions options; // coarse layers that keep apart do not fit into the ring
    options.resolution = {32, 0};
    options.self_collision = SCENE_SELF_NONE;
    const auto description = describe("RingPull", options);
    const auto engine = make_engine(EngineKind::pliant, *description, {});
    const auto height = [&] {
        const demos::SoftState state = engine->soft(0);
        float sum = 0;
        for (const pli_vec3 p : state.positions) {
            sum += p.y;
        }
        return sum / static_cast<float>(state.positions.size());
    };
    step(*engine, 30);
    assert_true(height() > 2.9f); // it hangs over the ring, which is 4 m up
    step(*engine, 240);
    print_message("the sheet is %g m up\n", static_cast<double>(height()));
    assert_true(height() < 2.5f);
    check_near(engine->rigid(2).pose.origin.y, 4.17 - 0.9 * 4, 1e-3);
}

static void the_flag_follows_the_wind(void**) {
    const auto description = describe("Flag", coarse());
    const auto engine = make_engine(EngineKind::pliant, *description, {});
    const auto mean_x = [&] {
        const demos::SoftState state = engine->soft(0);
        float sum = 0;
        for (const pli_vec3 p : state.positions) {
            sum += p.x;
        }
        return sum / static_cast<float>(state.positions.size());
    };
    step(*engine, 180);
    assert_true(mean_x() > 0.8f);
    step(*engine, 420);
    assert_true(mean_x() < -0.5f);
}

static void changes_that_a_scene_does_not_take_are_refused(void**) {
    SceneOptions resolution, self_collision;
    resolution.resolution = {10, 10};
    self_collision.self_collision = SCENE_SELF_NODES;
    assert_string_equal(error_of([&] { describe("Bunny", resolution); }).c_str(),
                        "scene Bunny has no grid whose resolution could be chosen");
    assert_string_equal(error_of([&] { describe("Bunny", self_collision); }).c_str(),
                        "scene Bunny has no self-collision that could be chosen");
    resolution.resolution = {30, 200};
    const auto description = describe("Ribbon", resolution);
    assert_int_equal(measure(*make_engine(EngineKind::bullet, *description, {})).nodes, 6000);
    const auto sheet = describe("FoldingCloth", coarse());
    assert_int_equal(measure(*make_engine(EngineKind::bullet, *sheet, {})).nodes, 256);
}

static void move_wrongly(scene_builder* builder) {
    scene_rigid_def def = scene_rigid_def_default();
    def.name = "ball";
    scene_move_rigid(builder, scene_add_rigid(builder, &def), 0, 10, pli_vec3_make(1, 0, 0), pli_vec3_make(0, 0, 0));
}

static void wrong_motions_are_named(void**) {
    const scene made = test_scene(move_wrongly);
    assert_string_equal(error_of([&] { demos::Description::build(made, {}); }).c_str(),
                        "scene Test: ball: only kinematic bodies are moved");
}

// With Bullet's solver and without self-collision, which btSoftBody lacks, steps equal its own. Turned bodies differ by
// rounding.
static void own_scenes_are_compared(void**) {
    EngineOptions options;
    options.solver.kind = SolverKind::position_based;
    const auto description = describe("FoldingCloth", coarse());
    const demos::Comparison result = compare(*description, 60, {}, demos::Witness::bullet, options);
    assert_true(result.one_step.has_value());
    assert_true(result.one_step->median < 1e-9);
    const demos::Comparison own = compare(*description, 30, {});
    assert_int_equal(static_cast<int>(own.solver.kind), static_cast<int>(SolverKind::xpbd));
    assert_true(own.free_run.error_30 > 0.0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(own_scenes_come_last),
        cmocka_unit_test(own_scenes_stay_finite),
        cmocka_unit_test(every_kind_of_self_collision_runs),
        cmocka_unit_test(layers_stay_apart),
        cmocka_unit_test(bars_twist_the_sheet),
        cmocka_unit_test(the_sheet_goes_through_the_ring),
        cmocka_unit_test(the_flag_follows_the_wind),
        cmocka_unit_test(changes_that_a_scene_does_not_take_are_refused),
        cmocka_unit_test(wrong_motions_are_named),
        cmocka_unit_test(own_scenes_are_compared),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
