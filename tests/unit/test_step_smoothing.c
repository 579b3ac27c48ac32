/* Step smoothing: nothing while steps are equal, free flight untouched, energy under steps that change by 16, cuts, bad
   input. */

#include "level_sheet.h"
#include "loaded_rope.h"

static const float long_dt = 1.0f / 15.0f, short_dt = 1.0f / 240.0f;

static pli_body* make_sheet(int pins) {
    pli_patch_def def = level_sheet(0.5f, 0, 12);
    def.pins = pins;
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

static const solver_choice tried[] = {POSITION, SWEEPS, XPBD};
enum { TRIED_COUNT = sizeof tried / sizeof *tried };

static void use_tried_solver(pli_body* body, solver_choice which) {
    if (which != SWEEPS) {
        use_solver(body, which);
        return;
    }
    pli_implicit_def def = pli_implicit_def_default();
    def.stiffness = 5000;
    assert_int_equal(pli_body_enable_implicit(body, &def), PLI_OK);
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
    for (int which = 0; which < TRIED_COUNT; ++which) {
        uint64_t hashes[2];
        for (int k = 0; k < 2; ++k) {
            pli_body* sheet = make_sheet(PLI_PATCH_PIN_00);
            use_tried_solver(sheet, tried[which]);
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
    for (int which = 0; which < TRIED_COUNT; ++which) {
        pli_body* sheet = make_sheet(0);
        use_tried_solver(sheet, tried[which]);
        assert_int_equal(pli_body_enable_step_smoothing(sheet), PLI_OK);
        for (int i = 0; i < 20; ++i) {
            assert_int_equal(pli_world_step(world, i % 2 == 0 ? long_dt : short_dt), PLI_OK);
        }
        check_near(pli_body_get_view(sheet).velocities[40].y, -100 * (long_dt + short_dt), 1e-3f);
        pli_body_destroy(sheet);
    }
}

/* A sheet that swings from one corner. Its energy at the start is 0. */
static double most_energy(solver_choice which, bool smooths, int shorts) {
    pli_body* sheet = make_sheet(PLI_PATCH_PIN_00);
    use_tried_solver(sheet, which);
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
    for (int which = 0; which < TRIED_COUNT; ++which) {
        for (int shorts = 1; shorts <= 16; shorts *= 4) {
            check_at_most(most_energy(tried[which], true, shorts), 0.5);
        }
        if (tried[which] != XPBD) { check_at_most(10.0, most_energy(tried[which], false, 1)); } /* what it is for */
    }
}

/* XPBD stays as soft as in the long steps: with 10^15 J for one short step each, 10^7 for four, 343 for sixteen if it
   did not. */
static void test_xpbd_keeps_energy_without_smoothing(void** state) {
    (void)state;
    const double most[] = {0.0, 0.9, 8.0};
    for (int k = 0; k < 3; ++k) {
        check_at_most(most_energy(XPBD, false, 1 << 2 * k), most[k]);
    }
}

/* 5 kg on a rope of 1 kg: 0.8 m/s in frames of 1/144 to 1/30 s at random, as in equal ones of 1/60 s, and 5.6 if each
   were as stiff as it can be. Ten seconds after it the rope is as long as without. */
static void test_xpbd_carries_a_load_through_uneven_frames(void** state) {
    (void)state;
    float ends[2];
    for (int k = 0; k < 2; ++k) {
        pli_solver_settings settings = pli_body_def_default().solver;
        settings.velocity_damping = 0.005f;
        pli_rigid* load = NULL;
        pli_body* rope = make_loaded_rope(settings, XPBD, &load);
        float fastest = 0;
        uint32_t random = 1;
        for (int i = 0; i < 1050; ++i) {
            random = random * 1664525u + 1013904223u;
            const float share = (float)(random >> 8) / 16777216.0f;
            const bool is_uneven = k == 1 && i >= 150 && i < 450;
            const float dt = is_uneven ? 1 / 30.0f + share * (1 / 144.0f - 1 / 30.0f) : 1 / 60.0f;
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            assert_int_equal(pli_rigid_integrate(load, pli_world_get_gravity(world), dt), PLI_OK);
            fastest = fmaxf(fastest, pli_vec3_length(pli_rigid_get_state(load).linear_velocity));
        }
        ends[k] = pli_rigid_get_state(load).pose.origin.y;
        assert_true(fastest < 1);
        pli_rigid_destroy(load);
        pli_body_destroy(rope);
    }
    check_near(ends[1], ends[0], 0.01f);
}

/* An upright sheet of 1 m by 1 m in turns of long and short steps: kinetic energy against what gravity has done. */
typedef struct upright_sheet {
    int columns, pins;
    float mass, stiffness; /* kg, linear stiffness */
    solver_choice solver;
} upright_sheet;

static double most_kinetic_share(const upright_sheet* which, int steps, float first_dt, float second_dt, int turn) {
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_make(-0.5f, 0, 0);
    def.corner_10 = pli_vec3_make(0.5f, 0, 0);
    def.corner_01 = pli_vec3_make(-0.5f, 1, 0);
    def.corner_11 = pli_vec3_make(0.5f, 1, 0);
    def.columns = def.rows = which->columns;
    def.pins = which->pins;
    def.diagonals = true;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, which->mass), PLI_OK);
    const pli_material material = {.linear_stiffness = which->stiffness};
    assert_int_equal(pli_mesh_set_material(mesh, 0, &material), PLI_OK);
    pli_body_def body_def = pli_body_def_default();
    body_def.solver.position_iterations = 10;
    pli_body* sheet = NULL;
    assert_int_equal(pli_body_create(world, mesh, &body_def, &sheet), PLI_OK);
    pli_mesh_destroy(mesh);
    use_tried_solver(sheet, which->solver);
    assert_int_equal(pli_body_enable_step_smoothing(sheet), PLI_OK);
    const double start = energy(sheet);
    double most = 0, done = 0;
    for (int i = 0; i < steps; ++i) {
        assert_int_equal(pli_world_step(world, i / turn % 2 == 0 ? first_dt : second_dt), PLI_OK);
        const pli_body_view view = pli_body_get_view(sheet);
        double potential = 0;
        for (int node = 0; node < view.node_count; ++node) {
            if (view.positions[node].w > 0) {
                potential += 10 * (double)(view.positions[node].y / view.positions[node].w);
            }
        }
        done = fmax(done, start - potential);
        most = fmax(most, (energy(sheet) - potential) / (done + 0.1));
    }
    pli_body_destroy(sheet);
    return most;
}

/* Of soft links, held at three corners. What the long steps have stretched stays for many short ones. */
static void test_step_smoothing_holds_soft_links(void** state) {
    (void)state;
    const upright_sheet sheet = {5, PLI_PATCH_PIN_10 | PLI_PATCH_PIN_01 | PLI_PATCH_PIN_11, 1.6f, 0.3f, POSITION};
    const double shares[] = {most_kinetic_share(&sheet, 200, 0.052f, 0.0025f, 8),
                             most_kinetic_share(&sheet, 200, 0.03f, 0.003f, 8),
                             most_kinetic_share(&sheet, 200, 0.0667f, 0.0042f, 4)};
    for (int k = 0; k < 3; ++k) {
        print_message("kinetic energy: at most %.3g of the work of gravity\n", shares[k]);
        check_at_most(shares[k], 1.0);
    }
}

/* XPBD is as soft in short steps as in the long ones by itself. Made softer once more, a sheet swung up and down, with
   2.5 times the work of gravity after two seconds. */
static void test_step_smoothing_counts_what_xpbd_does(void** state) {
    (void)state;
    const upright_sheet sheet = {10, PLI_PATCH_PIN_00 | PLI_PATCH_PIN_01, 0.12f, 1, XPBD};
    const double share = most_kinetic_share(&sheet, 160, 0.0188f, 0.0064f, 8);
    print_message("kinetic energy: at most %.3g of the work of gravity\n", share);
    check_at_most(share, 0.1);
}

/* Forces from outside are not what a step puts right. */
static void test_step_smoothing_leaves_forces_alone(void** state) {
    (void)state;
    for (int which = 0; which < TRIED_COUNT; ++which) {
        pli_body* sheet = make_sheet(0);
        use_tried_solver(sheet, tried[which]);
        assert_int_equal(pli_body_enable_step_smoothing(sheet), PLI_OK);
        assert_int_equal(pli_world_step(world, long_dt), PLI_OK);
        for (int i = 0; i < 20; ++i) {
            assert_int_equal(pli_body_add_force(sheet, pli_vec3_make(0.5f, 0, 0)), PLI_OK);
            assert_int_equal(pli_world_step(world, short_dt), PLI_OK);
        }
        check_near(pli_body_get_view(sheet).velocities[40].x, 20 * short_dt * 0.5f / 0.01f, 1e-3f);
        pli_body_destroy(sheet);
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
        cmocka_unit_test_setup_teardown(test_xpbd_keeps_energy_without_smoothing, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_xpbd_carries_a_load_through_uneven_frames, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_step_smoothing_holds_soft_links, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_step_smoothing_counts_what_xpbd_does, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_step_smoothing_leaves_forces_alone, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_step_smoothing_follows_cuts, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_step_smoothing_refuses_bad_input, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
