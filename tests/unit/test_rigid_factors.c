/* Factors of rigid bodies: to what meets one or is tied to it, a body that they hold is as one that cannot move,
   however light it is. */

#include "test_cluster_world.h"

#include "solver_choice.h"

static const float dt = 1.0f / 60.0f, half = 0.5f, margin = 0.05f;

/* 10 g at the origin, which nothing moves. */
static pli_rigid* make_held(void) {
    const pli_vec3 none = pli_vec3_make(0, 0, 0), extents = pli_vec3_make(half, half, half);
    pli_rigid* rigid = make_rigid(PLI_RIGID_DYNAMIC, 0.01f, 0.002f, none, make_box_shape(extents));
    assert_int_equal(pli_rigid_set_factors(rigid, none, none), PLI_OK);
    return rigid;
}

/* A triangle of 3 kg at this height. */
static pli_body* make_triangle(float height, solver_choice solver) {
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(context, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make(-0.2f, height, -0.2f), 1, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make(0, height, 0.2f), 1, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_node(mesh, pli_vec3_make(0.2f, height, -0.2f), 1, NULL), PLI_OK);
    assert_int_equal(pli_mesh_append_face(mesh, 0, 1, 2, 0, NULL), PLI_OK);
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(pli_mesh_append_link(mesh, i, (i + 1) % 3, 0, NULL), PLI_OK);
    }
    pli_body* body = make_body(mesh, margin);
    use_solver(body, solver);
    return body;
}

static void step(int count) {
    for (int i = 0; i < count; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
}

static void test_a_light_body_that_is_held_holds(void** unused) {
    (void)unused;
    for (int k = 0; k < 2 * SOLVER_COUNT; ++k) {
        const bool has_nodes = k < SOLVER_COUNT;
        pli_rigid* rigid = make_held();
        pli_body* body = make_triangle(half + 2 * margin, (solver_choice)(k % SOLVER_COUNT));
        assert_int_equal(has_nodes ? pli_body_enable_rigid_contacts(body, NULL)
                                   : pli_body_enable_rigid_face_contacts(body, NULL),
                         PLI_OK);
        step(60);
        check_near(middle_of(body).y, half + margin, has_nodes ? 1e-3 : 0.015);
        check_near(pli_rigid_get_state(rigid).linear_velocity.y, 0, 1e-6);
        pli_rigid_destroy(rigid);
        pli_body_destroy(body);
    }
}

/* What slides slower than friction allows stops at once. */
static void test_its_friction_is_that_of_one_that_stands(void** unused) {
    (void)unused;
    const solver_choice solvers[] = {POSITION, XPBD};
    for (int k = 0; k < 2; ++k) {
        pli_rigid* rigid = make_held();
        pli_body* body = make_triangle(half + margin, solvers[k]);
        pli_rigid_contacts_def def = pli_rigid_contacts_def_default();
        def.friction = 1;
        assert_int_equal(pli_body_enable_rigid_contacts(body, &def), PLI_OK);
        assert_int_equal(pli_body_add_velocity(body, pli_vec3_make(0.05f, 0, 0)), PLI_OK);
        step(2);
        check_near(pli_body_get_view(body).velocities[1].x, 0, 1e-3);
        pli_rigid_destroy(rigid);
        pli_body_destroy(body);
    }
}

static void test_anchors_and_joints_hang_on_it(void** unused) {
    (void)unused;
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_rigid* rigid = make_held();
        pli_body* body = make_triangle(0, (solver_choice)solver);
        const int nodes[] = {0, 1, 2};
        assert_int_equal(pli_body_attach_nodes(body, nodes, 3, rigid), PLI_OK);
        step(60);
        check_near(middle_of(body).y, 0, 0.01);
        pli_body_destroy(body);

        body = make_triangle(-1, (solver_choice)solver);
        assert_int_equal(pli_body_add_cluster(body, nodes, 3, NULL), PLI_OK);
        match_clusters(body, 1);
        pli_linear_joint_def linear = pli_linear_joint_def_default();
        linear.other.rigid = rigid;
        linear.position = pli_vec3_make(0, -1, -0.2f / 3);
        assert_int_equal(pli_body_add_linear_joint(body, &linear, NULL), PLI_OK);
        step(60);
        check_near(middle_of(body).y, -1, 0.01);
        pli_rigid_destroy(rigid);
        pli_body_destroy(body);
    }
}

/* It turns at once as far as the joint wants, and the light body not at all. */
static float wanted_speed(float present, void* user) {
    (void)present;
    (void)user;
    return 2.0f;
}
static void test_a_motor_turns_against_it(void** unused) {
    (void)unused;
    pli_rigid* rigid = make_held();
    pli_body* body = make_triangle(-1, POSITION);
    const int nodes[] = {0, 1, 2};
    assert_int_equal(pli_body_add_cluster(body, nodes, 3, NULL), PLI_OK);
    match_clusters(body, 1);
    pli_angular_joint_def angular = pli_angular_joint_def_default();
    angular.other.rigid = rigid;
    angular.axis = pli_vec3_make(0, 1, 0);
    angular.controller.speed = wanted_speed;
    assert_int_equal(pli_body_add_angular_joint(body, &angular, NULL), PLI_OK);
    step(3);
    check_near(cluster_of(body, 0).angular_velocity.y, 2, 0.1);
    check_near(pli_rigid_get_state(rigid).angular_velocity.y, 0, 0);
}

/* A pinned node pushes nothing along an axis along which the body is held, and all the same along the others. */
static void test_a_pinned_node_pulls_along_free_axes(void** unused) {
    (void)unused;
    const solver_choice solvers[] = {POSITION, XPBD};
    for (int k = 0; k < 2; ++k) {
        const pli_vec3 origin = pli_vec3_make(0, 0, 0);
        pli_rigid* rigid = make_rigid(PLI_RIGID_DYNAMIC, 2, 1, origin, NULL);
        assert_int_equal(pli_rigid_set_factors(rigid, pli_vec3_make(1, 1, 0), origin), PLI_OK);
        pli_body* body = make_points(&origin, 1, margin);
        use_solver(body, solvers[k]);
        assert_int_equal(pli_body_set_node_mass(body, 0, 0), PLI_OK);
        const int node = 0;
        assert_int_equal(pli_body_attach_nodes(body, &node, 1, rigid), PLI_OK);
        pli_rigid_state state = pli_rigid_get_state(rigid);
        state.linear_velocity = pli_vec3_make(1, 0, 3);
        assert_int_equal(pli_rigid_set_state(rigid, &state), PLI_OK);
        step(3);
        check_near(pli_rigid_get_state(rigid).linear_velocity.x, 0, 0.1);
        check_near(pli_rigid_get_state(rigid).linear_velocity.z, 3, 0);
        pli_rigid_destroy(rigid);
        pli_body_destroy(body);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_a_light_body_that_is_held_holds, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_its_friction_is_that_of_one_that_stands, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_anchors_and_joints_hang_on_it, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_motor_turns_against_it, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_pinned_node_pulls_along_free_axes, setup_weightless_world,
                                        teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
