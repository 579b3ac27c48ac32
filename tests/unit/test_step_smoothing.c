/* Step smoothing: nothing while steps are equal, free flight untouched, energy under steps that change by 16, cuts, bad
   input. */

#include "test_world.h"

static const float long_dt = 1.0f / 15.0f, short_dt = 1.0f / 240.0f;

static pli_body* make_sheet(int pins) {
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_make(-0.5f, 0, -0.5f);
    def.corner_10 = pli_vec3_make(0.5f, 0, -0.5f);
    def.corner_01 = pli_vec3_make(-0.5f, 0, 0.5f);
    def.corner_11 = pli_vec3_make(0.5f, 0, 0.5f);
    def.columns = def.rows = 12;
    def.pins = pins;
    def.diagonals = true;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 1.44f), PLI_OK);
    pli_body_def body_def = pli_body_def_default();
    body_def.solver.position_iterations = 10;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &body_def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

typedef enum solver { POSITION, SWEEPS, XPBD, SOLVER_COUNT } solver;

static void use_solver(pli_body* body, solver which) {
    if (which == SWEEPS) {
        pli_implicit_def def = pli_implicit_def_default();
        def.stiffness = 5000;
        assert_int_equal(pli_body_enable_implicit(body, &def), PLI_OK);
    } else if (which == XPBD) {
        const pli_xpbd_def def = pli_xpbd_def_default();
        assert_int_equal(pli_body_enable_xpbd(body, &def), PLI_OK);
        const pli_xpbd_links_def links = pli_xpbd_links_def_default();
        assert_int_equal(pli_body_enable_xpbd_links(body, &links), PLI_OK);
    }
}

static double energy(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    double sum = 0;
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 v = view.velocities[i];
        if (!(view.positions[i].w > 0)) { continue; }
        sum += 0.5 * (double)((v.x * v.x + v.y * v.y + v.z * v.z) / view.positions[i].w);
        sum += 10 * (double)(view.positions[i].y / view.positions[i].w);
    }
    return sum;
}

static void test_step_smoothing_leaves_equal_steps_alone(void** state) {
    (void)state;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        uint64_t hashes[2];
        for (int k = 0; k < 2; ++k) {
            pli_body* sheet = make_sheet(PLI_PATCH_PIN_00);
            use_solver(sheet, (solver)which);
            if (k == 1) { assert_int_equal(pli_body_enable_step_smoothing(sheet), PLI_OK); }
            for (int i = 0; i < 20; ++i) {
                assert_int_equal(pli_world_step(world, i < 10 ? 0.01f : 0.02f), PLI_OK); /* longer is as equal */
            }
            hashes[k] = pli_body_state_hash(sheet);
            pli_body_destroy(sheet);
        }
        assert_true(hashes[0] == hashes[1]);
    }
}

static void test_step_smoothing_lets_bodies_fall(void** state) {
    (void)state;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* sheet = make_sheet(0);
        use_solver(sheet, (solver)which);
        assert_int_equal(pli_body_enable_step_smoothing(sheet), PLI_OK);
        for (int i = 0; i < 20; ++i) {
            assert_int_equal(pli_world_step(world, i % 2 == 0 ? long_dt : short_dt), PLI_OK);
        }
        check_near(pli_body_get_view(sheet).velocities[40].y, -100 * (long_dt + short_dt), 1e-3f);
        pli_body_destroy(sheet);
    }
}

/* A sheet that swings from one corner. Its energy at the start is 0. */
static double most_energy(solver which, bool smooths, int shorts) {
    pli_body* sheet = make_sheet(PLI_PATCH_PIN_00);
    use_solver(sheet, which);
    if (smooths) { assert_int_equal(pli_body_enable_step_smoothing(sheet), PLI_OK); }
    double most = -1e30;
    for (int i = 0; i < 300; ++i) {
        assert_int_equal(pli_world_step(world, i % (shorts + 1) == 0 ? long_dt : short_dt), PLI_OK);
        most = fmax(most, energy(sheet));
    }
    pli_body_destroy(sheet);
    return most;
}

static void test_step_smoothing_keeps_energy(void** state) {
    (void)state;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        for (int shorts = 1; shorts <= 16; shorts *= 4) {
            check_at_most(most_energy((solver)which, true, shorts), 0.5);
        }
        check_at_most(10.0, most_energy((solver)which, false, 1)); /* what it is for */
    }
}

static void test_step_smoothing_follows_cuts(void** state) {
    (void)state;
    pli_body* sheet = make_sheet(PLI_PATCH_PIN_00);
    assert_int_equal(pli_body_enable_step_smoothing(sheet), PLI_OK);
    const size_t bytes = pli_body_bytes(sheet);
    assert_int_equal(pli_world_step(world, long_dt), PLI_OK);
    assert_int_equal(pli_body_cut_link(sheet, 40, 41, 0.5f), PLI_OK);
    assert_true(pli_body_bytes(sheet) > bytes);
    assert_int_equal(pli_world_step(world, short_dt), PLI_OK);
    assert_int_equal(pli_body_disable_step_smoothing(sheet), PLI_OK);
    assert_int_equal(pli_world_step(world, short_dt), PLI_OK);
}

static void test_step_smoothing_refuses_bad_input(void** state) {
    (void)state;
    pli_body* sheet = make_sheet(0);
    assert_int_equal(pli_body_enable_step_smoothing(NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_world_predict(world, long_dt), PLI_OK);
    assert_int_equal(pli_body_enable_step_smoothing(sheet), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_world_solve(world), PLI_OK);
    assert_int_equal(pli_body_get_features(sheet, 0, NULL), 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_step_smoothing_leaves_equal_steps_alone, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_step_smoothing_lets_bodies_fall, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_step_smoothing_keeps_energy, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_step_smoothing_follows_cuts, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_step_smoothing_refuses_bad_input, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
