/* Bodies that nothing holds, alone and with others: momentum and angular momentum of all stay, and no energy comes. */

#include "solver_choice.h"

#include <math.h>

#define CHECK_OK(call) assert_int_equal(call, PLI_OK)

/* About the origin and the axis z. */
typedef struct motion {
    double momentum[2], spin, energy;
} motion;

static motion motion_of_body(const pli_body* body) {
    motion sum = {.energy = (double)pli_body_kinetic_energy(body)};
    const pli_body_view view = pli_body_get_view(body);
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 x = view.positions[i], v = view.velocities[i];
        const double mass = 1.0 / (double)x.w;
        sum.momentum[0] += mass * (double)v.x;
        sum.momentum[1] += mass * (double)v.y;
        sum.spin += mass * ((double)x.x * (double)v.y - (double)x.y * (double)v.x);
    }
    return sum;
}

static void add_motion(motion* sum, motion more) {
    sum->momentum[0] += more.momentum[0];
    sum->momentum[1] += more.momentum[1];
    sum->spin += more.spin;
    sum->energy += more.energy;
}

/* A hollow ball with bending links. */
static pli_body* make_ball(float x, float y, float radius, float mass, solver_choice solver, float stiffness) {
    pli_mesh* mesh = NULL;
    pli_body* ball = NULL;
    CHECK_OK(
        pli_mesh_create_ellipsoid(context, pli_vec3_make(x, y, 0), pli_vec3_make(radius, radius, radius), 100, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, mass));
    CHECK_OK(pli_mesh_append_bending_links(mesh, 3, 0, NULL));
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.03f;
    CHECK_OK(pli_body_create(world, mesh, &def, &ball));
    pli_mesh_destroy(mesh);
    use_solver(ball, solver);
    if (solver == SWEEPS || solver == GRADIENTS) {
        pli_implicit_def implicit = pli_implicit_def_default();
        implicit.stiffness = stiffness;
        if (solver == GRADIENTS) {
            implicit.method = PLI_IMPLICIT_CONJUGATE_GRADIENT;
            implicit.sweeps = 100;
        }
        CHECK_OK(pli_body_enable_implicit(ball, &implicit));
    }
    return ball;
}

// ------------------------------------------------------------------------------------------- with a rigid body

enum { PLANK_MASS = 5 };
static const double plank_inertia = PLANK_MASS / 3.0 * (1.0 + 0.01); /* about z */

static pli_rigid* make_plank(void) {
    pli_rigid_def def = pli_rigid_def_default();
    pli_shape* box = NULL;
    CHECK_OK(pli_shape_create_box(context, pli_vec3_make(1, 0.1f, 0.5f), &box));
    def.shapes = &box;
    def.shape_count = 1;
    def.kind = PLI_RIGID_DYNAMIC;
    def.friction = 1;
    def.state.inverse_mass = 1.0f / PLANK_MASS;
    def.state.inverse_inertia_world = pli_mat3_identity();
    def.state.inverse_inertia_world.rows[0].x = 3.0f / (PLANK_MASS * 0.26f);
    def.state.inverse_inertia_world.rows[1].y = 3.0f / (PLANK_MASS * 1.25f);
    def.state.inverse_inertia_world.rows[2].z = (float)(1.0 / plank_inertia);
    pli_rigid* plank = NULL;
    CHECK_OK(pli_rigid_create(world, &def, &plank));
    pli_shape_release(box);
    return plank;
}

static motion motion_of_plank(const pli_rigid* plank) {
    const pli_rigid_state state = pli_rigid_get_state(plank);
    const pli_vec3 x = state.pose.origin, v = state.linear_velocity;
    const double turns = plank_inertia * (double)state.angular_velocity.z;
    const motion sum = {
        {PLANK_MASS * (double)v.x, PLANK_MASS * (double)v.y},
        turns + PLANK_MASS * ((double)x.x * (double)v.y - (double)x.y * (double)v.x),
        0.5 * (PLANK_MASS * (double)pli_vec3_length_squared(v) + turns * (double)state.angular_velocity.z)};
    return sum;
}

/* 1 kg at 3 m/s onto 5 kg, off the middle. */
static void a_plank_that_is_hit_turns_by_the_momentum_that_it_gets(void** unused) {
    (void)unused;
    static const float steps[] = {1.0f / 30.0f, 1.0f / 60.0f, 1.0f / 144.0f};
    for (int trial = 0; trial < 3 * SOLVER_COUNT; ++trial) {
        const solver_choice solver = (solver_choice)(trial / 3);
        const float dt = steps[trial % 3];
        pli_rigid* plank = make_plank();
        pli_body* ball = make_ball(0.6f, 0.7f, 0.3f, 1, solver, 1000);
        CHECK_OK(pli_body_enable_rigid_contacts(ball, NULL));
        CHECK_OK(pli_body_add_velocity(ball, pli_vec3_make(0, -3, 0)));
        const motion start = motion_of_body(ball);
        motion now = start;
        for (float time = 0; time < 0.5f; time += dt) {
            CHECK_OK(pli_world_step(world, dt));
            CHECK_OK(pli_rigid_integrate(plank, pli_vec3_make(0, 0, 0), dt));
            now = motion_of_body(ball);
            add_motion(&now, motion_of_plank(plank));
            check_at_most(now.energy, start.energy * 1.0001);
        }
        print_message("solver %d, %.4f s: %.4f of %.4f kg m^2/s, plank %.3f rad/s\n", (int)solver, (double)dt, now.spin,
                      start.spin, (double)pli_rigid_get_state(plank).angular_velocity.z);
        check_near(now.momentum[0], start.momentum[0], 1e-3);
        check_near(now.momentum[1], start.momentum[1], 1e-3);
        check_near(now.spin, start.spin, 0.1);
        check_at_most(pli_rigid_get_state(plank).angular_velocity.z, -0.7);
        pli_body_destroy(ball);
        pli_rigid_destroy(plank);
    }
}

// ---------------------------------------------------------------------------------------------------- soft bodies

/* 1 kg each, at 2 m/s, 0.6 m off each other's line. */
static void balls_that_meet_off_centre_keep_their_angular_momentum(void** unused) {
    (void)unused;
    for (int trial = 0; trial < 2 * SOLVER_COUNT; ++trial) {
        const solver_choice solver = (solver_choice)(trial / 2);
        const float stiffness = trial % 2 == 0 ? 1e3f : 1e4f;
        pli_body* balls[2];
        motion start = {0}, now = {0};
        for (int k = 0; k < 2; ++k) {
            const float side = k == 0 ? 1 : -1;
            balls[k] = make_ball(-0.8f * side, 0.3f * side, 0.5f, 1, solver, stiffness);
            CHECK_OK(pli_body_enable_soft_contacts(balls[k], NULL));
            CHECK_OK(pli_body_add_velocity(balls[k], pli_vec3_make(2 * side, 0, 0)));
            add_motion(&start, motion_of_body(balls[k]));
        }
        for (int i = 0; i < 90; ++i) {
            CHECK_OK(pli_world_step(world, 1.0f / 60.0f));
        }
        for (int k = 0; k < 2; ++k) {
            add_motion(&now, motion_of_body(balls[k]));
            pli_body_destroy(balls[k]);
        }
        print_message("solver %d, %g N/m: %.4f of %.4f kg m^2/s, %.2f of %.2f J\n", (int)solver, (double)stiffness,
                      now.spin, start.spin, now.energy, start.energy);
        check_near(now.momentum[0], 0, 1e-3);
        check_near(now.spin, start.spin, 0.08);
        check_at_most(now.energy, 0.6 * start.energy);
    }
}

/* Under the implicit solver, whose springs would turn a body that they deform, or brake it, by k w^3 h^3. */
static void springs_do_not_turn_a_free_body(void** unused) {
    (void)unused;
    for (int trial = 0; trial < 4; ++trial) {
        pli_body* ball = make_ball(0, 0, 0.5f, 1, trial / 2 == 0 ? SWEEPS : GRADIENTS, trial % 2 == 0 ? 1e3f : 1e4f);
        pli_vec3 positions[100], velocities[100];
        const pli_body_view view = pli_body_get_view(ball);
        for (int i = 0; i < 100; ++i) {
            const pli_vec4 x = view.positions[i];
            const float half = x.x > 0 ? 1 : 0;
            positions[i] = pli_vec3_make(x.x * (1 - 0.2f * half), x.y, x.z);
            velocities[i] = pli_vec3_make(-2 * half * x.x - 3 * x.y, 2 * half * x.x + 3 * x.x, 0);
        }
        CHECK_OK(pli_body_set_state(ball, positions, velocities));
        const double start = motion_of_body(ball).spin;
        for (int i = 0; i < 600; ++i) {
            CHECK_OK(pli_world_step(world, 1.0f / 60.0f));
        }
        print_message("%s: %.5f of %.5f kg m^2/s\n", trial / 2 == 0 ? "sweeps" : "gradients", motion_of_body(ball).spin,
                      start);
        check_near(motion_of_body(ball).spin, start, 1e-3);
        pli_body_destroy(ball);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_plank_that_is_hit_turns_by_the_momentum_that_it_gets, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(balls_that_meet_off_centre_keep_their_angular_momentum, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(springs_do_not_turn_a_free_body, setup_weightless_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
