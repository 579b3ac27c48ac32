/* Nearest rotations by Newton's method from starts nearby. With S = transpose(R) A the trace of exp(-w) S, to second
   order in the rotation vector w, is largest where (trace(S) - sym(S)) w is the axial vector of S. Where that matrix is
   positive definite, a rotation of zero is the maximum over all rotations, so what has converged is right. */

#include "math/simd_float4.h"

#include "math/rotation_fit_warm.h"

#include "math/rotation_fit.h"

#include <string.h>

#define FOLLOW_MOST_STEPS 4
/* Radians; what is left goes with its cube: where S is symmetric, nothing is of order 3. */
#define FOLLOW_LAST_STEP 3e-3f
/* Least determinant of the second derivative, for matrices of norm 1: the error is that of floats over the smallest of
   its eigenvalues, which is hardly less, as the others are at most 1.5. */
#define FOLLOW_LEAST_DETERMINANT 0.05f

enum { LANES = PLII_ROTATION_FOLLOW_LANES };

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
