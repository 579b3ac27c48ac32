/* The convex hull of points as a mesh. Recipe of btSoftBodyHelpers::CreateFromConvexHull, on a hull of our own: nodes
   are the corners of the hull in the order of the points. And an ellipsoid as such a hull. */

#include "geometry/convex_hull.h"
#include "math/bounds.h"
#include "mesh/mesh_impl.h"
#include "pliant/generate.h"

static pli_status hull_mesh_create(pli_context* context, int point_count, const pli_vec3* points,
                                   const plii_convex_hull* hull, const char* function, pli_mesh** mesh) {
    int* nodes = NULL; /* [point_count] of the corners */
    PLII_FAIL_IF(!PLII_ALLOCATE(context, &nodes, point_count), context, PLI_ERROR_OUT_OF_MEMORY, function,
                 "no memory for %d points", point_count);
    const int node_count = plii_convex_hull_corners(hull, point_count, nodes);
    const pli_status status = plii_mesh_create_reserved(context, node_count, hull->triangle_count / 2 * 3,
                                                        hull->triangle_count, 0, function, mesh);
    for (int i = 0; i < point_count && status == PLI_OK; ++i) {
        if (nodes[i] != PLI_NULL_INDEX) { plii_mesh_push_node(*mesh, points[i], 1.0f); }
    }
    for (int i = 0; i < hull->triangle_count && status == PLI_OK; ++i) {
        const int* t = hull->triangles[i];
        const int n[3] = {nodes[t[0]], nodes[t[1]], nodes[t[2]]};
        for (int k = 0; k < 3; ++k) { /* the other face of the edge runs along it in the other direction */
            if (n[k] < n[(k + 1) % 3]) { plii_mesh_push_link(*mesh, n[k], n[(k + 1) % 3]); }
        }
        plii_mesh_push_face(*mesh, n[0], n[1], n[2]);
    }
    if (status == PLI_OK) { plii_mesh_shuffle(*mesh); }
    PLII_RELEASE(context, nodes, point_count);
    return status;
}

pli_status pli_mesh_create_convex_hull(pli_context* context, int point_count, const pli_vec3* points,
                                       float tolerance_ratio, pli_mesh** mesh) {
    PLII_TRY(plii_check_create(context, mesh, "mesh", __func__));
    if (points == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "the points are null"); }
    PLII_TRY(
        plii_check_between(context, tolerance_ratio, 0.0f, 1.0f - FLT_EPSILON / 2.0f, "the tolerance ratio", __func__));
    PLII_TRY(plii_check_finite_points(context, point_count, points, "point", __func__));
    const pli_bounds bounds = plii_bounds_of_points(point_count, points);
    const float tolerance = tolerance_ratio * pli_vec3_length(pli_vec3_sub(bounds.max, bounds.min));
    plii_convex_hull hull = {0};
    PLII_TRY(plii_convex_hull_create(context, point_count, points, tolerance, __func__, &hull));
    const pli_status status = hull_mesh_create(context, point_count, points, &hull, __func__, mesh);
    plii_convex_hull_destroy(context, &hull);
    return status;
}

/* Hammersley point `i` of `count` on the unit sphere. */
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

/* As btSoftBodyHelpers::CreateEllipsoid; of points that coincide up to rounding one becomes a node. */
pli_status pli_mesh_create_ellipsoid(pli_context* context, pli_vec3 center, pli_vec3 radii, int point_count,
                                     pli_mesh** mesh) {
    PLII_TRY(plii_check_create(context, mesh, "mesh", __func__));
    PLII_TRY(plii_check_vec3_within(context, center, PLI_MAX_COORDINATE, "the center", __func__));
    PLII_TRY(plii_check_vec3_between(context, radii, PLII_ABOVE_0, PLI_MAX_COORDINATE, "radii", __func__));
    PLII_TRY(plii_check_int(context, point_count, 4, INT_MAX, "the number of points", __func__));
    pli_vec3* points = NULL;
    PLII_FAIL_IF(!PLII_ALLOCATE(context, &points, point_count), context, PLI_ERROR_OUT_OF_MEMORY, __func__,
                 "no memory for %d points", point_count);
    for (int i = 0; i < point_count; ++i) {
        points[i] = pli_vec3_add(pli_vec3_mul(ellipsoid_hammersley(i, point_count), radii), center);
    }
    const pli_status status = pli_mesh_create_convex_hull(context, point_count, points, 0.0f, mesh);
    PLII_RELEASE(context, points, point_count);
    return status;
}
