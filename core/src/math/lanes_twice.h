#ifndef PLII_LANES_TWICE_H
#define PLII_LANES_TWICE_H

/* Four floats of each of two kinds at a time: one register where there are eight lanes, else two of lanes.h, with the
   same results. Goes before other headers of the core. */

#include "math/lanes.h"

#if defined(__AVX2__)
#include <immintrin.h>

typedef __m256 plii_twice4;

PLII_SIMD_INLINE plii_twice4 plii_twice4_of(plii_float4 low, plii_float4 high) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(low), high, 1);
}
PLII_SIMD_INLINE plii_float4 plii_twice4_low(plii_twice4 a) {
    return _mm256_castps256_ps128(a);
}
PLII_SIMD_INLINE plii_float4 plii_twice4_high(plii_twice4 a) {
    return _mm256_extractf128_ps(a, 1);
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_load(const float* source) {
    return _mm256_loadu_ps(source);
}
PLII_SIMD_INLINE void plii_twice4_store(float* target, plii_twice4 a) {
    _mm256_storeu_ps(target, a);
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_add(plii_twice4 a, plii_twice4 b) {
    return _mm256_add_ps(a, b);
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_sub(plii_twice4 a, plii_twice4 b) {
    return _mm256_sub_ps(a, b);
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_mul(plii_twice4 a, plii_twice4 b) {
    return _mm256_mul_ps(a, b);
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_div(plii_twice4 a, plii_twice4 b) {
    return _mm256_div_ps(a, b);
}
/* plii_lanes_min and plii_lanes_max */
PLII_SIMD_INLINE plii_twice4 plii_twice4_min(plii_twice4 a, plii_twice4 b) {
    return _mm256_min_ps(a, b);
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_max(plii_twice4 a, plii_twice4 b) {
    return _mm256_max_ps(a, b);
}
/* a < b ? yes : no */
PLII_SIMD_INLINE plii_twice4 plii_twice4_select_less(plii_twice4 a, plii_twice4 b, plii_twice4 yes, plii_twice4 no) {
    return _mm256_blendv_ps(no, yes, _mm256_cmp_ps(a, b, _CMP_LT_OQ));
}
/* Bit k where a < b in lane k; those of `high` follow. */
PLII_SIMD_INLINE int plii_twice4_less_bits(plii_twice4 a, plii_twice4 b) {
    return _mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LT_OQ));
}
/* plii_float4_turn of both. */
PLII_SIMD_INLINE void plii_twice4_turn(plii_twice4 r[4]) {
    const __m256 xy01 = _mm256_unpacklo_ps(r[0], r[1]), zw01 = _mm256_unpackhi_ps(r[0], r[1]);
    const __m256 xy23 = _mm256_unpacklo_ps(r[2], r[3]), zw23 = _mm256_unpackhi_ps(r[2], r[3]);
    r[0] = _mm256_shuffle_ps(xy01, xy23, _MM_SHUFFLE(1, 0, 1, 0));
    r[1] = _mm256_shuffle_ps(xy01, xy23, _MM_SHUFFLE(3, 2, 3, 2));
    r[2] = _mm256_shuffle_ps(zw01, zw23, _MM_SHUFFLE(1, 0, 1, 0));
    r[3] = _mm256_shuffle_ps(zw01, zw23, _MM_SHUFFLE(3, 2, 3, 2));
}

#else

typedef struct plii_twice4 {
    plii_float4 low, high;
} plii_twice4;

PLII_SIMD_INLINE plii_twice4 plii_twice4_of(plii_float4 low, plii_float4 high) {
    return (plii_twice4){low, high};
}
PLII_SIMD_INLINE plii_float4 plii_twice4_low(plii_twice4 a) {
    return a.low;
}
PLII_SIMD_INLINE plii_float4 plii_twice4_high(plii_twice4 a) {
    return a.high;
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_load(const float* source) {
    return (plii_twice4){plii_float4_load(source), plii_float4_load(source + PLII_LANES)};
}
PLII_SIMD_INLINE void plii_twice4_store(float* target, plii_twice4 a) {
    plii_float4_store(target, a.low);
    plii_float4_store(target + PLII_LANES, a.high);
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_add(plii_twice4 a, plii_twice4 b) {
    return (plii_twice4){plii_float4_add(a.low, b.low), plii_float4_add(a.high, b.high)};
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_sub(plii_twice4 a, plii_twice4 b) {
    return (plii_twice4){plii_float4_sub(a.low, b.low), plii_float4_sub(a.high, b.high)};
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_mul(plii_twice4 a, plii_twice4 b) {
    return (plii_twice4){plii_float4_mul(a.low, b.low), plii_float4_mul(a.high, b.high)};
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_div(plii_twice4 a, plii_twice4 b) {
    return (plii_twice4){plii_float4_div(a.low, b.low), plii_float4_div(a.high, b.high)};
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_min(plii_twice4 a, plii_twice4 b) {
    return (plii_twice4){plii_lanes_min(a.low, b.low), plii_lanes_min(a.high, b.high)};
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_max(plii_twice4 a, plii_twice4 b) {
    return (plii_twice4){plii_lanes_max(a.low, b.low), plii_lanes_max(a.high, b.high)};
}
PLII_SIMD_INLINE plii_twice4 plii_twice4_select_less(plii_twice4 a, plii_twice4 b, plii_twice4 yes, plii_twice4 no) {
    return (plii_twice4){plii_lanes_select(plii_lanes_less(a.low, b.low), yes.low, no.low),
                         plii_lanes_select(plii_lanes_less(a.high, b.high), yes.high, no.high)};
}
PLII_SIMD_INLINE int plii_twice4_less_bits(plii_twice4 a, plii_twice4 b) {
    return plii_lanes_bits(plii_lanes_less(a.low, b.low)) | plii_lanes_bits(plii_lanes_less(a.high, b.high))
                                                                << PLII_LANES;
}
PLII_SIMD_INLINE void plii_twice4_turn(plii_twice4 r[4]) {
    plii_float4 low[4] = {r[0].low, r[1].low, r[2].low, r[3].low};
    plii_float4 high[4] = {r[0].high, r[1].high, r[2].high, r[3].high};
    plii_float4_turn(low);
    plii_float4_turn(high);
    for (int i = 0; i < 4; ++i) {
        r[i] = (plii_twice4){low[i], high[i]};
    }
}

#endif

PLII_SIMD_INLINE plii_twice4 plii_twice4_all(float value) {
    return plii_twice4_of(plii_float4_all(value), plii_float4_all(value));
}

/* Four vectors of each kind by components. */
typedef struct plii_twice3x4 {
    plii_twice4 x, y, z;
} plii_twice3x4;

PLII_SIMD_INLINE plii_twice3x4 plii_twice3x4_of(plii_vec3x4 low, plii_vec3x4 high) {
    return (plii_twice3x4){plii_twice4_of(low.x, high.x), plii_twice4_of(low.y, high.y), plii_twice4_of(low.z, high.z)};
}
PLII_SIMD_INLINE plii_vec3x4 plii_twice3x4_low(plii_twice3x4 a) {
    return (plii_vec3x4){plii_twice4_low(a.x), plii_twice4_low(a.y), plii_twice4_low(a.z)};
}
PLII_SIMD_INLINE plii_vec3x4 plii_twice3x4_high(plii_twice3x4 a) {
    return (plii_vec3x4){plii_twice4_high(a.x), plii_twice4_high(a.y), plii_twice4_high(a.z)};
}
PLII_SIMD_INLINE plii_twice3x4 plii_twice3x4_all(pli_vec3 a) {
    return (plii_twice3x4){plii_twice4_all(a.x), plii_twice4_all(a.y), plii_twice4_all(a.z)};
}
PLII_SIMD_INLINE plii_twice3x4 plii_twice3x4_add(plii_twice3x4 a, plii_twice3x4 b) {
    return (plii_twice3x4){plii_twice4_add(a.x, b.x), plii_twice4_add(a.y, b.y), plii_twice4_add(a.z, b.z)};
}
PLII_SIMD_INLINE plii_twice3x4 plii_twice3x4_sub(plii_twice3x4 a, plii_twice3x4 b) {
    return (plii_twice3x4){plii_twice4_sub(a.x, b.x), plii_twice4_sub(a.y, b.y), plii_twice4_sub(a.z, b.z)};
}
PLII_SIMD_INLINE plii_twice3x4 plii_twice3x4_mul(plii_twice3x4 a, plii_twice3x4 b) {
    return (plii_twice3x4){plii_twice4_mul(a.x, b.x), plii_twice4_mul(a.y, b.y), plii_twice4_mul(a.z, b.z)};
}
PLII_SIMD_INLINE plii_twice3x4 plii_twice3x4_scale(plii_twice3x4 a, plii_twice4 s) {
    return (plii_twice3x4){plii_twice4_mul(a.x, s), plii_twice4_mul(a.y, s), plii_twice4_mul(a.z, s)};
}
PLII_SIMD_INLINE plii_twice4 plii_twice3x4_dot(plii_twice3x4 a, plii_twice3x4 b) {
    return plii_twice4_add(plii_twice4_add(plii_twice4_mul(a.x, b.x), plii_twice4_mul(a.y, b.y)),
                           plii_twice4_mul(a.z, b.z));
}
PLII_SIMD_INLINE plii_twice3x4 plii_twice3x4_cross(plii_twice3x4 a, plii_twice3x4 b) {
    return (plii_twice3x4){plii_twice4_sub(plii_twice4_mul(a.y, b.z), plii_twice4_mul(a.z, b.y)),
                           plii_twice4_sub(plii_twice4_mul(a.z, b.x), plii_twice4_mul(a.x, b.z)),
                           plii_twice4_sub(plii_twice4_mul(a.x, b.y), plii_twice4_mul(a.y, b.x))};
}

#endif
