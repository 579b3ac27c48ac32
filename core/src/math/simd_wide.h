#pragma once

/* The sixteen floats of two groups of eight at a time where a kernel for AVX-512 asks for them, else the eight of one,
   with the same results. Rows of floats begin at `first` and `second`, records are in the order of plii_simd_record;
   what is `second` counts for nothing where there is one group. */

#include "math/simd_float8.h"

/* What is passed by value, not in line, lies at addresses of 32 bytes in code of clang 14 with AddressSanitizer, which
   takes them for those of 64. */
#if defined(PLII_WIDE_OF_SIXTEEN) && !PLII_SIMD_IS_CHECKED

enum { PLII_WIDE_GROUPS = 2 };
typedef float plii_wide __attribute__((vector_size(64)));

#define plii_wide_all _mm512_set1_ps
#define plii_wide_sqrt _mm512_sqrt_ps
#define plii_wide_max _mm512_max_ps
#define plii_wide_add(a, b) ((a) + (b))
#define plii_wide_sub(a, b) ((a) - (b))
#define plii_wide_mul(a, b) ((a) * (b))
#define plii_wide_div(a, b) ((a) / (b))

PLII_SIMD_INLINE plii_wide plii_wide_of(plii_float8 first, plii_float8 second) {
    return _mm512_insertf32x8(_mm512_castps256_ps512(first), second, 1);
}
PLII_SIMD_INLINE plii_wide plii_wide_load(const float* first, const float* second) {
    return plii_wide_of(plii_float8_load(first), plii_float8_load(second));
}
PLII_SIMD_INLINE void plii_wide_store(float* first, float* second, plii_wide a) {
    plii_float8_store(first, _mm512_castps512_ps256(a));
    plii_float8_store(second, _mm512_extractf32x8_ps(a, 1));
}
PLII_SIMD_INLINE plii_wide plii_wide_where_greater(plii_wide a, plii_wide b, plii_wide value) {
    return _mm512_maskz_mov_ps(_mm512_cmp_ps_mask(a, b, _CMP_GT_OS), value);
}
PLII_SIMD_INLINE void plii_wide_transpose4(plii_wide r[4]){
    PLII_TRANSPOSE4(plii_wide, _mm512)} PLII_SIMD_INLINE plii_wide
    plii_wide_load_records(const pli_vec4* records, const uint32_t* first, const uint32_t* second) {
    return plii_wide_of(plii_simd_load_two(records, first), plii_simd_load_two(records, second));
}
PLII_SIMD_INLINE void plii_wide_store_records(pli_vec4* records, const uint32_t* first, const uint32_t* second,
                                              plii_wide a) {
    plii_simd_store_two(records, first, _mm512_castps512_ps256(a));
    plii_simd_store_two(records, second, _mm512_extractf32x8_ps(a, 1));
}

#else

enum { PLII_WIDE_GROUPS = 1 };
typedef plii_float8 plii_wide;

#define plii_wide_all plii_float8_all
#define plii_wide_sqrt plii_float8_sqrt
#define plii_wide_max plii_float8_max
#define plii_wide_add plii_float8_add
#define plii_wide_sub plii_float8_sub
#define plii_wide_mul plii_float8_mul
#define plii_wide_div plii_float8_div
#define plii_wide_where_greater plii_float8_where_greater
#define plii_wide_transpose4 plii_float8_transpose4
#define plii_wide_load(first, second) plii_float8_load(first)
#define plii_wide_store(first, second, a) plii_float8_store(first, a)
#define plii_wide_load_records(records, first, second) plii_simd_load_two(records, first)
#define plii_wide_store_records(records, first, second, a) plii_simd_store_two(records, first, a)

#endif

typedef struct plii_wide_vec3 {
    plii_wide x, y, z;
} plii_wide_vec3;

PLII_SIMD_INLINE plii_wide_vec3 plii_wide_vec3_sub(plii_wide_vec3 a, plii_wide_vec3 b) {
    return (plii_wide_vec3){plii_wide_sub(a.x, b.x), plii_wide_sub(a.y, b.y), plii_wide_sub(a.z, b.z)};
}
PLII_SIMD_INLINE plii_wide_vec3 plii_wide_vec3_add(plii_wide_vec3 a, plii_wide_vec3 b) {
    return (plii_wide_vec3){plii_wide_add(a.x, b.x), plii_wide_add(a.y, b.y), plii_wide_add(a.z, b.z)};
}
PLII_SIMD_INLINE plii_wide_vec3 plii_wide_vec3_scale(plii_wide_vec3 a, plii_wide s) {
    return (plii_wide_vec3){plii_wide_mul(a.x, s), plii_wide_mul(a.y, s), plii_wide_mul(a.z, s)};
}
PLII_SIMD_INLINE plii_wide plii_wide_vec3_dot(plii_wide_vec3 a, plii_wide_vec3 b) {
    return plii_wide_add(plii_wide_add(plii_wide_mul(a.x, b.x), plii_wide_mul(a.y, b.y)), plii_wide_mul(a.z, b.z));
}

/* Records by components. */
typedef struct plii_wide_nodes {
    plii_wide_vec3 at;
    plii_wide w;
} plii_wide_nodes;

PLII_SIMD_INLINE plii_wide_nodes plii_wide_gather(const pli_vec4* records, const uint32_t* first,
                                                  const uint32_t* second) {
    plii_wide r[4];
    PLII_UNROLL(4)
    for (int k = 0; k < 4; ++k) {
        r[k] = plii_wide_load_records(records, first + 2 * k, second + 2 * k);
    }
    plii_wide_transpose4(r);
    return (plii_wide_nodes){{r[0], r[1], r[2]}, r[3]};
}
/* In the order of the records: of two with the same index the later one stays. */
PLII_SIMD_INLINE void plii_wide_scatter(pli_vec4* records, const uint32_t* first, const uint32_t* second,
                                        plii_wide_nodes a) {
    plii_wide r[4] = {a.at.x, a.at.y, a.at.z, a.w};
    plii_wide_transpose4(r);
    PLII_UNROLL(4)
    for (int k = 0; k < 4; ++k) {
        plii_wide_store_records(records, first + 2 * k, second + 2 * k, r[k]);
    }
}
