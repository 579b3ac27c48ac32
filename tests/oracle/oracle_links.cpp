// Links on positions and on velocities against btSoftBody: one step from the same state, bit for bit.

#include "bullet_twin.hpp"
#include "check.h"

#include <pliant/pliant.h>

namespace {

constexpr float time_step = 1.0f / 60.0f;

struct Pair {
    pli_context* context = nullptr;
    pli_world* world = nullptr;
    pli_body* body = nullptr;
    btSoftBodyWorldInfo info = twin::world_info();
    std::unique_ptr<btSoftBody> soft;

    Pair(const pli_solver_settings& settings, bool velocity_links, bool ropes_only) {
        assert_int_equal(pli_context_create(nullptr, &context), PLI_OK);
        assert_int_equal(pli_world_create(context, nullptr, &world), PLI_OK);
        pli_mesh* mesh = nullptr;
        if (ropes_only) {
            assert_int_equal(pli_mesh_create_rope(context, {0, 0, 0}, {4, 1, 0}, 14, PLI_ROPE_PIN_FIRST, &mesh),
                             PLI_OK);
        } else {
            pli_patch_def patch = pli_patch_def_default();
            patch.corner_00 = {-2, 0, -2};
            patch.corner_10 = {2, 0, -2};
            patch.corner_01 = {-2, 0, 2};
            patch.corner_11 = {2, 0, 2};
            patch.columns = 13;
            patch.rows = 11;
            patch.pins = PLI_PATCH_PIN_00 | PLI_PATCH_PIN_11;
            patch.diagonals = true;
            assert_int_equal(pli_mesh_create_patch(context, &patch, &mesh), PLI_OK);
            int soft_material = 0;
            const pli_material material{0.3f};
            assert_int_equal(pli_mesh_append_material(mesh, &material, &soft_material), PLI_OK);
            assert_int_equal(pli_mesh_append_bending_links(mesh, 2, soft_material, nullptr), PLI_OK);
            assert_int_equal(pli_mesh_shuffle_links(mesh), PLI_OK);
            assert_int_equal(pli_mesh_set_total_mass(mesh, 3.0f), PLI_OK);
        }
        pli_body_def def = pli_body_def_default();
        def.solver = settings;
        assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
        if (velocity_links) { assert_int_equal(pli_body_enable_velocity_links(body), PLI_OK); }

        soft = twin::make_soft_body(info, mesh);
        soft->m_cfg.viterations = settings.velocity_iterations;
        soft->m_cfg.piterations = settings.position_iterations;
        soft->m_cfg.diterations = settings.drift_iterations;
        soft->m_cfg.kVCF = settings.drift_correction;
        soft->m_cfg.kDP = settings.velocity_damping;
        soft->m_cfg.timescale = settings.time_scale;
        soft->setSolver(velocity_links ? btSoftBody::eSolverPresets::Velocities
                                       : btSoftBody::eSolverPresets::Positions);
        pli_mesh_destroy(mesh);

        // A start that stretches, shears and twists.
        twin::random_source random(77);
        for (int i = 0; i < soft->m_nodes.size(); ++i) {
            soft->m_nodes[i].m_v = twin::to_bullet(random.vector(3.0f));
        }
    }
    ~Pair() {
        soft.reset();
        pli_world_destroy(world);
        assert_int_equal(pli_context_allocated_bytes(context), 0);
        pli_context_destroy(context);
    }

    void check_exact_steps(int steps) {
        for (int i = 0; i < steps; ++i) {
            assert_int_equal(twin::copy_state(*soft, body), PLI_OK);
            twin::step(*soft, time_step);
            assert_int_equal(pli_world_step(world, time_step), PLI_OK);
            const twin::difference difference = twin::compare(*soft, body);
            if (!difference.is_exact()) {
                fail_msg("step %d, node %d: position differs by %g, velocity by %g", i, difference.node,
                         difference.position, difference.velocity);
            }
        }
    }

    void check_exact_trajectory(int steps) {
        assert_int_equal(twin::copy_state(*soft, body), PLI_OK);
        for (int i = 0; i < steps; ++i) {
            twin::step(*soft, time_step);
            assert_int_equal(pli_world_step(world, time_step), PLI_OK);
        }
        assert_true(twin::compare(*soft, body).is_exact());
    }
};

pli_solver_settings settings_of(int velocity, int position, int drift, float correction, float damping) {
    pli_solver_settings settings = pli_body_def_default().solver;
    settings.velocity_iterations = velocity;
    settings.position_iterations = position;
    settings.drift_iterations = drift;
    settings.drift_correction = correction;
    settings.velocity_damping = damping;
    return settings;
}

void oracle_position_links_equal_bullet(void**) {
    Pair(settings_of(0, 1, 0, 1.0f, 0.0f), false, false).check_exact_steps(200);
    Pair(settings_of(0, 4, 0, 1.0f, 0.02f), false, false).check_exact_steps(200);
    Pair(settings_of(0, 7, 0, 1.0f, 0.0f), false, true).check_exact_steps(200);
}

void oracle_velocity_links_equal_bullet(void**) {
    Pair(settings_of(5, 0, 3, 0.7f, 0.0f), true, false).check_exact_steps(100);
    Pair(settings_of(8, 1, 2, 1.0f, 0.01f), true, true).check_exact_steps(100);
}

void oracle_iterations_without_their_links_equal_bullet(void**) {
    Pair(settings_of(2, 2, 2, 0.5f, 0.0f), false, false).check_exact_steps(50);
    Pair(settings_of(0, 0, 0, 1.0f, 0.0f), false, false).check_exact_steps(50);
}

void oracle_time_scale_equals_bullet(void**) {
    pli_solver_settings settings = settings_of(0, 3, 0, 1.0f, 0.0f);
    settings.time_scale = 0.37f;
    Pair(settings, false, false).check_exact_steps(50);
}

void oracle_whole_trajectory_equals_bullet(void**) {
    Pair(settings_of(0, 3, 0, 1.0f, 0.01f), false, false).check_exact_trajectory(600);
    Pair(settings_of(0, 10, 0, 1.0f, 0.0f), false, true).check_exact_trajectory(600);
}

} // namespace

int main() {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(oracle_position_links_equal_bullet),
        cmocka_unit_test(oracle_velocity_links_equal_bullet),
        cmocka_unit_test(oracle_iterations_without_their_links_equal_bullet),
        cmocka_unit_test(oracle_time_scale_equals_bullet),
        cmocka_unit_test(oracle_whole_trajectory_equals_bullet),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
