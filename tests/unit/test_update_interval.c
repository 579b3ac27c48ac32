/* Update intervals: time kept, what is drawn between steps, turns, changes in the middle, snapshots, bad input. */

#include "solver_choice.h"

#include <stdlib.h>

static const float dt = 1.0f / 60.0f;

static pli_body* make_sheet(float x, int pins, solver_choice solver) {
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_make(x, 0, 0);
    def.corner_10 = pli_vec3_make(x + 1, 0, 0);
    def.corner_01 = pli_vec3_make(x, 0, 1);
    def.corner_11 = pli_vec3_make(x + 1, 0, 1);
    def.columns = def.rows = 6;
    def.pins = pins;
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
    assert_int_equal(pli_body_create(world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    use_solver(body, solver);
    return body;
}

static pli_vec3 drawn(const pli_body* body, int node, float factor) {
    pli_vec3 place;
    pli_vertex_buffer_def buffer = pli_vertex_buffer_def_default();
    buffer.vertices = &place;
    buffer.vertex_count = 1;
    buffer.stride = sizeof place;
    buffer.normal_offset = -1;
    buffer.vertex_nodes = &node;
    assert_int_equal(pli_body_write_vertices(body, &buffer, factor), PLI_OK);
    return place;
}

/* Steps change their length, and the interval changes in the middle of one. */
static void test_what_flies_evenly_is_drawn_where_it_is(void** state) {
    (void)state;
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_body* sheet = make_sheet(0, 0, (solver_choice)solver);
        assert_int_equal(pli_body_add_velocity(sheet, pli_vec3_make(3, 0, 0)), PLI_OK);
        assert_int_equal(pli_body_set_update_interval(sheet, 5), PLI_OK);
        assert_int_equal(pli_body_get_update_interval(sheet), 5);
        double time = 0;
        for (int i = 0; i < 60; ++i) {
            const float step = i % 7 == 3 ? 0.6f * dt : dt;
            if (i == 23) { assert_int_equal(pli_body_set_update_interval(sheet, 1), PLI_OK); }
            if (i == 37) { assert_int_equal(pli_body_set_update_interval(sheet, 3), PLI_OK); }
            assert_int_equal(pli_world_step(world, step), PLI_OK);
            for (int k = 0; k <= 4; ++k) {
                const float factor = 0.25f * (float)k;
                check_near((double)drawn(sheet, 0, factor).x, 3 * (time + (double)(factor * step)), 2e-5);
            }
            time += (double)step;
        }
        pli_body_destroy(sheet);
    }
}

static float greatest_drawn_motion(pli_body* body, bool changes) {
    float greatest = 0;
    pli_vec3 before = drawn(body, 35, 1);
    for (int i = 0; i < 120; ++i) {
        if (changes && i % 11 == 5) { assert_int_equal(pli_body_set_update_interval(body, 1 + i % 4), PLI_OK); }
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        const pli_vec3 present = drawn(body, 35, 1);
        greatest = fmaxf(greatest, pli_vec3_length(pli_vec3_sub(present, before)));
        before = present;
    }
    return greatest;
}

/* A sheet that falls and swings under an edge. */
static void test_changes_of_the_interval_show_no_jump(void** state) {
    (void)state;
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_body* plain = make_sheet(0, PLI_PATCH_PIN_00 | PLI_PATCH_PIN_01, (solver_choice)solver);
        const float motion = greatest_drawn_motion(plain, false);
        pli_body_destroy(plain);
        pli_body* changing = make_sheet(0, PLI_PATCH_PIN_00 | PLI_PATCH_PIN_01, (solver_choice)solver);
        check_at_most((double)greatest_drawn_motion(changing, true), 1.3 * (double)motion);
        pli_body_destroy(changing);
    }
}

/* Three of twelve bodies step in each step of the world, every one in each fourth. */
static void test_bodies_take_turns(void** state) {
    (void)state;
    pli_body* bodies[12];
    float heights[12] = {0};
    int moved[12] = {0};
    for (int i = 0; i < 12; ++i) {
        bodies[i] = make_sheet(2.0f * (float)i, 0, POSITION);
        assert_int_equal(pli_body_set_update_interval(bodies[i], 4), PLI_OK);
    }
    for (int step = 0; step < 24; ++step) {
        int moving = 0;
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        for (int i = 0; i < 12; ++i) {
            const float height = pli_body_get_view(bodies[i]).positions[0].y;
            if (height != heights[i]) {
                ++moving;
                ++moved[i];
            }
            heights[i] = height;
        }
        assert_int_equal(moving, step == 0 ? 12 : 3);
    }
    for (int i = 0; i < 12; ++i) {
        assert_in_range(moved[i], 6, 7);
    }
}

static void test_snapshots_keep_the_interval(void** state) {
    (void)state;
    pli_body* sheet = make_sheet(0, PLI_PATCH_PIN_00, POSITION);
    assert_int_equal(pli_body_set_update_interval(sheet, 4), PLI_OK);
    for (int i = 0; i < 6; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    const size_t size = pli_world_snapshot_size(world);
    void* bytes = malloc(size);
    assert_non_null(bytes);
    assert_int_equal(pli_world_save(world, bytes, size, NULL), PLI_OK);
    float heights[2][9];
    for (int run = 0; run < 2; ++run) {
        for (int i = 0; i < 9; ++i) {
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            heights[run][i] = drawn(sheet, 35, 0.5f).y;
        }
        assert_int_equal(pli_world_restore(world, bytes, size), PLI_OK);
    }
    free(bytes);
    assert_memory_equal(heights[0], heights[1], sizeof heights[0]);
    assert_true(heights[0][8] < heights[0][0] - 0.05f);
}

static void test_a_frozen_body_stands_still(void** state) {
    (void)state;
    pli_body* sheet = make_sheet(0, 0, POSITION);
    assert_int_equal(pli_body_set_update_interval(sheet, 4), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    assert_int_equal(pli_body_set_frozen(sheet, true), PLI_OK);
    const float height = pli_body_get_view(sheet).positions[0].y;
    for (int i = 0; i < 6; ++i) {
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
        check_near((double)drawn(sheet, 0, 0).y, (double)height, 0);
    }
    assert_int_equal(pli_body_set_frozen(sheet, false), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    check_at_most((double)pli_body_get_view(sheet).positions[0].y, (double)height - 1e-3);
}

/* A force that is added before each step of the world gives as much in a second, however often the body steps; nothing
   else would be the same for bodies that are far away. */
static void test_forces_give_the_same_impulse(void** state) {
    (void)state;
    enum { STEPS = 61 };
    for (int solver = 0; solver < SOLVER_COUNT; ++solver) {
        pli_body* sheet = make_sheet(0, 0, (solver_choice)solver);
        const float nodes = (float)pli_body_get_view(sheet).node_count;
        assert_int_equal(pli_body_set_update_interval(sheet, 4), PLI_OK);
        for (int i = 0; i < 4; ++i) { /* until its step begins with the next one of the world */
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
        }
        pli_vec3 before = pli_body_momentum(sheet);
        int steps = 0;
        for (int i = 0; i < STEPS; ++i) {
            assert_int_equal(pli_body_add_force(sheet, pli_vec3_make(0.5f, 0, 0)), PLI_OK);
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            const pli_vec3 after = pli_body_momentum(sheet);
            if (after.x == before.x) { continue; }
            steps = i + 1; /* what was added up to here has acted */
            before = after;
        }
        assert_true(steps > STEPS - 4);
        check_near((double)before.x, (double)(0.5f * nodes * (float)steps * dt), 1e-3 * (double)nodes);
        pli_body_destroy(sheet);
    }
}

static void test_forces_are_not_saved_up_while_frozen(void** state) {
    (void)state;
    pli_body* sheet = make_sheet(0, 0, POSITION);
    assert_int_equal(pli_body_set_frozen(sheet, true), PLI_OK);
    for (int i = 0; i < 100; ++i) {
        assert_int_equal(pli_body_add_force(sheet, pli_vec3_make(1, 0, 0)), PLI_OK);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
    assert_int_equal(pli_body_set_frozen(sheet, false), PLI_OK);
    assert_int_equal(pli_world_step(world, dt), PLI_OK);
    check_near((double)pli_vec3_length(pli_body_momentum(sheet)), 0, 1e-4);
}

static void test_bad_intervals_are_refused(void** state) {
    (void)state;
    pli_body* sheet = make_sheet(0, 0, POSITION);
    check_refused(pli_body_set_update_interval(sheet, 0), PLI_ERROR_INVALID_VALUE,
                  "steps is 0, the limits are 1 and 60");
    check_refused(pli_body_set_update_interval(sheet, 61), PLI_ERROR_INVALID_VALUE, "steps is 61");
    assert_int_equal(pli_body_set_update_interval(NULL, 1), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_get_update_interval(NULL), 1);
    assert_int_equal(pli_world_predict(world, dt), PLI_OK);
    check_refused(pli_body_set_update_interval(sheet, 2), PLI_ERROR_WRONG_STATE, "");
    assert_int_equal(pli_world_solve(world), PLI_OK);
    assert_int_equal(pli_body_get_update_interval(sheet), 1);
    /* Sixty of the longest steps would be longer than a step may be. */
    assert_int_equal(pli_body_set_update_interval(sheet, 60), PLI_OK);
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(pli_world_step(world, PLI_MAX_TIME_STEP), PLI_OK);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_what_flies_evenly_is_drawn_where_it_is, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_changes_of_the_interval_show_no_jump, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_bodies_take_turns, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_snapshots_keep_the_interval, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_a_frozen_body_stands_still, setup_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_forces_give_the_same_impulse, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(test_forces_are_not_saved_up_while_frozen, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(test_bad_intervals_are_refused, setup_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
