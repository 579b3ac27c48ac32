/* Bodies whose time goes slower or faster than that of their world, and rigid bodies, which keep the world's. */

#include "level_sheet.h"
#include "solver_choice.h"

#include <math.h>

static const float dt = 1.0f / 60.0f;
static const float scales[] = {0.1f, 0.25f, 0.5f, 2};
enum { SCALES = 4, SHEET_SIDE = 11 };

/* With contacts of nodes, of faces too, or of faces alone; a bit for each. */
enum { NODES = 1, FACES = 2 };

static void use_time(pli_body* body, solver_choice solver, float scale) {
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.position_iterations = 10;
    settings.time_scale = scale;
    assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
    use_solver(body, solver);
}

/* A sheet of 1 kg around the origin at a height. */
static pli_body* make_sheet(float height, solver_choice solver, float scale, int contacts) {
    pli_mesh* mesh;
    pli_patch_def patch = level_sheet(0.5f, height, SHEET_SIDE);
    assert_int_equal(pli_mesh_create_patch(context, &patch, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 1), PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.03f;
    pli_body* body;
    assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    use_time(body, solver, scale);
    const pli_rigid_contacts_def of_nodes = pli_rigid_contacts_def_default();
    const pli_rigid_face_contacts_def of_faces = pli_rigid_face_contacts_def_default();
    if ((contacts & NODES) != 0) { assert_int_equal(pli_body_enable_rigid_contacts(body, &of_nodes), PLI_OK); }
    if ((contacts & FACES) != 0) { assert_int_equal(pli_body_enable_rigid_face_contacts(body, &of_faces), PLI_OK); }
    return body;
}

static pli_rigid* make_box(pli_rigid_kind kind, pli_vec3 half, pli_vec3 origin, float mass) {
    pli_shape* shape;
    assert_int_equal(pli_shape_create_box(context, half, &shape), PLI_OK);
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = kind;
    def.shape_count = 1;
    def.shapes = &shape;
    def.state.pose.origin = origin;
    def.state.inverse_mass = 1 / mass;
    for (int i = 0; i < 3; ++i) {
        (&def.state.inverse_inertia_world.rows[i].x)[i] = 1.5f / (mass * half.x * half.x);
    }
    pli_rigid* rigid;
    assert_int_equal(pli_rigid_create(world, &def, &rigid), PLI_OK);
    pli_shape_release(shape);
    return rigid;
}

static void set_velocity(pli_rigid* rigid, pli_vec3 velocity) {
    pli_rigid_state state = pli_rigid_get_state(rigid);
    state.linear_velocity = velocity;
    assert_int_equal(pli_rigid_set_state(rigid, &state), PLI_OK);
}

static void step_with(pli_rigid* rigid) {
    const pli_vec3 gravity =
        pli_rigid_get_kind(rigid) == PLI_RIGID_DYNAMIC ? pli_world_get_gravity(world) : pli_vec3_make(0, 0, 0);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_int_equal(pli_rigid_integrate(rigid, gravity, dt), PLI_OK);
}

/* At 2 m/s a sheet with half of the time went through the lift. */
static void test_lifts_take_sheets_along(void** unused) {
    (void)unused;
    float lowest = 1, highest = 0;
    for (int c = 0; c < SCALES * SOLVER_COUNT * 2; ++c) {
        pli_rigid* lift = make_box(PLI_RIGID_KINEMATIC, pli_vec3_make(2, 0.5f, 2), pli_vec3_make(0, -0.5f, 0), 1);
        pli_body* sheet = make_sheet(0.035f, c / SCALES % SOLVER_COUNT, scales[c % SCALES],
                                     c / SCALES / SOLVER_COUNT == 0 ? NODES : NODES | FACES);
        set_velocity(lift, pli_vec3_make(0, 2, 0));
        for (int i = 0; i < 120; ++i) {
            step_with(lift);
            const float top = pli_rigid_get_state(lift).pose.origin.y + 0.5f;
            for (int k = 0; k < SHEET_SIDE * SHEET_SIDE; ++k) {
                const float height = pli_body_get_view(sheet).positions[k].y - top;
                lowest = fminf(lowest, height);
                highest = fmaxf(highest, height);
            }
        }
        pli_body_destroy(sheet);
        pli_rigid_destroy(lift);
    }
    print_message("%.4f to %.4f m above the lift\n", (double)lowest, (double)highest);
    check_at_most(-lowest, -0.0299);
    check_at_most(highest, 0.0301);
}

/* Friction brings a sheet to the speed of a belt, which in its own time is another one. */
static void test_belts_carry_sheets(void** unused) {
    (void)unused;
    for (int c = 0; c < SOLVER_COUNT * 2; ++c) {
        pli_rigid* belt = make_box(PLI_RIGID_KINEMATIC, pli_vec3_make(20, 0.5f, 2), pli_vec3_make(0, -0.5f, 0), 1);
        pli_body* sheet = make_sheet(0.03f, c % SOLVER_COUNT, 2, c < SOLVER_COUNT ? NODES : NODES | FACES);
        set_velocity(belt, pli_vec3_make(1, 0, 0));
        float before = 0;
        for (int i = 0; i < 120; ++i) {
            if (i == 60) { before = middle_of(sheet).x; }
            step_with(belt);
        }
        check_near(middle_of(sheet).x - before, 1, 2e-3);
        pli_body_destroy(sheet);
        pli_rigid_destroy(belt);
    }
}

/* J, with that of its height. */
static float energy_of(const pli_rigid* rigid, float mass) {
    const pli_rigid_state state = pli_rigid_get_state(rigid);
    const float speed = pli_vec3_length(state.linear_velocity);
    return 0.5f * mass * speed * speed + mass * 10 * state.pose.origin.y;
}

/* J, the most that a box of 5 kg that falls onto a sheet held at its rim has above what it began with. */
static float energy_gained_on_sheet(solver_choice solver, float scale, int contacts) {
    const float mass = 5, height = 0.3f;
    pli_body* sheet = make_sheet(0, solver, scale, contacts);
    for (int k = 0; k < SHEET_SIDE * SHEET_SIDE; ++k) {
        const int column = k % SHEET_SIDE, row = k / SHEET_SIDE, end = SHEET_SIDE - 1;
        if (column != 0 && column != end && row != 0 && row != end) { continue; }
        assert_int_equal(pli_body_set_node_mass(sheet, k, 0), PLI_OK);
    }
    pli_rigid* box = make_box(PLI_RIGID_DYNAMIC, pli_vec3_make(0.2f, 0.2f, 0.2f), pli_vec3_make(0, height, 0), mass);
    float gained = -INFINITY;
    for (int i = 0; i < 240; ++i) {
        step_with(box);
        gained = fmaxf(gained, energy_of(box, mass) - mass * 10 * height);
    }
    pli_rigid_destroy(box);
    pli_body_destroy(sheet);
    return gained;
}

/* At a tenth of the time one got 1650 J from contacts of nodes and faces. */
static void test_boxes_get_no_energy_from_sheets(void** unused) {
    (void)unused;
    float most = -INFINITY;
    for (int c = 0; c < SCALES * SOLVER_COUNT * 2; ++c) {
        const float gained = energy_gained_on_sheet(c / SCALES % SOLVER_COUNT, scales[c % SCALES],
                                                    c / SCALES / SOLVER_COUNT == 0 ? FACES : NODES | FACES);
        most = fmaxf(most, gained);
    }
    print_message("%.3f J\n", (double)most);
    check_at_most(most, 0);
}

/* J, the most above what a load of 5 kg began with, on a rope of 0.5 kg that lies level. */
static float energy_gained_on_rope(solver_choice solver, float scale) {
    const float mass = 5;
    pli_mesh* mesh;
    pli_body* rope;
    assert_int_equal(pli_mesh_create_rope(context, pli_vec3_make(0, 0, 0), pli_vec3_make(2, 0, 0), 9, 0, &mesh),
                     PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 0.5f), PLI_OK);
    assert_int_equal(pli_body_create(world, mesh, NULL, &rope), PLI_OK);
    pli_mesh_destroy(mesh);
    use_time(rope, solver, scale);
    pli_rigid* load = make_box(PLI_RIGID_DYNAMIC, pli_vec3_make(0.2f, 0.2f, 0.2f), pli_vec3_make(2, 0, 0), mass);
    pli_anchor_def anchor = pli_anchor_def_default();
    anchor.node = 10;
    anchor.rigid = load;
    assert_int_equal(pli_body_set_node_mass(rope, 0, 0), PLI_OK);
    assert_int_equal(pli_body_add_anchor(rope, &anchor, NULL), PLI_OK);
    float gained = -INFINITY;
    for (int i = 0; i < 300; ++i) {
        step_with(load);
        gained = fmaxf(gained, energy_of(load, mass));
    }
    pli_rigid_destroy(load);
    pli_body_destroy(rope);
    return gained;
}

/* Up to 285 J at a quarter of the time, where the way down gives 100 J. */
static void test_loads_on_ropes_get_no_energy(void** unused) {
    (void)unused;
    float most = -INFINITY;
    for (int c = 0; c < 3 * SOLVER_COUNT; ++c) {
        most = fmaxf(most, energy_gained_on_rope(c / 3, scales[c % 3]));
    }
    print_message("%.3f J\n", (double)most);
    check_at_most(most, 0);
}

/* m/s of the world, of a node that an anchor has brought to 3 m/s and let go. */
static void test_nodes_keep_the_speed_of_their_anchors(void** unused) {
    (void)unused;
    assert_int_equal(pli_world_set_gravity(world, pli_vec3_make(0, 0, 0)), PLI_OK);
    for (int c = 0; c < SCALES * SOLVER_COUNT; ++c) {
        pli_rigid* carrier = make_box(PLI_RIGID_KINEMATIC, pli_vec3_make(0.1f, 0.1f, 0.1f), pli_vec3_make(0, 0, 0), 1);
        pli_body* sheet = make_sheet(0, c / SCALES, scales[c % SCALES], 0);
        pli_anchor_id id[SHEET_SIDE * SHEET_SIDE];
        pli_anchor_def anchor = pli_anchor_def_default();
        anchor.rigid = carrier;
        for (int k = 0; k < SHEET_SIDE * SHEET_SIDE; ++k) {
            anchor.node = k;
            assert_int_equal(pli_body_add_anchor(sheet, &anchor, &id[k]), PLI_OK);
        }
        set_velocity(carrier, pli_vec3_make(3, 0, 0));
        for (int i = 0; i < 10; ++i) {
            step_with(carrier);
        }
        for (int k = 0; k < SHEET_SIDE * SHEET_SIDE; ++k) {
            assert_int_equal(pli_body_remove_anchor(sheet, id[k]), PLI_OK);
        }
        const float before = middle_of(sheet).x;
        for (int i = 0; i < 10; ++i) {
            step_with(carrier);
        }
        check_near(middle_of(sheet).x - before, 0.5, 1e-3);
        pli_body_destroy(sheet);
        pli_rigid_destroy(carrier);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_lifts_take_sheets_along, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_belts_carry_sheets, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_boxes_get_no_energy_from_sheets, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_loads_on_ropes_get_no_energy, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_nodes_keep_the_speed_of_their_anchors, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
