/* Box around the origin, with sharp edges. */

#include "shape_impl.h"

typedef struct box_data {
    pli_vec3 half_extents;
} box_data;

/* Outside: to the nearest point of the box. Inside: to the nearest side; between equally near ones x goes before y
   before z, and at coordinate 0 the positive side is taken. */
static void box_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                          pli_vec3* normals) {
    const pli_vec3 h = ((const box_data*)user)->half_extents;
    (void)max_distance;
    for (int i = 0; i < count; ++i) {
        const pli_vec3 p = points[i];
        const pli_vec3 q = pli_vec3_make(fabsf(p.x) - h.x, fabsf(p.y) - h.y, fabsf(p.z) - h.z);
        const pli_vec3 m = pli_vec3_make(plii_max(q.x, 0.0f), plii_max(q.y, 0.0f), plii_max(q.z, 0.0f));
        const float squared = pli_vec3_length_squared(m);
        const float length = sqrtf(squared);
        const bool is_outside = squared >= PLII_SHAPE_TINY_SQUARED;
        const float inverse = is_outside ? 1.0f / length : 0.0f;
        const bool on_x = q.x >= q.y && q.x >= q.z;
        const bool on_y = !on_x && q.y >= q.z;
        const bool on_z = !on_x && !on_y;
        const float inside = on_x ? q.x : on_y ? q.y : q.z;
        distances[i] = is_outside ? length : inside;
        normals[i].x = copysignf(is_outside ? m.x * inverse : on_x ? 1.0f : 0.0f, p.x);
        normals[i].y = copysignf(is_outside ? m.y * inverse : on_y ? 1.0f : 0.0f, p.y);
        normals[i].z = copysignf(is_outside ? m.z * inverse : on_z ? 1.0f : 0.0f, p.z);
    }
}

static pli_bounds box_bounds(const void* user) {
    const pli_vec3 h = ((const box_data*)user)->half_extents;
    const pli_bounds bounds = {pli_vec3_neg(h), h};
    return bounds;
}

static pli_vec3 box_support(const void* user, pli_vec3 direction) {
    const pli_vec3 h = ((const box_data*)user)->half_extents;
    return pli_vec3_make(copysignf(h.x, direction.x), copysignf(h.y, direction.y), copysignf(h.z, direction.z));
}

pli_status pli_shape_create_box(pli_context* context, pli_vec3 half_extents, pli_shape** shape) {
    PLII_TRY(plii_shape_check_create(context, shape, __func__));
    if (!plii_vec3_is_finite(half_extents)) {
        return PLII_FAIL(context, PLI_ERROR_NOT_FINITE, "half_extents is not finite");
    }
    if (!(half_extents.x > 0.0f && half_extents.y > 0.0f && half_extents.z > 0.0f)) {
        return PLII_FAIL(context, PLI_ERROR_INVALID_VALUE, "half_extents is (%g, %g, %g), all must be above 0",
                         (double)half_extents.x, (double)half_extents.y, (double)half_extents.z);
    }
    const box_data box = {half_extents};
    pli_shape_def def = pli_shape_def_default();
    def.distances = box_distances;
    def.bounds = box_bounds;
    def.support = box_support;
    return plii_shape_create_owning(context, &def, &box, sizeof box, __func__, shape);
}
