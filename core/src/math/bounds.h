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
static inline pli_bounds plii_bounds_of_triangle(pli_vec3 a, pli_vec3 b, pli_vec3 c) {
    return (pli_bounds){plii_vec3_min(a, plii_vec3_min(b, c)), plii_vec3_max(a, plii_vec3_max(b, c))};
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

/* Bounds of a box after a rigid motion. */
pli_bounds plii_bounds_transform(pli_bounds local, pli_transform pose);
