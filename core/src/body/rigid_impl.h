#ifndef PLII_RIGID_IMPL_H
#define PLII_RIGID_IMPL_H

#include "base/context.h"
#include "base/handle.h"
#include "math/range.h"
#include "math/vec.h"
#include "pliant/rigid.h"

struct pli_rigid {
    uint32_t magic;
    pli_world* world;
    pli_context* context;
    int world_index;
    void* user_data;
    pli_rigid_kind kind;
    /* For static and kinematic bodies the inverse mass and inertia are zero, for static ones the velocities too. */
    pli_rigid_state state;
    float friction;
    pli_vec3 linear_factor, angular_factor;
    bool is_absent; /* pli_rigid_set_present */
    bool was_touched, needs_reintegration;
    unsigned pose_version;                                  /* counts changes of the pose by its host */
    pli_vec3 given_linear_velocity, given_angular_velocity; /* of the last pli_rigid_set_state */
    pli_vec3 start_linear_velocity, start_angular_velocity; /* before the impulses of this step; of one touched in it */
    int shape_count, shape_capacity, shape_pose_capacity;
    pli_shape** shapes;
    pli_transform* shape_poses;
};

/* PLI_OK, or the error of a null or wrong handle. */
static inline pli_status plii_check_rigid(const pli_rigid* rigid, const char* function) {
    return plii_check_handle(rigid, PLII_HANDLE_RIGID, NULL, NULL, function);
}
/* World pose of shape `index`. */
pli_transform plii_rigid_shape_transform(const pli_rigid* rigid, int index);
/* World bounds over all shapes. */
pli_bounds plii_rigid_bounds(const pli_rigid* rigid);
/* Where velocities bring a body. */
pli_transform plii_rigid_advance(pli_transform pose, pli_vec3 linear_velocity, pli_vec3 angular_velocity, float dt);
/* Of the body here and there. */
pli_bounds plii_rigid_swept_bounds(const pli_rigid* rigid, float dt);

/* False for velocities that are NaN or beyond the limits. */
static inline bool plii_rigid_is_slow(const pli_rigid* rigid) {
    return plii_vec3_is_within(rigid->state.linear_velocity, PLI_MAX_SPEED) &&
           plii_vec3_is_within(rigid->state.angular_velocity, PLI_MAX_ANGULAR_SPEED);
}

static inline void plii_rigid_keep_velocities(pli_rigid* rigid) {
    rigid->start_linear_velocity = rigid->state.linear_velocity;
    rigid->start_angular_velocity = rigid->state.angular_velocity;
}
/* To be called before the first impulse of a step. */
static inline void plii_rigid_touch(pli_rigid* rigid) {
    if (rigid->was_touched) { return; }
    rigid->was_touched = true;
    plii_rigid_keep_velocities(rigid);
}

/* Velocity at an offset from the centre of mass. */
static inline pli_vec3 plii_rigid_velocity_at(const pli_rigid* rigid, pli_vec3 offset) {
    return pli_vec3_add(rigid->state.linear_velocity, pli_vec3_cross(rigid->state.angular_velocity, offset));
}

/* btRigidBody::applyImpulse, same order of operations. Nothing unless the body is dynamic. */
static inline void plii_rigid_apply_impulse(pli_rigid* rigid, pli_vec3 impulse, pli_vec3 offset) {
    if (rigid->state.inverse_mass == 0.0f) { return; }
    const pli_vec3 scaled = pli_vec3_mul(impulse, rigid->linear_factor);
    rigid->state.linear_velocity =
        pli_vec3_add(rigid->state.linear_velocity, pli_vec3_scale(scaled, rigid->state.inverse_mass));
    const pli_vec3 torque = pli_vec3_cross(offset, scaled);
    const pli_vec3 spin = pli_mat3_mul_vec3(rigid->state.inverse_inertia_world, torque);
    rigid->state.angular_velocity =
        pli_vec3_add(rigid->state.angular_velocity, pli_vec3_mul(spin, rigid->angular_factor));
}

/* btRigidBody::applyTorqueImpulse. */
static inline void plii_rigid_apply_torque_impulse(pli_rigid* rigid, pli_vec3 impulse) {
    const pli_vec3 spin = pli_mat3_mul_vec3(rigid->state.inverse_inertia_world, impulse);
    rigid->state.angular_velocity =
        pli_vec3_add(rigid->state.angular_velocity, pli_vec3_mul(spin, rigid->angular_factor));
}

/* Impulse that changes the relative displacement of a point mass and a rigid body at `offset` by one unit per step:
   (1/dt) * inverse(inverse_mass * I + inverse_mass_b * I - [offset]x W [offset]x). Bullet: ImpulseMatrix(dt, ...) */
pli_mat3 plii_effective_mass(float dt, float point_inverse_mass, float rigid_inverse_mass,
                             pli_mat3 rigid_inverse_inertia, pli_vec3 offset);

#endif
