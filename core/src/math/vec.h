#pragma once

/* Vectors and matrices. Where Bullet's bits are to be met the order of operations is part of the contract. */

#include "pliant/body.h"
#include "pliant/math.h"

#include <float.h>
#include <stdbool.h>

#define PLII_EPSILON FLT_EPSILON

static inline pli_vec3 plii_xyz(pli_vec4 v) {
    return pli_vec3_make(v.x, v.y, v.z);
}
/* Keeps w. */
static inline void plii_set_xyz(pli_vec4* target, pli_vec3 v) {
    target->x = v.x;
    target->y = v.y;
    target->z = v.z;
}
static inline void plii_add_xyz(pli_vec4* target, pli_vec3 v) {
    plii_set_xyz(target, pli_vec3_add(plii_xyz(*target), v));
}
static inline bool plii_is_finite(float value) {
    return isfinite(value) != 0;
}
static inline bool plii_vec3_is_finite(pli_vec3 v) {
    return plii_is_finite(v.x) && plii_is_finite(v.y) && plii_is_finite(v.z);
}
static inline bool plii_mat3_is_finite(pli_mat3 m) {
    return plii_vec3_is_finite(m.rows[0]) && plii_vec3_is_finite(m.rows[1]) && plii_vec3_is_finite(m.rows[2]);
}
static inline bool plii_transform_is_finite(pli_transform t) {
    return plii_mat3_is_finite(t.rotation) && plii_vec3_is_finite(t.origin);
}
/* One reciprocal and three products, as btVector3 divides by a scalar. */
static inline pli_vec3 plii_vec3_divide(pli_vec3 a, float s) {
    return pli_vec3_scale(a, 1.0f / s);
}
/* Of length 1; `other` where it is not longer than `least`. */
static inline pli_vec3 plii_vec3_unit_or(pli_vec3 a, float least, pli_vec3 other) {
    const float length = pli_vec3_length(a);
    return length > least ? plii_vec3_divide(a, length) : other;
}
/* btVector3::safeNormalize: (1, 0, 0) when too short. */
static inline pli_vec3 plii_vec3_safe_normalize(pli_vec3 a) {
    const float length_squared = pli_vec3_length_squared(a);
    if (length_squared >= PLII_EPSILON * PLII_EPSILON) { return plii_vec3_divide(a, sqrtf(length_squared)); }
    return pli_vec3_make(1, 0, 0);
}
static inline pli_vec3 plii_vec3_perpendicular(pli_vec3 unit) {
    const pli_vec3 axis = fabsf(unit.x) < 0.5f ? pli_vec3_make(1, 0, 0) : pli_vec3_make(0, 1, 0);
    return plii_vec3_safe_normalize(pli_vec3_cross(unit, axis));
}
/* A point in the frame of a pose, rounded as btTransform::inverse() times the point. */
static inline pli_vec3 plii_localize(pli_transform pose, pli_vec3 point) {
    return pli_vec3_add(pli_mat3_transpose_mul_vec3(pose.rotation, point),
                        pli_mat3_transpose_mul_vec3(pose.rotation, pli_vec3_neg(pose.origin)));
}
static inline float plii_min(float a, float b) {
    return a < b ? a : b;
}
static inline float plii_max(float a, float b) {
    return a > b ? a : b;
}
static inline float plii_clamp(float v, float low, float high) {
    return v < low ? low : v > high ? high : v;
}
static inline float plii_lerp(float a, float b, float t) {
    return a + (b - a) * t;
}
/* From `apart`, seen from the centre of a sphere, along a unit vector to the surface; 0 outside, on the way out. */
static inline float plii_sphere_room(pli_vec3 apart, float radius, pli_vec3 direction) {
    const float along = pli_vec3_dot(apart, direction), beyond = pli_vec3_length_squared(apart) - radius * radius;
    if (beyond >= 0.0f && along >= 0.0f) { return 0.0f; }
    return plii_max(sqrtf(plii_max(along * along - beyond, 0.0f)) - along, 0.0f);
}
static inline pli_vec3 plii_vec3_min(pli_vec3 a, pli_vec3 b) {
    return pli_vec3_make(plii_min(a.x, b.x), plii_min(a.y, b.y), plii_min(a.z, b.z));
}
static inline pli_vec3 plii_vec3_max(pli_vec3 a, pli_vec3 b) {
    return pli_vec3_make(plii_max(a.x, b.x), plii_max(a.y, b.y), plii_max(a.z, b.z));
}
/* The first of those that lie farthest along a direction; there is one point at least. */
static inline pli_vec3 plii_vec3_farthest(int count, const pli_vec3* points, pli_vec3 direction) {
    int farthest = 0;
    float most = pli_vec3_dot(points[0], direction);
    for (int i = 1; i < count; ++i) {
        const float along = pli_vec3_dot(points[i], direction);
        farthest = along > most ? i : farthest;
        most = along > most ? along : most;
    }
    return points[farthest];
}
/* By x, then y, then z: < 0, 0 or > 0. */
static inline int plii_vec3_compare(pli_vec3 a, pli_vec3 b) {
    if (a.x != b.x) { return a.x < b.x ? -1 : 1; }
    if (a.y != b.y) { return a.y < b.y ? -1 : 1; }
    return (a.z > b.z) - (a.z < b.z);
}
static inline bool plii_vec3_is_zero(pli_vec3 v) {
    return v.x == 0.0f && v.y == 0.0f && v.z == 0.0f;
}
static inline bool plii_mat3_is_zero(const pli_mat3* m) {
    return plii_vec3_is_zero(m->rows[0]) && plii_vec3_is_zero(m->rows[1]) && plii_vec3_is_zero(m->rows[2]);
}
static inline pli_mat3 plii_mat3_add(pli_mat3 a, pli_mat3 b) {
    for (int i = 0; i < 3; ++i) {
        a.rows[i] = pli_vec3_add(a.rows[i], b.rows[i]);
    }
    return a;
}
static inline pli_mat3 plii_mat3_scale(pli_mat3 m, float s) {
    for (int i = 0; i < 3; ++i) {
        m.rows[i] = pli_vec3_scale(m.rows[i], s);
    }
    return m;
}
static inline pli_mat3 plii_mat3_diagonal(float x, float y, float z) {
    const pli_mat3 diagonal = {{{x, 0, 0}, {0, y, 0}, {0, 0, z}}};
    return diagonal;
}
/* Adjugate over determinant by the first row, no check for singularity (btMatrix3x3::inverse). */
static inline pli_mat3 plii_mat3_inverse(pli_mat3 m) {
    const pli_vec3 a = m.rows[0], b = m.rows[1], c = m.rows[2];
    const pli_vec3 cofactors = pli_vec3_cross(b, c);
    const float s = 1.0f / pli_vec3_dot(a, cofactors);
    const pli_mat3 inverse = {{
        {cofactors.x * s, (a.z * c.y - a.y * c.z) * s, (a.y * b.z - a.z * b.y) * s},
        {cofactors.y * s, (a.x * c.z - a.z * c.x) * s, (a.z * b.x - a.x * b.z) * s},
        {cofactors.z * s, (a.y * c.x - a.x * c.y) * s, (a.x * b.y - a.y * b.x) * s},
    }};
    return inverse;
}
