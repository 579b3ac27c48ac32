/* Polar decomposition by scaled Newton iteration (Higham, "Computing the polar decomposition with applications",
   1986), with the operations in the order of btPolarDecomposition. */

#include "math/polar.h"

#define POLAR_TOLERANCE 0.0001f
#define POLAR_MAX_ITERATIONS 16

/* Largest sum of absolute values over the rows. */
static float polar_norm_infinity(pli_mat3 m) {
    float sums[3];
    for (int i = 0; i < 3; ++i) {
        sums[i] = fabsf(m.rows[i].x) + fabsf(m.rows[i].y) + fabsf(m.rows[i].z);
    }
    return plii_max(plii_max(sums[0], sums[1]), sums[2]);
}

/* Over the columns. */
static float polar_norm_1(pli_mat3 m) {
    return polar_norm_infinity(pli_mat3_transpose(m));
}

pli_mat3 plii_polar_factor_of_bullet(pli_mat3 a) {
    pli_mat3 u = a;
    pli_mat3 inverse = plii_mat3_inverse(a);
    for (int i = 0; i < POLAR_MAX_ITERATIONS; ++i) {
        const float inverse_norm_1 = polar_norm_1(inverse);
        const float inverse_norm = inverse_norm_1 * polar_norm_infinity(inverse);
        const float u_norm_1 = polar_norm_1(u);
        const float u_norm = u_norm_1 * polar_norm_infinity(u);
        if (inverse_norm < PLII_EPSILON || u_norm < PLII_EPSILON) { break; }
        const float gamma = powf(inverse_norm / u_norm, 0.25f);
        const float inverse_gamma = 1.0f / gamma;
        const pli_mat3 transposed = pli_mat3_transpose(inverse);
        pli_mat3 delta;
        for (int r = 0; r < 3; ++r) {
            const pli_vec3 sum = pli_vec3_add(pli_vec3_scale(u.rows[r], gamma - 2.0f),
                                              pli_vec3_scale(transposed.rows[r], inverse_gamma));
            delta.rows[r] = pli_vec3_scale(sum, 0.5f);
        }
        u = plii_mat3_add(u, delta);
        if (polar_norm_1(delta) <= POLAR_TOLERANCE * u_norm_1) { break; }
        inverse = plii_mat3_inverse(u);
    }
    return u;
}

/* False for NaN too. */
static bool polar_is_orthogonal(pli_mat3 u) {
    for (int i = 0; i < 3; ++i) {
        if (!(fabsf(pli_vec3_length_squared(u.rows[i]) - 1.0f) <= POLAR_TOLERANCE)) { return false; }
        if (!(fabsf(pli_vec3_dot(u.rows[i], u.rows[(i + 1) % 3])) <= POLAR_TOLERANCE)) { return false; }
    }
    return true;
}

pli_mat3 plii_polar_factor(pli_mat3 a, pli_mat3 fallback) {
    const pli_mat3 u = plii_polar_factor_of_bullet(a);
    if (plii_mat3_is_finite(u)) { return u; }
    /* Singular: at unit size the matrix of cofactors is u3 v3^T times the product of the two other singular values.
       Added, it supplies the missing direction with the sign that makes a rotation. */
    const float size = polar_norm_infinity(a);
    pli_mat3 unit;
    for (int i = 0; i < 3; ++i) {
        unit.rows[i] = pli_vec3_make(a.rows[i].x / size, a.rows[i].y / size, a.rows[i].z / size);
    }
    pli_mat3 completed = unit;
    for (int i = 0; i < 3; ++i) {
        const pli_vec3 cofactors = pli_vec3_cross(unit.rows[(i + 1) % 3], unit.rows[(i + 2) % 3]);
        completed.rows[i] = pli_vec3_add(unit.rows[i], cofactors);
    }
    const pli_mat3 rotation = plii_polar_factor_of_bullet(completed);
    return polar_is_orthogonal(rotation) ? rotation : fallback;
}
