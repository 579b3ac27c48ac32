/* Solids sampled from triangle meshes: distances against the exact ones, signs of damaged surfaces, errors, contacts.
 */

#include "failing_allocator.h"

#include "context_fixture.h"
#include "level_sheet.h"

#include <pliant/pliant.h>

// ------------------------------------------------------------------------------------------------------- surfaces

typedef struct surface {
    int point_count, triangle_count, point_room, triangle_room;
    pli_vec3* points;
    int* triangles;
} surface;

static void surface_room(surface* s, int points, int triangles) {
    s->point_room = s->point_count + points;
    s->triangle_room = s->triangle_count + triangles;
    s->points = realloc(s->points, (size_t)s->point_room * sizeof *s->points);
    s->triangles = realloc(s->triangles, (size_t)s->triangle_room * 3 * sizeof *s->triangles);
    assert_non_null(s->points);
    assert_non_null(s->triangles);
}

static void surface_free(surface* s) {
    free(s->points);
    free(s->triangles);
    memset(s, 0, sizeof *s);
}

static void surface_add_triangle(surface* s, int a, int b, int c) {
    assert_true(s->triangle_count < s->triangle_room);
    int* t = &s->triangles[3 * s->triangle_count++];
    t[0] = a;
    t[1] = b;
    t[2] = c;
}

static pli_vec3 on_sphere(float u, float v, float radius) {
    return pli_vec3_make(radius * sinf(v) * cosf(u), radius * sinf(v) * sinf(u), radius * cosf(v));
}

/* A sphere of `n` rings with 2 n points each; `turn` -1 faces it inward. */
static void surface_add_sphere(surface* s, int n, float radius, pli_vec3 center, int turn) {
    const float pi = 3.14159265f;
    const int first = s->point_count, across = 2 * n;
    surface_room(s, n * across + 2, 2 * n * across);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < across; ++j) {
            const pli_vec3 p = on_sphere(pi * (float)j / (float)n, pi * (float)(i + 1) / (float)(n + 1), radius);
            s->points[s->point_count++] = pli_vec3_add(center, p);
        }
    }
    const int top = s->point_count, bottom = top + 1;
    s->points[s->point_count++] = pli_vec3_add(center, pli_vec3_make(0, 0, radius));
    s->points[s->point_count++] = pli_vec3_add(center, pli_vec3_make(0, 0, -radius));
    const int begin = s->triangle_count;
    for (int j = 0; j < across; ++j) {
        const int next = (j + 1) % across;
        surface_add_triangle(s, top, first + j, first + next);
        surface_add_triangle(s, bottom, first + (n - 1) * across + next, first + (n - 1) * across + j);
        for (int i = 0; i + 1 < n; ++i) {
            const int a = first + i * across + j, b = first + i * across + next;
            surface_add_triangle(s, a, a + across, b);
            surface_add_triangle(s, b, a + across, b + across);
        }
    }
    for (int i = begin; i < s->triangle_count && turn < 0; ++i) {
        const int swap = s->triangles[3 * i];
        s->triangles[3 * i] = s->triangles[3 * i + 1];
        s->triangles[3 * i + 1] = swap;
    }
}

static void surface_add_torus(surface* s, int n, float ring, float tube) {
    const float tau = 6.28318531f;
    const int first = s->point_count;
    surface_room(s, n * n, 2 * n * n);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const float u = tau * (float)i / (float)n, v = tau * (float)j / (float)n;
            const float r = ring + tube * cosf(v);
            s->points[s->point_count++] = pli_vec3_make(r * cosf(u), r * sinf(u), tube * sinf(v));
        }
    }
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const int p = first + i * n, q = first + (i + 1) % n * n, k = (j + 1) % n;
            surface_add_triangle(s, p + j, q + j, p + k);
            surface_add_triangle(s, p + k, q + j, q + k);
        }
    }
}

static void surface_read_bunny(surface* s) {
    pli_triangles bunny;
    assert_int_equal(pli_triangles_read_obj(context, PLIANT_DATA_DIR "/bunny.obj", &bunny), PLI_OK);
    surface_room(s, bunny.point_count, bunny.triangle_count);
    memcpy(s->points, bunny.points, (size_t)bunny.point_count * sizeof *s->points);
    memcpy(s->triangles, bunny.indices, (size_t)bunny.triangle_count * 3 * sizeof *s->triangles);
    s->point_count = bunny.point_count;
    s->triangle_count = bunny.triangle_count;
    pli_triangles_destroy(&bunny);
}

static pli_shape* sample(const surface* s, float cell_size, float padding) {
    pli_sampled_mesh_def def = pli_sampled_mesh_def_default();
    def.cell_size = cell_size;
    def.padding = padding;
    pli_shape* shape = NULL;
    const pli_status status = pli_shape_create_sampled_mesh(context, s->point_count, s->points, s->triangle_count,
                                                            s->triangles, &def, &shape);
    if (status != PLI_OK) { fail_msg("%s", pli_last_error(context)); }
    return shape;
}

static pli_shape* exact(const surface* s) {
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_triangle_mesh(context, s->point_count, s->points, s->triangle_count, s->triangles,
                                                    0.01f, &shape),
                     PLI_OK);
    return shape;
}

static uint32_t random_state;
static float random_float(float low, float high) {
    random_state = random_state * 1664525u + 1013904223u;
    return low + (high - low) * (float)(random_state >> 8) / 16777216.0f;
}
static pli_vec3 random_in(pli_bounds b, float grown) {
    const float x = random_float(b.min.x - grown, b.max.x + grown);
    const float y = random_float(b.min.y - grown, b.max.y + grown);
    return pli_vec3_make(x, y, random_float(b.min.z - grown, b.max.z + grown));
}

// ----------------------------------------------------------------------------------------------------- distances

enum { POINTS = 10000 };

/* Distances within `cells` of the exact ones, signs right from half a cell on, normals unit and along the exact ones
   near the surface on average. */
static void check_against_exact(const surface* s, float cell_size, float cells) {
    pli_shape* truth = exact(s);
    pli_shape* shape = sample(s, cell_size, 4 * cell_size);
    const pli_bounds bounds = pli_shape_bounds(truth);
    double worst = 0, worst_outside = -1e9, sum_along = 0;
    int near = 0, wrong_signs = 0;
    random_state = 7;
    for (int i = 0; i < POINTS; ++i) {
        pli_vec3 n, n_exact;
        const pli_vec3 p = random_in(bounds, 4 * cell_size);
        const float d = pli_shape_distance(shape, p, &n), d_exact = pli_shape_distance(truth, p, &n_exact);
        worst = fmax(worst, fabs((double)d - (double)d_exact));
        wrong_signs += fabsf(d_exact) > 0.5f * cell_size && (d < 0) != (d_exact < 0);
        check_near(pli_vec3_length(n), 1, 1e-5);
        if (fabsf(d_exact) < cell_size) {
            ++near;
            sum_along += (double)pli_vec3_dot(n, n_exact);
        }
        /* Outside of the grid. */
        const pli_vec3 far = random_in(bounds, random_float(0.0f, 100.0f));
        const float far_exact = pli_shape_distance(truth, far, NULL), far_d = pli_shape_distance(shape, far, &n);
        worst_outside = fmax(worst_outside, (double)far_d - (double)far_exact - 1e-6 * (double)far_exact);
        check_near(pli_vec3_length(n), 1, 1e-5);
    }
    assert_int_equal(wrong_signs, 0);
    check_at_most(worst / (double)cell_size, cells);
    check_at_most(worst_outside / (double)cell_size, cells);
    assert_true(near > POINTS / 200);
    check_at_most(1 - sum_along / near, 0.05);
    const pli_bounds sampled = pli_shape_bounds(shape);
    check_near(sampled.min.x, bounds.min.x - cell_size, 1e-5);
    check_near(sampled.max.z, bounds.max.z + cell_size, 1e-5);
    pli_shape_release(shape);
    pli_shape_release(truth);
}

static void test_sampled_sphere(void** state) {
    (void)state;
    surface s = {0};
    surface_add_sphere(&s, 24, 1, pli_vec3_make(3, -2, 1), 1);
    check_against_exact(&s, 0.06f, 0.6f);
    check_against_exact(&s, 0.2f, 0.6f);
    surface_free(&s);
}

static void test_sampled_torus(void** state) {
    (void)state;
    surface s = {0};
    surface_add_torus(&s, 40, 1, 0.4f);
    check_against_exact(&s, 0.05f, 0.6f);
    surface_free(&s);
}

static void test_sampled_bunny(void** state) {
    (void)state;
    surface s = {0};
    surface_read_bunny(&s);
    check_against_exact(&s, 0.04f, 0.6f);
    surface_free(&s);
}

/* The same in a unit far from 1. */
static void test_sampled_sphere_of_any_size(void** state) {
    (void)state;
    const float scales[2] = {1e-12f, 1e5f};
    for (int k = 0; k < 2; ++k) {
        surface s = {0};
        surface_add_sphere(&s, 12, scales[k], pli_vec3_make(0, 0, 0), 1);
        pli_shape* shape = sample(&s, 0, 0.6f * scales[k]);
        for (int i = -3; i <= 3; ++i) {
            pli_vec3 n;
            const float x = 0.49f * (float)i;
            const float d = pli_shape_distance(shape, pli_vec3_make(x * scales[k], 0, 0), &n);
            check_near(d / scales[k], fabsf(x) - 1, 0.06);
            if (i != 0) { check_near(n.x, i > 0 ? 1 : -1, 0.02); }
        }
        pli_shape_release(shape);
        surface_free(&s);
    }
}

static void test_sampled_mesh_at_points_far_away(void** state) {
    (void)state;
    surface s = {0};
    surface_add_sphere(&s, 8, 1, pli_vec3_make(0, 0, 0), 1);
    pli_shape* shape = sample(&s, 0.2f, 0);
    for (int i = 0; i < 38; ++i) {
        pli_vec3 n;
        const float x = powf(10.0f, (float)i);
        const float d = pli_shape_distance(shape, pli_vec3_make(x, -x, 0), &n);
        /* From below: not farther than the ball, not nearer than the grid. */
        check_at_most(d, (sqrt(2) * (double)x - 0.96) * (1 + 1e-6));
        check_at_most(sqrt(2) * ((double)x - 1.9), (double)d * (1 + 1e-6));
        check_near(n.x, sqrt(0.5), 0.1);
        check_near(pli_vec3_length(n), 1, 1e-5);
    }
    assert_true(pli_shape_distance(shape, pli_vec3_make(3e38f, 3e38f, -3e38f), NULL) > 3e38f);
    pli_shape_release(shape);
    surface_free(&s);
}

// ------------------------------------------------------------------------------------------------ damaged surfaces

/* Share of points, farther than `clear` from the surface, that are on another side than the exact shape says. */
static double wrong_share(const pli_shape* shape, const pli_shape* truth, float clear) {
    const pli_bounds bounds = pli_shape_bounds(truth);
    int wrong = 0, asked = 0;
    random_state = 11;
    for (int i = 0; i < POINTS; ++i) {
        const pli_vec3 p = random_in(bounds, 0.2f);
        const float d = pli_shape_distance(truth, p, NULL);
        if (fabsf(d) < clear) { continue; }
        ++asked;
        wrong += (pli_shape_distance(shape, p, NULL) < 0) != (d < 0);
    }
    assert_true(asked > POINTS / 10);
    return wrong / (double)asked;
}

static void remove_triangle(surface* s, int i) {
    --s->triangle_count;
    memcpy(&s->triangles[3 * i], &s->triangles[3 * s->triangle_count], 3 * sizeof *s->triangles);
}

/* A hole is closed by a surface of its own: distances stay continuous there. */
static void check_steps(const pli_shape* shape, pli_bounds bounds, float step) {
    random_state = 5;
    for (int i = 0; i < POINTS; ++i) {
        const pli_vec3 p = random_in(bounds, 0.1f);
        const float d = pli_shape_distance(shape, p, NULL);
        const float e = pli_shape_distance(shape, pli_vec3_add(p, pli_vec3_make(step, 0, 0)), NULL);
        check_at_most(fabsf(e - d), 2.0f * step);
    }
}

static void test_sampled_mesh_with_holes(void** state) {
    (void)state;
    surface s = {0};
    surface_read_bunny(&s);
    pli_shape* truth = exact(&s);
    float hole = 0;
    for (int i = 0; i < 12; ++i) {
        const int* t = &s.triangles[3 * (i * 71)];
        for (int k = 0; k < 3; ++k) {
            const pli_vec3 side = pli_vec3_sub(s.points[t[k]], s.points[t[(k + 1) % 3]]);
            hole = fmaxf(hole, pli_vec3_length(side));
        }
        remove_triangle(&s, i * 71);
    }
    pli_shape* shape = sample(&s, 0.04f, 0);
    check_at_most(hole, 0.2);
    check_at_most(wrong_share(shape, truth, hole), 0.001);
    check_at_most(wrong_share(shape, truth, 0.04f), 0.001);
    check_steps(shape, pli_shape_bounds(truth), 0.004f);
    pli_shape_release(shape);
    pli_shape_release(truth);
    surface_free(&s);
}

/* A ball without its cap: 30 degrees around a pole. */
static void test_sampled_mesh_with_a_wide_hole(void** state) {
    (void)state;
    surface s = {0};
    surface_add_sphere(&s, 23, 1, pli_vec3_make(0, 0, 0), 1);
    for (int i = s.triangle_count - 1; i >= 0; --i) {
        const int* t = &s.triangles[3 * i];
        if (s.points[t[0]].z + s.points[t[1]].z + s.points[t[2]].z > 3 * 0.87f) { remove_triangle(&s, i); }
    }
    pli_shape* shape = sample(&s, 0.05f, 0);
    check_steps(shape, pli_shape_bounds(shape), 0.005f);
    assert_true(pli_shape_distance(shape, pli_vec3_make(0, 0, 0.6f), NULL) < 0);
    assert_true(pli_shape_distance(shape, pli_vec3_make(0, 0, 1.1f), NULL) > 0);
    pli_vec3 n;
    /* Where the hole is closed there is a surface like any other. */
    float z = 1.1f;
    while (z > 0 && pli_shape_distance(shape, pli_vec3_make(0.02f, 0.01f, z), NULL) > 0) {
        z -= 0.005f;
    }
    assert_true(z > 0.8f);
    check_near(pli_shape_distance(shape, pli_vec3_make(0.02f, 0.01f, z + 0.1f), &n), 0.1, 0.05);
    assert_true(n.z > 0.95f);
    pli_shape_release(shape);
    surface_free(&s);
}

/* Some triangles doubled, some turned over and kept, some without an area, points that nothing uses. */
static void test_sampled_mesh_with_bad_triangles(void** state) {
    (void)state;
    surface s = {0};
    surface_read_bunny(&s);
    pli_shape* truth = exact(&s);
    const int original = s.triangle_count;
    surface_room(&s, 1, 300);
    s.points[s.point_count++] = pli_vec3_make(50, 0, 0);
    for (int i = 0; i < 100; ++i) {
        const int* t = &s.triangles[3 * (i * 9 % original)];
        surface_add_triangle(&s, t[1], t[2], t[0]);
        surface_add_triangle(&s, t[0], t[0], t[1]);
        const int* u = &s.triangles[3 * ((i * 7 + 1) % original)];
        if (i % 10 == 0) { surface_add_triangle(&s, u[0], u[2], u[1]); }
    }
    pli_shape* shape = sample(&s, 0.04f, 0);
    check_near(pli_shape_bounds(shape).max.x, pli_shape_bounds(truth).max.x + 0.04f, 1e-5);
    check_at_most(wrong_share(shape, truth, 0.06f), 0.001);
    pli_shape_release(shape);
    pli_shape_release(truth);
    surface_free(&s);
}

static void test_sampled_mesh_turned_over(void** state) {
    (void)state;
    surface s = {0}, t = {0};
    surface_add_sphere(&s, 16, 1, pli_vec3_make(0, 0, 0), 1);
    surface_add_sphere(&t, 16, 1, pli_vec3_make(0, 0, 0), -1);
    pli_shape* truth = exact(&s);
    pli_shape* shape = sample(&t, 0.1f, 0);
    assert_true(wrong_share(shape, truth, 0.05f) == 0);
    /* One triangle in fifty turned over. */
    for (int i = 0; i < s.triangle_count; i += 50) {
        const int swap = s.triangles[3 * i];
        s.triangles[3 * i] = s.triangles[3 * i + 1];
        s.triangles[3 * i + 1] = swap;
    }
    pli_shape* speckled = sample(&s, 0.1f, 0);
    check_at_most(wrong_share(speckled, truth, 0.2f), 0.001);
    pli_shape_release(speckled);
    pli_shape_release(shape);
    pli_shape_release(truth);
    surface_free(&s);
    surface_free(&t);
}

/* Apart, one of them turned over; crossing; one inside of another, either way. */
static void test_sampled_mesh_of_several_components(void** state) {
    (void)state;
    surface s = {0};
    surface_add_sphere(&s, 32, 1, pli_vec3_make(0, 0, 0), 1);
    surface_add_sphere(&s, 32, 1, pli_vec3_make(1.2f, 0, 0), 1);     /* crosses the first */
    surface_add_sphere(&s, 32, 0.5f, pli_vec3_make(-0.2f, 0, 0), 1); /* in the first, the same way */
    surface_add_sphere(&s, 32, 1, pli_vec3_make(0, 4, 0), -1);       /* apart */
    surface_add_sphere(&s, 32, 1.2f, pli_vec3_make(0, 0, 4), 1);
    surface_add_sphere(&s, 32, 0.6f, pli_vec3_make(0, 0, 4), -1); /* a cavity */
    pli_shape* shape = sample(&s, 0.1f, 0);
    const struct {
        pli_vec3 point;
        double distance;
    } expected[] = {
        {{0.6f, 0, 0}, -0.8},    /* the circle where both cross, but for triangles that lie partly inside */
        {{-0.2f, 0, 0}, -0.8},   /* the inner walls do not count */
        {{0.3f, 0, 0}, -0.8544}, /* on an inner wall; nearest is the crossing circle */
        {{1.7f, 0, 0}, -0.5},    {{2.4f, 0, 0}, 0.2},  {{0, 4, 0}, -1},     {{0, 4, 1.2f}, 0.2},
        {{0, 0, 4}, 0.6},        {{0.9f, 0, 4}, -0.3}, {{1.3f, 0, 4}, 0.1}, {{0, 2, 0}, 1},
    };
    for (size_t i = 0; i < sizeof expected / sizeof expected[0]; ++i) {
        check_near(pli_shape_distance(shape, expected[i].point, NULL), expected[i].distance, i < 3 ? 0.15 : 0.05);
    }
    pli_shape_release(shape);
    surface_free(&s);
}

// ---------------------------------------------------------------------------------------------------- life, errors

static pli_status create_and_release(pli_context* failing, void* user) {
    const surface* s = user;
    pli_sampled_mesh_def def = pli_sampled_mesh_def_default();
    def.cell_size = 0.5f;
    pli_shape* shape = NULL;
    const pli_status status = pli_shape_create_sampled_mesh(failing, s->point_count, s->points, s->triangle_count,
                                                            s->triangles, &def, &shape);
    assert_true((shape != NULL) == (status == PLI_OK));
    pli_shape_release(shape);
    return status;
}

static void test_sampled_mesh_survives_every_failing_allocation(void** state) {
    (void)state;
    surface s = {0};
    surface_add_sphere(&s, 4, 1, pli_vec3_make(0, 0, 0), 1);
    assert_int_equal(check_survives_failing_allocator(create_and_release, &s), 11);
    surface_free(&s);
}

static void check_refused(const surface* s, const pli_sampled_mesh_def* def, pli_status expected, const char* message) {
    pli_shape* const before = (pli_shape*)context; /* something that must stay */
    pli_shape* shape = before;
    assert_int_equal(
        pli_shape_create_sampled_mesh(context, s->point_count, s->points, s->triangle_count, s->triangles, def, &shape),
        expected);
    assert_ptr_equal(shape, before);
    if (strstr(pli_last_error(context), message) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", pli_last_error(context), message);
    }
}

static void test_sampled_mesh_refuses_bad_input(void** state) {
    (void)state;
    surface s = {0};
    surface_add_sphere(&s, 4, 1, pli_vec3_make(0, 0, 0), 1);
    const pli_sampled_mesh_def good = pli_sampled_mesh_def_default();
    pli_sampled_mesh_def def = good;
    def.cookie = 0;
    check_refused(&s, &def, PLI_ERROR_INVALID_DEF, "pli_sampled_mesh_def_default");
    def = good;
    def.cell_size = NAN;
    check_refused(&s, &def, PLI_ERROR_NOT_FINITE, "cell_size");
    def.cell_size = -1;
    check_refused(&s, &def, PLI_ERROR_INVALID_VALUE, "cell_size is -1");
    def.cell_size = 1e-3f;
    check_refused(&s, &def, PLI_ERROR_INVALID_VALUE, "1912 x 1912 x 2009 samples");
    def.cell_size = 1e-9f;
    check_refused(&s, &def, PLI_ERROR_INVALID_VALUE, "too small");
    def = good;
    def.padding = 1e6f;
    check_refused(&s, &def, PLI_ERROR_INVALID_VALUE, "samples, more than 16777216");
    def.padding = 1e30f;
    check_refused(&s, &def, PLI_ERROR_INVALID_VALUE, "padding is 1e+30, the limits are 0 and 1e+06");
    def.padding = INFINITY;
    check_refused(&s, &def, PLI_ERROR_NOT_FINITE, "padding");

    surface t = s;
    t.points = NULL;
    check_refused(&t, &good, PLI_ERROR_NULL_ARGUMENT, "points");
    t = s;
    t.triangles = NULL;
    check_refused(&t, &good, PLI_ERROR_NULL_ARGUMENT, "triangles");
    t = s;
    t.triangle_count = 0;
    check_refused(&t, &good, PLI_ERROR_INVALID_MESH, "0 triangles");
    t = s;
    t.point_count = 30;
    check_refused(&t, &good, PLI_ERROR_INDEX_OUT_OF_RANGE, "there are 30 points");
    s.points[5].y = NAN;
    check_refused(&s, &good, PLI_ERROR_NOT_FINITE, "point 5");

    /* An open sheet, a sheet with two sides, triangles without an area, a point. */
    pli_vec3 corners[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    int sheet[12] = {0, 1, 2, 2, 1, 3, 0, 2, 1, 2, 3, 1};
    t.points = corners;
    t.triangles = sheet;
    t.point_count = 4;
    t.triangle_count = 2;
    check_refused(&t, &good, PLI_ERROR_INVALID_MESH, "the 2 triangles enclose nothing");
    t.triangle_count = 4;
    check_refused(&t, &good, PLI_ERROR_INVALID_MESH, "the 4 triangles enclose nothing");
    int lines[6] = {0, 1, 1, 3, 3, 3};
    t.triangles = lines;
    t.triangle_count = 2;
    check_refused(&t, &good, PLI_ERROR_INVALID_MESH, "enclose nothing");
    int dot[3] = {2, 2, 2};
    t.triangles = dot;
    t.triangle_count = 1;
    check_refused(&t, &good, PLI_ERROR_INVALID_VALUE, "too small");

    assert_int_equal(pli_shape_create_sampled_mesh(context, 4, corners, 2, sheet, &good, NULL),
                     PLI_ERROR_NULL_ARGUMENT);
    pli_shape* none = NULL;
    assert_int_equal(pli_shape_create_sampled_mesh(NULL, 4, corners, 2, sheet, &good, &none), PLI_ERROR_NULL_ARGUMENT);
    surface_free(&s);
}

// -------------------------------------------------------------------------------------------------------- contacts

/* A sheet of 24 x 24 nodes falls on a bunny and hangs over it after ten seconds. */
static void test_cloth_stays_on_a_sampled_bunny(void** state) {
    (void)state;
    surface s = {0};
    surface_read_bunny(&s);
    pli_shape* shape = sample(&s, 0, 0);
    pli_shape* truth = exact(&s);
    pli_world_def world_def = pli_world_def_default();
    world_def.gravity = pli_vec3_make(0, -9.81f, 0);
    pli_world* world = NULL;
    assert_int_equal(pli_world_create(context, &world_def, &world), PLI_OK);

    pli_patch_def patch = level_sheet(0.7f, 0.9f, 24);
    pli_mesh* mesh = NULL;
    assert_int_equal(pli_mesh_create_patch(context, &patch, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_set_total_mass(mesh, 0.5f), PLI_OK);
    const float margin = 0.02f;
    pli_body_def body_def = pli_body_def_default();
    body_def.collision_margin = margin;
    body_def.solver.position_iterations = 8;
    body_def.solver.velocity_damping = 0.2f;
    pli_body* body = NULL;
    assert_int_equal(pli_body_create(world, mesh, &body_def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    contacts.static_hardness = 1.0f;
    contacts.friction = 1.0f;
    assert_int_equal(pli_body_enable_rigid_contacts(body, &contacts), PLI_OK);

    pli_rigid_def rigid_def = pli_rigid_def_default();
    rigid_def.kind = PLI_RIGID_STATIC;
    rigid_def.friction = 1.0f;
    pli_rigid* rigid = NULL;
    assert_int_equal(pli_rigid_create(world, &rigid_def, &rigid), PLI_OK);
    const pli_transform pose = pli_transform_identity();
    assert_int_equal(pli_rigid_set_shapes(rigid, 1, &shape, &pose), PLI_OK);
    static pli_vec3 at_rest[24 * 24];
    float deepest = 1, lowest = 1, farthest = 0;
    pli_vec3 shift = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < 600; ++i) {
        assert_int_equal(pli_world_predict(world, 1.0f / 60.0f), PLI_OK);
        assert_int_equal(pli_world_collide_rigid(world, body, rigid), PLI_OK);
        assert_int_equal(pli_world_solve(world), PLI_OK);
        if (i < 540 || i % 10 != 0) { continue; }
        const pli_body_view view = pli_body_get_view(body);
        for (int n = 0; n < view.node_count; ++n) {
            const pli_vec3 p = pli_vec3_make(view.positions[n].x, view.positions[n].y, view.positions[n].z);
            deepest = fminf(deepest, pli_shape_distance(truth, p, NULL));
            lowest = fminf(lowest, p.y);
            if (i == 540) { at_rest[n] = p; }
            if (i == 590) { shift = pli_vec3_add(shift, pli_vec3_sub(p, at_rest[n])); }
            farthest = fmaxf(farthest, pli_vec3_length(pli_vec3_sub(p, at_rest[n])));
        }
    }
    /* In the last second no node is inside; the cloth still creeps and its hem sways, as on the exact mesh. */
    assert_true(deepest > 0.0f);
    assert_true(lowest > -1.0f);
    check_at_most(farthest, 0.1);
    check_at_most(pli_vec3_length(shift) / (24 * 24), 0.04);
    pli_world_destroy(world);
    pli_shape_release(truth);
    pli_shape_release(shape);
    surface_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sampled_sphere),
        cmocka_unit_test(test_sampled_torus),
        cmocka_unit_test(test_sampled_bunny),
        cmocka_unit_test(test_sampled_sphere_of_any_size),
        cmocka_unit_test(test_sampled_mesh_at_points_far_away),
        cmocka_unit_test(test_sampled_mesh_with_holes),
        cmocka_unit_test(test_sampled_mesh_with_a_wide_hole),
        cmocka_unit_test(test_sampled_mesh_with_bad_triangles),
        cmocka_unit_test(test_sampled_mesh_turned_over),
        cmocka_unit_test(test_sampled_mesh_of_several_components),
        cmocka_unit_test(test_sampled_mesh_survives_every_failing_allocation),
        cmocka_unit_test(test_sampled_mesh_refuses_bad_input),
        cmocka_unit_test(test_cloth_stays_on_a_sampled_bunny),
    };
    return cmocka_run_group_tests(tests, setup_context, teardown_context);
}
