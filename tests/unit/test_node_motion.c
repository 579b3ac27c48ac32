/* Pinned nodes that are led: where they are after each step under each solver, what hangs on them, what they cost, bad
   input. */

#include "failing_allocator.h"
#include "hanging_cape.h"

enum { FRAMES = 120 };

static pli_body* make_pinned_cape(void) {
    pli_body* body = make_cape(ROWS);
    for (int i = 0; i < COLUMNS; ++i) {
        assert_int_equal(pli_body_set_node_mass(body, i, 0), PLI_OK);
    }
    return body;
}

/* Of node i in step `frame`: along x at 6 m/s, turning about y with 20 rad/s. */
static pli_vec3 place(int i, int frame) {
    const float time = (float)frame * dt, x = -0.6f + 1.2f * (float)i / (COLUMNS - 1);
    return pli_vec3_make(6 * time + x * cosf(20 * time), 0, x * sinf(20 * time));
}

static void check_is_led(const pli_body* body, int frame) {
    const pli_body_view view = pli_body_get_view(body);
    for (int i = 0; i < COLUMNS; ++i) {
        const pli_vec3 goal = place(i, frame), before = place(i, frame - 1);
        check_near(distance(xyz(view.positions[i]), goal), 0, 0);
        check_at_most(distance(xyz(view.previous[i]), before), 1e-6);
        const pli_vec3 velocity = pli_vec3_scale(pli_vec3_sub(goal, before), 1 / dt);
        check_at_most(distance(xyz(view.velocities[i]), velocity), 1e-3);
    }
}

static void test_nodes_are_where_they_are_led_under_each_solver(void** unused) {
    (void)unused;
    for (int which = 0; which < SOLVER_COUNT; ++which) {
        pli_body* cape = make_pinned_cape();
        use_solver(cape, (solver_choice)which);
        assert_int_equal(pli_body_enable_tethers(cape, NULL), PLI_OK);
        float most = 0;
        for (int frame = 1; frame <= FRAMES; ++frame) {
            for (int i = 0; i < COLUMNS; ++i) {
                if (i % 7 == 0) { /* the last call counts */
                    assert_int_equal(pli_body_move_node(cape, i, pli_vec3_make(9, 9, 9)), PLI_OK);
                }
                assert_int_equal(pli_body_move_node(cape, i, place(i, frame)), PLI_OK);
            }
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            check_is_led(cape, frame);
            most = fmaxf(most, longest_tether(cape));
        }
        print_message("solver %d: %.2f %% longer\n", which, 100 * (double)most);
        check_at_most(most, 0.03);
        /* Nobody calls: they stay. */
        for (int k = 0; k < 3; ++k) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            const pli_body_view view = pli_body_get_view(cape);
            check_at_most(distance(xyz(view.positions[3]), place(3, FRAMES)), 1e-5);
            check_near(pli_vec3_length(xyz(view.velocities[3])), 0, 0);
        }
        pli_body_destroy(cape);
    }
}

/* A velocity that the caller gives between two steps is not taken back; a node that gets a mass falls. */
static void test_a_led_node_goes_on_as_it_is_told(void** unused) {
    (void)unused;
    pli_body* cape = make_pinned_cape();
    assert_int_equal(pli_body_move_node(cape, 0, place(0, 1)), PLI_OK);
    assert_int_equal(pli_body_move_node(cape, 1, place(1, 1)), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_int_equal(pli_body_set_node_velocity(cape, 0, pli_vec3_make(0, 3, 0)), PLI_OK);
    assert_int_equal(pli_body_move_node(cape, 1, place(1, 2)), PLI_OK);
    assert_int_equal(pli_body_set_node_mass(cape, 1, 0.1f), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    const pli_vec4* positions = pli_body_get_view(cape).positions;
    check_near(positions[0].y, 3 * dt, 1e-6);
    assert_true(distance(xyz(positions[1]), place(1, 2)) > 1e-3f);
}

static void test_led_nodes_cost_what_is_said(void** unused) {
    (void)unused;
    pli_body* cape = make_pinned_cape();
    uint64_t allocations = 0;
    for (int frame = 1; frame <= 20; ++frame) {
        for (int i = 0; i < COLUMNS; ++i) {
            assert_int_equal(pli_body_move_node(cape, i, place(i, frame)), PLI_OK);
        }
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        if (frame == 10) { allocations = pli_context_allocation_count(context); }
    }
    assert_int_equal(pli_context_allocation_count(context), allocations);
    /* A body that is called for but not stepped does not collect calls without end. */
    assert_int_equal(pli_body_set_frozen(cape, true), PLI_OK);
    for (int k = 0; k < 100000; ++k) {
        assert_int_equal(pli_body_move_node(cape, k % COLUMNS, place(k % COLUMNS, 30)), PLI_OK);
    }
    assert_true(pli_body_bytes(cape) < 2u * 28u * COLUMNS * ROWS * 2u + 300000u);
    assert_int_equal(pli_body_set_frozen(cape, false), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    check_near(distance(xyz(pli_body_get_view(cape).positions[5]), place(5, 30)), 0, 0);
}

static pli_status move_and_release(pli_context* c, void* unused) {
    (void)unused;
    pli_world* w = NULL;
    pli_mesh* mesh = NULL;
    pli_body* rope = NULL;
    pli_status status = pli_world_create(c, NULL, &w);
    if (status == PLI_OK) {
        status = pli_mesh_create_rope(c, pli_vec3_make(0, 0, 0), pli_vec3_make(5, 0, 0), 4, PLI_ROPE_PIN_FIRST, &mesh);
    }
    if (status == PLI_OK) { status = pli_body_create(w, mesh, NULL, &rope); }
    if (status == PLI_OK) { status = pli_body_move_node(rope, 0, pli_vec3_make(0, 1, 0)); }
    pli_mesh_destroy(mesh);
    pli_world_destroy(w);
    return status;
}

static void test_running_out_of_memory_leaves_nothing(void** unused) {
    (void)unused;
    assert_true(check_survives_failing_allocator(move_and_release, NULL) > 3);
}

static void test_bad_input_is_refused(void** unused) {
    (void)unused;
    pli_body* cape = make_pinned_cape();
    const pli_vec3 up = pli_vec3_make(0, 1, 0);
    assert_int_equal(pli_body_move_node(NULL, 0, up), PLI_ERROR_NULL_ARGUMENT);
    check_refused(pli_body_move_node(cape, COLUMNS * ROWS, up), PLI_ERROR_INDEX_OUT_OF_RANGE, "node 1000");
    check_refused(pli_body_move_node(cape, -1, up), PLI_ERROR_INDEX_OUT_OF_RANGE, "node -1");
    check_refused(pli_body_move_node(cape, 0, pli_vec3_make(NAN, 0, 0)), PLI_ERROR_NOT_FINITE, "position");
    check_refused(pli_body_move_node(cape, 0, pli_vec3_make(2e6f, 0, 0)), PLI_ERROR_INVALID_VALUE, "position");
    check_refused(pli_body_move_node(cape, COLUMNS, up), PLI_ERROR_INVALID_VALUE, "node 40 is not pinned");
    assert_int_equal(pli_world_predict(world, dt), PLI_OK);
    check_refused(pli_body_move_node(cape, 0, up), PLI_ERROR_WRONG_STATE, "between predict and solve");
    assert_int_equal(pli_world_solve(world), PLI_OK);
}

/* The second allocation is that of the list of motions. */
static void without_memory_no_feature_stays(void** state) {
    (void)state;
    failing_allocator allocator;
    pli_context* small = failing_context(&allocator);
    pli_world* small_world = NULL;
    pli_mesh* mesh = NULL;
    pli_body* rope = NULL;
    assert_int_equal(pli_world_create(small, NULL, &small_world), PLI_OK);
    assert_int_equal(
        pli_mesh_create_rope(small, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 0, 0), 10, PLI_ROPE_PIN_FIRST, &mesh),
        PLI_OK);
    assert_int_equal(pli_body_create(small_world, mesh, NULL, &rope), PLI_OK);
    pli_mesh_destroy(mesh);
    const int features = pli_body_get_features(rope, 0, NULL);
    int failures = 0;
    for (pli_status status = PLI_ERROR_OUT_OF_MEMORY; status != PLI_OK; ++failures) {
        assert_int_equal(pli_body_get_features(rope, 0, NULL), features);
        allocator.fail_at = failures + 1;
        status = pli_body_move_node(rope, 0, pli_vec3_make(0.1f, 0, 0));
        allocator.fail_at = 0;
        assert_true(status == PLI_OK || status == PLI_ERROR_OUT_OF_MEMORY);
    }
    assert_true(failures > 2);
    pli_world_destroy(small_world);
    pli_context_destroy(small);
    assert_int_equal(allocator.alive, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_memory_no_feature_stays),
        cmocka_unit_test_setup_teardown(test_nodes_are_where_they_are_led_under_each_solver, setup_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_a_led_node_goes_on_as_it_is_told, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_led_nodes_cost_what_is_said, setup_world, teardown_world),
        cmocka_unit_test(test_running_out_of_memory_leaves_nothing),
        cmocka_unit_test_setup_teardown(test_bad_input_is_refused, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
