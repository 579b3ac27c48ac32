/* Self-collision of nodes by two shifted grids: the response, what is a pair, what the grids see and miss. */

#include "self_cloth.h"

static pli_self_grids_def make_def(float distance, float separation) {
    pli_self_grids_def def = pli_self_grids_def_default();
    def.distance = distance;
    def.separation = separation;
    return def;
}

/* Nodes of a floating body far from each other; `links` pairs of nodes. No gravity. */
static pli_body* make_nodes(self_scene* scene, int count, const pli_vec3* positions, const float* masses,
                            const pli_vec3* velocities, int link_count, const int (*links)[2]) {
    assert_int_equal(pli_world_set_gravity(scene->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create(scene->context, &mesh), PLI_OK);
    for (int i = 0; i < count; ++i) {
        assert_int_equal(pli_mesh_append_node(mesh, positions[i], masses[i], NULL), PLI_OK);
    }
    for (int i = 0; i < link_count; ++i) {
        assert_int_equal(pli_mesh_append_link(mesh, links[i][0], links[i][1], 0, NULL), PLI_OK);
    }
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(scene->world, mesh, NULL, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_body_set_state(body, positions, velocities), PLI_OK);
    return body;
}

static void test_pair_is_put_apart_and_stops(void** data) {
    self_scene* scene = *data;
    const pli_vec3 x[2] = {{0, 0, 0}, {0.05f, 0, 0}}, v[2] = {{0.6f, 1, 0}, {-0.6f, 1, 0}};
    const float masses[2] = {1, 3};
    pli_body* body = make_nodes(scene, 2, x, masses, v, 0, NULL);
    const pli_self_grids_def def = make_def(0.1f, 0.5f);
    assert_int_equal(pli_body_enable_self_grids(body, &def), PLI_OK);
    self_steps(scene, 1);
    const pli_body_view view = pli_body_get_view(body);
    check_near(self_distance(&view, 0, 1), 0.1, 1e-7);
    assert_int_equal(pli_body_get_self_grids_report(body).pairs, 1);
    /* Momentum stays; along the pair both have the velocity of the centre of mass. */
    check_near(pli_body_momentum(body).x, -1.2, 1e-5);
    check_near(pli_body_momentum(body).y, 4.0, 1e-5);
    const double dx = (double)view.positions[1].x - (double)view.positions[0].x;
    const double dy = (double)view.positions[1].y - (double)view.positions[0].y;
    const double approach = dx * ((double)view.velocities[1].x - (double)view.velocities[0].x) +
                            dy * ((double)view.velocities[1].y - (double)view.velocities[0].y);
    check_near(approach, 0.0, 1e-6);
    /* The centre of mass moved by its velocity only. */
    check_near(0.25 * (double)view.positions[0].x + 0.75 * (double)view.positions[1].x, 0.0375 - 0.3 / 60.0, 1e-7);
}

static void test_published_separation_is_twice_the_distance(void** data) {
    self_scene* scene = *data;
    const pli_vec3 x[2] = {{0, 0, 0}, {0.05f, 0, 0}};
    const float masses[2] = {1, 1};
    pli_body* body = make_nodes(scene, 2, x, masses, NULL, 0, NULL);
    const pli_self_grids_def def = make_def(0.1f, 1);
    assert_int_equal(pli_body_enable_self_grids(body, &def), PLI_OK);
    self_steps(scene, 1);
    const pli_body_view view = pli_body_get_view(body);
    check_near(self_distance(&view, 0, 1), 0.2, 1e-7);
}

static void test_linked_pinned_and_coinciding_nodes(void** data) {
    self_scene* scene = *data;
    const pli_vec3 x[8] = {{0, 0, 0},    {0.05f, 0, 0},  /* linked */
                           {2, 0, 0},    {2.05f, 0, 0},  /* one pinned */
                           {4, 0, 0},    {4, 0, 0},      /* coinciding */
                           {6.0f, 0, 0}, {6.05f, 0, 0}}; /* both pinned */
    const float masses[8] = {1, 1, 0, 1, 1, 1, 0, 0};
    const int links[1][2] = {{0, 1}};
    pli_body* body = make_nodes(scene, 8, x, masses, NULL, 1, links);
    const pli_self_grids_def def = make_def(0.1f, 0.5f);
    assert_int_equal(pli_body_enable_self_grids(body, &def), PLI_OK);
    self_steps(scene, 1);
    const pli_body_view view = pli_body_get_view(body);
    check_near(self_distance(&view, 0, 1), 0.05, 1e-7);
    check_near(view.positions[2].x, 2.0, 0.0);
    check_near(view.positions[3].x, 2.1, 1e-6);
    check_near(self_distance(&view, 4, 5), 0.1, 1e-6);
    check_near(view.positions[6].x, 6.0, 0.0);
    check_near(view.positions[7].x, 6.05, 1e-6);
    assert_int_equal(pli_body_get_self_grids_report(body).pairs, 3);
}

/* Node 0 puts a corner of the first grid at the origin; the second has its walls at 0.05 + 0.1 k. */
static void test_pair_across_walls_of_both_grids_is_missed(void** data) {
    self_scene* scene = *data;
    const pli_vec3 x[7] = {{0, 0, 0},
                           {0.99f, 0.52f, 0.52f},
                           {1.01f, 0.52f, 0.52f}, /* across one wall of the first: seen */
                           {0.92f, 0.94f, 2.02f},
                           {0.92f, 0.96f, 2.02f}, /* across one wall of the second: seen */
                           {2.99f, 0.94f, 4.02f},
                           {3.01f, 0.96f, 4.02f}}; /* across both: missed */
    const float masses[7] = {1, 1, 1, 1, 1, 1, 1};
    pli_body* body = make_nodes(scene, 7, x, masses, NULL, 0, NULL);
    const pli_self_grids_def def = make_def(0.1f, 0.5f);
    assert_int_equal(pli_body_enable_self_grids(body, &def), PLI_OK);
    self_steps(scene, 1);
    const pli_body_view view = pli_body_get_view(body);
    check_near(self_distance(&view, 1, 2), 0.1, 1e-6);
    check_near(self_distance(&view, 3, 4), 0.1, 1e-6);
    check_near(self_distance(&view, 5, 6), sqrt(2.0) * 0.02, 1e-6);
    assert_int_equal(pli_body_get_self_grids_report(body).pairs, 2);
}

/* A sheet that has fallen edge on to the floor, after a second: pairs nearer than half the distance. */
static int count_near_after_folding(float height, bool has_grids, uint64_t* hash) {
    void* data = NULL;
    assert_int_equal(self_scene_setup(&data), 0);
    self_scene* scene = data;
    self_scene_add_floor(scene);
    pli_mesh* mesh = self_sheet_mesh(scene->context, 16, 0.03f, pli_vec3_make(0, height, 0), true);
    pli_body* body = self_make_body(scene, mesh, 0.01f, 0.05f);
    pli_implicit_def implicit = pli_implicit_def_default();
    implicit.stiffness = 200;
    assert_int_equal(pli_body_enable_implicit(body, &implicit), PLI_OK);
    const pli_self_grids_def def = make_def(0.025f, 0.5f);
    if (has_grids) { assert_int_equal(pli_body_enable_self_grids(body, &def), PLI_OK); }
    self_steps(scene, 45);
    const uint64_t allocations = pli_context_allocation_count(scene->context);
    self_steps(scene, 15);
    assert_true(!has_grids || pli_context_allocation_count(scene->context) == allocations);
    *hash = pli_body_state_hash(body);
    int near = 0;
    self_count_near(body, 0.5 * 0.025, &near);
    assert_int_equal(self_scene_teardown(&data), 0);
    return near;
}

/* With the implicit solver, as published. The grids miss pairs, so no distance is promised: a quarter as many are near
   after the first second, over several starts, from which the sheet folds differently. */
static void test_folding_implicit_cloth_spreads_and_repeats(void** unused) {
    (void)unused;
    int with_grids = 0, without = 0;
    for (int start = 0; start < 6; ++start) {
        const float height = 0.26f + 0.002f * (float)start;
        uint64_t first, second, other;
        const int near = count_near_after_folding(height, true, &first);
        assert_int_equal(count_near_after_folding(height, true, &second), near);
        assert_true(first == second);
        with_grids += near;
        without += count_near_after_folding(height, false, &other);
    }
    print_message("pairs nearer than half: %d with grids, %d without\n", with_grids, without);
    assert_true(4 * with_grids < without);
}

static void test_cut_and_misuse(void** data) {
    self_scene* scene = *data;
    assert_int_equal(pli_world_set_gravity(scene->world, pli_vec3_make(0, 0, 0)), PLI_OK);
    pli_mesh* mesh = self_sheet_mesh(scene->context, 8, 0.1f, pli_vec3_make(0, 1, 0), false);
    pli_body* body = self_make_body(scene, mesh, 0.01f, 0);
    pli_self_grids_def def = {0};
    assert_int_equal(pli_body_enable_self_grids(body, &def), PLI_ERROR_INVALID_DEF);
    def = make_def(NAN, 0.5f);
    assert_int_equal(pli_body_enable_self_grids(body, &def), PLI_ERROR_NOT_FINITE);
    def = make_def(0.01f, 0);
    assert_int_equal(pli_body_enable_self_grids(body, &def), PLI_ERROR_INVALID_VALUE);
    assert_non_null(strstr(pli_last_error(scene->context), "separation is 0, not above 0"));
    def = make_def(0.05f, 0.5f);
    assert_int_equal(pli_body_enable_self_grids(body, &def), PLI_OK);
    self_steps(scene, 1);
    int parted = 0;
    assert_int_equal(pli_body_cut_swept(body, pli_vec3_make(-1, 2, 0.04f), pli_vec3_make(-1, 0, 0.04f),
                                        pli_vec3_make(1, 2, 0.04f), pli_vec3_make(1, 0, 0.04f), &parted),
                     PLI_OK);
    assert_true(parted > 0);
    self_steps(scene, 30);
    assert_false(pli_body_is_frozen(body));
    assert_true(self_smallest_distance(body) > 0.02); /* copies of cut nodes lay in one place */
    assert_int_equal(pli_body_disable_self_grids(body), PLI_OK);
    assert_int_equal(pli_body_get_self_grids_report(body).pairs, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_pair_is_put_apart_and_stops, self_scene_setup, self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_published_separation_is_twice_the_distance, self_scene_setup,
                                        self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_linked_pinned_and_coinciding_nodes, self_scene_setup, self_scene_teardown),
        cmocka_unit_test_setup_teardown(test_pair_across_walls_of_both_grids_is_missed, self_scene_setup,
                                        self_scene_teardown),
        cmocka_unit_test(test_folding_implicit_cloth_spreads_and_repeats),
        cmocka_unit_test_setup_teardown(test_cut_and_misuse, self_scene_setup, self_scene_teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
