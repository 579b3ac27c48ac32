/* Half space dot(normal, p) <= offset. */

#include "math/range.h"
#include "shape/shape_impl.h"

typedef struct plane_data {
    pli_vec3 normal; /* unit */
    float offset;
} plane_data;

static void plane_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                            pli_vec3* normals) {
    const plane_data* plane = user;
    for (int i = 0; i < count; ++i) {
        distances[i] = pli_vec3_dot(plane->normal, points[i]) - plane->offset;
        normals[i] = plane->normal;
    }
}

/* Infinite, but for the one side of a plane at right angles to an axis. */
static pli_bounds plane_bounds(const void* user) {
    const plane_data* plane = user;
    const pli_vec3 n = plane->normal;
    pli_bounds bounds = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
    if (n.x == 1.0f) { bounds.max.x = plane->offset; }
    if (n.y == 1.0f) { bounds.max.y = plane->offset; }
    if (n.z == 1.0f) { bounds.max.z = plane->offset; }
    if (n.x == -1.0f) { bounds.min.x = -plane->offset; }
    if (n.y == -1.0f) { bounds.min.y = -plane->offset; }
    if (n.z == -1.0f) { bounds.min.z = -plane->offset; }
    return bounds;
}

pli_status pli_shape_create_plane(pli_context* context, pli_vec3 normal, float offset, pli_shape** shape) {
    PLII_TRY(plii_check_create(context, shape, "shape", __func__));
    PLII_FAIL_IF(!plii_vec3_is_finite(normal) || !plii_is_finite(offset), context, PLI_ERROR_NOT_FINITE, __func__,
                 "normal or offset is not finite");
    const float length = pli_vec3_length(normal);
    PLII_FAIL_IF(!(length * length > PLII_SHAPE_TINY_SQUARED) || !plii_is_finite(length), context,
                 PLI_ERROR_INVALID_VALUE, __func__, "the length of normal is %g", (double)length);
    PLII_TRY(plii_check_between(context, offset, -PLI_MAX_COORDINATE, PLI_MAX_COORDINATE, "offset", __func__));
    const plane_data plane = {pli_vec3_make(normal.x / length, normal.y / length, normal.z / length), offset};
    const pli_shape_def def = {.distances = plane_distances, .bounds = plane_bounds};
    return plii_shape_create_owning(context, PLII_SHAPE_PLANE, &def, &plane, sizeof plane, __func__, shape);
}
