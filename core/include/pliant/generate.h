#ifndef PLIANT_GENERATE_H
#define PLIANT_GENERATE_H

/// Ready-made meshes. Every function makes a new mesh that the caller destroys. Nodes have 1 kg unless pinned. Points
/// are in m, up to PLI_MAX_COORDINATE (limits.h).

#include "mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Ends of a rope that are pinned; bits.
enum {
    PLI_ROPE_PIN_FIRST = 1, ///< node 0, at `from`
    PLI_ROPE_PIN_LAST = 2   ///< the last node, at `to`
};

/// Makes a chain of `inner_nodes` + 2 nodes on the segment from `from` to `to`, link i from node i to node i + 1.
/// Bullet name: CreateRope
/// @param inner_nodes >= 0
/// @param pins        PLI_ROPE_PIN_ bits
PLI_API pli_status pli_mesh_create_rope(pli_context* context, pli_vec3 from, pli_vec3 to, int inner_nodes, int pins,
                                        pli_mesh** mesh);

/// Nodes of a patch that are pinned, named by their place in the (x, y) grid; bits. MID and CENTER only in
/// pli_mesh_create_patch_uv.
enum {
    PLI_PATCH_PIN_00 = 1,          ///< at corner_00
    PLI_PATCH_PIN_10 = 2,          ///< at corner_10
    PLI_PATCH_PIN_01 = 4,          ///< at corner_01
    PLI_PATCH_PIN_11 = 8,          ///< at corner_11
    PLI_PATCH_PIN_MID_BOTTOM = 16, ///< middle of the edge from 00 to 10
    PLI_PATCH_PIN_MID_LEFT = 32,   ///< middle of the edge from 00 to 01
    PLI_PATCH_PIN_MID_RIGHT = 64,  ///< middle of the edge from 10 to 11
    PLI_PATCH_PIN_MID_TOP = 128,   ///< middle of the edge from 01 to 11
    PLI_PATCH_PIN_CENTER = 256,    ///< middle of the sheet
    PLI_PATCH_PIN_CORNERS = 15     ///< all four corners
};

/// A sheet.
typedef struct pli_patch_def {
    pli_vec3 corner_00; ///< m, up to PLI_MAX_COORDINATE, default (-1, 0, -1)
    pli_vec3 corner_10; ///< default (1, 0, -1)
    pli_vec3 corner_01; ///< default (-1, 0, 1)
    pli_vec3 corner_11; ///< default (1, 0, 1)
    int columns;        ///< nodes along x (00 to 10), >= 2, default 16
    int rows;           ///< nodes along y (00 to 01), >= 2, default 16
    int pins;           ///< PLI_PATCH_PIN_ bits, default 0
    bool diagonals;     ///< default true: one diagonal link per cell, against shear
    uint32_t cookie;    ///< set by the default function
} pli_patch_def;

/// Defaults of the fields.
PLI_API pli_patch_def pli_patch_def_default(void);

/// Makes a rectangular sheet, node (x, y) at index y * columns + x, two faces per cell, with alternating diagonals.
/// Bullet name: CreatePatch
PLI_API pli_status pli_mesh_create_patch(pli_context* context, const pli_patch_def* def, pli_mesh** mesh);

/// Makes the same sheet with all diagonals in one direction and texture coordinates. Bullet name: CreatePatchUV
/// @param texture_coordinates NULL, or [12 * (columns - 1) * (rows - 1)] floats: u, v of the corners of the two faces
///                            of each cell, in face order
PLI_API pli_status pli_mesh_create_patch_uv(pli_context* context, const pli_patch_def* def, float* texture_coordinates,
                                            pli_mesh** mesh);

/// Makes a closed surface over Hammersley points on an ellipsoid. All points become nodes, in their order (Bullet's
/// hull drops some), except those that coincide up to rounding, which happens from some 100,000 on or if the centre is
/// far away. Links are shuffled. Bullet name: CreateEllipsoid with res = point_count - 3
/// @param radii       m, > 0, of the three axes
/// @param point_count >= 4
PLI_API pli_status pli_mesh_create_ellipsoid(pli_context* context, pli_vec3 center, pli_vec3 radii, int point_count,
                                             pli_mesh** mesh);

/// Makes the convex hull of points as a closed triangle mesh with a link per edge. Nodes keep the order of the points.
/// Links are shuffled. Bullet name: CreateFromConvexHull
/// @param points          [point_count], 4 or more
/// @param tolerance_ratio [0, 1): points closer to the hull of the others than this times the diagonal of the bounds
///                        may be dropped; 0: only what is inside up to rounding; Bullet uses 0.001
/// @return PLI_ERROR_INVALID_MESH when the points lie in a plane
PLI_API pli_status pli_mesh_create_convex_hull(pli_context* context, int point_count, const pli_vec3* points,
                                               float tolerance_ratio, pli_mesh** mesh);

/// Makes a surface mesh with a link per edge. Several components, zero-area faces and unused points are allowed; faces
/// that name a point twice are skipped (their edges still become links). Bullet name: CreateFromTriMesh
/// @param points    [point_count], 1 or more
/// @param triangles [3 * triangle_count] indices of points
/// @param shuffle   pli_mesh_shuffle_links at the end
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (triangles)
PLI_API pli_status pli_mesh_create_from_triangles(pli_context* context, int point_count, const pli_vec3* points,
                                                  int triangle_count, const int* triangles, bool shuffle,
                                                  pli_mesh** mesh);

/// Makes a surface mesh, as pli_mesh_create_from_triangles, from the vertices of a renderer, which has several at one
/// place where textures or normals end. Vertices at the same place become one node, so that the surface is connected.
/// @param vertices     [vertex_count], 1 or more
/// @param triangles    [3 * triangle_count] indices of vertices; faces keep their order
/// @param vertex_nodes [vertex_count] receives the node of each vertex, for pli_vertex_buffer_def::vertex_nodes; not
///                     touched on failure
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (triangles)
PLI_API pli_status pli_mesh_create_from_vertices(pli_context* context, int vertex_count, const pli_vec3* vertices,
                                                 int triangle_count, const int* triangles, int* vertex_nodes,
                                                 pli_mesh** mesh);

/// Makes a tetrahedral mesh with a link per edge and no faces.
/// @param points [point_count], 1 or more
/// @param tetras [4 * tetra_count] indices of points
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (tetras), PLI_ERROR_INVALID_VALUE (a point named twice)
PLI_API pli_status pli_mesh_create_from_tetras(pli_context* context, int point_count, const pli_vec3* points,
                                               int tetra_count, const int* tetras, pli_mesh** mesh);

#ifdef __cplusplus
}
#endif
#endif
