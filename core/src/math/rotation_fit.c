/* Nearest rotations, and below them polar factors. Horn ("Closed-form solution of absolute orientation using unit
   quaternions", 1987): the wanted quaternion is the eigenvector of the largest eigenvalue of a symmetric 4x4 matrix,
   found by Jacobi's rotations. Where that eigenvalue is multiple, or nearly so, it is the part of the start in its
   eigenspace. In double, as the error in float would be 1e-7 over the relative gap of the singular values. */

#include "math/rotation_fit.h"

#include "math/simd_float4.h"

#define ROTATION_NEAR 1e-6       /* of the norm: eigenvalues so near to the largest share its eigenspace */
#define ROTATION_LEAST_PART 0.01 /* of the start, squared, that must lie in the eigenspace */
#define ROTATION_NOTHING 1e-30   /* of the norm */
#define ROTATION_SWEEPS 8        /* convergence is quadratic: six reach the precision of double */

/* Scales to length 1; false, and nothing changed, for what has no length or is not finite. */
static bool rotation_normalize(int count, double* values) {
    double squared = 0.0;
    for (int k = 0; k < count; ++k) {
        squared += values[k] * values[k];
    }
    if (!(squared > 0.0) || !isfinite(squared)) { return false; }
    for (int k = 0; k < count; ++k) {
        values[k] /= sqrt(squared);
    }
    return true;
}

static double rotation_dot(const double a[4], const double b[4]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

void plii_diagonalize(double n[4][4], double axes[4][4]) {
    for (int sweep = 0; sweep < ROTATION_SWEEPS; ++sweep) {
        for (int pair = 0; pair < 6; ++pair) {
            static const int rows[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
            const int p = rows[pair][0], q = rows[pair][1];
            if (fabs(n[p][q]) < ROTATION_NOTHING) { continue; }
            const double cotangent = (n[q][q] - n[p][p]) / (2.0 * n[p][q]);
            const double t = (cotangent >= 0.0 ? 1.0 : -1.0) / (fabs(cotangent) + sqrt(cotangent * cotangent + 1.0));
            const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
            for (int k = 0; k < 4; ++k) {
                const double from_p = n[k][p], from_q = n[k][q];
                n[k][p] = c * from_p - s * from_q;
                n[k][q] = s * from_p + c * from_q;
            }
            for (int k = 0; k < 4; ++k) {
                const double from_p = n[p][k], from_q = n[q][k], axis_p = axes[p][k], axis_q = axes[q][k];
                n[p][k] = c * from_p - s * from_q;
                n[q][k] = s * from_p + c * from_q;
                axes[p][k] = c * axis_p - s * axis_q;
                axes[q][k] = s * axis_p + c * axis_q;
            }
        }
    }
}

/* The part of the start in the eigenspace of the largest eigenvalue, unit. */
static void rotation_project(double n[4][4], double axes[4][4], const double start[4], double q[4]) {
    int largest = 0;
    for (int i = 1; i < 4; ++i) {
        if (n[i][i] > n[largest][largest]) { largest = i; }
    }
    for (int i = 0; i < 4; ++i) {
        /* Smoothly from all to nothing, lest a small change of the matrix makes a large one of the result. */
        const double near = ROTATION_NEAR / (n[largest][largest] - n[i][i] + ROTATION_NEAR);
        const double part = near * near * near * rotation_dot(axes[i], start);
        for (int k = 0; k < 4; ++k) {
            q[k] += part * axes[i][k];
        }
    }
    if (rotation_dot(q, q) > ROTATION_LEAST_PART && rotation_normalize(4, q)) { return; }
    const double sign = rotation_dot(axes[largest], start) < 0.0 ? -1.0 : 1.0;
    for (int k = 0; k < 4; ++k) {
        q[k] = sign * axes[largest][k];
    }
}

pli_mat3 plii_rotation_fit(const pli_mat3* matrix, pli_quat* quaternion) {
    const pli_vec3* rows = matrix->rows;
    /* Squares of floats neither overflow nor vanish in double. */
    double m[9] = {(double)rows[0].x, (double)rows[0].y, (double)rows[0].z, (double)rows[1].x, (double)rows[1].y,
                   (double)rows[1].z, (double)rows[2].x, (double)rows[2].y, (double)rows[2].z};
    double start[4] = {(double)quaternion->w, (double)quaternion->x, (double)quaternion->y, (double)quaternion->z};
    double q[4] = {0.0, 0.0, 0.0, 0.0};
    if (!rotation_normalize(4, start)) {
        start[0] = 1.0;
        start[1] = start[2] = start[3] = 0.0;
    }
    double n[4][4] = {{0.0}}, axes[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    if (rotation_normalize(9, m)) {
        const double trace = m[0] + m[4] + m[8];
        const double wx = m[7] - m[5], wy = m[2] - m[6], wz = m[3] - m[1];
        const double xy = m[1] + m[3], xz = m[2] + m[6], yz = m[5] + m[7];
        const double horn[4][4] = {{trace, wx, wy, wz},
                                   {wx, 2.0 * m[0] - trace, xy, xz},
                                   {wy, xy, 2.0 * m[4] - trace, yz},
                                   {wz, xz, yz, 2.0 * m[8] - trace}};
        memcpy(n, horn, sizeof n);
        plii_diagonalize(n, axes);
    }
    rotation_project(n, axes, start, q);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    *quaternion = (pli_quat){.x = (float)x, .y = (float)y, .z = (float)z, .w = (float)w};
    return (pli_mat3){
        {{(float)(1.0 - 2.0 * (y * y + z * z)), (float)(2.0 * (x * y - w * z)), (float)(2.0 * (x * z + w * y))},
         {(float)(2.0 * (x * y + w * z)), (float)(1.0 - 2.0 * (x * x + z * z)), (float)(2.0 * (y * z - w * x))},
         {(float)(2.0 * (x * z - w * y)), (float)(2.0 * (y * z + w * x)), (float)(1.0 - 2.0 * (x * x + y * y))}}};
}

/* By Newton's method. With S = transpose(R) A the trace of exp(-w) S, to second
   order in the rotation vector w, is largest where (trace(S) - sym(S)) w is the axial vector of S. Where that matrix is
   positive definite, a rotation of zero is the maximum over all rotations, so what has converged is right. */

#define FOLLOW_MOST_STEPS 4
/* Radians; what is left goes with its cube: where S is symmetric, nothing is of order 3. */
#define FOLLOW_LAST_STEP 3e-3f
/* Least determinant of the second derivative, for matrices of norm 1: the error is that of floats over the smallest of
   its eigenvalues, which is hardly less, as the others are at most 1.5. */
#define FOLLOW_LEAST_DETERMINANT 0.05f

/* Four unit quaternions by components. */
typedef struct follow_quats {
    plii_vec3x4 v;
    plii_float4 w;
} follow_quats;

/* Turned by vectors, but for the third order of their length. */
static follow_quats follow_rotate(follow_quats q, plii_vec3x4 rotation) {
    const plii_vec3x4 half = plii_vec3x4_scale(rotation, plii_float4_all(0.5f));
    const plii_vec3x4 moved = plii_vec3x4_add(q.v, plii_vec3x4_scale(half, q.w));
    const plii_vec3x4 v = plii_vec3x4_add(moved, plii_vec3x4_cross(q.v, half));
    const plii_float4 w = q.w - plii_vec3x4_dot(q.v, half);
    const plii_float4 scale = 1.0f / plii_float4_sqrt(w * w + plii_vec3x4_dot(v, v));
    return (follow_quats){plii_vec3x4_scale(v, scale), w * scale};
}

/* The rotation vectors of a step from quaternions whose length hardly differs from 1, for the rows of matrices; all
   bits of `are_sound` where it is one to a maximum. */
static plii_vec3x4 follow_step(follow_quats q, const plii_vec3x4 a[3], plii_mask4* are_sound) {
    const plii_float4 x2 = q.v.x * 2.0f, y2 = q.v.y * 2.0f, z2 = q.v.z * 2.0f;
    const plii_float4 qxx = q.v.x * x2, qyy = q.v.y * y2, qzz = q.v.z * z2;
    const plii_float4 qxy = q.v.x * y2, qxz = q.v.x * z2, qyz = q.v.y * z2;
    const plii_float4 wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
    const plii_vec3x4 columns[3] = {{1.0f - (qyy + qzz), qxy + wz, qxz - wy},
                                    {qxy - wz, 1.0f - (qxx + qzz), qyz + wx},
                                    {qxz + wy, qyz - wx, 1.0f - (qxx + qyy)}};
    plii_vec3x4 s[3];
    PLII_UNROLL(3)
    for (int k = 0; k < 3; ++k) {
        s[k] = plii_vec3x4_add(plii_vec3x4_scale(a[0], columns[k].x), plii_vec3x4_scale(a[1], columns[k].y));
        s[k] = plii_vec3x4_add(s[k], plii_vec3x4_scale(a[2], columns[k].z));
    }
    const plii_vec3x4 axial = {s[2].y - s[1].z, s[0].z - s[2].x, s[1].x - s[0].y};
    const plii_float4 xx = s[1].y + s[2].z, yy = s[0].x + s[2].z, zz = s[0].x + s[1].y;
    const plii_float4 xy = -0.5f * (s[0].y + s[1].x), xz = -0.5f * (s[0].z + s[2].x), yz = -0.5f * (s[1].z + s[2].y);
    const plii_vec3x4 rows[3] = {{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
    const plii_vec3x4 x = plii_vec3x4_cross(rows[1], rows[2]), y = plii_vec3x4_cross(rows[2], rows[0]);
    const plii_vec3x4 z = plii_vec3x4_cross(rows[0], rows[1]); /* cofactors */
    const plii_float4 determinant = plii_vec3x4_dot(rows[0], x);
    *are_sound = (xx > 0.0f) & (z.z > 0.0f) & (determinant > FOLLOW_LEAST_DETERMINANT);
    const plii_vec3x4 step = {plii_vec3x4_dot(x, axial), plii_vec3x4_dot(y, axial), plii_vec3x4_dot(z, axial)};
    return plii_vec3x4_scale(step, 1.0f / determinant);
}

void plii_rotations_fit_warm(int count, pli_mat3* matrices, pli_quat* const* quaternions) {
    plii_float4 lanes[4][PLII_LANES]; /* rows and quaternions; where there are fewer than four, the first again */
    PLII_UNROLL(4)
    for (int i = 0; i < PLII_LANES; ++i) {
        const int from = i < count ? i : 0;
        PLII_UNROLL(3)
        for (int k = 0; k < 3; ++k) {
            lanes[k][i] = plii_lanes_from_vec3(&matrices[from].rows[k]);
        }
        lanes[3][i] = plii_float4_load(&quaternions[from]->x);
    }
    plii_float4 squared = plii_float4_all(0.0f);
    PLII_UNROLL(3)
    for (int k = 0; k < 3; ++k) {
        plii_float4_transpose(lanes[k]);
        squared += lanes[k][0] * lanes[k][0] + lanes[k][1] * lanes[k][1] + lanes[k][2] * lanes[k][2];
    }
    const plii_float4 scale = 1.0f / plii_float4_sqrt(squared);
    plii_vec3x4 a[3]; /* of norm 1 */
    PLII_UNROLL(3)
    for (int k = 0; k < 3; ++k) {
        a[k] = (plii_vec3x4){lanes[k][0] * scale, lanes[k][1] * scale, lanes[k][2] * scale};
    }
    plii_float4_transpose(lanes[3]);
    follow_quats q = {{lanes[3][0], lanes[3][1], lanes[3][2]}, lanes[3][3]};
    plii_mask4 are_done = {0, 0, 0, 0};
    for (int step = 0; step < FOLLOW_MOST_STEPS && plii_lanes_bits(are_done) != (1 << PLII_LANES) - 1; ++step) {
        plii_mask4 are_sound;
        const plii_vec3x4 rotation = follow_step(q, a, &are_sound);
        const follow_quats next = follow_rotate(q, rotation);
        q = (follow_quats){plii_vec3x4_select(are_done, q.v, next.v), plii_lanes_select(are_done, q.w, next.w)};
        are_done |= are_sound & (plii_vec3x4_dot(rotation, rotation) < FOLLOW_LAST_STEP * FOLLOW_LAST_STEP);
    }
    plii_float4 found[PLII_LANES] = {q.v.x, q.v.y, q.v.z, q.w};
    plii_float4_transpose(found);
    for (int i = 0; i < count; ++i) {
        if (are_done[i]) { plii_float4_store(&quaternions[i]->x, found[i]); }
        matrices[i] =
            are_done[i] ? pli_mat3_from_quat(*quaternions[i]) : plii_rotation_fit(&matrices[i], quaternions[i]);
    }
}

/* Polar decomposition by scaled Newton iteration (Higham, "Computing the polar decomposition with applications",
   1986), with the operations in the order of btPolarDecomposition. */

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
        const pli_mat3 sum =
            plii_mat3_add(plii_mat3_scale(u, gamma - 2.0f), plii_mat3_scale(pli_mat3_transpose(inverse), 1.0f / gamma));
        const pli_mat3 delta = plii_mat3_scale(sum, 0.5f);
        u = plii_mat3_add(u, delta);
        if (polar_norm_1(delta) <= POLAR_TOLERANCE * u_norm_1) { break; }
        inverse = plii_mat3_inverse(u);
    }
    return u;
}

pli_mat3 plii_polar_factor(pli_mat3 a, pli_mat3 start) {
    const pli_mat3 u = plii_polar_factor_of_bullet(a);
    pli_quat turned = plii_quat_near(&start);
    return plii_mat3_is_finite(u) ? u : plii_rotation_fit(&a, &turned);
}
