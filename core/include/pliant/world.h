#ifndef PLIANT_WORLD_H
#define PLIANT_WORLD_H

/// The world: soft bodies, rigid proxies, gravity and the step.

#include "body.h"
#include "rigid.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What all bodies of a world have in common.
typedef struct pli_world_def {
    pli_vec3 gravity;  ///< m/s^2, up to PLI_MAX_ACCELERATION, default (0, -10, 0)
    float air_density; ///< kg/m^3, 0 to PLI_MAX_COEFFICIENT, default 1.2; read by aerodynamics
    /// m per step and axis that forces (not gravity) may add, > 0 to PLI_MAX_COORDINATE, default 1000.
    /// Bullet name: m_maxDisplacement
    float max_force_displacement;
    /// Default true: the first step after something was added or changed reserves memory for the contacts that bodies
    /// can be expected to have, and later steps allocate nothing (docs/costs.md). If there is no memory for it, later
    /// steps try again. False: lists grow when they are full.
    bool preallocates;
    /// Default false. True: as btSoftBody does it. Bounds of predicted bodies are taken before pose matching, which
    /// does not work for small and pinned bodies; forces of air, pressure and volume conservation have no limit; nodes
    /// lag behind kinematic bodies that they are anchored to.
    bool reference_mode;
    /// Default false. True: bodies fall asleep only by pli_body_set_asleep, and rigid bodies wake only those that are
    /// anchored to them. The host does the rest, as the bridge to Bullet does.
    bool host_puts_to_sleep;
    void* user_data; ///< of the caller, default NULL; see pli_world_get_user_data
    uint32_t cookie; ///< set by the default function
} pli_world_def;

/// Defaults of the fields.
PLI_API pli_world_def pli_world_def_default(void);

/// Makes a world without bodies.
/// @param def NULL for the defaults; copied
PLI_API pli_status pli_world_create(pli_context* context, const pli_world_def* def, pli_world** world);

/// Destroys a world with its bodies and rigid bodies, also between the parts of a step. NULL is allowed.
PLI_API void pli_world_destroy(pli_world* world);

/// The context that it was made in.
PLI_API pli_context* pli_world_get_context(const pli_world* world);

/// As in pli_world_def, m/s^2; zero for a handle that is none.
PLI_API pli_vec3 pli_world_get_gravity(const pli_world* world);

/// Changes gravity, for steps that are predicted from now on.
/// @param gravity m/s^2, up to PLI_MAX_ACCELERATION
PLI_API pli_status pli_world_set_gravity(pli_world* world, pli_vec3 gravity);

/// What the definition has stored with it.
PLI_API void* pli_world_get_user_data(const pli_world* world);

/// One whole step: predict, collide everything that overlaps, solve.
///
/// A step that runs out of memory goes on without the things that it has no memory for: contacts, pairs of
/// self-collision, anchors under the XPBD and the implicit solver. It then returns PLI_ERROR_OUT_OF_MEMORY, and
/// pli_last_error names a feature and the index of a body (pli_world_get_body). Every body that is not frozen has still
/// been stepped to the end, and the next step asks for the memory again: the host may go on, or free memory first. A
/// step in which nothing new appears allocates nothing, so it cannot run out of memory.
/// @param dt s, PLI_MIN_TIME_STEP to PLI_MAX_TIME_STEP. Divide a long frame into steps of 1/30 s or less, or let time
///         go slower: a single step of 0.25 s throws bodies that rest, and takes them through floors
/// @return PLI_ERROR_WRONG_STATE after pli_world_predict without pli_world_solve; after any error but
///         PLI_ERROR_OUT_OF_MEMORY nothing was done
PLI_API pli_status pli_world_step(pli_world* world, float dt);

/// First of the three parts of a step, for hosts with a broad phase of their own: applies forces and moves the nodes
/// freely. The order is: predict, any number of collide calls, solve. Rigid states may be set between any two of them.
/// Contacts are made from the state at the collide call; anchors and the solver use the state at the solve call.
/// Contacts take a pose as that of the start of the step, from which the velocities lead to its end. So move rigid
/// bodies after the collide calls or after the solve, not before: cloth on a lift of 5 m/s that was moved before them,
/// by 1/60 s, floats 0.083 m above it.
/// @param dt s, PLI_MIN_TIME_STEP to PLI_MAX_TIME_STEP
/// @return PLI_ERROR_WRONG_STATE when called out of order. Lack of memory is reported by pli_world_solve
PLI_API pli_status pli_world_predict(pli_world* world, float dt);

/// Makes the contacts of a soft body with a rigid body. Call it once per pair and step. It does nothing for a pair that
/// does not overlap, that is switched off (pli_body_ignore_rigid) or that no enabled feature handles.
/// @return PLI_ERROR_WRONG_STATE when called out of order, PLI_ERROR_INVALID_VALUE for a member of another world,
///         PLI_ERROR_OUT_OF_MEMORY: contacts of this pair are missing
PLI_API pli_status pli_world_collide_rigid(pli_world* world, pli_body* body, pli_rigid* rigid);

/// A soft body and a rigid body whose bounds overlap.
typedef struct pli_rigid_pair {
    pli_body* body;   ///< the soft one
    pli_rigid* rigid; ///< the rigid one
} pli_rigid_pair;

/// Makes the contacts of many pairs, with the result of pli_world_collide_rigid for one after the other, but with
/// bodies side by side on the threads of the context. Pairs of one body should follow each other; otherwise all is done
/// on one thread.
/// @param pairs [count]
/// @return as pli_world_collide_rigid. Nothing is done when a pair is wrong; after PLI_ERROR_OUT_OF_MEMORY contacts are
///         missing
PLI_API pli_status pli_world_collide_rigids(pli_world* world, const pli_rigid_pair* pairs, int count);

/// Makes the contacts between two soft bodies. Call it once per pair and step, in either order.
/// pli_body_collides_with_bodies says which bodies need it.
/// @return as pli_world_collide_rigid; PLI_ERROR_INVALID_VALUE also for a body with itself
PLI_API pli_status pli_world_collide_bodies(pli_world* world, pli_body* body_a, pli_body* body_b);

/// Two soft bodies whose bounds overlap.
typedef struct pli_body_pair {
    pli_body* body_a; ///< the first
    pli_body* body_b; ///< the second
} pli_body_pair;

/// Makes the contacts of many pairs of soft bodies, with the result of pli_world_collide_bodies for one after the
/// other, but side by side on the threads of the context.
/// @param pairs [count]
/// @return as pli_world_collide_bodies. Nothing is done when a pair is wrong; after PLI_ERROR_OUT_OF_MEMORY contacts
///         are missing
PLI_API pli_status pli_world_collide_body_pairs(pli_world* world, const pli_body_pair* pairs, int count);

/// Last part of a step: joints, constraints and contacts, velocities, and what follows from them.
/// @return PLI_ERROR_WRONG_STATE when called out of order; PLI_ERROR_OUT_OF_MEMORY, as pli_world_step, when memory was
///         missing in any part of the step, which was still done
PLI_API pli_status pli_world_solve(pli_world* world);

/// False when no enabled feature looks at other bodies, so that a host need not pass pairs with this one.
PLI_API bool pli_body_collides_with_bodies(const pli_body* body);

/// True between pli_world_predict and pli_world_solve.
PLI_API bool pli_world_is_stepping(const pli_world* world);

/// Number of soft bodies.
PLI_API int pli_world_body_count(const pli_world* world);

/// A soft body by its index, in the order of creation; NULL when out of range. Indices shift when one is destroyed.
PLI_API pli_body* pli_world_get_body(const pli_world* world, int index);

/// Number of rigid bodies; 0 for a wrong handle.
PLI_API int pli_world_rigid_count(const pli_world* world);

/// Rigid body `index`, in the order of creation, or NULL when it is out of range. Indices shift when one is destroyed.
PLI_API pli_rigid* pli_world_get_rigid(const pli_world* world, int index);

// ---------------------------------------------------------------------------------------------------- events

/// What has happened.
typedef enum pli_event_kind {
    /// A node became NaN, got beyond PLI_MAX_COORDINATE or faster than PLI_MAX_SPEED. All nodes were put back to where
    /// they were at the start of the step, at rest, and the body was frozen.
    PLI_EVENT_BODY_FROZEN = 1,
    /// Anchors or joints of the body are gone, because the rigid body that they held to was destroyed
    /// (pli_rigid_destroy, also by the bridge when a Bullet object is gone). One event per body, however many are gone.
    PLI_EVENT_ANCHORS_LOST = 2,
    /// A rigid body was given back the velocities that it had before pli_world_solve. Those from the solve were NaN or
    /// beyond PLI_MAX_SPEED or PLI_MAX_ANGULAR_SPEED, or a soft body was frozen in the solve while something touched
    /// the rigid body.
    PLI_EVENT_RIGID_RESTORED = 3,
    PLI_EVENT_BODY_ASLEEP = 4, ///< see pli_body_enable_sleep
    PLI_EVENT_BODY_AWAKE = 5   ///< likewise
} pli_event_kind;

/// Something that happened in a step, or since it.
typedef struct pli_event {
    pli_event_kind kind; ///< which fields are set depends on it
    pli_body* body;      ///< or NULL
    int node;            ///< PLI_NULL_INDEX when no single node is meant
    pli_rigid* rigid;    ///< or NULL
} pli_event;

/// Events of the last step and of calls since then. The next pli_world_predict clears them. The pointer is valid until
/// then, and until something is added or destroyed.
/// @param count receives the number of events; may be NULL
PLI_API const pli_event* pli_world_get_events(const pli_world* world, int* count);

// --------------------------------------------------------------------------------------------------- profile

/// Called where a part of a step begins and where it ends; parts nest. For all bodies together `stage` is "predict",
/// "joints", "solve" or "refresh", and `feature` is NULL. Inside these come the stages of single features ("forces",
/// "update", "position", ...), and between them "collide", each with the feature's name. "refresh" also comes when a
/// call other than a step places nodes or cuts. It may read only. While it is set, bodies are not stepped side by side.
typedef void pli_profile_fn(const char* stage, const char* feature, bool begins, void* user);

/// Sets the function that is called around the parts of a step.
/// @param profile NULL, the default, costs one comparison per stage
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_world_set_profile(pli_world* world, pli_profile_fn* profile, void* user);

#ifdef __cplusplus
}
#endif
#endif
