/* Box around the origin, with sharp edges. */

#include "math/range.h"
#include "math/simd_float4.h"
#include "shape/shape_impl.h"

/* The data of a box is a pli_vec3: its half extents. */

typedef struct box_nearest {
    plii_float4 distance;
    plii_vec3x4 normal;
} box_nearest;

/* Outside: to the nearest point of the box. Inside: to the nearest side; between equally near ones x goes before y
   before z, and at coordinate 0 it is the positive one. */
static inline box_nearest box_nearest_of_four(plii_vec3x4 h, plii_vec3x4 p) {
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    const plii_vec3x4 q = {plii_lanes_abs(p.x) - h.x, plii_lanes_abs(p.y) - h.y, plii_lanes_abs(p.z) - h.z};
    const plii_vec3x4 m = {plii_lanes_max(q.x, zero), plii_lanes_max(q.y, zero), plii_lanes_max(q.z, zero)};
    const plii_float4 squared = plii_vec3x4_dot(m, m), length = plii_float4_sqrt(squared);
    const plii_mask4 is_outside = squared >= PLII_SHAPE_TINY_SQUARED;
    const plii_mask4 is_x = (q.x >= q.y) & (q.x >= q.z), is_y = ~is_x & (q.y >= q.z);
    const plii_float4 to_side = plii_lanes_select(is_x, q.x, plii_lanes_select(is_y, q.y, q.z));
    const plii_vec3x4 side = {plii_lanes_where(is_x, one), plii_lanes_where(is_y, one),
                              plii_lanes_where(~(is_x | is_y), one)};
    const plii_vec3x4 n = plii_vec3x4_select(is_outside, plii_vec3x4_scale(m, 1.0f / length), side);
    return (box_nearest){
        plii_lanes_select(is_outside, length, to_side),
        {plii_lanes_copy_sign(n.x, p.x), plii_lanes_copy_sign(n.y, p.y), plii_lanes_copy_sign(n.z, p.z)}};
}

static void box_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                          pli_vec3* normals) {
    const plii_vec3x4 h = plii_vec3x4_all(*(const pli_vec3*)user);
    for (int i = 0; i < count && count >= PLII_LANES; i += PLII_LANES) {
        const int first = i <= count - PLII_LANES ? i : count - PLII_LANES; /* the last four may meet those before */
        const box_nearest nearest = box_nearest_of_four(h, plii_vec3x4_from(&points[first]));
        plii_float4_store(&distances[first], nearest.distance);
        plii_vec3x4_to(&normals[first], nearest.normal);
    }
    for (int i = 0; i < count && count < PLII_LANES; ++i) {
        const box_nearest nearest = box_nearest_of_four(h, plii_vec3x4_all(points[i]));
        distances[i] = nearest.distance[0];
        normals[i] = plii_vec3x4_first(nearest.normal);
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
