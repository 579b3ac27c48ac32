/* Bodies of clusters under each solver: they lie on what they touch, also where that moves, and hang from their
   joints. */

#include "sample_mesh.h"
#include "solver_choice.h"

#include <math.h>

static const float dt = 1.0f / 60.0f;

#define CHECK_OK(call) assert_int_equal(call, PLI_OK)

/* 1 kg; takes the mesh. */
static pli_body* make_body(pli_mesh* mesh, solver_choice solver, int clusters, float damping) {
    CHECK_OK(pli_mesh_set_total_mass(mesh, 1));
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.03f;
    def.solver.position_iterations = 4;
    def.solver.velocity_damping = damping;
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    use_solver(body, solver);
    CHECK_OK(pli_body_generate_clusters(body, clusters, 100, NULL));
    return body;
}

/* A ball of 0.5 m of four clusters. */
static pli_body* make_ball(solver_choice solver, float height) {
    pli_mesh* mesh = NULL;
    CHECK_OK(
        pli_mesh_create_ellipsoid(context, pli_vec3_make(0, height, 0), pli_vec3_make(0.5f, 0.5f, 0.5f), 60, &mesh));
    return make_body(mesh, solver, 4, 0.01f);
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

/* Mass 0: kinematic. */
static pli_rigid* make_box(float half, float height, float mass, pli_vec3 velocity) {
    pli_shape* shape = NULL;
    CHECK_OK(pli_shape_create_box(context, pli_vec3_make(half, 0.15f, half), &shape));
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = mass > 0 ? PLI_RIGID_DYNAMIC : PLI_RIGID_KINEMATIC;
    def.shapes = &shape;
    def.shape_count = 1;
    def.state.pose.origin.y = height;
    def.state.linear_velocity = velocity;
    if (mass > 0) {
        def.state.inverse_mass = 1 / mass;
        for (int i = 0; i < 3; ++i) {
            def.state.inverse_inertia_world.rows[i] =
                pli_vec3_scale(pli_mat3_identity().rows[i], 1.5f / (mass * half * half));
        }
    }
    pli_rigid* rigid = NULL;
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    pli_shape_release(shape);
    return rigid;
}

/* Of the nodes against what they lie on, m/s. */
static float rms_speed(const pli_body* body, pli_vec3 velocity) {
    const pli_body_view view = pli_body_get_view(body);
    float sum = 0;
    for (int k = 0; k < view.node_count; ++k) {
        const pli_vec4 v = view.velocities[k];
        sum += pli_vec3_length_squared(pli_vec3_sub(pli_vec3_make(v.x, v.y, v.z), velocity));
    }
    return sqrtf(sum / (float)view.node_count);
}

/* How high a cushion and a crate of 1 kg on it lie above the middle of their lift, and how fast nodes move against it,
   rms; means over the last of four seconds; m, m/s. */
typedef struct ride {
    float cushion, crate, noise;
} ride;

static void set_matching(pli_body* body, float matching) { /* of its first cluster */
    pli_cluster_settings settings;
    CHECK_OK(pli_body_get_cluster_settings(body, 0, &settings));
    settings.matching = matching;
    CHECK_OK(pli_body_set_cluster_settings(body, 0, &settings));
}

static ride ride_on_lift(solver_choice solver, pli_vec3 velocity) {
    pli_mesh* mesh = NULL;
    const pli_vec3 centre = pli_vec3_make(0, 0.38f, 0), radii = pli_vec3_make(0.5f, 0.2f, 0.5f);
    CHECK_OK(pli_mesh_create_ellipsoid(context, centre, radii, 100, &mesh));
    pli_rigid* lift = make_box(3, 0, 0, velocity);
    pli_rigid* crate = make_box(0.15f, 0.77f, 1, velocity);
    pli_body* cushion = make_body(mesh, solver, 1, 0);
    set_matching(cushion, 0.3f);
    CHECK_OK(pli_body_enable_cluster_contacts(cushion, NULL));
    CHECK_OK(pli_body_add_velocity(cushion, velocity));
    ride found = {0, 0, 0};
    for (int i = 0; i < 240; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        CHECK_OK(pli_rigid_integrate(lift, pli_world_get_gravity(world), dt));
        CHECK_OK(pli_rigid_integrate(crate, pli_world_get_gravity(world), dt));
        if (i < 180) { continue; }
        const float height = pli_rigid_get_state(lift).pose.origin.y;
        found.cushion += (middle_of(cushion).y - height) / 60;
        found.crate += (pli_rigid_get_state(crate).pose.origin.y - height) / 60;
        found.noise += rms_speed(cushion, velocity) / 60;
    }
    pli_body_destroy(cushion);
    pli_rigid_destroy(crate);
    pli_rigid_destroy(lift);
    return found;
}

/* As on one that stands still, which they would sink into by v dt: 8 cm at 5 m/s. */
static void a_cushion_of_clusters_rides_at_any_speed(void** unused) {
    (void)unused;
    static const pli_vec3 velocities[] = {{0, 0.5f, 0}, {0, 5, 0}, {0, -5, 0}, {0, 20, 0}, {50, 0, 0}, {5, 5, 0}};
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        const ride still = ride_on_lift((solver_choice)solver, pli_vec3_make(0, 0, 0));
        for (int i = 0; i < (int)(sizeof velocities / sizeof *velocities); ++i) {
            const ride moving = ride_on_lift((solver_choice)solver, velocities[i]);
            print_message("solver %d at (%g, %g) m/s: cushion at %.4f m (still %.4f), crate at %.4f (%.4f), noise %.3f "
                          "(%.3f) m/s\n",
                          solver, (double)velocities[i].x, (double)velocities[i].y, (double)moving.cushion,
                          (double)still.cushion, (double)moving.crate, (double)still.crate, (double)moving.noise,
                          (double)still.noise);
            check_near(moving.cushion, still.cushion, 5e-4);
            check_near(moving.crate, still.crate, 3e-3);
            check_near(moving.noise, still.noise, 0.01);
        }
        check_at_most(still.noise, 0.06); /* 0.117 under XPBD if clusters did not know what gravity adds in a step */
    }
}

/* Clusters that lie on others give way: a crate of the slab's weight went 0.4 m deep. Contacts of nodes carry it. */
static void a_slab_of_clusters_carries_a_crate(void** unused) {
    (void)unused;
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_mesh* mesh = NULL;
        CHECK_OK(sample_create_slab(context, &mesh));
        CHECK_OK(pli_mesh_translate(mesh, pli_vec3_make(0, 0.2f, 0)));
        pli_rigid* floor = make_box(3, 0, 0, pli_vec3_make(0, 0, 0));
        pli_rigid* crate = make_box(0.3f, 0.8f, 1, pli_vec3_make(0, 0, 0));
        pli_body* slab = make_body(mesh, (solver_choice)solver, 8, 0.01f);
        CHECK_OK(pli_body_enable_cluster_contacts(slab, NULL));
        CHECK_OK(pli_body_enable_rigid_contacts(slab, NULL));
        float lowest = 1;
        for (int i = 0; i < 240; ++i) {
            CHECK_OK(pli_world_step(world, dt));
            CHECK_OK(pli_rigid_integrate(crate, pli_world_get_gravity(world), dt));
            lowest = fminf(lowest, pli_rigid_get_state(crate).pose.origin.y - 0.3f);
        }
        print_message("solver %d: the crate is %.3f m above the floor, was %.3f m\n", solver,
                      (double)pli_rigid_get_state(crate).pose.origin.y - 0.3, (double)lowest);
        assert_true(lowest > 0.4f);
        check_near(pli_rigid_get_state(crate).pose.origin.y - 0.3f, 0.44, 0.03);
        pli_body_destroy(slab);
        pli_rigid_destroy(crate);
        pli_rigid_destroy(floor);
    }
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
        set_matching(ball, 0.5f);
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

/* 100 nodes of one cluster in free fall for a second; its nodes take over its motion. */
static void damped_clusters_fall_with_g(void** unused) {
    (void)unused;
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_body* ball = make_ball((solver_choice)solver, 0);
        CHECK_OK(pli_body_generate_clusters(ball, 1, 100, NULL));
        pli_solver_settings unresisted = pli_body_get_solver_settings(ball);
        unresisted.velocity_damping = 0;
        CHECK_OK(pli_body_set_solver_settings(ball, &unresisted));
        pli_cluster_settings settings;
        CHECK_OK(pli_body_get_cluster_settings(ball, 0, &settings));
        settings.node_damping = 1;
        CHECK_OK(pli_body_set_cluster_settings(ball, 0, &settings));
        for (int i = 0; i < 60; ++i) {
            CHECK_OK(pli_world_step(world, dt));
        }
        const float speed = pli_body_get_view(ball).velocities[0].y;
        print_message("solver %d: %.4f m/s after a second\n", solver, (double)speed);
        check_near(speed, -10, 0.01);
        pli_body_destroy(ball);
    }
}

/* A ball of 1 m that is dropped from 5 and 45 cm has come to lie after six seconds, and does not roll on over edges of
   its mesh, which contacts that are followed from step to step did not see until they were deep in the ground. */
static void a_ball_of_one_cluster_stops_rolling(void** unused) {
    (void)unused;
    pli_rigid* ground = make_box(20, -0.15f, 0, pli_vec3_make(0, 0, 0));
    for (int run = 0; run < 2; ++run) {
        pli_mesh* mesh = NULL;
        const pli_vec3 centre = pli_vec3_make(0, run == 0 ? 1.1f : 1.5f, 0), radii = pli_vec3_make(1, 1, 1);
        CHECK_OK(pli_mesh_create_ellipsoid(context, centre, radii, 200, &mesh));
        pli_body* ball = make_body(mesh, POSITION, 1, 0);
        set_matching(ball, 0.5f);
        CHECK_OK(pli_body_enable_cluster_contacts(ball, NULL));
        float fastest = 0;
        for (int i = 0; i < 600; ++i) {
            CHECK_OK(pli_world_step(world, dt));
            if (i >= 360) { fastest = fmaxf(fastest, rms_speed(ball, pli_vec3_make(0, 0, 0))); }
        }
        print_message("from %.1f m: up to %.3f m/s after 6 s\n", (double)centre.y, (double)fastest);
        check_at_most(fastest, 0.15);
        pli_body_destroy(ball);
    }
    pli_rigid_destroy(ground);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_ball_of_clusters_lies_on_a_box, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_cushion_of_clusters_rides_at_any_speed, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_slab_of_clusters_carries_a_crate, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_ball_of_clusters_hangs_from_a_joint, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(damped_clusters_fall_with_g, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_ball_of_one_cluster_stops_rolling, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_ball_of_one_cluster_gets_its_shape_back, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
