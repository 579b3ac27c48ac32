/* The distance lattice: exact at lattice points, linear in between, bounded memory, errors. */

#include "context_fixture.h"

#include "pliant/bullet_reference.h"
#include "pliant/shape.h"

#include <string.h>

static void test_lattice_is_exact_at_its_points_and_linear_between(void** state) {
    (void)state;
    pli_shape *sphere = NULL, *lattice = NULL;
    assert_int_equal(pli_shape_create_sphere(context, 1.0f, &sphere), PLI_OK);
    assert_int_equal(pli_shape_create_lattice(context, sphere, 0.25f, &lattice), PLI_OK);
    for (int i = -7; i <= 7; ++i) {
        for (int j = -7; j <= 7; ++j) {
            for (int k = -7; k <= 7; ++k) {
                const pli_vec3 p = {0.25f * (float)i, 0.25f * (float)j, 0.25f * (float)k};
                check_near(pli_shape_distance(lattice, p, NULL), pli_shape_distance(sphere, p, NULL), 3e-7);
                const pli_vec3 q = {p.x + 0.25f, p.y, p.z};
                const float middle = 0.5f * (pli_shape_distance(sphere, p, NULL) + pli_shape_distance(sphere, q, NULL));
                check_near(pli_shape_distance(lattice, pli_vec3_make(p.x + 0.125f, p.y, p.z), NULL), middle, 3e-7);
            }
        }
    }
    /* The interpolant of a convex function is never below it, and at most h^2 / 8 per axis and curvature above. */
    pli_vec3 n, m;
    for (int i = 0; i < 1000; ++i) {
        const float a = 0.37f * (float)i, b = 0.11f * (float)i;
        const pli_vec3 p = {1.1f * cosf(a) * cosf(b), 1.1f * sinf(b), 1.1f * sinf(a) * cosf(b)};
        const float d = pli_shape_distance(lattice, p, &n) - pli_shape_distance(sphere, p, &m);
        check_at_most(-d, 1e-6);
        check_at_most(d, 0.02);
        check_near(pli_vec3_length(n), 1, 1e-6);
        check_at_most(1 - pli_vec3_dot(n, m), 0.02);
    }
    pli_shape_release(sphere); /* the lattice holds on to it */
    check_near(pli_shape_distance(lattice, pli_vec3_make(5, 0, 0), NULL), 4, 1e-6);
    pli_shape_release(lattice);
}

static void test_lattice_memory_is_bounded_and_results_survive_the_bound(void** state) {
    (void)state;
    pli_shape *plane = NULL, *lattice = NULL;
    assert_int_equal(pli_shape_create_plane(context, pli_vec3_make(1, 2, 3), 0.5f, &plane), PLI_OK);
    assert_int_equal(pli_shape_create_lattice(context, plane, 0.25f, &lattice), PLI_OK);
    const float before = pli_shape_distance(lattice, pli_vec3_make(0.1f, 0.2f, 0.3f), NULL);
    for (int i = 0; i < 50; ++i) {
        for (int j = 0; j < 50; ++j) {
            for (int k = 0; k < 50; ++k) {
                const pli_vec3 p = {0.75f * (float)i, 0.75f * (float)j, 0.75f * (float)k};
                check_near(pli_shape_distance(lattice, p, NULL), pli_shape_distance(plane, p, NULL), 2e-5);
            }
        }
    }
    check_at_most(pli_context_allocated_bytes(context), 10e6);
    assert_true(pli_shape_distance(lattice, pli_vec3_make(0.1f, 0.2f, 0.3f), NULL) == before);
    pli_shape_release(plane);
    pli_shape_release(lattice);
}

static void test_lattice_answers_far_and_bad_points(void** state) {
    (void)state;
    pli_shape *box = NULL, *lattice = NULL;
    assert_int_equal(pli_shape_create_box(context, pli_vec3_make(1, 1, 1), &box), PLI_OK);
    assert_int_equal(pli_shape_create_lattice(context, box, 0.25f, &lattice), PLI_OK);
    pli_vec3 n;
    check_near(pli_shape_distance(lattice, pli_vec3_make(1e15f, 0, 0), &n), 1e15f, 0);
    check_near(n.x, 1, 0);
    assert_true(isinf(pli_shape_distance(lattice, pli_vec3_make(NAN, 0, 0), &n)));
    /* Just below a cell border, where rounding could leave the cell. */
    for (int i = -40; i <= 40; ++i) {
        const float x = nextafterf(0.75f * (float)i, -INFINITY);
        check_near(pli_shape_distance(lattice, pli_vec3_make(x, 0, 0), NULL),
                   pli_shape_distance(box, pli_vec3_make(x, 0, 0), NULL), 1e-5);
    }
    pli_shape_release(lattice);
    lattice = NULL;
    assert_int_equal(pli_shape_create_lattice(context, NULL, 0.25f, &lattice), PLI_ERROR_NULL_ARGUMENT);
    assert_int_equal(pli_shape_create_lattice(context, box, 0, &lattice), PLI_ERROR_INVALID_VALUE);
    assert_non_null(strstr(pli_last_error(context), "voxel_size is 0"));
    assert_int_equal(pli_shape_create_lattice(context, box, -1, &lattice), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(pli_shape_create_lattice(context, box, NAN, &lattice), PLI_ERROR_NOT_FINITE);
    assert_null(lattice);
    pli_shape_release(box);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lattice_is_exact_at_its_points_and_linear_between),
        cmocka_unit_test(test_lattice_memory_is_bounded_and_results_survive_the_bound),
        cmocka_unit_test(test_lattice_answers_far_and_bad_points),
    };
    return cmocka_run_group_tests(tests, setup_context, teardown_context);
}
