/* The joint about one axis, driven and steered by a controller. Bullet: AJoint, in its order of operations. */

#include "cluster/joint_impl.h"

/* Errors are corrected as if they were not larger than this, rad. */
#define ANGULAR_JOINT_MAX_ERROR (3.1415926535897932384626433832795029f / 16.0f)

/* False for an axis without a direction. One that is a unit vector but for rounding stays as it is, bit for bit. */
static bool angular_joint_make_unit(pli_vec3* axis) {
    const float length_squared = pli_vec3_length_squared(*axis);
    if (fabsf(length_squared - 1.0f) <= 1e-5f) { return true; }
    if (!(length_squared > FLT_MIN) || !plii_is_finite(length_squared)) { return false; }
    *axis = plii_vec3_divide(*axis, sqrtf(length_squared));
    return true;
}

static void angular_joint_prepare(plii_joint* joint, float dt, int iterations) {
    if (joint->controller.steer != NULL) {
        pli_vec3 axis = joint->controller.steer(joint->local[0], joint->controller.user);
        if (angular_joint_make_unit(&axis)) { joint->local[0] = axis; }
    }
    joint->world[0] = pli_mat3_mul_vec3(joint->sides[0].frame.rotation, joint->local[0]);
    joint->world[1] = pli_mat3_mul_vec3(joint->sides[1].frame.rotation, joint->local[1]);
    const float cosine = plii_clamp(pli_vec3_dot(joint->world[0], joint->world[1]), -1.0f, 1.0f);
    const pli_vec3 cross = pli_vec3_cross(joint->world[1], joint->world[0]);
    pli_vec3 error = plii_vec3_unit_or(cross, PLII_EPSILON, pli_vec3_make(0, 0, 0));
    error = pli_vec3_scale(error, plii_min(ANGULAR_JOINT_MAX_ERROR, acosf(cosine)));
    joint->drift = pli_vec3_scale(error, joint->softness.error_reduction / dt);
    joint->impulse_matrix = plii_joint_angular_impulse_matrix(&joint->sides[0], &joint->sides[1]);
    plii_joint_split_drift(joint, iterations,
                           pli_vec3_dot(error, pli_mat3_mul_vec3(joint->sides[0].inverse_inertia, error)),
                           pli_vec3_dot(error, pli_mat3_mul_vec3(plii_joint_end_inertia(&joint->sides[1]), error)));
}

static pli_vec3 angular_joint_solve(const plii_joint* joint) {
    const pli_vec3 velocity = pli_vec3_sub(plii_joint_angular_velocity(&joint->sides[0].target),
                                           plii_joint_angular_velocity(&joint->sides[1].target));
    const float present = pli_vec3_dot(velocity, joint->world[0]);
    float wanted = present;
    if (joint->controller.speed != NULL) {
        const float speed = joint->controller.speed(present, joint->controller.user);
        if (plii_is_finite(speed)) { wanted = plii_clamp(speed, -PLI_MAX_ANGULAR_SPEED, PLI_MAX_ANGULAR_SPEED); }
    }
    const pli_vec3 excess = pli_vec3_sub(velocity, pli_vec3_scale(joint->world[0], wanted));
    const pli_vec3 change = pli_vec3_add(joint->drift, pli_vec3_scale(excess, joint->softness.velocity_factor));
    return pli_mat3_mul_vec3(joint->impulse_matrix, change);
}

const plii_joint_class plii_angular_joint_class = {true, angular_joint_prepare, angular_joint_solve};

PLII_DEFINE_DEFAULT(pli_angular_joint_def, .softness = {1.0f, 1.0f, 1.0f})
pli_status pli_body_add_angular_joint(pli_body* body, const pli_angular_joint_def* def, pli_joint_id* joint) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(PLII_CHECK_MADE(body->context, pli_angular_joint_def, def, __func__));
    pli_vec3 axis = def->axis;
    PLII_FAIL_IF(!angular_joint_make_unit(&axis), body->context, PLI_ERROR_INVALID_VALUE, __func__,
                 "the axis (%g, %g, %g) has no direction", (double)axis.x, (double)axis.y, (double)axis.z);
    plii_joint made = {.klass = &plii_angular_joint_class,
                       .cluster = def->cluster,
                       .other = def->other,
                       .softness = def->softness,
                       .controller = def->controller};
    return plii_joint_add(body, &made, axis, joint, __func__);
}
