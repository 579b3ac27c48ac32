/* Distance of convex cores: exact values, proof by support planes, degenerate sets, warm start. */

#include "check.h"
#include "geometry/gjk.h"
#include "sample_convex.h"

static plii_gjk_result run_convex(plii_convex a, plii_convex b, plii_convex_cache* cache) {
    const plii_gjk_query query = {.a = &a, .b = &b, .max_distance = HUGE_VAL, .max_support_calls = 200};
    plii_gjk_result result;
    plii_gjk_run(&query, cache, &result);
    return result;
}
static plii_gjk_result run(const sample_hull* a, const sample_hull* b, plii_convex_cache* cache) {
    return run_convex(sample_convex(a), sample_convex(b), cache);
}
/* Starts from vertices of the last simplex. */

static void test_boxes_face_to_face(void** state) {
    (void)state;
    const sample_hull a = sample_box(pli_vec3_make(0.1f, 3, 0.2f), pli_vec3_make(1, 1, 1));
    const sample_hull b = sample_box(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 1, 1));
    const plii_gjk_result r = run(&a, &b, NULL);
    assert_int_equal(r.relation, PLII_CONVEX_SEPARATED);
    check_near(r.distance, 1.0, 1e-12);
    check_near(r.normal.y, 1.0, 1e-12);
    check_near(r.point_a.y, 2.0, 1e-12);
    check_near(r.point_b.y, 1.0, 1e-12);
    check_near(r.point_a.x, r.point_b.x, 1e-12);
}

static void test_edge_to_edge(void** state) {
    (void)state;
    /* Segments along x and z, 0.5 apart in y. */
    const pli_vec3 p[2] = {{-1, 0.5f, 0.25f}, {1, 0.5f, 0.25f}}, q[2] = {{0.125f, 0, -1}, {0.125f, 0, 1}};
    const sample_hull a = sample_make(2, p), b = sample_make(2, q);
    const plii_gjk_result r = run(&a, &b, NULL);
    check_near(r.distance, 0.5, 1e-12);
    check_near(r.normal.y, 1.0, 1e-12);
    check_near(r.point_a.x, 0.125, 1e-12);
    check_near(r.point_b.z, 0.25, 1e-12);
}

static void test_vertex_to_vertex(void** state) {
    (void)state;
    const sample_hull a = sample_box(pli_vec3_make(4, 5, 3), pli_vec3_make(1, 1, 1));
    const sample_hull b = sample_box(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 1, 1));
    const plii_gjk_result r = run(&a, &b, NULL);
    check_near(r.distance, sqrt(4.0 + 9.0 + 1.0), 1e-12);
    check_near(r.normal.x, 2.0 / sqrt(14.0), 1e-7); /* the support direction is float */
    check_near(r.point_a.z, 2.0, 1e-12);
    check_near(r.point_b.y, 1.0, 1e-12);
}

typedef struct ball {
    pli_vec3 centre;
    float radius;
} ball;

static pli_vec3 ball_support(const void* user, pli_vec3 direction) {
    const ball* b = (const ball*)user;
    return pli_vec3_add(b->centre, pli_vec3_scale(direction, b->radius));
}

static void test_balls_converge_within_the_gap(void** state) {
    (void)state;
    const ball a = {{3, 1, -2}, 1.0f}, b = {{0, 0, 0}, 0.5f};
    const plii_convex convex_a = {.support = ball_support, .user = &a, .centre = {3, 1.5f, -2}};
    const plii_convex convex_b = {.support = ball_support, .user = &b, .centre = {0, 0.3f, 0}};
    const plii_gjk_query query = {.a = &convex_a, .b = &convex_b, .max_distance = HUGE_VAL, .max_support_calls = 200};
    plii_gjk_result r;
    plii_gjk_run(&query, NULL, &r);
    assert_int_equal(r.relation, PLII_CONVEX_SEPARATED);
    check_near(r.distance, sqrt(14.0) - 1.5, 4e-6);
    check_at_most(r.distance - r.lower_bound, 2e-6 * r.distance);
    check_near(r.normal.x, 3.0 / sqrt(14.0), 1e-3);
    check_at_most(r.support_calls, 60);
}

static void test_overlap_is_found(void** state) {
    (void)state;
    const sample_hull a = sample_box(pli_vec3_make(0.3f, 0.4f, 0.5f), pli_vec3_make(1, 1, 1));
    const sample_hull b = sample_box(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 1, 1));
    plii_convex_cache cache = {.count = 0};
    const plii_gjk_result r = run(&a, &b, &cache);
    assert_int_equal(r.relation, PLII_CONVEX_OVERLAPPING);
    check_near(r.distance, 0.0, 0.0);
    check_near(plii_dvec3_length(plii_dvec3_sub(r.point_a, r.point_b)), 0.0, 1e-12); /* a point of both */
    const plii_gjk_result again = run(&a, &b, &cache);
    assert_int_equal(again.relation, PLII_CONVEX_OVERLAPPING);
    check_at_most(again.support_calls, 8);
}

static void test_offset_moves_the_first_set(void** state) {
    (void)state;
    const sample_hull a = sample_box(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 1, 1)), b = a;
    const plii_convex convex_a = sample_convex(&a), convex_b = sample_convex(&b);
    const plii_gjk_query query = {
        .a = &convex_a, .b = &convex_b, .offset = {0, 0, -2.25}, .max_distance = HUGE_VAL, .max_support_calls = 200};
    plii_gjk_result r;
    plii_gjk_run(&query, NULL, &r);
    check_near(r.distance, 0.25, 1e-12);
    check_near(r.normal.z, -1.0, 1e-12);
    check_near(r.point_a.z, -1.25, 1e-12);
}

static void test_far_pairs_end_early(void** state) {
    (void)state;
    const sample_hull a = sample_box(pli_vec3_make(9, 8, 7), pli_vec3_make(1, 1, 1));
    const sample_hull b = sample_box(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 1, 1));
    const plii_convex convex_a = sample_convex(&a), convex_b = sample_convex(&b);
    const plii_gjk_query query = {.a = &convex_a, .b = &convex_b, .max_distance = 0.5, .max_support_calls = 200};
    plii_gjk_result r;
    plii_gjk_run(&query, NULL, &r);
    assert_int_equal(r.relation, PLII_CONVEX_BEYOND);
    check_at_most(0.5, r.lower_bound);
    check_at_most(r.lower_bound, r.distance);
    assert_int_equal(r.support_calls, 2);
}

static void test_degenerate_sets(void** state) {
    (void)state;
    const pli_vec3 origin = {0, 0, 0}, above[1] = {{0, 2, 0}};
    const pli_vec3 same[4] = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}};
    const pli_vec3 line[4] = {{-2, 1, 0}, {-1, 1, 0}, {1, 1, 0}, {2, 1, 0}};
    const pli_vec3 square[4] = {{-1, 0.75f, -1}, {1, 0.75f, -1}, {1, 0.75f, 1}, {-1, 0.75f, 1}};
    const sample_hull point = sample_make(1, &origin), point_above = sample_make(1, above);
    const sample_hull coincident = sample_make(4, same), collinear = sample_make(4, line),
                      flat = sample_make(4, square);

    check_near(run(&point_above, &point, NULL).distance, 2.0, 0.0);
    check_near(run(&coincident, &point, NULL).distance, sqrt(3.0), 1e-12);
    check_near(run(&collinear, &point, NULL).distance, 1.0, 1e-12);
    check_near(run(&flat, &point, NULL).distance, 0.75, 1e-12);
    check_near(run(&flat, &collinear, NULL).distance, 0.25, 1e-12);
    assert_int_equal(run(&point, &point, NULL).relation, PLII_CONVEX_OVERLAPPING);
    assert_int_equal(run(&flat, &flat, NULL).relation, PLII_CONVEX_OVERLAPPING);
    assert_int_equal(run(&collinear, &collinear, NULL).relation, PLII_CONVEX_OVERLAPPING);
    assert_int_equal(run(&coincident, &coincident, NULL).relation, PLII_CONVEX_OVERLAPPING);
}

static pli_vec3 nan_support(const void* user, pli_vec3 direction) {
    (void)user;
    return pli_vec3_make(NAN, direction.y, 0);
}

static void test_support_that_is_not_finite(void** state) {
    (void)state;
    const sample_hull b = sample_box(pli_vec3_make(0, 0, 0), pli_vec3_make(1, 1, 1));
    const plii_convex convex_a = {.support = nan_support}, convex_b = sample_convex(&b);
    const plii_gjk_query query = {.a = &convex_a, .b = &convex_b, .max_distance = HUGE_VAL, .max_support_calls = 200};
    plii_gjk_result r;
    plii_gjk_run(&query, NULL, &r);
    assert_int_equal(r.relation, PLII_CONVEX_UNDEFINED);
    assert_int_equal(r.support_calls, 2);
}

/* Witness points give an upper bound, the support plane of the normal a lower one: together they prove the distance.
   Pairs of all kinds, sizes from 1e-4 to 1e4, near the origin and 1e4 away; each with a cold and warm starts. */
static void test_random_distances_are_proven(void** state) {
    (void)state;
    uint64_t seed = 7;
    int separated = 0;
    double cold_calls = 0.0, warm_calls = 0.0;
    plii_convex_cache stale = {.count = 0};
    for (int i = 0; i < 30000; ++i) {
        sample_hull a, b;
        sample_hostile_pair(&seed, &a, &b);
        plii_convex_cache cache = {.count = 0}, any = {.count = 4};
        for (int k = 0; k < 4; ++k) {
            any.directions[k] = plii_vec3_safe_normalize(sample_random_vector(&seed));
        }
        const double reach = sample_reach(&a, &b);
        for (int pass = 0; pass < 4; ++pass) {
            /* Cold, warm, of another pair, from any directions, which may make a flat simplex. */
            const plii_gjk_result r = run(&a, &b, pass == 3 ? &any : pass == 2 ? &stale : &cache);
            const double rounding = pass < 3 ? 1.0 : 100.0;
            assert_int_not_equal(r.relation, PLII_CONVEX_UNDEFINED);
            assert_true(isfinite(r.distance) && isfinite(plii_dvec3_length(r.point_a)) &&
                        isfinite(plii_dvec3_length(r.point_b)));
            check_at_most(r.support_calls, 200);
            assert_int_equal(a.calls + b.calls, r.support_calls);
            a.calls = b.calls = 0;
            const plii_dvec3 between = plii_dvec3_sub(r.point_a, r.point_b);
            if (r.relation == PLII_CONVEX_OVERLAPPING) {
                check_at_most(plii_dvec3_length(between), 3e-7 * reach); /* weights in slivers */
                continue;
            }
            check_near(plii_dvec3_length(between), r.distance, rounding * 1e-9 * reach);
            check_near(plii_dvec3_length(r.normal), 1.0, 1e-12);
            check_near(-sample_way(&a, &b, r.normal), r.distance,
                       rounding * (2e-6 * r.distance + 4e-6 * reach)); /* float supports */
            separated += pass == 0;
            if (pass == 0) { cold_calls += r.support_calls; }
            if (pass == 1) { warm_calls += r.support_calls; }
        }
    }
    assert_in_range(separated, 10000, 30000);
    check_at_most(warm_calls, 0.95 * cold_calls);
}

/* A slow turn of one of two hulls, as in a simulation. */
static void test_warm_start_follows_motion(void** state) {
    (void)state;
    uint64_t seed = 3;
    int cold_calls = 0, warm_calls = 0;
    for (int pair = 0; pair < 50; ++pair) {
        pli_vec3 p[16], q[16];
        for (int i = 0; i < 16; ++i) {
            p[i] = pli_vec3_add(sample_random_vector(&seed), pli_vec3_make(0, 2.5f, 0));
            q[i] = sample_random_vector(&seed);
        }
        const sample_hull b = sample_make(16, q);
        plii_convex_cache cache = {.count = 0};
        for (int frame = 0; frame < 60; ++frame) {
            const pli_mat3 turn = pli_mat3_from_euler_zyx(0.01f * (float)frame, 0.007f * (float)frame, 0);
            pli_vec3 turned[16];
            for (int i = 0; i < 16; ++i) {
                turned[i] = pli_mat3_mul_vec3(turn, p[i]);
            }
            const sample_hull a = sample_make(16, turned);
            const plii_gjk_result cold = run(&a, &b, NULL), warm = run(&a, &b, &cache);
            assert_int_equal(cold.relation, warm.relation);
            check_near(cold.distance, warm.distance, 1e-6 * cold.distance + 1e-12);
            cold_calls += cold.support_calls;
            warm_calls += warm.support_calls;
        }
    }
    print_message("           of %d calls %d from directions\n", cold_calls, warm_calls);
    check_at_most(warm_calls, 0.85 * cold_calls);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_boxes_face_to_face),         cmocka_unit_test(test_edge_to_edge),
        cmocka_unit_test(test_vertex_to_vertex),           cmocka_unit_test(test_balls_converge_within_the_gap),
        cmocka_unit_test(test_overlap_is_found),           cmocka_unit_test(test_offset_moves_the_first_set),
        cmocka_unit_test(test_far_pairs_end_early),        cmocka_unit_test(test_degenerate_sets),
        cmocka_unit_test(test_support_that_is_not_finite), cmocka_unit_test(test_random_distances_are_proven),
        cmocka_unit_test(test_warm_start_follows_motion),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
