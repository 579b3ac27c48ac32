/* Box around the origin, with sharp edges. */

#include "math/range.h"
#include "shape/shape_impl.h"

/* The data of a box is a pli_vec3: its half extents. */

/* Outside: to the nearest point of the box. Inside: to the nearest side; between equally near ones x goes before y
   before z, and at coordinate 0 it is the positive one. */
static void box_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                          pli_vec3* normals) {
    const pli_vec3 h = *(const pli_vec3*)user;
    for (int i = 0; i < count; ++i) {
        const pli_vec3 p = points[i];
        const pli_vec3 q = pli_vec3_make(fabsf(p.x) - h.x, fabsf(p.y) - h.y, fabsf(p.z) - h.z);
        const pli_vec3 m = plii_vec3_max(q, pli_vec3_make(0, 0, 0));
        const float squared = pli_vec3_length_squared(m);
        pli_vec3 normal;
        if (squared >= PLII_SHAPE_TINY_SQUARED) {
            distances[i] = sqrtf(squared);
            normal = plii_vec3_divide(m, distances[i]);
        } else {
            const bool is_x = q.x >= q.y && q.x >= q.z, is_y = !is_x && q.y >= q.z;
            distances[i] = is_x ? q.x : is_y ? q.y : q.z;
            normal = pli_vec3_make(is_x, is_y, !is_x && !is_y);
        }
        normals[i] = pli_vec3_make(copysignf(normal.x, p.x), copysignf(normal.y, p.y), copysignf(normal.z, p.z));
    }
}

static pli_bounds box_bounds(const void* user) {
    const pli_vec3 h = *(const pli_vec3*)user;
    return (pli_bounds){pli_vec3_neg(h), h};
}
static pli_vec3 box_support(const void* user, pli_vec3 direction) {
    const pli_vec3 h = *(const pli_vec3*)user;
    return pli_vec3_make(copysignf(h.x, direction.x), copysignf(h.y, direction.y), copysignf(h.z, direction.z));
}

pli_status pli_shape_create_box(pli_context* context, pli_vec3 half_extents, pli_shape** shape) {
    PLII_TRY(plii_check_create(context, shape, "shape", __func__));
    PLII_TRY(
        plii_check_vec3_between(context, half_extents, PLII_ABOVE_0, PLI_MAX_COORDINATE, "half_extents", __func__));
    const pli_shape_def def = {.distances = box_distances, .bounds = box_bounds, .support = box_support};
    return plii_shape_create_owning(context, PLII_SHAPE_BOX, &def, &half_extents, sizeof half_extents, __func__, shape);
}
