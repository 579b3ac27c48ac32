#pragma once

/* Four floats at a time: the record of a node, or one component of four nodes. Results are those of the same operations
   one by one, so they have the same bits everywhere. Operators are the vector extensions of gcc and clang; only what
   those do not have, or not as well, is told for an instruction set. Masks have all bits or none set in a lane. */

#include "math/vec.h"

#include <string.h>

#if defined(__SSE2__)
#include <emmintrin.h>
#elif defined(__ARM_NEON) && defined(__aarch64__)
#include <arm_neon.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif

/* Vectors passed through memory would cost more than the arithmetic. With checks of each access, or unoptimised,
   inlined code grows so much that compilers need ten seconds and more for a kernel; there speed does not matter. */
#if defined(__SANITIZE_ADDRESS__)
#define PLII_SIMD_IS_CHECKED 1
#elif defined(__has_feature)
#define PLII_SIMD_IS_CHECKED __has_feature(address_sanitizer)
#else
#define PLII_SIMD_IS_CHECKED 0
#endif
#if defined(__OPTIMIZE__) && !PLII_SIMD_IS_CHECKED
#define PLII_SIMD_INLINE static inline __attribute__((always_inline))
#else
#define PLII_SIMD_INLINE static inline
#endif

/* Before a loop: its turns one after the other, where by -O2 gcc would keep their vectors in memory. Not where size
   counts, nor is there what several functions call in each of them. */
#if defined(__OPTIMIZE_SIZE__)
#define PLII_SIMD_SHARED static
#define PLII_UNROLL(turns)
#else
#define PLII_SIMD_SHARED PLII_SIMD_INLINE
#define PLII_PRAGMA(text) _Pragma(#text)
#define PLII_UNROLL(turns) PLII_PRAGMA(GCC unroll turns)
#endif

enum { PLII_LANES = 4, PLII_LANES_XYZ = 7 };

typedef float plii_float4 __attribute__((vector_size(16)));
typedef int32_t plii_mask4 __attribute__((vector_size(16)));

#define PLII_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)

PLII_SIMD_INLINE plii_float4 plii_float4_load(const float* source) {
    plii_float4 a;
    memcpy(&a, source, sizeof a);
    return a;
}
PLII_SIMD_INLINE void plii_float4_store(float* target, plii_float4 a) {
    memcpy(target, &a, sizeof a);
}
PLII_SIMD_INLINE plii_float4 plii_float4_from(const pli_vec4* record) {
    return plii_float4_load(&record->x);
}
PLII_SIMD_INLINE void plii_float4_to(pli_vec4* record, plii_float4 a) {
    plii_float4_store(&record->x, a);
}
PLII_SIMD_INLINE plii_float4 plii_float4_all(float value) {
    return (plii_float4){value, value, value, value};
}
PLII_SIMD_INLINE plii_float4 plii_lanes_xyzw(float x, float y, float z, float w) {
    return (plii_float4){x, y, z, w};
}
/* Of bits: operations of floats and of integers are in different parts of a processor. */
#if defined(__SSE2__)
#define PLII_OWN_AND(mask, value) _mm_and_ps((plii_float4)(mask), value)
#define PLII_OWN_SELECT(mask, yes, no) _mm_or_ps(PLII_OWN_AND(mask, yes), _mm_andnot_ps((plii_float4)(mask), no))
#else
#define PLII_OWN_AND(mask, value) (plii_float4)((mask) & (plii_mask4)(value))
#define PLII_OWN_SELECT(mask, yes, no) (plii_float4)(((mask) & (plii_mask4)(yes)) | (~(mask) & (plii_mask4)(no)))
#endif
PLII_SIMD_INLINE plii_float4 plii_lanes_select(plii_mask4 mask, plii_float4 yes, plii_float4 no) {
    return PLII_OWN_SELECT(mask, yes, no);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_where(plii_mask4 mask, plii_float4 value) {
    return PLII_OWN_AND(mask, value);
}
/* x, y, z, 0 */
PLII_SIMD_INLINE plii_float4 plii_lanes_xyz(plii_float4 a) {
    return plii_lanes_where((plii_mask4){-1, -1, -1, 0}, a);
}
/* The lanes in another order: y, z, x, w, and one of them in all. */
#define PLII_LANES_ORDER(name, ...)                                                                                    \
    PLII_SIMD_INLINE plii_float4 plii_lanes_##name(plii_float4 a) {                                                    \
        return PLII_SHUFFLE(a, a, __VA_ARGS__);                                                                        \
    }
PLII_LANES_ORDER(yzx, 1, 2, 0, 3)
PLII_LANES_ORDER(all_x, 0, 0, 0, 0)
PLII_LANES_ORDER(all_y, 1, 1, 1, 1)
PLII_LANES_ORDER(all_z, 2, 2, 2, 2)
PLII_LANES_ORDER(all_w, 3, 3, 3, 3)
PLII_SIMD_INLINE float plii_lanes_first(plii_float4 a) {
    return a[0];
}
/* (x + y) + z */
PLII_SIMD_INLINE float plii_lanes_sum(plii_float4 a) {
    return a[0] + a[1] + a[2];
}
/* Four records to components, and back. */
PLII_SIMD_INLINE void plii_float4_transpose(plii_float4 r[4]) {
    const plii_float4 xy01 = PLII_SHUFFLE(r[0], r[1], 0, 4, 1, 5), zw01 = PLII_SHUFFLE(r[0], r[1], 2, 6, 3, 7);
    const plii_float4 xy23 = PLII_SHUFFLE(r[2], r[3], 0, 4, 1, 5), zw23 = PLII_SHUFFLE(r[2], r[3], 2, 6, 3, 7);
    r[0] = PLII_SHUFFLE(xy01, xy23, 0, 1, 4, 5);
    r[1] = PLII_SHUFFLE(xy01, xy23, 2, 3, 6, 7);
    r[2] = PLII_SHUFFLE(zw01, zw23, 0, 1, 4, 5);
    r[3] = PLII_SHUFFLE(zw01, zw23, 2, 3, 6, 7);
}

/* plii_float4_sqrt; a < b ? a : b, and a > b ? a : b, also where one is NaN; bit k of an int for lane k of a mask */
#if defined(__SSE2__)
#define PLII_OWN_SQRT(a) _mm_sqrt_ps(a)
#define PLII_OWN_MIN(a, b) _mm_min_ps(a, b)
#define PLII_OWN_MAX(a, b) _mm_max_ps(a, b)
#define PLII_OWN_BITS(mask) _mm_movemask_ps((plii_float4)(mask))
#elif defined(__wasm_simd128__)
/* The "pseudo" ones are b < a ? b : a and a < b ? b : a. */
#define PLII_OWN_SQRT(a) (plii_float4) wasm_f32x4_sqrt((v128_t)(a))
#define PLII_OWN_MIN(a, b) (plii_float4) wasm_f32x4_pmin((v128_t)(b), (v128_t)(a))
#define PLII_OWN_MAX(a, b) (plii_float4) wasm_f32x4_pmax((v128_t)(b), (v128_t)(a))
#define PLII_OWN_BITS(mask) (int)wasm_i32x4_bitmask((v128_t)(mask))
#else
#if defined(__ARM_NEON) && defined(__aarch64__)
#define PLII_OWN_SQRT(a) (plii_float4) vsqrtq_f32((float32x4_t)(a))
#else
#define PLII_OWN_SQRT(a) ((plii_float4){sqrtf((a)[0]), sqrtf((a)[1]), sqrtf((a)[2]), sqrtf((a)[3])})
#endif
#define PLII_OWN_MIN(a, b) plii_lanes_select((a) < (b), a, b)
#define PLII_OWN_MAX(a, b) plii_lanes_select((a) > (b), a, b)
#define PLII_OWN_BITS(mask) plii_lanes_or((mask) & (plii_mask4){1, 2, 4, 8})
PLII_SIMD_INLINE int plii_lanes_or(plii_mask4 bits) {
    return bits[0] | bits[1] | bits[2] | bits[3];
}
#endif
PLII_SIMD_INLINE plii_float4 plii_float4_sqrt(plii_float4 a) {
    return PLII_OWN_SQRT(a);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_min(plii_float4 a, plii_float4 b) {
    return PLII_OWN_MIN(a, b);
}
PLII_SIMD_INLINE plii_float4 plii_lanes_max(plii_float4 a, plii_float4 b) {
    return PLII_OWN_MAX(a, b);
}
PLII_SIMD_INLINE int plii_lanes_bits(plii_mask4 mask) {
    return PLII_OWN_BITS(mask);
}

/* Vectors in memory, w: 0 */
#if defined(__SSE2__)
PLII_SIMD_INLINE plii_float4 plii_lanes_from_vec3(const pli_vec3* source) {
    const __m128i xy = _mm_loadl_epi64((const __m128i*)(const void*)source);
    return _mm_movelh_ps(_mm_castsi128_ps(xy), _mm_load_ss(&source->z));
}
PLII_SIMD_INLINE void plii_lanes_to_vec3(pli_vec3* target, plii_float4 a) {
    _mm_storel_pi((__m64*)(void*)target, a);
    _mm_store_ss(&target->z, _mm_movehl_ps(a, a));
}
#else
PLII_SIMD_INLINE plii_float4 plii_lanes_from_vec3(const pli_vec3* source) {
    return (plii_float4){source->x, source->y, source->z, 0.0f};
}
PLII_SIMD_INLINE void plii_lanes_to_vec3(pli_vec3* target, plii_float4 a) {
    *target = pli_vec3_make(a[0], a[1], a[2]);
}
#endif

PLII_SIMD_INLINE pli_vec3 plii_lanes_vec3(plii_float4 a) {
    pli_vec3 v;
    plii_lanes_to_vec3(&v, a);
    return v;
}

PLII_SIMD_INLINE plii_float4 plii_lanes_abs(plii_float4 a) {
    return (plii_float4)((plii_mask4)a & INT32_MAX);
}
/* copysignf */
PLII_SIMD_INLINE plii_float4 plii_lanes_copy_sign(plii_float4 a, plii_float4 sign) {
    return (plii_float4)(((plii_mask4)a & INT32_MAX) | ((plii_mask4)sign & INT32_MIN));
}

/* Of all lanes. */
#define PLII_LANES_MOST(name, of_two)                                                                                  \
    PLII_SIMD_INLINE float plii_lanes_##name(plii_float4 a) {                                                          \
        a = of_two(a, plii_lanes_all_w(a));                                                                            \
        return plii_lanes_first(of_two(of_two(a, plii_lanes_all_y(a)), plii_lanes_all_z(a)));                          \
    }
PLII_LANES_MOST(least, plii_lanes_min)
PLII_LANES_MOST(largest, plii_lanes_max)

/* pli_vec3_cross; w: 0 */
PLII_SIMD_INLINE plii_float4 plii_lanes_cross(plii_float4 a, plii_float4 b) {
    const plii_float4 zxy = a * plii_lanes_yzx(b) - plii_lanes_yzx(a) * b;
    return plii_lanes_yzx(zxy);
}
PLII_SIMD_INLINE float plii_lanes_dot(plii_float4 a, plii_float4 b) {
    return plii_lanes_sum(a * b);
}
/* The rows of a matrix, or its columns, w: 0; and their sum by the components of a vector: transpose(matrix) * v of
   rows, matrix * v of columns, with the same bits as in math.h. */
typedef struct plii_lanes_mat3 {
    plii_float4 at[4];
} plii_lanes_mat3;

PLII_SIMD_INLINE plii_lanes_mat3 plii_lanes_rows(const pli_mat3* m) {
    return (plii_lanes_mat3){{plii_lanes_from_vec3(&m->rows[0]), plii_lanes_from_vec3(&m->rows[1]),
                              plii_lanes_from_vec3(&m->rows[2]), plii_float4_all(0.0f)}};
}
PLII_SIMD_INLINE plii_lanes_mat3 plii_lanes_columns(const pli_mat3* m) {
    plii_lanes_mat3 columns = plii_lanes_rows(m);
    plii_float4_transpose(columns.at);
    return columns;
}
PLII_SIMD_INLINE plii_float4 plii_lanes_combine(plii_lanes_mat3 m, plii_float4 v) {
    return m.at[0] * plii_lanes_all_x(v) + m.at[1] * plii_lanes_all_y(v) + m.at[2] * plii_lanes_all_z(v);
}
/* Lanes in which all bits are set where `a` is finite: a - a is 0 there, else NaN. */
PLII_SIMD_INLINE plii_mask4 plii_lanes_finite(plii_float4 a) {
    return a - a <= 0.0f;
}
/* x, y and z are finite. */
PLII_SIMD_INLINE bool plii_lanes_xyz_finite(plii_float4 a) {
    return (plii_lanes_bits(plii_lanes_finite(a)) & PLII_LANES_XYZ) == PLII_LANES_XYZ;
}

/* Vectors of four nodes by components. */
typedef struct plii_vec3x4 {
    plii_float4 x, y, z;
} plii_vec3x4;

#define PLII_VEC3X4_OPERATOR(name, op)                                                                                 \
    PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_##name(plii_vec3x4 a, plii_vec3x4 b) {                                    \
        return (plii_vec3x4){a.x op b.x, a.y op b.y, a.z op b.z};                                                      \
    }
PLII_VEC3X4_OPERATOR(add, +)
PLII_VEC3X4_OPERATOR(sub, -)
PLII_VEC3X4_OPERATOR(mul, *)
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_scale(plii_vec3x4 a, plii_float4 s) {
    return (plii_vec3x4){a.x * s, a.y * s, a.z * s};
}
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_neg(plii_vec3x4 a) {
    return (plii_vec3x4){-a.x, -a.y, -a.z};
}
PLII_SIMD_INLINE plii_float4 plii_vec3x4_dot(plii_vec3x4 a, plii_vec3x4 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_cross(plii_vec3x4 a, plii_vec3x4 b) {
    return (plii_vec3x4){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
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
/* Of four records, without their w. */
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_of(plii_float4 a, plii_float4 b, plii_float4 c, plii_float4 d) {
    plii_float4 rows[4] = {a, b, c, d};
    plii_float4_transpose(rows);
    return (plii_vec3x4){rows[0], rows[1], rows[2]};
}
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_from_vec4s(const pli_vec4* records) {
    return plii_vec3x4_of(plii_float4_from(&records[0]), plii_float4_from(&records[1]), plii_float4_from(&records[2]),
                          plii_float4_from(&records[3]));
}
/* Of four vectors one after the other. */
PLII_SIMD_INLINE plii_vec3x4 plii_vec3x4_from(const pli_vec3* vectors) {
    const float* source = &vectors->x;
    const plii_float4 a = plii_float4_load(source), b = plii_float4_load(source + 4), c = plii_float4_load(source + 8);
    const plii_float4 yz = PLII_SHUFFLE(a, b, 1, 2, 4, 5); /* of the first two */
    const plii_float4 xy = PLII_SHUFFLE(b, c, 2, 3, 5, 6); /* of the last two */
    return (plii_vec3x4){PLII_SHUFFLE(a, xy, 0, 3, 4, 6), PLII_SHUFFLE(yz, xy, 0, 2, 5, 7),
                         PLII_SHUFFLE(yz, c, 1, 3, 4, 7)};
}
PLII_SIMD_INLINE void plii_vec3x4_to(pli_vec3* vectors, plii_vec3x4 v) {
    float* target = &vectors->x;
    const plii_float4 xy = PLII_SHUFFLE(v.x, v.y, 0, 2, 4, 6); /* of the vectors 0, 2 */
    const plii_float4 yz = PLII_SHUFFLE(v.y, v.z, 1, 3, 5, 7); /* 1, 3 */
    const plii_float4 zx = PLII_SHUFFLE(v.z, v.x, 0, 2, 5, 7); /* z of 0, 2, x of 1, 3 */
    plii_float4_store(target, PLII_SHUFFLE(xy, zx, 0, 2, 4, 6));
    plii_float4_store(target + 4, PLII_SHUFFLE(yz, xy, 0, 2, 5, 7));
    plii_float4_store(target + 8, PLII_SHUFFLE(zx, yz, 1, 3, 5, 7));
}
