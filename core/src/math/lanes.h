#ifndef PLII_LANES_H
#define PLII_LANES_H

/* Four floats at a time, with instructions that every processor of the target has: the record of a node, or one
   component of four nodes. For passes over nodes and faces, whose results are those of the same operations one by one.
   Goes before other headers of the core, as it chooses the path of simd.h. */

#if defined(__SSE2__)
#define PLII_SIMD_SSE2
#elif defined(__ARM_NEON) && defined(__aarch64__)
#define PLII_SIMD_NEON
#else
#define PLII_SIMD_PORTABLE
#endif
#include "math/simd.h"

enum { PLII_LANES = 4, PLII_LANES_XYZ = 7 };

/* Masks have all bits or none set in a lane; plii_lanes_bits gives bit k for lane k. */
#if defined(PLII_SIMD_SSE2)

typedef __m128 plii_mask4;

PLII_SIMD_INLINE plii_mask4 plii_lanes_less(plii_float4 a, plii_float4 b) {
    return _mm_cmplt_ps(a, b);
}
PLII_SIMD_INLINE plii_mask4 plii_lanes_at_most(plii_float4 a, plii_float4 b) {
    return _mm_cmple_ps(a, b);
}
PLII_SIMD_INLINE plii_mask4 plii_lanes_both(plii_mask4 a, plii_mask4 b) {
    return _mm_and_ps(a, b);
}
PLII_SIMD_INLINE plii_mask4 plii_lanes_either(plii_mask4 a, plii_mask4 b) {
    return _mm_or_ps(a, b);
}
/* copysignf */
PLII_SIMD_INLINE plii_float4 plii_lanes_with_sign(plii_float4 size, plii_float4 sign) {
    const __m128 bit = _mm_set1_ps(-0.0f);
    return _mm_or_ps(_mm_andnot_ps(bit, size), _mm_and_ps(bit, sign));
}
PLII_SIMD_INLINE plii_float4 plii_lanes_select(plii_mask4 mask, plii_float4 yes, plii_float4 no) {
    return _mm_or_ps(_mm_and_ps(mask, yes), _mm_andnot_ps(mask, no));
}
PLII_SIMD_INLINE int plii_lanes_bits(plii_mask4 mask) {
    return _mm_movemask_ps(mask);
}
PLII_SIMD_INLINE float plii_lanes_first(plii_float4 a) {
    return _mm_cvtss_f32(a);
}
/* x, y, z, 0 */
PLII_SIMD_INLINE plii_float4 plii_lanes_xyz(plii_float4 a) {
    return _mm_and_ps(a, _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1)));
}
/* y, z, x, w */
PLII_SIMD_INLINE plii_float4 plii_lanes_yzx(plii_float4 a) {
    return _mm_shuffle_ps(a, a, _MM_SHUFFLE(3, 0, 2, 1));
}
/* y, z, w, next.x; before.w, x, y, z */
PLII_SIMD_INLINE plii_float4 plii_lanes_next(plii_float4 a, plii_float4 next) {
    const __m128 high = _mm_shuffle_ps(a, next, _MM_SHUFFLE(0, 0, 3, 3));
    return _mm_shuffle_ps(a, high, _MM_SHUFFLE(2, 0, 2, 1));
}
PLII_SIMD_INLINE plii_float4 plii_lanes_before(plii_float4 before, plii_float4 a) {
    const __m128 low = _mm_shuffle_ps(before, a, _MM_SHUFFLE(0, 0, 3, 3));
    return _mm_shuffle_ps(low, a, _MM_SHUFFLE(2, 1, 2, 0));
}
PLII_SIMD_INLINE plii_float4 plii_lanes_all_x(plii_float4 a) {
    return _mm_shuffle_ps(a, a, _MM_SHUFFLE(0, 0, 0, 0));
}
PLII_SIMD_INLINE plii_float4 plii_lanes_all_y(plii_float4 a) {
    return _mm_shuffle_ps(a, a, _MM_SHUFFLE(1, 1, 1, 1));
}
PLII_SIMD_INLINE plii_float4 plii_lanes_all_z(plii_float4 a) {
    return _mm_shuffle_ps(a, a, _MM_SHUFFLE(2, 2, 2, 2));
}
PLII_SIMD_INLINE plii_float4 plii_lanes_all_w(plii_float4 a) {
    return _mm_shuffle_ps(a, a, _MM_SHUFFLE(3, 3, 3, 3));
}
PLII_SIMD_INLINE plii_float4 plii_lanes_xyzw(float x, float y, float z, float w) {
    return _mm_setr_ps(x, y, z, w);
}
/* a < b ? a : b, and a > b ? a : b, also where one is NaN. */
PLII_SIMD_INLINE plii_float4 plii_lanes_min(plii_float4 a, plii_float4 b) {
    return _mm_min_ps(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_max(plii_float4 a, plii_float4 b) {
    return _mm_max_ps(a, b);
}
/* (x + y) + z */
PLII_SIMD_INLINE float plii_lanes_sum(plii_float4 a) {
    const __m128 y = _mm_shuffle_ps(a, a, _MM_SHUFFLE(1, 1, 1, 1)), z = _mm_movehl_ps(a, a);
    return _mm_cvtss_f32(_mm_add_ss(_mm_add_ss(a, y), z));
}
PLII_SIMD_INLINE plii_float4 plii_lanes_from_vec3(const pli_vec3* source) {
    const __m128i xy = _mm_loadl_epi64((const __m128i*)(const void*)source);
    return _mm_movelh_ps(_mm_castsi128_ps(xy), _mm_load_ss(&source->z));
}
PLII_SIMD_INLINE void plii_lanes_to_vec3(pli_vec3* target, plii_float4 a) {
    _mm_storel_pi((__m64*)(void*)target, a);
    _mm_store_ss(&target->z, _mm_movehl_ps(a, a));
}

#elif defined(PLII_SIMD_NEON)

typedef uint32x4_t plii_mask4;

PLII_SIMD_INLINE plii_mask4 plii_lanes_less(plii_float4 a, plii_float4 b) {
    return vcltq_f32(a, b);
}
PLII_SIMD_INLINE plii_mask4 plii_lanes_at_most(plii_float4 a, plii_float4 b) {
    return vcleq_f32(a, b);
}
PLII_SIMD_INLINE plii_mask4 plii_lanes_both(plii_mask4 a, plii_mask4 b) {
    return vandq_u32(a, b);
}
PLII_SIMD_INLINE plii_mask4 plii_lanes_either(plii_mask4 a, plii_mask4 b) {
    return vorrq_u32(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_with_sign(plii_float4 size, plii_float4 sign) {
    return vbslq_f32(vdupq_n_u32(0x80000000u), sign, size);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_select(plii_mask4 mask, plii_float4 yes, plii_float4 no) {
    return vbslq_f32(mask, yes, no);
}
PLII_SIMD_INLINE int plii_lanes_bits(plii_mask4 mask) {
    const uint32_t values[4] = {1, 2, 4, 8};
    return (int)vaddvq_u32(vandq_u32(mask, vld1q_u32(values)));
}
PLII_SIMD_INLINE float plii_lanes_first(plii_float4 a) {
    return vgetq_lane_f32(a, 0);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_xyz(plii_float4 a) {
    return vsetq_lane_f32(0.0f, a, 3);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_yzx(plii_float4 a) {
    const float32x4_t turned = vextq_f32(a, a, 1); /* y, z, w, x */
    return vsetq_lane_f32(vgetq_lane_f32(a, 3), vsetq_lane_f32(vgetq_lane_f32(a, 0), turned, 2), 3);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_next(plii_float4 a, plii_float4 next) {
    return vextq_f32(a, next, 1);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_before(plii_float4 before, plii_float4 a) {
    return vextq_f32(before, a, 3);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_all_x(plii_float4 a) {
    return vdupq_laneq_f32(a, 0);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_all_y(plii_float4 a) {
    return vdupq_laneq_f32(a, 1);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_all_z(plii_float4 a) {
    return vdupq_laneq_f32(a, 2);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_all_w(plii_float4 a) {
    return vdupq_laneq_f32(a, 3);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_xyzw(float x, float y, float z, float w) {
    return vsetq_lane_f32(w, vsetq_lane_f32(z, vsetq_lane_f32(y, vdupq_n_f32(x), 1), 2), 3);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_min(plii_float4 a, plii_float4 b) {
    return vbslq_f32(vcltq_f32(a, b), a, b);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_max(plii_float4 a, plii_float4 b) {
    return vbslq_f32(vcgtq_f32(a, b), a, b);
}
PLII_SIMD_INLINE float plii_lanes_sum(plii_float4 a) {
    return vgetq_lane_f32(a, 0) + vgetq_lane_f32(a, 1) + vgetq_lane_f32(a, 2);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_from_vec3(const pli_vec3* source) {
    return vsetq_lane_f32(source->z, vcombine_f32(vld1_f32(&source->x), vdup_n_f32(0.0f)), 2);
}
PLII_SIMD_INLINE void plii_lanes_to_vec3(pli_vec3* target, plii_float4 a) {
    vst1_f32(&target->x, vget_low_f32(a));
    target->z = vgetq_lane_f32(a, 2);
}

#else

typedef struct plii_mask4 {
    bool lanes[4];
} plii_mask4;

PLII_SIMD_INLINE plii_mask4 plii_lanes_less(plii_float4 a, plii_float4 b) {
    return (plii_mask4){
        {a.lanes[0] < b.lanes[0], a.lanes[1] < b.lanes[1], a.lanes[2] < b.lanes[2], a.lanes[3] < b.lanes[3]}};
}
PLII_SIMD_INLINE plii_mask4 plii_lanes_at_most(plii_float4 a, plii_float4 b) {
    return (plii_mask4){
        {a.lanes[0] <= b.lanes[0], a.lanes[1] <= b.lanes[1], a.lanes[2] <= b.lanes[2], a.lanes[3] <= b.lanes[3]}};
}
PLII_SIMD_INLINE plii_mask4 plii_lanes_both(plii_mask4 a, plii_mask4 b) {
    return (plii_mask4){
        {a.lanes[0] && b.lanes[0], a.lanes[1] && b.lanes[1], a.lanes[2] && b.lanes[2], a.lanes[3] && b.lanes[3]}};
}
PLII_SIMD_INLINE plii_mask4 plii_lanes_either(plii_mask4 a, plii_mask4 b) {
    return (plii_mask4){
        {a.lanes[0] || b.lanes[0], a.lanes[1] || b.lanes[1], a.lanes[2] || b.lanes[2], a.lanes[3] || b.lanes[3]}};
}
PLII_SIMD_INLINE plii_float4 plii_lanes_with_sign(plii_float4 size, plii_float4 sign) {
    return (plii_float4){{copysignf(size.lanes[0], sign.lanes[0]), copysignf(size.lanes[1], sign.lanes[1]),
                          copysignf(size.lanes[2], sign.lanes[2]), copysignf(size.lanes[3], sign.lanes[3])}};
}
PLII_SIMD_INLINE plii_float4 plii_lanes_select(plii_mask4 mask, plii_float4 yes, plii_float4 no) {
    return (plii_float4){{mask.lanes[0] ? yes.lanes[0] : no.lanes[0], mask.lanes[1] ? yes.lanes[1] : no.lanes[1],
                          mask.lanes[2] ? yes.lanes[2] : no.lanes[2], mask.lanes[3] ? yes.lanes[3] : no.lanes[3]}};
}
PLII_SIMD_INLINE int plii_lanes_bits(plii_mask4 mask) {
    return (mask.lanes[0] ? 1 : 0) | (mask.lanes[1] ? 2 : 0) | (mask.lanes[2] ? 4 : 0) | (mask.lanes[3] ? 8 : 0);
}
PLII_SIMD_INLINE float plii_lanes_first(plii_float4 a) {
    return a.lanes[0];
}
PLII_SIMD_INLINE plii_float4 plii_lanes_xyz(plii_float4 a) {
    return (plii_float4){{a.lanes[0], a.lanes[1], a.lanes[2], 0.0f}};
}
PLII_SIMD_INLINE plii_float4 plii_lanes_yzx(plii_float4 a) {
    return (plii_float4){{a.lanes[1], a.lanes[2], a.lanes[0], a.lanes[3]}};
}
PLII_SIMD_INLINE plii_float4 plii_lanes_next(plii_float4 a, plii_float4 next) {
    return (plii_float4){{a.lanes[1], a.lanes[2], a.lanes[3], next.lanes[0]}};
}
PLII_SIMD_INLINE plii_float4 plii_lanes_before(plii_float4 before, plii_float4 a) {
    return (plii_float4){{before.lanes[3], a.lanes[0], a.lanes[1], a.lanes[2]}};
}
PLII_SIMD_INLINE plii_float4 plii_lanes_all_x(plii_float4 a) {
    return plii_float4_all(a.lanes[0]);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_all_y(plii_float4 a) {
    return plii_float4_all(a.lanes[1]);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_all_z(plii_float4 a) {
    return plii_float4_all(a.lanes[2]);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_all_w(plii_float4 a) {
    return plii_float4_all(a.lanes[3]);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_xyzw(float x, float y, float z, float w) {
    return (plii_float4){{x, y, z, w}};
}
PLII_SIMD_INLINE plii_float4 plii_lanes_min(plii_float4 a, plii_float4 b) {
    return plii_lanes_select(plii_lanes_less(a, b), a, b);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_max(plii_float4 a, plii_float4 b) {
    return plii_lanes_select(plii_lanes_less(b, a), a, b);
}
PLII_SIMD_INLINE float plii_lanes_sum(plii_float4 a) {
    return a.lanes[0] + a.lanes[1] + a.lanes[2];
}
PLII_SIMD_INLINE plii_float4 plii_lanes_from_vec3(const pli_vec3* source) {
    return (plii_float4){{source->x, source->y, source->z, 0.0f}};
}
PLII_SIMD_INLINE void plii_lanes_to_vec3(pli_vec3* target, plii_float4 a) {
    *target = pli_vec3_make(a.lanes[0], a.lanes[1], a.lanes[2]);
}

#endif

/* pli_vec3_cross; w: 0 */
PLII_SIMD_INLINE plii_float4 plii_lanes_cross(plii_float4 a, plii_float4 b) {
    const plii_float4 zxy =
        plii_float4_sub(plii_float4_mul(a, plii_lanes_yzx(b)), plii_float4_mul(plii_lanes_yzx(a), b));
    return plii_lanes_yzx(zxy);
}
PLII_SIMD_INLINE float plii_lanes_dot(plii_float4 a, plii_float4 b) {
    return plii_lanes_sum(plii_float4_mul(a, b));
}
/* Lanes in which all bits are set where `a` is finite: a - a is 0 there, else NaN. */
PLII_SIMD_INLINE plii_mask4 plii_lanes_finite(plii_float4 a) {
    return plii_lanes_at_most(plii_float4_sub(a, a), plii_float4_all(0.0f));
}

/* x, y and z are finite. */
PLII_SIMD_INLINE bool plii_lanes_xyz_finite(plii_float4 a) {
    return (plii_lanes_bits(plii_lanes_finite(a)) & PLII_LANES_XYZ) == PLII_LANES_XYZ;
}

/* A matrix by columns; w of each is what its user puts there. */
typedef struct plii_lanes_mat3 {
    plii_float4 columns[3];
} plii_lanes_mat3;

PLII_SIMD_INLINE plii_lanes_mat3 plii_lanes_from_mat3(const pli_mat3* m) {
    plii_float4 rows[4] = {plii_lanes_from_vec3(&m->rows[0]), plii_lanes_from_vec3(&m->rows[1]),
                           plii_lanes_from_vec3(&m->rows[2]), plii_float4_all(0.0f)};
    plii_float4_turn(rows);
    return (plii_lanes_mat3){{rows[0], rows[1], rows[2]}};
}
/* pli_mat3_mul_vec3 */
PLII_SIMD_INLINE plii_float4 plii_lanes_mat3_mul(const plii_lanes_mat3* m, plii_float4 v) {
    return plii_float4_add(plii_float4_add(plii_float4_mul(m->columns[0], plii_lanes_all_x(v)),
                                           plii_float4_mul(m->columns[1], plii_lanes_all_y(v))),
                           plii_float4_mul(m->columns[2], plii_lanes_all_z(v)));
}

typedef struct plii_lanes_bounds {
    plii_float4 low, high;
} plii_lanes_bounds;

/* One axis: rows times its range, 0 where they do not see the axis, whose infinity must not come in. */
PLII_SIMD_INLINE plii_lanes_bounds plii_lanes_bounds_add_axis(plii_lanes_bounds sum, plii_float4 weights, float min,
                                                              float max) {
    const plii_float4 zero = plii_float4_all(0.0f);
    const plii_float4 at_min = plii_float4_mul(weights, plii_float4_all(min));
    const plii_float4 at_max = plii_float4_mul(weights, plii_float4_all(max));
    const plii_mask4 is_blind = plii_lanes_both(plii_lanes_at_most(weights, zero), plii_lanes_at_most(zero, weights));
    const plii_mask4 is_positive = plii_lanes_less(zero, weights);
    const plii_float4 least = plii_lanes_select(is_positive, at_min, at_max);
    const plii_float4 most = plii_lanes_select(is_positive, at_max, at_min);
    return (plii_lanes_bounds){plii_float4_add(sum.low, plii_lanes_select(is_blind, zero, least)),
                               plii_float4_add(sum.high, plii_lanes_select(is_blind, zero, most))};
}

/* plii_bounds_transform */
PLII_SIMD_INLINE plii_lanes_bounds plii_lanes_bounds_transform(const pli_bounds* local, const plii_lanes_mat3* rotation,
                                                               plii_float4 origin) {
    plii_lanes_bounds sum = {origin, origin};
    sum = plii_lanes_bounds_add_axis(sum, rotation->columns[0], local->min.x, local->max.x);
    sum = plii_lanes_bounds_add_axis(sum, rotation->columns[1], local->min.y, local->max.y);
    sum = plii_lanes_bounds_add_axis(sum, rotation->columns[2], local->min.z, local->max.z);
    /* Where infinities met there is no number. */
    const plii_float4 least = plii_float4_all(-INFINITY), most = plii_float4_all(INFINITY);
    return (plii_lanes_bounds){plii_lanes_select(plii_lanes_at_most(sum.low, sum.low), sum.low, least),
                               plii_lanes_select(plii_lanes_at_most(sum.high, sum.high), sum.high, most)};
}

/* Vectors of four nodes by components. */
typedef struct plii_vec3x4 {
    plii_float4 x, y, z;
} plii_vec3x4;

PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_add(plii_vec3x4 a, plii_vec3x4 b) {
    return (plii_vec3x4){plii_float4_add(a.x, b.x), plii_float4_add(a.y, b.y), plii_float4_add(a.z, b.z)};
}
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_sub(plii_vec3x4 a, plii_vec3x4 b) {
    return (plii_vec3x4){plii_float4_sub(a.x, b.x), plii_float4_sub(a.y, b.y), plii_float4_sub(a.z, b.z)};
}
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_scale(plii_vec3x4 a, plii_float4 s) {
    return (plii_vec3x4){plii_float4_mul(a.x, s), plii_float4_mul(a.y, s), plii_float4_mul(a.z, s)};
}
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_neg(plii_vec3x4 a) {
    return (plii_vec3x4){plii_float4_negate(a.x), plii_float4_negate(a.y), plii_float4_negate(a.z)};
}
PLII_SIMD_INLINE plii_float4 plii_vec3x4_dot(plii_vec3x4 a, plii_vec3x4 b) {
    return plii_float4_add(plii_float4_add(plii_float4_mul(a.x, b.x), plii_float4_mul(a.y, b.y)),
                           plii_float4_mul(a.z, b.z));
}
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_cross(plii_vec3x4 a, plii_vec3x4 b) {
    return (plii_vec3x4){plii_float4_sub(plii_float4_mul(a.y, b.z), plii_float4_mul(a.z, b.y)),
                         plii_float4_sub(plii_float4_mul(a.z, b.x), plii_float4_mul(a.x, b.z)),
                         plii_float4_sub(plii_float4_mul(a.x, b.y), plii_float4_mul(a.y, b.x))};
}
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_select(plii_mask4 mask, plii_vec3x4 yes, plii_vec3x4 no) {
    return (plii_vec3x4){plii_lanes_select(mask, yes.x, no.x), plii_lanes_select(mask, yes.y, no.y),
                         plii_lanes_select(mask, yes.z, no.z)};
}
/* The same vector four times, and the first of four. */
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_all(pli_vec3 a) {
    return (plii_vec3x4){plii_float4_all(a.x), plii_float4_all(a.y), plii_float4_all(a.z)};
}
PLII_SIMD_INLINE pli_vec3 plii_vec3x4_first(plii_vec3x4 a) {
    return pli_vec3_make(plii_lanes_first(a.x), plii_lanes_first(a.y), plii_lanes_first(a.z));
}
/* Of four records; their w goes to `w`, which may be NULL. */
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_from_records(const pli_vec4* records, plii_float4* w) {
    plii_float4 rows[4] = {plii_float4_from(&records[0]), plii_float4_from(&records[1]), plii_float4_from(&records[2]),
                           plii_float4_from(&records[3])};
    plii_float4_turn(rows);
    if (w != NULL) { *w = rows[3]; }
    return (plii_vec3x4){rows[0], rows[1], rows[2]};
}
/* Of four vectors one after the other. */
#if defined(PLII_SIMD_SSE2)
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_from(const pli_vec3* vectors) {
    const float* source = (const float*)vectors;
    const __m128 a = _mm_loadu_ps(source), b = _mm_loadu_ps(source + 4), c = _mm_loadu_ps(source + 8);
    const __m128 yz = _mm_shuffle_ps(a, b, _MM_SHUFFLE(1, 0, 2, 1)); /* of the first two */
    const __m128 xy = _mm_shuffle_ps(b, c, _MM_SHUFFLE(2, 1, 3, 2)); /* of the last two */
    return (plii_vec3x4){_mm_shuffle_ps(a, xy, _MM_SHUFFLE(2, 0, 3, 0)),
                         _mm_shuffle_ps(yz, xy, _MM_SHUFFLE(3, 1, 2, 0)),
                         _mm_shuffle_ps(yz, c, _MM_SHUFFLE(3, 0, 3, 1))};
}
PLII_SIMD_INLINE void plii_vec3x4_to(pli_vec3* vectors, plii_vec3x4 v) {
    float* target = (float*)vectors;
    const __m128 xy = _mm_shuffle_ps(v.x, v.y, _MM_SHUFFLE(2, 0, 2, 0)); /* of the vectors 0, 2 */
    const __m128 yz = _mm_shuffle_ps(v.y, v.z, _MM_SHUFFLE(3, 1, 3, 1)); /* 1, 3 */
    const __m128 zx = _mm_shuffle_ps(v.z, v.x, _MM_SHUFFLE(3, 1, 2, 0)); /* z of 0, 2, x of 1, 3 */
    _mm_storeu_ps(target, _mm_shuffle_ps(xy, zx, _MM_SHUFFLE(2, 0, 2, 0)));
    _mm_storeu_ps(target + 4, _mm_shuffle_ps(yz, xy, _MM_SHUFFLE(3, 1, 2, 0)));
    _mm_storeu_ps(target + 8, _mm_shuffle_ps(zx, yz, _MM_SHUFFLE(3, 1, 3, 1)));
}
#elif defined(PLII_SIMD_NEON)
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_from(const pli_vec3* vectors) {
    const float32x4x3_t v = vld3q_f32((const float*)vectors);
    return (plii_vec3x4){v.val[0], v.val[1], v.val[2]};
}
PLII_SIMD_INLINE void plii_vec3x4_to(pli_vec3* vectors, plii_vec3x4 v) {
    const float32x4x3_t three = {{v.x, v.y, v.z}};
    vst3q_f32((float*)vectors, three);
}
#else
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_from(const pli_vec3* v) {
    return (plii_vec3x4){
        {{v[0].x, v[1].x, v[2].x, v[3].x}}, {{v[0].y, v[1].y, v[2].y, v[3].y}}, {{v[0].z, v[1].z, v[2].z, v[3].z}}};
}
PLII_SIMD_INLINE void plii_vec3x4_to(pli_vec3* vectors, plii_vec3x4 v) {
    for (int k = 0; k < 4; ++k) {
        vectors[k] = pli_vec3_make(v.x.lanes[k], v.y.lanes[k], v.z.lanes[k]);
    }
}
#endif

#endif
