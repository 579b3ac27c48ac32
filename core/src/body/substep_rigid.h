#pragma once

/* Rigid bodies during the substeps of a step. Their owner moves them, before or after the solve; meanwhile they are on
   a path of their own, from where the step began, with the velocities that constraints change at once. Gravity
   comes in equal parts. What joints, springs and contacts of the owner did holds from the start, as it takes it: in
   equal parts it would be half a step late, and what turns on a hinge would swing up by itself. */

#include "body/rigid_impl.h"
#include "body/substep.h"

/* Before the first substep, of each that the body may push. */
void plii_substep_follow_rigid(pli_body* body, pli_rigid* rigid);
/* At the start of every substep, and after the last one. */
void plii_substep_rigids_restart(const pli_body* body, const plii_substep* substep);
/* dt: s, of a substep in their time */
void plii_substep_rigids_finish(pli_body* body, float dt);

typedef struct plii_substep_rigid_point {
    pli_rigid* rigid;
    pli_vec3 offset; /* from the centre of mass, world axes */
} plii_substep_rigid_point;

/* A point that turns with the rigid body from substep to substep. What hangs from an arm that stays as it was at the
   start of the step is righted half a step late, and swings up by itself. */
typedef struct plii_substep_rigid_pivot {
    plii_substep_rigid_point point;
    pli_vec3 start_offset; /* at the start of the step */
} plii_substep_rigid_pivot;

/* At the start of every substep. */
void plii_substep_rigid_pivot_turn(plii_substep_rigid_pivot* pivot);
/* m, in the substeps before this one */
static inline pli_vec3 plii_substep_rigid_pivot_moved(const plii_substep_rigid_pivot* pivot) {
    return pli_vec3_add(pivot->point.rigid->path.moved.linear, pli_vec3_sub(pivot->point.offset, pivot->start_offset));
}
/* m/s and rad/s, of the substep */
static inline plii_twist plii_substep_rigid_velocity(const pli_rigid* rigid) {
    return plii_twist_add(plii_rigid_velocity(rigid), rigid->path.drift);
}
/* m, within the substep */
static inline pli_vec3 plii_substep_rigid_point_motion(const plii_substep_rigid_point* point,
                                                       const plii_substep* substep) {
    const plii_twist velocity = plii_substep_rigid_velocity(point->rigid);
    return pli_vec3_scale(pli_vec3_add(velocity.linear, pli_vec3_cross(velocity.angular, point->offset)),
                          substep->host_dt);
}
/* A correction in kg m, as the multiplier times a gradient; the opposite of what the node gets. */
static inline void plii_substep_rigid_point_push(const plii_substep_rigid_point* point, pli_vec3 push,
                                                 const plii_substep* substep) {
    if (point->rigid->state.inverse_mass == 0.0f) { return; } /* and nothing is written, as others may touch it too */
    plii_rigid_apply_impulse(point->rigid, pli_vec3_scale(push, substep->inverse_host_dt), point->offset);
    point->rigid->path.is_pushed = true;
}
/* m, of what is left before a rigid body is held hard: a share per time, less the nearer it is, so that it does not
   jerk to and fro while light nodes between make that a little more and a little less. */
#define PLII_SUBSTEP_BRAKING 0.1f   /* s */
#define PLII_SUBSTEP_SOFT_END 0.02f /* m */
static inline float plii_substep_braked(float room, const plii_substep* substep) {
    return room * plii_min(room / PLII_SUBSTEP_SOFT_END, 1.0f) * plii_min(substep->dt / PLII_SUBSTEP_BRAKING, 1.0f);
}
/* The room, m, that leaves a motion of so many m as it is. */
static inline float plii_substep_unbraked(float way, const plii_substep* substep) {
    return plii_max(way * plii_max(PLII_SUBSTEP_BRAKING * substep->inverse_dt, 1.0f), PLII_SUBSTEP_SOFT_END);
}
/* Moves the rigid body, m, and leaves its velocity. */
static inline void plii_substep_rigid_point_shift(const plii_substep_rigid_point* point, pli_vec3 shift) {
    plii_rigid_path* path = &point->rigid->path;
    path->moved.linear = pli_vec3_add(path->moved.linear, shift);
    path->is_pushed = true;
}
/* Inverse of the mass that the point shows along a unit vector, 1/kg; along another one times its squared length. */
static inline float plii_substep_rigid_point_weight(const plii_substep_rigid_point* point, pli_vec3 direction) {
    const pli_vec3 arm = pli_vec3_cross(point->offset, direction);
    const pli_vec3 spin = plii_rigid_spin_of(point->rigid, direction, point->offset);
    return plii_rigid_linear_response(point->rigid, direction) + pli_vec3_dot(arm, spin);
}
