/* Ray casts: places, normals and nearest nodes of hits on nodes, links, faces and tetrahedra; several parts; errors. */

#include "check.h"

#include <pliant/generate.h>
#include <pliant/query.h>
#include <pliant/world.h>

#include <stdlib.h>
#include <string.h>

typedef struct fixture {
    pli_context* context;
    pli_world* world;
    pli_mesh* mesh;
} fixture;

static int setup(void** state) {
    fixture* f = calloc(1, sizeof *f);
    if (f == NULL || pli_context_create(NULL, &f->context) != PLI_OK) { return -1; }
    *state = f;
    return pli_world_create(f->context, NULL, &f->world) == PLI_OK && pli_mesh_create(f->context, &f->mesh) == PLI_OK
               ? 0
               : -1;
}

static int teardown(void** state) {
    fixture* f = *state;
    pli_mesh_destroy(f->mesh);
    pli_world_destroy(f->world);
    const size_t left = pli_context_allocated_bytes(f->context);
    pli_context_destroy(f->context);
    free(f);
    return left == 0 ? 0 : -1;
}

static int add_node(fixture* f, float x, float y, float z) {
    int node = 0;
    assert_int_equal(pli_mesh_append_node(f->mesh, pli_vec3_make(x, y, z), 1.0f, &node), PLI_OK);
    return node;
}

static pli_body* make_body(fixture* f) {
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(f->world, f->mesh, NULL, &body), PLI_OK);
    return body;
}

static pli_ray_hit cast(const pli_body* body, pli_vec3 from, pli_vec3 to, int targets, float radius) {
    pli_ray_def def = pli_ray_def_default();
    def.from = from;
    def.to = to;
    def.targets = targets;
    def.radius = radius;
    pli_ray_hit hit;
    assert_int_equal(pli_body_cast_ray(body, &def, &hit), PLI_OK);
    return hit;
}

static void check_vector(pli_vec3 actual, float x, float y, float z, double tolerance) {
    check_near(actual.x, x, tolerance);
    check_near(actual.y, y, tolerance);
    check_near(actual.z, z, tolerance);
}

static void test_face_is_hit_from_both_sides(void** state) {
    fixture* f = *state;
    add_node(f, 0, 0, 0);
    add_node(f, 1, 0, 0);
    add_node(f, 0, 0, 1);
    assert_int_equal(pli_mesh_append_face(f->mesh, 0, 1, 2, 0, NULL), PLI_OK);
    const pli_body* body = make_body(f);
    pli_ray_hit hit = cast(body, pli_vec3_make(0.7f, 1, 0.1f), pli_vec3_make(0.7f, -3, 0.1f), PLI_RAY_FACES, 0.0f);
    assert_int_equal(hit.kind, PLI_FEATURE_FACE);
    assert_int_equal(hit.index, 0);
    assert_int_equal(hit.nearest_node, 1);
    check_near(hit.fraction, 0.25, 1e-7);
    check_vector(hit.point, 0.7f, 0, 0.1f, 1e-6);
    check_vector(hit.normal, 0, 1, 0, 1e-7);
    hit = cast(body, pli_vec3_make(0.1f, -1, 0.6f), pli_vec3_make(0.1f, 1, 0.6f), PLI_RAY_FACES, 0.0f);
    assert_int_equal(hit.kind, PLI_FEATURE_FACE);
    assert_int_equal(hit.nearest_node, 2);
    check_vector(hit.normal, 0, -1, 0, 1e-7);

    /* Too short, beside it, along it. */
    hit = cast(body, pli_vec3_make(0.1f, 1, 0.1f), pli_vec3_make(0.1f, 0.1f, 0.1f), PLI_RAY_FACES, 0.0f);
    assert_int_equal(hit.kind, PLI_FEATURE_NONE);
    assert_int_equal(hit.index, PLI_NULL_INDEX);
    assert_int_equal(hit.nearest_node, PLI_NULL_INDEX);
    check_near(hit.fraction, 1.0, 0.0);
    hit = cast(body, pli_vec3_make(0.7f, 1, 0.7f), pli_vec3_make(0.7f, -1, 0.7f), PLI_RAY_FACES, 0.0f);
    assert_int_equal(hit.kind, PLI_FEATURE_NONE);
    hit = cast(body, pli_vec3_make(-1, 0, 0.2f), pli_vec3_make(2, 0, 0.2f), PLI_RAY_FACES, 0.0f);
    assert_int_equal(hit.kind, PLI_FEATURE_NONE);
    /* Not asked for. */
    hit = cast(body, pli_vec3_make(0.2f, 1, 0.2f), pli_vec3_make(0.2f, -1, 0.2f), PLI_RAY_TETRAS, 0.0f);
    assert_int_equal(hit.kind, PLI_FEATURE_NONE);
}

/* Cells of 5 mm, here and a kilometre away: each ray meets the face that is there, and none beside the sheet. */
static void test_small_faces_are_hit_where_they_are(void** state) {
    fixture* f = *state;
    enum { CELLS = 60 };
    const float cell = 0.005f, size = cell * CELLS;
    for (int k = 0; k < 2; ++k) {
        const float x = 1000.0f * (float)k;
        pli_patch_def def = pli_patch_def_default();
        def.corner_00 = pli_vec3_make(x, 0, 0);
        def.corner_10 = pli_vec3_make(x + size, 0, 0);
        def.corner_01 = pli_vec3_make(x, 0, size);
        def.corner_11 = pli_vec3_make(x + size, 0, size);
        def.columns = def.rows = CELLS + 1;
        pli_mesh* mesh = NULL;
        pli_body* body = NULL;
        assert_int_equal(pli_mesh_create_patch(f->context, &def, &mesh), PLI_OK);
        assert_int_equal(pli_body_create(f->world, mesh, NULL, &body), PLI_OK);
        pli_mesh_destroy(mesh);
        const int* faces = pli_body_get_view(body).face_nodes;
        for (int i = 0; i < 400; ++i) {
            /* Oblique; through the middles of all kinds of cells, edges and nodes, and beyond the rim. */
            const float across = 0.0025f * (float)(i % 20 * 7), along = 0.0025f * (float)(i / 20 * 7);
            const pli_vec3 at = pli_vec3_make(x + across, 0, along), way = pli_vec3_make(0.2f, -3, -0.1f);
            const pli_ray_hit hit =
                cast(body, pli_vec3_sub(at, way), pli_vec3_add(at, way), PLI_RAY_FACES | PLI_RAY_TETRAS, 0);
            const float rim = 0.0005f;
            if (across > size + rim || along > size + rim) { assert_int_equal(hit.kind, PLI_FEATURE_NONE); }
            if (across < rim || along < rim || across > size - rim || along > size - rim) { continue; }
            assert_int_equal(hit.kind, PLI_FEATURE_FACE);
            check_vector(hit.point, at.x, 0, at.z, 2e-4);
            for (int corner = 0; corner < 3; ++corner) {
                const pli_vec4 p = pli_body_get_view(body).positions[faces[3 * hit.index + corner]];
                check_at_most(fabsf(p.x - at.x), cell + rim);
                check_at_most(fabsf(p.z - at.z), cell + rim);
            }
        }
        pli_body_destroy(body);
    }
}

static void test_node_is_a_sphere(void** state) {
    fixture* f = *state;
    add_node(f, 5, 0, 0);
    add_node(f, 0, 0, 0);
    const pli_body* body = make_body(f);
    pli_ray_hit hit = cast(body, pli_vec3_make(-1, 0.3f, 0), pli_vec3_make(1, 0.3f, 0), PLI_RAY_NODES, 0.5f);
    assert_int_equal(hit.kind, PLI_FEATURE_NODE);
    assert_int_equal(hit.index, 1);
    assert_int_equal(hit.nearest_node, 1);
    check_near(hit.fraction, 0.3, 1e-6); /* x = -0.4 */
    check_vector(hit.normal, -0.8f, 0.6f, 0, 1e-6);
    hit = cast(body, pli_vec3_make(-1, 0.6f, 0), pli_vec3_make(1, 0.6f, 0), PLI_RAY_NODES, 0.5f);
    assert_int_equal(hit.kind, PLI_FEATURE_NONE);
    /* Without a radius nothing is hit; nor is what the ray starts in. */
    hit = cast(body, pli_vec3_make(-1, 0, 0), pli_vec3_make(1, 0, 0), PLI_RAY_NODES | PLI_RAY_LINKS, 0.0f);
    assert_int_equal(hit.kind, PLI_FEATURE_NONE);
    hit = cast(body, pli_vec3_make(0.1f, 0, 0), pli_vec3_make(9, 0, 0), PLI_RAY_NODES, 0.5f);
    assert_int_equal(hit.index, 0);
}

static void test_thin_link_is_found_far_away(void** state) {
    fixture* f = *state;
    add_node(f, 0, 0, -1);
    add_node(f, 0, 0, 2);
    assert_int_equal(pli_mesh_append_link(f->mesh, 0, 1, 0, NULL), PLI_OK);
    const pli_body* body = make_body(f);
    /* A tube of 1 mm at 100 m, 0.5 mm off the axis. */
    pli_ray_hit hit =
        cast(body, pli_vec3_make(-100, 0.0005f, 1.2f), pli_vec3_make(100, 0.0005f, 1.2f), PLI_RAY_LINKS, 0.001f);
    assert_int_equal(hit.kind, PLI_FEATURE_LINK);
    assert_int_equal(hit.index, 0);
    assert_int_equal(hit.nearest_node, 1);
    check_near(hit.fraction, 0.5, 1e-5);
    check_vector(hit.normal, -0.8660254f, 0.5f, 0, 1e-4);
    hit = cast(body, pli_vec3_make(-100, 0.0015f, 1.2f), pli_vec3_make(100, 0.0015f, 1.2f), PLI_RAY_LINKS, 0.001f);
    assert_int_equal(hit.kind, PLI_FEATURE_NONE);
    /* Along the axis the round end is met. */
    hit = cast(body, pli_vec3_make(0, 0, -11), pli_vec3_make(0, 0, 9), PLI_RAY_LINKS, 0.5f);
    check_near(hit.fraction, 9.5 / 20.0, 1e-7);
    check_vector(hit.normal, 0, 0, -1, 1e-7);
    assert_int_equal(hit.nearest_node, 0);
    /* From inside. */
    hit = cast(body, pli_vec3_make(0.1f, 0, 1), pli_vec3_make(4, 0, 1), PLI_RAY_LINKS, 0.5f);
    assert_int_equal(hit.kind, PLI_FEATURE_NONE);
}

static void test_nearest_of_all_kinds_wins(void** state) {
    fixture* f = *state;
    for (int i = 0; i < 4; ++i) { /* a tetrahedron at x = 2 .. 3, in a part of its own */
        add_node(f, i == 3 ? 3.0f : 2.0f, i == 0 ? 1.0f : -1.0f, i == 1 ? 1.0f : i == 2 ? -1.0f : 0.0f);
    }
    assert_int_equal(pli_mesh_append_tetra(f->mesh, 0, 1, 2, 3, 0, NULL), PLI_OK);
    add_node(f, 1, 1, 0); /* a face at x = 1 */
    add_node(f, 1, -1, 1);
    add_node(f, 1, -1, -1);
    assert_int_equal(pli_mesh_append_face(f->mesh, 4, 5, 6, 0, NULL), PLI_OK);
    add_node(f, 0, -1, 0); /* a link at x = 0 */
    add_node(f, 0, 1, 0);
    assert_int_equal(pli_mesh_append_link(f->mesh, 7, 8, 0, NULL), PLI_OK);
    add_node(f, -1, -0.1f, 0);
    const pli_body* body = make_body(f);
    const pli_vec3 from = pli_vec3_make(-2, -0.1f, 0), to = pli_vec3_make(4, -0.1f, 0);
    const int all = PLI_RAY_NODES | PLI_RAY_LINKS | PLI_RAY_FACES | PLI_RAY_TETRAS;
    assert_int_equal(cast(body, from, to, all, 0.1f).kind, PLI_FEATURE_NODE);
    assert_int_equal(cast(body, from, to, all & ~PLI_RAY_NODES, 0.1f).kind, PLI_FEATURE_LINK);
    assert_int_equal(cast(body, from, to, PLI_RAY_FACES | PLI_RAY_TETRAS, 0.1f).kind, PLI_FEATURE_FACE);
    assert_int_equal(cast(body, from, to, PLI_RAY_TETRAS, 0.1f).kind, PLI_FEATURE_TETRA);
    assert_int_equal(cast(body, to, from, all, 0.1f).kind, PLI_FEATURE_TETRA);
}

static void check_refused(const fixture* f, const pli_body* body, const pli_ray_def* def, pli_status status,
                          const char* words) {
    pli_ray_hit hit = {.index = 77};
    assert_int_equal(pli_body_cast_ray(body, def, &hit), status);
    assert_int_equal(hit.index, 77);
    assert_non_null(strstr(pli_last_error(f->context), words));
}

static void test_degenerate_rays_are_refused(void** state) {
    fixture* f = *state;
    add_node(f, 0, 0, 0);
    const pli_body* body = make_body(f);
    pli_ray_def def = pli_ray_def_default();
    check_refused(f, body, &def, PLI_ERROR_INVALID_VALUE, "0 m long");
    def.to = pli_vec3_make(1e-30f, 0, 0);
    check_refused(f, body, &def, PLI_ERROR_INVALID_VALUE, "long");
    def.to = pli_vec3_make(1e30f, 0, 0);
    check_refused(f, body, &def, PLI_ERROR_INVALID_VALUE, "end 1 is (1e+30, 0, 0)");
    def.to = pli_vec3_make(NAN, 0, 0);
    check_refused(f, body, &def, PLI_ERROR_NOT_FINITE, "not finite");
    def.to = pli_vec3_make(1, 0, 0);
    def.from = pli_vec3_make(0, INFINITY, 0);
    check_refused(f, body, &def, PLI_ERROR_NOT_FINITE, "not finite");
    def.from = pli_vec3_make(0, 0, 0);
    def.radius = -1.0f;
    check_refused(f, body, &def, PLI_ERROR_INVALID_VALUE, "radius is -1");
    def.radius = NAN;
    check_refused(f, body, &def, PLI_ERROR_NOT_FINITE, "radius is nan");
    def.radius = 0.0f;
    def.targets = 0;
    check_refused(f, body, &def, PLI_ERROR_INVALID_VALUE, "targets");
    def.targets = 16;
    check_refused(f, body, &def, PLI_ERROR_INVALID_VALUE, "targets");
    def = pli_ray_def_default();
    def.cookie = 0;
    check_refused(f, body, &def, PLI_ERROR_INVALID_DEF, "pli_ray_def_default");
    pli_ray_hit hit;
    assert_int_equal(pli_body_cast_ray(body, NULL, &hit), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_cast_ray(body, &def, NULL), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_body_cast_ray(NULL, &def, &hit), PLI_ERROR_NULL_ARGUMENT);
}

int main(void) {
#define RAY_TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)
    const struct CMUnitTest tests[] = {
        RAY_TEST(test_face_is_hit_from_both_sides),
        RAY_TEST(test_small_faces_are_hit_where_they_are),
        RAY_TEST(test_node_is_a_sphere),
        RAY_TEST(test_thin_link_is_found_far_away),
        RAY_TEST(test_nearest_of_all_kinds_wins),
        RAY_TEST(test_degenerate_rays_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
