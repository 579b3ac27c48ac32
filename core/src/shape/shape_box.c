/* Box around the origin, with sharp edges. */

#include "math/range.h"
#include "math/simd_float4.h"
#include "shape/shape_impl.h"

/* The data of a box is a pli_vec3: its half extents. */

static plii_float4 box_distances_of_four(plii_vec3x4 h, plii_vec3x4 p, plii_vec3x4* normals) {
    const plii_float4 zero = plii_float4_all(0.0f), one = plii_float4_all(1.0f);
    const plii_vec3x4 size = {plii_lanes_with_sign(p.x, zero), plii_lanes_with_sign(p.y, zero),
                              plii_lanes_with_sign(p.z, zero)};
    const plii_vec3x4 q = plii_vec3x4_sub(size, h);
    const plii_vec3x4 m = {plii_lanes_max(q.x, zero), plii_lanes_max(q.y, zero), plii_lanes_max(q.z, zero)};
    const plii_float4 squared = plii_vec3x4_dot(m, m), length = plii_float4_sqrt(squared);
    const plii_mask4 is_outside = plii_float4_all(PLII_SHAPE_TINY_SQUARED) <= squared;
    const plii_vec3x4 outward = plii_vec3x4_scale(m, one / length);
    const plii_mask4 on_x = (q.y <= q.x) & (q.z <= q.x);
    const plii_mask4 y_before_z = q.z <= q.y;
    const plii_vec3x4 side = {plii_lanes_select(on_x, one, zero),
                              plii_lanes_select(on_x, zero, plii_lanes_select(y_before_z, one, zero)),
                              plii_lanes_select(on_x, zero, plii_lanes_select(y_before_z, zero, one))};
    const plii_vec3x4 normal = plii_vec3x4_select(is_outside, outward, side);
    *normals = (plii_vec3x4){plii_lanes_with_sign(normal.x, p.x), plii_lanes_with_sign(normal.y, p.y),
                             plii_lanes_with_sign(normal.z, p.z)};
    const plii_float4 inside = plii_lanes_select(on_x, q.x, plii_lanes_select(y_before_z, q.y, q.z));
    return plii_lanes_select(is_outside, length, inside);
}

/* Outside: to the nearest point of the box. Inside: to the nearest side; between equally near ones x goes before y
   before z, and at coordinate 0 it is the positive one. */
static void box_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                          pli_vec3* normals) {
    const plii_vec3x4 h = plii_vec3x4_all(*(const pli_vec3*)user);
    plii_vec3x4 found;
    int i = 0;
    for (; i + PLII_LANES <= count; i += PLII_LANES) {
        plii_float4_store(&distances[i], box_distances_of_four(h, plii_vec3x4_from(&points[i]), &found));
        plii_vec3x4_to(&normals[i], found);
    }
    if (i == count) { return; }
    pli_vec3 last_normals[PLII_LANES];
    float last_distances[PLII_LANES];
    const pli_vec3 *a = &points[i], *b = &points[i + 1 < count ? i + 1 : i], *c = &points[i + 2 < count ? i + 2 : i];
    const plii_vec3x4 last = {plii_lanes_xyzw(a->x, b->x, c->x, a->x), plii_lanes_xyzw(a->y, b->y, c->y, a->y),
                              plii_lanes_xyzw(a->z, b->z, c->z, a->z)};
    plii_float4_store(last_distances, box_distances_of_four(h, last, &found));
    plii_vec3x4_to(last_normals, found);
    for (int k = 0; i + k < count; ++k) {
        distances[i + k] = last_distances[k];
        normals[i + k] = last_normals[k];
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
    PLII_TRY(plii_shape_check_create(context, shape, __func__));
    PLII_TRY(
        plii_check_vec3_between(context, half_extents, PLII_ABOVE_0, PLI_MAX_COORDINATE, "half_extents", __func__));
    const pli_shape_def def = {.distances = box_distances, .bounds = box_bounds, .support = box_support};
    return plii_shape_create_kind(context, PLII_SHAPE_BOX, &def, &half_extents, sizeof half_extents, __func__, shape);
}
