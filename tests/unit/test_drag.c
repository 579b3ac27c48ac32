/* Dragging: how far a weight pulls the spring, energy, following a goal, faces, cuts, ids, bad input. */

#include "failing_allocator.h"
#include "hanging_cape.h"
#include "level_sheet.h"

static const float gravity = 10;

static pli_drag_id begin(pli_body* body, const pli_drag_def* def) {
    pli_drag_id id = {0};
    assert_int_equal(pli_body_begin_drag(body, def, &id), PLI_OK);
    return id;
}

static pli_vec3 point_of(const pli_body* body, pli_drag_id id) {
    pli_vec3 point;
    assert_int_equal(pli_body_get_drag(body, id, &point, NULL), PLI_OK);
    return point;
}

static void step(int frames, float seconds) {
    for (int i = 0; i < frames; ++i) {
        assert_int_equal(pli_world_step(world, seconds), PLI_OK);
    }
}

/* A small sheet, which the iterations of each solver can hold. */
static pli_body* make_sheet(solver_choice which) {
    pli_patch_def def = level_sheet(0.2f, 0, 9);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 0.5f), PLI_OK);
    pli_body_def body_def = pli_body_def_default();
    body_def.solver.position_iterations = 10;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &body_def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    use_solver(body, which);
    return body;
}

static void test_a_weight_stretches_the_spring_as_it_should(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* sheet = make_sheet((solver_choice)which);
        pli_solver_settings settings = pli_body_get_solver_settings(sheet);
        settings.velocity_damping = 0.02f;
        assert_int_equal(pli_body_set_solver_settings(sheet, &settings), PLI_OK);
        pli_drag_def def = pli_drag_def_default();
        def.node = 4 * 9 + 4;
        def.stiffness = 50;
        const pli_drag_id drag = begin(sheet, &def);
        step(900, dt);
        const float sag = -point_of(sheet, drag).y;
        print_message("solver %d: 0.5 kg on 50 N/m hang %.4f m lower\n", which, (double)sag);
        check_near(sag, 0.5f * gravity / 50, 0.004);
        pli_body_destroy(sheet);
    }
}

static float energy_of(const pli_body* body, pli_drag_id drag, float stiffness) {
    const pli_body_view view = pli_body_get_view(body);
    double sum = 0;
    for (int i = 0; i < view.node_count; ++i) {
        const double mass = 1 / (double)view.positions[i].w;
        sum += mass * (0.5 * (double)pli_vec3_length_squared(xyz(view.velocities[i])) +
                       (double)gravity * (double)view.positions[i].y);
    }
    pli_vec3 point, goal;
    assert_int_equal(pli_body_get_drag(body, drag, &point, &goal), PLI_OK);
    return (float)(sum + 0.5 * (double)stiffness * (double)pli_vec3_length_squared(pli_vec3_sub(point, goal)));
}

/* Any stiffness, any step: from where it is thrown, no energy is gained. */
static void test_a_goal_that_stands_gives_no_energy(void** unused) {
    (void)unused;
    static const float stiffnesses[] = {10, 1e3f, 1e6f, 1e12f}, steps[] = {1.0f / 240, 1.0f / 60, 1.0f / 15};
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        float most = 0;
        for (int s = 0; s < 4 * 3 * 2; ++s) {
            const float seconds = steps[s % 3];
            pli_body* sheet = make_sheet((solver_choice)which);
            pli_drag_def def = pli_drag_def_default();
            def.face = 60;
            def.point = pli_vec3_make(0, 0, 0);
            def.stiffness = stiffnesses[s / 3 % 4];
            def.damping_ratio = s < 12 ? 0 : 1;
            const pli_drag_id drag = begin(sheet, &def);
            assert_int_equal(pli_body_add_velocity(sheet, pli_vec3_make(4, 1, 3)), PLI_OK);
            const float start = energy_of(sheet, drag, 0);
            for (float time = 0; time < 4; time += seconds) {
                step(1, seconds);
                /* The energy of a stiff spring is below rounding. */
                most = fmaxf(most, energy_of(sheet, drag, def.stiffness < 1e5f ? def.stiffness : 0) / start);
            }
            assert_false(pli_body_is_frozen(sheet));
            assert_true(pli_vec3_length(point_of(sheet, drag)) < 5);
            pli_body_destroy(sheet);
        }
        print_message("solver %d: at most %.4f of the energy at the start\n", which, (double)most);
        check_at_most(most, 1.0005);
    }
}

static void test_a_stiff_drag_follows_its_goal(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* sheet = make_sheet((solver_choice)which);
        pli_drag_def def = pli_drag_def_default();
        def.stiffness = 1e8f;
        def.damping_ratio = 0;
        const pli_drag_id drag = begin(sheet, &def);
        const pli_vec3 start = point_of(sheet, drag);
        float most = 0, fastest = 0;
        for (int frame = 1; frame <= 60; ++frame) {
            const pli_vec3 goal = pli_vec3_add(start, pli_vec3_make(2 * (float)frame * dt, 0, 0));
            assert_int_equal(pli_body_move_drag(sheet, drag, goal), PLI_OK);
            step(1, dt);
            most = fmaxf(most, distance(point_of(sheet, drag), goal));
            const pli_body_view view = pli_body_get_view(sheet);
            for (int i = 0; i < view.node_count; ++i) {
                fastest = fmaxf(fastest, pli_vec3_length(xyz(view.velocities[i])));
            }
        }
        print_message("solver %d: %.4f m behind at most, nodes %.1f m/s at most\n", which, (double)most,
                      (double)fastest);
        check_at_most(most, which == SWEEPS ? 0.05 : 0.03);
        check_at_most(fastest, 30);
        assert_int_equal(pli_body_end_drag(sheet, drag), PLI_OK);
        const float height = pli_body_get_view(sheet).positions[40].y;
        step(30, dt);
        assert_true(pli_body_get_view(sheet).positions[40].y < height - 0.5f); /* it falls */
        pli_body_destroy(sheet);
    }
}

static void test_the_point_of_a_face_is_held(void** unused) {
    (void)unused;
    pli_body* sheet = make_sheet(XPBD);
    pli_drag_def def = pli_drag_def_default();
    pli_ray_def ray = pli_ray_def_default();
    ray.from = pli_vec3_make(0.015f, 0.5f, 0.02f);
    ray.to = pli_vec3_make(0.015f, -0.5f, 0.02f);
    pli_ray_hit hit;
    assert_int_equal(pli_body_cast_ray(sheet, &ray, &hit), PLI_OK);
    assert_int_equal(hit.kind, PLI_FEATURE_FACE);
    const pli_vec3 middle = hit.point;
    def.face = hit.index;
    def.point = pli_vec3_add(middle, pli_vec3_make(0, 0.01f, 0)); /* the nearest point counts */
    def.stiffness = 1e9f;
    const pli_drag_id drag = begin(sheet, &def);
    check_at_most(distance(point_of(sheet, drag), middle), 1e-6);
    step(120, dt);
    check_at_most(distance(point_of(sheet, drag), middle), 1e-3);
    /* A cut parts the face; the drag stays where it is, with a node. */
    const pli_vec3 before = point_of(sheet, drag);
    int parted = 0;
    assert_int_equal(pli_body_cut_swept(sheet, pli_vec3_make(before.x, before.y - 1, before.z - 1),
                                        pli_vec3_make(before.x, before.y + 1, before.z - 1),
                                        pli_vec3_make(before.x, before.y - 1, before.z + 1),
                                        pli_vec3_make(before.x, before.y + 1, before.z + 1), &parted),
                     PLI_OK);
    assert_true(parted > 0);
    check_at_most(distance(point_of(sheet, drag), before), 1e-5);
    step(120, dt);
    check_at_most(distance(point_of(sheet, drag), middle), 0.01);
}

/* Of nodes of their own, in whatever order they began. */
static void test_the_order_of_drags_makes_no_difference(void** unused) {
    (void)unused;
    enum { NODES = 81, DRAGS = 3 };
    static const int nodes[DRAGS] = {0, 40, 77};
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_vec4 ends[2][NODES];
        for (int k = 0; k < 2; ++k) {
            pli_body* sheet = make_sheet((solver_choice)which);
            for (int i = 0; i < DRAGS; ++i) {
                pli_drag_def def = pli_drag_def_default();
                def.node = nodes[k == 0 ? i : DRAGS - 1 - i];
                def.stiffness = 100;
                begin(sheet, &def);
            }
            step(30, dt);
            memcpy(ends[k], pli_body_get_view(sheet).positions, sizeof ends[k]);
            pli_body_destroy(sheet);
        }
        assert_memory_equal(ends[0], ends[1], sizeof ends[0]);
        check_near(ends[0][0].y, -0.0167, 0.03); /* a third of the weight */
    }
}

static void test_drags_are_told_apart(void** unused) {
    (void)unused;
    pli_body* sheet = make_sheet(POSITION);
    pli_drag_def def = pli_drag_def_default();
    const pli_drag_id first = begin(sheet, &def);
    def.node = 80;
    const pli_drag_id second = begin(sheet, &def);
    step(60, dt);
    const uint64_t count = pli_context_allocation_count(context);
    assert_int_equal(pli_body_move_drag(sheet, second, pli_vec3_make(0.2f, 0.5f, 0.2f)), PLI_OK);
    step(60, dt);
    assert_true(pli_context_allocation_count(context) == count);
    assert_true(point_of(sheet, second).y > point_of(sheet, first).y + 0.2f);
    assert_int_equal(pli_body_end_drag(sheet, first), PLI_OK);
    const pli_drag_id third = begin(sheet, &def);
    assert_int_equal(third.index1, first.index1);
    check_refused(pli_body_end_drag(sheet, first), PLI_ERROR_STALE_ID, "no drag {1, 1}");
    check_refused(pli_body_move_drag(sheet, first, pli_vec3_make(0, 0, 0)), PLI_ERROR_STALE_ID, "no drag");
    assert_int_equal(pli_body_end_drag(sheet, second), PLI_OK);
    check_at_most(distance(point_of(sheet, third), xyz(pli_body_get_view(sheet).positions[80])), 1e-6);
}

static void test_bad_input_is_refused(void** unused) {
    (void)unused;
    pli_body* sheet = make_sheet(POSITION);
    pli_drag_def def = pli_drag_def_default();
    pli_drag_id id;
    const pli_status range = PLI_ERROR_INDEX_OUT_OF_RANGE, value = PLI_ERROR_INVALID_VALUE;
    check_refused(pli_body_begin_drag(sheet, NULL, &id), PLI_ERROR_NULL_ARGUMENT, "def");
    check_refused(pli_body_begin_drag(sheet, &def, NULL), PLI_ERROR_NULL_ARGUMENT, "drag is null");
    def.node = 81;
    check_refused(pli_body_begin_drag(sheet, &def, &id), range, "node 81");
    def.node = 0;
    def.face = 128;
    check_refused(pli_body_begin_drag(sheet, &def, &id), range, "face 128");
    def.face = -2;
    check_refused(pli_body_begin_drag(sheet, &def, &id), range, "face -2");
    def.face = 0;
    def.point.x = NAN;
    check_refused(pli_body_begin_drag(sheet, &def, &id), PLI_ERROR_NOT_FINITE, "point");
    def.point.x = 0;
    def.stiffness = -1;
    check_refused(pli_body_begin_drag(sheet, &def, &id), value, "stiffness");
    def.stiffness = 0;
    def.damping_ratio = 1e7f;
    check_refused(pli_body_begin_drag(sheet, &def, &id), value, "damping_ratio");
    check_refused(pli_body_end_drag(sheet, (pli_drag_id){0}), PLI_ERROR_STALE_ID, "no drag");
    def.damping_ratio = 1;
    id = begin(sheet, &def);
    check_refused(pli_body_move_drag(sheet, id, pli_vec3_make(2e6f, 0, 0)), value, "goal");
    assert_int_equal(pli_world_predict(world, dt), PLI_OK);
    check_refused(pli_body_end_drag(sheet, id), PLI_ERROR_WRONG_STATE, "between predict and solve");
    assert_int_equal(pli_world_solve(world), PLI_OK);
}

static pli_status drag_and_release(pli_context* own, void* unused) {
    (void)unused;
    pli_world* w = NULL;
    pli_mesh* mesh = NULL;
    pli_body* rope = NULL;
    pli_drag_id id;
    const pli_drag_def def = pli_drag_def_default();
    pli_status status = pli_world_create(own, NULL, &w);
    if (status == PLI_OK) {
        status = pli_mesh_create_rope(own, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 4, 0, &mesh);
    }
    if (status == PLI_OK) { status = pli_body_create(w, mesh, NULL, &rope); }
    if (status == PLI_OK) { status = pli_body_begin_drag(rope, &def, &id); }
    pli_mesh_destroy(mesh);
    pli_world_destroy(w);
    return status;
}

static void test_running_out_of_memory_leaves_nothing(void** unused) {
    (void)unused;
    assert_true(check_survives_failing_allocator(drag_and_release, NULL) > 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_a_weight_stretches_the_spring_as_it_should, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_goal_that_stands_gives_no_energy, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_stiff_drag_follows_its_goal, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_the_point_of_a_face_is_held, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_the_order_of_drags_makes_no_difference, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_drags_are_told_apart, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_bad_input_is_refused, setup_world, teardown_world),
        cmocka_unit_test(test_running_out_of_memory_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
