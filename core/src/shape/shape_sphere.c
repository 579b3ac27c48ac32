/* Sphere around the origin. */

#include "math/range.h"
#include "shape/shape_impl.h"

/* The data of a sphere is a float: its radius. At the very centre all directions are as good; it is +y there. */
static void sphere_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                             pli_vec3* normals) {
    const float radius = *(const float*)user;
    for (int i = 0; i < count; ++i) {
        const pli_vec3 p = points[i];
        const float squared = pli_vec3_length_squared(p);
        const bool is_centre = squared < PLII_SHAPE_TINY_SQUARED;
        const float length = sqrtf(squared);
        const float inverse = is_centre ? 0.0f : 1.0f / length;
        distances[i] = length - radius;
        normals[i] = pli_vec3_make(p.x * inverse, is_centre ? 1.0f : p.y * inverse, p.z * inverse);
    }
}

static pli_bounds sphere_bounds(const void* user) {
    const float r = *(const float*)user;
    return (pli_bounds){{-r, -r, -r}, {r, r, r}};
}
static pli_vec3 sphere_support(const void* user, pli_vec3 direction) {
    return pli_vec3_make(0, 0, 0);
}

pli_status pli_shape_create_sphere(pli_context* context, float radius, pli_shape** shape) {
    PLII_TRY(plii_check_create(context, shape, "shape", __func__));
    PLII_TRY(plii_check_between(context, radius, PLII_ABOVE_0, PLI_MAX_COORDINATE, "radius", __func__));
    const pli_shape_def def = {
        .distances = sphere_distances, .bounds = sphere_bounds, .support = sphere_support, .radius = radius};
    return plii_shape_create_owning(context, PLII_SHAPE_SPHERE, &def, &radius, sizeof radius, __func__, shape);
}
