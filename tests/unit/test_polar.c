/* Polar decomposition: orthogonality, symmetry of the other factor, sign, and matrices without an inverse. */

#include "check.h"

#include "math/rotation_fit.h"

#include <math.h>

static float determinant_of(pli_mat3 m) {
    return pli_vec3_dot(m.rows[0], pli_vec3_cross(m.rows[1], m.rows[2]));
}

static uint32_t random_state = 7;
static float random_float(float size) {
    random_state = random_state * 1664525u + 1013904223u;
    return ((float)(random_state >> 8) / 8388608.0f - 1.0f) * size;
}
static pli_vec3 random_vec3(float size) {
    const float x = random_float(size), y = random_float(size);
    return pli_vec3_make(x, y, random_float(size));
}
static pli_mat3 random_mat3(float size) {
    pli_mat3 m;
    for (int i = 0; i < 3; ++i) {
        m.rows[i] = random_vec3(size);
    }
    return m;
}

/* Largest |element| of a - b. */
static float distance(pli_mat3 a, pli_mat3 b) {
    float largest = 0.0f;
    for (int i = 0; i < 3; ++i) {
        const pli_vec3 d = pli_vec3_sub(a.rows[i], b.rows[i]);
        if (!plii_vec3_is_finite(d)) { return INFINITY; }
        largest = fmaxf(largest, fmaxf(fabsf(d.x), fmaxf(fabsf(d.y), fabsf(d.z))));
    }
    return largest;
}

static float orthogonality_error(pli_mat3 u) {
    return distance(pli_mat3_mul(u, pli_mat3_transpose(u)), pli_mat3_identity());
}

static float asymmetry(pli_mat3 m) {
    return distance(m, pli_mat3_transpose(m));
}

static void test_random_matrices_have_an_orthogonal_factor(void** unused) {
    (void)unused;
    float worst_orthogonality = 0.0f, worst_symmetry = 0.0f;
    int checked = 0;
    for (int i = 0; i < 100000; ++i) {
        const pli_mat3 a = random_mat3(1.0f);
        const float determinant = determinant_of(a);
        /* The symmetry of the other factor is lost as the condition grows: leave the worst out. */
        if (fabsf(determinant) < 1e-3f) { continue; }
        const pli_mat3 u = plii_polar_factor(a, pli_mat3_identity());
        worst_orthogonality = fmaxf(worst_orthogonality, orthogonality_error(u));
        worst_symmetry = fmaxf(worst_symmetry, asymmetry(pli_mat3_mul(pli_mat3_transpose(u), a)));
        assert_true(determinant_of(u) * determinant > 0.0f);
        ++checked;
    }
    print_message("%d matrices: orthogonal to %.2g, symmetric to %.2g\n", checked, (double)worst_orthogonality,
                  (double)worst_symmetry);
    assert_true(checked > 95000);
    check_at_most(worst_orthogonality, 1e-6);
    check_at_most(worst_symmetry, 1e-5);
}

static void test_a_stretched_rotation_gives_the_rotation(void** unused) {
    (void)unused;
    for (int i = 0; i < 1000; ++i) {
        const pli_mat3 r =
            pli_mat3_from_quat((pli_quat){random_float(1), random_float(1), random_float(1), random_float(1) + 1.5f});
        const pli_mat3 stretch = {{{2.0f, 0.3f, -0.1f}, {0.3f, 0.7f, 0.2f}, {-0.1f, 0.2f, 1.1f}}};
        check_at_most(distance(plii_polar_factor(pli_mat3_mul(r, stretch), pli_mat3_identity()), r), 2e-6);
    }
}

static void test_an_inverted_matrix_gives_a_reflection(void** unused) {
    (void)unused;
    const pli_mat3 u = plii_polar_factor(plii_mat3_diagonal(2, 3, -1), pli_mat3_identity());
    check_at_most(distance(u, plii_mat3_diagonal(1, 1, -1)), 1e-6);
}

/* Two equal rows and whole numbers: the determinant is zero without rounding. */
static void test_a_flat_matrix_gives_a_rotation(void** unused) {
    (void)unused;
    for (int i = 0; i < 1000; ++i) {
        const float size = ldexpf(1.0f, i % 28 - 8);
        pli_mat3 a = random_mat3(10.0f);
        for (int k = 0; k < 2; ++k) {
            a.rows[k] = pli_vec3_make(roundf(a.rows[k].x), roundf(a.rows[k].y), roundf(a.rows[k].z));
            a.rows[k] = pli_vec3_scale(a.rows[k], size);
        }
        if (pli_vec3_length(pli_vec3_cross(a.rows[0], a.rows[1])) < 5.0f * size * size) { continue; }
        a.rows[2] = a.rows[1];
        assert_true(determinant_of(a) == 0.0f);
        const pli_mat3 u = plii_polar_factor(a, plii_mat3_diagonal(1, -1, -1));
        check_at_most(orthogonality_error(u), 1e-5);
        check_near(determinant_of(u), 1, 1e-5);
        check_at_most(asymmetry(pli_mat3_mul(pli_mat3_transpose(u), a)), 1e-3f * size);
    }
}

/* What has no numbers leaves the rotation as it was; a line (1, 2, -1) (1, 2, 3)^T turns it as far as it has to. */
static void test_a_matrix_without_a_factor_gives_a_rotation(void** unused) {
    (void)unused;
    const pli_mat3 start = {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}};
    const pli_mat3 cases[] = {plii_mat3_diagonal(NAN, 1, 1), plii_mat3_diagonal(INFINITY, 1, 1)};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        check_at_most(distance(plii_polar_factor(cases[i], start), start), 1e-7);
    }
    const pli_mat3 line = {{{1, 2, 3}, {2, 4, 6}, {-1, -2, -3}}}, u = plii_polar_factor(line, start);
    check_at_most(orthogonality_error(u), 1e-6);
    check_near(determinant_of(u), 1, 1e-6);
    const pli_vec3 turned = pli_mat3_mul_vec3(u, pli_vec3_make(1, 2, 3));
    check_near(pli_vec3_dot(turned, pli_vec3_make(1, 2, -1)), sqrt(6.0 * 14.0), 1e-5);
}

static void test_very_small_and_large_matrices_come_back_unchanged(void** unused) {
    (void)unused;
    const pli_mat3 cases[] = {plii_mat3_diagonal(0, 0, 0), plii_mat3_diagonal(1e-4f, 2e-4f, 3e-4f),
                              plii_mat3_diagonal(1e4f, 2e4f, 3e4f)};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        assert_true(distance(plii_polar_factor(cases[i], pli_mat3_identity()), cases[i]) == 0.0f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_matrices_have_an_orthogonal_factor),
        cmocka_unit_test(test_a_stretched_rotation_gives_the_rotation),
        cmocka_unit_test(test_an_inverted_matrix_gives_a_reflection),
        cmocka_unit_test(test_a_flat_matrix_gives_a_rotation),
        cmocka_unit_test(test_a_matrix_without_a_factor_gives_a_rotation),
        cmocka_unit_test(test_very_small_and_large_matrices_come_back_unchanged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
