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
    /// Default true: the first step after something was added or changed makes room for the contacts that bodies can be
    /// expected to have, and later steps allocate nothing (docs/costs.md); without memory for it later steps try again.
    /// False: lists grow when they are full.
    bool preallocates;
    /// Reference mode only: as btSoftBody does it, default false. Bounds of predicted bodies are those from before pose
    /// matching, which does not work for small and pinned ones, the forces of air, pressure and volume conservation
    /// have no limit, and nodes lag behind kinematic bodies that they are anchored to.
    bool reference_mode;
    /// Default false. True: bodies fall asleep by pli_body_set_asleep alone, and rigid bodies wake those alone that are
    /// anchored to them; the host does the rest, as the bridge to Bullet does.
    bool host_puts_to_sleep;
    void* user_data; ///< of the caller, default NULL; see pli_world_get_user_data
    uint32_t cookie; ///< set by the default function
} pli_world_def;

/// Defaults of the fields.
PLI_API pli_world_def pli_world_def_default(void);

/// Makes a world without bodies.
/// @param def NULL for the defaults; copied
PLI_API pli_status pli_world_create(pli_context* context, const pli_world_def* def, pli_world** world);

/// Ends a world with its bodies and rigid proxies, also between the parts of a step. NULL is allowed.
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
/// Out of memory a step goes on, without what there is no memory for: contacts, pairs of self-collision, anchors under
/// the XPBD and the implicit solver. PLI_ERROR_OUT_OF_MEMORY means that this happened; pli_last_error names a feature
/// and the index of a body (pli_world_get_body). Every body that is not frozen has been stepped to its end then, and
/// the next step asks for the memory anew: the host may go on, or free memory first. Steps into which nothing new comes
/// allocate nothing, and so cannot run out of it.
/// @param dt s, PLI_MIN_TIME_STEP to PLI_MAX_TIME_STEP. Cut a frame that took long into steps of 1/30 s or less, or let
///           time go slower: a single step of 0.25 s throws what rests, and takes it through floors
/// @return PLI_ERROR_WRONG_STATE after pli_world_predict without pli_world_solve; after any error but
///         PLI_ERROR_OUT_OF_MEMORY nothing was done
PLI_API pli_status pli_world_step(pli_world* world, float dt);

/// First of the three parts of a step, for hosts with a broad phase of their own: applies forces and moves the nodes
/// freely. The order is: predict, any number of collide calls, solve. Rigid states may be set between any two of them:
/// contacts are made from the state at the collide call, anchors and the solver use the state at the solve call. For
/// contacts a pose is that of the start of the step, from which the velocities lead to its end: move rigid bodies after
/// the collide calls or after the solve, not before. Cloth on a lift of 5 m/s that was moved before them, by 1/60 s,
/// floats 0.083 m above it.
/// @param dt s, PLI_MIN_TIME_STEP to PLI_MAX_TIME_STEP
/// @return PLI_ERROR_WRONG_STATE when called out of order. What there is no memory for pli_world_solve tells
PLI_API pli_status pli_world_predict(pli_world* world, float dt);

/// Makes the contacts of a soft body with a rigid body; once per pair and step. Nothing is done for a pair that does
/// not overlap, that is switched off (pli_body_ignore_rigid) or that no enabled feature takes care of.
/// @return PLI_ERROR_WRONG_STATE when called out of order, PLI_ERROR_INVALID_VALUE for a member of another world,
///         PLI_ERROR_OUT_OF_MEMORY: contacts of this pair are missing
PLI_API pli_status pli_world_collide_rigid(pli_world* world, pli_body* body, pli_rigid* rigid);

/// A soft body and a rigid body whose bounds overlap.
typedef struct pli_rigid_pair {
    pli_body* body;   ///< the soft one
    pli_rigid* rigid; ///< the rigid one
} pli_rigid_pair;

/// Makes the contacts of many pairs, as pli_world_collide_rigid does for one after the other, bodies side by side on
/// the threads that there are. Pairs of one body should follow each other; where they do not all is done on one thread.
/// @param pairs [count]
/// @return as pli_world_collide_rigid; nothing is done when a pair is wrong, PLI_ERROR_OUT_OF_MEMORY: contacts are
///         missing
PLI_API pli_status pli_world_collide_rigids(pli_world* world, const pli_rigid_pair* pairs, int count);

/// Makes the contacts between two soft bodies, as pli_world_collide_rigid; once per pair and step, in either order.
/// pli_body_collides_with_bodies tells which bodies need it.
/// @return the same, PLI_ERROR_INVALID_VALUE also for a body with itself
PLI_API pli_status pli_world_collide_bodies(pli_world* world, pli_body* body_a, pli_body* body_b);

/// Two soft bodies whose bounds overlap.
typedef struct pli_body_pair {
    pli_body* body_a; ///< the first
    pli_body* body_b; ///< the second
} pli_body_pair;

/// Makes the contacts of many pairs of soft bodies, as pli_world_collide_bodies does for one after the other, side by
/// side on the threads that there are: contacts are the same, in the same order.
/// @param pairs [count]
/// @return as pli_world_collide_bodies; nothing is done when a pair is wrong, PLI_ERROR_OUT_OF_MEMORY: contacts are
///         missing
PLI_API pli_status pli_world_collide_body_pairs(pli_world* world, const pli_body_pair* pairs, int count);

/// Last part of a step: joints, constraints and contacts, velocities, and what follows from them.
/// @return PLI_ERROR_WRONG_STATE when called out of order, PLI_ERROR_OUT_OF_MEMORY, as of pli_world_step: something was
///         missing anywhere in the step, which has been done
PLI_API pli_status pli_world_solve(pli_world* world);

/// False where no enabled feature looks at other bodies, so that a host need not hand in such pairs.
PLI_API bool pli_body_collides_with_bodies(const pli_body* body);

/// True between pli_world_predict and pli_world_solve.
PLI_API bool pli_world_is_stepping(const pli_world* world);

/// Number of soft bodies.
PLI_API int pli_world_body_count(const pli_world* world);

/// A soft body by its index, which those behind it change when one before them goes; NULL when out of range.
PLI_API pli_body* pli_world_get_body(const pli_world* world, int index);

/// Number of rigid bodies; 0 for a wrong handle.
PLI_API int pli_world_rigid_count(const pli_world* world);

/// Rigid body `index`, in the order of creation, or NULL when it is out of range. Indices shift when one is destroyed.
PLI_API pli_rigid* pli_world_get_rigid(const pli_world* world, int index);

// ---------------------------------------------------------------------------------------------------- events

/// What has happened.
typedef enum pli_event_kind {
    /// A node came to be NaN, beyond PLI_MAX_COORDINATE or faster than PLI_MAX_SPEED; all nodes were put
    /// back to where they were at the start of the step, at rest, and the body was frozen.
    PLI_EVENT_BODY_FROZEN = 1,
    /// Anchors or joints of the body have gone with the rigid body that they held to: pli_rigid_destroy, and what the
    /// bridge to Bullet does when an object is no longer there. One for a body, however many have gone.
    PLI_EVENT_ANCHORS_LOST = 2,
    /// A rigid body has the velocities that it had before pli_world_solve: those that the solve gave it were NaN, or
    /// beyond PLI_MAX_SPEED or PLI_MAX_ANGULAR_SPEED, or a body was put back and frozen in the solve while something
    /// touched the rigid body.
    PLI_EVENT_RIGID_RESTORED = 3,
    PLI_EVENT_BODY_ASLEEP = 4, ///< see pli_body_enable_sleep
    PLI_EVENT_BODY_AWAKE = 5   ///< likewise
} pli_event_kind;

/// Something that has gone another way than asked.
typedef struct pli_event {
    pli_event_kind kind; ///< which fields are set depends on it
    pli_body* body;      ///< or NULL
    int node;            ///< PLI_NULL_INDEX when no single node is meant
    pli_rigid* rigid;    ///< or NULL
} pli_event;

/// Events of the last step and of calls since then, which the next pli_world_predict clears; valid until it, and until
/// something is added or destroyed.
/// @param count receives the number of events; may be NULL
PLI_API const pli_event* pli_world_get_events(const pli_world* world, int* count);

// --------------------------------------------------------------------------------------------------- profile

/// Called where a part of a step begins and where it ends; parts nest. `stage` is "predict", "joints", "solve" or
/// "refresh" for all bodies together, with `feature` NULL; inside these the stage of one body's feature ("forces",
/// "update", "position", ...), and between them "collide", each with the feature's name. "refresh" also comes where a
/// call other than a step places nodes or cuts. May read only. While it is set, bodies are not stepped side by side.
typedef void pli_profile_fn(const char* stage, const char* feature, bool begins, void* user);

/// Sets the function that is called around the parts of a step.
/// @param profile NULL, the default, costs one comparison per stage
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_world_set_profile(pli_world* world, pli_profile_fn* profile, void* user);

#ifdef __cplusplus
}
#endif
#endif
