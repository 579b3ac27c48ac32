#ifndef PLIANT_BODY_H
#define PLIANT_BODY_H

/// A soft body: the state made from a mesh, and the features that are enabled on it. A new body has links, gravity and
/// nothing else. Forces, contacts, anchors, pose matching and so on are enabled one by one (forces.h, contact.h,
/// anchor.h, pose.h). A feature that is not enabled takes no time, no memory and no code.

#include "mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pli_world pli_world;
typedef struct pli_rigid pli_rigid;
typedef struct pli_body pli_body;

/// How the position-based solver runs.
typedef struct pli_solver_settings {
    int velocity_iterations; ///< >= 0, default 0; see pli_body_enable_velocity_links. Bullet name: viterations
    /// >= 0, default 8; 4 to 20 are usual. Iterations over anchors, contacts and links. With 1, the default of Bullet,
    /// links are soft, and solved in the order of the mesh they give a large sheet energy until it bursts. Bullet name:
    /// piterations
    int position_iterations;
    /// >= 0, default 0: iterations that solve links on positions once more at the end of a step, with
    /// pli_body_enable_velocity_links. Contacts, anchors, targets and tethers do not hold nodes in them, as in Bullet.
    /// Bullet name: diterations
    int drift_iterations;
    float drift_correction; ///< default 1, up to PLI_MAX_FACTOR of either sign: share of the drift solve that enters
                            ///< the velocity. Bullet name: kVCF
    float velocity_damping; ///< [0, 1], default 0: share of the velocity lost per step. Bullet name: kDP
    /// PLI_MIN_TIME_SCALE to PLI_MAX_TIME_SCALE, default 1: factor of the step. Bullet: timescale. Velocities of the
    /// body and impulses on it are in its own time. Rigid bodies keep the time of the world; contacts, anchors and
    /// tethers convert between the two, so that a lift takes a slow cloth along, and a ball gets no energy from it.
    /// Clusters and joints do not convert, nor do worlds with reference_mode: leave 1 where these meet moving bodies.
    float time_scale;
} pli_solver_settings;

/// A collision margin that suits the mesh: half the mean rest length of the links (without bending links; without
/// links, of the edges of faces), at most 0.25 m, so that contacts of nodes leave no wide gaps. For single nodes, and
/// in worlds with pli_world_def::reference_mode, 0.25 m as in Bullet.
#define PLI_MARGIN_OF_MESH (-1.0f)

/// How a body is made from a mesh.
typedef struct pli_body_def {
    float collision_margin;     ///< m, 0 to PLI_MAX_COORDINATE, default PLI_MARGIN_OF_MESH: distance that contacts with
                                ///< rigid bodies keep; also grows the bounds
    pli_solver_settings solver; ///< defaults as named there
    void* user_data;            ///< of the caller, default NULL; see pli_body_get_user_data
    uint32_t cookie;            ///< set by the default function
} pli_body_def;

/// Defaults of the fields.
PLI_API pli_body_def pli_body_def_default(void);

/// Makes a body from a mesh. Rest lengths are the present distances of the nodes. Node and link indices stay those of
/// the mesh, which may be changed or destroyed afterwards.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_INVALID_MESH for a mesh without nodes or with more than 32768 materials, PLI_ERROR_WRONG_STATE
///         while stepping
/// Cost: 48 B per node, 12 B per link (14 with several materials), 12 B per face, 16 B per tetrahedron; faces and
/// tetrahedra are shared by the bodies of a mesh.
PLI_API pli_status pli_body_create(pli_world* world, const pli_mesh* mesh, const pli_body_def* def, pli_body** body);

/// Destroys a body with all that is enabled on it, and the joints and contacts of other bodies with it. NULL is
/// allowed. Not while stepping: the body then stays, and pli_last_error says so.
PLI_API void pli_body_destroy(pli_body* body);

/// The world that it was made in.
PLI_API pli_world* pli_body_get_world(const pli_body* body);

/// The pointer from pli_body_def or pli_body_set_user_data.
PLI_API void* pli_body_get_user_data(const pli_body* body);

/// Stores a pointer for the caller, which the library never follows. Allowed inside callbacks.
PLI_API pli_status pli_body_set_user_data(pli_body* body, void* user_data);

/// The present settings; all zero for an invalid handle.
PLI_API pli_solver_settings pli_body_get_solver_settings(const pli_body* body);

/// Replaces all settings. They count from the next part of a step on.
PLI_API pli_status pli_body_set_solver_settings(pli_body* body, const pli_solver_settings* settings);

/// As in pli_body_def, m.
PLI_API float pli_body_get_collision_margin(const pli_body* body);

/// Changes the margin and the bounds with it.
/// @param margin m, 0 to PLI_MAX_COORDINATE
PLI_API pli_status pli_body_set_collision_margin(pli_body* body, float margin);

// ------------------------------------------------------------------------------------------------- state

/// One record of a node array; the meaning of `w` is named at the array.
typedef struct pli_vec4 {
    float x, y, z, w;
} pli_vec4;

/// Read access without a copy. Pointers are valid until the body is destroyed or cut, those of normals until no enabled
/// feature needs them. The contents change with each step.
typedef struct pli_body_view {
    int node_count;             ///< of `positions`, `previous`, `velocities`, `normals`
    int link_count;             ///< of `link_nodes`
    int face_count;             ///< of `face_nodes`
    int tetra_count;            ///< of `tetra_nodes`
    const pli_vec4* positions;  ///< [node_count], m; w = inverse mass, 1/kg
    const pli_vec4* previous;   ///< [node_count], m, start of the last step; w = 0
    const pli_vec4* velocities; ///< [node_count], m/s; w = 0
    const pli_vec3* normals;    ///< [node_count] unit, or NULL when no enabled feature needs normals
    const int* link_nodes;      ///< node a of link i at link_nodes[i * link_node_stride], node b right after it
    int link_node_stride;       ///< in numbers, from a link to the next
    const int* face_nodes;      ///< [3 * face_count]
    const int* tetra_nodes;     ///< [4 * tetra_count]
} pli_body_view;

/// Pointers to the arrays of a body, for drawing and the like; all zero for an invalid handle.
PLI_API pli_body_view pli_body_get_view(const pli_body* body);

/// Present bounds of the nodes, m, grown by the collision margin.
PLI_API pli_bounds pli_body_get_bounds(const pli_body* body);

/// Rest length of a link, m; 0 for an index out of range.
PLI_API float pli_body_get_rest_length(const pli_body* body, int link);

/// Makes a link longer or shorter: muscles, growth, wear. The link gets there within a step, under XPBD within a
/// substep, so change lengths little by little. A sheet of 2 m that becomes 35 % larger at once flies apart with 13 m/s
/// (XPBD: 118 m/s); in 60 small changes over a second it has 0.6 m/s. Features that keep a volume or a pose, and
/// clusters, do not follow, and pull against it: disable them before, and enable them afterwards at the new shape.
/// @param rest_length m, 0 to PLI_MAX_COORDINATE
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (link)
PLI_API pli_status pli_body_set_rest_length(pli_body* body, int link, float rest_length);

/// Replaces positions and velocities of all nodes, and brings up to date what is derived from them. Rest lengths and
/// masses stay.
/// @param positions  [node_count] m, up to PLI_MAX_COORDINATE
/// @param velocities [node_count] m/s, up to PLI_MAX_SPEED; NULL: zero
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_set_state(pli_body* body, const pli_vec3* positions, const pli_vec3* velocities);

/// Places one node between steps, as if it had been there before. Its velocity and the rest lengths of its links stay;
/// normals follow in the next step. To lead a pinned node along a path use pli_body_move_node.
/// @param position m, up to PLI_MAX_COORDINATE
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE, PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_set_node_position(pli_body* body, int node, pli_vec3 position);

/// Sets the velocity of one node. A pinned node moves with it in every step from now on; only the position-based
/// solver then takes velocity_damping from it, as btSoftBody does.
/// @param velocity m/s, up to PLI_MAX_SPEED
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE, PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_set_node_velocity(pli_body* body, int node, pli_vec3 velocity);

/// Leads a pinned node: call it before each step with the place where the node is to be at the end of that step. The
/// node goes there in a straight line at one speed, also through the substeps of XPBD. After the step it is exactly
/// there, with that speed as its velocity. Links, tethers, contacts and air see it move. In a step without a call
/// the node stays where it is. If called twice before a step, the last call counts. Use it instead of
/// pli_body_set_node_position, which would let the node jump, and pli_body_set_node_velocity.
/// @param position m, up to PLI_MAX_COORDINATE
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE, PLI_ERROR_INVALID_VALUE also for a node that is not pinned,
///         PLI_ERROR_OUT_OF_MEMORY, PLI_ERROR_WRONG_STATE while stepping
/// Cost: 28 B per node that is led.
PLI_API pli_status pli_body_move_node(pli_body* body, int node, pli_vec3 position);

/// Changes the mass of one node. Rest lengths and its velocity stay. So a node that is pinned in flight flies on, as
/// after pli_body_set_node_velocity: set the velocity to zero if it is to stay where it is. Bullet name: setMass
/// @param mass kg, PLI_MIN_MASS to PLI_MAX_MASS; 0 pins the node
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE, PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_set_node_mass(pli_body* body, int node, float mass);

/// Sum of the masses of all nodes that are not pinned, kg.
PLI_API float pli_body_total_mass(const pli_body* body);

/// Moves the whole body; velocities turn with it, rest lengths stay. Bullet name: transform
/// @return PLI_ERROR_INVALID_VALUE when a node would leave the limits, PLI_ERROR_WRONG_STATE while stepping; nothing
///         is then moved
PLI_API pli_status pli_body_transform(pli_body* body, pli_transform transform);

/// Adds to the force on one node in the next step. No effect on a pinned node. Bullet name: addForce(f, node)
/// @param force N; the sum of all that was added up to PLI_MAX_FORCE
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE
/// Cost: 12 B per node from the first call on.
PLI_API pli_status pli_body_add_node_force(pli_body* body, int node, pli_vec3 force);

/// Adds the same force to every node that is not pinned, in the next step. Bullet name: addForce
/// @param force N per node; as in pli_body_add_node_force
PLI_API pli_status pli_body_add_force(pli_body* body, pli_vec3 force);

/// Adds to the velocity of all nodes that are not pinned. Bullet name: addVelocity
/// @param velocity m/s; the sum up to PLI_MAX_SPEED
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_add_velocity(pli_body* body, pli_vec3 velocity);

/// For steps of changing length, with any solver; XPBD handles most of them without it. A short step after a long one
/// would correct the errors of the long one within its own length, and make a large speed of them: 1/15 and 1/240 s in
/// turn blow bodies up. With smoothing, a step that is shorter than those before changes velocities (against free
/// flight) by as little as the long one would: by the ratio of its length to a reference, or by the square of the ratio
/// where that would add energy. The reference falls to 0.75 to 0.98 of itself per step, as fast as errors shrink.
/// Pressure, conservation of volume and (not under XPBD) air are smoothed too, other forces are not. Steps of equal
/// length do not change, nor do the impulses on rigid bodies.
/// @return PLI_ERROR_WRONG_STATE while stepping
/// Cost: 12 B per node.
PLI_API pli_status pli_body_enable_step_smoothing(pli_body* body);

/// Ends step smoothing. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_step_smoothing(pli_body* body);

/// Solves links on velocities and in the drift solve instead of in the position solve. Needs velocity_iterations or
/// drift_iterations > 0 to have an effect. Bullet name: setSolver(Velocities)
/// @return PLI_ERROR_WRONG_STATE also when the body has another solver than the position-based one, and while stepping
/// Cost: 16 B per link.
PLI_API pli_status pli_body_enable_velocity_links(pli_body* body);

/// Returns to links in the position solve, the default. Bullet name: setSolver(Positions)
/// @return as pli_body_enable_velocity_links
PLI_API pli_status pli_body_disable_velocity_links(pli_body* body);

/// Solves links colour by colour, several at once: many times faster than in the order of the mesh, and without its
/// direction, in which a ball may roll off by itself (see pli_mesh_append_bending_links). Link indices stay those of
/// the mesh. Results differ as they would for a mesh with shuffled links; they depend neither on the instruction set
/// nor on threads. A body with few links, or with links that all meet in a node, keeps the order of the mesh.
/// @return as pli_body_enable_velocity_links
/// Cost: about 20 B per link.
PLI_API pli_status pli_body_enable_colored_links(pli_body* body);

/// Returns to the order of the mesh, the default. Does nothing when not enabled.
/// @return as pli_body_enable_velocity_links
PLI_API pli_status pli_body_disable_colored_links(pli_body* body);

/// Lets a body step less often, for bodies that are far away or hardly seen. One step of the body covers several steps
/// of the world and costs as much as one. It begins with the first of them; in the others the body does not move.
/// Bodies with the same interval take turns.
/// - Drawing: pli_body_write_vertices interpolates through the longer step, so that bodies neither lag nor jump; a
///   changed interval counts from the next long step on. Positions in pli_body_view are ahead by up to steps - 1 steps
///   of the world.
/// - Forces that are added act for one step of the world, as on other bodies.
/// - Results are those of the longer step: the position-based solver stretches more, XPBD needs as many times the
///   substeps. When the interval shrinks, steps get shorter, so use pli_body_enable_step_smoothing: from 4 to 1 a flag
///   that hangs with 1 m/s gets 9 m/s without it (position-based; 15 by implicit sweeps), and 3 (4) with it.
/// - Contacts: while a body touches a dynamic rigid body or another soft body, or is held to one by an anchor or joint,
///   it takes every step. Before that a fast body sinks in by as much as it moves in one long step.
/// @param steps 1 to 60, default 1; fewer where a step would be longer than PLI_MAX_TIME_STEP
/// @return PLI_ERROR_INVALID_VALUE, PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_set_update_interval(pli_body* body, int steps);

/// 1 unless pli_body_set_update_interval was called.
PLI_API int pli_body_get_update_interval(const pli_body* body);

/// True for a body that is left out of steps. A body freezes when a node leaves the limits of limits.h
/// (PLI_EVENT_BODY_FROZEN), or by pli_body_set_frozen.
PLI_API bool pli_body_is_frozen(const pli_body* body);

/// Takes a body out of the steps, or back in. A frozen body stays where it is, keeps its velocities and touches
/// nothing: other soft bodies and rigid bodies pass through it. Joints of other bodies to it hold; its own joints and
/// anchors do not. Forces that are added meanwhile are lost with each step.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_set_frozen(pli_body* body, bool frozen);

// ----------------------------------------------------------------------------------------------------------- sleep

// Sleep: a body that has come to rest is not stepped until something wakes it, and costs next to nothing meanwhile.
//
// Bodies that touch each other, or the same dynamic rigid body, fall asleep and wake together, with these rigid bodies.
// They count as touching when their bounding boxes overlap. A body without sleep keeps those awake that it touches.
// Asleep, all velocities are zero. A body is woken, in the step in which it happens, by
// - a rigid body that moves into its bounds or moves one of its anchors, or one below it that leaves the world, moves,
//   or gets other shapes, another mass or another friction;
// - another soft body that moves into its bounds, if both collide with soft bodies, or that has a joint to it;
// - each call that changes it (forces, velocities, nodes, materials, features, wind, cuts), a change of gravity, and
//   pli_body_set_asleep. Not by calls that are refused, by wind and targets set to what they already are, or by
//   disabling a feature that is not enabled.
//
// PLI_EVENT_BODY_ASLEEP and PLI_EVENT_BODY_AWAKE report it (world.h). In a Bullet world Bullet's islands decide
// (docs/state.md).

/// When a body counts as resting: for `time`, no node has moved further than speed * time from where it was. So nodes
/// may tremble, but not travel.
typedef struct pli_sleep_def {
    float speed;     ///< m/s, 0 to PLI_MAX_SPEED, default 0.05
    float time;      ///< s, above 0 to PLI_MAX_COEFFICIENT, default 0.5
    uint32_t cookie; ///< set by the default function
} pli_sleep_def;

/// Defaults of the fields.
PLI_API pli_sleep_def pli_sleep_def_default(void);

/// Lets a body fall asleep, or changes the settings. Dynamic rigid bodies that it touches fall asleep with it, if they
/// rest by the default settings; pli_rigid_integrate then leaves them where they are.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_INVALID_VALUE, PLI_ERROR_NOT_FINITE, PLI_ERROR_WRONG_STATE while stepping,
///         PLI_ERROR_OUT_OF_MEMORY
/// Cost: 12 B per node. Awake, one pass over the nodes per step; asleep, a few tests of boxes.
PLI_API pli_status pli_body_enable_sleep(pli_body* body, const pli_sleep_def* def);

/// Wakes the body for good. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_sleep(pli_body* body);

/// True for a body that sleeps (pli_body_enable_sleep): it is left out of steps until something wakes it.
PLI_API bool pli_body_is_asleep(const pli_body* body);

/// True for a body that may sleep and has rested for the time of its settings; asleep it stays true.
PLI_API bool pli_body_is_resting(const pli_body* body);

/// The rigid bodies that anchors and joints of a body hold, one entry per anchor and joint. For hosts that put bodies
/// to sleep themselves: what a sleeping body holds has to sleep too.
/// @param capacity of `rigids`, which may be NULL where it is 0
/// @return their number, which may be above the capacity
PLI_API int pli_body_get_held_rigids(const pli_body* body, int capacity, pli_rigid** rigids);

/// True: puts this body alone to sleep, whether it rests or not; its velocities become zero. False: wakes it in the
/// next step, with all that fell asleep with it.
/// @return PLI_ERROR_WRONG_STATE while stepping, or without pli_body_enable_sleep
PLI_API pli_status pli_body_set_asleep(pli_body* body, bool asleep);

// ------------------------------------------------------------------------------------- pairs that are switched off

/// Switches contacts (of nodes, faces and clusters) between a soft body and one rigid body off or on. By default they
/// are on. Bullet name: m_collisionDisabledObjects
/// @return PLI_ERROR_INVALID_VALUE for a rigid body of another world, PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_body_ignore_rigid(pli_body* body, pli_rigid* rigid, bool ignore);

/// True for a pair that is switched off.
PLI_API bool pli_body_ignores_rigid(const pli_body* body, const pli_rigid* rigid);

// ---------------------------------------------------------------------------------------------- measures

/// 64-bit FNV-1a hash of the bits of all positions and velocities, by words of 32 bits: equal for equal states on every
/// processor.
PLI_API uint64_t pli_body_state_hash(const pli_body* body);

/// Kinetic energy of the nodes that are not pinned, J.
PLI_API float pli_body_kinetic_energy(const pli_body* body);

/// Largest |length / rest length - 1| over the links; 0 without links.
PLI_API float pli_body_max_stretch(const pli_body* body);

/// Sum of mass * velocity over the nodes that are not pinned, kg m/s.
PLI_API pli_vec3 pli_body_momentum(const pli_body* body);

/// Signed volume enclosed by the faces, m^3; positive when they are counter-clockwise seen from outside.
PLI_API float pli_body_volume(const pli_body* body);

/// Memory of the body in bytes, features included.
PLI_API size_t pli_body_bytes(const pli_body* body);

/// A feature that is on, or one that another of them needs.
typedef struct pli_feature_cost {
    const char* name; ///< lives as long as the program; the same that pli_world_set_profile gives
    size_t bytes;     ///< that it holds now
    bool is_needed;   ///< is on only because another feature needs it
    bool has_passes;  ///< runs in some stage of a step
} pli_feature_cost;

/// The features that a body pays for, in the order of enabling. Any other feature takes neither time nor memory.
/// @param features NULL, or room for `capacity` features
/// @return the number of features
PLI_API int pli_body_get_features(const pli_body* body, int capacity, pli_feature_cost* features);

#ifdef __cplusplus
}
#endif
#endif
