/* The joint that holds two points together. Bullet: LJoint, in its order of operations. */

#include "cluster/joint_impl.h"

/* Errors are corrected as if they were not longer than this, m. */
#define LINEAR_JOINT_MAX_ERROR 4.0f

static void linear_joint_prepare(plii_joint* joint, float dt, int iterations) {
    pli_vec3 points[2];
    for (int i = 0; i < 2; ++i) {
        const plii_joint_end* side = &joint->sides[i];
        points[i] = pli_transform_point(side->frame, pli_vec3_sub(joint->local[i], side->rest_centre));
    }
    pli_vec3 error = pli_vec3_sub(points[0], points[1]);
    const float squared = pli_vec3_length_squared(error);
    if (squared > LINEAR_JOINT_MAX_ERROR * LINEAR_JOINT_MAX_ERROR) {
        error = plii_vec3_divide(pli_vec3_scale(error, LINEAR_JOINT_MAX_ERROR), sqrtf(squared));
    }
    joint->drift = plii_vec3_divide(pli_vec3_scale(error, joint->softness.error_reduction), dt);
    joint->world[0] = pli_vec3_sub(points[0], joint->sides[0].frame.origin);
    joint->world[1] = pli_vec3_sub(points[1], joint->sides[1].frame.origin);
    joint->impulse_matrix =
        plii_joint_impulse_matrix(&joint->sides[0], joint->world[0], &joint->sides[1], joint->world[1]);
    plii_joint_split_drift(joint, iterations, plii_joint_end_response(&joint->sides[0], joint->world[0], error),
                           plii_joint_end_response(&joint->sides[1], joint->world[1], error));
}

static pli_vec3 linear_joint_solve(const plii_joint* joint) {
    const pli_vec3 velocity = pli_vec3_sub(plii_joint_velocity_at(&joint->sides[0].target, joint->world[0]),
                                           plii_joint_velocity_at(&joint->sides[1].target, joint->world[1]));
    const pli_vec3 change = pli_vec3_add(joint->drift, pli_vec3_scale(velocity, joint->softness.velocity_factor));
    return pli_mat3_mul_vec3(joint->impulse_matrix, change);
}

const plii_joint_class plii_linear_joint_class = {false, linear_joint_prepare, linear_joint_solve};

PLII_DEFINE_DEFAULT(pli_linear_joint_def, .softness = {1.0f, 1.0f, 1.0f})
pli_status pli_body_add_linear_joint(pli_body* body, const pli_linear_joint_def* def, pli_joint_id* joint) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(PLII_CHECK_MADE(body->context, pli_linear_joint_def, def, __func__));
    plii_joint made = {
        .klass = &plii_linear_joint_class, .cluster = def->cluster, .other = def->other, .softness = def->softness};
    return plii_joint_add(body, &made, def->position, joint, __func__);
}
