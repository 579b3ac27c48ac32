// Aerodynamics, pressure and volume conservation against btSoftBody, bit for bit. Both run freely from one disturbed
// state, so a difference in any step stays visible in the last.

#include "check.h"
#include "sample_mesh.h"

#include "oracle/bullet_twin.hpp"

#include <pliant/forces.h>

#include <cstdio>
#include <functional>

namespace {

constexpr float dt = 1.0f / 60.0f;
constexpr int steps = 120;

struct fixture {
    btSoftBodyWorldInfo info = twin::world_info();
    pli_context* context = nullptr;
    pli_world* world = nullptr;
    pli_body* body = nullptr;
    std::unique_ptr<btSoftBody> soft;

    using make_mesh = std::function<pli_status(pli_context*, pli_mesh**)>;
    explicit fixture(const make_mesh& make, float total_mass) {
        assert_int_equal(pli_context_create(nullptr, &context), PLI_OK);
        pli_world_def def = pli_world_def_default();
        def.reference_mode = true; // forces without limits
        assert_int_equal(pli_world_create(context, &def, &world), PLI_OK);
        pli_mesh* mesh = nullptr;
        assert_int_equal(make(context, &mesh), PLI_OK);
        assert_int_equal(pli_mesh_set_total_mass(mesh, total_mass), PLI_OK);
        soft = twin::make_soft_body(info, mesh);
        assert_int_equal(pli_body_create(world, mesh, nullptr, &body), PLI_OK);
        pli_mesh_destroy(mesh);
        pli_solver_settings settings = pli_body_get_solver_settings(body);
        settings.position_iterations = 2;
        settings.velocity_damping = 0.01f;
        assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
        soft->m_cfg.piterations = 2;
        soft->m_cfg.kDP = 0.01f;
    }
    ~fixture() {
        pli_world_destroy(world);
        pli_context_destroy(context);
    }
    fixture(const fixture&) = delete;
    fixture& operator=(const fixture&) = delete;

    // Random displacements and velocities on top of the rest shape.
    void disturb(float displacement, float velocity, std::uint32_t start) {
        twin::random_source random(start);
        for (int i = 0; i < soft->m_nodes.size(); ++i) {
            btSoftBody::Node& node = soft->m_nodes[i];
            if (node.m_im > 0) {
                node.m_x += twin::to_bullet(random.vector(displacement));
                node.m_v += twin::to_bullet(random.vector(velocity));
            }
        }
        soft->updateNormals();
        assert_int_equal(twin::copy_state(*soft, body), PLI_OK);
    }

    // Where the two are apart after some steps.
    twin::difference run() {
        for (int i = 0; i < steps; ++i) {
            twin::step(*soft, dt);
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
        }
        return twin::compare(*soft, body);
    }

    void check_exact(const char* what) {
        const twin::difference apart = run();
        if (!apart.is_exact()) {
            fail_msg("%s: node %d apart by %g m and %g m/s", what, apart.node, apart.position, apart.velocity);
        }
    }

    // What was just switched off in Pliant alone must have had an effect, or the comparison before showed nothing.
    void check_differs(const char* what) {
        if (run().is_exact()) { fail_msg("%s has no effect here", what); }
    }
};

pli_status make_sheet(pli_context* context, pli_mesh** mesh) {
    return sample_create_sheet(context, 9, 0.0f, PLI_PATCH_PIN_00 | PLI_PATCH_PIN_10, mesh);
}
pli_status make_ball(pli_context* context, pli_mesh** mesh) {
    return sample_create_ellipsoid(context, pli_vec3_make(1.0f, 1.3f, 0.8f), mesh);
}

void enable_aero(fixture& f, int model, float lift, float drag, pli_vec3 wind) {
    pli_aero_def def = pli_aero_def_default();
    def.model = static_cast<pli_aero_model>(model);
    def.lift = lift;
    def.drag = drag;
    def.wind = wind;
    assert_int_equal(pli_body_enable_aero(f.body, &def), PLI_OK);
    f.soft->m_cfg.aeromodel = static_cast<btSoftBody::eAeroModel::_>(model);
    f.soft->m_cfg.kLF = lift;
    f.soft->m_cfg.kDG = drag;
    f.soft->setWindVelocity(twin::to_bullet(wind));
}

void test_all_aero_models_equal_bullet(void**) {
    for (int model = 0; model <= 6; ++model) {
        for (const float mass : {8.0f, 0.05f}) { // the light sheet meets the limits of force and drag
            char what[64];
            std::snprintf(what, sizeof what, "aerodynamics %d with %g kg", model, static_cast<double>(mass));
            fixture f(make_sheet, mass);
            enable_aero(f, model, 0.03f, 0.05f, pli_vec3_make(4, 12, -3));
            f.disturb(0.05f, 2.0f, 17);
            f.check_exact(what);
            assert_int_equal(pli_body_disable_aero(f.body), PLI_OK);
            f.check_differs(what);
        }
    }
}

void test_wind_and_model_can_change(void**) {
    fixture f(make_sheet, 4.0f);
    enable_aero(f, PLI_AERO_VERTEX_TWO_SIDED, 0.03f, 0.05f, pli_vec3_make(0, 5, 0));
    f.disturb(0.05f, 2.0f, 3);
    f.check_exact("vertex model");
    enable_aero(f, PLI_AERO_FACE_TWO_SIDED_LIFT_DRAG, 0.02f, 0.06f, pli_vec3_make(0, 5, 0));
    f.check_exact("face model");
    assert_int_equal(pli_body_set_wind(f.body, pli_vec3_make(9, 0, 1)), PLI_OK);
    f.soft->setWindVelocity(btVector3(9, 0, 1));
    f.check_exact("new wind");
    enable_aero(f, PLI_AERO_VERTEX_TWO_SIDED, 0.03f, 0.05f, pli_vec3_make(0, 5, 0));
    f.check_exact("vertex model again");
}

void test_pressure_equals_bullet(void**) {
    for (const float coefficient : {2500.0f, -40.0f}) {
        fixture f(make_ball, 30.0f);
        assert_int_equal(pli_body_enable_pressure(f.body, coefficient), PLI_OK);
        f.soft->m_cfg.kPR = coefficient;
        f.disturb(0.05f, 1.0f, 5);
        f.check_exact("pressure");
        assert_int_equal(pli_body_disable_pressure(f.body), PLI_OK);
        f.check_differs("pressure");
    }
}

void test_volume_conservation_equals_bullet(void**) {
    fixture f(make_ball, 30.0f);
    assert_int_equal(pli_body_enable_volume_conservation(f.body, 20.0f), PLI_OK);
    f.soft->setPose(true, false);
    f.soft->m_cfg.kVC = 20;
    f.disturb(0.1f, 1.0f, 5);
    f.check_exact("volume conservation");
    // A new coefficient keeps the rest volume.
    assert_int_equal(pli_body_enable_volume_conservation(f.body, 35.0f), PLI_OK);
    f.soft->m_cfg.kVC = 35;
    f.check_exact("volume conservation with a new coefficient");
    assert_int_equal(pli_body_disable_volume_conservation(f.body), PLI_OK);
    f.check_differs("volume conservation");
}

// Forces add up in Bullet's order: vertex aerodynamics, pressure, volume, face aerodynamics, whatever was enabled
// first.
void test_all_forces_together_equal_bullet(void**) {
    for (const int model : {PLI_AERO_VERTEX_TWO_SIDED_LIFT_DRAG, PLI_AERO_FACE_TWO_SIDED}) {
        fixture f(make_ball, 10.0f);
        assert_int_equal(pli_body_enable_volume_conservation(f.body, 20.0f), PLI_OK);
        assert_int_equal(pli_body_enable_pressure(f.body, 300.0f), PLI_OK);
        enable_aero(f, model, 0.1f, 0.2f, pli_vec3_make(4, 12, -3));
        f.soft->setPose(true, false);
        f.soft->m_cfg.kVC = 20;
        f.soft->m_cfg.kPR = 300;
        f.disturb(0.1f, 1.0f, 5);
        f.check_exact("all forces");
    }
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_all_aero_models_equal_bullet),
        cmocka_unit_test(test_wind_and_model_can_change),
        cmocka_unit_test(test_pressure_equals_bullet),
        cmocka_unit_test(test_volume_conservation_equals_bullet),
        cmocka_unit_test(test_all_forces_together_equal_bullet),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
