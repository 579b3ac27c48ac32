/* Contacts and anchors are enabled once and hold under each solver, whichever was enabled first and however often a
   body goes from one to the other. */

#include "level_sheet.h"
#include "test_world.h"

#define CHECK_OK(expression) assert_int_equal(expression, PLI_OK)

static const float dt = 1.0f / 60.0f;

typedef enum solver { POSITION, XPBD, IMPLICIT } solver;

static void enable_solver(pli_body* body, solver which) {
    if (which == XPBD) {
        CHECK_OK(pli_body_enable_xpbd(body, NULL));
        CHECK_OK(pli_body_enable_xpbd_links(body, NULL));
    } else if (which == IMPLICIT) {
        pli_implicit_def def = pli_implicit_def_default();
        def.stiffness = 1e4f;
        def.sweeps = 31;
        CHECK_OK(pli_body_enable_implicit(body, &def));
    }
}

static void disable_solver(pli_body* body, solver which) {
    if (which == XPBD) { CHECK_OK(pli_body_disable_xpbd(body)); }
    if (which == IMPLICIT) { CHECK_OK(pli_body_disable_implicit(body)); }
}

static void steps(int count) {
    for (int i = 0; i < count; ++i) {
        CHECK_OK(pli_world_step(world, dt));
    }
}

static pli_vec3 position(const pli_body* body, int node) {
    const pli_vec4 x = pli_body_get_view(body).positions[node];
    return pli_vec3_make(x.x, x.y, x.z);
}

static pli_rigid* make_rigid(pli_shape* shape) {
    pli_rigid_def def = pli_rigid_def_default();
    def.shape_count = shape != NULL ? 1 : 0;
    def.shapes = &shape;
    def.friction = 1.0f;
    pli_rigid* rigid = NULL;
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    return rigid;
}

static pli_body* make_body(pli_mesh* mesh) {
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.02f;
    def.solver.position_iterations = 10;
    def.solver.velocity_damping = 0.02f;
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    return body;
}

static pli_body* make_sheet(float height, float width, int nodes) {
    const float half = 0.5f * width;
    pli_patch_def patch = level_sheet(half, height, nodes);
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 0.5f));
    return make_body(mesh);
}

static void enable_rigid_contacts(pli_body* body) {
    pli_rigid_contacts_def def = pli_rigid_contacts_def_default();
    def.friction = 0.8f;
    def.static_hardness = 1.0f;
    CHECK_OK(pli_body_enable_rigid_contacts(body, &def));
}

/* Of the nodes from the surface of a ball about the origin. */
static double lowest_gap(const pli_body* body, double radius) {
    double lowest = 1e9;
    for (int i = 0; i < pli_body_get_view(body).node_count; ++i) {
        lowest = fmin(lowest, (double)pli_vec3_length(position(body, i)) - radius);
    }
    return lowest;
}

// ---------------------------------------------------------------------------------------------------------- contacts

static void make_ball(float radius) {
    pli_shape* ball = NULL;
    CHECK_OK(pli_shape_create_sphere(context, radius, &ball));
    make_rigid(ball);
    pli_shape_release(ball);
}

static void check_lies_on_ball(const pli_body* body) {
    const double gap = lowest_gap(body, 0.5);
    const pli_vec3 middle = position(body, 60); /* of 11 x 11 */
    print_message("lowest gap %g, middle %g %g %g\n", gap, (double)middle.x, (double)middle.y, (double)middle.z);
    check_near(gap, 0.02, 0.006); /* the margin */
    check_near(middle.x, 0.0, 0.05);
    check_near(middle.y, 0.52, 0.01);
    check_near(middle.z, 0.0, 0.05);
    assert_true(pli_body_get_rigid_contacts(body, 0, NULL) >= 9);
}

static void test_sheet_lies_on_a_ball_under_each_solver(void** unused) {
    (void)unused;
    static const solver order[] = {XPBD, POSITION, IMPLICIT, XPBD, IMPLICIT, POSITION, XPBD};
    make_ball(0.5f);
    pli_body* body = make_sheet(0.53f, 1.0f, 11);
    enable_rigid_contacts(body);
    for (size_t i = 0; i < sizeof order / sizeof *order; ++i) {
        enable_solver(body, order[i]);
        steps(60);
        check_lies_on_ball(body);
        disable_solver(body, order[i]);
    }
}

static void test_contacts_may_come_after_the_solver_and_go_before_it(void** unused) {
    (void)unused;
    make_ball(0.5f);
    static const solver solvers[] = {XPBD, IMPLICIT};
    for (int i = 0; i < 2; ++i) {
        pli_body* body = make_sheet(0.53f, 1.0f, 11);
        enable_solver(body, solvers[i]);
        enable_rigid_contacts(body);
        steps(60);
        check_lies_on_ball(body);
        CHECK_OK(pli_body_disable_rigid_contacts(body));
        steps(30);
        check_at_most(position(body, 60).y, -0.2); /* it fell through by 1.2 m, less the damping */
        pli_body_destroy(body);
    }
}

/* Two steps differ by nothing else than which was enabled first. */
static void test_order_of_enabling_does_not_matter(void** unused) {
    (void)unused;
    make_ball(0.5f);
    for (int which = XPBD; which <= IMPLICIT; ++which) {
        uint64_t hashes[2];
        for (int order = 0; order < 2; ++order) {
            pli_body* body = make_sheet(0.53f, 1.0f, 11);
            if (order == 0) { enable_solver(body, (solver)which); }
            enable_rigid_contacts(body);
            CHECK_OK(pli_body_enable_soft_contacts(body, NULL));
            if (order == 1) { enable_solver(body, (solver)which); }
            steps(60);
            hashes[order] = pli_body_state_hash(body);
            pli_body_destroy(body);
        }
        assert_true(hashes[0] == hashes[1]);
    }
}

static void test_sheet_lies_on_a_sheet_under_each_solver(void** unused) {
    (void)unused;
    static const solver order[] = {XPBD, IMPLICIT, POSITION, XPBD};
    pli_shape* plane = NULL;
    CHECK_OK(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0.0f, &plane));
    make_rigid(plane);
    pli_shape_release(plane);
    pli_body* bodies[2] = {make_sheet(0.02f, 1.0f, 9), make_sheet(0.07f, 0.6f, 6)};
    for (int i = 0; i < 2; ++i) {
        pli_soft_contacts_def def = pli_soft_contacts_def_default();
        def.recovery_speed = 1.0f;
        CHECK_OK(pli_body_enable_soft_contacts(bodies[i], &def));
        enable_rigid_contacts(bodies[i]);
    }
    for (size_t i = 0; i < sizeof order / sizeof *order; ++i) {
        for (int b = 0; b < 2; ++b) {
            enable_solver(bodies[b], order[i]);
        }
        steps(60);
        double height = 0.0;
        for (int node = 0; node < 36; ++node) {
            height += (double)position(bodies[1], node).y / 36.0;
        }
        print_message("mean height %g\n", height);
        check_near(height, 0.06, 0.004); /* a margin above the plane and two above the other sheet */
        assert_true(pli_body_get_soft_contacts(bodies[0], 0, NULL) + pli_body_get_soft_contacts(bodies[1], 0, NULL) >
                    0);
        for (int b = 0; b < 2; ++b) {
            disable_solver(bodies[b], order[i]);
        }
    }
}

// ----------------------------------------------------------------------------------------------------------- anchors

static void test_anchors_hold_under_each_solver(void** unused) {
    (void)unused;
    static const solver order[] = {XPBD, POSITION, IMPLICIT, XPBD, IMPLICIT, POSITION, XPBD};
    pli_rigid* wall = make_rigid(NULL);
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 9, 0, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 0.5f));
    pli_body* body = make_body(mesh);
    pli_anchor_def def = pli_anchor_def_default();
    def.rigid = wall;
    pli_anchor_id anchor;
    CHECK_OK(pli_body_add_anchor(body, &def, &anchor));
    for (size_t i = 0; i < sizeof order / sizeof *order; ++i) {
        enable_solver(body, order[i]);
        steps(60);
        assert_int_equal(pli_body_anchor_count(body), 1);
        assert_true(pli_rigid_was_touched(wall));
        print_message("held to %g m\n", (double)pli_vec3_length(position(body, 0)));
        check_at_most(pli_vec3_length(position(body, 0)), 5e-3); /* XPBD and implicit 1e-6 */
        check_near(pli_vec3_length(position(body, 10)), 1.0, 0.1);
        disable_solver(body, order[i]);
    }
    CHECK_OK(pli_body_remove_anchor(body, anchor)); /* the same one all along */
    CHECK_OK(pli_body_enable_xpbd(body, NULL));
    const float height = position(body, 0).y;
    steps(30);
    check_at_most(position(body, 0).y, (double)height - 0.5);
}

// ------------------------------------------------------------------------------------------------ values of contacts

/* How far a node that begins 0.1 m deep in a plane is lifted within 0.1 s, without gravity. */
static double lift(solver which, float recovery_speed, float* speed) {
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create(context, &mesh));
    CHECK_OK(pli_mesh_append_node(mesh, pli_vec3_make(0, -0.08f, 0), 1.0f, NULL));
    pli_body* body = make_body(mesh);
    pli_rigid_contacts_def def = pli_rigid_contacts_def_default();
    def.recovery_speed = recovery_speed;
    CHECK_OK(pli_body_enable_rigid_contacts(body, &def));
    if (which == XPBD) { CHECK_OK(pli_body_enable_xpbd(body, NULL)); }
    if (which == IMPLICIT) { CHECK_OK(pli_body_enable_implicit(body, NULL)); }
    steps(6);
    const double lifted = (double)position(body, 0).y + 0.08;
    *speed = pli_body_get_view(body).velocities[0].y;
    pli_body_destroy(body);
    return lifted;
}

static void test_penetrations_go_at_the_recovery_speed(void** unused) {
    (void)unused;
    CHECK_OK(pli_world_set_gravity(world, pli_vec3_make(0, 0, 0)));
    pli_shape* plane = NULL;
    CHECK_OK(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0.0f, &plane));
    make_rigid(plane);
    pli_shape_release(plane);
    float speed = 0.0f;
    check_near(lift(XPBD, 0.5f, &speed), 0.05, 1e-5);
    check_near(speed, 0.0, 1e-5);
    check_near(lift(XPBD, 0.0f, &speed), 0.1, 1e-5); /* 1 m/s */
    check_near(lift(IMPLICIT, 0.2f, &speed), 0.02, 1e-5);
    check_near(speed, 0.0, 1e-5);
    /* A tenth of what is left in each step, which is slower than 1 m/s. */
    check_near(lift(IMPLICIT, 0.0f, &speed), 0.1 * (1.0 - pow(0.9, 6.0)), 1e-5);
    check_near(lift(POSITION, 0.5f, &speed), 0.05, 1e-5);
    check_near(speed, 0.0, 1e-5);
    check_near(lift(POSITION, 0.0f, &speed), 0.1, 1e-5);
}

static void test_wrong_values_are_refused(void** unused) {
    (void)unused;
    pli_body* body = make_sheet(0, 1, 3);
    pli_rigid_contacts_def rigid = pli_rigid_contacts_def_default();
    rigid.compliance = -1.0f;
    check_refused(pli_body_enable_rigid_contacts(body, &rigid), PLI_ERROR_INVALID_VALUE, "compliance is -1");
    rigid.compliance = NAN;
    check_refused(pli_body_enable_rigid_contacts(body, &rigid), PLI_ERROR_NOT_FINITE, "compliance is nan");
    rigid.compliance = 0.0f;
    rigid.recovery_speed = -2.0f;
    check_refused(pli_body_enable_rigid_contacts(body, &rigid), PLI_ERROR_INVALID_VALUE, "recovery_speed is -2");
    pli_soft_contacts_def soft = pli_soft_contacts_def_default();
    soft.compliance = -3.0f;
    check_refused(pli_body_enable_soft_contacts(body, &soft), PLI_ERROR_INVALID_VALUE, "compliance is -3");
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.rigid = make_rigid(NULL);
    anchor.compliance = INFINITY;
    check_refused(pli_body_add_anchor(body, &anchor, NULL), PLI_ERROR_NOT_FINITE, "compliance is inf");
    assert_int_equal(pli_body_anchor_count(body), 0);
}

// ------------------------------------------------------------------------------------------------------------ memory

static size_t feature_bytes(const pli_body* body, const char* name) {
    pli_feature_cost features[32];
    const int count = pli_body_get_features(body, 32, features);
    for (int i = 0; i < count; ++i) {
        if (strcmp(features[i].name, name) == 0) { return features[i].bytes; }
    }
    fail_msg("no feature %s", name);
    return 0;
}

/* They are solved in the same way by each. */
static void test_memory_of_contacts_does_not_depend_on_the_solver(void** unused) {
    (void)unused;
    make_ball(0.5f);
    pli_body* bodies[2] = {make_sheet(0.53f, 1.0f, 11), make_sheet(0.60f, 1.0f, 11)};
    size_t rigid = 0, soft = 0;
    for (int round = 0; round < 3; ++round) {
        for (int b = 0; b < 2; ++b) {
            enable_rigid_contacts(bodies[b]);
            CHECK_OK(pli_body_enable_soft_contacts(bodies[b], NULL));
        }
        steps(30);
        if (round == 0) {
            rigid = feature_bytes(bodies[0], "rigid contacts");
            soft = feature_bytes(bodies[1], "soft contacts");
        }
        enable_solver(bodies[0], XPBD);
        enable_solver(bodies[1], XPBD);
        steps(20);
        assert_int_equal(feature_bytes(bodies[0], "rigid contacts"), rigid);
        assert_int_equal(feature_bytes(bodies[1], "soft contacts"), soft);
        disable_solver(bodies[0], XPBD);
        disable_solver(bodies[1], XPBD);
        assert_int_equal(feature_bytes(bodies[0], "rigid contacts"), rigid);
        assert_int_equal(feature_bytes(bodies[1], "soft contacts"), soft);
    }
}

/* The first step after a change makes room for what comes. */
static void test_steps_that_meet_a_ball_do_not_allocate(void** unused) {
    (void)unused;
    static const solver order[] = {XPBD, POSITION, XPBD};
    make_ball(0.5f);
    pli_body* body = make_sheet(0.53f, 1.0f, 11);
    enable_rigid_contacts(body);
    for (size_t i = 0; i < sizeof order / sizeof *order; ++i) {
        enable_solver(body, order[i]);
        CHECK_OK(pli_body_transform(body, pli_transform_make(pli_quat_identity(), pli_vec3_make(0, 0.1f, 0))));
        steps(1);
        assert_int_equal(pli_body_get_rigid_contacts(body, 0, NULL), 0);
        const uint64_t before = pli_context_allocation_count(context);
        steps(40);
        assert_int_equal(pli_context_allocation_count(context), before);
        assert_true(pli_body_get_rigid_contacts(body, 0, NULL) > 0);
        disable_solver(body, order[i]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_sheet_lies_on_a_ball_under_each_solver, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_contacts_may_come_after_the_solver_and_go_before_it, setup_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_order_of_enabling_does_not_matter, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_sheet_lies_on_a_sheet_under_each_solver, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_anchors_hold_under_each_solver, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_penetrations_go_at_the_recovery_speed, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_wrong_values_are_refused, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_memory_of_contacts_does_not_depend_on_the_solver, setup_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_steps_that_meet_a_ball_do_not_allocate, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
