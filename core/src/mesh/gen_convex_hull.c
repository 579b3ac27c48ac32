/* The convex hull of points as a mesh. Recipe of btSoftBodyHelpers::CreateFromConvexHull, on a hull of our own: nodes
   are the corners of the hull in the order of the points. */

#include "geometry/convex_hull.h"
#include "mesh/mesh_impl.h"
#include "pliant/generate.h"

/* Nodes for the points that `place` marks, and the index of each. */
static void hull_mesh_push_nodes(pli_mesh* mesh, int point_count, const pli_vec3* points, int* place) {
    for (int i = 0; i < point_count; ++i) {
        if (place[i] == 0) { continue; }
        place[i] = mesh->node_count;
        plii_mesh_push_node(mesh, points[i], 1.0f);
    }
}

static pli_status hull_mesh_create(pli_context* context, int point_count, const pli_vec3* points,
                                   const plii_convex_hull* hull, const char* function, pli_mesh** mesh) {
    const size_t place_size = (size_t)point_count * sizeof(int);
    int* place = plii_allocate(context, place_size);
    if (place == NULL) {
        return plii_fail(context, PLI_ERROR_OUT_OF_MEMORY, function, "no memory for %d points", point_count);
    }
    int node_count = 0;
    for (int i = 0; i < hull->triangle_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            node_count += place[hull->triangles[i][k]] == 0;
            place[hull->triangles[i][k]] = 1;
        }
    }
    const pli_status status = plii_mesh_create_reserved(context, node_count, hull->triangle_count / 2 * 3,
                                                        hull->triangle_count, 0, function, mesh);
    if (status == PLI_OK) {
        hull_mesh_push_nodes(*mesh, point_count, points, place);
        for (int i = 0; i < hull->triangle_count; ++i) {
            const int* t = hull->triangles[i];
            const int n[3] = {place[t[0]], place[t[1]], place[t[2]]};
            for (int k = 0; k < 3; ++k) { /* the other face of the edge runs along it in the other direction */
                if (n[k] < n[(k + 1) % 3]) { plii_mesh_push_link(*mesh, n[k], n[(k + 1) % 3]); }
            }
            plii_mesh_push_face(*mesh, n[0], n[1], n[2]);
        }
        plii_mesh_shuffle(*mesh);
    }
    plii_release(context, place, place_size);
    return status;
}

pli_status pli_mesh_create_convex_hull(pli_context* context, int point_count, const pli_vec3* points,
                                       float tolerance_ratio, pli_mesh** mesh) {
    PLII_TRY(plii_check_context_change(context, __func__));
    if (points == NULL || mesh == NULL) {
        return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "the %s null",
                         points == NULL ? "points are" : "place for the mesh is");
    }
    PLII_TRY(
        plii_check_between(context, tolerance_ratio, 0.0f, 1.0f - FLT_EPSILON / 2.0f, "the tolerance ratio", __func__));
    PLII_TRY(plii_check_finite_points(context, point_count, points, "point", __func__));
    float tolerance = 0.0f;
    if (point_count > 0) {
        pli_bounds bounds = {points[0], points[0]};
        for (int i = 1; i < point_count; ++i) {
            bounds.min = plii_vec3_min(bounds.min, points[i]);
            bounds.max = plii_vec3_max(bounds.max, points[i]);
        }
        tolerance = tolerance_ratio * pli_vec3_length(pli_vec3_sub(bounds.max, bounds.min));
    }
    plii_convex_hull hull = {0};
    PLII_TRY(plii_convex_hull_create(context, point_count, points, tolerance, __func__, &hull));
    const pli_status status = hull_mesh_create(context, point_count, points, &hull, __func__, mesh);
    plii_convex_hull_destroy(context, &hull);
    return status;
}
