/* A car drives through a curtain on tethers, which swings out of its way: 2 kg are no wall to a ton. And a curtain is
   drawn on its rings. */

#include "heavy_bodies.h"
#include "solver_choice.h"

#include <math.h>

enum { COLUMNS = 31, ROWS = 21 };
static const float dt = 1.0f / 60.0f;

/* 3 m wide, from 2.1 m down to 0.1 m, in the plane x = 0. */
static pli_body* make_curtain(solver_choice solver, bool has_faces) {
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(0, 2.1f, -1.5f);
    patch.corner_10 = pli_vec3_make(0, 2.1f, 1.5f);
    patch.corner_01 = pli_vec3_make(0, 0.1f, -1.5f);
    patch.corner_11 = pli_vec3_make(0, 0.1f, 1.5f);
    patch.columns = COLUMNS;
    patch.rows = ROWS;
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 2));
    for (int i = 0; i < COLUMNS; ++i) {
        CHECK_OK(pli_mesh_set_node_mass(mesh, i, 0));
    }
    pli_body_def def = pli_body_def_default();
    def.solver.position_iterations = 8;
    def.collision_margin = 0.02f;
    pli_body* curtain = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &curtain));
    pli_mesh_destroy(mesh);
    CHECK_OK(pli_body_enable_rigid_contacts(curtain, NULL));
    if (has_faces) { CHECK_OK(pli_body_enable_rigid_face_contacts(curtain, NULL)); }
    use_solver(curtain, solver);
    CHECK_OK(pli_body_enable_tethers(curtain, NULL));
    return curtain;
}

/* 3 m long, 1 m high, 1.6 m wide, its front 2.5 m before the curtain. */
static pli_rigid* make_car(float speed) {
    pli_shape* box = NULL;
    CHECK_OK(pli_shape_create_box(context, pli_vec3_make(1.5f, 0.5f, 0.8f), &box));
    pli_rigid* car = make_rigid(box, 0.55f, 1000);
    pli_rigid_state state = pli_rigid_get_state(car);
    state.pose.origin.x = -4;
    state.linear_velocity.x = speed;
    CHECK_OK(pli_rigid_set_state(car, &state));
    return car;
}

/* On its wheels, straight on. */
static void drive(pli_rigid* car) {
    CHECK_OK(pli_world_step(world, dt));
    CHECK_OK(pli_rigid_integrate(car, pli_vec3_make(0, 0, 0), dt));
    pli_rigid_state state = pli_rigid_get_state(car);
    state.linear_velocity = pli_vec3_make(state.linear_velocity.x, 0, 0);
    state.angular_velocity = pli_vec3_make(0, 0, 0);
    CHECK_OK(pli_rigid_set_state(car, &state));
}

/* How many times as far from the pinned edge as along the cloth. */
static float stretch_of(const pli_body* curtain) {
    const pli_vec4* x = pli_body_get_view(curtain).positions;
    float most = 0;
    for (int i = COLUMNS; i < COLUMNS * ROWS; ++i) {
        const pli_tether tether = pli_body_get_tether(curtain, i);
        const pli_vec4 a = x[i], b = x[tether.origin];
        most = fmaxf(most, pli_vec3_length(pli_vec3_make(a.x - b.x, a.y - b.y, a.z - b.z)) / tether.length);
    }
    return most;
}

static void a_curtain_is_no_wall(void** unused) {
    (void)unused;
    for (int c = 0; c < 2 * 2 * SOLVER_COUNT; ++c) {
        const float speed = c % 2 == 0 ? 3 : 10;
        pli_body* curtain = make_curtain((solver_choice)(c / 4), c / 2 % 2 == 1);
        pli_rigid* car = make_car(speed);
        float stretch = 0;
        for (float way = 0; way < 12; way += speed * dt) {
            drive(car);
            stretch = fmaxf(stretch, stretch_of(curtain));
        }
        const pli_rigid_state state = pli_rigid_get_state(car);
        print_message("solver %d, %s, %g m/s: %.2f m/s at %.1f m, stretch %.3f\n", c / 4,
                      c / 2 % 2 == 1 ? "faces" : "nodes", (double)speed, (double)state.linear_velocity.x,
                      (double)state.pose.origin.x, (double)stretch);
        check_near(state.linear_velocity.x, speed * 0.985f, speed * 0.015f);
        check_at_most(stretch, 1.2);
        pli_rigid_destroy(car);
        pli_body_destroy(curtain);
    }
}

enum { RINGS = 9, BETWEEN = 5, WIDTH = (RINGS - 1) * BETWEEN + 1, HEIGHT = 31 };

/* 2.4 m by 2.1 m and 1.5 kg in the plane z = 0, but for waves of the height from ring to ring. */
static pli_body* make_drawn_curtain(solver_choice solver, float waves) {
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(0, 2.4f, 0);
    patch.corner_10 = pli_vec3_make(2.4f, 2.4f, 0);
    patch.corner_01 = pli_vec3_make(0, 0.3f, 0);
    patch.corner_11 = pli_vec3_make(2.4f, 0.3f, 0);
    patch.columns = WIDTH;
    patch.rows = HEIGHT;
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 1.5f));
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        pli_vec3 place = pli_mesh_get_view(mesh).positions[i];
        place.z = i < WIDTH ? 0 : waves * sinf((float)(i % WIDTH) * 3.14159265f / BETWEEN);
        CHECK_OK(pli_mesh_set_node_position(mesh, i, place));
    }
    for (int k = 0; k < RINGS; ++k) {
        CHECK_OK(pli_mesh_set_node_mass(mesh, k * BETWEEN, 0));
    }
    pli_body* curtain = NULL;
    CHECK_OK(pli_body_create(world, mesh, NULL, &curtain));
    pli_mesh_destroy(mesh);
    use_solver(curtain, solver);
    CHECK_OK(pli_body_enable_tethers(curtain, NULL));
    return curtain;
}

/* Aside, to a fifth of its width, in two seconds, and back in one. m/s of the fastest node. */
static float draw(solver_choice solver, int steps, float waves) {
    pli_body* curtain = make_drawn_curtain(solver, waves);
    float fastest = 0;
    for (int step = 1; step <= 4 * steps; ++step) {
        const float time = (float)step / (float)steps;
        const float width = time < 2 ? 1 - 0.4f * time : fminf(0.2f + 0.8f * (time - 2), 1);
        for (int k = 0; k < RINGS; ++k) {
            CHECK_OK(pli_body_move_node(curtain, k * BETWEEN, pli_vec3_make(0.3f * (float)k * width, 2.4f, 0)));
        }
        CHECK_OK(pli_world_step(world, 1 / (float)steps));
        const pli_body_view view = pli_body_get_view(curtain);
        for (int i = 0; i < view.node_count; ++i) {
            const pli_vec4 v = view.velocities[i];
            fastest = fmaxf(fastest, pli_vec3_length(pli_vec3_make(v.x, v.y, v.z)));
        }
    }
    pli_body_destroy(curtain);
    return fastest;
}

/* One that is flat is folded within its plane, and thrown out of that. */
static void a_curtain_in_waves_is_drawn(void** unused) {
    (void)unused;
    for (int c = 0; c < 2 * SOLVER_COUNT; ++c) {
        const solver_choice solver = (solver_choice)(c / 2);
        const int steps = c % 2 == 0 ? 60 : 144;
        const float fastest = draw(solver, steps, 0.01f);
        print_message("solver %d, %d steps: %.1f m/s, flat %.1f\n", c / 2, steps, (double)fastest,
                      (double)draw(solver, steps, 0));
        check_at_most(fastest, 20);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_curtain_is_no_wall, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_curtain_in_waves_is_drawn, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
