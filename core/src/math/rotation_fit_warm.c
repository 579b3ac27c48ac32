/* Nearest rotations by Newton's method from starts nearby. With S = transpose(R) A the trace of exp(-w) S, to second
   order in the rotation vector w, is largest where (trace(S) - sym(S)) w is the axial vector of S. Where that matrix is
   positive definite, a rotation of zero is the maximum over all rotations, so what has converged is right. */

#include "math/simd_float4.h"

#include "math/rotation_fit_warm.h"

#include "math/rotation_fit.h"

#define FOLLOW_MOST_STEPS 4
#define FOLLOW_LAST_STEP                                                                                               \
    3e-3f /* radians; what is left goes with its cube: where S is symmetric, nothing is of order 3 */
/* Least determinant of the second derivative, for matrices of norm 1: the error is that of floats over the smallest of
   its eigenvalues, which is hardly less, as the others are at most 1.5. */
#define FOLLOW_LEAST_DETERMINANT 0.05f

enum { LANES = PLII_ROTATION_FOLLOW_LANES };

typedef struct follow_quat {
    plii_float4 w, x, y, z;
} follow_quat;

typedef struct follow_mat3 {
    plii_vec3x4 rows[3];
} follow_mat3;

static plii_float4 follow_inverse_root(plii_float4 squared) {
    return 1.0f / plii_float4_sqrt(squared);
}

static plii_float4 follow_squared(follow_quat q) {
    return q.w * q.w + q.x * q.x + (q.y * q.y + q.z * q.z);
}

static follow_quat follow_normalize(follow_quat q) {
    const plii_float4 scale = follow_inverse_root(follow_squared(q));
    return (follow_quat){q.w * scale, q.x * scale, q.y * scale, q.z * scale};
}

/* A unit quaternion turned by the vector w, but for the third order of its length. */
static follow_quat follow_rotate(follow_quat q, plii_vec3x4 w) {
    const plii_vec3x4 half = plii_vec3x4_scale(w, plii_float4_all(0.5f));
    const plii_float4 scale = follow_inverse_root(1.0f + plii_vec3x4_dot(half, half));
    const plii_vec3x4 v = {q.x, q.y, q.z};
    const plii_vec3x4 moved =
        plii_vec3x4_add(plii_vec3x4_add(v, plii_vec3x4_scale(half, q.w)), plii_vec3x4_cross(v, half));
    return (follow_quat){(q.w - plii_vec3x4_dot(v, half)) * scale, moved.x * scale, moved.y * scale, moved.z * scale};
}

/* `two` is 2 over the square of its length, which hardly differs from 1. */
static follow_mat3 follow_matrix(follow_quat q, plii_float4 two) {
    const plii_float4 x2 = q.x * two, y2 = q.y * two, z2 = q.z * two;
    const plii_float4 xx = q.x * x2, yy = q.y * y2, zz = q.z * z2;
    const plii_float4 xy = q.x * y2, xz = q.x * z2, yz = q.y * z2;
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

static follow_quat follow_select(plii_mask4 mask, follow_quat yes, follow_quat no) {
    return (follow_quat){plii_lanes_select(mask, yes.w, no.w), plii_lanes_select(mask, yes.x, no.x),
                         plii_lanes_select(mask, yes.y, no.y), plii_lanes_select(mask, yes.z, no.z)};
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

static follow_mat3 follow_load(const pli_mat3* const matrices[LANES]) {
    follow_mat3 loaded;
    plii_float4 squared = plii_float4_all(0.0f);
    for (int k = 0; k < 3; ++k) {
        plii_float4 rows[LANES];
        for (int i = 0; i < LANES; ++i) {
            rows[i] = plii_lanes_from_vec3(&matrices[i]->rows[k]);
        }
        plii_float4_transpose(rows);
        loaded.rows[k] = (plii_vec3x4){rows[0], rows[1], rows[2]};
        squared += plii_vec3x4_dot(loaded.rows[k], loaded.rows[k]);
    }
    const plii_float4 scale = follow_inverse_root(squared);
    for (int k = 0; k < 3; ++k) {
        loaded.rows[k] = plii_vec3x4_scale(loaded.rows[k], scale);
    }
    return loaded;
}

static follow_quat follow_load_starts(const pli_quat* const starts[LANES]) {
    float w[LANES], x[LANES], y[LANES], z[LANES];
    for (int i = 0; i < LANES; ++i) {
        w[i] = starts[i]->w;
        x[i] = starts[i]->x;
        y[i] = starts[i]->y;
        z[i] = starts[i]->z;
    }
    return follow_normalize(
        (follow_quat){plii_float4_load(w), plii_float4_load(x), plii_float4_load(y), plii_float4_load(z)});
}

static void follow_store(follow_quat q, int lane_count, int found, pli_quat* quaternions, pli_mat3* rotations) {
    const follow_mat3 matrix = follow_matrix(q, 2.0f / follow_squared(q));
    float w[LANES], x[LANES], y[LANES], z[LANES];
    pli_vec3 rows[3][LANES];
    plii_float4_store(w, q.w);
    plii_float4_store(x, q.x);
    plii_float4_store(y, q.y);
    plii_float4_store(z, q.z);
    for (int k = 0; k < 3; ++k) {
        plii_vec3x4_to(rows[k], matrix.rows[k]);
    }
    for (int i = 0; i < lane_count; ++i) {
        if ((found >> i & 1) == 0) { continue; }
        quaternions[i] = (pli_quat){.x = x[i], .y = y[i], .z = z[i], .w = w[i]};
        rotations[i] = (pli_mat3){{rows[0][i], rows[1][i], rows[2][i]}};
    }
}

/* Returns the bits of those that were found. */
static int follow_block(int lane_count, const pli_mat3* matrices, pli_quat* quaternions, pli_mat3* rotations) {
    const pli_mat3* sources[LANES];
    const pli_quat* starts[LANES];
    for (int i = 0; i < LANES; ++i) {
        sources[i] = &matrices[i < lane_count ? i : 0]; /* surplus lanes repeat the first */
        starts[i] = &quaternions[i < lane_count ? i : 0];
    }
    const follow_mat3 a = follow_load(sources);
    follow_quat q = follow_load_starts(starts);
    plii_mask4 is_found = {0};
    for (int step = 0; step < FOLLOW_MOST_STEPS && plii_lanes_bits(is_found) != (1 << LANES) - 1; ++step) {
        const follow_mat3 r = follow_matrix(q, plii_float4_all(2.0f));
        plii_mask4 is_sound;
        const plii_vec3x4 rotation = follow_step(&r, &a, &is_sound);
        /* A lane that is done stays as it is, whatever its neighbours need. */
        q = follow_select(is_found, q, follow_rotate(q, rotation));
        const plii_mask4 is_small = plii_vec3x4_dot(rotation, rotation) < FOLLOW_LAST_STEP * FOLLOW_LAST_STEP;
        is_found |= (is_sound & is_small);
    }
    const int found = plii_lanes_bits(is_found);
    follow_store(q, lane_count, found, quaternions, rotations);
    return found;
}

void plii_rotation_fit_warm(int count, const pli_mat3* matrices, pli_quat* quaternions, pli_mat3* rotations) {
    for (int begin = 0; begin < count; begin += LANES) {
        const int lane_count = count - begin < LANES ? count - begin : LANES;
        const int found = follow_block(lane_count, matrices + begin, quaternions + begin, rotations + begin);
        for (int i = begin; i < begin + lane_count; ++i) {
            if ((found >> (i - begin) & 1) != 0) { continue; }
            rotations[i] = plii_rotation_fit(&matrices[i], &quaternions[i]);
        }
    }
}
