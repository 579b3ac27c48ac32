/* Signed distances of the built-in shapes: against double-precision tests for inside and outside, against points of
   the surface, against finite differences, and against each other. */

#include "context_fixture.h"

#include "pliant/bullet_reference.h"
#include "pliant/shape.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS = 10000, SURFACE_POINTS = 500 };

/* Uniform in [-size, size]. */
static uint32_t random_state = 1;
static float random_float(float size) {
    random_state = random_state * 1664525u + 1013904223u;
    return ((float)(random_state >> 8) / 8388608.0f - 1.0f) * size;
}
static pli_vec3 random_vec3(float size) {
    const float x = random_float(size), y = random_float(size);
    return pli_vec3_make(x, y, random_float(size));
}

static bool is_finite(pli_vec3 v) {
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

/* What a signed distance must fulfil. `inside` > 0 within the shape, < 0 outside, 0 too close to tell. */
typedef int inside_fn(pli_vec3 p, const void* user);

static void check_shape(const pli_shape* shape, float size, float tolerance, float gradient_tolerance,
                        inside_fn* inside, const void* user) {
    pli_vec3* surface = malloc(sizeof(pli_vec3) * SURFACE_POINTS);
    assert_non_null(surface);
    int surface_count = 0;
    pli_vec3 n;
    while (surface_count < SURFACE_POINTS) {
        const pli_vec3 p = random_vec3(size);
        const float d = pli_shape_distance(shape, p, &n);
        surface[surface_count++] = pli_vec3_sub(p, pli_vec3_scale(n, d));
    }
    const pli_bounds bounds = pli_shape_bounds(shape);
    int smooth = 0;
    for (int i = 0; i < POINTS; ++i) {
        const pli_vec3 p = random_vec3(size);
        const float d = pli_shape_distance(shape, p, &n);
        check_near(pli_vec3_length(n), 1.0, 1e-6);

        /* The sign. */
        const int expected = inside(p, user);
        if (expected > 0) { check_at_most(d, tolerance); }
        if (expected < 0) { check_at_most(-d, tolerance); }
        if (p.x < bounds.min.x || p.x > bounds.max.x || p.y < bounds.min.y || p.y > bounds.max.y ||
            p.z < bounds.min.z || p.z > bounds.max.z) {
            check_at_most(-d, tolerance);
        }

        /* At distance d along -n there is surface, and no point of the surface is closer. */
        const pli_vec3 foot = pli_vec3_sub(p, pli_vec3_scale(n, d));
        check_near(pli_shape_distance(shape, foot, NULL), 0.0, tolerance);
        float nearest_squared = INFINITY;
        for (int k = 0; k < surface_count; ++k) {
            const float squared = pli_vec3_length_squared(pli_vec3_sub(p, surface[k]));
            if (squared < nearest_squared) { nearest_squared = squared; }
        }
        check_at_most(fabsf(d) - sqrtf(nearest_squared), tolerance);

        /* Away from creases the normal is the gradient. */
        const float h = 1e-3f;
        pli_vec3 gradient, n1, n2;
        float* components[3] = {&gradient.x, &gradient.y, &gradient.z};
        bool is_smooth = true;
        for (int axis = 0; axis < 3; ++axis) {
            pli_vec3 a = p, b = p;
            (axis == 0 ? &a.x : axis == 1 ? &a.y : &a.z)[0] -= h;
            (axis == 0 ? &b.x : axis == 1 ? &b.y : &b.z)[0] += h;
            const float low = pli_shape_distance(shape, a, &n1), high = pli_shape_distance(shape, b, &n2);
            *components[axis] = (high - low) / (2 * h);
            is_smooth = is_smooth && pli_vec3_length(pli_vec3_sub(n1, n2)) < 0.01f;
        }
        if (is_smooth) {
            ++smooth;
            check_at_most(pli_vec3_length(pli_vec3_sub(gradient, n)), gradient_tolerance);
        }
    }
    assert_true(smooth > POINTS / 2);
    free(surface);
}

// ------------------------------------------------------------------------------------------------ analytic shapes

static int inside_sphere(pli_vec3 p, const void* user) {
    const double r = *(const double*)user;
    const double d = r * r - (double)p.x * (double)p.x - (double)p.y * (double)p.y - (double)p.z * (double)p.z;
    return d > 1e-5 ? 1 : d < -1e-5 ? -1 : 0;
}

static void test_shape_sphere(void** state) {
    (void)state;
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_sphere(context, 0.8f, &shape), PLI_OK);
    check_shape(shape, 2.0f, 1e-6f, 2e-3f, inside_sphere, &(double){0.8});
    pli_vec3 n;
    check_near(pli_shape_distance(shape, pli_vec3_make(0, 0, 0), &n), -0.8, 1e-7);
    check_near(pli_vec3_length(n), 1, 0);
    check_near(pli_shape_distance(shape, pli_vec3_make(1e-20f, 0, 0), &n), -0.8, 1e-7);
    check_near(pli_vec3_length(n), 1, 0);
    pli_shape_release(shape);
}

static int inside_box(pli_vec3 p, const void* user) {
    const pli_vec3* h = user;
    const float d = fminf(fminf(h->x - fabsf(p.x), h->y - fabsf(p.y)), h->z - fabsf(p.z));
    return d > 1e-6f ? 1 : d < -1e-6f ? -1 : 0;
}

static void test_shape_box_has_sharp_edges(void** state) {
    (void)state;
    const pli_vec3 h = {0.5f, 1.0f, 0.25f};
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_box(context, h, &shape), PLI_OK);
    check_shape(shape, 2.0f, 1e-6f, 2e-3f, inside_box, &h);
    pli_vec3 n;
    /* From a corner, an edge, a side, the middle. */
    check_near(pli_shape_distance(shape, pli_vec3_make(0.6f, 1.1f, -0.35f), &n), 0.1 * sqrt(3), 1e-7);
    check_near(n.z, -1 / sqrt(3), 1e-6);
    check_near(pli_shape_distance(shape, pli_vec3_make(-0.8f, 0, 0.65f), &n), 0.5, 1e-7);
    check_near(n.x, -0.6, 1e-6);
    check_near(n.y, 0, 0);
    check_near(pli_shape_distance(shape, pli_vec3_make(0, 0, 0), &n), -0.25, 0);
    check_near(n.z, 1, 0);
    check_near(pli_shape_distance(shape, pli_vec3_make(0.5f, 1.0f, 0.25f), &n), 0, 0);
    check_near(n.x, 1, 0);
    pli_shape_release(shape);
}

typedef struct rod {
    pli_vec3 half;
    float radius;
} rod;

static void rod_coordinates(pli_vec3 p, const rod* r, double* along, double* across) {
    const double ax = (double)r->half.x, ay = (double)r->half.y, az = (double)r->half.z;
    const double length = sqrt(ax * ax + ay * ay + az * az);
    const double x = (double)p.x, y = (double)p.y, z = (double)p.z;
    *along = length > 0 ? (x * ax + y * ay + z * az) / length : 0;
    *across = sqrt(fmax(0, x * x + y * y + z * z - *along * *along));
}

static int inside_capsule(pli_vec3 p, const void* user) {
    const rod* r = user;
    double along, across;
    rod_coordinates(p, r, &along, &across);
    const double beyond = fmax(0, fabs(along) - (double)pli_vec3_length(r->half));
    const double d = (double)r->radius - sqrt(beyond * beyond + across * across);
    return d > 1e-5 ? 1 : d < -1e-5 ? -1 : 0;
}

static int inside_cylinder(pli_vec3 p, const void* user) {
    const rod* r = user;
    double along, across;
    rod_coordinates(p, r, &along, &across);
    const double d = fmin((double)r->radius - across, (double)pli_vec3_length(r->half) - fabs(along));
    return d > 1e-5 ? 1 : d < -1e-5 ? -1 : 0;
}

static const rod rods[] = {
    {{0, 0.7f, 0}, 0.4f}, {{0.5f, 0, 0}, 0.2f}, {{0.3f, -0.6f, 0.45f}, 0.5f}, {{-0.01f, 0.02f, 0.9f}, 1.1f}};

static void test_shape_capsule(void** state) {
    (void)state;
    for (size_t i = 0; i < sizeof rods / sizeof *rods; ++i) {
        pli_shape* shape = NULL;
        assert_int_equal(pli_shape_create_capsule(context, rods[i].half, rods[i].radius, &shape), PLI_OK);
        check_shape(shape, 2.0f, 2e-6f, 2e-3f, inside_capsule, &rods[i]);
        pli_vec3 n;
        check_near(pli_shape_distance(shape, pli_vec3_make(0, 0, 0), &n), -rods[i].radius, 0);
        check_near(pli_vec3_length(n), 1, 1e-6);
        check_near(pli_vec3_dot(n, rods[i].half), 0, 1e-6);
        pli_shape_release(shape);
    }
    /* Without a length it is a sphere. */
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_capsule(context, pli_vec3_make(0, 0, 0), 0.5f, &shape), PLI_OK);
    check_near(pli_shape_distance(shape, pli_vec3_make(0, 2, 0), NULL), 1.5, 0);
    pli_shape_release(shape);
}

static void test_shape_cylinder(void** state) {
    (void)state;
    for (size_t i = 0; i < sizeof rods / sizeof *rods; ++i) {
        pli_shape* shape = NULL;
        assert_int_equal(pli_shape_create_cylinder(context, rods[i].half, rods[i].radius, &shape), PLI_OK);
        check_shape(shape, 2.0f, 2e-6f, 2e-3f, inside_cylinder, &rods[i]);
        pli_vec3 n;
        pli_shape_distance(shape, pli_vec3_make(0, 0, 0), &n);
        check_near(pli_vec3_length(n), 1, 1e-6);
        pli_shape_release(shape);
    }
}

static void test_shape_plane(void** state) {
    (void)state;
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_plane(context, pli_vec3_make(0, 3, 0), 2.0f, &shape), PLI_OK);
    pli_vec3 n;
    check_near(pli_shape_distance(shape, pli_vec3_make(5, 2.5f, -7), &n), 0.5, 0);
    check_near(n.y, 1, 0);
    check_near(pli_shape_distance(shape, pli_vec3_make(5, -7, 1), NULL), -9, 0);
    const pli_bounds bounds = pli_shape_bounds(shape);
    check_near(bounds.max.y, 2, 0);
    assert_true(isinf(bounds.min.y) && isinf(bounds.max.x) && isinf(bounds.min.z));
    pli_shape_release(shape);
    assert_int_equal(pli_shape_create_plane(context, pli_vec3_make(1, 1, 1), 0, &shape), PLI_OK);
    check_near(pli_shape_distance(shape, pli_vec3_make(1, 1, 1), NULL), sqrt(3), 1e-6);
    assert_true(isinf(pli_shape_bounds(shape).max.y));
    pli_shape_release(shape);
}

// ------------------------------------------------------------------------------------------------- triangle mesh

static const int box_triangles[] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                    2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

static void box_corners(pli_vec3 h, pli_vec3 points[8]) {
    for (int i = 0; i < 8; ++i) {
        points[i] = pli_vec3_make((i & 1) != 0 ? h.x : -h.x, (i & 2) != 0 ? h.y : -h.y, (i & 4) != 0 ? h.z : -h.z);
    }
}

/* Both see the same box; where the nearest side is not ambiguous the normals agree too. */
static void check_equals_box(const pli_shape* shape, pli_vec3 h) {
    pli_shape* box = NULL;
    assert_int_equal(pli_shape_create_box(context, h, &box), PLI_OK);
    for (int i = 0; i < POINTS; ++i) {
        const pli_vec3 p = random_vec3(2.0f);
        pli_vec3 n, m;
        const float d = pli_shape_distance(shape, p, &n), e = pli_shape_distance(box, p, &m);
        check_near(d, e, 1e-6);
        const pli_vec3 q = {h.x - fabsf(p.x), h.y - fabsf(p.y), h.z - fabsf(p.z)};
        const bool is_ambiguous =
            e < 0 && (fabsf(q.x - q.y) < 1e-5f || fabsf(q.y - q.z) < 1e-5f || fabsf(q.x - q.z) < 1e-5f);
        if (!is_ambiguous && fabsf(e) > 1e-4f) { check_at_most(pli_vec3_length(pli_vec3_sub(n, m)), 2e-3); }
    }
    pli_shape_release(box);
}

static void test_shape_mesh_of_a_box_equals_the_box(void** state) {
    (void)state;
    const pli_vec3 h = {0.5f, 1.0f, 0.25f};
    pli_vec3 corners[8];
    box_corners(h, corners);
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_triangle_mesh(context, 8, corners, 12, box_triangles, 0.01f, &shape), PLI_OK);
    check_shape(shape, 2.0f, 1e-6f, 2e-3f, inside_box, &h);
    check_equals_box(shape, h);
    pli_shape_release(shape);

    /* The same as loose triangles, each with corners of its own, and with triangles that have no area. */
    pli_vec3 points[45];
    int triangles[45];
    for (int i = 0; i < 36; ++i) {
        points[i] = corners[box_triangles[i]];
    }
    for (int i = 36; i < 45; ++i) {
        points[i] = corners[i < 39 ? 5 : i < 42 ? i % 2 : i % 3 == 0 ? 3 : 1];
    }
    for (int i = 0; i < 45; ++i) {
        triangles[i] = i;
    }
    assert_int_equal(pli_shape_create_triangle_mesh(context, 45, points, 15, triangles, 0.01f, &shape), PLI_OK);
    check_equals_box(shape, h);
    pli_shape_release(shape);
}

// ---------------------------------------------------------------------------------------------------- convex hull

/* Over the edge between two triangles of one plane the normal is that of the plane, however close the point. */
static void test_shape_mesh_is_smooth_over_flat_edges(void** state) {
    (void)state;
    pli_vec3 corners[8];
    box_corners(pli_vec3_make(0.5f, 1.0f, 0.25f), corners);
    for (int i = 0; i < 8; ++i) {
        corners[i] = pli_vec3_add(corners[i], pli_vec3_make(9, 7, 8));
    }
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_triangle_mesh(context, 8, corners, 12, box_triangles, 0.01f, &shape), PLI_OK);
    for (int i = 1; i < 100; ++i) {
        /* The sides at greatest and least z are split from corner 5 to 6 and from 1 to 2. */
        for (int k = 0; k < 2; ++k) {
            const float t = 0.01f * (float)i, sign = k == 0 ? 1.0f : -1.0f;
            pli_vec3 p = pli_vec3_lerp(corners[k == 0 ? 5 : 1], corners[k == 0 ? 6 : 2], t);
            p.z += sign * 2e-5f;
            pli_vec3 n;
            check_near(pli_shape_distance(shape, p, &n), (p.z - corners[k == 0 ? 5 : 1].z) * sign, 1e-6);
            check_near(n.z, sign, 1e-6);
        }
    }
    pli_shape_release(shape);
}

enum { DIRECTIONS = 2000 };
typedef struct cloud {
    int count;
    pli_vec3 points[60];
    float radius;
    pli_vec3 directions[DIRECTIONS];
    float reach[DIRECTIONS]; /* of the points along each direction */
} cloud;

static void test_shape_hull_of_a_box_equals_the_box(void** state) {
    (void)state;
    const pli_vec3 h = {0.5f, 1.0f, 0.25f};
    pli_vec3 points[40];
    box_corners(h, points);
    for (int i = 8; i < 40; ++i) {
        points[i] = pli_vec3_make(random_float(h.x), random_float(h.y), random_float(h.z));
    }
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_convex_hull(context, 40, points, 0, &shape), PLI_OK);
    check_shape(shape, 2.0f, 1e-6f, 2e-3f, inside_box, &h);
    check_equals_box(shape, h);
    pli_shape_release(shape);
}

static void cloud_measure(cloud* c) {
    for (int i = 0; i < DIRECTIONS; ++i) {
        /* A spiral. */
        const float y = 1 - 2 * ((float)i + 0.5f) / DIRECTIONS, r = sqrtf(1 - y * y), a = 2.3999632f * (float)i;
        c->directions[i] = pli_vec3_make(r * cosf(a), y, r * sinf(a));
        c->reach[i] = -INFINITY;
        for (int k = 0; k < c->count; ++k) {
            c->reach[i] = fmaxf(c->reach[i], pli_vec3_dot(c->directions[i], c->points[k]));
        }
    }
}

/* Outside when beyond all points in some direction; inside when well short of them in all. */
static int inside_cloud(pli_vec3 p, const void* user) {
    const cloud* c = user;
    float least = INFINITY;
    for (int i = 0; i < DIRECTIONS; ++i) {
        least = fminf(least, c->reach[i] + c->radius - pli_vec3_dot(c->directions[i], p));
    }
    return least < -1e-5f ? -1 : least > 0.06f ? 1 : 0;
}

static void test_shape_hull_of_points_with_a_radius(void** state) {
    (void)state;
    cloud c = {.count = 60};
    for (int i = 0; i < c.count; ++i) {
        c.points[i] = random_vec3(0.8f);
    }
    cloud_measure(&c);
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_convex_hull(context, c.count, c.points, 0, &shape), PLI_OK);
    check_shape(shape, 1.5f, 2e-6f, 4e-3f, inside_cloud, &c);
    pli_shape* round = NULL;
    c.radius = 0.1f;
    assert_int_equal(pli_shape_create_convex_hull(context, c.count, c.points, c.radius, &round), PLI_OK);
    check_shape(round, 1.5f, 2e-6f, 4e-3f, inside_cloud, &c);
    for (int i = 0; i < POINTS; ++i) {
        const pli_vec3 p = random_vec3(1.5f);
        check_near(pli_shape_distance(round, p, NULL), pli_shape_distance(shape, p, NULL) - 0.1f, 1e-6);
    }
    pli_shape_release(shape);
    pli_shape_release(round);
}

// ---------------------------------------------------------------------------------------------- meshes, continued

enum { TORUS_U = 24, TORUS_V = 12, TORUS_TRIANGLES = 2 * TORUS_U * TORUS_V };
typedef struct torus {
    pli_vec3 points[TORUS_U * TORUS_V];
    int triangles[3 * TORUS_TRIANGLES];
} torus;

static void torus_make(torus* t) {
    int n = 0;
    for (int i = 0; i < TORUS_U; ++i) {
        for (int j = 0; j < TORUS_V; ++j) {
            const float a = 6.2831853f * (float)i / TORUS_U, b = 6.2831853f * (float)j / TORUS_V;
            const float r = 1.0f + 0.4f * cosf(b);
            t->points[i * TORUS_V + j] = pli_vec3_make(r * cosf(a), r * sinf(a), 0.4f * sinf(b));
            const int p = i * TORUS_V + j, q = i * TORUS_V + (j + 1) % TORUS_V;
            const int r0 = (i + 1) % TORUS_U * TORUS_V + j, s = (i + 1) % TORUS_U * TORUS_V + (j + 1) % TORUS_V;
            const int quad[6] = {p, r0, q, q, r0, s};
            memcpy(&t->triangles[n], quad, sizeof quad);
            n += 6;
        }
    }
}

/* By the solid angle that the surface fills around the point. */
static int inside_torus(pli_vec3 p, const void* user) {
    const torus* t = user;
    double angle = 0;
    for (int i = 0; i < TORUS_TRIANGLES; ++i) {
        double v[3][3], length[3];
        for (int k = 0; k < 3; ++k) {
            const pli_vec3 c = t->points[t->triangles[3 * i + k]];
            v[k][0] = (double)c.x - (double)p.x;
            v[k][1] = (double)c.y - (double)p.y;
            v[k][2] = (double)c.z - (double)p.z;
            length[k] = sqrt(v[k][0] * v[k][0] + v[k][1] * v[k][1] + v[k][2] * v[k][2]);
        }
        const double volume = v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) +
                              v[0][1] * (v[1][2] * v[2][0] - v[1][0] * v[2][2]) +
                              v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
        double below = length[0] * length[1] * length[2];
        for (int k = 0; k < 3; ++k) {
            const double *a = v[k], *b = v[(k + 1) % 3];
            below += (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * length[(k + 2) % 3];
        }
        angle += 2 * atan2(volume, below);
    }
    return fabs(angle) > 6.2831853 ? 1 : -1;
}

static void test_shape_mesh_that_is_not_convex(void** state) {
    (void)state;
    torus* t = malloc(sizeof *t);
    assert_non_null(t);
    torus_make(t);
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_triangle_mesh(context, TORUS_U * TORUS_V, t->points, TORUS_TRIANGLES,
                                                    t->triangles, 0.01f, &shape),
                     PLI_OK);
    check_shape(shape, 1.6f, 2e-6f, 2e-3f, inside_torus, t);
    pli_shape_release(shape);
    free(t);
}

static void test_shape_open_mesh_is_a_floor(void** state) {
    (void)state;
    /* 4 x 4 squares of 1 m in the plane y = 0, front side up. */
    pli_vec3 points[25];
    int triangles[96];
    for (int i = 0; i < 25; ++i) {
        points[i] = pli_vec3_make((float)(i % 5) - 2, 0, (float)(i / 5) - 2);
    }
    for (int i = 0; i < 16; ++i) {
        const int p = i / 4 * 5 + i % 4;
        const int quad[6] = {p, p + 5, p + 1, p + 1, p + 5, p + 6};
        memcpy(&triangles[6 * i], quad, sizeof quad);
    }
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_triangle_mesh(context, 25, points, 32, triangles, 0.2f, &shape), PLI_OK);
    for (int i = 0; i < POINTS; ++i) {
        const pli_vec3 p = random_vec3(1.9f);
        pli_vec3 n;
        const float d = pli_shape_distance(shape, p, &n);
        if (p.y < -0.2f) {
            assert_true(isinf(d));
        } else {
            check_near(d, p.y, 1e-7);
            check_near(n.y, 1, 1e-6);
        }
    }
    check_near(pli_shape_bounds(shape).min.y, -0.2, 1e-6); /* with the inside */
    /* Beyond its border it is never inside. */
    pli_vec3 n;
    check_near(pli_shape_distance(shape, pli_vec3_make(2.03f, -0.04f, 0.3f), &n), 0.05, 1e-6);
    check_near(n.x, 0.6, 1e-4);
    check_near(n.y, -0.8, 1e-4);
    check_near(pli_shape_distance(shape, pli_vec3_make(2.03f, 0.04f, -0.3f), &n), 0.05, 1e-6);
    check_near(n.y, 0.8, 1e-4);
    pli_shape_release(shape);
}

// --------------------------------------------------------------------------------------------------- life, errors

/* Each part of a mesh is open or closed by itself: a floor of many squares, and an octahedron over it. */
static void test_shape_parts_are_open_or_closed(void** state) {
    (void)state;
    enum { SIDE = 7, FLOOR = SIDE * SIDE };
    static const pli_vec3 corners[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    static const int faces[] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    pli_vec3 points[FLOOR + 6];
    int triangles[6 * FLOOR + 24], places[FLOOR], placed = 0, count = 0;
    /* Points from the border inwards, squares from the middle outwards: what is open is known last. */
    for (int ring = SIDE / 2; ring >= 0; --ring) {
        for (int i = 0; i < FLOOR; ++i) {
            const int x = i % SIDE - SIDE / 2, z = i / SIDE - SIDE / 2;
            if ((abs(x) > abs(z) ? abs(x) : abs(z)) != ring) { continue; }
            points[placed] = pli_vec3_make((float)x, 0, (float)z);
            places[i] = placed++;
        }
    }
    for (int ring = 0; ring < SIDE / 2; ++ring) {
        for (int i = 0; i < FLOOR - SIDE; ++i) {
            const int x = 2 * (i % SIDE) - SIDE + 2, z = 2 * (i / SIDE) - SIDE + 2; /* twice those of the middle */
            if (i % SIDE + 1 == SIDE || (abs(x) > abs(z) ? abs(x) : abs(z)) != 2 * ring + 1) { continue; }
            const int square[6] = {i, i + SIDE, i + 1, i + 1, i + SIDE, i + SIDE + 1};
            for (int k = 0; k < 6; ++k) {
                triangles[count++] = places[square[k]];
            }
        }
    }
    assert_int_equal(count, 6 * (SIDE - 1) * (SIDE - 1));
    for (int i = 0; i < 6; ++i) {
        points[FLOOR + i] = pli_vec3_add(corners[i], pli_vec3_make(0, 3, 0));
    }
    for (int i = 0; i < 24; ++i) {
        triangles[count++] = FLOOR + faces[i];
    }
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create_triangle_mesh(context, FLOOR + 6, points, count / 3, triangles, 0.25f, &shape),
                     PLI_OK);
    check_near(pli_shape_distance(shape, pli_vec3_make(0, 3, 0), NULL), -1.0 / sqrt(3.0), 1e-6);
    for (int i = 0; i < 36; ++i) {
        const pli_vec3 below = pli_vec3_make((float)(i % 6) - 2.6f, -0.2f, (float)(i / 6) - 2.6f);
        check_near(pli_shape_distance(shape, below, NULL), -0.2, 1e-6);
        assert_true(isinf(pli_shape_distance(shape, pli_vec3_make(below.x, -0.3f, below.z), NULL)));
    }
    pli_shape_release(shape);
}

static int destroyed;
static void custom_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                             pli_vec3* normals) {
    (void)user;
    (void)max_distance;
    for (int i = 0; i < count; ++i) {
        distances[i] = points[i].y;
        normals[i] = pli_vec3_make(0, 1, 0);
    }
}
static pli_bounds custom_bounds(const void* user) {
    (void)user;
    return (pli_bounds){{-1, -1, -1}, {1, 0, 1}};
}
static void custom_destroy(void* user) {
    assert_ptr_equal(user, &destroyed);
    ++destroyed;
}

/* A floor that is listed twice has a border too, whatever corners its triangles begin with. */
static void test_shape_triangles_that_come_again_count_once(void** state) {
    (void)state;
    const pli_vec3 points[4] = {{-1, 0, -1}, {1, 0, -1}, {-1, 0, 1}, {1, 0, 1}};
    const int triangles[12] = {0, 2, 1, 1, 2, 3, 2, 1, 0, 3, 1, 2};
    pli_shape *once = NULL, *twice = NULL;
    assert_int_equal(pli_shape_create_triangle_mesh(context, 4, points, 2, triangles, 0.1f, &once), PLI_OK);
    assert_int_equal(pli_shape_create_triangle_mesh(context, 4, points, 4, triangles, 0.1f, &twice), PLI_OK);
    int behind = 0;
    for (int i = 0; i < POINTS; ++i) {
        const pli_vec3 p = random_vec3(4);
        const float d = pli_shape_distance(once, p, NULL);
        behind += isinf(d);
        assert_true(pli_shape_distance(twice, p, NULL) == d);
    }
    assert_true(behind > 0);
    pli_shape_release(once);
    pli_shape_release(twice);
}

static void test_shape_is_destroyed_with_the_last_reference(void** state) {
    (void)state;
    destroyed = 0;
    pli_shape_def def = pli_shape_def_default();
    def.distances = custom_distances;
    def.bounds = custom_bounds;
    def.destroy = custom_destroy;
    def.user = &destroyed;
    pli_shape* shape = NULL;
    assert_int_equal(pli_shape_create(context, &def, &shape), PLI_OK);
    pli_shape_retain(shape);
    pli_shape_release(shape);
    assert_int_equal(destroyed, 0);
    check_near(pli_shape_distance(shape, pli_vec3_make(0, 4, 0), NULL), 4, 0);
    pli_shape_release(shape);
    assert_int_equal(destroyed, 1);
    pli_shape_release(NULL);
    pli_shape_retain(NULL);
}

/* An allocator whose n-th allocation fails. */
static int allocations_left;
static void* failing_allocate(size_t size, size_t alignment, void* user) {
    (void)user;
    if (allocations_left-- <= 0) { return NULL; }
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}
static void failing_release(void* block, size_t size, void* user) {
    (void)size;
    (void)user;
    free(block);
}

static void test_shape_survives_every_failing_allocation(void** state) {
    (void)state;
    pli_context_def def = pli_context_def_default();
    def.allocator.allocate = failing_allocate;
    def.allocator.release = failing_release;
    pli_context* scarce = NULL;
    allocations_left = 1;
    assert_int_equal(pli_context_create(&def, &scarce), PLI_OK);
    pli_vec3 corners[8];
    box_corners(pli_vec3_make(1, 1, 1), corners);
    for (int kind = 0; kind < 3; ++kind) {
        pli_status status = PLI_ERROR_OUT_OF_MEMORY;
        int n = 0;
        for (; status != PLI_OK; ++n) {
            assert_true(n < 100);
            pli_shape *shape = NULL, *box = NULL;
            allocations_left = 2;
            assert_int_equal(pli_shape_create_box(scarce, pli_vec3_make(1, 1, 1), &box), PLI_OK);
            allocations_left = n;
            status = kind == 0   ? pli_shape_create_convex_hull(scarce, 8, corners, 0, &shape)
                     : kind == 1 ? pli_shape_create_triangle_mesh(scarce, 8, corners, 12, box_triangles, 1, &shape)
                                 : pli_shape_create_lattice(scarce, box, 0.25f, &shape);
            if (status == PLI_OK) {
                /* A query without memory is slower, not wrong. */
                allocations_left = 0;
                check_near(pli_shape_distance(shape, pli_vec3_make(2, 0, 0), NULL), 1, 1e-6);
            } else {
                assert_int_equal(status, PLI_ERROR_OUT_OF_MEMORY);
                assert_null(shape);
            }
            pli_shape_release(shape);
            pli_shape_release(box);
            check_near(pli_context_allocated_bytes(scarce), 0, 0);
        }
        assert_true(n > 2);
    }
    pli_context_destroy(scarce);
}

static void check_refused(pli_status got, pli_status expected, const pli_shape* shape, const char* message) {
    assert_int_equal(got, expected);
    assert_null(shape);
    if (strstr(pli_last_error(context), message) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", pli_last_error(context), message);
    }
}

static void test_shape_refuses_bad_input(void** state) {
    (void)state;
    pli_shape* s = NULL;
    const pli_vec3 zero = {0, 0, 0}, one = {1, 1, 1}, bad = {1, NAN, 1};
    pli_shape_def def = pli_shape_def_default();
    check_refused(pli_shape_create(context, NULL, &s), PLI_ERROR_NULL_ARGUMENT, s, "def");
    check_refused(pli_shape_create(context, &def, &s), PLI_ERROR_NULL_ARGUMENT, s, "distances");
    def.distances = custom_distances;
    check_refused(pli_shape_create(context, &def, &s), PLI_ERROR_NULL_ARGUMENT, s, "bounds");
    def.cookie = 0;
    check_refused(pli_shape_create(context, &def, &s), PLI_ERROR_INVALID_DEF, s, "pli_shape_def_default");
    assert_int_equal(pli_shape_create_sphere(NULL, 1, &s), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_shape_create_sphere(context, 1, NULL), PLI_ERROR_NULL_ARGUMENT);
    check_refused(pli_shape_create_plane(context, zero, 0, &s), PLI_ERROR_INVALID_VALUE, s, "normal");
    check_refused(pli_shape_create_plane(context, bad, 0, &s), PLI_ERROR_NOT_FINITE, s, "normal");
    check_refused(pli_shape_create_plane(context, one, INFINITY, &s), PLI_ERROR_NOT_FINITE, s, "offset");
    check_refused(pli_shape_create_sphere(context, 0, &s), PLI_ERROR_INVALID_VALUE, s, "radius is 0");
    check_refused(pli_shape_create_sphere(context, NAN, &s), PLI_ERROR_NOT_FINITE, s, "radius");
    check_refused(pli_shape_create_box(context, zero, &s), PLI_ERROR_INVALID_VALUE, s, "half_extents");
    check_refused(pli_shape_create_box(context, bad, &s), PLI_ERROR_NOT_FINITE, s, "half_extents");
    check_refused(pli_shape_create_capsule(context, one, -1, &s), PLI_ERROR_INVALID_VALUE, s, "radius is -1");
    check_refused(pli_shape_create_capsule(context, bad, 1, &s), PLI_ERROR_NOT_FINITE, s, "half_segment");
    check_refused(pli_shape_create_cylinder(context, zero, 1, &s), PLI_ERROR_INVALID_VALUE, s, "half_axis");
    check_refused(pli_shape_create_cylinder(context, one, 0, &s), PLI_ERROR_INVALID_VALUE, s, "radius is 0");
    check_refused(pli_shape_create_cylinder(context, one, NAN, &s), PLI_ERROR_NOT_FINITE, s, "radius");
    const pli_vec3 line[3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, broken[3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, INFINITY}};
    const int good[3] = {0, 1, 2}, out[3] = {0, 1, 3};
    check_refused(pli_shape_create_triangle_mesh(context, 3, line, 1, good, 1, &s), PLI_ERROR_INVALID_MESH, s, "area");
    check_refused(pli_shape_create_triangle_mesh(context, 3, line, 1, out, 1, &s), PLI_ERROR_INDEX_OUT_OF_RANGE, s,
                  "triangle 0 names point 3, there are 3 points");
    check_refused(pli_shape_create_triangle_mesh(context, 3, broken, 1, good, 1, &s), PLI_ERROR_NOT_FINITE, s,
                  "point 2");
    check_refused(pli_shape_create_triangle_mesh(context, 3, line, 1, good, 0, &s), PLI_ERROR_INVALID_VALUE, s,
                  "thickness is 0");
    check_refused(pli_shape_create_triangle_mesh(context, 0, line, 1, good, 1, &s), PLI_ERROR_INVALID_MESH, s,
                  "0 points");
    check_refused(pli_shape_create_triangle_mesh(context, 3, NULL, 1, good, 1, &s), PLI_ERROR_NULL_ARGUMENT, s,
                  "points");

    const pli_vec3 flat[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    check_refused(pli_shape_create_convex_hull(context, 4, flat, 0, &s), PLI_ERROR_INVALID_MESH, s, "plane");
    check_refused(pli_shape_create_convex_hull(context, 4, flat, -1, &s), PLI_ERROR_INVALID_VALUE, s, "radius is -1");
    check_refused(pli_shape_create_convex_hull(context, 3, flat, 0, &s), PLI_ERROR_INVALID_VALUE, s, "3");
    check_refused(pli_shape_create_convex_hull(context, 4, NULL, 0, &s), PLI_ERROR_NULL_ARGUMENT, s, "points");
    check_refused(pli_shape_create_convex_hull(context, 3, broken, 0, &s), PLI_ERROR_NOT_FINITE, s, "point 2");

    /* Queries never crash. */
    assert_true(isinf(pli_shape_distance(NULL, one, NULL)));
    check_near(pli_shape_bounds(NULL).max.x, 0, 0);
    assert_int_equal(pli_shape_create_sphere(context, 1, &s), PLI_OK);
    pli_vec3 n;
    assert_true(isinf(pli_shape_distance(s, bad, &n)));
    assert_true(is_finite(n));
    pli_shape_release(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_shape_sphere),
        cmocka_unit_test(test_shape_box_has_sharp_edges),
        cmocka_unit_test(test_shape_capsule),
        cmocka_unit_test(test_shape_cylinder),
        cmocka_unit_test(test_shape_plane),
        cmocka_unit_test(test_shape_mesh_of_a_box_equals_the_box),
        cmocka_unit_test(test_shape_mesh_is_smooth_over_flat_edges),
        cmocka_unit_test(test_shape_hull_of_a_box_equals_the_box),
        cmocka_unit_test(test_shape_hull_of_points_with_a_radius),
        cmocka_unit_test(test_shape_mesh_that_is_not_convex),
        cmocka_unit_test(test_shape_parts_are_open_or_closed),
        cmocka_unit_test(test_shape_open_mesh_is_a_floor),
        cmocka_unit_test(test_shape_triangles_that_come_again_count_once),
        cmocka_unit_test(test_shape_is_destroyed_with_the_last_reference),
        cmocka_unit_test(test_shape_survives_every_failing_allocation),
        cmocka_unit_test(test_shape_refuses_bad_input),
    };
    return cmocka_run_group_tests(tests, setup_context, teardown_context);
}
