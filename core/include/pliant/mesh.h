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
    int nodes[2];    ///< two different ones
    int material;    ///< index of a material
    bool is_bending; ///< made by pli_mesh_append_bending_links
} pli_link;

/// A triangle: surface of the body, for forces, contacts and drawing.
typedef struct pli_face {
    int nodes[3]; ///< counter-clockwise seen from outside
    int material; ///< index of a material; not used by any solver at present
} pli_face;

/// A tetrahedron: volume of the body, for XPBD, clusters and ray casts.
typedef struct pli_tetra {
    int nodes[4]; ///< in any order
    int material; ///< index of a material; not used by any solver at present
} pli_tetra;

/// Read access to a mesh; valid until the mesh is changed.
typedef struct pli_mesh_view {
    int node_count;                ///< of `positions` and `inverse_masses`
    int link_count;                ///< of `links`
    int face_count;                ///< of `faces`
    int tetra_count;               ///< of `tetras`
    int material_count;            ///< of `materials`
    const pli_vec3* positions;     ///< [node_count], m
    const float* inverse_masses;   ///< [node_count], 1/kg; 0 = pinned
    const pli_link* links;         ///< [link_count]
    const pli_face* faces;         ///< [face_count]
    const pli_tetra* tetras;       ///< [tetra_count]
    const pli_material* materials; ///< [material_count], at least 1
} pli_mesh_view;

// ---------------------------------------------------------------------------------------------------- life

/// Makes an empty mesh with one material (index 0, linear stiffness 1).
PLI_API pli_status pli_mesh_create(pli_context* context, pli_mesh** mesh);

/// Makes a copy in the same context, to change one of the two.
PLI_API pli_status pli_mesh_clone(const pli_mesh* source, pli_mesh** mesh);

/// Destroys a mesh; bodies made from it stay as they are. NULL is allowed.
PLI_API void pli_mesh_destroy(pli_mesh* mesh);

/// Pointers to the arrays of a mesh; all zero for an invalid handle.
PLI_API pli_mesh_view pli_mesh_get_view(const pli_mesh* mesh);

// ------------------------------------------------------------------------------------------------- building

/// Adds a node.
/// @param position m, up to PLI_MAX_COORDINATE (limits.h)
/// @param mass     kg, PLI_MIN_MASS to PLI_MAX_MASS; 0 pins the node
/// @param index    receives the index of the node; may be NULL
PLI_API pli_status pli_mesh_append_node(pli_mesh* mesh, pli_vec3 position, float mass, int* index);

/// Adds a link between two nodes. Bullet name: appendLink
/// @param index receives the index of the link; may be NULL
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (node or material), PLI_ERROR_INVALID_VALUE (both ends the same node)
PLI_API pli_status pli_mesh_append_link(pli_mesh* mesh, int node_a, int node_b, int material, int* index);

/// Adds a face, without links along its edges. Bullet name: appendFace
/// @param a,b,c nodes, counter-clockwise seen from outside
/// @param index receives the index of the face; may be NULL
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (node or material), PLI_ERROR_INVALID_VALUE (a node named twice)
PLI_API pli_status pli_mesh_append_face(pli_mesh* mesh, int a, int b, int c, int material, int* index);

/// Adds a tetrahedron, without links along its edges or faces on its sides. Bullet name: appendTetra
/// @param a,b,c,d nodes, in any order
/// @param index   receives the index of the tetrahedron; may be NULL
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (node or material), PLI_ERROR_INVALID_VALUE (a node named twice)
PLI_API pli_status pli_mesh_append_tetra(pli_mesh* mesh, int a, int b, int c, int d, int material, int* index);

/// Adds a material for links that are appended with its index. Bullet name: appendMaterial
/// @param index receives the index of the material; may be NULL
/// @return PLI_ERROR_INVALID_VALUE (stiffness, or more than 32768 materials)
PLI_API pli_status pli_mesh_append_material(pli_mesh* mesh, const pli_material* material, int* index);

/// Changes a material, for bodies that are made from now on.
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE
PLI_API pli_status pli_mesh_set_material(pli_mesh* mesh, int index, const pli_material* material);

/// Places one node.
/// @param position m, up to PLI_MAX_COORDINATE
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE
PLI_API pli_status pli_mesh_set_node_position(pli_mesh* mesh, int node, pli_vec3 position);

// --------------------------------------------------------------------------------------------- link recipes

/// Links every pair of nodes whose shortest path over the present links has exactly `distance` links, so that the body
/// resists bending. The new links are (i, j) with i > j, ordered by j and then i. Solved in this order, they push round
/// bodies one way, and a ball on a level floor rolls off by itself: pli_mesh_shuffle_links afterwards prevents it, and
/// so does pli_body_enable_colored_links. Time is linear in the number of paths that are followed. Bullet name:
/// generateBendingConstraints
/// @param distance >= 2
/// @param added    receives the number of new links; may be NULL
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (material)
PLI_API pli_status pli_mesh_append_bending_links(pli_mesh* mesh, int distance, int material, int* added);

/// Brings links and faces into a fixed pseudo-random order, which lets Gauss-Seidel sweeps converge evenly.
/// The generator starts from the same seed in every call. Bullet name: randomizeConstraints
PLI_API pli_status pli_mesh_shuffle_links(pli_mesh* mesh);

// ---------------------------------------------------------------------------------------------------- masses

/// Changes the mass of one node. Bullet name: setMass
/// @param mass kg, PLI_MIN_MASS to PLI_MAX_MASS; 0 pins the node
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE
PLI_API pli_status pli_mesh_set_node_mass(pli_mesh* mesh, int node, float mass);

/// Sum of the masses of all nodes that are not pinned, kg.
PLI_API float pli_mesh_total_mass(const pli_mesh* mesh);

/// Scales the masses of the nodes that are not pinned. Bullet name: setTotalMass(m, false)
/// @param mass kg, > 0, of all nodes together
/// @return PLI_ERROR_INVALID_MESH when all nodes are pinned, PLI_ERROR_INVALID_VALUE also when a node would get a mass
///         beyond the limits; then no mass is changed
PLI_API pli_status pli_mesh_set_total_mass(pli_mesh* mesh, float mass);

/// Gives each node a mass in proportion to the area of its faces. Pinned nodes stay pinned and nodes without a face
/// keep their share of one node (Bullet un-pins the former and makes the latter infinitely light).
/// Bullet name: setTotalMass(m, true)
/// @param mass kg, > 0, of all nodes together
/// @return PLI_ERROR_INVALID_MESH when no face of a node that is not pinned has an area, PLI_ERROR_INVALID_VALUE as in
///         pli_mesh_set_total_mass, PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_mesh_set_total_mass_from_faces(pli_mesh* mesh, float mass);

/// Gives each node a mass in proportion to the mean volume of its tetrahedra; pinned nodes and those without one as in
/// pli_mesh_set_total_mass_from_faces. Bullet name: setVolumeMass
/// @param mass kg, > 0, of all nodes together
/// @return PLI_ERROR_INVALID_MESH when no tetrahedron of a node that is not pinned has a volume,
///         PLI_ERROR_INVALID_VALUE as in pli_mesh_set_total_mass, PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_mesh_set_total_mass_from_tetras(pli_mesh* mesh, float mass);

/// pli_mesh_set_total_mass_from_faces with |pli_mesh_volume| * density, the mass of a solid with this surface.
/// Bullet name: setTotalDensity
/// @param density kg/m^3, > 0
/// @return PLI_ERROR_INVALID_MESH also when the faces enclose no volume; else the same
PLI_API pli_status pli_mesh_set_density_from_faces(pli_mesh* mesh, float density);

/// pli_mesh_set_total_mass_from_tetras with the sum of |tetra volume| * density (Bullet's setVolumeDensity is four
/// times that).
/// @param density kg/m^3, > 0
/// @return PLI_ERROR_INVALID_MESH also when there is no volume; else the same
PLI_API pli_status pli_mesh_set_density_from_tetras(pli_mesh* mesh, float density);

// ------------------------------------------------------------------------------------------------- geometry

/// Moves and turns all nodes: p becomes transform * p. Bullet name: transform
/// @return PLI_ERROR_INVALID_VALUE or PLI_ERROR_NOT_FINITE when a node would leave PLI_MAX_COORDINATE; no node is moved
///         then
PLI_API pli_status pli_mesh_transform(pli_mesh* mesh, pli_transform transform);

/// Moves all nodes by an offset, m. Bullet name: translate
/// @return as pli_mesh_transform
PLI_API pli_status pli_mesh_translate(pli_mesh* mesh, pli_vec3 offset);

/// Turns all nodes about the origin, by a quaternion of any length but zero. Bullet name: rotate
/// @return as pli_mesh_transform
PLI_API pli_status pli_mesh_rotate(pli_mesh* mesh, pli_quat rotation);

/// Multiplies the coordinates of all nodes by factors per axis. Bullet name: scale
/// @return as pli_mesh_transform
PLI_API pli_status pli_mesh_scale(pli_mesh* mesh, pli_vec3 factors);

/// Signed volume enclosed by the faces, m^3, taken from node 0; meaningful for closed meshes.
PLI_API float pli_mesh_volume(const pli_mesh* mesh);

/// Bounds of the nodes, m; both corners zero for a mesh without nodes.
PLI_API pli_bounds pli_mesh_bounds(const pli_mesh* mesh);

#ifdef __cplusplus
}
#endif
#endif
