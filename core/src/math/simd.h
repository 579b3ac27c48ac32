#ifndef PLII_SIMD_H
#define PLII_SIMD_H

/* Eight floats at a time. Kernels are written once and compiled once per instruction set: a source file says which by
   defining one of PLII_SIMD_AVX2, PLII_SIMD_SSE2, PLII_SIMD_NEON, PLII_SIMD_PORTABLE before it includes this header,
   and the build gives it the flags; without any only the order of lanes is there. All operations are such that IEEE 754
   rounds correctly, so all paths give the same bits.

   Records of four floats are turned into one vector per component and back. Lane k < 4 then holds record 2 k, lane 4 +
   k record 2 k + 1: two neighbours in memory fill a 256-bit register. */

#include "math/vec.h"

#include <stddef.h>

enum { PLII_SIMD_LANES = 8 };

/* Vectors passed through memory would cost more than the arithmetic. With checks of each access inlined code grows so
   much that compilers need half a minute for a kernel; there speed does not matter. */
#if defined(__SANITIZE_ADDRESS__)
#define PLII_SIMD_IS_CHECKED 1
#elif defined(__has_feature)
#define PLII_SIMD_IS_CHECKED __has_feature(address_sanitizer)
#else
#define PLII_SIMD_IS_CHECKED 0
#endif
#if defined(__GNUC__) && !PLII_SIMD_IS_CHECKED
#define PLII_SIMD_INLINE static inline __attribute__((always_inline))
#else
#define PLII_SIMD_INLINE static inline
#endif

/* Of what is called in many places: inline where vectors stay in registers, elsewhere it would only be large. */
#if defined(PLII_SIMD_AVX2)
#define PLII_SIMD_LARGE PLII_SIMD_INLINE
#else
#define PLII_SIMD_LARGE static
#endif

/* The record in a lane. */
static inline int plii_simd_record(int lane) {
    return lane < 4 ? 2 * lane : 2 * lane - 7;
}

/* A record by its place, which is twice its index: a processor that multiplies addresses by eight at most needs no
   shift then. */
static inline uint32_t plii_simd_place(int index) {
    return 2u * (uint32_t)index;
}
static inline int plii_simd_index(uint32_t place) {
    return (int)(place / 2u);
}
PLII_SIMD_INLINE const pli_vec4* plii_simd_at(const pli_vec4* records, uint32_t place) {
    return (const pli_vec4*)(const void*)((const char*)records + 8 * (size_t)place);
}
PLII_SIMD_INLINE pli_vec4* plii_simd_at_mutable(pli_vec4* records, uint32_t place) {
    return (pli_vec4*)(void*)((char*)records + 8 * (size_t)place);
}

#if defined(PLII_SIMD_AVX2)
#include <immintrin.h>

enum { PLII_SIMD_RECORDS = 2 }; /* in a register */

typedef __m256 plii_float8;

PLII_SIMD_INLINE plii_float8 plii_float8_load(const float* source) {
    return _mm256_loadu_ps(source);
}
PLII_SIMD_INLINE void plii_float8_store(float* target, plii_float8 a) {
    _mm256_storeu_ps(target, a);
}
PLII_SIMD_INLINE plii_float8 plii_float8_all(float value) {
    return _mm256_set1_ps(value);
}
PLII_SIMD_INLINE plii_float8 plii_float8_add(plii_float8 a, plii_float8 b) {
    return _mm256_add_ps(a, b);
}
PLII_SIMD_INLINE plii_float8 plii_float8_sub(plii_float8 a, plii_float8 b) {
    return _mm256_sub_ps(a, b);
}
PLII_SIMD_INLINE plii_float8 plii_float8_mul(plii_float8 a, plii_float8 b) {
    return _mm256_mul_ps(a, b);
}
PLII_SIMD_INLINE plii_float8 plii_float8_div(plii_float8 a, plii_float8 b) {
    return _mm256_div_ps(a, b);
}
PLII_SIMD_INLINE plii_float8 plii_float8_sqrt(plii_float8 a) {
    return _mm256_sqrt_ps(a);
}
/* `value` where a > b, else 0. */
PLII_SIMD_INLINE plii_float8 plii_float8_where_greater(plii_float8 a, plii_float8 b, plii_float8 value) {
    return _mm256_and_ps(_mm256_cmp_ps(a, b, _CMP_GT_OQ), value);
}

typedef struct plii_records8 {
    plii_float8 x, y, z, w;
} plii_records8;

PLII_SIMD_INLINE plii_float8 plii_simd_pair(const pli_vec4* low, const pli_vec4* high) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(&low->x)), _mm_loadu_ps(&high->x), 1);
}
PLII_SIMD_INLINE void plii_simd_store_pair(pli_vec4* low, pli_vec4* high, plii_float8 a) {
    _mm_storeu_ps(&low->x, _mm256_castps256_ps128(a));
    _mm_storeu_ps(&high->x, _mm256_extractf128_ps(a, 1));
}

/* Eight records as they lie in memory, two in each register. */
typedef struct plii_packed8 {
    plii_float8 pairs[4];
} plii_packed8;

PLII_SIMD_INLINE plii_packed8 plii_packed8_gather(const pli_vec4* records, const uint32_t* places) {
    return (plii_packed8){{plii_simd_pair(plii_simd_at(records, places[0]), plii_simd_at(records, places[1])),
                           plii_simd_pair(plii_simd_at(records, places[2]), plii_simd_at(records, places[3])),
                           plii_simd_pair(plii_simd_at(records, places[4]), plii_simd_at(records, places[5])),
                           plii_simd_pair(plii_simd_at(records, places[6]), plii_simd_at(records, places[7]))}};
}
/* Records first, first + step, ... first + 7 step; the step is 1 or 2. */
PLII_SIMD_INLINE plii_packed8 plii_packed8_load(const pli_vec4* first, int step) {
    if (step == 2) {
        return (plii_packed8){{plii_simd_pair(first, first + 2), plii_simd_pair(first + 4, first + 6),
                               plii_simd_pair(first + 8, first + 10), plii_simd_pair(first + 12, first + 14)}};
    }
    return (plii_packed8){{_mm256_loadu_ps(&first[0].x), _mm256_loadu_ps(&first[2].x), _mm256_loadu_ps(&first[4].x),
                           _mm256_loadu_ps(&first[6].x)}};
}
PLII_SIMD_INLINE plii_packed8 plii_packed8_add(plii_packed8 a, plii_packed8 b) {
    return (plii_packed8){{_mm256_add_ps(a.pairs[0], b.pairs[0]), _mm256_add_ps(a.pairs[1], b.pairs[1]),
                           _mm256_add_ps(a.pairs[2], b.pairs[2]), _mm256_add_ps(a.pairs[3], b.pairs[3])}};
}
PLII_SIMD_INLINE plii_packed8 plii_packed8_sub(plii_packed8 a, plii_packed8 b) {
    return (plii_packed8){{_mm256_sub_ps(a.pairs[0], b.pairs[0]), _mm256_sub_ps(a.pairs[1], b.pairs[1]),
                           _mm256_sub_ps(a.pairs[2], b.pairs[2]), _mm256_sub_ps(a.pairs[3], b.pairs[3])}};
}

/* Four pairs of records to components, and the same way back. */
PLII_SIMD_INLINE plii_records8 plii_simd_turn(plii_float8 r0, plii_float8 r1, plii_float8 r2, plii_float8 r3) {
    const __m256 xy01 = _mm256_unpacklo_ps(r0, r1), zw01 = _mm256_unpackhi_ps(r0, r1);
    const __m256 xy23 = _mm256_unpacklo_ps(r2, r3), zw23 = _mm256_unpackhi_ps(r2, r3);
    return (plii_records8){_mm256_shuffle_ps(xy01, xy23, 0x44), _mm256_shuffle_ps(xy01, xy23, 0xee),
                           _mm256_shuffle_ps(zw01, zw23, 0x44), _mm256_shuffle_ps(zw01, zw23, 0xee)};
}
PLII_SIMD_INLINE plii_records8 plii_packed8_turn(plii_packed8 a) {
    return plii_simd_turn(a.pairs[0], a.pairs[1], a.pairs[2], a.pairs[3]);
}

PLII_SIMD_INLINE plii_packed8 plii_records8_turn(const plii_records8* a) {
    const __m256 xy02 = _mm256_unpacklo_ps(a->x, a->y), zw02 = _mm256_unpacklo_ps(a->z, a->w);
    const __m256 xy46 = _mm256_unpackhi_ps(a->x, a->y), zw46 = _mm256_unpackhi_ps(a->z, a->w);
    return (plii_packed8){{_mm256_shuffle_ps(xy02, zw02, 0x44), _mm256_shuffle_ps(xy02, zw02, 0xee),
                           _mm256_shuffle_ps(xy46, zw46, 0x44), _mm256_shuffle_ps(xy46, zw46, 0xee)}};
}

/* Of two sets of which one record and one, or two and two (`width`), take turns in memory: a0, b0, a1, b1, ... */
PLII_SIMD_INLINE void plii_packed8_load_turns(const pli_vec4* first, int width, plii_packed8* a, plii_packed8* b) {
    const __m256 r0 = _mm256_loadu_ps(&first[0].x), r1 = _mm256_loadu_ps(&first[2].x);
    const __m256 r2 = _mm256_loadu_ps(&first[4].x), r3 = _mm256_loadu_ps(&first[6].x);
    const __m256 r4 = _mm256_loadu_ps(&first[8].x), r5 = _mm256_loadu_ps(&first[10].x);
    const __m256 r6 = _mm256_loadu_ps(&first[12].x), r7 = _mm256_loadu_ps(&first[14].x);
    if (width == 2) {
        *a = (plii_packed8){{r0, r2, r4, r6}};
        *b = (plii_packed8){{r1, r3, r5, r7}};
        return;
    }
    *a = (plii_packed8){{_mm256_permute2f128_ps(r0, r1, 0x20), _mm256_permute2f128_ps(r2, r3, 0x20),
                         _mm256_permute2f128_ps(r4, r5, 0x20), _mm256_permute2f128_ps(r6, r7, 0x20)}};
    *b = (plii_packed8){{_mm256_permute2f128_ps(r0, r1, 0x31), _mm256_permute2f128_ps(r2, r3, 0x31),
                         _mm256_permute2f128_ps(r4, r5, 0x31), _mm256_permute2f128_ps(r6, r7, 0x31)}};
}

/* x, y, z of each record times the number in its lane, w 0. */
PLII_SIMD_INLINE plii_packed8 plii_packed8_scale_xyz(plii_packed8 a, plii_float8 factors) {
    const __m256 zero = _mm256_setzero_ps();
    return (plii_packed8){{_mm256_blend_ps(_mm256_mul_ps(a.pairs[0], _mm256_permute_ps(factors, 0x00)), zero, 0x88),
                           _mm256_blend_ps(_mm256_mul_ps(a.pairs[1], _mm256_permute_ps(factors, 0x55)), zero, 0x88),
                           _mm256_blend_ps(_mm256_mul_ps(a.pairs[2], _mm256_permute_ps(factors, 0xaa)), zero, 0x88),
                           _mm256_blend_ps(_mm256_mul_ps(a.pairs[3], _mm256_permute_ps(factors, 0xff)), zero, 0x88)}};
}
/* Those added or taken away, for records that are in registers. */
PLII_SIMD_INLINE plii_packed8 plii_packed8_add_scaled(plii_packed8 a, plii_packed8 b, plii_float8 factors) {
    const __m256 s0 = _mm256_mul_ps(b.pairs[0], _mm256_permute_ps(factors, 0x00));
    const __m256 s1 = _mm256_mul_ps(b.pairs[1], _mm256_permute_ps(factors, 0x55));
    const __m256 s2 = _mm256_mul_ps(b.pairs[2], _mm256_permute_ps(factors, 0xaa));
    const __m256 s3 = _mm256_mul_ps(b.pairs[3], _mm256_permute_ps(factors, 0xff));
    return (plii_packed8){{_mm256_blend_ps(_mm256_add_ps(a.pairs[0], s0), a.pairs[0], 0x88),
                           _mm256_blend_ps(_mm256_add_ps(a.pairs[1], s1), a.pairs[1], 0x88),
                           _mm256_blend_ps(_mm256_add_ps(a.pairs[2], s2), a.pairs[2], 0x88),
                           _mm256_blend_ps(_mm256_add_ps(a.pairs[3], s3), a.pairs[3], 0x88)}};
}
PLII_SIMD_INLINE plii_packed8 plii_packed8_sub_scaled(plii_packed8 a, plii_packed8 b, plii_float8 factors) {
    const __m256 s0 = _mm256_mul_ps(b.pairs[0], _mm256_permute_ps(factors, 0x00));
    const __m256 s1 = _mm256_mul_ps(b.pairs[1], _mm256_permute_ps(factors, 0x55));
    const __m256 s2 = _mm256_mul_ps(b.pairs[2], _mm256_permute_ps(factors, 0xaa));
    const __m256 s3 = _mm256_mul_ps(b.pairs[3], _mm256_permute_ps(factors, 0xff));
    return (plii_packed8){{_mm256_blend_ps(_mm256_sub_ps(a.pairs[0], s0), a.pairs[0], 0x88),
                           _mm256_blend_ps(_mm256_sub_ps(a.pairs[1], s1), a.pairs[1], 0x88),
                           _mm256_blend_ps(_mm256_sub_ps(a.pairs[2], s2), a.pairs[2], 0x88),
                           _mm256_blend_ps(_mm256_sub_ps(a.pairs[3], s3), a.pairs[3], 0x88)}};
}
PLII_SIMD_INLINE void plii_packed8_store(pli_vec4* first, int step, plii_packed8 a) {
    if (step == 2) {
        plii_simd_store_pair(first, first + 2, a.pairs[0]);
        plii_simd_store_pair(first + 4, first + 6, a.pairs[1]);
        plii_simd_store_pair(first + 8, first + 10, a.pairs[2]);
        plii_simd_store_pair(first + 12, first + 14, a.pairs[3]);
        return;
    }
    _mm256_storeu_ps(&first[0].x, a.pairs[0]);
    _mm256_storeu_ps(&first[2].x, a.pairs[1]);
    _mm256_storeu_ps(&first[4].x, a.pairs[2]);
    _mm256_storeu_ps(&first[6].x, a.pairs[3]);
}
PLII_SIMD_INLINE void plii_simd_store_turns(pli_vec4* first, int width, plii_float8 a, plii_float8 b) {
    _mm256_storeu_ps(&first[0].x, width == 2 ? a : _mm256_permute2f128_ps(a, b, 0x20));
    _mm256_storeu_ps(&first[2].x, width == 2 ? b : _mm256_permute2f128_ps(a, b, 0x31));
}
PLII_SIMD_INLINE void plii_packed8_store_turns(pli_vec4* first, int width, plii_packed8 a, plii_packed8 b) {
    plii_simd_store_turns(first, width, a.pairs[0], b.pairs[0]);
    plii_simd_store_turns(first + 4, width, a.pairs[1], b.pairs[1]);
    plii_simd_store_turns(first + 8, width, a.pairs[2], b.pairs[2]);
    plii_simd_store_turns(first + 12, width, a.pairs[3], b.pairs[3]);
}
/* In the order of the records: of two at the same place the later one stays. */
PLII_SIMD_INLINE void plii_packed8_scatter(pli_vec4* records, const uint32_t* places, plii_packed8 a) {
    plii_simd_store_pair(plii_simd_at_mutable(records, places[0]), plii_simd_at_mutable(records, places[1]),
                         a.pairs[0]);
    plii_simd_store_pair(plii_simd_at_mutable(records, places[2]), plii_simd_at_mutable(records, places[3]),
                         a.pairs[1]);
    plii_simd_store_pair(plii_simd_at_mutable(records, places[4]), plii_simd_at_mutable(records, places[5]),
                         a.pairs[2]);
    plii_simd_store_pair(plii_simd_at_mutable(records, places[6]), plii_simd_at_mutable(records, places[7]),
                         a.pairs[3]);
}

PLII_SIMD_INLINE plii_float8 plii_float8_load_halves(const float* low, const float* high) {
    return _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(low)), _mm_loadu_ps(high), 1);
}
PLII_SIMD_INLINE void plii_float8_store_halves(float* low, float* high, plii_float8 a) {
    _mm_storeu_ps(low, _mm256_castps256_ps128(a));
    _mm_storeu_ps(high, _mm256_extractf128_ps(a, 1));
}
/* Numbers that take turns in two rows of eight; lanes 0, 1, 4 and 5 are those of the first row. */
PLII_SIMD_INLINE void plii_float8_load_turns(const float* first, const float* second, plii_float8* a, plii_float8* b) {
    const __m256 low = _mm256_loadu_ps(first), high = _mm256_loadu_ps(second);
    *a = _mm256_shuffle_ps(low, high, 0x88);
    *b = _mm256_shuffle_ps(low, high, 0xdd);
}
PLII_SIMD_INLINE void plii_float8_store_turns(float* first, float* second, plii_float8 a, plii_float8 b) {
    _mm256_storeu_ps(first, _mm256_unpacklo_ps(a, b));
    _mm256_storeu_ps(second, _mm256_unpackhi_ps(a, b));
}
/* From the order of records to that of memory. */
PLII_SIMD_INLINE plii_float8 plii_float8_load_slots(const float* slots) {
    return _mm256_permutevar8x32_ps(_mm256_loadu_ps(slots), _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7));
}
/* From the order of records, of which even ones are the first of two rows, to that of numbers that take turns. */
PLII_SIMD_INLINE plii_float8 plii_float8_load_turned_slots(const float* slots) {
    return _mm256_permutevar8x32_ps(_mm256_loadu_ps(slots), _mm256_setr_epi32(0, 1, 4, 5, 2, 3, 6, 7));
}

#elif defined(PLII_SIMD_SSE2) || defined(PLII_SIMD_NEON) || defined(PLII_SIMD_PORTABLE)

/* Two registers of four, or eight plain floats. */

enum { PLII_SIMD_RECORDS = 1 };

#if defined(PLII_SIMD_SSE2)
#include <emmintrin.h>

typedef __m128 plii_float4;

PLII_SIMD_INLINE plii_float4 plii_float4_load(const float* source) {
    return _mm_loadu_ps(source);
}
PLII_SIMD_INLINE void plii_float4_store(float* target, plii_float4 a) {
    _mm_storeu_ps(target, a);
}
PLII_SIMD_INLINE plii_float4 plii_float4_from(const pli_vec4* record) {
    return _mm_loadu_ps(&record->x);
}
PLII_SIMD_INLINE void plii_float4_to(pli_vec4* record, plii_float4 a) {
    _mm_storeu_ps(&record->x, a);
}
PLII_SIMD_INLINE plii_float4 plii_float4_all(float value) {
    return _mm_set1_ps(value);
}
PLII_SIMD_INLINE plii_float4 plii_float4_add(plii_float4 a, plii_float4 b) {
    return _mm_add_ps(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_sub(plii_float4 a, plii_float4 b) {
    return _mm_sub_ps(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_mul(plii_float4 a, plii_float4 b) {
    return _mm_mul_ps(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_div(plii_float4 a, plii_float4 b) {
    return _mm_div_ps(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_sqrt(plii_float4 a) {
    return _mm_sqrt_ps(a);
}
PLII_SIMD_INLINE plii_float4 plii_float4_negate(plii_float4 a) {
    return _mm_xor_ps(a, _mm_set1_ps(-0.0f));
}
PLII_SIMD_INLINE plii_float4 plii_float4_where_greater(plii_float4 a, plii_float4 b, plii_float4 value) {
    return _mm_and_ps(_mm_cmpgt_ps(a, b), value);
}
/* a0, b0, a1, b1 and a2, b2, a3, b3; and the even and the odd ones of eight. */
PLII_SIMD_INLINE plii_float4 plii_float4_zip_low(plii_float4 a, plii_float4 b) {
    return _mm_unpacklo_ps(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_zip_high(plii_float4 a, plii_float4 b) {
    return _mm_unpackhi_ps(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_even(plii_float4 a, plii_float4 b) {
    return _mm_shuffle_ps(a, b, 0x88);
}
PLII_SIMD_INLINE plii_float4 plii_float4_odd(plii_float4 a, plii_float4 b) {
    return _mm_shuffle_ps(a, b, 0xdd);
}
/* The first two of both; the last two. */
PLII_SIMD_INLINE void plii_float4_turn(plii_float4 r[4]) {
    _MM_TRANSPOSE4_PS(r[0], r[1], r[2], r[3]);
}
/* x, y, z of each record times the number in its lane, w 0. */
PLII_SIMD_INLINE void plii_float4_scale_xyz(plii_float4 r[4], plii_float4 factors) {
    const __m128 xyz = _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1));
    r[0] = _mm_and_ps(_mm_mul_ps(r[0], _mm_shuffle_ps(factors, factors, 0x00)), xyz);
    r[1] = _mm_and_ps(_mm_mul_ps(r[1], _mm_shuffle_ps(factors, factors, 0x55)), xyz);
    r[2] = _mm_and_ps(_mm_mul_ps(r[2], _mm_shuffle_ps(factors, factors, 0xaa)), xyz);
    r[3] = _mm_and_ps(_mm_mul_ps(r[3], _mm_shuffle_ps(factors, factors, 0xff)), xyz);
}

#elif defined(PLII_SIMD_NEON)
#include <arm_neon.h>

typedef float32x4_t plii_float4;

PLII_SIMD_INLINE plii_float4 plii_float4_load(const float* source) {
    return vld1q_f32(source);
}
PLII_SIMD_INLINE void plii_float4_store(float* target, plii_float4 a) {
    vst1q_f32(target, a);
}
PLII_SIMD_INLINE plii_float4 plii_float4_from(const pli_vec4* record) {
    return vld1q_f32(&record->x);
}
PLII_SIMD_INLINE void plii_float4_to(pli_vec4* record, plii_float4 a) {
    vst1q_f32(&record->x, a);
}
PLII_SIMD_INLINE plii_float4 plii_float4_all(float value) {
    return vdupq_n_f32(value);
}
PLII_SIMD_INLINE plii_float4 plii_float4_add(plii_float4 a, plii_float4 b) {
    return vaddq_f32(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_sub(plii_float4 a, plii_float4 b) {
    return vsubq_f32(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_mul(plii_float4 a, plii_float4 b) {
    return vmulq_f32(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_div(plii_float4 a, plii_float4 b) {
    return vdivq_f32(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_sqrt(plii_float4 a) {
    return vsqrtq_f32(a);
}
PLII_SIMD_INLINE plii_float4 plii_float4_negate(plii_float4 a) {
    return vnegq_f32(a);
}
PLII_SIMD_INLINE plii_float4 plii_float4_where_greater(plii_float4 a, plii_float4 b, plii_float4 value) {
    return vreinterpretq_f32_u32(vandq_u32(vcgtq_f32(a, b), vreinterpretq_u32_f32(value)));
}
PLII_SIMD_INLINE plii_float4 plii_float4_zip_low(plii_float4 a, plii_float4 b) {
    return vzip1q_f32(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_zip_high(plii_float4 a, plii_float4 b) {
    return vzip2q_f32(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_even(plii_float4 a, plii_float4 b) {
    return vuzp1q_f32(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_float4_odd(plii_float4 a, plii_float4 b) {
    return vuzp2q_f32(a, b);
}
PLII_SIMD_INLINE void plii_float4_turn(plii_float4 r[4]) {
    const float32x4x2_t xz02 = vzipq_f32(r[0], r[2]), xz13 = vzipq_f32(r[1], r[3]);
    const float32x4x2_t xy = vzipq_f32(xz02.val[0], xz13.val[0]), zw = vzipq_f32(xz02.val[1], xz13.val[1]);
    r[0] = xy.val[0];
    r[1] = xy.val[1];
    r[2] = zw.val[0];
    r[3] = zw.val[1];
}
PLII_SIMD_INLINE void plii_float4_scale_xyz(plii_float4 r[4], plii_float4 factors) {
    r[0] = vsetq_lane_f32(0.0f, vmulq_laneq_f32(r[0], factors, 0), 3);
    r[1] = vsetq_lane_f32(0.0f, vmulq_laneq_f32(r[1], factors, 1), 3);
    r[2] = vsetq_lane_f32(0.0f, vmulq_laneq_f32(r[2], factors, 2), 3);
    r[3] = vsetq_lane_f32(0.0f, vmulq_laneq_f32(r[3], factors, 3), 3);
}

#else

typedef struct plii_float4 {
    float lanes[4];
} plii_float4;

PLII_SIMD_INLINE plii_float4 plii_float4_load(const float* source) {
    return (plii_float4){{source[0], source[1], source[2], source[3]}};
}
PLII_SIMD_INLINE void plii_float4_store(float* target, plii_float4 a) {
    for (int k = 0; k < 4; ++k) {
        target[k] = a.lanes[k];
    }
}
PLII_SIMD_INLINE plii_float4 plii_float4_from(const pli_vec4* record) {
    return (plii_float4){{record->x, record->y, record->z, record->w}};
}
PLII_SIMD_INLINE void plii_float4_to(pli_vec4* record, plii_float4 a) {
    *record = (pli_vec4){a.lanes[0], a.lanes[1], a.lanes[2], a.lanes[3]};
}
PLII_SIMD_INLINE plii_float4 plii_float4_all(float value) {
    return (plii_float4){{value, value, value, value}};
}
PLII_SIMD_INLINE plii_float4 plii_float4_add(plii_float4 a, plii_float4 b) {
    return (plii_float4){
        {a.lanes[0] + b.lanes[0], a.lanes[1] + b.lanes[1], a.lanes[2] + b.lanes[2], a.lanes[3] + b.lanes[3]}};
}
PLII_SIMD_INLINE plii_float4 plii_float4_sub(plii_float4 a, plii_float4 b) {
    return (plii_float4){
        {a.lanes[0] - b.lanes[0], a.lanes[1] - b.lanes[1], a.lanes[2] - b.lanes[2], a.lanes[3] - b.lanes[3]}};
}
PLII_SIMD_INLINE plii_float4 plii_float4_mul(plii_float4 a, plii_float4 b) {
    return (plii_float4){
        {a.lanes[0] * b.lanes[0], a.lanes[1] * b.lanes[1], a.lanes[2] * b.lanes[2], a.lanes[3] * b.lanes[3]}};
}
PLII_SIMD_INLINE plii_float4 plii_float4_div(plii_float4 a, plii_float4 b) {
    return (plii_float4){
        {a.lanes[0] / b.lanes[0], a.lanes[1] / b.lanes[1], a.lanes[2] / b.lanes[2], a.lanes[3] / b.lanes[3]}};
}
PLII_SIMD_INLINE plii_float4 plii_float4_sqrt(plii_float4 a) {
    for (int k = 0; k < 4; ++k) {
        a.lanes[k] = sqrtf(a.lanes[k]);
    }
    return a;
}
PLII_SIMD_INLINE plii_float4 plii_float4_negate(plii_float4 a) {
    for (int k = 0; k < 4; ++k) {
        a.lanes[k] = -a.lanes[k];
    }
    return a;
}
PLII_SIMD_INLINE plii_float4 plii_float4_where_greater(plii_float4 a, plii_float4 b, plii_float4 value) {
    for (int k = 0; k < 4; ++k) {
        value.lanes[k] = a.lanes[k] > b.lanes[k] ? value.lanes[k] : 0.0f;
    }
    return value;
}
PLII_SIMD_INLINE plii_float4 plii_float4_zip_low(plii_float4 a, plii_float4 b) {
    return (plii_float4){{a.lanes[0], b.lanes[0], a.lanes[1], b.lanes[1]}};
}
PLII_SIMD_INLINE plii_float4 plii_float4_zip_high(plii_float4 a, plii_float4 b) {
    return (plii_float4){{a.lanes[2], b.lanes[2], a.lanes[3], b.lanes[3]}};
}
PLII_SIMD_INLINE plii_float4 plii_float4_even(plii_float4 a, plii_float4 b) {
    return (plii_float4){{a.lanes[0], a.lanes[2], b.lanes[0], b.lanes[2]}};
}
PLII_SIMD_INLINE plii_float4 plii_float4_odd(plii_float4 a, plii_float4 b) {
    return (plii_float4){{a.lanes[1], a.lanes[3], b.lanes[1], b.lanes[3]}};
}
PLII_SIMD_INLINE void plii_float4_turn(plii_float4 r[4]) {
    const plii_float4 a = r[0], b = r[1], c = r[2], d = r[3];
    r[0] = (plii_float4){{a.lanes[0], b.lanes[0], c.lanes[0], d.lanes[0]}};
    r[1] = (plii_float4){{a.lanes[1], b.lanes[1], c.lanes[1], d.lanes[1]}};
    r[2] = (plii_float4){{a.lanes[2], b.lanes[2], c.lanes[2], d.lanes[2]}};
    r[3] = (plii_float4){{a.lanes[3], b.lanes[3], c.lanes[3], d.lanes[3]}};
}
PLII_SIMD_INLINE void plii_float4_scale_xyz(plii_float4 r[4], plii_float4 factors) {
    for (int k = 0; k < 4; ++k) {
        const float factor = factors.lanes[k];
        r[k] = (plii_float4){{r[k].lanes[0] * factor, r[k].lanes[1] * factor, r[k].lanes[2] * factor, 0.0f}};
    }
}

#endif

typedef struct plii_float8 {
    plii_float4 low, high;
} plii_float8;

PLII_SIMD_INLINE plii_float8 plii_float8_load(const float* source) {
    return (plii_float8){plii_float4_load(source), plii_float4_load(source + 4)};
}
PLII_SIMD_INLINE void plii_float8_store(float* target, plii_float8 a) {
    plii_float4_store(target, a.low);
    plii_float4_store(target + 4, a.high);
}
PLII_SIMD_INLINE plii_float8 plii_float8_all(float value) {
    return (plii_float8){plii_float4_all(value), plii_float4_all(value)};
}
PLII_SIMD_INLINE plii_float8 plii_float8_add(plii_float8 a, plii_float8 b) {
    return (plii_float8){plii_float4_add(a.low, b.low), plii_float4_add(a.high, b.high)};
}
PLII_SIMD_INLINE plii_float8 plii_float8_sub(plii_float8 a, plii_float8 b) {
    return (plii_float8){plii_float4_sub(a.low, b.low), plii_float4_sub(a.high, b.high)};
}
PLII_SIMD_INLINE plii_float8 plii_float8_mul(plii_float8 a, plii_float8 b) {
    return (plii_float8){plii_float4_mul(a.low, b.low), plii_float4_mul(a.high, b.high)};
}
PLII_SIMD_INLINE plii_float8 plii_float8_div(plii_float8 a, plii_float8 b) {
    return (plii_float8){plii_float4_div(a.low, b.low), plii_float4_div(a.high, b.high)};
}
PLII_SIMD_INLINE plii_float8 plii_float8_sqrt(plii_float8 a) {
    return (plii_float8){plii_float4_sqrt(a.low), plii_float4_sqrt(a.high)};
}
PLII_SIMD_INLINE plii_float8 plii_float8_where_greater(plii_float8 a, plii_float8 b, plii_float8 value) {
    return (plii_float8){plii_float4_where_greater(a.low, b.low, value.low),
                         plii_float4_where_greater(a.high, b.high, value.high)};
}

typedef struct plii_records8 {
    plii_float8 x, y, z, w;
} plii_records8;

typedef struct plii_packed8 {
    plii_float4 records[8];
} plii_packed8;

PLII_SIMD_INLINE plii_packed8 plii_packed8_gather(const pli_vec4* records, const uint32_t* places) {
    return (plii_packed8){
        {plii_float4_from(plii_simd_at(records, places[0])), plii_float4_from(plii_simd_at(records, places[1])),
         plii_float4_from(plii_simd_at(records, places[2])), plii_float4_from(plii_simd_at(records, places[3])),
         plii_float4_from(plii_simd_at(records, places[4])), plii_float4_from(plii_simd_at(records, places[5])),
         plii_float4_from(plii_simd_at(records, places[6])), plii_float4_from(plii_simd_at(records, places[7]))}};
}
PLII_SIMD_INLINE plii_packed8 plii_packed8_load(const pli_vec4* first, int step) {
    return (plii_packed8){{plii_float4_from(first), plii_float4_from(first + step), plii_float4_from(first + 2 * step),
                           plii_float4_from(first + 3 * step), plii_float4_from(first + 4 * step),
                           plii_float4_from(first + 5 * step), plii_float4_from(first + 6 * step),
                           plii_float4_from(first + 7 * step)}};
}
PLII_SIMD_INLINE plii_packed8 plii_packed8_add(plii_packed8 a, plii_packed8 b) {
    return (plii_packed8){{plii_float4_add(a.records[0], b.records[0]), plii_float4_add(a.records[1], b.records[1]),
                           plii_float4_add(a.records[2], b.records[2]), plii_float4_add(a.records[3], b.records[3]),
                           plii_float4_add(a.records[4], b.records[4]), plii_float4_add(a.records[5], b.records[5]),
                           plii_float4_add(a.records[6], b.records[6]), plii_float4_add(a.records[7], b.records[7])}};
}
PLII_SIMD_INLINE plii_packed8 plii_packed8_sub(plii_packed8 a, plii_packed8 b) {
    return (plii_packed8){{plii_float4_sub(a.records[0], b.records[0]), plii_float4_sub(a.records[1], b.records[1]),
                           plii_float4_sub(a.records[2], b.records[2]), plii_float4_sub(a.records[3], b.records[3]),
                           plii_float4_sub(a.records[4], b.records[4]), plii_float4_sub(a.records[5], b.records[5]),
                           plii_float4_sub(a.records[6], b.records[6]), plii_float4_sub(a.records[7], b.records[7])}};
}
PLII_SIMD_INLINE plii_records8 plii_packed8_turn(plii_packed8 a) {
    plii_float4 even[4] = {a.records[0], a.records[2], a.records[4], a.records[6]};
    plii_float4 odd[4] = {a.records[1], a.records[3], a.records[5], a.records[7]};
    plii_float4_turn(even);
    plii_float4_turn(odd);
    return (plii_records8){{even[0], odd[0]}, {even[1], odd[1]}, {even[2], odd[2]}, {even[3], odd[3]}};
}

PLII_SIMD_INLINE plii_packed8 plii_records8_turn(const plii_records8* a) {
    plii_float4 even[4] = {a->x.low, a->y.low, a->z.low, a->w.low};
    plii_float4 odd[4] = {a->x.high, a->y.high, a->z.high, a->w.high};
    plii_float4_turn(even);
    plii_float4_turn(odd);
    return (plii_packed8){{even[0], odd[0], even[1], odd[1], even[2], odd[2], even[3], odd[3]}};
}

PLII_SIMD_INLINE plii_packed8 plii_packed8_scale_xyz(plii_packed8 a, plii_float8 factors) {
    plii_float4 even[4] = {a.records[0], a.records[2], a.records[4], a.records[6]};
    plii_float4 odd[4] = {a.records[1], a.records[3], a.records[5], a.records[7]};
    plii_float4_scale_xyz(even, factors.low);
    plii_float4_scale_xyz(odd, factors.high);
    return (plii_packed8){{even[0], odd[0], even[1], odd[1], even[2], odd[2], even[3], odd[3]}};
}
PLII_SIMD_INLINE plii_packed8 plii_packed8_add_scaled(plii_packed8 a, plii_packed8 b, plii_float8 factors) {
    return plii_packed8_add(a, plii_packed8_scale_xyz(b, factors));
}
PLII_SIMD_INLINE plii_packed8 plii_packed8_sub_scaled(plii_packed8 a, plii_packed8 b, plii_float8 factors) {
    return plii_packed8_sub(a, plii_packed8_scale_xyz(b, factors));
}
PLII_SIMD_INLINE void plii_packed8_store(pli_vec4* first, int step, plii_packed8 a) {
    plii_float4_to(first, a.records[0]);
    plii_float4_to(first + step, a.records[1]);
    plii_float4_to(first + 2 * step, a.records[2]);
    plii_float4_to(first + 3 * step, a.records[3]);
    plii_float4_to(first + 4 * step, a.records[4]);
    plii_float4_to(first + 5 * step, a.records[5]);
    plii_float4_to(first + 6 * step, a.records[6]);
    plii_float4_to(first + 7 * step, a.records[7]);
}
PLII_SIMD_INLINE void plii_packed8_scatter(pli_vec4* records, const uint32_t* places, plii_packed8 a) {
    plii_float4_to(plii_simd_at_mutable(records, places[0]), a.records[0]);
    plii_float4_to(plii_simd_at_mutable(records, places[1]), a.records[1]);
    plii_float4_to(plii_simd_at_mutable(records, places[2]), a.records[2]);
    plii_float4_to(plii_simd_at_mutable(records, places[3]), a.records[3]);
    plii_float4_to(plii_simd_at_mutable(records, places[4]), a.records[4]);
    plii_float4_to(plii_simd_at_mutable(records, places[5]), a.records[5]);
    plii_float4_to(plii_simd_at_mutable(records, places[6]), a.records[6]);
    plii_float4_to(plii_simd_at_mutable(records, places[7]), a.records[7]);
}
/* From an even place to the next one; from one even place to another there are four records. */
PLII_SIMD_INLINE ptrdiff_t plii_simd_turn(int width) {
    return width == 2 ? 1 : 2;
}
PLII_SIMD_INLINE plii_packed8 plii_simd_load_turns(const pli_vec4* first, int width) {
    const ptrdiff_t odd = plii_simd_turn(width);
    return (plii_packed8){{plii_float4_from(first), plii_float4_from(first + odd), plii_float4_from(first + 4),
                           plii_float4_from(first + 4 + odd), plii_float4_from(first + 8),
                           plii_float4_from(first + 8 + odd), plii_float4_from(first + 12),
                           plii_float4_from(first + 12 + odd)}};
}
PLII_SIMD_INLINE void plii_packed8_load_turns(const pli_vec4* first, int width, plii_packed8* a, plii_packed8* b) {
    *a = plii_simd_load_turns(first, width);
    *b = plii_simd_load_turns(first + width, width);
}
PLII_SIMD_INLINE void plii_simd_store_turns(pli_vec4* first, int width, plii_packed8 a) {
    const ptrdiff_t odd = plii_simd_turn(width);
    plii_float4_to(first, a.records[0]);
    plii_float4_to(first + odd, a.records[1]);
    plii_float4_to(first + 4, a.records[2]);
    plii_float4_to(first + 4 + odd, a.records[3]);
    plii_float4_to(first + 8, a.records[4]);
    plii_float4_to(first + 8 + odd, a.records[5]);
    plii_float4_to(first + 12, a.records[6]);
    plii_float4_to(first + 12 + odd, a.records[7]);
}
PLII_SIMD_INLINE void plii_packed8_store_turns(pli_vec4* first, int width, plii_packed8 a, plii_packed8 b) {
    plii_simd_store_turns(first, width, a);
    plii_simd_store_turns(first + width, width, b);
}

PLII_SIMD_INLINE plii_float8 plii_float8_load_halves(const float* low, const float* high) {
    return (plii_float8){plii_float4_load(low), plii_float4_load(high)};
}
PLII_SIMD_INLINE void plii_float8_store_halves(float* low, float* high, plii_float8 a) {
    plii_float4_store(low, a.low);
    plii_float4_store(high, a.high);
}
PLII_SIMD_INLINE void plii_float8_load_turns(const float* first, const float* second, plii_float8* a, plii_float8* b) {
    const plii_float4 f0 = plii_float4_load(first), f1 = plii_float4_load(first + 4);
    const plii_float4 s0 = plii_float4_load(second), s1 = plii_float4_load(second + 4);
    *a = (plii_float8){plii_float4_even(f0, f1), plii_float4_even(s0, s1)};
    *b = (plii_float8){plii_float4_odd(f0, f1), plii_float4_odd(s0, s1)};
}
PLII_SIMD_INLINE void plii_float8_store_turns(float* first, float* second, plii_float8 a, plii_float8 b) {
    plii_float4_store(first, plii_float4_zip_low(a.low, b.low));
    plii_float4_store(first + 4, plii_float4_zip_high(a.low, b.low));
    plii_float4_store(second, plii_float4_zip_low(a.high, b.high));
    plii_float4_store(second + 4, plii_float4_zip_high(a.high, b.high));
}
PLII_SIMD_INLINE plii_float8 plii_float8_load_slots(const float* slots) {
    const plii_float4 even = plii_float4_load(slots), odd = plii_float4_load(slots + 4);
    return (plii_float8){plii_float4_zip_low(even, odd), plii_float4_zip_high(even, odd)};
}
PLII_SIMD_INLINE plii_float8 plii_float8_load_turned_slots(const float* slots) {
    return plii_float8_load(slots);
}

#endif

#endif
