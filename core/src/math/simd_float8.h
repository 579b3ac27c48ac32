#pragma once

/* Eight floats at a time: one register where the compiler has AVX2, else two of simd_float4.h, with the same results.
   What is worth it is compiled for both, by a second source file that includes the first, and chosen at run time. */

#include "math/simd_float4.h"

#ifndef PLII_KERNEL_NAME
#define PLII_KERNEL_NAME(name) name##_base
#endif

#if defined(__AVX2__)
#include <immintrin.h>

enum { PLII_FLOAT8_IS_ONE = 1 }; /* register */

typedef float plii_float8 __attribute__((vector_size(32)));
#define PLII_FLOAT8(of_eight, of_low, of_high) (of_eight)

PLII_SIMD_INLINE plii_float4 plii_float8_low(plii_float8 a) {
    return _mm256_castps256_ps128(a);
}
PLII_SIMD_INLINE plii_float4 plii_float8_high(plii_float8 a) {
    return _mm256_extractf128_ps(a, 1);
}
PLII_SIMD_INLINE void plii_float8_store(float* target, plii_float8 a) {
    _mm256_storeu_ps(target, a);
}
/* Bit k where a < b in lane k. */
PLII_SIMD_INLINE int plii_float8_less_bits(plii_float8 a, plii_float8 b) {
    return _mm256_movemask_ps((plii_float8)(a < b));
}
/* plii_float4_transpose of all halves or quarters. */
#define PLII_TRANSPOSE4(type, prefix)                                                                                  \
    const type xy01 = prefix##_unpacklo_ps(r[0], r[1]), zw01 = prefix##_unpackhi_ps(r[0], r[1]);                       \
    const type xy23 = prefix##_unpacklo_ps(r[2], r[3]), zw23 = prefix##_unpackhi_ps(r[2], r[3]);                       \
    r[0] = prefix##_shuffle_ps(xy01, xy23, 0x44);                                                                      \
    r[1] = prefix##_shuffle_ps(xy01, xy23, 0xee);                                                                      \
    r[2] = prefix##_shuffle_ps(zw01, zw23, 0x44);                                                                      \
    r[3] = prefix##_shuffle_ps(zw01, zw23, 0xee);
PLII_SIMD_INLINE void plii_float8_transpose4(plii_float8 r[4]) {
    PLII_TRANSPOSE4(plii_float8, _mm256)
}

#else

enum { PLII_FLOAT8_IS_ONE = 0 };

typedef struct plii_float8 {
    plii_float4 low, high;
} plii_float8;
#define PLII_FLOAT8(of_eight, of_low, of_high) ((plii_float8){of_low, of_high})

PLII_SIMD_INLINE plii_float4 plii_float8_low(plii_float8 a) {
    return a.low;
}
PLII_SIMD_INLINE plii_float4 plii_float8_high(plii_float8 a) {
    return a.high;
}
PLII_SIMD_INLINE void plii_float8_store(float* target, plii_float8 a) {
    plii_float4_store(target, a.low);
    plii_float4_store(target + PLII_LANES, a.high);
}
PLII_SIMD_INLINE int plii_float8_less_bits(plii_float8 a, plii_float8 b) {
    return plii_lanes_bits(a.low < b.low) | plii_lanes_bits(a.high < b.high) << PLII_LANES;
}
PLII_SIMD_INLINE void plii_float8_transpose4(plii_float8 r[4]) {
    plii_float4 low[4] = {r[0].low, r[1].low, r[2].low, r[3].low};
    plii_float4 high[4] = {r[0].high, r[1].high, r[2].high, r[3].high};
    plii_float4_transpose(low);
    plii_float4_transpose(high);
    r[0] = (plii_float8){low[0], high[0]};
    r[1] = (plii_float8){low[1], high[1]};
    r[2] = (plii_float8){low[2], high[2]};
    r[3] = (plii_float8){low[3], high[3]};
}

#endif

/* Each by one register, or by both halves: PLII_FLOAT8 takes one and leaves the others out. */
PLII_SIMD_INLINE plii_float8 plii_float8_of(plii_float4 low, plii_float4 high) {
    return PLII_FLOAT8(_mm256_insertf128_ps(_mm256_castps128_ps256(low), high, 1), low, high);
}
PLII_SIMD_INLINE plii_float8 plii_float8_all(float value) {
    return PLII_FLOAT8(_mm256_set1_ps(value), plii_float4_all(value), plii_float4_all(value));
}
PLII_SIMD_INLINE plii_float8 plii_float8_load(const float* source) {
    return PLII_FLOAT8(_mm256_loadu_ps(source), plii_float4_load(source), plii_float4_load(source + PLII_LANES));
}
/* `value` where a > b, else 0. */
PLII_SIMD_INLINE plii_float8 plii_float8_where_greater(plii_float8 a, plii_float8 b, plii_float8 value) {
    return PLII_FLOAT8(_mm256_and_ps((plii_float8)(a > b), value), plii_lanes_where(a.low > b.low, value.low),
                       plii_lanes_where(a.high > b.high, value.high));
}
/* a < b ? yes : no */
PLII_SIMD_INLINE plii_float8 plii_float8_select_less(plii_float8 a, plii_float8 b, plii_float8 yes, plii_float8 no) {
    return PLII_FLOAT8(_mm256_blendv_ps(no, yes, (plii_float8)(a < b)),
                       plii_lanes_select(a.low < b.low, yes.low, no.low),
                       plii_lanes_select(a.high < b.high, yes.high, no.high));
}
#define PLII_FLOAT8_BINARY(name, of_eight, of_low, of_high)                                                            \
    PLII_SIMD_INLINE plii_float8 plii_float8_##name(plii_float8 a, plii_float8 b) {                                    \
        return PLII_FLOAT8(of_eight, of_low, of_high);                                                                 \
    }
PLII_FLOAT8_BINARY(add, a + b, a.low + b.low, a.high + b.high)
PLII_FLOAT8_BINARY(sub, a - b, a.low - b.low, a.high - b.high)
PLII_FLOAT8_BINARY(mul, a* b, a.low* b.low, a.high* b.high)
PLII_FLOAT8_BINARY(div, a / b, a.low / b.low, a.high / b.high)
PLII_FLOAT8_BINARY(min, _mm256_min_ps(a, b), plii_lanes_min(a.low, b.low), plii_lanes_min(a.high, b.high))
PLII_FLOAT8_BINARY(max, _mm256_max_ps(a, b), plii_lanes_max(a.low, b.low), plii_lanes_max(a.high, b.high))
#define PLII_FLOAT8_UNARY(name, of_eight, of_four)                                                                     \
    PLII_SIMD_INLINE plii_float8 plii_float8_##name(plii_float8 a) {                                                   \
        return PLII_FLOAT8(of_eight, of_four(a.low), of_four(a.high));                                                 \
    }
PLII_FLOAT8_UNARY(sqrt, _mm256_sqrt_ps(a), plii_float4_sqrt)
/* Of two records: w, w, w, w, and x, y, z, 0. */
PLII_FLOAT8_UNARY(all_w, _mm256_shuffle_ps(a, a, 0xff), plii_lanes_all_w)
PLII_FLOAT8_UNARY(xyz, _mm256_blend_ps(a, _mm256_setzero_ps(), 0x88), plii_lanes_xyz)

/* Of what is called in many places: inline where vectors stay in registers, elsewhere it would only be large. */
#if defined(__AVX2__)
#define PLII_SIMD_LARGE PLII_SIMD_INLINE
#else
#define PLII_SIMD_LARGE static
#endif

/* Of eight records by components lane k < 4 has record 2 k, lane 4 + k record 2 k + 1: neighbours share a register. */
static inline int plii_simd_record(int lane) {
    return lane < 4 ? 2 * lane : 2 * lane - 7;
}
/* Twice an index: a processor that multiplies addresses by eight at most needs no shift for records then. */
static inline uint32_t plii_scaled_index(int index) {
    return 2u * (uint32_t)index;
}
PLII_SIMD_INLINE const pli_vec4* plii_simd_at(const pli_vec4* records, uint32_t scaled_index) {
    return (const pli_vec4*)(const void*)((const char*)records + 8 * (size_t)scaled_index);
}
PLII_SIMD_INLINE plii_float8 plii_simd_load_two(const pli_vec4* records, const uint32_t scaled_indices[2]) {
    return plii_float8_of(plii_float4_from(plii_simd_at(records, scaled_indices[0])),
                          plii_float4_from(plii_simd_at(records, scaled_indices[1])));
}
PLII_SIMD_INLINE void plii_simd_store_two(pli_vec4* records, const uint32_t scaled_indices[2], plii_float8 a) {
    plii_float4_to((pli_vec4*)plii_simd_at(records, scaled_indices[0]), plii_float8_low(a));
    plii_float4_to((pli_vec4*)plii_simd_at(records, scaled_indices[1]), plii_float8_high(a));
}

/* Two records, or the last one alone. */
PLII_SIMD_INLINE plii_float8 plii_float8_from(const pli_vec4* records, int first, bool are_two) {
    return are_two ? plii_float8_load(&records[first].x)
                   : plii_float8_of(plii_float4_from(&records[first]), plii_float4_all(0.0f));
}
PLII_SIMD_INLINE void plii_float8_to(pli_vec4* records, int first, bool are_two, plii_float8 a) {
    if (are_two) {
        plii_float8_store(&records[first].x, a);
    } else {
        plii_float4_to(&records[first], plii_float8_low(a));
    }
}

/* A range of records by name##_at, two at a time; the copy of the task is one that no store can change. */
#define PLII_RECORDS_RANGE(name, task_type)                                                                            \
    static void name(int begin, int end, void* data) {                                                                 \
        const task_type task = *(const task_type*)data;                                                                \
        int i = begin;                                                                                                 \
        for (; i + 1 < end; i += 2) {                                                                                  \
            name##_at(&task, i, true);                                                                                 \
        }                                                                                                              \
        if (i < end) { name##_at(&task, i, false); }                                                                   \
    }
