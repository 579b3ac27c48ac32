/* Capsule: all points within a radius of a segment through the origin. */

#include "math/range.h"
#include "shape/shape_impl.h"

typedef struct capsule_data {
    pli_vec3 half_segment;
    float inverse_squared; /* 1 / |half_segment|^2, 0 for a segment of no length (a sphere) */
    float radius;
    pli_vec3 side; /* unit, at a right angle to the segment: normal of points on it */
} capsule_data;

static void capsule_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                              pli_vec3* normals) {
    const capsule_data capsule = *(const capsule_data*)user;
    for (int i = 0; i < count; ++i) {
        const float along = pli_vec3_dot(points[i], capsule.half_segment) * capsule.inverse_squared;
        const float clamped = plii_clamp(along, -1.0f, 1.0f);
        const pli_vec3 r = pli_vec3_sub(points[i], pli_vec3_scale(capsule.half_segment, clamped));
        const float squared = pli_vec3_length_squared(r), length = sqrtf(squared);
        distances[i] = length - capsule.radius;
        normals[i] = squared < PLII_SHAPE_TINY_SQUARED ? capsule.side : plii_vec3_divide(r, length);
    }
}

static pli_bounds capsule_bounds(const void* user) {
    const capsule_data* capsule = user;
    const pli_vec3 a = capsule->half_segment;
    const pli_vec3 h =
        pli_vec3_make(fabsf(a.x) + capsule->radius, fabsf(a.y) + capsule->radius, fabsf(a.z) + capsule->radius);
    return (pli_bounds){pli_vec3_neg(h), h};
}

static pli_vec3 capsule_support(const void* user, pli_vec3 direction) {
    const capsule_data* capsule = user;
    return pli_vec3_dot(direction, capsule->half_segment) < 0.0f ? pli_vec3_neg(capsule->half_segment)
                                                                 : capsule->half_segment;
}

pli_status pli_shape_create_capsule(pli_context* context, pli_vec3 half_segment, float radius, pli_shape** shape) {
    PLII_TRY(plii_check_create(context, shape, "shape", __func__));
    PLII_TRY(plii_check_vec3_within(context, half_segment, PLI_MAX_COORDINATE, "half_segment", __func__));
    PLII_TRY(plii_check_between(context, radius, PLII_ABOVE_0, PLI_MAX_COORDINATE, "radius", __func__));
    const float squared = pli_vec3_length_squared(half_segment);
    capsule_data capsule = {half_segment, 0.0f, radius, {1, 0, 0}};
    if (squared >= PLII_SHAPE_TINY_SQUARED) {
        capsule.inverse_squared = 1.0f / squared;
        capsule.side = plii_vec3_perpendicular(plii_vec3_safe_normalize(half_segment));
    }
    const pli_shape_def def = {
        .distances = capsule_distances, .bounds = capsule_bounds, .support = capsule_support, .radius = radius};
    return plii_shape_create_owning(context, PLII_SHAPE_CAPSULE, &def, &capsule, sizeof capsule, __func__, shape);
}
