// Controls of scenes: what a user turns while a scene runs, on both engines.

#include "scene_records.h"

#include "check.h"

using demos::EngineKind;

namespace {

constexpr EngineKind both[] = {EngineKind::pliant, EngineKind::bullet};

pli_vec3 center(const demos::Engine& engine) {
    const demos::SoftState soft = engine.soft(0);
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    for (const pli_vec3 position : soft.positions) {
        sum = pli_vec3_add(sum, position);
    }
    return pli_vec3_scale(sum, 1.0f / static_cast<float>(soft.positions.size()));
}

void step(demos::Engine& engine, int count) {
    for (int i = 0; i < count; ++i) {
        engine.step();
    }
}

} // namespace

// The flags hang at z = 0 and blow towards -z.
static void wind_is_turned(void**) {
    const auto description = describe("Aero2");
    assert_int_equal(description->controls.size(), 1);
    for (const EngineKind kind : both) {
        const auto engine = demos::make_engine(kind, *description, {});
        step(*engine, 60);
        const float before = center(*engine).z;
        assert_true(before < -1.0f);
        assert_float_equal(engine->control(0), 0.0f, 0);
        engine->set_control(0, 400);
        assert_float_equal(engine->control(0), 180.0f, 0);
        step(*engine, 120);
        assert_true(center(*engine).z > 1.0f);
    }
}

static pli_mesh* two_faces(scene_builder* builder) {
    pli_patch_def patch = pli_patch_def_default();
    patch.columns = patch.rows = 2;
    patch.corner_10 = pli_vec3_make(1, 0, 0);
    patch.corner_01 = pli_vec3_make(0, 0, 1);
    patch.corner_11 = pli_vec3_make(1, 0, 1);
    pli_mesh* mesh = nullptr;
    scene_check(builder, pli_mesh_create_patch(scene_context(builder), &patch, &mesh));
    return mesh;
}

static void a_script_sets_controls(void**) {
    const auto build = [](scene_builder* builder) {
        scene_soft_def def = scene_soft_def_default();
        def.name = "soft";
        def.aero.drag = 1;
        scene_add_soft(builder, two_faces(builder), &def);
        const scene_control control = {"wind", -1, 1, 0, SCENE_KEYS_NONE, false, [](scene_run* run, float value) {
                                           scene_run_set_wind(run, 0, pli_vec3_make(value, 0, 0));
                                       }};
        scene_set_control_at(builder, 3, scene_add_control(builder, &control), -0.5f);
    };
    const scene made = test_scene(build);
    const auto description = demos::Description::build(made, {});
    for (const EngineKind kind : both) {
        const auto engine = demos::make_engine(kind, *description, {});
        step(*engine, 3);
        assert_float_equal(engine->control(0), 0.0f, 0);
        step(*engine, 1);
        assert_float_equal(engine->control(0), -0.5f, 0);
    }
}

static void wrong_controls_are_named(void**) {
    const auto description = describe("Aero2");
    const auto engine = demos::make_engine(EngineKind::pliant, *description, {});
    for (const int index : {-1, 1}) {
        assert_string_equal(error_of([&] { engine->set_control(index, 0); }).c_str(),
                            ("there is no control " + std::to_string(index)).c_str());
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wind_is_turned),
        cmocka_unit_test(a_script_sets_controls),
        cmocka_unit_test(wrong_controls_are_named),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
