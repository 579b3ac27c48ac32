#ifndef PLIANT_BULLET_REFERENCE_H
#define PLIANT_BULLET_REFERENCE_H

/// What there is only to equal btSoftBody bit for bit: its orders, its boxes and its picture of rigid shapes. For
/// comparisons (docs/comparison.md) and nothing else; without it bodies step faster and find all of their contacts. Not
/// in pliant.h. Fields of definitions that belong here say "reference mode only": pli_world_def::reference_mode,
/// pli_clusters_def::reference_mode, pli_cluster_contacts_def::disable_contact_cache and ::distance,
/// pli_soft_contacts_def::bullet_boxes, pli_refine_def::reset_rest_lengths.

#include "body.h"
#include "mesh.h"
#include "shape.h"

#ifdef __cplusplus
extern "C" {
#endif

// -------------------------------------------------------------------------------------------------------- orders

/// Reorders links so that neighbours in the list depend less on each other, without changing the result of a sweep.
/// Bullet name: ReoptimizeLinkOrder
/// @return PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_mesh_interleave_links(pli_mesh* mesh);

/// Changes the order in which contacts of nodes with rigid bodies are solved; results of Gauss-Seidel depend on it.
/// Between collide and solve.
/// @param order [count] a permutation: the contact now at `order[i]` comes to place i
/// @param count the number of contacts there are
/// @return PLI_ERROR_WRONG_STATE when not between pli_world_predict and pli_world_solve, or not enabled,
///         PLI_ERROR_INDEX_OUT_OF_RANGE, PLI_ERROR_INVALID_VALUE (another count, or a contact named twice),
///         PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_body_reorder_rigid_contacts(pli_body* body, const int* order, int count);

/// The same for the contacts of pli_body_get_soft_contacts.
/// @return as pli_body_reorder_rigid_contacts
PLI_API pli_status pli_body_reorder_soft_contacts(pli_body* body, const int* order, int count);

/// The same for the contacts of pli_body_get_cluster_contacts.
/// @return as pli_body_reorder_rigid_contacts
PLI_API pli_status pli_body_reorder_cluster_contacts(pli_body* body, const int* order, int count);

// --------------------------------------------------------------------------------------------------------- boxes

/// Keeps Bullet's boxes of nodes from step to step, and meets rigid shapes with the nodes whose boxes they touch, so
/// that the same contacts are found as by btSoftBody. Position-based solver only.
/// @return PLI_ERROR_WRONG_STATE while stepping
/// Cost: 24 B per node.
PLI_API pli_status pli_body_enable_bullet_node_boxes(pli_body* body);

/// Drops the boxes; rigid shapes meet all nodes that are near, unless `bullet_boxes` keeps them. Does nothing
/// when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_bullet_node_boxes(pli_body* body);

/// Replaces the stored boxes of `bullet_boxes` and of pli_body_enable_bullet_node_boxes, to take them over from a
/// btSoftBody before a step is compared.
/// @param node_boxes [node_count]
/// @param face_boxes [face_count]; NULL where only rigid contacts keep boxes
/// @return PLI_ERROR_WRONG_STATE when they are not kept
PLI_API pli_status pli_body_set_bullet_boxes(pli_body* body, const pli_bounds* node_boxes,
                                             const pli_bounds* face_boxes);

// -------------------------------------------------------------------------------------------------------- shapes

/// Wraps a shape in a lattice of sampled distances: values are taken at multiples of `voxel_size`, cached, and
/// interpolated trilinearly; the normal is the gradient of the interpolant. This is how Bullet sees rigid shapes
/// (btSparseSdf, voxel 0.25); the shape itself is more accurate. Holds a reference to `source`. The cache takes 9 MB at
/// most; when full it starts anew, which changes time but not results.
/// Not for use from several threads at once, so not for worlds outside of reference mode in a context with a hook for
/// threads, nor for worlds that step at the same time: sampling fills the cache.
/// @param voxel_size m, > 0
PLI_API pli_status pli_shape_create_lattice(pli_context* context, pli_shape* source, float voxel_size,
                                            pli_shape** shape);

#ifdef __cplusplus
}
#endif
#endif
