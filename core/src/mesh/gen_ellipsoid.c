/* A closed surface over Hammersley points on an ellipsoid, the points of btSoftBodyHelpers::CreateEllipsoid. All
   points become nodes, in their order; only what coincides up to rounding is left out. */

#include "mesh/mesh_impl.h"
#include "pliant/generate.h"

/* Point `i` of `count` on the unit sphere. */
static pli_vec3 ellipsoid_hammersley(int i, int count) {
    const float pi = 3.1415926535897932384626433832795029f;
    float digit = 0.5f, fraction = 0.0f; /* the binary digits of i, mirrored at the point */
    for (int rest = i; rest != 0; rest >>= 1) {
        if ((rest & 1) != 0) { fraction += digit; }
        digit *= 0.5f;
    }
    const float height = 2.0f * fraction - 1.0f;
    const float angle = (pi + (float)(2 * (int64_t)i) * pi) / (float)count;
    const float radius = sqrtf(1.0f - height * height);
    return pli_vec3_make(radius * cosf(angle), radius * sinf(angle), height);
}

pli_status pli_mesh_create_ellipsoid(pli_context* context, pli_vec3 center, pli_vec3 radii, int point_count,
                                     pli_mesh** mesh) {
    PLII_TRY(plii_check_mesh_create(context, mesh, __func__));
    PLII_TRY(plii_check_vec3_within(context, center, PLI_MAX_COORDINATE, "the center", __func__));
    PLII_TRY(plii_check_vec3_between(context, radii, PLII_ABOVE_0, PLI_MAX_COORDINATE, "radii", __func__));
    if (point_count < 4) {
        return PLII_FAIL(context, PLI_ERROR_INVALID_VALUE, "%d points, it must be 4 or more", point_count);
    }
    pli_vec3* points = plii_allocate(context, (size_t)point_count * sizeof *points);
    if (points == NULL) { return PLII_FAIL(context, PLI_ERROR_OUT_OF_MEMORY, "no memory for %d points", point_count); }
    for (int i = 0; i < point_count; ++i) {
        points[i] = pli_vec3_add(pli_vec3_mul(ellipsoid_hammersley(i, point_count), radii), center);
    }
    const pli_status status = pli_mesh_create_convex_hull(context, point_count, points, 0.0f, mesh);
    PLII_RELEASE(context, points, point_count);
    return status;
}
