/* NULL in the place of a definition is the definition with its defaults. */

#include "check.h"
#include "world_fixture.h"

#include <pliant/pliant.h>

typedef pli_status enable_fn(pli_body* body, bool with_null);

#define ENABLE(feature, prefix)                                                                                        \
    static pli_status enable_##feature(pli_body* body, bool with_null) {                                               \
        const prefix##_def def = prefix##_def_default();                                                               \
        return pli_body_enable_##feature(body, with_null ? NULL : &def);                                               \
    }
ENABLE(aero, pli_aero)
ENABLE(clusters, pli_clusters)
ENABLE(cluster_contacts, pli_cluster_contacts)
ENABLE(rigid_contacts, pli_rigid_contacts)
ENABLE(rigid_face_contacts, pli_rigid_face_contacts)
ENABLE(soft_contacts, pli_soft_contacts)
ENABLE(self_collision, pli_self_collision)
ENABLE(self_grids, pli_self_grids)
ENABLE(self_faces, pli_self_faces)
ENABLE(tethers, pli_tethers)
ENABLE(implicit, pli_implicit)
ENABLE(xpbd, pli_xpbd)
ENABLE(xpbd_links, pli_xpbd_links)
ENABLE(xpbd_bending, pli_xpbd_bending)
ENABLE(xpbd_volume, pli_xpbd_volume)

/* A sheet with one pinned corner that falls on a ball, next to another one. */
static uint64_t run(enable_fn* enable, bool needs_xpbd, bool with_null, size_t* bytes) {
    pli_context* context = NULL;
    pli_world* world = NULL;
    pli_mesh* mesh = NULL;
    pli_shape* ball = NULL;
    pli_rigid* rigid = NULL;
    pli_body* bodies[2] = {NULL, NULL};
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    assert_int_equal(pli_world_create(context, NULL, &world), PLI_OK);
    pli_patch_def patch = pli_patch_def_default();
    patch.columns = patch.rows = 5;
    patch.pins = PLI_PATCH_PIN_00;
    assert_int_equal(pli_mesh_create_patch(context, &patch, &mesh), PLI_OK);
    assert_int_equal(pli_shape_create_sphere(context, 0.5f, &ball), PLI_OK);
    pli_rigid_def def = pli_rigid_def_default();
    def.state.pose.origin.y = -0.7f;
    def.shape_count = 1;
    def.shapes = &ball;
    assert_int_equal(pli_rigid_create(world, &def, &rigid), PLI_OK);
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(pli_body_create(world, mesh, NULL, &bodies[i]), PLI_OK);
        if (needs_xpbd) { assert_int_equal(pli_body_enable_xpbd(bodies[i], NULL), PLI_OK); }
        if (needs_xpbd) { assert_int_equal(pli_body_enable_rigid_contacts(bodies[i], NULL), PLI_OK); }
        if (needs_xpbd) { assert_int_equal(pli_body_enable_soft_contacts(bodies[i], NULL), PLI_OK); }
        assert_int_equal(enable(bodies[i], with_null), PLI_OK);
        pli_transform transform = pli_transform_identity();
        transform.origin.y = 0.2f * (float)i;
        assert_int_equal(pli_body_transform(bodies[i], transform), PLI_OK);
    }
    for (int i = 0; i < 10; ++i) {
        assert_int_equal(pli_world_step(world, 1.0f / 60.0f), PLI_OK);
    }
    const uint64_t hash = pli_body_state_hash(bodies[0]) * 31 + pli_body_state_hash(bodies[1]);
    *bytes = pli_body_bytes(bodies[0]);
    pli_mesh_destroy(mesh);
    pli_shape_release(ball);
    pli_world_destroy(world);
    assert_int_equal(pli_context_destroy(context), PLI_OK);
    return hash;
}

static void test_null_is_the_defaults(void** state) {
    (void)state;
    static const struct {
        enable_fn* enable;
        bool needs_xpbd;
    } features[] = {
        {enable_aero, false},
        {enable_clusters, false},
        {enable_cluster_contacts, false},
        {enable_rigid_contacts, false},
        {enable_rigid_face_contacts, false},
        {enable_soft_contacts, false},
        {enable_self_collision, false},
        {enable_self_grids, false},
        {enable_self_faces, false},
        {enable_tethers, false},
        {enable_implicit, false},
        {enable_xpbd, false},
        {enable_xpbd_links, true},
        {enable_xpbd_bending, true},
        {enable_xpbd_volume, true},
        {enable_rigid_contacts, true},
        {enable_soft_contacts, true},
    };
    for (size_t i = 0; i < sizeof features / sizeof *features; ++i) {
        size_t bytes = 0, bytes_by_null = 0;
        const uint64_t hash = run(features[i].enable, features[i].needs_xpbd, false, &bytes);
        assert_true(hash == run(features[i].enable, features[i].needs_xpbd, true, &bytes_by_null));
        assert_int_equal(bytes, bytes_by_null);
    }
}

static void test_null_samples_by_defaults(void** state) {
    const fixture* f = *state;
    const pli_vec3 points[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const int triangles[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    const pli_sampled_mesh_def def = pli_sampled_mesh_def_default();
    pli_shape *by_def = NULL, *by_null = NULL;
    assert_int_equal(pli_shape_create_sampled_mesh(f->context, 4, points, 4, triangles, &def, &by_def), PLI_OK);
    assert_int_equal(pli_shape_create_sampled_mesh(f->context, 4, points, 4, triangles, NULL, &by_null), PLI_OK);
    const pli_vec3 point = pli_vec3_make(0.3f, 0.4f, 0.5f);
    assert_true(pli_shape_distance(by_def, point, NULL) == pli_shape_distance(by_null, point, NULL));
    pli_shape_release(by_def);
    pli_shape_release(by_null);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_null_is_the_defaults),
        cmocka_unit_test_setup_teardown(test_null_samples_by_defaults, setup_fixture, teardown_fixture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
