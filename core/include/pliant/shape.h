#ifndef PLIANT_SHAPE_H
#define PLIANT_SHAPE_H

/// Collision shapes of rigid bodies, in their local frame. Shapes are immutable and shared: each create returns one
/// reference, each rigid body that uses a shape holds another. Sizes and points go to PLI_MAX_COORDINATE (limits.h), in
/// m.

#include "base.h"
#include "math.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pli_shape pli_shape;

/// The functions of a shape. All get `user`, must be pure functions and may run on any thread. They may read only,
/// except `destroy`, which may also release other shapes.
typedef struct pli_shape_def {
    void* user; ///< handed to all callbacks, default NULL
    /// Signed distances (negative inside) and unit outward normals at `count` local points. A distance above
    /// `max_distance` may be reported as any value above it, without a normal. No array is NULL. Required.
    void (*distances)(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                      pli_vec3* normals);
    /// The local bounds; infinite components are allowed. Required.
    pli_bounds (*bounds)(const void* user);
    /// The farthest point of the core along a unit direction; NULL for shapes that are not convex. The shape is all
    /// that lies within `radius` of the core.
    pli_vec3 (*support)(const void* user, pli_vec3 direction);
    float radius; ///< m, >= 0, default 0
    /// Called when the last reference is released; may be NULL.
    void (*destroy)(void* user);
    uint32_t cookie; ///< set by the default function
} pli_shape_def;

/// Defaults of the fields; `distances` and `bounds` have to be set.
PLI_API pli_shape_def pli_shape_def_default(void);

/// Makes a shape from the caller's own functions.
/// @param def copied; after an error `destroy` is not called
PLI_API pli_status pli_shape_create(pli_context* context, const pli_shape_def* def, pli_shape** shape);

/// Takes one more reference.
PLI_API void pli_shape_retain(pli_shape* shape);

/// Releases one reference; the last one destroys the shape. NULL is allowed.
PLI_API void pli_shape_release(pli_shape* shape);

/// Makes the half space dot(normal, p) <= offset.
/// @param normal of any length but zero; it is normalised
/// @param offset m, along the unit normal
PLI_API pli_status pli_shape_create_plane(pli_context* context, pli_vec3 normal, float offset, pli_shape** shape);

/// Makes a ball around the origin.
/// @param radius m, > 0
PLI_API pli_status pli_shape_create_sphere(pli_context* context, float radius, pli_shape** shape);

/// Makes a box around the origin, along the axes.
/// @param half_extents m, each > 0
PLI_API pli_status pli_shape_create_box(pli_context* context, pli_vec3 half_extents, pli_shape** shape);

/// Makes all points within `radius` of the segment from -`half_segment` to +`half_segment`.
/// @param half_segment m; zero makes a sphere
/// @param radius       m, > 0
PLI_API pli_status pli_shape_create_capsule(pli_context* context, pli_vec3 half_segment, float radius,
                                            pli_shape** shape);

/// Makes a flat-ended cylinder around the segment from -`half_axis` to +`half_axis`.
/// @param half_axis m, not zero
/// @param radius    m, > 0
PLI_API pli_status pli_shape_create_cylinder(pli_context* context, pli_vec3 half_axis, float radius, pli_shape** shape);

/// Makes the convex hull of points, grown by a radius (rounded edges).
/// @param points [point_count], 4 or more; copied
/// @param radius m, >= 0
/// @return PLI_ERROR_INVALID_MESH when the points lie in a plane
PLI_API pli_status pli_shape_create_convex_hull(pli_context* context, int point_count, const pli_vec3* points,
                                                float radius, pli_shape** shape);

/// Makes a surface of triangles with a bounding volume tree. The sign of the distance comes from the angle-weighted
/// normal of the nearest feature, so a closed surface is solid, and an open one is a floor seen from its front. Behind
/// an open surface only points within `thickness` count as inside; farther behind there is nothing (distance INFINITY).
/// Each connected part of the surface is open or closed by itself; points at equal positions count as one. Triangles
/// without area, and repeated ones with the same corners in the same order, are ignored. Source: Baerentzen and Aanaes,
/// "Signed Distance Computation Using the Angle Weighted Pseudonormal"
/// @param points    [point_count]; copied
/// @param triangles [3 * triangle_count] indices of points, counter-clockwise seen from outside
/// @param thickness m, > 0
/// @return PLI_ERROR_INVALID_MESH without a triangle that has an area, PLI_ERROR_INDEX_OUT_OF_RANGE (triangles)
PLI_API pli_status pli_shape_create_triangle_mesh(pli_context* context, int point_count, const pli_vec3* points,
                                                  int triangle_count, const int* triangles, float thickness,
                                                  pli_shape** shape);

/// How a triangle mesh is sampled.
typedef struct pli_sampled_mesh_def {
    float cell_size; ///< m, >= 0, distance of the samples; default 0: the diagonal of the mesh's bounds / 64
    /// m, >= 0: how far outside the bounds of the mesh distances are sampled, at least a cell; default 0: 4 cells
    float padding;
    uint32_t cookie; ///< set by the default function
} pli_sampled_mesh_def;

/// Samples of one grid; each takes 4 bytes, and 1 more while the shape is made.
#define PLI_SAMPLED_MESH_MAX_SAMPLES 16777216

/// Defaults of the fields.
PLI_API pli_sampled_mesh_def pli_sampled_mesh_def_default(void);

/// Makes the solid inside triangles, by signed distances that are sampled on a grid once and then interpolated: a query
/// costs the same for any number of triangles. Inside is where the winding number is above one half, whichever way each
/// part of the surface is turned. Holes are closed by a surface of their own. Parts may overlap (triangles that lie
/// completely inside do not count) or lie inside each other (turned the same way: solid; the other way: a cavity).
/// Triangles may be doubled or have no area. Details smaller than a cell are lost. Outside the grid the distance is a
/// lower bound, up to the error of interpolation; let `padding` be at least the largest collision margin.
/// @param points    [point_count]
/// @param triangles [3 * triangle_count] indices of points
/// @param def       NULL for the defaults; copied
/// @return PLI_ERROR_INVALID_MESH when the triangles enclose nothing, PLI_ERROR_INDEX_OUT_OF_RANGE (triangles),
///         PLI_ERROR_INVALID_VALUE also when the cells are too small or the grid would need more than
///         PLI_SAMPLED_MESH_MAX_SAMPLES
PLI_API pli_status pli_shape_create_sampled_mesh(pli_context* context, int point_count, const pli_vec3* points,
                                                 int triangle_count, const int* triangles,
                                                 const pli_sampled_mesh_def* def, pli_shape** shape);

/// Signed distance of a point from a shape, m, < 0 inside, for your own colliders and for tests. INFINITY for a null
/// shape and for a point that is not finite.
/// @param point  m, in the frame of the shape
/// @param normal receives the unit outward normal; may be NULL
PLI_API float pli_shape_distance(const pli_shape* shape, pli_vec3 point, pli_vec3* normal);

/// Bounds of a shape in its own frame, m, with its radius; components may be infinite. Both corners zero for a null
/// shape.
PLI_API pli_bounds pli_shape_bounds(const pli_shape* shape);

#ifdef __cplusplus
}
#endif
#endif
