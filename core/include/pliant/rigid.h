#ifndef PLIANT_RIGID_H
#define PLIANT_RIGID_H

/// Rigid bodies as soft bodies see them: pose, velocities, mass, friction and shapes. The core does not move them by
/// itself. The host (a rigid-body engine, or the caller) owns their motion, and reads back the velocities that contacts
/// and anchors have changed. Rigid bodies do not collide with each other here; an engine does that.

#include "shape.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pli_world pli_world;
typedef struct pli_rigid pli_rigid;

/// Who moves a rigid body.
typedef enum pli_rigid_kind {
    PLI_RIGID_STATIC = 0, ///< nobody: floors and walls; velocities are ignored
    /// The host alone: lifts, hands, characters. Its velocities drag soft bodies, and impulses do not change it. The
    /// pose set before pli_world_step is that of the start of the step, and the velocities lead from there: anchored
    /// nodes end at the pose plus velocity times dt, where the character is to be drawn.
    PLI_RIGID_KINEMATIC = 1,
    PLI_RIGID_DYNAMIC = 2 ///< host and soft bodies: impulses change its velocities
} pli_rigid_kind;

/// What the host sets before a step and reads after it.
typedef struct pli_rigid_state {
    pli_transform pose;             ///< origin = centre of mass, m, up to PLI_MAX_COORDINATE; its rotation, without
                                    ///< scale, shear or mirror beyond 1 %; default identity
    pli_vec3 linear_velocity;       ///< m/s, up to PLI_MAX_SPEED, default zero
    pli_vec3 angular_velocity;      ///< rad/s, up to PLI_MAX_ANGULAR_SPEED, default zero
    float inverse_mass;             ///< 1/kg, of PLI_MIN_MASS to PLI_MAX_MASS for dynamic, ignored otherwise
    pli_mat3 inverse_inertia_world; ///< 1/(kg m^2), up to PLI_MAX_INVERSE_INERTIA, ignored unless dynamic; default
                                    ///< zero: contacts do not turn it
} pli_rigid_state;

/// A rigid body.
typedef struct pli_rigid_def {
    pli_rigid_kind kind;              ///< default PLI_RIGID_STATIC
    pli_rigid_state state;            ///< defaults as named there; dynamic bodies need mass and inertia
    float friction;                   ///< 0 to PLI_MAX_FACTOR, default 0.5; multiplied with the soft body's
    float restitution;                ///< 0 to PLI_MAX_FACTOR, default 1; multiplied with the soft body's
    pli_vec3 linear_factor;           ///< per-axis scale of linear impulses, up to PLI_MAX_FACTOR, default 1
    pli_vec3 angular_factor;          ///< per-axis scale of angular impulses, up to PLI_MAX_FACTOR, default 1
    int shape_count;                  ///< number of entries in `shapes`, default 0: it touches nothing
    pli_shape* const* shapes;         ///< [shape_count]; each is retained
    const pli_transform* shape_poses; ///< [shape_count] in the frame of the body; default NULL: all identity
    void* user_data;                  ///< of the caller, default NULL; see pli_rigid_get_user_data
    uint32_t cookie;                  ///< set by the default function
} pli_rigid_def;

/// Defaults of the fields.
PLI_API pli_rigid_def pli_rigid_def_default(void);

/// Adds a rigid body to a world. pli_world_step meets all of them with all soft bodies.
/// @param def copied
PLI_API pli_status pli_rigid_create(pli_world* world, const pli_rigid_def* def, pli_rigid** rigid);

/// Destroys a rigid body, with the anchors and joints that hold to it; a body that had any gets PLI_EVENT_ANCHORS_LOST.
/// NULL is allowed. Not while stepping: it then stays, and pli_last_error says so.
PLI_API void pli_rigid_destroy(pli_rigid* rigid);

/// Sets pose, velocities and mass, before a step or between its parts. Fields that the kind ignores are not checked.
PLI_API pli_status pli_rigid_set_state(pli_rigid* rigid, const pli_rigid_state* state);

/// Leads a kinematic body to a pose within the next step: sets the velocities that take it there from its present pose,
/// straight and the shorter way round. Call it before each step, and pli_rigid_integrate after the step, which puts the
/// body there. What is anchored to it, and what touches it, then follows to where it is drawn. To put a body elsewhere
/// without a motion use pli_rigid_set_state. So too for a character that faces about within one frame, and
/// pli_body_transform for its clothes: swept around by half a turn they may stay caught on the wrong side of a limb.
/// @param pose as in pli_rigid_state
/// @param dt   s, PLI_MIN_TIME_STEP to PLI_MAX_TIME_STEP, that of the step
/// @return PLI_ERROR_WRONG_STATE for a body that is not kinematic; PLI_ERROR_INVALID_VALUE also when it would be faster
///         than the limits
PLI_API pli_status pli_rigid_move(pli_rigid* rigid, pli_transform pose, float dt);

/// The present state. After a step its velocities are those that soft bodies have left.
PLI_API pli_rigid_state pli_rigid_get_state(const pli_rigid* rigid);

/// Changes the friction.
/// @param friction 0 to PLI_MAX_FACTOR; multiplied with the soft body's
PLI_API pli_status pli_rigid_set_friction(pli_rigid* rigid, float friction);

/// As in pli_rigid_def; for soft bodies with pli_body_enable_restitution.
/// @return PLI_ERROR_INVALID_VALUE, PLI_ERROR_NOT_FINITE
PLI_API pli_status pli_rigid_set_restitution(pli_rigid* rigid, float restitution);

/// Scales the effect of impulses along each world axis: 0 holds the body, 1 leaves it free. Bullet: setLinearFactor,
/// setAngularFactor. What linear_factor takes from an impulse has no torque either, as in Bullet (not under the
/// implicit solver): factors make no hinge or seesaw, for which the host holds the centre.
/// @param linear_factor,angular_factor up to PLI_MAX_FACTOR
PLI_API pli_status pli_rigid_set_factors(pli_rigid* rigid, pli_vec3 linear_factor, pli_vec3 angular_factor);

/// Changes the kind and sets the state, as pli_rigid_set_state. Anchors stay.
PLI_API pli_status pli_rigid_set_kind(pli_rigid* rigid, pli_rigid_kind kind, const pli_rigid_state* state);

/// Replaces the shapes, keeping anchors. Contacts of the step in progress stay as they were made.
/// @param shapes      [shape_count]; each is retained, the old ones are released
/// @param shape_poses [shape_count] in the frame of the body; NULL: all identity
/// @return PLI_ERROR_OUT_OF_MEMORY
PLI_API pli_status pli_rigid_set_shapes(pli_rigid* rigid, int shape_count, pli_shape* const* shapes,
                                        const pli_transform* shape_poses);

/// For hosts whose body is out of their world for a while, or disappears in the middle of a step. A rigid body that is
/// not present touches nothing; anchors and joints to it are kept, but have no effect. Contacts of the step in progress
/// stay as they were made. By default a body is present.
PLI_API pli_status pli_rigid_set_present(pli_rigid* rigid, bool is_present);

/// False after pli_rigid_set_present with false.
PLI_API bool pli_rigid_is_present(const pli_rigid* rigid);

/// A sensor takes part in no contact: bodies pass through it, and those with pli_body_enable_contact_events report that
/// they are in it. Anchors and joints to it hold. Default false. Contacts of the step in progress stay as they were
/// made.
PLI_API pli_status pli_rigid_set_sensor(pli_rigid* rigid, bool is_sensor);

/// As set by pli_rigid_set_sensor.
PLI_API bool pli_rigid_is_sensor(const pli_rigid* rigid);

/// True for a dynamic body that fell asleep with the soft bodies that it touches (pli_body_enable_sleep). Its
/// velocities are zero, and pli_rigid_integrate leaves it where it is, as should a host that moves bodies itself. It
/// wakes with the soft bodies, or when it is given another pose or a velocity.
PLI_API bool pli_rigid_is_asleep(const pli_rigid* rigid);

/// As in pli_rigid_def or pli_rigid_set_kind.
PLI_API pli_rigid_kind pli_rigid_get_kind(const pli_rigid* rigid);

/// What the definition has stored with it.
PLI_API void* pli_rigid_get_user_data(const pli_rigid* rigid);

/// True when a contact or an anchor acted on the body in the last step: the host should wake it.
PLI_API bool pli_rigid_was_touched(const pli_rigid* rigid);

/// How far soft bodies have moved a dynamic body in the last step from where it was in pli_world_solve. A host that
/// moves its bodies before the solve, as Bullet does, should move this one by that as well: the implicit solver, XPBD
/// and contacts of faces move rigid bodies along while they solve, and rely on it. pli_rigid_integrate does so.
/// @param shift    m, world axes; zero where it returns false; may be NULL
/// @param rotation rad, axis times angle, world axes, about the centre of mass; likewise
/// @return false when there is nothing to move
PLI_API bool pli_rigid_get_shift(const pli_rigid* rigid, pli_vec3* shift, pli_vec3* rotation);

/// Moves a rigid body freely, for C programs without a rigid-body engine: v += gravity * dt, the pose by v and the
/// angular velocity, the inertia turned with it. Call it after pli_world_step. If the body was touched in the step,
/// gravity changes v only at the start of the next one, so that what holds the body takes it back: a body at rest has v
/// = 0. The angular velocity stays, as without gyroscopic torque, not the angular momentum of what tumbles. Kinematic
/// bodies move without gravity, static ones not at all.
/// @param gravity m/s^2, up to PLI_MAX_ACCELERATION
/// @param dt      s, PLI_MIN_TIME_STEP to PLI_MAX_TIME_STEP
/// @return PLI_ERROR_INVALID_VALUE also when the body would leave the limits; it then stays as it was
PLI_API pli_status pli_rigid_integrate(pli_rigid* rigid, pli_vec3 gravity, float dt);

#ifdef __cplusplus
}
#endif
#endif
