/* Generators: counts, places, pins, and what they refuse. Bit equality with Bullet is in oracle_generate.cpp. */

#include "failing_allocator.h"

#include "context_fixture.h"

#include <pliant/generate.h>

#include <limits.h>

/* The call must give `status` and a message with `text` in it, and make nothing. */
#define check_refused(call, status, text)                                                                              \
    do {                                                                                                               \
        assert_int_equal(call, status);                                                                                \
        if (strstr(pli_last_error(context), text) == NULL) {                                                           \
            fail_msg("'%s' does not contain '%s'", pli_last_error(context), text);                                     \
        }                                                                                                              \
        assert_null(mesh);                                                                                             \
        assert_int_equal(pli_context_allocated_bytes(context), 0);                                                     \
    } while (0)

static void check_counts(const pli_mesh* mesh, int nodes, int links, int faces, int tetras) {
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    assert_int_equal(view.node_count, nodes);
    assert_int_equal(view.link_count, links);
    assert_int_equal(view.face_count, faces);
    assert_int_equal(view.tetra_count, tetras);
}

static void test_rope(void** state) {
    (void)state;
    const pli_vec3 from = {0, 0, 0}, to = {4, 8, 0};
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_rope(context, from, to, 3, PLI_ROPE_PIN_LAST, &mesh), PLI_OK);
    check_counts(mesh, 5, 4, 0, 0);
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    check_near(view.positions[3].y, 6, 0);
    check_near(view.inverse_masses[0], 1, 0);
    check_near(view.inverse_masses[4], 0, 0);
    pli_mesh_destroy(mesh);
    mesh = NULL;
    check_refused(pli_mesh_create_rope(context, from, to, -1, 0, &mesh), PLI_ERROR_INVALID_VALUE,
                  "the number of inner nodes is -1");
    check_refused(pli_mesh_create_rope(context, from, to, INT_MAX, 0, &mesh), PLI_ERROR_INVALID_VALUE,
                  "a mesh of 2147483649 nodes");
    check_refused(pli_mesh_create_rope(context, from, to, 3, 4, &mesh), PLI_ERROR_INVALID_VALUE, "pins 0x4");
    check_refused(pli_mesh_create_rope(context, from, pli_vec3_make(0, NAN, 0), 3, 0, &mesh), PLI_ERROR_NOT_FINITE,
                  "point 1 is (0, ");
    check_refused(pli_mesh_create_rope(context, from, to, 3, 0, NULL), PLI_ERROR_NULL_ARGUMENT, "null");
    assert_int_equal(pli_mesh_create_rope(NULL, from, to, 3, 0, &mesh), PLI_ERROR_NULL_ARGUMENT);
}

static void test_patch_counts(void** state) {
    (void)state;
    const int sizes[][2] = {{31, 31}, {17, 17}, {20, 20}, {15, 15}, {10, 30}, {2, 2}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        const int columns = sizes[i][0], rows = sizes[i][1], cells = (columns - 1) * (rows - 1);
        const int straight = columns * (rows - 1) + rows * (columns - 1);
        for (int diagonals = 0; diagonals < 2; ++diagonals) {
            pli_patch_def def = pli_patch_def_default();
            def.columns = columns;
            def.rows = rows;
            def.diagonals = diagonals != 0;
            pli_mesh* mesh = NULL;
            assert_int_equal(pli_mesh_create_patch(context, &def, &mesh), PLI_OK);
            check_counts(mesh, columns * rows, straight + diagonals * cells, 2 * cells, 0);
            pli_mesh_destroy(mesh);
            assert_int_equal(pli_mesh_create_patch_uv(context, &def, NULL, &mesh), PLI_OK);
            check_counts(mesh, columns * rows, straight + diagonals * cells, 2 * cells, 0);
            pli_mesh_destroy(mesh);
        }
    }
}

static void test_patch_refusals(void** state) {
    (void)state;
    const pli_patch_def good = pli_patch_def_default();
    pli_patch_def def;
    pli_mesh* mesh = NULL;
    check_refused(pli_mesh_create_patch(context, NULL, &mesh), PLI_ERROR_NULL_ARGUMENT, "definition is null");
    check_refused(pli_mesh_create_patch(context, &good, NULL), PLI_ERROR_NULL_ARGUMENT, "null");
    assert_int_equal(pli_mesh_create_patch(NULL, &good, &mesh), PLI_ERROR_NULL_ARGUMENT);
    memset(&def, 0, sizeof def);
    check_refused(pli_mesh_create_patch(context, &def, &mesh), PLI_ERROR_INVALID_DEF, "pli_patch_def_default");
    check_refused(pli_mesh_create_patch_uv(context, &def, NULL, &mesh), PLI_ERROR_INVALID_DEF, "pli_patch_def_default");
    def = good;
    def.rows = 1;
    check_refused(pli_mesh_create_patch(context, &def, &mesh), PLI_ERROR_INVALID_VALUE, "rows is 1");
    def.rows = -5;
    check_refused(pli_mesh_create_patch(context, &def, &mesh), PLI_ERROR_INVALID_VALUE, "rows is -5");
    def.rows = def.columns = 65536;
    check_refused(pli_mesh_create_patch(context, &def, &mesh), PLI_ERROR_INVALID_VALUE, "a mesh of 4294967296 nodes");
    def.rows = def.columns = INT_MAX;
    check_refused(pli_mesh_create_patch_uv(context, &def, NULL, &mesh), PLI_ERROR_INVALID_VALUE,
                  "columns is 2147483647");
    def.rows = def.columns = 46340; /* as many nodes as an int can count, but more links */
    check_refused(pli_mesh_create_patch(context, &def, &mesh), PLI_ERROR_INVALID_VALUE, "6442001441 links");
    def = good;
    def.corner_11.z = INFINITY;
    check_refused(pli_mesh_create_patch(context, &def, &mesh), PLI_ERROR_NOT_FINITE, "corner_11");
    def = good;
    def.pins = PLI_PATCH_PIN_CENTER;
    check_refused(pli_mesh_create_patch(context, &def, &mesh), PLI_ERROR_INVALID_VALUE, "pins 0x100");
    def.pins = 512;
    check_refused(pli_mesh_create_patch_uv(context, &def, NULL, &mesh), PLI_ERROR_INVALID_VALUE, "pins 0x200");
}

static void test_ellipsoid(void** state) {
    (void)state;
    const pli_vec3 center = {1, 2, 3}, radii = {1, 2, 0.5f};
    const int counts[] = {4, 5, 8, 67, 131, 515, 4099};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) {
        const int n = counts[i];
        pli_mesh* mesh = NULL;
        assert_int_equal(pli_mesh_create_ellipsoid(context, center, radii, n, &mesh), PLI_OK);
        check_counts(mesh, n, 3 * n - 6, 2 * n - 4, 0);
        const pli_mesh_view view = pli_mesh_get_view(mesh);
        for (int k = 0; k < n; ++k) {
            const pli_vec3 p = pli_vec3_sub(view.positions[k], center);
            check_near(p.x * p.x + p.y * p.y / 4 + p.z * p.z * 4, 1, 5e-6);
        }
        check_near(view.positions[0].z, 2.5, 0); /* the first point is the pole below */
        pli_mesh_destroy(mesh);
    }
    pli_mesh* mesh = NULL;
    check_refused(pli_mesh_create_ellipsoid(context, center, radii, 3, &mesh), PLI_ERROR_INVALID_VALUE,
                  "number of points is 3");
    check_refused(pli_mesh_create_ellipsoid(context, center, pli_vec3_make(1, 0, 1), 9, &mesh), PLI_ERROR_INVALID_VALUE,
                  "(1, 0, 1)");
    check_refused(pli_mesh_create_ellipsoid(context, center, pli_vec3_make(1, NAN, 1), 9, &mesh), PLI_ERROR_NOT_FINITE,
                  "radii is (1, nan, 1)");
    check_refused(pli_mesh_create_ellipsoid(context, center, radii, 9, NULL), PLI_ERROR_NULL_ARGUMENT, "null");
    assert_int_equal(pli_mesh_create_ellipsoid(NULL, center, radii, 9, &mesh), PLI_ERROR_NULL_ARGUMENT);
}

static void test_convex_hull(void** state) {
    (void)state;
    pli_vec3 points[10];
    for (int i = 0; i < 8; ++i) {
        points[i] = pli_vec3_make((float)(i & 1), (float)(i >> 1 & 1), (float)(i >> 2));
    }
    points[8] = pli_vec3_make(0.5f, 0.5f, 0.5f);
    points[9] = pli_vec3_make(0.5f, 0.5f, 1.0005f);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_convex_hull(context, 9, points, 0, &mesh), PLI_OK);
    check_counts(mesh, 8, 18, 12, 0);
    check_near(pli_mesh_volume(mesh), 1, 1e-6);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_mesh_create_convex_hull(context, 10, points, 0, &mesh), PLI_OK);
    check_counts(mesh, 9, 21, 14, 0);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_mesh_create_convex_hull(context, 10, points, 0.001f, &mesh), PLI_OK);
    check_counts(mesh, 8, 18, 12, 0);
    pli_mesh_destroy(mesh);
    mesh = NULL;
    check_refused(pli_mesh_create_convex_hull(context, 4, points, 0, &mesh), PLI_ERROR_INVALID_MESH,
                  "pli_mesh_create_convex_hull: the 4 points lie in a plane");
    check_refused(pli_mesh_create_convex_hull(context, 3, points, 0, &mesh), PLI_ERROR_INVALID_VALUE,
                  "points of a hull is 3");
    check_refused(pli_mesh_create_convex_hull(context, -3, points, 0, &mesh), PLI_ERROR_INVALID_VALUE,
                  "points of a hull is -3");
    check_refused(pli_mesh_create_convex_hull(context, 8, NULL, 0, &mesh), PLI_ERROR_NULL_ARGUMENT, "points are null");
    check_refused(pli_mesh_create_convex_hull(context, 8, points, 0, NULL), PLI_ERROR_NULL_ARGUMENT, "mesh is null");
    check_refused(pli_mesh_create_convex_hull(context, 8, points, -0.1f, &mesh), PLI_ERROR_INVALID_VALUE, "ratio");
    check_refused(pli_mesh_create_convex_hull(context, 8, points, NAN, &mesh), PLI_ERROR_NOT_FINITE, "ratio");
    points[5].y = NAN;
    check_refused(pli_mesh_create_convex_hull(context, 8, points, 0, &mesh), PLI_ERROR_NOT_FINITE, "point 5");
    assert_int_equal(pli_mesh_create_convex_hull(NULL, 8, points, 0, &mesh), PLI_ERROR_NULL_ARGUMENT);
}

static void test_triangles(void** state) {
    (void)state;
    /* Two components, a face without an area (3, 4, 5 in a line), one that names a point twice, an unused point. */
    const pli_vec3 points[8] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {7, 0, 0}, {5, 5, 5}, {1, 1, 0}};
    const int triangles[] = {0, 1, 2, 1, 7, 2, 3, 4, 5, 5, 3, 5};
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_from_triangles(context, 8, points, 4, triangles, false, &mesh), PLI_OK);
    check_counts(mesh, 8, 8, 3, 0);
    const int links[8][2] = {{2, 0}, {0, 1}, {1, 2}, {1, 7}, {7, 2}, {5, 3}, {3, 4}, {4, 5}};
    for (int i = 0; i < 8; ++i) {
        assert_memory_equal(pli_mesh_get_view(mesh).links[i].nodes, links[i], sizeof links[i]);
    }
    pli_mesh_destroy(mesh);
    mesh = NULL;
    const int low[] = {0, 1, 2, 0, -1, 2}, high[] = {0, 1, 8};
    check_refused(pli_mesh_create_from_triangles(context, 8, points, 2, low, true, &mesh), PLI_ERROR_INDEX_OUT_OF_RANGE,
                  "triangle 1 names point -1, there are 8 points");
    check_refused(pli_mesh_create_from_triangles(context, 8, points, 1, high, true, &mesh),
                  PLI_ERROR_INDEX_OUT_OF_RANGE, "triangle 0 names point 8");
    check_refused(pli_mesh_create_from_triangles(context, 0, points, 0, low, true, &mesh), PLI_ERROR_INVALID_VALUE,
                  "0 points");
    check_refused(pli_mesh_create_from_triangles(context, 8, points, -1, low, true, &mesh), PLI_ERROR_INVALID_VALUE,
                  "-1 triangles");
    check_refused(pli_mesh_create_from_triangles(context, 8, NULL, 1, low, true, &mesh), PLI_ERROR_NULL_ARGUMENT,
                  "points");
    check_refused(pli_mesh_create_from_triangles(context, 8, points, 1, NULL, true, &mesh), PLI_ERROR_NULL_ARGUMENT,
                  "triangles");
    check_refused(pli_mesh_create_from_triangles(context, 8, points, 1, low, true, NULL), PLI_ERROR_NULL_ARGUMENT,
                  "mesh");
    assert_int_equal(pli_mesh_create_from_triangles(NULL, 8, points, 1, low, true, &mesh), PLI_ERROR_NULL_ARGUMENT);
    const pli_vec3 bad[3] = {{0, 0, 0}, {1, 0, 0}, {0, NAN, 0}};
    check_refused(pli_mesh_create_from_triangles(context, 3, bad, 1, low, true, &mesh), PLI_ERROR_NOT_FINITE,
                  "point 2");
}

static void test_tetras(void** state) {
    (void)state;
    const pli_vec3 points[5] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    const int tetras[] = {0, 1, 2, 3, 4, 1, 2, 3};
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_from_tetras(context, 5, points, 2, tetras, &mesh), PLI_OK);
    check_counts(mesh, 5, 9, 0, 2);
    const int links[9][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}, {4, 1}, {2, 4}, {4, 3}};
    for (int i = 0; i < 9; ++i) {
        assert_memory_equal(pli_mesh_get_view(mesh).links[i].nodes, links[i], sizeof links[i]);
    }
    pli_mesh_destroy(mesh);
    mesh = NULL;
    const int high[] = {0, 1, 2, 3, 0, 1, 2, 5}, twice[] = {0, 1, 2, 1};
    check_refused(pli_mesh_create_from_tetras(context, 5, points, 2, high, &mesh), PLI_ERROR_INDEX_OUT_OF_RANGE,
                  "tetra 1 names point 5");
    check_refused(pli_mesh_create_from_tetras(context, 5, points, 1, twice, &mesh), PLI_ERROR_INVALID_VALUE,
                  "tetra 0 names point 1 twice");
    check_refused(pli_mesh_create_from_tetras(context, 0, points, 1, tetras, &mesh), PLI_ERROR_INVALID_VALUE,
                  "0 points");
    check_refused(pli_mesh_create_from_tetras(context, 5, NULL, 1, tetras, &mesh), PLI_ERROR_NULL_ARGUMENT, "points");
    check_refused(pli_mesh_create_from_tetras(context, 5, points, 1, NULL, &mesh), PLI_ERROR_NULL_ARGUMENT, "tetras");
    check_refused(pli_mesh_create_from_tetras(context, 5, points, 1, tetras, NULL), PLI_ERROR_NULL_ARGUMENT, "mesh");
    assert_int_equal(pli_mesh_create_from_tetras(NULL, 5, points, 1, tetras, &mesh), PLI_ERROR_NULL_ARGUMENT);
}

static pli_status make_all(pli_context* own_context, void* user) {
    const pli_vec3 points[5] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
    const int tetras[] = {0, 1, 2, 3, 4, 1, 2, 3}, triangles[] = {0, 1, 2, 1, 2, 3};
    const pli_patch_def def = pli_patch_def_default();
    const pli_vec3 radii = {1, 2, 3};
    for (int kind = 0; kind < 7; ++kind) {
        pli_mesh* mesh = NULL;
        pli_status status = PLI_OK;
        switch (kind) {
        case 0:
            status = pli_mesh_create_rope(own_context, points[0], points[1], 30, 0, &mesh);
            break;
        case 1:
            status = pli_mesh_create_patch(own_context, &def, &mesh);
            break;
        case 2:
            status = pli_mesh_create_patch_uv(own_context, &def, NULL, &mesh);
            break;
        case 3:
            status = pli_mesh_create_ellipsoid(own_context, points[4], radii, 50, &mesh);
            break;
        case 4:
            status = pli_mesh_create_convex_hull(own_context, 5, points, 0.001f, &mesh);
            break;
        case 5:
            status = pli_mesh_create_from_triangles(own_context, 5, points, 2, triangles, true, &mesh);
            break;
        default:
            status = pli_mesh_create_from_tetras(own_context, 5, points, 2, tetras, &mesh);
            break;
        }
        if (status != PLI_OK) {
            assert_null(mesh);
            return status;
        }
        pli_mesh_destroy(mesh);
    }
    (void)user;
    return PLI_OK;
}

static void test_out_of_memory_leaves_nothing(void** state) {
    (void)state;
    assert_in_range(check_survives_failing_allocator(make_all, NULL), 40, 300);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rope),           cmocka_unit_test(test_patch_counts),
        cmocka_unit_test(test_patch_refusals), cmocka_unit_test(test_ellipsoid),
        cmocka_unit_test(test_convex_hull),    cmocka_unit_test(test_triangles),
        cmocka_unit_test(test_tetras),         cmocka_unit_test(test_out_of_memory_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, setup_context, teardown_context);
}
