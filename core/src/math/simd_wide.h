#ifndef PLII_SIMD_WIDE_H
#define PLII_SIMD_WIDE_H

/* Eight floats, as those of simd.h. */

#include "math/simd.h"

#if defined(PLII_SIMD_AVX2) || defined(PLII_SIMD_SSE2) || defined(PLII_SIMD_NEON) || defined(PLII_SIMD_PORTABLE)

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
