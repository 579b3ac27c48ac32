/* A skirt on a runner whose limbs an animation moves: it runs, turns within a quarter of a second and jumps, while arms
   swing past hips and press the skirt on them. No node is thrown. */

#include "solver_choice.h"

#include <pliant/anchor.h>
#include <pliant/contact.h>
#include <pliant/tether.h>

#include <math.h>

#define CHECK_OK(call) assert_int_equal(call, PLI_OK)

enum { PELVIS, THIGHS, FOREARMS = 3, BONES = 5, COLUMNS = 32, ROWS = 16 };

typedef struct runner {
    pli_rigid* bones[BONES];
    pli_body* skirt;
} runner;

static float smooth(float t) {
    const float s = fminf(fmaxf(t, 0), 1);
    return s * s * (3 - 2 * s);
}

static pli_transform turned(float yaw, float roll, pli_vec3 origin) {
    return pli_transform_make(pli_quat_from_yaw_pitch_roll(yaw, 0, roll), origin);
}

/* At rest for half a second, then at 4 m/s, back from 2 s on, and in the air from 3 to 3.8 s. */
static void pose_bones(float time, pli_transform poses[BONES]) {
    const float run = fmaxf(time - 0.5f, 0), turn = smooth((time - 2) * 4), air = time - 3;
    const float height = air > 0 && air < 0.8f ? 1 + 4 * air - 5 * air * air : 1;
    const float swing = smooth(run * 4) * sinf(16 * run);
    const pli_vec3 place =
        pli_vec3_make(run < 0.25f ? 8 * run * run : 4 * run - 0.5f - fmaxf(8 * (time - 2), 0), height, 0);
    const pli_transform root = turned(turn * 3.14159265f, 0, place);
    poses[PELVIS] = root;
    for (int k = 0; k < 2; ++k) {
        const float side = k == 0 ? 1 : -1;
        const pli_transform hip = turned(0, side * 0.7f * swing, pli_vec3_make(0, -0.05f, side * 0.1f)),
                            elbow = turned(0, 0.4f - side * 0.6f * swing, pli_vec3_make(0, 0.2f, side * 0.23f));
        const pli_transform thigh = turned(0, 0, pli_vec3_make(0, -0.21f, 0)),
                            forearm = turned(0, 0, pli_vec3_make(0, -0.13f, 0));
        poses[THIGHS + k] = pli_transform_mul(root, pli_transform_mul(hip, thigh));
        poses[FOREARMS + k] = pli_transform_mul(root, pli_transform_mul(elbow, forearm));
    }
}

static void make_bones(runner* r) {
    static const float halves[BONES] = {0.05f, 0.21f, 0.21f, 0.13f, 0.13f},
                       radii[BONES] = {0.16f, 0.085f, 0.085f, 0.045f, 0.045f};
    pli_transform poses[BONES];
    pose_bones(0, poses);
    for (int i = 0; i < BONES; ++i) {
        pli_shape* capsule = NULL;
        CHECK_OK(pli_shape_create_capsule(context, pli_vec3_make(0, halves[i], 0), radii[i], &capsule));
        pli_rigid_def def = pli_rigid_def_default();
        def.kind = PLI_RIGID_KINEMATIC;
        def.shapes = &capsule;
        def.shape_count = 1;
        def.state.pose = poses[i];
        CHECK_OK(pli_rigid_create(world, &def, &r->bones[i]));
        pli_shape_release(capsule);
    }
}

/* 0.4 kg, from the waist, which is held, down by 0.55 m. */
static void make_skirt(runner* r, solver_choice solver) {
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create(context, &mesh));
    for (int i = 0; i < ROWS * COLUMNS; ++i) {
        const float down = (float)(i / COLUMNS) / (ROWS - 1), angle = 6.2831853f * (float)(i % COLUMNS) / COLUMNS;
        const float radius = 0.185f + 0.25f * down;
        CHECK_OK(pli_mesh_append_node(
            mesh, pli_vec3_make(radius * cosf(angle), 1.04f - 0.55f * down, radius * sinf(angle)), 1, NULL));
    }
    for (int a = 0; a < ROWS * COLUMNS; ++a) {
        const int b = a % COLUMNS == COLUMNS - 1 ? a + 1 - COLUMNS : a + 1;
        CHECK_OK(pli_mesh_append_link(mesh, a, b, 0, NULL));
        if (a / COLUMNS == ROWS - 1) { continue; }
        CHECK_OK(pli_mesh_append_link(mesh, a, a + COLUMNS, 0, NULL));
        CHECK_OK(pli_mesh_append_link(mesh, a, b + COLUMNS, 0, NULL));
        CHECK_OK(pli_mesh_append_face(mesh, a, b, b + COLUMNS, 0, NULL));
        CHECK_OK(pli_mesh_append_face(mesh, a, b + COLUMNS, a + COLUMNS, 0, NULL));
    }
    CHECK_OK(pli_mesh_set_total_mass(mesh, 0.4f));
    CHECK_OK(pli_body_create(world, mesh, NULL, &r->skirt));
    pli_mesh_destroy(mesh);
    int waist[COLUMNS];
    for (int i = 0; i < COLUMNS; ++i) {
        waist[i] = i;
    }
    CHECK_OK(pli_body_attach_nodes(r->skirt, waist, COLUMNS, r->bones[PELVIS]));
    CHECK_OK(pli_body_enable_rigid_contacts(r->skirt, NULL));
    CHECK_OK(pli_body_enable_tethers(r->skirt, NULL));
    use_solver(r->skirt, solver);
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

/* Four seconds; m/s of the fastest node, and the most that a link is stretched. */
static void run(solver_choice solver, int steps, float* speed, float* stretch) {
    const float dt = 1 / (float)steps;
    runner r = {0};
    make_bones(&r);
    make_skirt(&r, solver);
    *speed = *stretch = 0;
    for (int step = 1; step <= 4 * steps; ++step) {
        pli_transform poses[BONES];
        pose_bones((float)step * dt, poses);
        for (int i = 0; i < BONES; ++i) {
            CHECK_OK(pli_rigid_move(r.bones[i], poses[i], dt));
        }
        CHECK_OK(pli_world_step(world, dt));
        for (int i = 0; i < BONES; ++i) {
            CHECK_OK(pli_rigid_integrate(r.bones[i], pli_vec3_make(0, 0, 0), dt));
        }
        *speed = fmaxf(*speed, fastest_of(r.skirt));
        *stretch = fmaxf(*stretch, pli_body_max_stretch(r.skirt));
    }
    assert_false(pli_body_is_frozen(r.skirt));
    pli_body_destroy(r.skirt);
    for (int i = 0; i < BONES; ++i) {
        pli_rigid_destroy(r.bones[i]);
    }
}

static void limbs_that_press_the_skirt_throw_no_node(void** unused) {
    (void)unused;
    for (int c = 0; c < 2 * SOLVER_COUNT; ++c) {
        const int steps = c % 2 == 0 ? 60 : 144;
        float speed, stretch;
        run((solver_choice)(c / 2), steps, &speed, &stretch);
        print_message("solver %d, %d steps: %.1f m/s, stretch %.2f\n", c / 2, steps, (double)speed, (double)stretch);
        check_at_most(speed, 100);
        check_at_most(stretch, 13);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(limbs_that_press_the_skirt_throw_no_node, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
