/* Velocities that lead a kinematic body to a pose. */

#include "body/world_state.h"
#include "math/rotation_fit.h"

/* Of the size of a pose, and radians: what rounding leaves of the way to where a body is already. */
#define MOVE_ROUNDING 1e-6f

/* Axis times angle, the shorter way round. */
static pli_vec3 move_rotation(const pli_mat3* from, const pli_mat3* to) {
    const pli_mat3 way = pli_mat3_mul(*to, pli_mat3_transpose(*from));
    pli_quat fit = pli_quat_identity();
    (void)plii_rotation_fit(&way, &fit);
    const pli_vec3 axis = pli_vec3_make(fit.x, fit.y, fit.z);
    const float sine = pli_vec3_length(axis), angle = 2.0f * atan2f(sine, fit.w);
    return angle > MOVE_ROUNDING ? pli_vec3_scale(axis, angle / sine) : pli_vec3_make(0, 0, 0);
}

pli_status pli_rigid_move(pli_rigid* rigid, pli_transform pose, float dt) {
    PLII_TRY(plii_check_rigid_change(rigid, __func__));
    PLII_FAIL_IF(rigid->kind != PLI_RIGID_KINEMATIC, rigid->context, PLI_ERROR_WRONG_STATE, __func__,
                 "the rigid body is not kinematic");
    const pli_rigid_state target = {.pose = pose};
    PLII_TRY(plii_rigid_judge_state(rigid->context, PLI_RIGID_STATIC, &target, __func__)); /* its pose */
    PLII_TRY(plii_check_between(rigid->context, dt, PLI_MIN_TIME_STEP, PLI_MAX_TIME_STEP, "dt", __func__));
    pli_rigid_state state = rigid->state;
    const pli_vec3 way = pli_vec3_sub(pose.origin, state.pose.origin);
    const bool stays = pli_vec3_length(way) <= MOVE_ROUNDING * (1.0f + pli_vec3_length(pose.origin));
    const pli_vec3 rotation = move_rotation(&state.pose.rotation, &pose.rotation);
    state.linear_velocity = pli_vec3_scale(way, stays ? 0.0f : 1.0f / dt);
    state.angular_velocity = pli_vec3_scale(rotation, 1.0f / dt);
    return plii_rigid_change(rigid, rigid->kind, &state, __func__);
}
