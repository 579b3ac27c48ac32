#ifndef PLIANT_MESH_H
#define PLIANT_MESH_H

/// The editable recipe of a soft body: nodes, links, faces, tetrahedra and materials. A body copies what it needs
/// (pli_body_create); one mesh may be the recipe of many bodies and may be changed or destroyed afterwards.

#include "base.h"
#include "math.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pli_mesh pli_mesh;

/// What a link is made of.
typedef struct pli_material {
    float linear_stiffness; ///< (0, 1], PLI_MIN_STIFFNESS at least: share of a link's length error that one iteration
                            ///< removes. Bullet name: kLST
} pli_material;

/// A distance constraint between two nodes. Its rest length is the distance of the nodes when a body is made.
typedef struct pli_link {
    int nodes[2];
    int material;
    bool is_bending; ///< made by pli_mesh_append_bending_links
} pli_link;

typedef struct pli_face {
    int nodes[3]; ///< counter-clockwise seen from outside
    int material;
} pli_face;

typedef struct pli_tetra {
    int nodes[4];
    int material;
} pli_tetra;

/// Read access to a mesh; valid until the mesh is changed.
typedef struct pli_mesh_view {
    int node_count, link_count, face_count, tetra_count, material_count;
    const pli_vec3* positions;     ///< [node_count], m
    const float* inverse_masses;   ///< [node_count], 1/kg; 0 = pinned
    const pli_link* links;         ///< [link_count]
    const pli_face* faces;         ///< [face_count]
    const pli_tetra* tetras;       ///< [tetra_count]
    const pli_material* materials; ///< [material_count], at least 1
} pli_mesh_view;

// ---------------------------------------------------------------------------------------------------- life

/// An empty mesh with one material (index 0, linear stiffness 1).
PLI_API pli_status pli_mesh_create(pli_context* context, pli_mesh** mesh);
PLI_API pli_status pli_mesh_clone(const pli_mesh* source, pli_mesh** mesh);
/// NULL is allowed.
PLI_API void pli_mesh_destroy(pli_mesh* mesh);
PLI_API pli_mesh_view pli_mesh_get_view(const pli_mesh* mesh);

// ------------------------------------------------------------------------------------------------- building

/// @param position m, up to PLI_MAX_COORDINATE (limits.h)
/// @param mass  kg, PLI_MIN_MASS to PLI_MAX_MASS; 0 pins the node
/// @param index receives the index of the node; may be NULL (the same holds for the other append functions)
/// @return PLI_ERROR_NOT_FINITE, PLI_ERROR_INVALID_VALUE (beyond the limits), PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_mesh_append_node(pli_mesh* mesh, pli_vec3 position, float mass, int* index);

/// @return PLI_ERROR_INDEX_OUT_OF_RANGE, PLI_ERROR_INVALID_VALUE (both ends the same node), PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_mesh_append_link(pli_mesh* mesh, int node_a, int node_b, int material, int* index);

/// @return PLI_ERROR_INDEX_OUT_OF_RANGE, PLI_ERROR_INVALID_VALUE (a node named twice), PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_mesh_append_face(pli_mesh* mesh, int a, int b, int c, int material, int* index);
PLI_API pli_status pli_mesh_append_tetra(pli_mesh* mesh, int a, int b, int c, int d, int material, int* index);

/// @return PLI_ERROR_INVALID_VALUE (stiffness outside (0, 1]), PLI_ERROR_NOT_FINITE, PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_mesh_append_material(pli_mesh* mesh, const pli_material* material, int* index);
PLI_API pli_status pli_mesh_set_material(pli_mesh* mesh, int index, const pli_material* material);

PLI_API pli_status pli_mesh_set_node_position(pli_mesh* mesh, int node, pli_vec3 position);

// --------------------------------------------------------------------------------------------- link recipes

/// Link every pair of nodes whose shortest path over the present links has exactly `distance` links (2 or more).
/// The new links are (i, j) with i > j, ordered by j and then i. Time is linear in the number of paths that are
/// followed. Bullet name: generateBendingConstraints.
/// @param added receives the number of new links; may be NULL
PLI_API pli_status pli_mesh_append_bending_links(pli_mesh* mesh, int distance, int material, int* added);

/// Bring links and faces into a fixed pseudo-random order, which lets Gauss-Seidel sweeps converge evenly.
/// The generator starts from the same seed in every call. Bullet name: randomizeConstraints.
PLI_API pli_status pli_mesh_shuffle_links(pli_mesh* mesh);

/// Reorder links so that neighbours in the list depend less on each other, without changing the result of a sweep.
/// Bullet name: ReoptimizeLinkOrder.
PLI_API pli_status pli_mesh_interleave_links(pli_mesh* mesh);

// ---------------------------------------------------------------------------------------------------- masses

/// @param mass kg, PLI_MIN_MASS to PLI_MAX_MASS; 0 pins the node. Bullet name: setMass
PLI_API pli_status pli_mesh_set_node_mass(pli_mesh* mesh, int node, float mass);

/// Sum of the masses of all nodes that are not pinned, kg.
PLI_API float pli_mesh_total_mass(const pli_mesh* mesh);

/// Scale the masses of the nodes that are not pinned to `mass` in all, kg, > 0. Bullet name: setTotalMass(m, false)
/// @return PLI_ERROR_INVALID_VALUE when a node would get a mass beyond the limits; the same holds below
PLI_API pli_status pli_mesh_set_total_mass(pli_mesh* mesh, float mass);

/// Give each node a mass in proportion to the area of its faces, `mass` in all, kg, > 0. Pinned nodes stay pinned and
/// nodes without a face keep their share of one node (Bullet un-pins the former and makes the latter infinitely light).
/// Bullet name: setTotalMass(m, true)
/// @return PLI_ERROR_INVALID_MESH when no face has an area
PLI_API pli_status pli_mesh_set_total_mass_from_faces(pli_mesh* mesh, float mass);

/// Give each node a mass in proportion to the mean volume of its tetrahedra, `mass` in all. Bullet name: setVolumeMass
/// @return PLI_ERROR_INVALID_MESH when no tetrahedron has a volume
PLI_API pli_status pli_mesh_set_total_mass_from_tetras(pli_mesh* mesh, float mass);

/// set_total_mass_from_faces with |volume| * density, kg/m^3, > 0. Bullet name: setTotalDensity
PLI_API pli_status pli_mesh_set_density_from_faces(pli_mesh* mesh, float density);

/// set_total_mass_from_tetras with the sum of |tetra volume| * density (Bullet's setVolumeDensity is four times that).
PLI_API pli_status pli_mesh_set_density_from_tetras(pli_mesh* mesh, float density);

// ------------------------------------------------------------------------------------------------- geometry

/// Apply to all node positions: p becomes transform * p. Fails on a transform that is not finite or that would take a
/// node beyond PLI_MAX_COORDINATE.
PLI_API pli_status pli_mesh_transform(pli_mesh* mesh, pli_transform transform);
PLI_API pli_status pli_mesh_translate(pli_mesh* mesh, pli_vec3 offset);
PLI_API pli_status pli_mesh_rotate(pli_mesh* mesh, pli_quat rotation);
PLI_API pli_status pli_mesh_scale(pli_mesh* mesh, pli_vec3 factors);

/// Signed volume enclosed by the faces, m^3, taken from node 0; meaningful for closed meshes.
PLI_API float pli_mesh_volume(const pli_mesh* mesh);
PLI_API pli_bounds pli_mesh_bounds(const pli_mesh* mesh);

#ifdef __cplusplus
}
#endif
#endif
