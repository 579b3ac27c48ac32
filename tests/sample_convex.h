#ifndef TESTS_SAMPLE_CONVEX_H
#define TESTS_SAMPLE_CONVEX_H

/* Convex sets for tests: hulls of a few points, ordinary and hostile, with a count of support calls. */

#include "geometry/convex_distance.h"

#define SAMPLE_MAX_POINTS 20

typedef struct sample_hull {
    int count;
    pli_vec3 points[SAMPLE_MAX_POINTS];
    pli_vec3 centre;
    int calls;
} sample_hull;

static inline int sample_farthest(const void* user, pli_vec3 direction) {
    sample_hull* hull = (sample_hull*)(uintptr_t)user; /* the count is the test's business */
    ++hull->calls;
    int best = 0;
    float farthest = pli_vec3_dot(hull->points[0], direction);
    for (int i = 1; i < hull->count; ++i) {
        const float along = pli_vec3_dot(hull->points[i], direction);
        if (along > farthest) {
            farthest = along;
            best = i;
        }
    }
    return best;
}
static inline pli_vec3 sample_support(const void* user, pli_vec3 direction) {
    return ((const sample_hull*)user)->points[sample_farthest(user, direction)];
}

static inline plii_convex sample_convex(const sample_hull* hull) {
    const plii_convex convex = {.support = sample_support, .user = hull, .centre = hull->centre};
    return convex;
}
static inline uint32_t sample_random(uint64_t* seed) {
    *seed = *seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*seed >> 33);
}
/* In [-1, 1). */
static inline float sample_random_unit(uint64_t* seed) {
    return (float)(sample_random(seed) >> 7) / 8388608.0f - 1.0f;
}
static inline pli_vec3 sample_random_vector(uint64_t* seed) {
    const float x = sample_random_unit(seed), y = sample_random_unit(seed), z = sample_random_unit(seed);
    return pli_vec3_make(x, y, z);
}

static inline sample_hull sample_make(int count, const pli_vec3* points) {
    sample_hull hull = {.count = count};
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < count; ++i) {
        hull.points[i] = points[i];
        sum = pli_vec3_add(sum, points[i]);
    }
    hull.centre = pli_vec3_scale(sum, 1.0f / (float)count);
    return hull;
}

static inline sample_hull sample_box(pli_vec3 centre, pli_vec3 half) {
    pli_vec3 points[8];
    for (int i = 0; i < 8; ++i) {
        points[i] = pli_vec3_add(
            centre, pli_vec3_make(i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z));
    }
    return sample_make(8, points);
}

/* Kinds of hostile hulls; each random in place and size. */
enum {
    SAMPLE_POINT,
    SAMPLE_TWO_POINTS,
    SAMPLE_COLLINEAR,
    SAMPLE_FLAT,
    SAMPLE_FLAT_ON_GRID,
    SAMPLE_NEEDLE,
    SAMPLE_COINCIDENT,
    SAMPLE_BOX_ON_GRID,
    SAMPLE_SOLID,
    SAMPLE_KIND_COUNT
};

static inline sample_hull sample_hostile(int kind, float size, pli_vec3 place, uint64_t* seed) {
    pli_vec3 points[SAMPLE_MAX_POINTS];
    const pli_vec3 along = sample_random_vector(seed), across = sample_random_vector(seed);
    int count = 3 + (int)(sample_random(seed) % (SAMPLE_MAX_POINTS - 2));
    if (kind == SAMPLE_POINT) { count = 1; }
    if (kind == SAMPLE_TWO_POINTS) { count = 2; }
    if (kind == SAMPLE_BOX_ON_GRID) { count = 8; }
    for (int i = 0; i < count; ++i) {
        const float u = sample_random_unit(seed), v = sample_random_unit(seed);
        pli_vec3 p = sample_random_vector(seed);
        if (kind == SAMPLE_COLLINEAR) {
            p = pli_vec3_scale(along, u);
        } else if (kind == SAMPLE_FLAT) {
            p = pli_vec3_add(pli_vec3_scale(along, u), pli_vec3_scale(across, v));
        } else if (kind == SAMPLE_FLAT_ON_GRID) {
            p = pli_vec3_make(roundf(2 * u) / 2, 0, roundf(2 * v) / 2);
        } else if (kind == SAMPLE_NEEDLE) {
            p = pli_vec3_make(p.x, 1e-4f * p.y, 1e-4f * p.z);
        } else if (kind == SAMPLE_COINCIDENT) {
            p = pli_vec3_add(along, pli_vec3_scale(p, 1e-7f));
        } else if (kind == SAMPLE_BOX_ON_GRID) {
            p = pli_vec3_make(i & 1 ? 0.5f : -0.5f, i & 2 ? 0.5f : -0.5f, i & 4 ? 0.5f : -0.5f);
        }
        points[i] = pli_vec3_add(place, pli_vec3_scale(p, size));
    }
    sample_hull hull = sample_make(count, points);
    const uint32_t where = sample_random(seed) % 4;
    if (where == 1) { hull.centre = points[0]; }
    if (where == 2) { hull.centre = pli_vec3_add(hull.centre, pli_vec3_scale(along, 2 * size)); }
    return hull;
}

/* Two hostile hulls of like size, on, in, beside or far from each other. */
static inline void sample_hostile_pair(uint64_t* seed, sample_hull* a, sample_hull* b) {
    static const float sizes[5] = {1, 1e-4f, 1e4f, 1e-2f, 1e2f};
    static const float spreads[4] = {0, 1e-6f, 0.5f, 2};
    const float size = sizes[sample_random(seed) % 5];
    const float other_size = sample_random(seed) % 8 == 0 ? sizes[sample_random(seed) % 5] : size;
    const pli_vec3 place =
        sample_random(seed) % 4 == 0 ? pli_vec3_scale(sample_random_vector(seed), 1e4f) : pli_vec3_make(0, 0, 0);
    const uint32_t layout = sample_random(seed) % 5;
    pli_vec3 offset = pli_vec3_make(0, layout == 4 ? size : 0, 0);
    if (layout < 4) { offset = pli_vec3_scale(sample_random_vector(seed), spreads[layout] * size); }
    *a = sample_hostile((int)(sample_random(seed) % SAMPLE_KIND_COUNT), size, place, seed);
    if (sample_random(seed) % 8 == 0) {
        *b = *a;
        b->calls = 0;
        return;
    }
    *b = sample_hostile((int)(sample_random(seed) % SAMPLE_KIND_COUNT), other_size, pli_vec3_add(place, offset), seed);
}

/* How far the hull reaches along `n`, in double. */
static inline double sample_extent(const sample_hull* hull, plii_dvec3 n) {
    double farthest = -HUGE_VAL;
    for (int i = 0; i < hull->count; ++i) {
        const double along = plii_dvec3_dot(plii_dvec3_from(hull->points[i]), n);
        if (along > farthest) { farthest = along; }
    }
    return farthest;
}

/* Largest coordinate of both: what float rounding is measured by. */
static inline double sample_reach(const sample_hull* a, const sample_hull* b) {
    double reach = 0.0;
    for (int i = 0; i < a->count + b->count; ++i) {
        const pli_vec3 p = i < a->count ? a->points[i] : b->points[i - a->count];
        const double size = plii_dvec3_length(plii_dvec3_from(p));
        if (size > reach) { reach = size; }
    }
    return reach;
}

/* How far a has to move along the unit vector `normal` until it only touches b. */
static inline double sample_way(const sample_hull* a, const sample_hull* b, plii_dvec3 normal) {
    return sample_extent(b, normal) + sample_extent(a, plii_dvec3_scale(normal, -1.0));
}

#endif
