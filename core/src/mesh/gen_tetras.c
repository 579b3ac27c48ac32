/* A tetrahedral mesh with a link per edge, in the order of btSoftBodyHelpers::CreateFromTetGenData. */

#include "base/key_table.h"
#include "mesh/mesh_impl.h"
#include "pliant/generate.h"

static pli_status tetras_check(pli_context* context, int point_count, const pli_vec3* points, int tetra_count,
                               const int* tetras, const char* function) {
    if (points == NULL || (tetras == NULL && tetra_count > 0)) {
        return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "the %s are null",
                         points == NULL ? "points" : "tetras");
    }
    if (point_count < 1 || tetra_count < 0) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%d points and %d tetras are no mesh", point_count,
                         tetra_count);
    }
    PLII_TRY(plii_check_finite_points(context, point_count, points, "point", function));
    for (int i = 0; i < tetra_count; ++i) {
        const int* n = tetras + (ptrdiff_t)4 * i;
        for (int j = 0; j < 4; ++j) {
            if (n[j] < 0 || n[j] >= point_count) {
                return plii_fail(context, PLI_ERROR_INDEX_OUT_OF_RANGE, function,
                                 "tetra %d names point %d, there are %d points", i, n[j], point_count);
            }
            for (int k = 0; k < j; ++k) {
                if (n[k] == n[j]) {
                    return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "tetra %d names point %d twice", i,
                                     n[j]);
                }
            }
        }
    }
    return PLI_OK;
}

pli_status pli_mesh_create_from_tetras(pli_context* context, int point_count, const pli_vec3* points, int tetra_count,
                                       const int* tetras, pli_mesh** mesh) {
    static const int edge_ends[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
    PLII_TRY(plii_check_context_change(context, __func__));
    if (mesh == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "the place for the mesh is null"); }
    PLII_TRY(tetras_check(context, point_count, points, tetra_count, tetras, __func__));
    const int64_t edges = (int64_t)6 * tetra_count;
    pli_mesh* made = NULL;
    PLII_TRY(plii_mesh_create_reserved(context, point_count, edges, 0, tetra_count, __func__, &made));
    plii_key_table known = {.context = context};
    if (!plii_key_table_reserve(&known, (size_t)edges)) {
        pli_mesh_destroy(made);
        return PLII_FAIL(context, PLI_ERROR_OUT_OF_MEMORY, "no memory for the edges of %d tetras", tetra_count);
    }
    for (int i = 0; i < point_count; ++i) {
        plii_mesh_push_node(made, points[i], 1.0f);
    }
    for (int i = 0; i < tetra_count; ++i) {
        const int* n = tetras + (ptrdiff_t)4 * i;
        plii_mesh_push_tetra(made, n[0], n[1], n[2], n[3]);
        for (int k = 0; k < 6; ++k) {
            const int a = n[edge_ends[k][0]], b = n[edge_ends[k][1]];
            if (plii_key_table_insert(&known, plii_edge_key(a, b))) { plii_mesh_push_link(made, a, b); }
        }
    }
    plii_key_table_free(&known);
    *mesh = made;
    return PLI_OK;
}
