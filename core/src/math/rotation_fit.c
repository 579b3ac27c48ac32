/* Nearest rotations. Horn ("Closed-form solution of absolute orientation using unit quaternions", 1987): the wanted
   quaternion is the eigenvector of the largest eigenvalue of a symmetric 4x4 matrix, found by Jacobi's rotations. Where
   that eigenvalue is multiple, or nearly so, it is the part of the start in its eigenspace. In double, as the error in
   float would be 1e-7 over the relative gap of the singular values. */

#include "math/rotation_fit.h"
#include "math/simd_float4.h"

#include <string.h>

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

/* Makes a symmetric matrix diagonal; the rows of `axes` become its eigenvectors. */
static void rotation_diagonalize(double n[4][4], double axes[4][4]) {
    for (int sweep = 0; sweep < ROTATION_SWEEPS; ++sweep) {
        for (int pair = 0; pair < 6; ++pair) {
            static const int rows[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
            const int p = rows[pair][0], q = rows[pair][1];
            if (fabs(n[p][q]) < ROTATION_NOTHING) { continue; }
            const double cotangent = (n[q][q] - n[p][p]) / (2.0 * n[p][q]);
            const double t = copysign(1.0, cotangent) / (fabs(cotangent) + sqrt(cotangent * cotangent + 1.0));
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
        rotation_diagonalize(n, axes);
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

enum { LANES = PLII_ROTATION_LANES };

typedef struct follow_quat {
    plii_float4 w;
    plii_vec3x4 v;
} follow_quat;

typedef struct follow_mat3 {
    plii_vec3x4 rows[3];
} follow_mat3;

static plii_float4 follow_squared(follow_quat q) {
    return q.w * q.w + plii_vec3x4_dot(q.v, q.v);
}

static follow_quat follow_normalize(follow_quat q) {
    const plii_float4 scale = 1.0f / plii_float4_sqrt(follow_squared(q));
    return (follow_quat){q.w * scale, plii_vec3x4_scale(q.v, scale)};
}

/* A unit quaternion turned by the vector w, but for the third order of its length. */
static follow_quat follow_rotate(follow_quat q, plii_vec3x4 w) {
    const plii_vec3x4 half = plii_vec3x4_scale(w, plii_float4_all(0.5f));
    const plii_vec3x4 moved =
        plii_vec3x4_add(plii_vec3x4_add(q.v, plii_vec3x4_scale(half, q.w)), plii_vec3x4_cross(q.v, half));
    return follow_normalize((follow_quat){q.w - plii_vec3x4_dot(q.v, half), moved});
}

/* `two` is 2 over the square of its length, which hardly differs from 1. */
static follow_mat3 follow_matrix(follow_quat q, plii_float4 two) {
    const plii_float4 x = q.v.x, y = q.v.y, z = q.v.z, x2 = x * two, y2 = y * two, z2 = z * two;
    const plii_float4 xx = x * x2, yy = y * y2, zz = z * z2, xy = x * y2, xz = x * z2, yz = y * z2;
    const plii_float4 wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
    return (follow_mat3){{{1.0f - (yy + zz), xy - wz, xz + wy},
                          {xy + wz, 1.0f - (xx + zz), yz - wx},
                          {xz - wy, yz + wx, 1.0f - (xx + yy)}}};
}

/* A row of transpose(r) a. */
static plii_vec3x4 follow_row(plii_float4 r0, plii_float4 r1, plii_float4 r2, const follow_mat3* a) {
    return plii_vec3x4_add(plii_vec3x4_add(plii_vec3x4_scale(a->rows[0], r0), plii_vec3x4_scale(a->rows[1], r1)),
                           plii_vec3x4_scale(a->rows[2], r2));
}

/* The rotation vector of a step; `is_sound` where it is one to a maximum. */
static plii_vec3x4 follow_step(const follow_mat3* r, const follow_mat3* a, plii_mask4* is_sound) {
    const plii_vec3x4 s0 = follow_row(r->rows[0].x, r->rows[1].x, r->rows[2].x, a);
    const plii_vec3x4 s1 = follow_row(r->rows[0].y, r->rows[1].y, r->rows[2].y, a);
    const plii_vec3x4 s2 = follow_row(r->rows[0].z, r->rows[1].z, r->rows[2].z, a);
    const plii_vec3x4 axial = {s2.y - s1.z, s0.z - s2.x, s1.x - s0.y};
    const plii_float4 xx = s1.y + s2.z, yy = s0.x + s2.z, zz = s0.x + s1.y;
    const plii_float4 xy = -0.5f * (s0.y + s1.x), xz = -0.5f * (s0.z + s2.x), yz = -0.5f * (s1.z + s2.y);
    const plii_vec3x4 rows[3] = {{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
    const plii_vec3x4 cofactors[3] = {plii_vec3x4_cross(rows[1], rows[2]), plii_vec3x4_cross(rows[2], rows[0]),
                                      plii_vec3x4_cross(rows[0], rows[1])};
    const plii_float4 determinant = plii_vec3x4_dot(rows[0], cofactors[0]);
    *is_sound = (xx > 0.0f) & ((cofactors[2].z > 0.0f) & (determinant > FOLLOW_LEAST_DETERMINANT));
    const plii_vec3x4 sum = {plii_vec3x4_dot(cofactors[0], axial), plii_vec3x4_dot(cofactors[1], axial),
                             plii_vec3x4_dot(cofactors[2], axial)};
    return plii_vec3x4_scale(sum, 1.0f / determinant);
}

/* Of norm 1. */
static follow_mat3 follow_load(const pli_mat3 matrices[LANES]) {
    follow_mat3 loaded;
    plii_float4 squared = plii_float4_all(0.0f);
    for (int k = 0; k < 3; ++k) {
        plii_float4 rows[LANES];
        for (int i = 0; i < LANES; ++i) {
            rows[i] = plii_lanes_from_vec3(&matrices[i].rows[k]);
        }
        plii_float4_transpose(rows);
        loaded.rows[k] = (plii_vec3x4){rows[0], rows[1], rows[2]};
        squared += plii_vec3x4_dot(loaded.rows[k], loaded.rows[k]);
    }
    const plii_float4 scale = 1.0f / plii_float4_sqrt(squared);
    for (int k = 0; k < 3; ++k) {
        loaded.rows[k] = plii_vec3x4_scale(loaded.rows[k], scale);
    }
    return loaded;
}

/* Newton's method on four; returns the bits of those that were found. */
static int follow_block(const pli_mat3 matrices[LANES], pli_quat quaternions[LANES], pli_mat3 rotations[LANES]) {
    const follow_mat3 a = follow_load(matrices);
    plii_float4 records[LANES];
    memcpy(records, quaternions, sizeof records);
    plii_float4_transpose(records);
    follow_quat q = follow_normalize((follow_quat){records[3], {records[0], records[1], records[2]}});
    plii_mask4 is_found = {0};
    for (int step = 0; step < FOLLOW_MOST_STEPS && plii_lanes_bits(is_found) != (1 << LANES) - 1; ++step) {
        const follow_mat3 r = follow_matrix(q, plii_float4_all(2.0f));
        plii_mask4 is_sound;
        const plii_vec3x4 rotation = follow_step(&r, &a, &is_sound);
        /* A lane that is done stays as it is, whatever its neighbours need. */
        const follow_quat next = follow_rotate(q, rotation);
        q = (follow_quat){plii_lanes_select(is_found, q.w, next.w), plii_vec3x4_select(is_found, q.v, next.v)};
        const plii_mask4 is_small = plii_vec3x4_dot(rotation, rotation) < FOLLOW_LAST_STEP * FOLLOW_LAST_STEP;
        is_found |= (is_sound & is_small);
    }
    const follow_mat3 found = follow_matrix(q, 2.0f / follow_squared(q));
    pli_vec3 rows[LANES];
    for (int k = 0; k < 3; ++k) {
        plii_vec3x4_to(rows, found.rows[k]);
        for (int i = 0; i < LANES; ++i) {
            rotations[i].rows[k] = rows[i];
        }
    }
    records[0] = q.v.x;
    records[1] = q.v.y;
    records[2] = q.v.z;
    records[3] = q.w;
    plii_float4_transpose(records);
    memcpy(quaternions, records, sizeof records);
    return plii_lanes_bits(is_found);
}

void plii_rotation_fit_warm(int count, const pli_mat3* matrices, pli_quat* quaternions, pli_mat3* rotations) {
    for (int begin = 0; begin < count; begin += LANES) {
        pli_mat3 sources[LANES], fits[LANES];
        pli_quat turns[LANES];
        for (int i = 0; i < LANES; ++i) {
            const int item = begin + i < count ? begin + i : begin; /* surplus lanes repeat the first */
            sources[i] = matrices[item];
            turns[i] = quaternions[item];
        }
        const int found = follow_block(sources, turns, fits);
        for (int i = 0; i < LANES && begin + i < count; ++i) {
            if ((found >> i & 1) != 0) {
                quaternions[begin + i] = turns[i];
                rotations[begin + i] = fits[i];
            } else {
                rotations[begin + i] = plii_rotation_fit(&matrices[begin + i], &quaternions[begin + i]);
            }
        }
    }
}
