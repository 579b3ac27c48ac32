/* Random sheets, many of their nodes pinned, that start inside of each other and of rigid bodies, with contacts of
   all kinds and self-collision under all solvers: what cannot be parted is not thrown away. */

#include "heavy_bodies.h"
#include "solver_choice.h"

#include <pliant/self_collision.h>
#include <pliant/tether.h>

#ifdef NDEBUG
enum { TRIALS = 400 };
#else
enum { TRIALS = 100 }; /* unoptimised programs are slow */
#endif
enum { STEPS = 60, MOST_BODIES = 2, MOST_RIGIDS = 3 };

static const float dt = 1.0f / 60.0f, gravity = 10;
static uint32_t dice;

static uint32_t roll(uint32_t sides) {
    dice = dice * 1664525u + 1013904223u;
    return (dice >> 8) % sides;
}
static float between(float least, float most) {
    return least + (most - least) * (float)roll(100000) / 100000.0f;
}

static pli_body* roll_sheet(void) {
    const float half = between(0.25f, 1), height = between(-0.05f, 0.05f);
    const float along_x = between(-0.3f, 0.3f), along_z = between(-0.3f, 0.3f);
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(-half, height - along_x, -half);
    patch.corner_10 = pli_vec3_make(half, height + along_z, -half);
    patch.corner_01 = pli_vec3_make(-half, height - along_z, half);
    patch.corner_11 = pli_vec3_make(half, height + along_x, half);
    patch.columns = patch.rows = 3 + (int)roll(8);
    patch.diagonals = roll(2) == 1;
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, between(0.1f, 2)));
    const float pinned_share = roll(3) == 0 ? 0 : between(0, 0.5f);
    for (int i = 0; i < patch.columns * patch.rows; ++i) {
        if (between(0, 1) < pinned_share) { CHECK_OK(pli_mesh_set_node_mass(mesh, i, 0)); }
    }
    pli_body_def def = pli_body_def_default();
    def.collision_margin = between(0.005f, 0.05f);
    def.solver.position_iterations = 1 + (int)roll(10);
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    use_solver(body, (solver_choice)roll(SOLVER_COUNT));
    if (roll(2) == 0) { CHECK_OK(pli_body_enable_rigid_contacts(body, NULL)); }
    if (roll(2) == 0) { CHECK_OK(pli_body_enable_rigid_face_contacts(body, NULL)); }
    if (roll(2) == 0) { CHECK_OK(pli_body_enable_soft_contacts(body, NULL)); }
    if (roll(4) == 0) { CHECK_OK(pli_body_enable_self_collision(body, NULL)); }
    if (roll(4) == 0) { CHECK_OK(pli_body_enable_tethers(body, NULL)); }
    return body;
}

static pli_rigid* roll_rigid(void) {
    const float radius = between(0.05f, 0.5f);
    pli_shape* shape = NULL;
    switch (roll(4)) {
    case 0:
        CHECK_OK(pli_shape_create_sphere(context, radius, &shape));
        break;
    case 1:
        CHECK_OK(
            pli_shape_create_box(context, pli_vec3_make(radius, between(0.02f, 0.5f), between(0.02f, 0.5f)), &shape));
        break;
    case 2:
        CHECK_OK(pli_shape_create_capsule(context, pli_vec3_make(between(0.05f, 0.5f), 0, between(0.05f, 0.3f)), radius,
                                          &shape));
        break;
    default:
        CHECK_OK(pli_shape_create_cylinder(context, pli_vec3_make(0, between(0.05f, 0.5f), between(0, 0.2f)), radius,
                                           &shape));
    }
    pli_rigid* rigid = make_rigid(shape, 0, roll(2) == 0 ? 0 : powf(10, between(-1, 2)));
    pli_rigid_state state = pli_rigid_get_state(rigid);
    state.pose.origin = pli_vec3_make(between(-1, 1), between(-0.4f, 0.4f), between(-1, 1));
    CHECK_OK(pli_rigid_set_state(rigid, &state));
    return rigid;
}

/* The host gives a body that can move its gravity, and moves it after the step. */
static void step_all(pli_rigid** rigids, int count) {
    for (int i = 0; i < count; ++i) {
        pli_rigid_state state = pli_rigid_get_state(rigids[i]);
        if (!(state.inverse_mass > 0)) { continue; }
        state.linear_velocity.y -= gravity * dt;
        CHECK_OK(pli_rigid_set_state(rigids[i], &state));
    }
    CHECK_OK(pli_world_step(world, dt));
    for (int i = 0; i < count; ++i) {
        if (!(pli_rigid_get_state(rigids[i]).inverse_mass > 0)) { continue; }
        CHECK_OK(pli_rigid_integrate(rigids[i], pli_vec3_make(0, 0, 0), dt));
    }
}

static double fastest(pli_body** bodies, int body_count, pli_rigid** rigids, int rigid_count) {
    double speed = 0;
    for (int i = 0; i < body_count; ++i) {
        const pli_body_view view = pli_body_get_view(bodies[i]);
        for (int k = 0; k < view.node_count; ++k) {
            const pli_vec4 v = view.velocities[k];
            speed = fmax(speed, (double)pli_vec3_length(pli_vec3_make(v.x, v.y, v.z)));
        }
    }
    for (int i = 0; i < rigid_count; ++i) {
        speed = fmax(speed, (double)pli_vec3_length(pli_rigid_get_state(rigids[i]).linear_velocity));
    }
    return speed;
}

/* The fastest that anything gets. */
static double run_trial(uint32_t trial) {
    dice = trial * 2654435761u;
    pli_body* bodies[MOST_BODIES];
    pli_rigid* rigids[MOST_RIGIDS];
    const int body_count = 1 + (int)roll(MOST_BODIES), rigid_count = (int)roll(MOST_RIGIDS + 1);
    for (int i = 0; i < body_count; ++i) {
        bodies[i] = roll_sheet();
        if (trial % 4 == 3) { CHECK_OK(pli_body_enable_self_faces(bodies[i], NULL)); }
    }
    for (int i = 0; i < rigid_count; ++i) {
        rigids[i] = roll_rigid();
    }
    double speed = 0;
    for (int i = 0; i < STEPS; ++i) {
        step_all(rigids, rigid_count);
        speed = fmax(speed, fastest(bodies, body_count, rigids, rigid_count));
    }
    for (int i = 0; i < body_count; ++i) {
        pli_body_destroy(bodies[i]);
    }
    for (int i = 0; i < rigid_count; ++i) {
        pli_rigid_destroy(rigids[i]);
    }
    print_message("trial %u: %.3g m/s\n", (unsigned)trial, speed);
    return speed;
}

static void test_nothing_is_thrown_away(void** unused) {
    (void)unused;
    int fast_count = 0;
    for (uint32_t trial = 0; trial < TRIALS; ++trial) {
        const double speed = run_trial(trial);
        fast_count += speed > 200;
        check_at_most(speed, 1000);
    }
    check_at_most(fast_count, 2);
}

/* Conjugate gradients that end early: what is left of the error is no friction. */
static void test_nodes_between_surfaces(void** unused) {
    (void)unused;
    check_at_most(run_trial(2205), 30);
    check_at_most(run_trial(3060), 30);
}

/* Contacts of faces that contradict each other where a body starts inside of a sheet, bit by bit. */
static void test_bodies_inside_of_pinned_sheets(void** unused) {
    (void)unused;
    check_at_most(run_trial(458), 200);
    check_at_most(run_trial(1022), 200);
    check_at_most(run_trial(940), 200);
    check_at_most(run_trial(2532), 200);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_nothing_is_thrown_away, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_nodes_between_surfaces, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_bodies_inside_of_pinned_sheets, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
