/* The step against closed forms: free fall, pendulum, spring, catenary; invariants; freezing of bodies that blow up. */

#include "test_world.h"

#include <string.h>

static pli_body* make_rope(pli_vec3 from, pli_vec3 to, int inner_nodes, int pins, float stiffness, int iterations) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_rope(context, from, to, inner_nodes, pins, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_material(mesh, 0, &(pli_material){stiffness}), PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.solver.position_iterations = iterations;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

static void step_many(int steps, float dt) {
    for (int i = 0; i < steps; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
}

static float margin_of(pli_mesh* mesh, bool in_reference) {
    pli_world* in = world;
    pli_world_def def = pli_world_def_default();
    def.reference_mode = true;
    if (in_reference) { assert_int_equal(pli_world_create(context, &def, &in), PLI_OK); }
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(in, mesh, NULL, &body), PLI_OK);
    const float margin = pli_body_get_collision_margin(body);
    pli_body_destroy(body);
    if (in_reference) { pli_world_destroy(in); }
    pli_mesh_destroy(mesh);
    return margin;
}

static pli_mesh* make_chain(float spacing) {
    pli_mesh* mesh = NULL;
    assert_int_equal(
        pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(4 * spacing, 0, 0), 3, 0, &mesh), PLI_OK);
    return mesh;
}

static void test_the_default_margin_suits_the_mesh(void** unused) {
    (void)unused;
    check_near(margin_of(make_chain(0.1f), false), 0.05, 1e-6);
    check_near(margin_of(make_chain(0.1f), true), 0.25, 0);
    check_near(margin_of(make_chain(3), false), 0.25, 0);
    pli_mesh* stiff = make_chain(0.1f);
    assert_int_equal(pli_mesh_append_bending_links(stiff, 2, 0, NULL), PLI_OK);
    check_near(margin_of(stiff, false), 0.05, 1e-6);
    pli_mesh* faces = NULL; /* of 3, 4 and 5 decimetres, without links; then without faces */
    assert_int_equal(pli_mesh_create(context, &faces), PLI_OK);
    assert_int_equal(pli_mesh_append_node(faces, pli_vec3_make(0, 0, 0), 1, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_node(faces, pli_vec3_make(0.3f, 0, 0), 1, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_node(faces, pli_vec3_make(0, 0, 0.4f), 1, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_face(faces, 0, 2, 1, 0, NULL), PLI_OK);
    check_near(margin_of(faces, false), 0.2, 1e-6);
    assert_int_equal(pli_mesh_create(context, &faces), PLI_OK);
    assert_int_equal(pli_mesh_append_node(faces, pli_vec3_make(0, 0, 0), 1, NULL), PLI_OK);
    check_near(margin_of(faces, false), 0.25, 0);
}

static void test_free_fall_follows_the_symplectic_sum(void** unused) {
    (void)unused;
    pli_body* body = make_rope(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 6, 0, 1.0f, 4);
    const int steps = 120;
    const double dt = 1.0 / 60.0;
    step_many(steps, (float)dt);
    /* Velocity first, then position: y = -g dt^2 n (n + 1) / 2. */
    const double expected = -10.0 * dt * dt * steps * (steps + 1) / 2.0;
    const pli_body_view view = pli_body_get_view(body);
    for (int i = 0; i < view.node_count; ++i) {
        check_near(view.positions[i].y, expected, 2e-4);
        /* Velocities are differences of positions, whose rounding at -20 m is 1e-6 m per step. */
        check_near(view.velocities[i].y, -10.0 * dt * steps, 4e-4);
    }
    check_at_most(pli_body_max_stretch(body), 1e-5);
}

static void test_pendulum_swings_with_its_period(void** unused) {
    (void)unused;
    const double length = 2.0, angle = 0.1, dt = 1.0 / 240.0;
    const pli_vec3 end = pli_vec3_make((float)(length * sin(angle)), (float)(-length * cos(angle)), 0);
    pli_body* body = make_rope(pli_vec3_make(0, 0, 0), end, 0, PLI_ROPE_PIN_FIRST, 1.0f, 8);
    const pli_vec4* bob = &pli_body_get_view(body).positions[1];
    /* Between the first and the fifth crossing of the middle lie two periods. */
    double first = -1.0, fifth = -1.0;
    int crossings = 0;
    float x_before = bob->x;
    for (int i = 1; crossings < 5 && i < 5000; ++i) {
        step_many(1, (float)dt);
        if ((x_before > 0.0f) != (bob->x > 0.0f)) {
            const double time = dt * (i - (double)bob->x / ((double)bob->x - (double)x_before));
            crossings += 1;
            if (crossings == 1) { first = time; }
            if (crossings == 5) { fifth = time; }
        }
        x_before = bob->x;
    }
    const double period = 2.0 * acos(-1.0) * sqrt(length / 10.0) * (1.0 + angle * angle / 16.0);
    check_near((fifth - first) / 2.0, period, 2e-3 * period);
}

/* At rest the prediction adds g dt^2 and one sweep takes k r (r^2 - l^2) / (r^2 + l^2) back, r the predicted length. */
static double resting_length(double rest, double stiffness, double sag_per_step) {
    double low = rest, high = 10.0 * rest;
    for (int i = 0; i < 200; ++i) {
        const double r = 0.5 * (low + high);
        if (stiffness * r * (r * r - rest * rest) / (r * r + rest * rest) < sag_per_step) {
            low = r;
        } else {
            high = r;
        }
    }
    return low - sag_per_step;
}

static void test_spring_hangs_at_its_fixed_point(void** unused) {
    (void)unused;
    const float stiffnesses[] = {0.02f, 0.1f, 0.5f};
    for (int i = 0; i < 3; ++i) {
        const pli_vec3 top = pli_vec3_make((float)i, 0, 0), bottom = pli_vec3_make((float)i, -1, 0);
        pli_body* body = make_rope(top, bottom, 0, PLI_ROPE_PIN_FIRST, stiffnesses[i], 1);
        pli_solver_settings settings = pli_body_get_solver_settings(body);
        settings.velocity_damping = 0.05f;
        assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
        step_many(2000, 1.0f / 60.0f);
        const double expected = resting_length(1.0, (double)stiffnesses[i], 10.0 / 3600.0);
        check_near(-pli_body_get_view(body).positions[1].y, expected, 2e-5);
    }
}

/* Sag of an inextensible rope of length `length` over a level span: length = 2 a sinh(span / 2a). */
static double catenary_sag(double length, double span) {
    double low = 1e-1, high = 1e3;
    for (int i = 0; i < 200; ++i) {
        const double a = sqrt(low * high);
        if (2.0 * a * sinh(span / (2.0 * a)) > length) {
            low = a;
        } else {
            high = a;
        }
    }
    return low * (cosh(span / (2.0 * low)) - 1.0);
}

static void test_rope_hangs_as_a_catenary(void** unused) {
    (void)unused;
    const float length = 5.0f, span = 4.0f;
    const int inner_nodes = 49, pins = PLI_ROPE_PIN_FIRST | PLI_ROPE_PIN_LAST;
    pli_body* body = make_rope(pli_vec3_make(0, 0, 0), pli_vec3_make(length, 0, 0), inner_nodes, pins, 1.0f, 400);
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.velocity_damping = 0.02f;
    assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
    /* The last node comes nearer; the nodes between start on a parabola below. */
    for (int i = 0; i <= inner_nodes + 1; ++i) {
        const float share = (float)i / (float)(inner_nodes + 1);
        const float sag = -4.0f * share * (1.0f - share);
        assert_int_equal(pli_body_set_node_position(body, i, pli_vec3_make(span * share, sag, 0)), PLI_OK);
    }
    step_many(1500, 1.0f / 60.0f);
    const pli_body_view view = pli_body_get_view(body);
    check_near(-view.positions[(inner_nodes + 1) / 2].y, catenary_sag((double)length, (double)span), 5e-3);
    check_at_most(pli_body_max_stretch(body), 5e-3);
    check_near(view.positions[view.node_count - 1].x, span, 0.0);
}

static void test_free_body_keeps_its_momentum(void** unused) {
    (void)unused;
    assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, 0, 0)), PLI_OK);
    pli_body* body = make_rope(pli_vec3_make(0, 0, 0), pli_vec3_make(3, 0, 0), 10, 0, 0.7f, 3);
    assert_int_equal(pli_body_set_node_velocity(body, 0, pli_vec3_make(5, 3, 1)), PLI_OK);
    assert_int_equal(pli_body_set_node_velocity(body, 7, pli_vec3_make(-1, 2, -4)), PLI_OK);
    const pli_vec3 before = pli_body_momentum(body);
    step_many(60, 1.0f / 60.0f);
    const pli_vec3 after = pli_body_momentum(body);
    check_near(after.x, before.x, 1e-4);
    check_near(after.y, before.y, 1e-4);
    check_near(after.z, before.z, 1e-4);
}

static void test_pinned_node_with_a_velocity_moves_and_keeps_it(void** unused) {
    (void)unused;
    pli_body* body = make_rope(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 2, PLI_ROPE_PIN_FIRST, 1.0f, 1);
    assert_int_equal(pli_body_set_node_velocity(body, 0, pli_vec3_make(0, 3, 0)), PLI_OK);
    step_many(60, 1.0f / 60.0f);
    const pli_body_view view = pli_body_get_view(body);
    check_near(view.positions[0].y, 3.0, 1e-4);
    check_near(view.velocities[0].y, 3.0, 1e-4);
}

/* But by the position-based solver, as by btSoftBody. */
static void test_what_leads_a_pinned_node_is_not_damped(void** unused) {
    (void)unused;
    for (int run = 0; run < 3; ++run) {
        pli_body* body = make_rope(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 2, PLI_ROPE_PIN_FIRST, 1.0f, 1);
        if (run == 1) { assert_int_equal(pli_body_enable_implicit(body, NULL), PLI_OK); }
        if (run == 2) { assert_int_equal(pli_body_enable_xpbd(body, NULL), PLI_OK); }
        pli_solver_settings settings = pli_body_get_solver_settings(body);
        settings.velocity_damping = 0.05f;
        assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
        assert_int_equal(pli_body_set_node_velocity(body, 0, pli_vec3_make(0, 3, 0)), PLI_OK);
        step_many(60, 1.0f / 60.0f);
        const pli_body_view view = pli_body_get_view(body);
        const double kept = run == 0 ? pow(0.95, 60) : 1.0, went = run == 0 ? (1.0 - kept) : 3.0;
        check_near(view.velocities[0].y, 3.0 * kept, 1e-4);
        check_near(view.positions[0].y, went, 1e-4);
        pli_body_destroy(body);
    }
}

static void test_velocity_links_hold_a_rope_together(void** unused) {
    (void)unused;
    pli_body* body = make_rope(pli_vec3_make(0, 0, 0), pli_vec3_make(2, 0, 0), 8, PLI_ROPE_PIN_FIRST, 1.0f, 0);
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.velocity_iterations = 60;
    settings.drift_iterations = 60;
    settings.drift_correction = 0.7f;
    assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
    assert_int_equal(pli_body_enable_velocity_links(body), PLI_OK);
    step_many(240, 1.0f / 60.0f);
    check_at_most(pli_body_max_stretch(body), 0.02);
    /* Without any link it would be 80 m down. */
    check_at_most(-pli_body_get_view(body).positions[9].y, 2.1);
}

static void test_link_between_pinned_nodes_is_harmless(void** unused) {
    (void)unused;
    for (int use_velocity_links = 0; use_velocity_links < 2; ++use_velocity_links) {
        const int pins = PLI_ROPE_PIN_FIRST | PLI_ROPE_PIN_LAST;
        pli_body* body = make_rope(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 0, pins, 1.0f, 2);
        pli_solver_settings settings = pli_body_get_solver_settings(body);
        settings.velocity_iterations = settings.drift_iterations = 2;
        assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
        if (use_velocity_links != 0) { assert_int_equal(pli_body_enable_velocity_links(body), PLI_OK); }
        step_many(10, 1.0f / 60.0f);
        const pli_body_view view = pli_body_get_view(body);
        check_near(view.positions[1].x, 1.0, 0.0);
        check_near(view.positions[1].y, 0.0, 0.0);
        check_near(view.velocities[1].y, 0.0, 0.0);
    }
}

static void test_body_that_leaves_the_numbers_is_put_back_and_frozen(void** unused) {
    (void)unused;
    pli_body* wild = make_rope(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 2, 0, 1.0f, 1);
    pli_body* calm = make_rope(pli_vec3_make(5, 0, 0), pli_vec3_make(6, 0, 0), 2, 0, 1.0f, 1);
    step_many(3, 1.0f / 60.0f);
    pli_vec4 before[4];
    memcpy(before, pli_body_get_view(wild).positions, sizeof before);
    assert_int_equal(pli_body_set_node_velocity(wild, 2, pli_vec3_make(0, PLI_MAX_SPEED, 0)), PLI_OK);
    step_many(3, 60.0f);
    assert_true(pli_body_is_frozen(wild));
    assert_false(pli_body_is_frozen(calm));
    for (int i = 0; i < 4; ++i) {
        check_near(pli_body_get_view(wild).positions[i].x, before[i].x, 0.0);
        check_near(pli_body_get_view(wild).positions[i].y, before[i].y, 0.0);
    }
    check_at_most(pli_body_get_view(calm).positions[0].y, -1e4);
}

static void test_freezing_is_reported_once(void** unused) {
    (void)unused;
    pli_body* body = make_rope(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 2, 0, 1.0f, 1);
    assert_int_equal(pli_body_set_node_velocity(body, 3, pli_vec3_make(PLI_MAX_SPEED, 0, 0)), PLI_OK);
    step_many(1, 60.0f);
    int count = 0;
    const pli_event* events = pli_world_get_events(world, &count);
    assert_int_equal(count, 1);
    assert_int_equal(events[0].kind, PLI_EVENT_BODY_FROZEN);
    assert_ptr_equal(events[0].body, body);
    assert_int_equal(events[0].node, 3);
    step_many(1, 60.0f);
    pli_world_get_events(world, &count);
    assert_int_equal(count, 0);
}

static void test_same_input_gives_the_same_bits(void** unused) {
    (void)unused;
    uint64_t hashes[2];
    for (int run = 0; run < 2; ++run) {
        pli_world* own = NULL;
        assert_int_equal(pli_world_create(context, NULL, &own), PLI_OK);
        pli_patch_def def = pli_patch_def_default();
        def.columns = def.rows = 12;
        def.corner_00 = pli_vec3_make(0, 0, 0);
        def.corner_10 = pli_vec3_make(2, 0, 0);
        def.corner_01 = pli_vec3_make(0, 0, 2);
        def.corner_11 = pli_vec3_make(2, 0, 2);
        def.pins = PLI_PATCH_PIN_00 | PLI_PATCH_PIN_10;
        def.diagonals = true;
        pli_mesh* mesh = NULL;
        assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
        pli_body* body = NULL;
        assert_int_equal(pli_body_create(own, mesh, NULL, &body), PLI_OK);
        for (int i = 0; i < 100; ++i) {
            assert_int_equal(pli_world_step(own, 1.0f / 60.0f), PLI_OK);
        }
        hashes[run] = pli_body_state_hash(body);
        pli_mesh_destroy(mesh);
        pli_world_destroy(own);
    }
    assert_true(hashes[0] == hashes[1]);
}

typedef struct part_log {
    int depth, calls;
    int predicts, link_iterations;
} part_log;

static void log_part(const char* stage, const char* feature, bool begins, void* user) {
    part_log* log = user;
    log->calls += 1;
    log->depth += begins ? 1 : -1;
    assert_in_range(log->depth, 0, 2);
    if (!begins) { return; }
    if (strcmp(stage, "predict") == 0 && feature == NULL) { log->predicts += 1; }
    if (strcmp(stage, "position") == 0 && strcmp(feature, "links") == 0) { log->link_iterations += 1; }
}

static void test_profile_names_what_a_step_does(void** unused) {
    (void)unused;
    make_rope(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 6, PLI_ROPE_PIN_FIRST, 1.0f, 4);
    part_log log = {0};
    assert_int_equal(pli_world_set_profile(NULL, log_part, &log), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_world_set_profile(world, log_part, &log), PLI_OK);
    step_many(3, 1.0f / 60.0f);
    assert_int_equal(log.depth, 0);
    assert_int_equal(log.predicts, 3);
    assert_int_equal(log.link_iterations, 3 * 4);
    assert_int_equal(pli_world_predict(world, 1.0f / 60.0f), PLI_OK);
    assert_int_equal(pli_world_set_profile(world, NULL, NULL), PLI_ERROR_WRONG_STATE);
    assert_int_equal(pli_world_solve(world), PLI_OK);
    const int calls = log.calls;
    assert_int_equal(pli_world_set_profile(world, NULL, NULL), PLI_OK);
    step_many(1, 1.0f / 60.0f);
    assert_int_equal(log.calls, calls);
}

#define DYNAMICS_TEST(name) cmocka_unit_test_setup_teardown(name, setup_world, teardown_world)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_the_default_margin_suits_the_mesh, setup_world, teardown_world),
        DYNAMICS_TEST(test_free_fall_follows_the_symplectic_sum),
        DYNAMICS_TEST(test_pendulum_swings_with_its_period),
        DYNAMICS_TEST(test_spring_hangs_at_its_fixed_point),
        DYNAMICS_TEST(test_rope_hangs_as_a_catenary),
        DYNAMICS_TEST(test_free_body_keeps_its_momentum),
        DYNAMICS_TEST(test_pinned_node_with_a_velocity_moves_and_keeps_it),
        DYNAMICS_TEST(test_what_leads_a_pinned_node_is_not_damped),
        DYNAMICS_TEST(test_velocity_links_hold_a_rope_together),
        DYNAMICS_TEST(test_link_between_pinned_nodes_is_harmless),
        DYNAMICS_TEST(test_body_that_leaves_the_numbers_is_put_back_and_frozen),
        DYNAMICS_TEST(test_freezing_is_reported_once),
        DYNAMICS_TEST(test_same_input_gives_the_same_bits),
        DYNAMICS_TEST(test_profile_names_what_a_step_does),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
