/* Meshes from lists of triangles or tetrahedra, with a link per edge, in the order of
   btSoftBodyHelpers::CreateFromTriMesh and CreateFromTetGenData. Of a renderer's vertices several are at a place where
   textures end: they become one node. */

#include "base/key_table.h"
#include "geometry/triangle_soup.h"
#include "mesh/mesh_impl.h"
#include "pliant/generate.h"

/* Elements of three or four corners: `name` is "triangle" or "tetra", what they join "point" or "vertex". */
typedef struct element_list {
    const char *name, *point, *points;
    int corner_count, edge_count, count;
    const int* corners; /* [corner_count * count] points */
} element_list;

/* A tetrahedron with a point twice is an error; of such a triangle only the links are made. */
static pli_status elements_check(pli_context* context, const element_list* list, int point_count,
                                 const pli_vec3* points, const char* function) {
    PLII_FAIL_IF(points == NULL || (list->corners == NULL && list->count > 0), context, PLI_ERROR_NULL_ARGUMENT,
                 function, "the list of %ss is null", points == NULL ? list->point : list->name);
    PLII_FAIL_IF(point_count < 1 || list->count < 0, context, PLI_ERROR_INVALID_VALUE, function,
                 "%d %s and %d %ss are no mesh", point_count, list->points, list->count, list->name);
    PLII_TRY(plii_check_finite_points(context, point_count, points, list->point, function));
    for (int i = 0; i < list->count; ++i) {
        const int* n = list->corners + (ptrdiff_t)list->corner_count * i;
        for (int j = 0; j < list->corner_count; ++j) {
            PLII_FAIL_IF(n[j] < 0 || n[j] >= point_count, context, PLI_ERROR_INDEX_OUT_OF_RANGE, function,
                         "%s %d names %s %d, there are %d %s", list->name, i, list->point, n[j], point_count,
                         list->points);
            for (int k = 0; k < j && list->corner_count == 4; ++k) {
                PLII_FAIL_IF(n[k] == n[j], context, PLI_ERROR_INVALID_VALUE, function, "%s %d names point %d twice",
                             list->name, i, n[j]);
            }
        }
    }
    return PLI_OK;
}

static void elements_push(pli_mesh* mesh, const element_list* list, plii_key_table* edges) {
    static const int edge_ends[2][6][2] = {{{2, 0}, {0, 1}, {1, 2}}, {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
    for (int i = 0; i < list->count; ++i) {
        const int* n = list->corners + (ptrdiff_t)list->corner_count * i;
        for (int k = 0; k < list->edge_count; ++k) {
            const int *ends = edge_ends[list->corner_count - 3][k], a = n[ends[0]], b = n[ends[1]];
            if (a == b || plii_key_table_add(edges, plii_edge_key(a, b), mesh->link_count) != mesh->link_count) {
                continue;
            }
            plii_mesh_push_link(mesh, a, b);
        }
        if (list->corner_count == 4) {
            plii_mesh_push_tetra(mesh, n[0], n[1], n[2], n[3]);
        } else if (n[0] != n[1] && n[1] != n[2] && n[2] != n[0]) {
            plii_mesh_push_face(mesh, n[0], n[1], n[2]);
        }
    }
}

static pli_status elements_create(pli_context* context, const element_list* list, int point_count,
                                  const pli_vec3* points, const char* function, pli_mesh** mesh) {
    PLII_TRY(plii_check_create(context, mesh, "mesh", function));
    PLII_TRY(elements_check(context, list, point_count, points, function));
    const int64_t edge_count = (int64_t)list->edge_count * list->count;
    const bool are_tetras = list->corner_count == 4;
    pli_mesh* made = NULL;
    PLII_TRY(plii_mesh_create_reserved(context, point_count, edge_count, are_tetras ? 0 : list->count,
                                       are_tetras ? list->count : 0, function, &made));
    plii_key_table edges = {.context = context};
    if (edge_count > INT32_MAX || !plii_key_table_reserve(&edges, (int)edge_count)) {
        pli_mesh_destroy(made);
        return plii_fail(context, PLI_ERROR_OUT_OF_MEMORY, function, "no memory for the edges of %d %ss", list->count,
                         list->name);
    }
    for (int i = 0; i < point_count; ++i) {
        plii_mesh_push_node(made, points[i], 1.0f);
    }
    elements_push(made, list, &edges);
    plii_key_table_free(&edges);
    *mesh = made;
    return PLI_OK;
}

pli_status pli_mesh_create_from_triangles(pli_context* context, int point_count, const pli_vec3* points,
                                          int triangle_count, const int* triangles, bool shuffle, pli_mesh** mesh) {
    const element_list list = {"triangle", "point", "points", 3, 3, triangle_count, triangles};
    PLII_TRY(elements_create(context, &list, point_count, points, __func__, mesh));
    if (shuffle) { plii_mesh_shuffle(*mesh); }
    return PLI_OK;
}

pli_status pli_mesh_create_from_vertices(pli_context* context, int vertex_count, const pli_vec3* vertices,
                                         int triangle_count, const int* triangles, int* vertex_nodes, pli_mesh** mesh) {
    PLII_TRY(plii_check_create(context, mesh, "mesh", __func__));
    PLII_FAIL_IF(vertex_nodes == NULL, context, PLI_ERROR_NULL_ARGUMENT, __func__, "vertex_nodes is null");
    const element_list list = {"triangle", "vertex", "vertices", 3, 3, triangle_count, triangles};
    PLII_TRY(elements_check(context, &list, vertex_count, vertices, __func__));
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

pli_status pli_mesh_create_from_tetras(pli_context* context, int point_count, const pli_vec3* points, int tetra_count,
                                       const int* tetras, pli_mesh** mesh) {
    const element_list list = {"tetra", "point", "points", 4, 6, tetra_count, tetras};
    return elements_create(context, &list, point_count, points, __func__, mesh);
}
