/* Bodies of clusters under each solver: they lie on what they touch, and hang from their joints. */

#include "solver_choice.h"

#include <math.h>

static const float dt = 1.0f / 60.0f;

#define CHECK_OK(call) assert_int_equal(call, PLI_OK)

/* A ball of 0.5 m, 1 kg, of four clusters. */
static pli_body* make_ball(solver_choice solver, float height) {
    pli_mesh* mesh = NULL;
    CHECK_OK(
        pli_mesh_create_ellipsoid(context, pli_vec3_make(0, height, 0), pli_vec3_make(0.5f, 0.5f, 0.5f), 60, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 1));
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.03f;
    def.solver.position_iterations = 4;
    def.solver.velocity_damping = 0.01f;
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    use_solver(body, solver);
    CHECK_OK(pli_body_generate_clusters(body, 4, 100, NULL));
    return body;
}

static void a_ball_of_clusters_lies_on_a_box(void** unused) {
    (void)unused;
    pli_shape* shape = NULL;
    CHECK_OK(pli_shape_create_box(context, pli_vec3_make(3, 0.5f, 3), &shape));
    pli_rigid_def def = pli_rigid_def_default();
    def.shapes = &shape;
    def.shape_count = 1;
    def.state.pose.origin.y = -0.5f;
    pli_rigid* rigid = NULL;
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    pli_shape_release(shape);
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_body* ball = make_ball((solver_choice)solver, 0.6f);
        CHECK_OK(pli_body_enable_cluster_contacts(ball, NULL));
        float lowest = 1;
        for (int i = 0; i < 180; ++i) {
            CHECK_OK(pli_world_step(world, dt));
            lowest = fminf(lowest, middle_of(ball).y);
        }
        print_message("solver %d: lies at %.3f m, was at %.3f m\n", solver, (double)middle_of(ball).y, (double)lowest);
        assert_true(lowest > 0.49f);
        check_near(middle_of(ball).y, 0.5, 0.01);
        pli_body_destroy(ball);
    }
    pli_rigid_destroy(rigid);
}

static void a_ball_of_clusters_hangs_from_a_joint(void** unused) {
    (void)unused;
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_body* ball = make_ball((solver_choice)solver, 0);
        pli_linear_joint_def joint = pli_linear_joint_def_default();
        joint.position = pli_vec3_make(0, 0.5f, 0);
        CHECK_OK(pli_body_add_linear_joint(ball, &joint, NULL));
        float lowest = 1;
        for (int i = 0; i < 180; ++i) {
            CHECK_OK(pli_world_step(world, dt));
            lowest = fminf(lowest, middle_of(ball).y);
        }
        print_message("solver %d: hangs at %.3f m, was at %.3f m\n", solver, (double)middle_of(ball).y, (double)lowest);
        assert_true(lowest > -0.01f);
        pli_body_destroy(ball);
    }
}

/* Pressed flat and let go, without links. */
static void a_ball_of_one_cluster_gets_its_shape_back(void** unused) {
    (void)unused;
    CHECK_OK(pli_world_set_gravity(world, pli_vec3_make(0, 0, 0)));
    for (int has_xpbd = 0; has_xpbd <= 1; ++has_xpbd) {
        pli_mesh* mesh = NULL;
        const pli_vec3 radii = pli_vec3_make(0.5f, 0.5f, 0.5f);
        CHECK_OK(pli_mesh_create_ellipsoid(context, pli_vec3_make(0, 0, 0), radii, 100, &mesh));
        pli_body_def def = pli_body_def_default();
        def.solver.position_iterations = 0;
        pli_body* ball = NULL;
        CHECK_OK(pli_body_create(world, mesh, &def, &ball));
        pli_mesh_destroy(mesh);
        if (has_xpbd != 0) { CHECK_OK(pli_body_enable_xpbd(ball, NULL)); }
        CHECK_OK(pli_body_enable_clusters(ball, NULL));
        CHECK_OK(pli_body_generate_clusters(ball, 1, 100, NULL));
        pli_cluster_settings settings;
        CHECK_OK(pli_body_get_cluster_settings(ball, 0, &settings));
        settings.matching = 0.5f;
        CHECK_OK(pli_body_set_cluster_settings(ball, 0, &settings));
        const float volume = pli_body_volume(ball);
        for (int i = 0; i < 100; ++i) {
            const pli_vec4 x = pli_body_get_view(ball).positions[i];
            CHECK_OK(pli_body_set_node_position(ball, i, pli_vec3_make(x.x, 0.5f * x.y, x.z)));
        }
        CHECK_OK(pli_world_step(world, dt));
        const float share = pli_body_volume(ball) / volume;
        print_message("xpbd %d: volume %.4f of that at rest after a step\n", has_xpbd, (double)share);
        check_near(share, 0.75, 0.03);
        pli_body_destroy(ball);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_ball_of_clusters_lies_on_a_box, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_ball_of_clusters_hangs_from_a_joint, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_ball_of_one_cluster_gets_its_shape_back, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
