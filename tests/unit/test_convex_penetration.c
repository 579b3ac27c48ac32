/* Signed distance of overlapping cores by descent and the expanding polytope: exact values, results
   that are never less than the true depth, budgets that hold for every input. */

#include "check.h"
#include "geometry/convex_distance.h"
#include "sample_convex.h"

static plii_penetration_fn* const methods[2] = {NULL, plii_penetration_epa};

static plii_convex_result run(const sample_hull* a, const sample_hull* b, plii_penetration_fn* method,
                              plii_convex_cache* cache) {
    const plii_convex convex_a = sample_convex(a), convex_b = sample_convex(b);
    plii_convex_options options = {.max_distance = INFINITY};
    options.penetration = method;
    plii_convex_result result;
    plii_convex_distance(&convex_a, &convex_b, &options, cache, &result);
    return result;
}

static void test_boxes(void** state) {
    (void)state;
    const sample_hull a = sample_box(pli_vec3_make(0.5f, 1.75f, -0.25f), pli_vec3_make(1, 1, 1));
    const sample_hull b = sample_box(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 1, 1));
    for (int i = 0; i < 2; ++i) {
        const plii_convex_result r = run(&a, &b, methods[i], NULL);
        assert_int_equal(r.relation, PLII_CONVEX_OVERLAPPING);
        check_near(r.distance, -0.25, 1e-6);
        check_near(r.normal.y, 1.0, 1e-6);
        check_near(r.point_a.y, 0.75, 1e-6);
        check_near(r.point_b.y, 1.0, 1e-6);
        check_near(r.point_a.x, r.point_b.x, 1e-6);
        assert_true(fabsf(r.point_a.x) <= 1 && r.point_a.x >= -0.5f); /* on both */
    }
}

static void test_turned_box_corner(void** state) {
    (void)state;
    /* A box on its corner, 0.1 deep in a floor. */
    pli_vec3 points[8];
    const float s = 0.5f / sqrtf(3.0f), height = 0.5f - 0.1f;
    sample_hull a = sample_box(pli_vec3_make(0, 0, 0), pli_vec3_make(s, s, s));
    const pli_mat3 turn = {{{sqrtf(0.5f), -sqrtf(0.5f), 0},
                            {1 / sqrtf(3.0f), 1 / sqrtf(3.0f), 1 / sqrtf(3.0f)},
                            {-1 / sqrtf(6.0f), -1 / sqrtf(6.0f), sqrtf(2.0f / 3.0f)}}};
    for (int i = 0; i < 8; ++i) {
        points[i] = pli_vec3_add(pli_mat3_mul_vec3(turn, a.points[i]), pli_vec3_make(0.3f, height, -0.2f));
    }
    a = sample_make(8, points);
    const sample_hull b = sample_box(pli_vec3_make(0, -1, 0), pli_vec3_make(5, 1, 5));
    for (int i = 0; i < 2; ++i) {
        const plii_convex_result r = run(&a, &b, methods[i], NULL);
        check_near(r.distance, -0.1, 1e-6);
        check_near(r.normal.y, 1.0, 1e-6);
        check_near(r.point_a.x, 0.3, 1e-6);
        check_near(r.point_a.y, -0.1, 1e-6);
        check_near(r.point_b.y, 0.0, 1e-6);
        check_near(r.point_b.z, -0.2, 1e-6);
    }
}

static void test_apart_and_beyond(void** state) {
    (void)state;
    const sample_hull a = sample_box(pli_vec3_make(0, 2.5f, 0), pli_vec3_make(1, 1, 1));
    const sample_hull b = sample_box(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 1, 1));
    const plii_convex_result r = run(&a, &b, NULL, NULL);
    assert_int_equal(r.relation, PLII_CONVEX_SEPARATED);
    check_near(r.distance, 0.5, 1e-6);
    check_near(r.normal.y, 1.0, 1e-6);

    const plii_convex convex_a = sample_convex(&a), convex_b = sample_convex(&b);
    const plii_convex_options options = {.max_distance = 0.25f};
    plii_convex_result far;
    plii_convex_distance(&convex_a, &convex_b, &options, NULL, &far);
    assert_int_equal(far.relation, PLII_CONVEX_BEYOND);
    assert_int_equal(far.support_calls, 2);
}

/* Touching or flat sets: depth 0 and still a unit normal. */
static void test_degenerate_overlaps(void** state) {
    (void)state;
    const pli_vec3 point[1] = {{3, 4, 5}};
    const pli_vec3 square[4] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
    const pli_vec3 line[2] = {{-0.5f, 0, 0}, {0.5f, 0, 0}};
    const sample_hull p = sample_make(1, point), flat = sample_make(4, square), segment = sample_make(2, line);
    const sample_hull box = sample_box(pli_vec3_make(0, 1, 0), pli_vec3_make(1, 1, 1));
    const sample_hull* pairs[6][2] = {{&p, &p},          {&flat, &flat}, {&segment, &segment},
                                      {&flat, &segment}, {&box, &flat},  {&flat, &box}};
    for (int i = 0; i < 2; ++i) {
        for (int k = 0; k < 6; ++k) {
            const plii_convex_result r = run(pairs[k][0], pairs[k][1], methods[i], NULL);
            assert_int_equal(r.relation, PLII_CONVEX_OVERLAPPING);
            check_near(r.distance, 0.0, 1e-7);
            check_near(pli_vec3_length(r.normal), 1.0, 1e-6);
        }
        const plii_convex_result r = run(&box, &flat, methods[i], NULL);
        check_near(r.normal.y, 1.0, 1e-6);
    }
}

/* The normal of the last frame starts the search of the next: an overlap that grows deep keeps its side. */
static void test_cache_keeps_the_side(void** state) {
    (void)state;
    const sample_hull b = sample_box(pli_vec3_make(0, 0, 0), pli_vec3_make(4, 1, 4));
    plii_convex_cache cache = {.count = 0};
    for (int frame = 0; frame < 40; ++frame) {
        const sample_hull a =
            sample_box(pli_vec3_make(0, 1.6f - 0.05f * (float)frame, 0), pli_vec3_make(0.5f, 0.5f, 0.5f));
        const plii_convex_result r = run(&a, &b, NULL, &cache);
        const double expected = 0.1 - 0.05 * (double)frame;
        if (frame > 30) { continue; } /* past the middle the other side is nearer */
        check_near(r.distance, expected, 1e-5);
        check_near(r.normal.y, 1.0, 1e-5);
    }
}

/* Every result is finite, consistent and proven by support planes not to be less than the true depth; the number of
   support calls is as reported and within the budget. */
static void check_result(const sample_hull* a, const sample_hull* b, const plii_convex_result* r) {
    const double reach = sample_reach(a, b);
    check_at_most(r->support_calls, PLII_CONVEX_MAX_SUPPORT_CALLS);
    assert_int_equal(a->calls + b->calls, r->support_calls);
    assert_true(r->relation == PLII_CONVEX_SEPARATED || r->relation == PLII_CONVEX_OVERLAPPING);
    assert_true(plii_is_finite(r->distance) && plii_vec3_is_finite(r->point_a) && plii_vec3_is_finite(r->point_b));
    check_near(pli_vec3_length(r->normal), 1.0, 1e-6);
    const pli_vec3 between = pli_vec3_sub(r->point_a, r->point_b);
    const pli_vec3 error = pli_vec3_sub(between, pli_vec3_scale(r->normal, r->distance));
    check_at_most(pli_vec3_length(error), 1e-6 * reach);
    if (r->relation == PLII_CONVEX_OVERLAPPING) {
        check_at_most(r->distance, 0.0);
        check_near(sample_way(a, b, plii_dvec3_from(r->normal)), -(double)r->distance, 1e-6 * reach);
    }
}

static void run_hostile(uint64_t seed, int count) {
    int overlapping = 0;
    plii_convex_cache shared = {.count = 0};
    for (int i = 0; i < count; ++i) {
        sample_hull a, b;
        sample_hostile_pair(&seed, &a, &b);
        const plii_convex convex_a = sample_convex(&a), convex_b = sample_convex(&b);
        plii_convex_options options = {.max_distance = INFINITY};
        for (int k = 0; k < 2; ++k) {
            options.penetration = methods[k];
            plii_convex_result r;
            plii_convex_distance(&convex_a, &convex_b, &options, i % 3 == 0 ? &shared : NULL, &r);
            check_result(&a, &b, &r);
            a.calls = b.calls = 0;
            overlapping += k == 0 && r.relation == PLII_CONVEX_OVERLAPPING;
        }
    }
    assert_in_range(overlapping, count / 10, count);
    print_message("%d pairs, %d overlap\n", count, overlapping);
}

static void test_hostile_pairs(void** state) {
    (void)state;
#ifdef NDEBUG
    run_hostile(11, 100000);
#else
    run_hostile(11, 20000);
#endif
}

/* libccd alone, with every budget from 0 to 80 calls, on pairs that need not overlap, with centres anywhere and the
   wrong size. */
static void test_budget_ends_libccd(void** state) {
    (void)state;
    uint64_t seed = 5;
    int without_result = 0;
#ifdef NDEBUG
    const int count = 100000;
#else
    const int count = 20000;
#endif
    for (int i = 0; i < count; ++i) {
        sample_hull a, b;
        sample_hostile_pair(&seed, &a, &b);
        const plii_convex convex_a = sample_convex(&a), convex_b = sample_convex(&b);
        plii_penetration_query query = {.a = &convex_a, .b = &convex_b, .max_support_calls = i % 81};
        query.size = pow(10.0, (double)(sample_random(&seed) % 9) - 4.0);
        query.support_calls = -1;
        const bool is_found = plii_penetration_epa(&query);
        assert_in_range(query.support_calls, 0, query.max_support_calls);
        assert_int_equal(a.calls + b.calls, query.support_calls);
        if (is_found) { check_near(pli_vec3_length(query.normal), 1.0, 1e-6); }
        without_result += !is_found;
    }
    assert_in_range(without_result, 100, count - 100);
}

typedef struct broken_set {
    int calls;
    int good_calls; /* then NaN */
} broken_set;

static pli_vec3 broken_support(const void* user, pli_vec3 direction) {
    broken_set* set = (broken_set*)(uintptr_t)user;
    return set->calls++ < set->good_calls ? direction : pli_vec3_make(0, NAN, 0);
}

static void test_support_that_stops_being_finite(void** state) {
    (void)state;
    const sample_hull b = sample_box(pli_vec3_make(0.1f, 0.2f, 0.3f), pli_vec3_make(1, 0.7f, 1));
    for (int good = 0; good < 120; ++good) {
        for (int k = 0; k < 2; ++k) {
            broken_set broken = {.good_calls = good};
            const plii_convex convex_a = {.support = broken_support, .user = &broken};
            const plii_convex convex_b = sample_convex(&b);
            plii_convex_options options = {.max_distance = INFINITY};
            options.penetration = methods[k];
            plii_convex_result r;
            plii_convex_distance(&convex_a, &convex_b, &options, NULL, &r);
            assert_true(r.relation == PLII_CONVEX_OVERLAPPING || r.relation == PLII_CONVEX_UNDEFINED);
            assert_true(plii_is_finite(r.distance) && plii_vec3_is_finite(r.point_a) &&
                        plii_vec3_is_finite(r.point_b) && plii_vec3_is_finite(r.normal));
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_boxes),
        cmocka_unit_test(test_turned_box_corner),
        cmocka_unit_test(test_apart_and_beyond),
        cmocka_unit_test(test_degenerate_overlaps),
        cmocka_unit_test(test_cache_keeps_the_side),
        cmocka_unit_test(test_hostile_pairs),
        cmocka_unit_test(test_budget_ends_libccd),
        cmocka_unit_test(test_support_that_stops_being_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
