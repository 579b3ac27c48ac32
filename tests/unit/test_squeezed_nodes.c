/* Cloth between two surfaces that nothing moves and that leave it less room than its margins take: under a ball that
   stands on the floor, and between two fingers. */

#include "solver_choice.h"

#include <math.h>

enum { SIDE = 15 };
static const float dt = 1.0f / 60.0f, margin = 0.03f;

#define CHECK_OK(call) assert_int_equal(call, PLI_OK)

/* 1 m by 1 m, 0.5 kg, level or upright. */
static pli_body* make_sheet(solver_choice solver, bool has_faces, pli_vec3 center, bool is_upright, float friction) {
    const float y = is_upright ? 0.5f : 0, z = is_upright ? 0 : 0.5f;
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_add(center, pli_vec3_make(-0.5f, -y, -z));
    patch.corner_10 = pli_vec3_add(center, pli_vec3_make(0.5f, -y, -z));
    patch.corner_01 = pli_vec3_add(center, pli_vec3_make(-0.5f, y, z));
    patch.corner_11 = pli_vec3_add(center, pli_vec3_make(0.5f, y, z));
    patch.columns = patch.rows = SIDE;
    patch.diagonals = true;
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 0.5f));
    pli_body_def def = pli_body_def_default();
    def.collision_margin = margin;
    def.solver.position_iterations = 4;
    def.solver.velocity_damping = 0.01f;
    pli_body* body = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    contacts.friction = friction;
    CHECK_OK(pli_body_enable_rigid_contacts(body, &contacts));
    if (has_faces) { CHECK_OK(pli_body_enable_rigid_face_contacts(body, NULL)); }
    use_solver(body, solver);
    return body;
}

static pli_rigid* make_surface(pli_shape* shape, pli_rigid_kind kind, pli_vec3 place) {
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = kind;
    def.shapes = &shape;
    def.shape_count = 1;
    def.state.pose.origin = place;
    pli_rigid* rigid = NULL;
    CHECK_OK(pli_rigid_create(world, &def, &rigid));
    pli_shape_release(shape);
    return rigid;
}

/* To where it is at the end of the next step. */
static void move_surface(pli_rigid* rigid, pli_vec3 to) {
    pli_rigid_state state = pli_rigid_get_state(rigid);
    state.pose.origin = pli_vec3_add(state.pose.origin, pli_vec3_scale(state.linear_velocity, dt));
    state.linear_velocity = pli_vec3_scale(pli_vec3_sub(to, state.pose.origin), 1 / dt);
    CHECK_OK(pli_rigid_set_state(rigid, &state));
}

static float fastest_of(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    float most = 0;
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 v = view.velocities[i];
        most = fmaxf(most, pli_vec3_length(pli_vec3_make(v.x, v.y, v.z)));
    }
    return most;
}

/* Three seconds, with contacts of nodes, and of faces if they are there; `speed` of the ball, m/s, `late` the fastest
 * node after the first second. */
static void lie_under_ball(solver_choice solver, bool has_faces, float speed, float* most, float* late,
                           float* stretch) {
    pli_shape *plane = NULL, *ball = NULL;
    CHECK_OK(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0, &plane));
    CHECK_OK(pli_shape_create_sphere(context, 0.5f, &ball));
    pli_rigid* floor = make_surface(plane, PLI_RIGID_STATIC, pli_vec3_make(0, 0, 0));
    pli_rigid* sliding = make_surface(ball, PLI_RIGID_KINEMATIC, pli_vec3_make(0, 0.5f, 0));
    pli_body* sheet = make_sheet(solver, has_faces, pli_vec3_make(0, margin, 0), false, 0.2f);
    *most = *late = *stretch = 0;
    for (int step = 1; step <= 180; ++step) {
        move_surface(sliding, pli_vec3_make(speed * dt * (float)step, 0.5f, 0));
        CHECK_OK(pli_world_step(world, dt));
        *most = fmaxf(*most, fastest_of(sheet));
        if (step > 60) { *late = fmaxf(*late, fastest_of(sheet)); }
        *stretch = fmaxf(*stretch, pli_body_max_stretch(sheet));
    }
    pli_body_destroy(sheet);
    pli_rigid_destroy(sliding);
    pli_rigid_destroy(floor);
}

static void cloth_rests_under_a_ball_that_stands_on_the_floor(void** unused) {
    (void)unused;
    for (int c = 0; c < 2 * SOLVER_COUNT; ++c) {
        float most, late, stretch;
        lie_under_ball((solver_choice)(c / 2), c % 2 == 1, 0, &most, &late, &stretch);
        print_message("solver %d, faces %d: %.3f m/s, then %.4f m/s, stretch %.3f\n", c / 2, c % 2, (double)most,
                      (double)late, (double)stretch);
        check_at_most(most, 0.6);
        check_at_most(late, 0.01);
        check_at_most(stretch, 0.1);
    }
}

static void a_ball_slides_over_cloth(void** unused) {
    (void)unused;
    for (int c = 0; c < 2 * SOLVER_COUNT; ++c) {
        float most, late, stretch;
        lie_under_ball((solver_choice)(c / 2), c % 2 == 1, 0.5f, &most, &late, &stretch);
        print_message("solver %d, faces %d: %.3f m/s, stretch %.3f\n", c / 2, c % 2, (double)most, (double)stretch);
        check_at_most(most, 1.2);
        check_at_most(stretch, 0.2);
    }
}

/* A capsule that touches the floor crosses it at 1.5 m/s; floor and rug have as much friction with the rug. */
static void a_rug_stays_under_a_walker(void** unused) {
    (void)unused;
    for (int c = 0; c < 4 * SOLVER_COUNT; ++c) {
        const bool has_faces = c % 2 == 1, floor_is_first = c / 2 % 2 == 0;
        pli_shape *plane = NULL, *capsule = NULL;
        CHECK_OK(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0, &plane));
        CHECK_OK(pli_shape_create_capsule(context, pli_vec3_make(0, 0.6f, 0), 0.3f, &capsule));
        pli_rigid *floor = NULL, *walker = NULL;
        if (floor_is_first) { floor = make_surface(plane, PLI_RIGID_STATIC, pli_vec3_make(0, 0, 0)); }
        walker = make_surface(capsule, PLI_RIGID_KINEMATIC, pli_vec3_make(-1.5f, 0.9f, 0.05f));
        if (!floor_is_first) { floor = make_surface(plane, PLI_RIGID_STATIC, pli_vec3_make(0, 0, 0)); }
        pli_body* rug = make_sheet((solver_choice)(c / 4), has_faces, pli_vec3_make(0, margin, 0), false, 0.5f);
        float most = 0;
        for (int step = 1; step <= 180; ++step) {
            move_surface(walker, pli_vec3_make(fminf(-1.5f + 1.5f * dt * (float)step, 1.5f), 0.9f, 0.05f));
            CHECK_OK(pli_world_step(world, dt));
            most = fmaxf(most, fastest_of(rug));
        }
        const pli_vec3 middle = middle_of(rug);
        print_message("solver %d, faces %d, floor first %d: %.2f m/s, moved by %.3f m, at last %.3f m/s\n", c / 4,
                      has_faces, floor_is_first, (double)most, (double)middle.x, (double)fastest_of(rug));
        check_at_most(most, 2);
        check_near(middle.x, 0, 0.12);
        check_at_most(fastest_of(rug), 0.01);
        pli_body_destroy(rug);
        pli_rigid_destroy(walker);
        pli_rigid_destroy(floor);
    }
}

/* Two fingers of 30 cm close on the upper part of a sheet in half a second, hold it for another half, lift it by 1.5 m
   in three seconds, and open. */
static void fingers_lift_cloth(void** unused) {
    (void)unused;
    for (int c = 0; c < 4 * SOLVER_COUNT; ++c) {
        const bool has_faces = c / 2 % 2 == 1;
        const float thickness = c % 2 == 0 ? 0.02f : 0.05f, half = 0.5f * thickness;
        pli_body* sheet = make_sheet((solver_choice)(c / 4), has_faces, pli_vec3_make(0, 1, 0), true, 1);
        pli_rigid* fingers[2];
        for (int i = 0; i < 2; ++i) {
            pli_shape* box = NULL;
            CHECK_OK(pli_shape_create_box(context, pli_vec3_make(0.15f, 0.15f, 0.05f), &box));
            fingers[i] = make_surface(box, PLI_RIGID_KINEMATIC, pli_vec3_make(0, 1.4f, i == 0 ? -0.55f : 0.55f));
            pli_rigid_set_friction(fingers[i], 1);
        }
        float before = 0, after = 0, stretch = 0, fastest = 0;
        for (int step = 1; step <= 330; ++step) {
            const float closed = fminf((float)step / 30, 1), opened = fmaxf((float)(step - 240) / 30, 0);
            const float apart = half + (0.5f - half) * (1 - closed) + 0.2f * fminf(opened, 1);
            const float height = 1.4f + 0.5f * fmaxf(fminf((float)(step - 60) * dt, 3), 0);
            for (int i = 0; i < 2; ++i) {
                move_surface(fingers[i], pli_vec3_make(0, height, (i == 0 ? -1.0f : 1.0f) * (0.05f + apart)));
            }
            CHECK_OK(pli_world_set_gravity(world, pli_vec3_make(0, step <= 35 ? 0 : -10, 0)));
            CHECK_OK(pli_world_step(world, dt));
            if (step == 60) { before = middle_of(sheet).y; }
            if (step == 240) { after = middle_of(sheet).y; }
            if (step > 240) { continue; }
            stretch = fmaxf(stretch, pli_body_max_stretch(sheet));
            fastest = fmaxf(fastest, fastest_of(sheet));
        }
        const float fallen = after - middle_of(sheet).y;
        print_message("solver %d, faces %d, %.0f cm: lifted by %.2f m, %.2f m/s, stretch %.2f, then fallen by %.2f m\n",
                      c / 4, has_faces, (double)thickness * 100, (double)(after - before), (double)fastest,
                      (double)stretch, (double)fallen);
        check_near(after - before, 1.5, 0.06);
        check_at_most(stretch, 0.8);
        check_at_most(fastest, 5.0); /* of corners that swing down */
        assert_true(fallen > 5);
        for (int i = 0; i < 2; ++i) {
            pli_rigid_destroy(fingers[i]);
        }
        pli_body_destroy(sheet);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(cloth_rests_under_a_ball_that_stands_on_the_floor, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_ball_slides_over_cloth, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_rug_stays_under_a_walker, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(fingers_lift_cloth, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
