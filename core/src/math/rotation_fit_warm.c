/* Nearest rotations by Newton's method from starts nearby. With S = transpose(R) A the trace of exp(-w) S, to second
   order in the turn w, is largest where (trace(S) - sym(S)) w is the axial vector of S. Where that matrix is positive
   definite, a turn of zero is the maximum over all rotations, so what has converged is right. */

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
    return plii_float4_div(plii_float4_all(1.0f), plii_float4_sqrt(squared));
}

static plii_float4 follow_squared(follow_quat q) {
    return plii_float4_add(plii_float4_add(plii_float4_mul(q.w, q.w), plii_float4_mul(q.x, q.x)),
                           plii_float4_add(plii_float4_mul(q.y, q.y), plii_float4_mul(q.z, q.z)));
}

static follow_quat follow_normalize(follow_quat q) {
    const plii_float4 scale = follow_inverse_root(follow_squared(q));
    return (follow_quat){plii_float4_mul(q.w, scale), plii_float4_mul(q.x, scale), plii_float4_mul(q.y, scale),
                         plii_float4_mul(q.z, scale)};
}

/* A unit quaternion turned by the vector w, but for the third order of its length. */
static follow_quat follow_rotate(follow_quat q, plii_vec3x4 w) {
    const plii_vec3x4 half = plii_vec3x4_scale(w, plii_float4_all(0.5f));
    const plii_float4 scale = follow_inverse_root(plii_float4_add(plii_float4_all(1.0f), plii_vec3x4_dot(half, half)));
    const plii_vec3x4 v = {q.x, q.y, q.z};
    const plii_vec3x4 moved =
        plii_vec3x4_add(plii_vec3x4_add(v, plii_vec3x4_scale(half, q.w)), plii_vec3x4_cross(v, half));
    return (follow_quat){plii_float4_mul(plii_float4_sub(q.w, plii_vec3x4_dot(v, half)), scale),
                         plii_float4_mul(moved.x, scale), plii_float4_mul(moved.y, scale),
                         plii_float4_mul(moved.z, scale)};
}

/* `two` is 2 over the square of its length, which hardly differs from 1. */
static follow_mat3 follow_matrix(follow_quat q, plii_float4 two) {
    const plii_float4 one = plii_float4_all(1.0f);
    const plii_float4 x2 = plii_float4_mul(q.x, two), y2 = plii_float4_mul(q.y, two), z2 = plii_float4_mul(q.z, two);
    const plii_float4 xx = plii_float4_mul(q.x, x2), yy = plii_float4_mul(q.y, y2), zz = plii_float4_mul(q.z, z2);
    const plii_float4 xy = plii_float4_mul(q.x, y2), xz = plii_float4_mul(q.x, z2), yz = plii_float4_mul(q.y, z2);
    const plii_float4 wx = plii_float4_mul(q.w, x2), wy = plii_float4_mul(q.w, y2), wz = plii_float4_mul(q.w, z2);
    return (follow_mat3){
        {{plii_float4_sub(one, plii_float4_add(yy, zz)), plii_float4_sub(xy, wz), plii_float4_add(xz, wy)},
         {plii_float4_add(xy, wz), plii_float4_sub(one, plii_float4_add(xx, zz)), plii_float4_sub(yz, wx)},
         {plii_float4_sub(xz, wy), plii_float4_add(yz, wx), plii_float4_sub(one, plii_float4_add(xx, yy))}}};
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

/* The turn that a step makes; `is_sound` where it is one to a maximum. */
static plii_vec3x4 follow_step(const follow_mat3* r, const follow_mat3* a, plii_mask4* is_sound) {
    const plii_vec3x4 s0 = follow_row(r->rows[0].x, r->rows[1].x, r->rows[2].x, a);
    const plii_vec3x4 s1 = follow_row(r->rows[0].y, r->rows[1].y, r->rows[2].y, a);
    const plii_vec3x4 s2 = follow_row(r->rows[0].z, r->rows[1].z, r->rows[2].z, a);
    const plii_float4 minus_half = plii_float4_all(-0.5f), zero = plii_float4_all(0.0f);
    const plii_vec3x4 axial = {plii_float4_sub(s2.y, s1.z), plii_float4_sub(s0.z, s2.x), plii_float4_sub(s1.x, s0.y)};
    const plii_float4 xx = plii_float4_add(s1.y, s2.z), yy = plii_float4_add(s0.x, s2.z);
    const plii_float4 zz = plii_float4_add(s0.x, s1.y);
    const plii_float4 xy = plii_float4_mul(plii_float4_add(s0.y, s1.x), minus_half);
    const plii_float4 xz = plii_float4_mul(plii_float4_add(s0.z, s2.x), minus_half);
    const plii_float4 yz = plii_float4_mul(plii_float4_add(s1.z, s2.y), minus_half);
    const plii_vec3x4 rows[3] = {{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}};
    const plii_vec3x4 cofactors[3] = {plii_vec3x4_cross(rows[1], rows[2]), plii_vec3x4_cross(rows[2], rows[0]),
                                      plii_vec3x4_cross(rows[0], rows[1])};
    const plii_float4 determinant = plii_vec3x4_dot(rows[0], cofactors[0]);
    *is_sound =
        plii_lanes_both(plii_lanes_less(zero, xx),
                        plii_lanes_both(plii_lanes_less(zero, cofactors[2].z),
                                        plii_lanes_less(plii_float4_all(FOLLOW_LEAST_DETERMINANT), determinant)));
    const plii_float4 scale = plii_float4_div(plii_float4_all(1.0f), determinant);
    const plii_vec3x4 sum = {plii_vec3x4_dot(cofactors[0], axial), plii_vec3x4_dot(cofactors[1], axial),
                             plii_vec3x4_dot(cofactors[2], axial)};
    return plii_vec3x4_scale(sum, scale);
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
        squared = plii_float4_add(squared, plii_vec3x4_dot(loaded.rows[k], loaded.rows[k]));
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
    const follow_mat3 matrix = follow_matrix(q, plii_float4_div(plii_float4_all(2.0f), follow_squared(q)));
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
    const plii_float4 zero = plii_float4_all(0.0f), most = plii_float4_all(FOLLOW_LAST_STEP * FOLLOW_LAST_STEP);
    plii_mask4 is_found = plii_lanes_less(zero, zero);
    for (int step = 0; step < FOLLOW_MOST_STEPS && plii_lanes_bits(is_found) != (1 << LANES) - 1; ++step) {
        const follow_mat3 r = follow_matrix(q, plii_float4_all(2.0f));
        plii_mask4 is_sound;
        const plii_vec3x4 turn = follow_step(&r, &a, &is_sound);
        /* A lane that is done stays as it is, whatever its neighbours need. */
        q = follow_select(is_found, q, follow_rotate(q, turn));
        const plii_mask4 is_small = plii_lanes_less(plii_vec3x4_dot(turn, turn), most);
        is_found = plii_lanes_either(is_found, plii_lanes_both(is_sound, is_small));
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
