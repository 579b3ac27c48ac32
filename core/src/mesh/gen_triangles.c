/* A surface mesh with a link per edge. Links come in the order of btSoftBodyHelpers::CreateFromTriMesh, whose table of
   all pairs of nodes is a hash set here. */

#include "base/key_table.h"
#include "mesh/mesh_impl.h"
#include "pliant/generate.h"

static pli_status triangles_check(pli_context* context, int point_count, const pli_vec3* points, int triangle_count,
                                  const int* triangles, const char* function) {
    if (points == NULL || (triangles == NULL && triangle_count > 0)) {
        return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "the %s are null",
                         points == NULL ? "points" : "triangles");
    }
    if (point_count < 1 || triangle_count < 0) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%d points and %d triangles are no mesh",
                         point_count, triangle_count);
    }
    PLII_TRY(plii_check_finite_points(context, point_count, points, "point", function));
    for (int64_t i = 0; i < (int64_t)3 * triangle_count; ++i) {
        if (triangles[i] < 0 || triangles[i] >= point_count) {
            return plii_fail(context, PLI_ERROR_INDEX_OUT_OF_RANGE, function,
                             "triangle %d names point %d, there are %d points", (int)(i / 3), triangles[i],
                             point_count);
        }
    }
    return PLI_OK;
}

pli_status pli_mesh_create_from_triangles(pli_context* context, int point_count, const pli_vec3* points,
                                          int triangle_count, const int* triangles, bool shuffle, pli_mesh** mesh) {
    PLII_TRY(plii_check_context_change(context, __func__));
    if (mesh == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "the place for the mesh is null"); }
    PLII_TRY(triangles_check(context, point_count, points, triangle_count, triangles, __func__));
    const int64_t edges = (int64_t)3 * triangle_count;
    pli_mesh* made = NULL;
    PLII_TRY(plii_mesh_create_reserved(context, point_count, edges, triangle_count, 0, __func__, &made));
    plii_key_table known = {.context = context};
    if (!plii_key_table_reserve(&known, (size_t)edges)) {
        pli_mesh_destroy(made);
        return PLII_FAIL(context, PLI_ERROR_OUT_OF_MEMORY, "no memory for the edges of %d triangles", triangle_count);
    }
    for (int i = 0; i < point_count; ++i) {
        plii_mesh_push_node(made, points[i], 1.0f);
    }
    for (int i = 0; i < triangle_count; ++i) {
        const int* n = triangles + (ptrdiff_t)3 * i;
        for (int j = 2, k = 0; k < 3; j = k++) {
            if (n[j] == n[k] || !plii_key_table_insert(&known, plii_edge_key(n[j], n[k]))) { continue; }
            plii_mesh_push_link(made, n[j], n[k]);
        }
        if (n[0] != n[1] && n[1] != n[2] && n[2] != n[0]) { plii_mesh_push_face(made, n[0], n[1], n[2]); }
    }
    plii_key_table_free(&known);
    if (shuffle) { plii_mesh_shuffle(made); }
    *mesh = made;
    return PLI_OK;
}
