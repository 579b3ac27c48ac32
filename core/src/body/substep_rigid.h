#ifndef PLII_SUBSTEP_RIGID_H
#define PLII_SUBSTEP_RIGID_H

/* A point of a rigid body during the substeps of a step. The body itself is moved by its owner, after the step; until
   then its points move with its velocities, which constraints change at once. */

#include "body/rigid_impl.h"
#include "body/substep.h"

typedef struct plii_substep_rigid_point {
    pli_rigid* rigid;
    pli_vec3 offset; /* from the centre of mass, world axes */
    pli_vec3 moved;  /* m, in the substeps before this one */
} plii_substep_rigid_point;

/* To be called at the start of every substep. */
static inline void plii_substep_rigid_point_restart(plii_substep_rigid_point* point, const plii_substep* substep) {
    if (substep->index == 0) {
        point->moved = pli_vec3_make(0, 0, 0);
        return;
    }
    point->moved =
        pli_vec3_add(point->moved, pli_vec3_scale(plii_rigid_velocity_at(point->rigid, point->offset), substep->dt));
}
/* m, within the substep */
static inline pli_vec3 plii_substep_rigid_point_motion(const plii_substep_rigid_point* point,
                                                       const plii_substep* substep) {
    return pli_vec3_scale(plii_rigid_velocity_at(point->rigid, point->offset), substep->dt);
}
/* A correction in kg m, as the multiplier times a gradient; the opposite of what the node gets. */
static inline void plii_substep_rigid_point_push(const plii_substep_rigid_point* point, pli_vec3 push,
                                                 const plii_substep* substep) {
    plii_rigid_apply_impulse(point->rigid, pli_vec3_scale(push, substep->inverse_dt), point->offset);
}
/* Inverse of the mass that the point shows along a unit vector, 1/kg. */
static inline float plii_substep_rigid_point_weight(const plii_substep_rigid_point* point, pli_vec3 direction) {
    const pli_rigid* rigid = point->rigid;
    const pli_vec3 arm = pli_vec3_cross(point->offset, direction);
    return rigid->state.inverse_mass + pli_vec3_dot(arm, pli_mat3_mul_vec3(rigid->state.inverse_inertia_world, arm));
}

#endif
