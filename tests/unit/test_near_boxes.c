/* Boxes near a point against a look at all of them. */

#include "check.h"
#include "near_boxes.h"

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

static void test_finds_what_is_near(void** state) {
    (void)state;
    static const int counts[] = {0, 1, 3, 4, 5, 16, 17, 64, 257, MAX_BOXES, 2};
    static pli_bounds bounds[MAX_BOXES];
    int found[MAX_BOXES], total = 0;
    uint64_t seed = 7;
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    plii_near_boxes boxes = {0};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; ++c) {
        for (int i = 0; i < counts[c]; ++i) {
            bounds[i].min = random_vector(&seed, 10);
            bounds[i].max = pli_vec3_add(bounds[i].min, random_vector(&seed, 1));
        }
        assert_true(plii_near_boxes_build(context, &boxes, counts[c], bounds));
        for (int k = 0; k < 200; ++k) {
            const pli_vec3 point = random_vector(&seed, 11);
            const float radius = random_below(&seed, 2);
            const int count = plii_near_boxes_find(&boxes, point, radius, found);
            int next = 0;
            for (int i = 0; i < counts[c]; ++i) {
                if (!is_near(bounds[i], point, radius)) { continue; }
                assert_true(next < count);
                assert_int_equal(found[next++], i);
            }
            assert_int_equal(next, count);
            total += count;

            const pli_bounds reach = {point, pli_vec3_add(point, random_vector(&seed, 2))};
            const int touching = plii_near_boxes_overlaps(&boxes, &reach, found);
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
    assert_true(plii_near_boxes_bytes(&boxes) >= MAX_BOXES * sizeof *bounds);
    plii_near_boxes_free(context, &boxes);
    assert_int_equal(plii_near_boxes_bytes(&boxes), 0);
    assert_int_equal(pli_context_allocated_bytes(context), 0);
    pli_context_destroy(context);
}

/* A second build of the same size needs nothing. */
static void test_memory_is_kept(void** state) {
    (void)state;
    static const pli_bounds bounds[9] = {0};
    pli_context* context = NULL;
    assert_int_equal(pli_context_create(NULL, &context), PLI_OK);
    plii_near_boxes boxes = {0};
    assert_true(plii_near_boxes_build(context, &boxes, 9, bounds));
    const uint64_t count = pli_context_allocation_count(context);
    assert_true(plii_near_boxes_build(context, &boxes, 9, bounds));
    assert_true(plii_near_boxes_build(context, &boxes, 2, bounds));
    assert_int_equal(pli_context_allocation_count(context), count);
    plii_near_boxes_free(context, &boxes);
    pli_context_destroy(context);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_finds_what_is_near),
        cmocka_unit_test(test_memory_is_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
