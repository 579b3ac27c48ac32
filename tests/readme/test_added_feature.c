/* The feature that docs/adding_a_feature.md adds, compiled from that page. */

#include "added_feature.h"
#include "unit/test_world.h"

/* A free node of 0.5 kg at (1, 0, 0) and a pinned one 1 mm beside it; links are not solved. */
static pli_body* make_body(void) {
    pli_mesh* mesh = NULL;
    pli_body* body = NULL;
    assert_int_equal(
        pli_mesh_create_rope(context, pli_vec3_make(1, 0, 0), pli_vec3_make(1, 0, 1e-3f), 0, PLI_ROPE_PIN_LAST, &mesh),
        PLI_OK);
    assert_int_equal(pli_mesh_set_node_mass(mesh, 0, 0.5f), PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.solver.position_iterations = 0;
    assert_int_equal(pli_body_create(world, mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    return body;
}

static void run(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) {
        assert_int_equal(pli_world_step(world, 1e-3f), PLI_OK);
    }
}

static void a_node_swings_with_the_period_of_mass_and_stiffness(void** unused) {
    (void)unused;
    pli_body* body = make_body();
    assert_int_equal(pli_body_enable_point_spring(body, pli_vec3_make(0, 0, 0), 2), PLI_OK);
    run(785); /* a quarter of 2 pi sqrt(0.5 / 2) s */
    const pli_body_view view = pli_body_get_view(body);
    check_near(view.positions[0].x, 0, 5e-3);
    check_near(view.velocities[0].x, -2, 5e-3);
    check_near(view.positions[1].x, 1, 0);
}

static void a_disabled_spring_does_nothing(void** unused) {
    (void)unused;
    pli_body* body = make_body();
    assert_int_equal(pli_body_enable_point_spring(body, pli_vec3_make(0, 0, 0), 2), PLI_OK);
    assert_int_equal(pli_body_disable_point_spring(body), PLI_OK);
    run(100);
    check_near(pli_body_get_view(body).positions[0].x, 1, 0);
}

static void a_snapshot_has_the_settings(void** unused) {
    (void)unused;
    pli_body* body = make_body();
    assert_int_equal(pli_body_enable_point_spring(body, pli_vec3_make(0, 0, 0), 2), PLI_OK);
    unsigned char saved[4096];
    size_t size = 0;
    assert_int_equal(pli_world_save(world, saved, sizeof saved, &size), PLI_OK);
    run(100);
    const uint64_t hash = pli_body_state_hash(body);
    assert_int_equal(pli_body_enable_point_spring(body, pli_vec3_make(0, 3, 0), 5), PLI_OK);
    assert_int_equal(pli_world_restore(world, saved, size), PLI_OK);
    run(100);
    assert_true(pli_body_state_hash(body) == hash);
}

static void a_body_that_sleeps_wakes(void** unused) {
    (void)unused;
    pli_body* body = make_body();
    assert_int_equal(pli_body_enable_sleep(body, NULL), PLI_OK);
    run(600);
    assert_true(pli_body_is_asleep(body));
    assert_int_equal(pli_body_enable_point_spring(body, pli_vec3_make(0, 0, 0), 2), PLI_OK);
    run(10);
    assert_false(pli_body_is_asleep(body));
    assert_true(pli_body_get_view(body).velocities[0].x < 0);
}

static void bad_values_are_refused(void** unused) {
    (void)unused;
    pli_body* body = make_body();
    check_refused(pli_body_enable_point_spring(body, pli_vec3_make(0, NAN, 0), 1), PLI_ERROR_NOT_FINITE, "point");
    check_refused(pli_body_enable_point_spring(body, pli_vec3_make(0, 0, 0), -1), PLI_ERROR_INVALID_VALUE, "stiffness");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_node_swings_with_the_period_of_mass_and_stiffness, setup_weightless_world,
                                        teardown_world),
        cmocka_unit_test_setup_teardown(a_disabled_spring_does_nothing, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_snapshot_has_the_settings, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(a_body_that_sleeps_wakes, setup_weightless_world, teardown_world),
        cmocka_unit_test_setup_teardown(bad_values_are_refused, setup_weightless_world, teardown_world),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
