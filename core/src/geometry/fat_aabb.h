#pragma once

/* Boxes that are kept from step to step (btDbvt::update), for those who must find the same pairs as Bullet. */

#include "math/bounds.h"
#include "math/vec.h"

/* A stored box is replaced only when it does not hold the new one, and then by a larger one. */
static inline void plii_fat_aabb_update(pli_bounds* stored, pli_bounds box, pli_vec3 motion, float margin) {
    if (plii_bounds_contain(*stored, box)) { return; }
    box = plii_bounds_grow(box, margin);
    *(motion.x > 0.0f ? &box.max.x : &box.min.x) += motion.x;
    *(motion.y > 0.0f ? &box.max.y : &box.min.y) += motion.y;
    *(motion.z > 0.0f ? &box.max.z : &box.min.z) += motion.z;
    *stored = box;
}
