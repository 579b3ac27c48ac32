/* A mesh from a renderer's vertices, which are there more than once where textures or normals end: vertices at the same
   place become one node. */

#include "base/context.h"
#include "mesh/mesh_impl.h"
#include "pliant/generate.h"

#include <string.h>

/* An open table of nodes by their place, at most half full. */
typedef struct place_table {
    int* nodes; /* -1: free */
    size_t capacity;
} place_table;

static size_t place_hash(pli_vec3 p) {
    uint32_t words[3];
    memcpy(words, &p, sizeof words);
    uint64_t hash = 0x9e3779b97f4a7c15u;
    for (int i = 0; i < 3; ++i) {
        hash = (hash ^ words[i]) * 0xff51afd7ed558ccdu;
        hash ^= hash >> 32;
    }
    return (size_t)hash;
}

/* The slot of a node at this place, or the free one where it belongs. */
static int* place_find(const place_table* table, const pli_vec3* points, pli_vec3 p) {
    size_t slot = place_hash(p) & (table->capacity - 1);
    while (table->nodes[slot] >= 0) {
        const pli_vec3 q = points[table->nodes[slot]];
        if (q.x == p.x && q.y == p.y && q.z == p.z) { break; }
        slot = (slot + 1) & (table->capacity - 1);
    }
    return &table->nodes[slot];
}

/* Numbers the places in the order of the vertices; the number of them. */
static int vertices_merge(place_table* table, int count, const pli_vec3* vertices, pli_vec3* points, int* nodes) {
    int point_count = 0;
    for (int i = 0; i < count; ++i) {
        const pli_vec3 p = {vertices[i].x + 0.0f, vertices[i].y + 0.0f, vertices[i].z + 0.0f}; /* -0 is 0 */
        int* slot = place_find(table, points, p);
        if (*slot < 0) {
            *slot = point_count;
            points[point_count++] = p;
        }
        nodes[i] = *slot;
    }
    return point_count;
}

static pli_status vertices_check(pli_context* context, int vertex_count, const pli_vec3* vertices, int triangle_count,
                                 const int* triangles, const int* vertex_nodes, const char* function) {
    if (vertices == NULL || vertex_nodes == NULL || (triangles == NULL && triangle_count > 0)) {
        return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "%s is null",
                         vertices == NULL       ? "vertices"
                         : vertex_nodes == NULL ? "vertex_nodes"
                                                : "triangles");
    }
    if (vertex_count < 1 || triangle_count < 0) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%d vertices and %d triangles are no mesh",
                         vertex_count, triangle_count);
    }
    for (ptrdiff_t i = 0; i < (ptrdiff_t)3 * triangle_count; ++i) {
        if (triangles[i] < 0 || triangles[i] >= vertex_count) {
            return plii_fail(context, PLI_ERROR_INDEX_OUT_OF_RANGE, function,
                             "triangle %d names vertex %d, there are %d vertices", (int)(i / 3), triangles[i],
                             vertex_count);
        }
    }
    return plii_check_finite_points(context, vertex_count, vertices, "vertex", function);
}

pli_status pli_mesh_create_from_vertices(pli_context* context, int vertex_count, const pli_vec3* vertices,
                                         int triangle_count, const int* triangles, int* vertex_nodes, pli_mesh** mesh) {
    PLII_TRY(plii_check_mesh_create(context, mesh, __func__));
    PLII_TRY(vertices_check(context, vertex_count, vertices, triangle_count, triangles, vertex_nodes, __func__));
    place_table table = {.capacity = 4};
    while (table.capacity < 2 * (size_t)vertex_count) {
        table.capacity *= 2;
    }
    const size_t corner_count = 3 * (size_t)triangle_count;
    pli_vec3* points = NULL;
    int *corners = NULL, *nodes = NULL;
    const bool has_memory =
        PLII_ALLOCATE(context, &table.nodes, table.capacity) && PLII_ALLOCATE(context, &points, vertex_count) &&
        PLII_ALLOCATE(context, &nodes, vertex_count) && PLII_ALLOCATE(context, &corners, corner_count);
    pli_status status = has_memory ? PLI_OK
                                   : plii_fail(context, PLI_ERROR_OUT_OF_MEMORY, __func__,
                                               "no memory for the places of %d vertices", vertex_count);
    if (status == PLI_OK) {
        memset(table.nodes, 0xff, table.capacity * sizeof *table.nodes);
        const int point_count = vertices_merge(&table, vertex_count, vertices, points, nodes);
        for (size_t i = 0; i < corner_count; ++i) {
            corners[i] = nodes[triangles[i]];
        }
        status = pli_mesh_create_from_triangles(context, point_count, points, triangle_count, corners, false, mesh);
    }
    if (status == PLI_OK) { memcpy(vertex_nodes, nodes, (size_t)vertex_count * sizeof *nodes); }
    PLII_RELEASE(context, table.nodes, table.capacity);
    PLII_RELEASE(context, points, vertex_count);
    PLII_RELEASE(context, nodes, vertex_count);
    PLII_RELEASE(context, corners, corner_count);
    return status;
}
