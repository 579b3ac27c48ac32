/* Self-collision under XPBD: enabled as with other solvers, before or after it; rules of the response in a substep;
   cloth in folds against a search of all pairs; all three modules. */

#include "self_cloth.h"

static void enable_xpbd(pli_body* body, int substeps, bool has_links) {
    pli_xpbd_def def = pli_xpbd_def_default();
    def.substeps = substeps;
    assert_int_equal(pli_body_enable_xpbd(body, &def), PLI_OK);
    if (!has_links) { return; }
    const pli_xpbd_links_def links = pli_xpbd_links_def_default();
    assert_int_equal(pli_body_enable_xpbd_links(body, &links), PLI_OK);
}

// ----------------------------------------------------------------------------------------------------- the response

static void test_pairs_are_parted_by_inverse_mass(void** data) {
    self_scene* scene = *data;
    const pli_vec3 rest[4] = {{0, 0, 0}, {1, 0, 0}, {0, 5, 0}, {1, 5, 0}};
    const float masses[4] = {1, 3, 0, 2};
    const pli_vec3 near[4] = {{0, 0, 0}, {0.06f, 0, 0}, {0, 5, 0}, {0.06f, 5, 0}};
    for (int order = 0; order < 2; ++order) { /* of enabling */
        pli_body* body = self_make_loose(scene, 4, rest, masses);
        const pli_self_collision_def def = self_make_def(0.1f, 0, 0);
        if (order == 0) { enable_xpbd(body, 1, false); }
        assert_int_equal(pli_body_enable_self_collision(body, &def), PLI_OK);
        if (order == 1) { enable_xpbd(body, 1, false); }
        assert_int_equal(pli_body_set_state(body, near, NULL), PLI_OK);
        self_steps(scene, 1);
        const pli_vec4* x = pli_body_get_view(body).positions;
        check_near(x[0].x, -0.03, 1e-7); /* 3/4 of 0.04 */
        check_near(x[1].x, 0.07, 1e-7);
        check_near(x[2].x, 0.0, 0.0); /* pinned */
        check_near(x[3].x, 0.1, 1e-7);
        const pli_self_collision_report report = pli_body_get_self_collision_report(body);
        assert_int_equal(report.pairs, 2);
        assert_int_equal(report.contacts, 2);
        assert_int_equal(report.searches, 1);
        pli_body_destroy(body);
    }
}

static void test_smaller_distance_at_rest_is_kept_instead(void** data) {
    self_scene* scene = *data;
    const pli_vec3 rest[3] = {{0, 0, 0}, {0.05f, 0, 0}, {0.05f, 0, 0}}, near[3] = {{0, 0, 0}, {0.02f, 0, 0}, {9, 0, 0}};
    const float masses[3] = {1, 1, 1};
    pli_body* body = self_make_loose(scene, 3, rest, masses);
    const pli_self_collision_def def = self_make_def(0.1f, 0, 0);
    assert_int_equal(pli_body_enable_self_collision(body, &def), PLI_OK);
    enable_xpbd(body, 1, false);
    self_steps(scene, 1);
    check_near(self_smallest_distance(body), 0.0, 0.0); /* as at rest: nothing happens */
    assert_int_equal(pli_body_set_state(body, near, NULL), PLI_OK);
    self_steps(scene, 1);
    const pli_body_view view = pli_body_get_view(body);
    check_near(self_distance(&view, 0, 1), 0.05, 1e-7);
}

/* Of two nodes that slide past each other, one three times as heavy: friction takes its share of the sliding once per
   substep, what parting adds is lost, momentum stays. */
static void test_friction_takes_its_share_in_each_substep(void** data) {
    self_scene* scene = *data;
    const pli_vec3 rest[2] = {{0, 0, 0}, {1, 0, 0}}, near[2] = {{0, 0, 0}, {0.09f, 0, 0}};
    const pli_vec3 velocities[2] = {{0, 0.006f, 0}, {0, -0.006f, 0}};
    const float masses[2] = {1, 3};
    for (int substeps = 1; substeps <= 4; substeps *= 4) {
        pli_body* body = self_make_loose(scene, 2, rest, masses);
        const pli_self_collision_def def = self_make_def(0.1f, 0.25f, 0);
        assert_int_equal(pli_body_enable_self_collision(body, &def), PLI_OK);
        enable_xpbd(body, substeps, false);
        assert_int_equal(pli_body_set_state(body, near, velocities), PLI_OK);
        self_steps(scene, 1);
        const pli_vec4* v = pli_body_get_view(body).velocities;
        /* Parted in the first substep; after that they touch only as far as rounding says. */
        check_near(v[0].y - v[1].y, 0.012 * 0.75, 0.012 * 1e-2);
        check_near(v[1].x - v[0].x, 0.0, 1e-4);
        check_near(pli_body_momentum(body).y, 0.006 - 0.018, 1e-7);
        check_near(pli_body_momentum(body).x, 0.0, 1e-5);
        pli_body_destroy(body);
    }
}

/* The limit is that of a substep, beside the mean: ratio * thickness * substeps / dt. */
static void test_speed_limit_is_that_of_a_substep(void** data) {
    self_scene* scene = *data;
    const pli_vec3 rest[2] = {{1, 0, 0}, {0, 0, 0}}, velocities[2] = {{50, 0, 0}, {10, 0, 0}};
    const float masses[2] = {1, 1};
    pli_body* body = self_make_loose(scene, 2, rest, masses);
    const pli_self_collision_def def = self_make_def(0.1f, 0, 0.2f);
    assert_int_equal(pli_body_enable_self_collision(body, &def), PLI_OK);
    enable_xpbd(body, 10, false);
    assert_int_equal(pli_body_set_state(body, rest, velocities), PLI_OK);
    self_steps(scene, 1);
    check_near(pli_body_get_view(body).velocities[0].x, 30 + 0.2 * 0.1 * 600, 1e-4);
    check_near(pli_body_get_view(body).velocities[1].x, 30 - 0.2 * 0.1 * 600, 1e-4);
    assert_true(pli_body_get_self_collision_report(body).limited_nodes > 0); /* of all substeps */
}

// ------------------------------------------------------------------------------------------------- cloth in folds

enum { FOLD_NODES = 24 };
static const float fold_spacing = 0.02f, fold_thickness = 0.018f;

static pli_body* make_folding_cloth(self_scene* scene) {
    self_scene_add_floor(scene);
    pli_mesh* mesh = self_sheet_mesh(scene->context, FOLD_NODES, fold_spacing, pli_vec3_make(0, 0.27f, 0), true);
    pli_body* body = self_make_body(scene, mesh, 0.01f, 0.02f);
    enable_xpbd(body, 10, true);
    return body;
}

static double fold_speed(const pli_body* body) {
    return sqrt(2.0 * (double)pli_body_kinetic_energy(body) / (double)pli_body_total_mass(body));
}

/* Smallest distance of unlinked nodes after the first second, in thicknesses. */
static double run_fold(self_scene* scene, const pli_body* body, int frames) {
    double smallest = 1e30;
    for (int frame = 0; frame < frames; ++frame) {
        self_steps(scene, 1);
        if (frame >= 60 && frame % 10 == 0) {
            smallest = fmin(smallest, self_smallest_distance(body) / (double)fold_thickness);
        }
    }
    assert_false(pli_body_is_frozen(body));
    return smallest;
}

static void test_folding_cloth_keeps_its_distance(void** data) {
    self_scene* scene = *data;
    pli_body* body = make_folding_cloth(scene);
    const pli_self_collision_def def = self_make_def(fold_thickness, 0.1f, 0.2f);
    assert_int_equal(pli_body_enable_self_collision(body, &def), PLI_OK);
    const double smallest = run_fold(scene, body, 600);
    print_message("smallest distance %.3f thicknesses, speed %.4f m/s\n", smallest, fold_speed(body));
    assert_true(smallest > 0.8);
    check_at_most(self_largest_speed(body), 0.01);
}

/* Friction that moved nodes instead of their velocities would push them into others, without end. */
static void test_full_friction_is_stable(void** data) {
    self_scene* scene = *data;
    pli_body* body = make_folding_cloth(scene);
    const pli_self_collision_def def = self_make_def(fold_thickness, 1.0f, 0.2f);
    assert_int_equal(pli_body_enable_self_collision(body, &def), PLI_OK);
    const double smallest = run_fold(scene, body, 400);
    print_message("friction 1: smallest distance %.3f thicknesses, speed %.4f m/s\n", smallest, fold_speed(body));
    assert_true(smallest > 0.5);
    check_at_most(fold_speed(body), 0.05);
}

/* The measure can fail. */
static void test_folding_cloth_without_self_collision_collapses(void** data) {
    self_scene* scene = *data;
    const pli_body* body = make_folding_cloth(scene);
    const double smallest = run_fold(scene, body, 300);
    print_message("without: smallest distance %.3f thicknesses, speed %.4f m/s\n", smallest, fold_speed(body));
    check_at_most(smallest, 0.2);
}

static void test_grids_work_after_the_step(void** data) {
    self_scene* scene = *data;
    pli_body* body = make_folding_cloth(scene);
    pli_self_grids_def def = pli_self_grids_def_default();
    def.distance = fold_thickness;
    assert_int_equal(pli_body_enable_self_grids(body, &def), PLI_OK);
    const double smallest = run_fold(scene, body, 300);
    print_message("grids: smallest distance %.3f thicknesses, speed %.4f m/s\n", smallest, fold_speed(body));
    assert_true(pli_body_get_self_grids_report(body).pairs > 0);
}

static void test_faces_do_not_cross(void** data) {
    self_scene* scene = *data;
    self_scene_add_floor(scene);
    pli_mesh* mesh = self_sheet_mesh(scene->context, 10, 0.05f, pli_vec3_make(0, 0.27f, 0), true);
    pli_body* body = self_make_body(scene, mesh, 0.01f, 0.02f);
    enable_xpbd(body, 5, true);
    pli_self_faces_def def = pli_self_faces_def_default();
    assert_int_equal(pli_body_enable_self_faces(body, &def), PLI_OK);
    int worst = 0;
    for (int i = 0; i < 200; ++i) {
        int now = 0;
        self_steps(scene, 1);
        assert_int_equal(pli_body_count_crossings(body, &now), PLI_OK);
        worst = now > worst ? now : worst;
    }
    assert_int_equal(worst, 0);
    assert_true(pli_body_get_self_faces_report(body).pairs > 0);
    assert_false(pli_body_is_frozen(body));
}

enum { TWIST_COLUMNS = 21, TWIST_ROWS = 7, TWIST_STEPS = 240 };

/* A sheet between two bars that turn by a full turn each, against each other, and come nearer. Returns the largest
   number of crossing faces. */
static int run_twist(self_scene* scene, bool has_self_collision) {
    assert_int_equal(pli_world_set_gravity(scene->world, pli_vec3_make(0, -1, 0)), PLI_OK);
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(-0.25f, 0, -0.075f);
    patch.corner_10 = pli_vec3_make(0.25f, 0, -0.075f);
    patch.corner_01 = pli_vec3_make(-0.25f, 0, 0.075f);
    patch.corner_11 = pli_vec3_make(0.25f, 0, 0.075f);
    patch.columns = TWIST_COLUMNS;
    patch.rows = TWIST_ROWS;
    patch.diagonals = true;
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(scene->context, &patch, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 0.1f), PLI_OK);
    for (int i = 0; i < 2 * TWIST_ROWS; ++i) {
        const int node = i / 2 * TWIST_COLUMNS + i % 2 * (TWIST_COLUMNS - 1);
        assert_int_equal(pli_mesh_set_node_mass(mesh, node, 0), PLI_OK);
    }
    pli_body* body = self_make_body(scene, mesh, 0.01f, 0.02f);
    enable_xpbd(body, 10, true);
    pli_self_faces_def def = pli_self_faces_def_default();
    def.thickness = 0.008f;
    if (has_self_collision) { assert_int_equal(pli_body_enable_self_faces(body, &def), PLI_OK); }
    int worst = 0;
    for (int step = 0; step < TWIST_STEPS + 30; ++step) {
        const float share = step < TWIST_STEPS ? (float)(step + 1) / (float)TWIST_STEPS : 1.0f;
        for (int i = 0; i < 2 * TWIST_ROWS; ++i) {
            const int row = i / 2, end = i % 2;
            const float angle = (end == 0 ? 1.0f : -1.0f) * 6.2831853f * share, z = 0.025f * (float)(row - 3);
            const float x = (end == 0 ? -0.25f : 0.25f) * (1.0f - 0.3f * share);
            const pli_vec3 at = pli_vec3_make(x, -z * sinf(angle), z * cosf(angle));
            assert_int_equal(pli_body_set_node_position(body, row * TWIST_COLUMNS + end * (TWIST_COLUMNS - 1), at),
                             PLI_OK);
        }
        self_steps(scene, 1);
        int now = 0;
        if (step % 5 == 0) { assert_int_equal(pli_body_count_crossings(body, &now), PLI_OK); }
        worst = now > worst ? now : worst;
    }
    assert_false(pli_body_is_frozen(body));
    return worst;
}

static void test_twisted_cloth_does_not_cross_itself(void** data) {
    assert_int_equal(run_twist(*data, true), 0);
}

static void test_twisted_cloth_without_self_collision_crosses(void** data) {
    const int worst = run_twist(*data, false);
    print_message("without: %d crossings\n", worst);
    assert_true(worst > 20);
}

static void test_solver_can_be_changed_on_the_way(void** data) {
    self_scene* scene = *data;
    pli_body* body = make_folding_cloth(scene);
    const pli_self_collision_def def = self_make_def(fold_thickness, 0.1f, 0.2f);
    assert_int_equal(pli_body_enable_self_collision(body, &def), PLI_OK);
    self_steps(scene, 60);
    assert_int_equal(pli_body_disable_xpbd(body), PLI_OK);
    self_steps(scene, 1);
    assert_true(pli_body_get_self_collision_report(body).searches > 0); /* positions have another origin now */
    self_steps(scene, 59);
    assert_true(pli_body_get_self_collision_report(body).pairs > 0);
    const pli_implicit_def implicit = pli_implicit_def_default();
    assert_int_equal(pli_body_enable_implicit(body, &implicit), PLI_OK);
    self_steps(scene, 10);
    assert_true(pli_body_get_self_collision_report(body).pairs > 0);
    assert_false(pli_body_is_frozen(body));
}

static void test_steps_repeat_bit_for_bit_without_allocation(void** unused) {
    (void)unused;
    uint64_t hashes[2];
    for (int run = 0; run < 2; ++run) {
        void* data = NULL;
        assert_int_equal(self_scene_setup(&data), 0);
        self_scene* scene = data;
        pli_body* body = make_folding_cloth(scene);
        const pli_self_collision_def def = self_make_def(fold_thickness, 0.1f, 0.2f);
        assert_int_equal(pli_body_enable_self_collision(body, &def), PLI_OK);
        self_steps(scene, 200);
        const uint64_t allocations = pli_context_allocation_count(scene->context);
        self_steps(scene, 40);
        assert_true(pli_context_allocation_count(scene->context) == allocations);
        hashes[run] = pli_body_state_hash(body);
        assert_int_equal(self_scene_teardown(&data), 0);
    }
    assert_true(hashes[0] == hashes[1]);
}

#define SELF_TEST(name) cmocka_unit_test_setup_teardown(name, self_scene_setup, self_scene_teardown)

int main(void) {
    const struct CMUnitTest tests[] = {
        SELF_TEST(test_pairs_are_parted_by_inverse_mass),
        SELF_TEST(test_smaller_distance_at_rest_is_kept_instead),
        SELF_TEST(test_friction_takes_its_share_in_each_substep),
        SELF_TEST(test_speed_limit_is_that_of_a_substep),
        SELF_TEST(test_folding_cloth_keeps_its_distance),
        SELF_TEST(test_full_friction_is_stable),
        SELF_TEST(test_folding_cloth_without_self_collision_collapses),
        SELF_TEST(test_grids_work_after_the_step),
        SELF_TEST(test_faces_do_not_cross),
        SELF_TEST(test_twisted_cloth_does_not_cross_itself),
        SELF_TEST(test_twisted_cloth_without_self_collision_crosses),
        SELF_TEST(test_solver_can_be_changed_on_the_way),
        cmocka_unit_test(test_steps_repeat_bit_for_bit_without_allocation),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
