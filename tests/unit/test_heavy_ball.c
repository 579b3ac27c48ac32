/* Heavy balls that fall on a light sheet under the position-based solver: which do not pass, how high they rise, and
   how deep they sink where tethers hold the sheet. */

#include "test_world.h"

#include <math.h>

static const float dt = 1.0f / 60.0f;

enum { SIDE = 21, NODES = SIDE * SIDE };

/* 2 m by 2 m, 1 kg, level at the height 0. */
static pli_body* make_sheet(bool has_rim) {
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_make(-1, 0, -1);
    def.corner_10 = pli_vec3_make(1, 0, -1);
    def.corner_01 = pli_vec3_make(-1, 0, 1);
    def.corner_11 = pli_vec3_make(1, 0, 1);
    def.columns = def.rows = SIDE;
    def.diagonals = true;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 1), PLI_OK);
    for (int i = 0; i < NODES; ++i) {
        const bool ends_row = i % SIDE == 0 || i % SIDE == SIDE - 1, ends_column = i < SIDE || i >= NODES - SIDE;
        const bool is_pinned = has_rim ? ends_row || ends_column : ends_row && ends_column;
        if (is_pinned) { assert_int_equal(pli_mesh_set_node_mass(mesh, i, 0), PLI_OK); }
    }
    pli_body_def body_def = pli_body_def_default();
    body_def.solver.position_iterations = 8;
    body_def.solver.velocity_damping = 0.05f;
    body_def.collision_margin = 0.02f;
    pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    contacts.friction = 1;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &body_def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_body_enable_colored_links(body), PLI_OK);
    assert_int_equal(pli_body_enable_rigid_contacts(body, &contacts), PLI_OK);
    return body;
}

static pli_rigid* make_ball(float mass) {
    const float radius = 0.3f, inertia = 0.4f * mass * radius * radius;
    pli_shape* sphere = NULL;
    assert_int_equal(pli_shape_create_sphere(context, radius, &sphere), PLI_OK);
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_DYNAMIC;
    def.state.pose.origin = pli_vec3_make(0, radius + 0.2f, 0);
    def.state.inverse_mass = 1 / mass;
    for (int i = 0; i < 3; ++i) {
        def.state.inverse_inertia_world.rows[i] =
            pli_vec3_make(i == 0 ? 1 / inertia : 0, i == 1 ? 1 / inertia : 0, i == 2 ? 1 / inertia : 0);
    }
    def.friction = 1;
    def.shape_count = 1;
    def.shapes = &sphere;
    pli_rigid* ball = NULL;
    assert_int_equal(pli_rigid_create(world, &def, &ball), PLI_OK);
    pli_shape_release(sphere);
    return ball;
}

typedef struct outcome {
    float lowest, highest; /* m, of the ball after it has met the sheet */
    bool passed;
} outcome;

static outcome drop(float mass, bool has_rim, bool has_faces, bool has_tethers) {
    pli_body* sheet = make_sheet(has_rim);
    if (has_faces) { assert_int_equal(pli_body_enable_rigid_face_contacts(sheet, NULL), PLI_OK); }
    if (has_tethers) { assert_int_equal(pli_body_enable_tethers(sheet, NULL), PLI_OK); }
    pli_rigid* ball = make_ball(mass);
    outcome result = {0, -10, false};
    for (int i = 0; i < 240; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        assert_int_equal(pli_rigid_integrate(ball, pli_vec3_make(0, -10, 0), dt), PLI_OK);
        const float height = pli_rigid_get_state(ball).pose.origin.y;
        result.lowest = fminf(result.lowest, height);
        if (i > 30) { result.highest = fmaxf(result.highest, height); }
    }
    const float sheet_low = pli_body_get_bounds(sheet).min.y;
    result.passed = !(pli_rigid_get_state(ball).pose.origin.y > sheet_low);
    pli_rigid_destroy(ball);
    pli_body_destroy(sheet);
    return result;
}

/* With contacts of faces all of them are held; nodes alone part around a ball of 5 kg. */
static void heavy_balls_do_not_pass(void** unused) {
    (void)unused;
    static const float masses[4] = {1, 2, 5, 20};
    for (int c = 0; c < 32; ++c) {
        const float mass = masses[c & 3];
        const bool has_rim = (c & 4) != 0, has_faces = (c & 8) != 0, has_tethers = (c & 16) != 0;
        if (!has_faces && mass > 2) { continue; }
        const outcome result = drop(mass, has_rim, has_faces, has_tethers);
        assert_false(result.passed);
        check_at_most(result.highest, 0.15); /* from 0.5 */
        if (has_faces && has_tethers) { check_at_most(-result.lowest, has_rim ? 0.55 : 0.8); }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(heavy_balls_do_not_pass, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
