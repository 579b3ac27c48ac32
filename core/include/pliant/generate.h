#ifndef PLIANT_GENERATE_H
#define PLIANT_GENERATE_H

/// Ready-made meshes. Every function makes a new mesh that the caller destroys; nodes have 1 kg unless pinned. Points
/// go to PLI_MAX_COORDINATE (limits.h).

#include "mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Ends of a rope that are pinned.
enum { PLI_ROPE_PIN_FIRST = 1, PLI_ROPE_PIN_LAST = 2 };

/// A chain of `inner_nodes` + 2 nodes on the segment from `from` to `to`. Bullet name: CreateRope
PLI_API pli_status pli_mesh_create_rope(pli_context* context, pli_vec3 from, pli_vec3 to, int inner_nodes, int pins,
                                        pli_mesh** mesh);

/// Nodes of a patch that are pinned, named by their place in the (x, y) grid; MID and CENTER only in
/// pli_mesh_create_patch_uv.
enum {
    PLI_PATCH_PIN_00 = 1,
    PLI_PATCH_PIN_10 = 2,
    PLI_PATCH_PIN_01 = 4,
    PLI_PATCH_PIN_11 = 8,
    PLI_PATCH_PIN_MID_BOTTOM = 16,
    PLI_PATCH_PIN_MID_LEFT = 32,
    PLI_PATCH_PIN_MID_RIGHT = 64,
    PLI_PATCH_PIN_MID_TOP = 128,
    PLI_PATCH_PIN_CENTER = 256,
    PLI_PATCH_PIN_CORNERS = 15
};

typedef struct pli_patch_def {
    pli_vec3 corner_00, corner_10, corner_01, corner_11; ///< m
    int columns, rows;                                   ///< nodes along x (00 to 10) and y (00 to 01), >= 2
    int pins;                                            ///< PLI_PATCH_PIN_ bits
    bool diagonals;                                      ///< one diagonal link per cell
    uint32_t cookie;                                     ///< set by the default function
} pli_patch_def;

PLI_API pli_patch_def pli_patch_def_default(void);

/// A rectangular sheet, node (x, y) at index y * columns + x, alternating diagonals. Bullet name: CreatePatch
PLI_API pli_status pli_mesh_create_patch(pli_context* context, const pli_patch_def* def, pli_mesh** mesh);

/// The same sheet with all diagonals in one direction and texture coordinates. Bullet name: CreatePatchUV
/// @param texture_coordinates NULL, or [12 * (columns - 1) * (rows - 1)] floats: u, v of the corners of the two faces
///                            of each cell, in face order
PLI_API pli_status pli_mesh_create_patch_uv(pli_context* context, const pli_patch_def* def, float* texture_coordinates,
                                            pli_mesh** mesh);

/// A closed surface over `point_count` Hammersley points on an ellipsoid (4 or more), all of which become nodes, in
/// their order (Bullet's hull drops some); of those that coincide up to rounding, from some 100,000 on, not all do.
/// Links are shuffled. Bullet name: CreateEllipsoid with res = point_count - 3
PLI_API pli_status pli_mesh_create_ellipsoid(pli_context* context, pli_vec3 center, pli_vec3 radii, int point_count,
                                             pli_mesh** mesh);

/// The convex hull of points as a closed triangle mesh with a link per edge. Points closer to the hull of the others
/// than `tolerance_ratio` times the diagonal of the bounds may be dropped (0: only what is inside up to rounding;
/// Bullet uses 0.001). Nodes keep the order of the points. Links are shuffled. Bullet name: CreateFromConvexHull
/// @return PLI_ERROR_INVALID_MESH when the points lie in a plane
PLI_API pli_status pli_mesh_create_convex_hull(pli_context* context, int point_count, const pli_vec3* points,
                                               float tolerance_ratio, pli_mesh** mesh);

/// A surface mesh with a link per edge. Several components, zero-area faces and unused points are allowed; faces that
/// name a point twice are skipped (their edges still become links). Bullet name: CreateFromTriMesh
/// @param triangles [3 * triangle_count] indices of points
/// @param shuffle   pli_mesh_shuffle_links at the end
PLI_API pli_status pli_mesh_create_from_triangles(pli_context* context, int point_count, const pli_vec3* points,
                                                  int triangle_count, const int* triangles, bool shuffle,
                                                  pli_mesh** mesh);

/// A tetrahedral mesh with a link per edge.
/// @param tetras [4 * tetra_count] indices of points
PLI_API pli_status pli_mesh_create_from_tetras(pli_context* context, int point_count, const pli_vec3* points,
                                               int tetra_count, const int* tetras, pli_mesh** mesh);

#ifdef __cplusplus
}
#endif
#endif
