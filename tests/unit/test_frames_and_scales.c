/* What moves along with all there is, and what is smaller or larger by a power of two, moves as it does at rest and at
   its size. */

#include "heavy_bodies.h"
#include "solver_choice.h"

#include <math.h>

static const float dt = 1.0f / 60.0f;

typedef struct outcome {
    pli_vec3 nodes[SHEET_NODES], ball; /* from the frame that the corners hang from */
} outcome;

/* A ball drops 10 cm onto a sheet whose corners hang from a frame that flies; lengths times `scale`. */
static void run(solver_choice which, bool has_faces, int frames, pli_vec3 velocity, float scale, outcome* at) {
    pli_world_def world_def = pli_world_def_default();
    world_def.gravity = pli_vec3_scale(world_def.gravity, scale);
    CHECK_OK(pli_world_create(context, &world_def, &world));
    pli_patch_def patch = level_sheet(scale, 0, SHEET_SIDE);
    pli_mesh* mesh = NULL;
    CHECK_OK(pli_mesh_create_patch(context, &patch, &mesh));
    CHECK_OK(pli_mesh_set_total_mass(mesh, 1));
    pli_body_def def = pli_body_def_default();
    def.collision_margin = sheet_margin * scale;
    pli_body* sheet = NULL;
    CHECK_OK(pli_body_create(world, mesh, &def, &sheet));
    pli_mesh_destroy(mesh);
    CHECK_OK(pli_body_enable_rigid_contacts(sheet, NULL));
    if (has_faces) { CHECK_OK(pli_body_enable_rigid_face_contacts(sheet, NULL)); }
    use_solver(sheet, which);

    pli_rigid_def frame_def = pli_rigid_def_default();
    frame_def.kind = PLI_RIGID_KINEMATIC;
    frame_def.state.linear_velocity = velocity;
    pli_rigid* frame = NULL;
    CHECK_OK(pli_rigid_create(world, &frame_def, &frame));
    const int corners[] = {0, SHEET_SIDE - 1, SHEET_NODES - SHEET_SIDE, SHEET_NODES - 1};
    CHECK_OK(pli_body_attach_nodes(sheet, corners, 4, frame));
    pli_shape* sphere = NULL;
    CHECK_OK(pli_shape_create_sphere(context, ball_radius * scale, &sphere));
    pli_rigid* ball = make_rigid(sphere, (ball_radius + 2 * sheet_margin + 0.1f) * scale, 2);
    pli_rigid_state state = pli_rigid_get_state(ball);
    state.linear_velocity = velocity;
    for (int i = 0; i < 3; ++i) {
        state.inverse_inertia_world.rows[i] = pli_vec3_scale(state.inverse_inertia_world.rows[i], 1 / (scale * scale));
    }
    CHECK_OK(pli_rigid_set_state(ball, &state));
    CHECK_OK(pli_body_add_velocity(sheet, velocity));
    for (int i = 0; i < frames; ++i) {
        CHECK_OK(pli_world_step(world, dt));
        CHECK_OK(pli_rigid_integrate(ball, world_def.gravity, dt));
        CHECK_OK(pli_rigid_integrate(frame, pli_vec3_make(0, 0, 0), dt));
    }
    const pli_vec3 origin = pli_rigid_get_state(frame).pose.origin;
    const pli_body_view view = pli_body_get_view(sheet);
    for (int i = 0; i < SHEET_NODES; ++i) {
        const pli_vec4 x = view.positions[i];
        at->nodes[i] = pli_vec3_scale(pli_vec3_sub(pli_vec3_make(x.x, x.y, x.z), origin), 1 / scale);
    }
    at->ball = pli_vec3_scale(pli_vec3_sub(pli_rigid_get_state(ball).pose.origin, origin), 1 / scale);
    pli_world_destroy(world);
}

/* m, at most, of any node and of the ball. */
static float difference(const outcome* a, const outcome* b) {
    float most = pli_vec3_length(pli_vec3_sub(a->ball, b->ball));
    for (int i = 0; i < SHEET_NODES; ++i) {
        most = fmaxf(most, pli_vec3_length(pli_vec3_sub(a->nodes[i], b->nodes[i])));
    }
    return most;
}

static outcome reference, other;

/* Over an impact; what bounces doubles what rounding leaves with every frame. */
static void what_flies_together_moves_as_at_rest(void** unused) {
    (void)unused;
    for (int c = 0; c < 2 * SOLVER_COUNT; ++c) {
        run((solver_choice)(c / 2), c % 2 == 1, 15, pli_vec3_make(0, 0, 0), 1, &reference);
        run((solver_choice)(c / 2), c % 2 == 1, 15, pli_vec3_make(30, 10, 0), 1, &other);
        check_at_most(difference(&reference, &other), 1e-4);
    }
}

/* Contacts of faces take heavy bodies back within 2 cm, whatever their size, and so are left out. */
static void what_is_small_or_large_moves_alike(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        run((solver_choice)which, false, 60, pli_vec3_make(0, 0, 0), 1, &reference);
        for (int power = -10; power <= 2; power += 4) {
            run((solver_choice)which, false, 60, pli_vec3_make(0, 0, 0), ldexpf(1, power), &other);
            check_at_most(difference(&reference, &other), which == SWEEPS ? 1e-4 : 0);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(what_flies_together_moves_as_at_rest, setup_context, teardown_context),
        cmocka_unit_test_setup_teardown(what_is_small_or_large_moves_alike, setup_context, teardown_context),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
