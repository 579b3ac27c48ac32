/* Flat-ended cylinder around a segment through the origin, with sharp rims. */

#include "math/range.h"
#include "shape/shape_impl.h"

typedef struct cylinder_data {
    pli_vec3 axis; /* unit */
    float half_height, radius;
    pli_vec3 side; /* unit, at a right angle to the axis: radial direction of points on it */
} cylinder_data;

static void cylinder_distances(const void* user, int count, const pli_vec3* points, float max_distance,
                               float* distances, pli_vec3* normals) {
    const cylinder_data cylinder = *(const cylinder_data*)user;
    for (int i = 0; i < count; ++i) {
        /* The distance in the half plane through the point and the axis: a rectangle. */
        const float along = pli_vec3_dot(points[i], cylinder.axis);
        const pli_vec3 across = pli_vec3_sub(points[i], pli_vec3_scale(cylinder.axis, along));
        const float squared = pli_vec3_length_squared(across);
        const float distance_to_axis = sqrtf(squared);
        const pli_vec3 radial =
            squared < PLII_SHAPE_TINY_SQUARED ? cylinder.side : plii_vec3_divide(across, distance_to_axis);
        const float to_wall = distance_to_axis - cylinder.radius;
        const float to_end = fabsf(along) - cylinder.half_height;
        const float wall = plii_max(to_wall, 0.0f), end = plii_max(to_end, 0.0f);
        const float outside_squared = wall * wall + end * end;
        const float outside = sqrtf(outside_squared);
        const bool is_outside = outside_squared >= PLII_SHAPE_TINY_SQUARED;
        const float scale = is_outside ? 1.0f / outside : 0.0f;
        const bool wall_is_nearer = to_wall >= to_end;
        const float weight_wall = is_outside ? wall * scale : wall_is_nearer ? 1.0f : 0.0f;
        const float weight_end = copysignf(is_outside ? end * scale : wall_is_nearer ? 0.0f : 1.0f, along);
        distances[i] = is_outside ? outside : plii_max(to_wall, to_end);
        normals[i] = pli_vec3_add(pli_vec3_scale(radial, weight_wall), pli_vec3_scale(cylinder.axis, weight_end));
    }
}

static pli_bounds cylinder_bounds(const void* user) {
    const cylinder_data* cylinder = user;
    const pli_vec3 u = cylinder->axis;
    /* A disc with unit normal u reaches radius * sqrt(1 - u_i^2) along axis i. */
    const pli_vec3 h = pli_vec3_make(
        fabsf(u.x) * cylinder->half_height + cylinder->radius * sqrtf(plii_max(0.0f, u.y * u.y + u.z * u.z)),
        fabsf(u.y) * cylinder->half_height + cylinder->radius * sqrtf(plii_max(0.0f, u.x * u.x + u.z * u.z)),
        fabsf(u.z) * cylinder->half_height + cylinder->radius * sqrtf(plii_max(0.0f, u.x * u.x + u.y * u.y)));
    return (pli_bounds){pli_vec3_neg(h), h};
}

static pli_vec3 cylinder_support(const void* user, pli_vec3 direction) {
    const cylinder_data* cylinder = user;
    const float along = pli_vec3_dot(direction, cylinder->axis);
    const pli_vec3 across = pli_vec3_sub(direction, pli_vec3_scale(cylinder->axis, along));
    const float length = pli_vec3_length(across);
    const pli_vec3 end = pli_vec3_scale(cylinder->axis, copysignf(cylinder->half_height, along));
    if (length * length < PLII_SHAPE_TINY_SQUARED) {
        return pli_vec3_add(end, pli_vec3_scale(cylinder->side, cylinder->radius));
    }
    return pli_vec3_add(end, pli_vec3_scale(across, cylinder->radius / length));
}

pli_status pli_shape_create_cylinder(pli_context* context, pli_vec3 half_axis, float radius, pli_shape** shape) {
    PLII_TRY(plii_check_create(context, shape, "shape", __func__));
    PLII_TRY(plii_check_vec3_within(context, half_axis, PLI_MAX_COORDINATE, "half_axis", __func__));
    PLII_TRY(plii_check_between(context, radius, PLII_ABOVE_0, PLI_MAX_COORDINATE, "radius", __func__));
    const float half_height = pli_vec3_length(half_axis);
    PLII_FAIL_IF(!(half_height * half_height >= PLII_SHAPE_TINY_SQUARED), context, PLI_ERROR_INVALID_VALUE, __func__,
                 "the length of half_axis is %g", (double)half_height);
    const pli_vec3 axis =
        pli_vec3_make(half_axis.x / half_height, half_axis.y / half_height, half_axis.z / half_height);
    const cylinder_data cylinder = {axis, half_height, radius, plii_vec3_perpendicular(axis)};
    const pli_shape_def def = {.distances = cylinder_distances, .bounds = cylinder_bounds, .support = cylinder_support};
    return plii_shape_create_owning(context, PLII_SHAPE_CYLINDER, &def, &cylinder, sizeof cylinder, __func__, shape);
}
