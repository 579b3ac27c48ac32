/* Nearest rotations of matrices of all kinds against a singular value decomposition in double precision. */

#include "check.h"
#include "math/rotation_fit.h"

#include <stdlib.h>
#include <string.h>

static uint32_t random_bits(uint64_t* seed) {
    *seed = *seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*seed >> 33);
}
/* In [-1, 1). */
static float random_unit(uint64_t* seed) {
    return (float)(random_bits(seed) >> 7) / 8388608.0f - 1.0f;
}
static pli_vec3 random_vector(uint64_t* seed) {
    const float x = random_unit(seed), y = random_unit(seed), z = random_unit(seed);
    return pli_vec3_make(x, y, z);
}
static pli_quat random_quaternion(uint64_t* seed) {
    pli_quat q;
    float squared;
    do {
        q.x = random_unit(seed), q.y = random_unit(seed), q.z = random_unit(seed), q.w = random_unit(seed);
        squared = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    } while (!(squared > 0.01f && squared <= 1));
    return q;
}

/* Singular values, greatest first, and U diag(1, 1, det U V) V^T, by Jacobi rotations of the columns (Hestenes). The
   last value carries the sign of the determinant. */
static void decompose(pli_mat3 m, double value[3], double rotation[3][3]) {
    double a[3][3], v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int r = 0; r < 3; ++r) {
        a[r][0] = (double)m.rows[r].x;
        a[r][1] = (double)m.rows[r].y;
        a[r][2] = (double)m.rows[r].z;
    }
    for (int sweep = 0; sweep < 30; ++sweep) {
        double off = 0.0;
        for (int p = 0; p < 2; ++p) {
            for (int q = p + 1; q < 3; ++q) {
                double pp = 0.0, qq = 0.0, pq = 0.0;
                for (int r = 0; r < 3; ++r) {
                    pp += a[r][p] * a[r][p];
                    qq += a[r][q] * a[r][q];
                    pq += a[r][p] * a[r][q];
                }
                if (!(fabs(pq) > 1e-17 * sqrt(pp * qq))) { continue; }
                off = fmax(off, fabs(pq) / sqrt(pp * qq));
                const double zeta = (qq - pp) / (2.0 * pq);
                const double t = (zeta >= 0.0 ? 1.0 : -1.0) / (fabs(zeta) + sqrt(1.0 + zeta * zeta));
                const double c = 1.0 / sqrt(1.0 + t * t), s = c * t;
                for (int r = 0; r < 3; ++r) {
                    const double ap = a[r][p], vp = v[r][p];
                    a[r][p] = c * ap - s * a[r][q];
                    a[r][q] = s * ap + c * a[r][q];
                    v[r][p] = c * vp - s * v[r][q];
                    v[r][q] = s * vp + c * v[r][q];
                }
            }
        }
        if (off < 1e-15) { break; }
    }
    int order[3] = {0, 1, 2};
    double length[3];
    for (int k = 0; k < 3; ++k) {
        length[k] = sqrt(a[0][k] * a[0][k] + a[1][k] * a[1][k] + a[2][k] * a[2][k]);
    }
    for (int i = 0; i < 3; ++i) {
        for (int k = i + 1; k < 3; ++k) {
            if (length[order[k]] > length[order[i]]) {
                const int swap = order[i];
                order[i] = order[k];
                order[k] = swap;
            }
        }
    }
    double u[3][3] = {{0}}, w[3][3]; /* columns in order */
    for (int k = 0; k < 3; ++k) {
        value[k] = length[order[k]];
        for (int r = 0; r < 3; ++r) {
            u[r][k] = value[k] > 0.0 ? a[r][order[k]] / value[k] : 0.0;
            w[r][k] = v[r][order[k]];
        }
    }
    /* Both made right-handed: the third columns are cross products. */
    for (int r = 0; r < 3; ++r) {
        const int s = (r + 1) % 3, t = (r + 2) % 3;
        const double third_u = u[s][0] * u[t][1] - u[t][0] * u[s][1];
        const double third_w = w[s][0] * w[t][1] - w[t][0] * w[s][1];
        u[r][2] = third_u;
        w[r][2] = third_w;
    }
    const double determinant =
        (double)m.rows[0].x * ((double)m.rows[1].y * (double)m.rows[2].z - (double)m.rows[1].z * (double)m.rows[2].y) -
        (double)m.rows[0].y * ((double)m.rows[1].x * (double)m.rows[2].z - (double)m.rows[1].z * (double)m.rows[2].x) +
        (double)m.rows[0].z * ((double)m.rows[1].x * (double)m.rows[2].y - (double)m.rows[1].y * (double)m.rows[2].x);
    if (determinant < 0.0) { value[2] = -value[2]; }
    for (int r = 0; r < 3; ++r) {
        for (int k = 0; k < 3; ++k) {
            rotation[r][k] = u[r][0] * w[k][0] + u[r][1] * w[k][1] + u[r][2] * w[k][2];
        }
    }
}

static double element(pli_mat3 m, int r, int k) {
    const pli_vec3 row = m.rows[r];
    return (double)(k == 0 ? row.x : k == 1 ? row.y : row.z);
}

/* Largest element of R R^T - 1, or NaN. */
static double orthogonality_error(pli_mat3 m) {
    double worst = 0.0;
    for (int r = 0; r < 3; ++r) {
        for (int s = 0; s < 3; ++s) {
            double sum = r == s ? -1.0 : 0.0;
            for (int k = 0; k < 3; ++k) {
                sum += element(m, r, k) * element(m, s, k);
            }
            if (!(fabs(sum) <= worst)) { worst = fabs(sum); }
        }
    }
    return worst;
}

static double trace_of_product(pli_mat3 rotation, pli_mat3 m) {
    double sum = 0.0;
    for (int r = 0; r < 3; ++r) {
        for (int k = 0; k < 3; ++k) {
            sum += element(rotation, r, k) * element(m, r, k);
        }
    }
    return sum;
}

typedef enum matrix_kind {
    WELL_CONDITIONED,
    NEAR_SINGULAR,
    INVERTED,
    NEAR_DEFINED, /* s2 + s3 from 1e-4 to 1e-1 of s1, s3 mostly negative */
    ROTATED,      /* a rotation, by 180 degrees from the start every other time */
    FLAT,
    RANK_1,
    ZERO,
    KIND_COUNT
} matrix_kind;

static const char* const kind_names[KIND_COUNT] = {"well-conditioned", "near-singular", "inverted", "near-defined",
                                                   "rotations",        "flat",          "rank 1",   "zero"};

static pli_mat3 product_of(pli_quat p, float s1, float s2, float s3, pli_quat q) {
    pli_mat3 scaled = pli_mat3_from_quat(q);
    scaled.rows[0] = pli_vec3_scale(scaled.rows[0], s1);
    scaled.rows[1] = pli_vec3_scale(scaled.rows[1], s2);
    scaled.rows[2] = pli_vec3_scale(scaled.rows[2], s3);
    return pli_mat3_mul(pli_mat3_from_quat(p), scaled);
}

static pli_mat3 random_matrix(uint64_t* seed, matrix_kind kind, pli_quat start) {
    const pli_quat p = random_quaternion(seed), q = random_quaternion(seed);
    const float s = 0.55f + 0.45f * random_unit(seed), t = 0.55f + 0.45f * random_unit(seed);
    const float small = powf(10.0f, 3.5f * random_unit(seed) - 4.5f);
    const pli_vec3 u = random_vector(seed), v = random_vector(seed);
    pli_mat3 m = pli_mat3_identity();
    if (kind == WELL_CONDITIONED) {
        m = product_of(p, 1, s, t, q);
    } else if (kind == NEAR_SINGULAR) {
        m = product_of(p, 1, s, random_bits(seed) % 2 ? small : -small, q);
    } else if (kind == INVERTED) {
        m = product_of(p, 1, s, -t, q);
    } else if (kind == NEAR_DEFINED) {
        const float gap = powf(10.0f, 1.5f * random_unit(seed) - 2.5f);
        m = product_of(p, 1, s, gap - s, q);
    } else if (kind == ROTATED) {
        m = pli_mat3_from_quat(p);
        if (random_bits(seed) % 2) {
            const pli_mat3 half_turn = {{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}};
            m = pli_mat3_mul(pli_mat3_from_quat(start), half_turn);
        }
    } else if (kind == FLAT) {
        m = product_of(p, 1, s, 0, q);
    } else if (kind == RANK_1) {
        m.rows[0] = pli_vec3_scale(v, u.x);
        m.rows[1] = pli_vec3_scale(v, u.y);
        m.rows[2] = pli_vec3_scale(v, u.z);
    } else {
        m.rows[0] = m.rows[1] = m.rows[2] = pli_vec3_make(0, 0, 0);
    }
    static const float sizes[6] = {1, 1, 1e-6f, 1e6f, 1e-30f, 1e30f};
    const float size = sizes[random_bits(seed) % 6];
    for (int r = 0; r < 3; ++r) {
        m.rows[r] = pli_vec3_scale(m.rows[r], size);
    }
    return m;
}

enum { MATRIX_COUNT = PLIANT_CHECKED ? 200000 : 1000000, CHUNK = 1000 };

static void test_against_singular_values(void** state) {
    (void)state;
    uint64_t seed = 1;
    static pli_mat3 matrices[CHUNK];
    static pli_quat starts[CHUNK], quaternions[CHUNK];
    double worst_orthogonality = 0.0, worst_determinant = 0.0, worst_rotation[KIND_COUNT] = {0.0};
    double worst_trace[KIND_COUNT] = {0.0};
    int defined_count[KIND_COUNT] = {0};
    for (int done = 0; done < MATRIX_COUNT; done += CHUNK) {
        for (int i = 0; i < CHUNK; ++i) {
            starts[i] = quaternions[i] = random_quaternion(&seed);
            matrices[i] = random_matrix(&seed, (matrix_kind)(i % KIND_COUNT), starts[i]);
        }
        for (int i = 0; i < CHUNK; ++i) {
            const pli_mat3 r = plii_rotation_fit(&matrices[i], &quaternions[i]);
            const double orthogonality = orthogonality_error(r);
            const double determinant =
                (double)pli_vec3_dot(r.rows[0], pli_vec3_cross(r.rows[1], r.rows[2])); /* about 1, so float will do */
            if (!(orthogonality <= worst_orthogonality)) { worst_orthogonality = orthogonality; }
            if (!(fabs(determinant - 1.0) <= worst_determinant)) { worst_determinant = fabs(determinant - 1.0); }
            double value[3], expected[3][3];
            decompose(matrices[i], value, expected);
            if (value[0] > 0.0) {
                /* Of all rotations none has a larger trace than s1 + s2 + s3, defined or not. */
                const double best = value[0] + value[1] + value[2];
                const double lost = (best - trace_of_product(r, matrices[i])) / value[0];
                if (!(lost <= worst_trace[i % KIND_COUNT])) { worst_trace[i % KIND_COUNT] = lost; }
            }
            if (!(value[1] + value[2] > 1e-3 * value[0])) { continue; }
            ++defined_count[i % KIND_COUNT];
            for (int row = 0; row < 3; ++row) {
                for (int k = 0; k < 3; ++k) {
                    const double error = fabs(element(r, row, k) - expected[row][k]);
                    if (!(error <= worst_rotation[i % KIND_COUNT])) { worst_rotation[i % KIND_COUNT] = error; }
                }
            }
        }
    }
    print_message("orthogonality %.2g, determinant - 1 %.2g\n", worst_orthogonality, worst_determinant);
    for (int k = 0; k < KIND_COUNT; ++k) {
        print_message("  %-16s %6d defined, rotation error %.2g; lost of the trace %.2g\n", kind_names[k],
                      defined_count[k], worst_rotation[k], worst_trace[k]);
    }
    check_at_most(worst_orthogonality, 1e-6);
    check_at_most(worst_determinant, 1e-6);
    for (int k = 0; k < KIND_COUNT; ++k) {
        check_at_most(worst_rotation[k], 1e-5);
        check_at_most(worst_trace[k], 1e-5);
    }
    for (int k = 0; k < FLAT; ++k) {
        assert_in_range(defined_count[k], MATRIX_COUNT / KIND_COUNT / 3, MATRIX_COUNT);
    }
}

/* What the matrix leaves open is taken from the start; what it does not is not. */
static void test_start_fills_what_is_open(void** state) {
    (void)state;
    const pli_quat turn = {.x = 0, .y = 0.6f, .z = 0, .w = 0.8f};
    pli_mat3 zero, rank_1;
    memset(&zero, 0, sizeof zero);
    rank_1 = zero;
    rank_1.rows[1].y = 3; /* y stays y: any turn around it is as good */
    pli_quat q = turn;
    pli_mat3 r;
    r = plii_rotation_fit(&zero, &q);
    check_near(q.y, 0.6, 1e-7);
    check_near(q.w, 0.8, 1e-7);
    r = plii_rotation_fit(&rank_1, &q);
    check_near(q.y, 0.6, 1e-6);
    check_near(r.rows[1].y, 1, 1e-6);
    const pli_mat3 identity = pli_mat3_identity();
    q = (pli_quat){.x = 0, .y = 0, .z = 1, .w = 0}; /* half a turn away */
    r = plii_rotation_fit(&identity, &q);
    check_near(fabsf(q.w), 1, 1e-7);
    check_near(r.rows[0].x, 1, 1e-7);
}

static void test_useless_input(void** state) {
    (void)state;
    pli_mat3 matrices[4], rotations[4];
    for (int i = 0; i < 4; ++i) {
        matrices[i] = pli_mat3_identity();
    }
    matrices[0].rows[1].z = NAN;
    matrices[1].rows[0].x = INFINITY;
    pli_quat q[4] = {{0, 0, 0, 1}, {0, 1, 0, 0}, {0, 0, 0, 0}, {NAN, 0, INFINITY, 1}};
    for (int i = 0; i < 4; ++i) {
        rotations[i] = plii_rotation_fit(&matrices[i], &q[i]);
        check_at_most(orthogonality_error(rotations[i]), 1e-6);
        check_near(rotations[i].rows[1].y, 1, 1e-6);
        check_near(rotations[i].rows[0].x, i == 1 ? -1 : 1, 1e-6);
    }
}

// ------------------------------------------------------------------------------------------------------
// rotation_follow

static pli_quat turned(pli_quat q, pli_vec3 turn) {
    const pli_vec3 v = {q.x, q.y, q.z}, half = pli_vec3_scale(turn, 0.5f);
    const pli_vec3 moved = pli_vec3_add(pli_vec3_scale(half, q.w), pli_vec3_cross(v, half));
    return (pli_quat){.x = q.x + moved.x, .y = q.y + moved.y, .z = q.z + moved.z, .w = q.w - pli_vec3_dot(v, half)};
}

static pli_mat3 fit_warm(pli_mat3 matrix, pli_quat* quaternion) {
    plii_rotations_fit_warm(1, &matrix, &quaternion);
    return matrix;
}

/* Starts up to half a radian beside the result, and matrices of all kinds beside those that shape matching has. */
static void test_follow_is_fit(void** state) {
    (void)state;
    uint64_t seed = 3;
    enum { COUNT = 20000 };
    double worst[KIND_COUNT] = {0.0}, worst_orthogonality = 0.0;
    for (int i = 0; i < COUNT; ++i) {
        const matrix_kind kind = (matrix_kind)(i % KIND_COUNT);
        pli_quat result = random_quaternion(&seed);
        const pli_mat3 matrix = random_matrix(&seed, kind, result);
        pli_mat3 expected, found;
        expected = plii_rotation_fit(&matrix, &result);
        pli_quat q = turned(result, pli_vec3_scale(random_vector(&seed), 0.3f * random_unit(&seed)));
        found = fit_warm(matrix, &q);
        if (!(orthogonality_error(found) <= worst_orthogonality)) { worst_orthogonality = orthogonality_error(found); }
        double value[3], rotation[3][3];
        decompose(matrix, value, rotation);
        if (!(value[1] + value[2] > 1e-3 * value[0])) { continue; }
        double error = 0.0;
        for (int row = 0; row < 3; ++row) {
            for (int k = 0; k < 3; ++k) {
                error = fmax(error, fabs(element(found, row, k) - element(expected, row, k)));
            }
        }
        if (!(error <= worst[kind])) { worst[kind] = error; }
        const pli_mat3 of_quaternion = pli_mat3_from_quat(q);
        for (int row = 0; row < 3; ++row) {
            for (int k = 0; k < 3; ++k) {
                check_near(element(of_quaternion, row, k), element(found, row, k), 1e-6);
            }
        }
    }
    print_message("orthogonality %.2g\n", worst_orthogonality);
    for (int k = 0; k < KIND_COUNT; ++k) {
        print_message("  %-16s differ by %.2g\n", kind_names[k], worst[k]);
        check_at_most(worst[k], 3e-6);
    }
    check_at_most(worst_orthogonality, 1e-6);
}

/* Four at once have the bits that each has alone, beside what takes more steps or is left to plii_rotation_fit too. */
static void test_follow_four(void** state) {
    (void)state;
    uint64_t seed = 7;
    for (int i = 0; i < 4000; ++i) {
        pli_mat3 matrices[4], alone[4];
        pli_quat q[4], q_alone[4], *quaternions[4];
        const int count = 1 + i % 4;
        for (int k = 0; k < count; ++k) {
            const pli_quat start = random_quaternion(&seed);
            const float apart = k == i / 4 % 4 ? 0.4f : 1e-3f;
            matrices[k] = random_matrix(&seed, (matrix_kind)((i + k) % KIND_COUNT), start);
            q[k] = q_alone[k] = turned(start, pli_vec3_scale(random_vector(&seed), apart));
            quaternions[k] = &q[k];
            alone[k] = fit_warm(matrices[k], &q_alone[k]);
        }
        plii_rotations_fit_warm(count, matrices, quaternions);
        assert_memory_equal(matrices, alone, (size_t)count * sizeof *alone);
        assert_memory_equal(q, q_alone, (size_t)count * sizeof *q);
    }
}

static void test_follow_useless_start(void** state) {
    (void)state;
    uint64_t seed = 5;
    pli_quat start = random_quaternion(&seed), useless = {0, 0, 0, 0};
    pli_mat3 matrix = random_matrix(&seed, (matrix_kind)0, start);
    check_at_most(orthogonality_error(fit_warm(matrix, &useless)), 1e-6);
    matrix.rows[1].y = NAN;
    check_at_most(orthogonality_error(fit_warm(matrix, &start)), 1e-6);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_against_singular_values),
        cmocka_unit_test(test_start_fills_what_is_open),
        cmocka_unit_test(test_useless_input),
        cmocka_unit_test(test_follow_is_fit),
        cmocka_unit_test(test_follow_four),
        cmocka_unit_test(test_follow_useless_start),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
