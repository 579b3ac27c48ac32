#ifndef PLIANT_BODY_H
#define PLIANT_BODY_H

/// A soft body: the state cooked from a mesh, and the features that are enabled on it. A new body has links, gravity
/// and nothing else: forces, contacts, anchors and pose matching are enabled one by one (forces.h, pose.h, contact.h,
/// anchor.h), and what is not enabled takes no time, no memory and no code.

#include "mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pli_world pli_world;
typedef struct pli_rigid pli_rigid;
typedef struct pli_body pli_body;

/// How the position-based solver runs.
typedef struct pli_solver_settings {
    int velocity_iterations; ///< >= 0, default 0; see pli_body_use_velocity_links. Bullet name: viterations
    int position_iterations; ///< >= 0, default 1; anchors, contacts, links. Bullet name: piterations
    int drift_iterations;    ///< >= 0, default 0; Bullet name: diterations
    /// share of the drift solve that enters the velocity, default 1, up to PLI_MAX_FACTOR. Bullet name: kVCF
    float drift_correction;
    float velocity_damping; ///< [0, 1], share of the velocity lost per step, default 0. Bullet name: kDP
    float time_scale;       ///< PLI_MIN_TIME_SCALE to PLI_MAX_TIME_SCALE, default 1
} pli_solver_settings;

typedef struct pli_body_def {
    float collision_margin; ///< m, 0 to PLI_MAX_COORDINATE, default 0.25; also grows the bounds
    pli_solver_settings solver;
    void* user_data;
    uint32_t cookie; ///< set by the default function
} pli_body_def;

PLI_API pli_body_def pli_body_def_default(void);

/// Cooks a mesh. Rest lengths are the present distances, node and link indices stay those of the mesh.
/// @param def NULL for the defaults
/// @return PLI_ERROR_INVALID_MESH for a mesh without nodes, PLI_ERROR_NOT_FINITE, PLI_ERROR_WRONG_STATE while stepping,
///         PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_body_create(pli_world* world, const pli_mesh* mesh, const pli_body_def* def, pli_body** body);
/// NULL is allowed. Not while stepping: the body stays then, and pli_last_error says so.
PLI_API void pli_body_destroy(pli_body* body);

PLI_API pli_world* pli_body_get_world(const pli_body* body);
PLI_API void* pli_body_get_user_data(const pli_body* body);
PLI_API void pli_body_set_user_data(pli_body* body, void* user_data);

PLI_API pli_solver_settings pli_body_get_solver_settings(const pli_body* body);
PLI_API pli_status pli_body_set_solver_settings(pli_body* body, const pli_solver_settings* settings);
PLI_API float pli_body_get_collision_margin(const pli_body* body);
PLI_API pli_status pli_body_set_collision_margin(pli_body* body, float margin);

// ------------------------------------------------------------------------------------------------- state

/// One record of a node array; the meaning of `w` is named at the array.
typedef struct pli_vec4 {
    float x, y, z, w;
} pli_vec4;

/// Read access without a copy; valid until the body is destroyed or cut. Contents change with each step.
typedef struct pli_body_view {
    int node_count, link_count, face_count, tetra_count;
    const pli_vec4* positions;  ///< [node_count], m; w = inverse mass, 1/kg
    const pli_vec4* previous;   ///< [node_count], m, start of the last step; w = 0
    const pli_vec4* velocities; ///< [node_count], m/s; w = 0
    const pli_vec3* normals;    ///< [node_count] unit, or NULL when no enabled feature needs normals
    const int* link_nodes;      ///< node a of link i at link_nodes[i * link_node_stride], node b right after it
    int link_node_stride;
    const int* face_nodes;  ///< [3 * face_count]
    const int* tetra_nodes; ///< [4 * tetra_count]
} pli_body_view;

PLI_API pli_body_view pli_body_get_view(const pli_body* body);

/// Present bounds of the nodes, grown by the collision margin.
PLI_API pli_bounds pli_body_get_bounds(const pli_body* body);

/// Rest length of a link, m; 0 to PLI_MAX_COORDINATE.
PLI_API float pli_body_get_rest_length(const pli_body* body, int link);
PLI_API pli_status pli_body_set_rest_length(pli_body* body, int link, float rest_length);

/// Replaces positions and velocities of all nodes, as from a snapshot; what is derived from them is brought up to date.
/// @param positions  [node_count] m, up to PLI_MAX_COORDINATE
/// @param velocities [node_count] m/s, up to PLI_MAX_SPEED; NULL: zero
/// @return PLI_ERROR_NOT_FINITE, PLI_ERROR_INVALID_VALUE, PLI_ERROR_WRONG_STATE while stepping; the same holds below
PLI_API pli_status pli_body_set_state(pli_body* body, const pli_vec3* positions, const pli_vec3* velocities);

PLI_API pli_status pli_body_set_node_position(pli_body* body, int node, pli_vec3 position);
PLI_API pli_status pli_body_set_node_velocity(pli_body* body, int node, pli_vec3 velocity);
/// @param mass kg, PLI_MIN_MASS to PLI_MAX_MASS; 0 pins the node. Rest lengths stay.
PLI_API pli_status pli_body_set_node_mass(pli_body* body, int node, float mass);
PLI_API float pli_body_total_mass(const pli_body* body);

/// Moves the whole body; velocities turn with it, rest lengths stay. Refused when a node would leave the limits.
PLI_API pli_status pli_body_transform(pli_body* body, pli_transform transform);

/// Adds to the force on a node (or on all nodes that are not pinned), N; used up by the next step. The sum is at most
/// PLI_MAX_FORCE.
PLI_API pli_status pli_body_add_node_force(pli_body* body, int node, pli_vec3 force);
PLI_API pli_status pli_body_add_force(pli_body* body, pli_vec3 force);
/// Adds to the velocity of all nodes that are not pinned, m/s. The sum is at most PLI_MAX_SPEED.
PLI_API pli_status pli_body_add_velocity(pli_body* body, pli_vec3 velocity);

/// For steps of changing length, under each solver; default off. What a long step leaves of errors the short one after
/// it would put right as a speed of the error over its own length: 1/15 and 1/240 s in turn blow bodies up. With this a
/// step that is shorter than one before changes velocities, about those of free flight, by as little as that one would:
/// by its length over a reference, which is at least 0.75 of that of the step before. Equal steps are not changed. What
/// rigid bodies get in such a step is not made smaller. Cost: 12 B per node.
/// @return PLI_ERROR_WRONG_STATE while stepping, PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_body_use_step_smoothing(pli_body* body, bool use);

/// Solve links on velocities and in the drift solve instead of in the position solve (the default, and what `false`
/// returns to). Needs velocity_iterations or drift_iterations > 0 to have an effect. Bullet name: setSolver(Velocities)
PLI_API pli_status pli_body_use_velocity_links(pli_body* body, bool use);

/// Solve links in an order of the library's own, colour by colour, several at once: many times faster than in the order
/// of the mesh (the default, and what `false` returns to). Link indices stay those of the mesh. Results differ from
/// those of the other order as much as those of a mesh with shuffled links would; they do not depend on the instruction
/// set nor on threads. A body of a few links that all meet keeps the order of the mesh. A rope (link k joins nodes k
/// and k + 1, for all of 16 to 127 links) has its even, then its odd links, all iterations at once while at most its
/// last node touches or holds something, otherwise colours as any body. Cost: 4 B per link of regular grids, 16 B per
/// other link, of ropes 12 B more.
PLI_API pli_status pli_body_use_colored_links(pli_body* body, bool use);

/// A frozen body takes no part in steps. Bodies freeze when a node leaves the limits of limits.h
/// (PLI_EVENT_BODY_FROZEN).
PLI_API bool pli_body_is_frozen(const pli_body* body);
PLI_API void pli_body_set_frozen(pli_body* body, bool frozen);

/// Switch contacts between a soft body and one rigid body off or on.
PLI_API pli_status pli_body_ignore_rigid(pli_body* body, pli_rigid* rigid, bool ignore);
PLI_API bool pli_body_ignores_rigid(const pli_body* body, const pli_rigid* rigid);

// ---------------------------------------------------------------------------------------------- measures

/// 64-bit hash of the bits of all positions and velocities.
PLI_API uint64_t pli_body_state_hash(const pli_body* body);
/// J
PLI_API float pli_body_kinetic_energy(const pli_body* body);
/// Largest |length / rest length - 1| over the links; 0 without links.
PLI_API float pli_body_max_stretch(const pli_body* body);
/// Sum of mass * velocity over the nodes that are not pinned, kg m/s.
PLI_API pli_vec3 pli_body_momentum(const pli_body* body);
/// Signed volume enclosed by the faces, m^3.
PLI_API float pli_body_volume(const pli_body* body);
/// Bytes that the body holds, features included.
PLI_API size_t pli_body_bytes(const pli_body* body);

/// A feature that is on, or one that another of them needs.
typedef struct pli_feature_cost {
    const char* name; ///< lives as long as the program; the same that pli_world_set_profile gives
    size_t bytes;     ///< that it holds now
    bool is_needed;   ///< is on only because another feature needs it
    bool has_passes;  ///< runs in some stage of a step
} pli_feature_cost;

/// What a body pays for, in the order of enabling; what is not on is not there, and takes neither time nor memory.
/// @param features NULL, or room for `capacity` features
/// @return the number of features there are
PLI_API int pli_body_get_features(const pli_body* body, int capacity, pli_feature_cost* features);

#ifdef __cplusplus
}
#endif
#endif
