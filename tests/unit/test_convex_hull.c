/* The hull service: closed, convex, made of extreme points only, whatever the points. */

#include "failing_allocator.h"
#include "geometry/convex_hull.h"
#include "geometry/orient3d.h"

#include "context_fixture.h"

static float random_unit(uint32_t* seed) {
    *seed = UINT32_C(1664525) * *seed + UINT32_C(1013904223);
    return (float)(*seed >> 8) / 8388608.0f - 1.0f;
}

/* Every directed edge once and its opposite once, and no face in front of a neighbour. */
static void check_closed_and_convex(const plii_convex_hull* hull, int point_count, const pli_vec3* points) {
    const int count = hull->triangle_count;
    int* first = (int*)malloc((size_t)point_count * sizeof(int)); /* chains of directed edges by start */
    int* next = (int*)malloc((size_t)count * 3 * sizeof(int));
    for (int i = 0; i < point_count; ++i) {
        first[i] = -1;
    }
    for (int i = 0; i < 3 * count; ++i) {
        const int from = hull->triangles[i / 3][i % 3];
        assert_in_range(from, 0, point_count - 1);
        next[i] = first[from];
        first[from] = i;
    }
    for (int i = 0; i < 3 * count; ++i) {
        const int* t = hull->triangles[i / 3];
        const int from = t[i % 3], to = t[(i + 1) % 3];
        int opposite = 0, same = 0;
        for (int k = first[to]; k >= 0; k = next[k]) {
            const int* u = hull->triangles[k / 3];
            if (u[(k % 3 + 1) % 3] != from) { continue; }
            ++opposite;
            const pli_vec3 apex = points[u[(k % 3 + 2) % 3]];
            assert_true(plii_orient3d(points[t[0]], points[t[1]], points[t[2]], apex) <= 0);
        }
        for (int k = first[from]; k >= 0; k = next[k]) {
            same += hull->triangles[k / 3][(k % 3 + 1) % 3] == to;
        }
        assert_int_equal(opposite, 1);
        assert_int_equal(same, 1);
    }
    int corners = 0;
    for (int i = 0; i < point_count; ++i) {
        corners += first[i] >= 0;
    }
    assert_int_equal(corners - count / 2, 2); /* Euler: V - E + F = V - F / 2 */
    free(first);
    free(next);
}

/* Largest distance of a point in front of a face. */
static double distance_outside(const plii_convex_hull* hull, int point_count, const pli_vec3* points) {
    double outside = 0.0;
    for (int i = 0; i < hull->triangle_count; ++i) {
        const pli_vec3 a = points[hull->triangles[i][0]], b = points[hull->triangles[i][1]];
        const pli_vec3 c = points[hull->triangles[i][2]];
        const double ux = (double)b.x - (double)a.x, uy = (double)b.y - (double)a.y, uz = (double)b.z - (double)a.z;
        const double vx = (double)c.x - (double)a.x, vy = (double)c.y - (double)a.y, vz = (double)c.z - (double)a.z;
        const double nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
        const double length = sqrt(nx * nx + ny * ny + nz * nz);
        for (int k = 0; k < point_count; ++k) {
            const pli_vec3 p = points[k];
            const double height =
                nx * ((double)p.x - (double)a.x) + ny * ((double)p.y - (double)a.y) + nz * ((double)p.z - (double)a.z);
            outside = fmax(outside, height / length);
        }
    }
    return outside;
}

/* Number of corners of the hull, after all checks. */
static int hull_corners(int count, const pli_vec3* points, float tolerance, double allowed_outside) {
    plii_convex_hull hull = {0};
    assert_int_equal(plii_convex_hull_create(context, count, points, tolerance, __func__, &hull), PLI_OK);
    check_closed_and_convex(&hull, count, points);
    const int corners = hull.triangle_count / 2 + 2;
    if (count <= 3000) { check_at_most(distance_outside(&hull, count, points), allowed_outside); }
    plii_convex_hull_destroy(context, &hull);
    return corners;
}

/* n * n points on each side of the cube [-1, 1]^3. */
static int fill_cube_grid(pli_vec3* points, int n) {
    const float s = 2.0f / (float)(n - 1);
    int count = 0;
    for (int x = 0; x < n; ++x) {
        for (int y = 0; y < n; ++y) {
            for (int z = 0; z < n; ++z) {
                if (x > 0 && x < n - 1 && y > 0 && y < n - 1 && z > 0 && z < n - 1) { continue; }
                points[count++] = pli_vec3_make(-1 + s * (float)x, -1 + s * (float)y, -1 + s * (float)z);
            }
        }
    }
    return count;
}

static void test_orientation_is_exact(void** state) {
    (void)state;
    const pli_vec3 a = {0.1f, 0.2f, 0.3f}, b = {1.7f, -0.4f, 0.9f}, c = {-2.3f, 1.1f, 0.7f};
    const pli_vec3 above = {0.1f, 0.2f, 100.0f};
    const int side = plii_orient3d(a, b, c, above);
    assert_int_not_equal(side, 0);
    assert_int_equal(plii_orient3d(b, a, c, above), -side);
    assert_int_equal(plii_orient3d(a, b, c, a), 0);
    assert_int_equal(plii_orient3d(a, b, c, c), 0);
    /* The smallest float against a plane through far points decides. */
    const pli_vec3 p = {1e6f, 0, 0}, q = {0, 1e6f, 0}, r = {-1e6f, -1e6f, 0};
    assert_int_equal(plii_orient3d(p, q, r, pli_vec3_make(3, 4, 0)), 0);
    assert_int_equal(plii_orient3d(p, q, r, pli_vec3_make(3, 4, 1e-44f)), 1);
    assert_int_equal(plii_orient3d(p, q, r, pli_vec3_make(3, 4, -1e-44f)), -1);
    /* The plane x + y + z = 3, by points whose products do not fit into a double. */
    const pli_vec3 u = {16777215, -16777212, 0}, v = {-16777216, 16777216, 3}, w = {1.5f, 0.5f, 1};
    assert_int_equal(plii_orient3d(u, v, w, pli_vec3_make(1, 1, 1)), 0);
    const int tilt = plii_orient3d(u, v, w, pli_vec3_make(1, 1, 1.00000012f));
    assert_int_not_equal(tilt, 0);
    assert_int_equal(plii_orient3d(u, v, w, pli_vec3_make(1, 1, 0.99999994f)), -tilt);
}

static void test_cube_keeps_its_corners_only(void** state) {
    (void)state;
    static pli_vec3 points[6 * 20 * 20];
    for (int n = 2; n <= 20; n += 3) {
        const int count = fill_cube_grid(points, n);
        assert_int_equal(hull_corners(count, points, 0, 0), 8);
    }
}

static void test_turned_cube_keeps_its_corners_only(void** state) {
    (void)state;
    static pli_vec3 points[6 * 20 * 20];
    const pli_mat3 turn = pli_mat3_from_euler_zyx(0.3f, 0.7f, -1.1f);
    for (int n = 2; n <= 20; n += 3) {
        const int count = fill_cube_grid(points, n);
        for (int i = 0; i < count; ++i) {
            points[i] = pli_mat3_mul_vec3(turn, points[i]);
        }
        assert_int_equal(hull_corners(count, points, 0, 1e-6), 8);
    }
}

static void test_sphere_keeps_all_points(void** state) {
    (void)state;
    static pli_vec3 points[1000];
    uint32_t seed = 1;
    for (int i = 0; i < 1000; ++i) {
        pli_vec3 p;
        do {
            p = pli_vec3_make(random_unit(&seed), random_unit(&seed), random_unit(&seed));
        } while (pli_vec3_length(p) < 0.1f);
        points[i] = pli_vec3_scale(p, 1.0f / pli_vec3_length(p));
    }
    assert_in_range(hull_corners(1000, points, 0, 5e-7), 998, 1000); /* random points may nearly coincide */
    assert_in_range(hull_corners(1000, points, 0.01f, 0.01 + 5e-7), 50, 600);
}

static void test_random_points_and_duplicates(void** state) {
    (void)state;
    static pli_vec3 points[2000];
    uint32_t seed = 7;
    for (int round = 0; round < 120; ++round) {
        const int half = 8 + round * 8;
        for (int i = 0; i < half; ++i) {
            pli_vec3 p = pli_vec3_make(random_unit(&seed), random_unit(&seed), random_unit(&seed));
            /* Few values: many points in common planes and on common lines. */
            if (round % 3 == 1) { p = pli_vec3_make(roundf(2 * p.x), roundf(2 * p.y), roundf(2 * p.z)); }
            if (round % 3 == 2) { p.z *= 1e-5f; }
            points[i] = points[2 * half - 1 - i] = pli_vec3_add(p, pli_vec3_make(0, 0, (float)(round % 2)));
        }
        assert_in_range(hull_corners(2 * half, points, 0, 2e-6), 4, half);
    }
}

static void test_cylinder_and_cone(void** state) {
    (void)state;
    static pli_vec3 points[2001];
    const int n = 1000;
    for (int i = 0; i < n; ++i) {
        const float angle = 6.2831853f * (float)i / (float)n;
        points[i] = pli_vec3_make(cosf(angle), 0, sinf(angle));
        points[n + i] = pli_vec3_make(cosf(angle), 2, sinf(angle));
    }
    assert_int_equal(hull_corners(2 * n, points, 0, 1e-6), 2 * n);
    points[n] = pli_vec3_make(0, 5, 0);
    assert_int_equal(hull_corners(n + 1, points, 0, 1e-6), n + 1);
}

static void test_many_points(void** state) {
    (void)state;
    const int count = 200000;
    pli_vec3* points = (pli_vec3*)malloc((size_t)count * sizeof *points);
    uint32_t seed = 3;
    for (int i = 0; i < count; ++i) {
        points[i] = pli_vec3_make(random_unit(&seed), random_unit(&seed), random_unit(&seed));
        points[i] = pli_vec3_scale(points[i], i < count / 4 ? 1.0f / pli_vec3_length(points[i]) : 0.6f);
    }
    assert_in_range(hull_corners(count, points, 0, 0), 1000, count);
    free(points);
}

static void test_flat_points_are_refused(void** state) {
    (void)state;
    const pli_vec3 line[5] = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {-5, -5, -5}};
    const pli_vec3 plane[5] = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}, {0.3f, 0.4f, 1}};
    const pli_vec3 same[5] = {{2, 3, 4}, {2, 3, 4}, {2, 3, 4}, {2, 3, 4}, {2, 3, 4}};
    plii_convex_hull hull = {0};
    assert_int_equal(plii_convex_hull_create(context, 5, line, 0, "here", &hull), PLI_ERROR_INVALID_MESH);
    assert_int_equal(plii_convex_hull_create(context, 5, plane, 0, "here", &hull), PLI_ERROR_INVALID_MESH);
    assert_string_equal(pli_last_error(context), "here: the 5 points lie in a plane");
    assert_int_equal(plii_convex_hull_create(context, 5, same, 0, "here", &hull), PLI_ERROR_INVALID_MESH);
    assert_int_equal(plii_convex_hull_create(context, 3, plane, 0, "here", &hull), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(plii_convex_hull_create(context, 0, plane, 0, "here", &hull), PLI_ERROR_INVALID_VALUE);
    assert_null(hull.triangles);
}

static void test_extreme_sizes(void** state) {
    (void)state;
    const float sizes[] = {1e-40f, 1e-20f, 1e-3f, 1e5f, 1e18f, 3e38f};
    pli_vec3 points[8];
    for (int s = 0; s < 6; ++s) {
        for (int i = 0; i < 8; ++i) {
            points[i] = pli_vec3_make((i & 1) != 0 ? sizes[s] : -sizes[s], (i & 2) != 0 ? sizes[s] : -sizes[s],
                                      (i & 4) != 0 ? sizes[s] : -sizes[s]);
        }
        assert_int_equal(hull_corners(8, points, 0, 0), 8);
    }
}

static pli_status make_hull(pli_context* own_context, void* user) {
    (void)user;
    static pli_vec3 points[6 * 5 * 5];
    const int count = fill_cube_grid(points, 5);
    plii_convex_hull hull = {0};
    const pli_status status = plii_convex_hull_create(own_context, count, points, 0, "hull", &hull);
    plii_convex_hull_destroy(own_context, &hull);
    return status;
}

static void test_out_of_memory_leaves_nothing(void** state) {
    (void)state;
    assert_in_range(check_survives_failing_allocator(make_hull, NULL), 7, 100);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_orientation_is_exact),
        cmocka_unit_test(test_cube_keeps_its_corners_only),
        cmocka_unit_test(test_turned_cube_keeps_its_corners_only),
        cmocka_unit_test(test_sphere_keeps_all_points),
        cmocka_unit_test(test_random_points_and_duplicates),
        cmocka_unit_test(test_cylinder_and_cone),
        cmocka_unit_test(test_many_points),
        cmocka_unit_test(test_flat_points_are_refused),
        cmocka_unit_test(test_extreme_sizes),
        cmocka_unit_test(test_out_of_memory_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, setup_context, teardown_context);
}
