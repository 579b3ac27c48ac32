#pragma once

/* Boxes along the axes. */

#include "math/vec.h"

static inline bool plii_bounds_overlap(pli_bounds a, pli_bounds b) {
    return a.min.x <= b.max.x && a.max.x >= b.min.x && a.min.y <= b.max.y && a.max.y >= b.min.y && a.min.z <= b.max.z &&
           a.max.z >= b.min.z;
}
static inline pli_bounds plii_bounds_add(pli_bounds b, pli_vec3 point) {
    return (pli_bounds){plii_vec3_min(b.min, point), plii_vec3_max(b.max, point)};
}
/* Zeros without any. */
static inline pli_bounds plii_bounds_of_points(int count, const pli_vec3* points) {
    pli_bounds bounds = count > 0 ? (pli_bounds){points[0], points[0]} : (pli_bounds){0};
    for (int i = 1; i < count; ++i) {
        bounds = plii_bounds_add(bounds, points[i]);
    }
    return bounds;
}
static inline pli_bounds plii_bounds_join(pli_bounds a, pli_bounds b) {
    return (pli_bounds){plii_vec3_min(a.min, b.min), plii_vec3_max(a.max, b.max)};
}
static inline pli_bounds plii_bounds_of_triangle(pli_vec3 a, pli_vec3 b, pli_vec3 c) {
    return (pli_bounds){plii_vec3_min(a, plii_vec3_min(b, c)), plii_vec3_max(a, plii_vec3_max(b, c))};
}
static inline pli_bounds plii_bounds_of_face(const pli_vec4* positions, const int* face) {
    return plii_bounds_of_triangle(plii_xyz(positions[face[0]]), plii_xyz(positions[face[1]]),
                                   plii_xyz(positions[face[2]]));
}
static inline pli_bounds plii_bounds_grow(pli_bounds b, float margin) {
    const pli_vec3 m = pli_vec3_make(margin, margin, margin);
    b.min = pli_vec3_sub(b.min, m);
    b.max = pli_vec3_add(b.max, m);
    return b;
}
static inline bool plii_bounds_contain(pli_bounds outer, pli_bounds inner) {
    return outer.min.x <= inner.min.x && outer.min.y <= inner.min.y && outer.min.z <= inner.min.z &&
           outer.max.x >= inner.max.x && outer.max.y >= inner.max.y && outer.max.z >= inner.max.z;
}

typedef struct plii_range {
    float low, high;
} plii_range;
/* Nothing where a row does not see the axis, whose infinity must not come in. */
static inline plii_range plii_range_add_axis(plii_range sum, float weight, float min, float max) {
    if (weight == 0.0f) { return sum; }
    return (plii_range){sum.low + weight * (weight > 0.0f ? min : max),
                        sum.high + weight * (weight > 0.0f ? max : min)};
}
/* One coordinate of a box after a rigid motion, by its row of the rotation. */
static inline plii_range plii_bounds_transform_row(pli_bounds local, pli_vec3 row, float origin) {
    plii_range sum = {origin, origin};
    sum = plii_range_add_axis(sum, row.x, local.min.x, local.max.x);
    sum = plii_range_add_axis(sum, row.y, local.min.y, local.max.y);
    sum = plii_range_add_axis(sum, row.z, local.min.z, local.max.z);
    /* Where infinities met there is no number. */
    return (plii_range){isnan(sum.low) ? -INFINITY : sum.low, isnan(sum.high) ? INFINITY : sum.high};
}
static inline pli_bounds plii_bounds_transform(pli_bounds local, pli_transform pose) {
    const plii_range x = plii_bounds_transform_row(local, pose.rotation.rows[0], pose.origin.x);
    const plii_range y = plii_bounds_transform_row(local, pose.rotation.rows[1], pose.origin.y);
    const plii_range z = plii_bounds_transform_row(local, pose.rotation.rows[2], pose.origin.z);
    return (pli_bounds){{x.low, y.low, z.low}, {x.high, y.high, z.high}};
}

/* Of boxes that are kept from step to step, for those who must find the same pairs as Bullet (btDbvt::update): a stored
   box is replaced only when it does not hold the new one, and then by a larger one. */
static inline void plii_fat_aabb_update(pli_bounds* stored, pli_bounds box, pli_vec3 motion, float margin) {
    if (plii_bounds_contain(*stored, box)) { return; }
    box = plii_bounds_grow(box, margin);
    *(motion.x > 0.0f ? &box.max.x : &box.min.x) += motion.x;
    *(motion.y > 0.0f ? &box.max.y : &box.min.y) += motion.y;
    *(motion.z > 0.0f ? &box.max.z : &box.min.z) += motion.z;
    *stored = box;
}
