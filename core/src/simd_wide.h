#ifndef PLII_SIMD_WIDE_H
#define PLII_SIMD_WIDE_H

/* The widest vectors that an instruction set has from eight floats on: sixteen where a source file has defined
   PLII_SIMD_AVX512, otherwise those of simd.h. What is left over may be fewer: operations on memory take how many
   floats they are for, a multiple of four. */

#include "simd.h"

#if defined(PLII_SIMD_AVX512)

enum { PLII_WIDE_LANES = 16 };

typedef __m512 plii_wide;

PLII_SIMD_INLINE __mmask16 plii_wide_mask(int count) {
    return (__mmask16)((1u << count) - 1u);
}
PLII_SIMD_INLINE plii_wide plii_wide_load(const float* source, int count) {
    return count == PLII_WIDE_LANES ? _mm512_loadu_ps(source) : _mm512_maskz_loadu_ps(plii_wide_mask(count), source);
}
PLII_SIMD_INLINE void plii_wide_store(float* target, plii_wide a, int count) {
    if (count == PLII_WIDE_LANES) {
        _mm512_storeu_ps(target, a);
    } else {
        _mm512_mask_storeu_ps(target, plii_wide_mask(count), a);
    }
}
PLII_SIMD_INLINE plii_wide plii_wide_all(float value) {
    return _mm512_set1_ps(value);
}
PLII_SIMD_INLINE plii_wide plii_wide_add(plii_wide a, plii_wide b) {
    return _mm512_add_ps(a, b);
}
PLII_SIMD_INLINE plii_wide plii_wide_sub(plii_wide a, plii_wide b) {
    return _mm512_sub_ps(a, b);
}
PLII_SIMD_INLINE plii_wide plii_wide_mul(plii_wide a, plii_wide b) {
    return _mm512_mul_ps(a, b);
}
PLII_SIMD_INLINE plii_wide plii_wide_div(plii_wide a, plii_wide b) {
    return _mm512_div_ps(a, b);
}
PLII_SIMD_INLINE plii_wide plii_wide_sqrt(plii_wide a) {
    return _mm512_sqrt_ps(a);
}
PLII_SIMD_INLINE plii_wide plii_wide_where_greater(plii_wide a, plii_wide b, plii_wide value) {
    return _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(a, b, _CMP_GT_OQ), value);
}
/* Two fours, and nothing else. */
PLII_SIMD_INLINE plii_wide plii_wide_load_halves(const float* low, const float* high) {
    const __m512 four = _mm512_zextps128_ps512(_mm_loadu_ps(low));
    return _mm512_insertf32x4(four, _mm_loadu_ps(high), 1);
}
PLII_SIMD_INLINE void plii_wide_store_halves(float* low, float* high, plii_wide a) {
    _mm_storeu_ps(low, _mm512_castps512_ps128(a));
    _mm_storeu_ps(high, _mm512_extractf32x4_ps(a, 1));
}
/* Numbers that take turns in two rows of `count`; of each four lanes the first two are those of the first row. */
PLII_SIMD_INLINE void plii_wide_load_turns(const float* first, const float* second, int count, plii_wide* a,
                                           plii_wide* b) {
    const __m512 low = plii_wide_load(first, count), high = plii_wide_load(second, count);
    *a = _mm512_shuffle_ps(low, high, 0x88);
    *b = _mm512_shuffle_ps(low, high, 0xdd);
}
PLII_SIMD_INLINE void plii_wide_store_turns(float* first, float* second, int count, plii_wide a, plii_wide b) {
    plii_wide_store(first, _mm512_unpacklo_ps(a, b), count);
    plii_wide_store(second, _mm512_unpackhi_ps(a, b), count);
}
/* Eights in the order of records to that of memory. */
PLII_SIMD_INLINE plii_wide plii_wide_load_slots(const float* slots, int count) {
    return _mm512_permutexvar_ps(_mm512_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7, 8, 12, 9, 13, 10, 14, 11, 15),
                                 plii_wide_load(slots, count));
}
/* To that of numbers that take turns. */
PLII_SIMD_INLINE plii_wide plii_wide_load_turned_slots(const float* slots, int count) {
    return _mm512_permutexvar_ps(_mm512_setr_epi32(0, 1, 4, 5, 2, 3, 6, 7, 8, 9, 12, 13, 10, 11, 14, 15),
                                 plii_wide_load(slots, count));
}
/* Every second four, `count` floats in all. */
PLII_SIMD_INLINE plii_wide plii_wide_load_fours(const float* first, int count) {
    const int low = count < 8 ? count : 8;
    const __m512 a = _mm512_maskz_loadu_ps((__mmask16)(plii_wide_mask(2 * low) & 0x0f0f), first);
    const __m512 b = _mm512_maskz_loadu_ps((__mmask16)(plii_wide_mask(2 * (count - low)) & 0x0f0f), first + 16);
    return _mm512_shuffle_f32x4(a, b, 0x88);
}
PLII_SIMD_INLINE void plii_wide_store_fours(float* first, plii_wide a, int count) {
    const int low = count < 8 ? count : 8;
    _mm512_mask_storeu_ps(first, (__mmask16)(plii_wide_mask(2 * low) & 0x0f0f), _mm512_shuffle_f32x4(a, a, 0x50));
    _mm512_mask_storeu_ps(first + 16, (__mmask16)(plii_wide_mask(2 * (count - low)) & 0x0f0f),
                          _mm512_shuffle_f32x4(a, a, 0xfa));
}

#elif defined(PLII_SIMD_AVX2) || defined(PLII_SIMD_SSE2) || defined(PLII_SIMD_NEON) || defined(PLII_SIMD_PORTABLE)

enum { PLII_WIDE_LANES = 8 }; /* and all counts */

typedef plii_float8 plii_wide;

PLII_SIMD_INLINE plii_wide plii_wide_load(const float* source, int count) {
    (void)count;
    return plii_float8_load(source);
}
PLII_SIMD_INLINE void plii_wide_store(float* target, plii_wide a, int count) {
    (void)count;
    plii_float8_store(target, a);
}
PLII_SIMD_INLINE plii_wide plii_wide_all(float value) {
    return plii_float8_all(value);
}
PLII_SIMD_INLINE plii_wide plii_wide_add(plii_wide a, plii_wide b) {
    return plii_float8_add(a, b);
}
PLII_SIMD_INLINE plii_wide plii_wide_sub(plii_wide a, plii_wide b) {
    return plii_float8_sub(a, b);
}
PLII_SIMD_INLINE plii_wide plii_wide_mul(plii_wide a, plii_wide b) {
    return plii_float8_mul(a, b);
}
PLII_SIMD_INLINE plii_wide plii_wide_div(plii_wide a, plii_wide b) {
    return plii_float8_div(a, b);
}
PLII_SIMD_INLINE plii_wide plii_wide_sqrt(plii_wide a) {
    return plii_float8_sqrt(a);
}
PLII_SIMD_INLINE plii_wide plii_wide_where_greater(plii_wide a, plii_wide b, plii_wide value) {
    return plii_float8_where_greater(a, b, value);
}
PLII_SIMD_INLINE plii_wide plii_wide_load_halves(const float* low, const float* high) {
    return plii_float8_load_halves(low, high);
}
PLII_SIMD_INLINE void plii_wide_store_halves(float* low, float* high, plii_wide a) {
    plii_float8_store_halves(low, high, a);
}
PLII_SIMD_INLINE void plii_wide_load_turns(const float* first, const float* second, int count, plii_wide* a,
                                           plii_wide* b) {
    (void)count;
    plii_float8_load_turns(first, second, a, b);
}
PLII_SIMD_INLINE void plii_wide_store_turns(float* first, float* second, int count, plii_wide a, plii_wide b) {
    (void)count;
    plii_float8_store_turns(first, second, a, b);
}
PLII_SIMD_INLINE plii_wide plii_wide_load_slots(const float* slots, int count) {
    (void)count;
    return plii_float8_load_slots(slots);
}
PLII_SIMD_INLINE plii_wide plii_wide_load_turned_slots(const float* slots, int count) {
    (void)count;
    return plii_float8_load_turned_slots(slots);
}
PLII_SIMD_INLINE plii_wide plii_wide_load_fours(const float* first, int count) {
    (void)count;
    return plii_float8_load_halves(first, first + 8);
}
PLII_SIMD_INLINE void plii_wide_store_fours(float* first, plii_wide a, int count) {
    (void)count;
    plii_float8_store_halves(first, first + 8, a);
}

#endif

#endif
