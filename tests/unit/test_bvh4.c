/* Boxes near a point against a look at all of them. */

#include "check.h"
#include "geometry/bvh.h"
#include "math/bounds.h"

#include <stdlib.h>

#define MAX_BOXES 1100

static uint32_t random_bits(uint64_t* seed) {
    *seed = *seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*seed >> 33);
}
/* In [0, size). */
static float random_below(uint64_t* seed, float size) {
    return (float)(random_bits(seed) >> 7) / 16777216.0f * size;
}
static pli_vec3 random_vector(uint64_t* seed, float size) {
    const float x = random_below(seed, size), y = random_below(seed, size), z = random_below(seed, size);
    return pli_vec3_make(x, y, z);
}

static bool is_near(pli_bounds box, pli_vec3 p, float radius) {
    const pli_vec3 inside = plii_vec3_min(plii_vec3_max(p, box.min), box.max);
    return pli_vec3_length_squared(pli_vec3_sub(p, inside)) <= radius * radius;
}

static const pli_bounds everything = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};

static int find(const plii_bvh4* boxes, pli_bounds around, pli_vec3 point, float radius, int* found) {
    int groups[PLII_BVH4_GROUP_ROOM(MAX_BOXES)];
    const int count = plii_bvh4_overlaps(boxes, &around, 1, groups);
    return plii_bvh4_find(boxes, groups, count, point, radius, found);
}

static void test_finds_what_is_near(void** state) {
    (void)state;
    static const int counts[] = {0, 1, 3, 4, 5, 16, 17, 64, 257, MAX_BOXES, 2};
    static pli_bounds bounds[MAX_BOXES];
    int found[PLII_BVH4_ROOM(MAX_BOXES)], total = 0;
    uint64_t seed = 7;
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    plii_bvh4 boxes = {0};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
        for (int i = 0; i < counts[c]; ++i) {
            bounds[i].min = random_vector(&seed, 10);
            bounds[i].max = pli_vec3_add(bounds[i].min, random_vector(&seed, 1));
        }
        assert_true(plii_bvh4_build(context, &boxes, counts[c], bounds, NULL));
        for (int k = 0; k < 200; ++k) {
            const pli_vec3 point = random_vector(&seed, 11);
            const float radius = random_below(&seed, 2);
            const int count = find(&boxes, plii_bounds_grow((pli_bounds){point, point}, radius), point, radius, found);
            int next = 0;
            for (int i = 0; i < counts[c]; ++i) {
                if (!is_near(bounds[i], point, radius)) { continue; }
                assert_true(next < count);
                assert_int_equal(found[next++], i);
            }
            assert_int_equal(next, count);
            total += count;

            const pli_bounds reach = {point, pli_vec3_add(point, random_vector(&seed, 2))};
            const int touching = plii_bvh4_overlaps(&boxes, &reach, 0, found);
            next = 0;
            for (int i = 0; i < counts[c]; ++i) {
                if (!plii_bounds_overlap(bounds[i], reach)) { continue; }
                assert_true(next < touching);
                assert_int_equal(found[next++], i);
            }
            assert_int_equal(next, touching);
        }
    }
    assert_true(total > 1000);
    assert_true((size_t)boxes.capacity * sizeof *boxes.groups >= MAX_BOXES * sizeof *bounds);
    plii_bvh4_free(context, &boxes);
    assert_int_equal(boxes.capacity, 0);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    pli_context_destroy(context);
}

/* A second build of the same size needs nothing. */
static void test_memory_is_kept(void** state) {
    (void)state;
    static const pli_bounds bounds[9] = {0};
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    plii_bvh4 boxes = {0};
    assert_true(plii_bvh4_build(context, &boxes, 9, bounds, NULL));
    const uint64_t count = pli_context_allocation_count(context);
    assert_true(plii_bvh4_build(context, &boxes, 9, bounds, NULL));
    assert_true(plii_bvh4_build(context, &boxes, 2, bounds, NULL));
    assert_int_equal(pli_context_allocation_count(context), count);
    plii_bvh4_free(context, &boxes);
    pli_context_destroy(context);
}

/* The boxes that fill up groups are found by no radius, no bounds and no point. */
static void test_finds_no_more_than_there_are(void** state) {
    (void)state;
    static const int counts[] = {1, 2, 3, 5, 6, 13, 17, 64, 67, 257};
    static const float radii[] = {1e19f, 1e20f, 3e38f, INFINITY, -INFINITY, NAN};
    static const pli_vec3 points[] = {{0, 0, 0}, {3e38f, -3e38f, 3e38f}, {INFINITY, 0, 0}, {NAN, NAN, NAN}};
    static pli_bounds bounds[257];
    int found[PLII_BVH4_ROOM(257)];
    uint64_t seed = 3;
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    plii_bvh4 boxes = {0};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
        const int count = counts[c];
        for (int i = 0; i < count; ++i) {
            bounds[i].min = random_vector(&seed, 10);
            bounds[i].max = pli_vec3_add(bounds[i].min, random_vector(&seed, 1));
        }
        assert_true(plii_bvh4_build(context, &boxes, count, bounds, NULL));
        for (size_t r = 0; r < sizeof radii / sizeof *radii; ++r) {
            for (size_t p = 0; p < sizeof points / sizeof *points; ++p) {
                const int near = find(&boxes, everything, points[p], radii[r], found);
                const bool has_numbers = !isnan(radii[r]) && !isnan(points[p].x);
                const bool is_near_all = has_numbers && (p == 0 || isinf(radii[r] * radii[r]));
                assert_int_equal(near, is_near_all ? count : 0);
                for (int i = 0; i < near; ++i) {
                    assert_int_equal(found[i], i);
                }
            }
        }
        assert_int_equal(plii_bvh4_overlaps(&boxes, &everything, 0, found), count);
        const pli_bounds nothing = {{NAN, NAN, NAN}, {NAN, NAN, NAN}};
        assert_int_equal(plii_bvh4_overlaps(&boxes, &nothing, 0, found), 0);
        /* Boxes that are not finite are found or not, once. */
        bounds[count / 2].min.x = bounds[0].max.y = NAN;
        bounds[count - 1].max = pli_vec3_make(INFINITY, INFINITY, INFINITY);
        bounds[count / 3].min.z = INFINITY;
        assert_true(plii_bvh4_build(context, &boxes, count, bounds, NULL));
        assert_in_range(find(&boxes, everything, points[0], INFINITY, found), 0, count);
        assert_in_range(plii_bvh4_overlaps(&boxes, &everything, 0, found), 0, count);
    }
    plii_bvh4_free(context, &boxes);
    pli_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_finds_what_is_near),
        cmocka_unit_test(test_memory_is_kept),
        cmocka_unit_test(test_finds_no_more_than_there_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
