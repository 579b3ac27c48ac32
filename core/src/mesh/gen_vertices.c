/* A mesh from a renderer's vertices, of which several are at a place where textures end: they become one node. */

#include "geometry/triangle_soup.h"
#include "mesh/mesh_impl.h"
#include "pliant/generate.h"

static pli_status vertices_check(pli_context* context, int vertex_count, const pli_vec3* vertices, int triangle_count,
                                 const int* triangles, const int* vertex_nodes, const char* function) {
    PLII_FAIL_IF(vertices == NULL, context, PLI_ERROR_NULL_ARGUMENT, function, "vertices is null");
    PLII_FAIL_IF(vertex_nodes == NULL, context, PLI_ERROR_NULL_ARGUMENT, function, "vertex_nodes is null");
    PLII_FAIL_IF(triangles == NULL && triangle_count > 0, context, PLI_ERROR_NULL_ARGUMENT, function,
                 "triangles is null");
    PLII_FAIL_IF(vertex_count < 1 || triangle_count < 0, context, PLI_ERROR_INVALID_VALUE, function,
                 "%d vertices and %d triangles are no mesh", vertex_count, triangle_count);
    for (ptrdiff_t i = 0; i < (ptrdiff_t)3 * triangle_count; ++i) {
        PLII_FAIL_IF(triangles[i] < 0 || triangles[i] >= vertex_count, context, PLI_ERROR_INDEX_OUT_OF_RANGE, function,
                     "triangle %d names vertex %d, there are %d vertices", (int)(i / 3), triangles[i], vertex_count);
    }
    return plii_check_finite_points(context, vertex_count, vertices, "vertex", function);
}

pli_status pli_mesh_create_from_vertices(pli_context* context, int vertex_count, const pli_vec3* vertices,
                                         int triangle_count, const int* triangles, int* vertex_nodes, pli_mesh** mesh) {
    PLII_TRY(plii_check_create(context, mesh, "mesh", __func__));
    PLII_TRY(vertices_check(context, vertex_count, vertices, triangle_count, triangles, vertex_nodes, __func__));
    const size_t corner_count = 3 * (size_t)triangle_count;
    plii_scratch scratch = {.context = context};
    int *nodes = PLII_TAKE(&scratch, int, vertex_count), *corners = PLII_TAKE(&scratch, int, corner_count);
    pli_vec3* points = PLII_TAKE(&scratch, pli_vec3, vertex_count);
    const int point_count =
        scratch.is_short ? PLI_NULL_INDEX : plii_weld_points(context, vertex_count, vertices, nodes);
    pli_status status = PLI_OK;
    if (point_count == PLI_NULL_INDEX) {
        status = PLII_FAIL(context, PLI_ERROR_OUT_OF_MEMORY, "no memory for the places of %d vertices", vertex_count);
    } else {
        for (int i = 0; i < vertex_count; ++i) {
            points[nodes[i]] = pli_vec3_add(vertices[i], pli_vec3_make(0, 0, 0)); /* -0 is 0 */
        }
        for (size_t i = 0; i < corner_count; ++i) {
            corners[i] = nodes[triangles[i]];
        }
        status = pli_mesh_create_from_triangles(context, point_count, points, triangle_count, corners, false, mesh);
    }
    if (status == PLI_OK) { memcpy(vertex_nodes, nodes, (size_t)vertex_count * sizeof *nodes); }
    plii_scratch_free(&scratch);
    return status;
}
