#ifndef PLIANT_DRAWING_H
#define PLIANT_DRAWING_H

/// What a renderer needs of a body: normals, vertices in the renderer's own layout, interpolated between steps, and
/// what cuts changed.

#include "body.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Keeps unit normals of nodes (mean of the faces around, by area) and of faces, refreshed after each step, without any
/// force that needs them: pli_body_view::normals and pli_body_get_face_normals.
/// @return PLI_ERROR_INVALID_MESH for a body without faces, PLI_ERROR_OUT_OF_MEMORY, PLI_ERROR_WRONG_STATE while
///         stepping
/// Cost: 40 B per node and 12 B per face; a pass over the faces per step.
PLI_API pli_status pli_body_enable_normals(pli_body* body);

/// Ends them, but for what other features need. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_normals(pli_body* body);

/// [face_count] unit normals of faces, of the side from which their nodes go counter-clockwise; zero for a face without
/// area. NULL when no enabled feature needs them.
PLI_API const pli_vec3* pli_body_get_face_normals(const pli_body* body);

/// A buffer of vertices, each with a position and, if wanted, a normal, of three floats each.
typedef struct pli_vertex_buffer_def {
    void* vertices;          ///< required; aligned to 4 B
    int vertex_count;        ///< >= 0, default 0
    int stride;              ///< B from a vertex to the next, default 24; a multiple of 4
    int position_offset;     ///< B from the begin of a vertex, >= 0, default 0; a multiple of 4
    int normal_offset;       ///< the same, default 12; negative: no normals
    const int* vertex_nodes; ///< [vertex_count] the node of each vertex, for meshes whose vertices are doubled where
                             ///< textures or normals end (pli_mesh_create_from_vertices makes it); NULL, the
                             ///< default: vertex i is node i
    uint32_t cookie;         ///< set by the default function
} pli_vertex_buffer_def;

/// Defaults of the fields; `vertices` and `vertex_count` have to be set.
PLI_API pli_vertex_buffer_def pli_vertex_buffer_def_default(void);

/// Writes positions and normals, interpolated over the last step, for frames that are drawn between fixed steps.
/// @param buffer what lies between positions and normals is not touched
/// @param factor 0 to 2: 0 is the start of the last step, 1 its end, 2 as far again in the same direction. With Bullet:
///        pliant::Bridge::interpolation(). Of a frozen body always its present state
/// @return PLI_ERROR_INVALID_VALUE also when normals are wanted and pli_body_enable_normals was not called,
///         PLI_ERROR_INDEX_OUT_OF_RANGE (node of a vertex); nothing is written then
PLI_API pli_status pli_body_write_vertices(const pli_body* body, const pli_vertex_buffer_def* buffer, float factor);

/// A node that a cut or a refinement has added. Its texture coordinates, weights and colours are those of `a` + share *
/// (those of `b` - those of `a`).
typedef struct pli_new_node {
    int a;       ///< a node of smaller index, which may be new itself
    int b;       ///< as `a`; the same for a copy
    float share; ///< 0 to 1
} pli_new_node;

/// How the nodes and faces of a body have changed. Old nodes keep their index.
typedef struct pli_topology_changes {
    int old_node_count;            ///< nodes from this index on are new
    int new_node_count;            ///< of `new_nodes`
    const pli_new_node* new_nodes; ///< [new_node_count]
    int old_face_count;            ///< of before
    int face_count;                ///< of now, of `face_parents`
    const int* face_parents;       ///< [face_count] the old face that each face is, or is a part of
} pli_topology_changes;

/// Records what cuts and refinements change from now on. Called again, it starts anew from the present state.
/// @return PLI_ERROR_OUT_OF_MEMORY, PLI_ERROR_WRONG_STATE while stepping
/// Cost: 4 B per face, 12 B per new node.
PLI_API pli_status pli_body_enable_topology_changes(pli_body* body);

/// Notes nothing any more. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_topology_changes(pli_body* body);

/// All changes since the last call of pli_body_enable_topology_changes; valid until the next change. All zero when it
/// is not enabled.
PLI_API pli_topology_changes pli_body_get_topology_changes(const pli_body* body);

#ifdef __cplusplus
}
#endif
#endif
