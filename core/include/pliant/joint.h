#ifndef PLIANT_JOINT_H
#define PLIANT_JOINT_H

/// Joints between a cluster of a body and a cluster, a rigid body or the world.

#include "cluster.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Names a joint of one body; all zero is no joint.
typedef struct pli_joint_id {
    int32_t index1;
    uint32_t generation;
} pli_joint_id;

/// The other end of a joint: a cluster of `body`, or `rigid`, or the world when both are NULL.
typedef struct pli_joint_end {
    pli_body* body;
    int cluster;
    pli_rigid* rigid;
} pli_joint_end;

typedef struct pli_joint_softness {
    float error_reduction; ///< [0, 1], default 1: share of the error corrected per step. Bullet name: erp
    float velocity_factor; ///< [0, 1], default 1: share of the relative velocity removed. Bullet name: cfm
    /// [0, 1], default 1: share of the correction that is a displacement, not a velocity. A rigid body is not
    /// displaced; as_bullet it takes this share as a velocity all the same, at the expense of the momentum.
    float split;
} pli_joint_softness;

typedef struct pli_linear_joint_def {
    int cluster; ///< of this body, default 0
    pli_joint_end other;
    pli_vec3 position; ///< m, world; the point of both ends that is held together
    pli_joint_softness softness;
    uint32_t cookie;
} pli_linear_joint_def;

PLI_API pli_linear_joint_def pli_linear_joint_def_default(void);
/// A ball and socket. Bullet name: appendLinearJoint
PLI_API pli_status pli_body_add_linear_joint(pli_body* body, const pli_linear_joint_def* def, pli_joint_id* joint);

/// Drives and steers an angular joint. Both callbacks may be NULL; a speed that is not finite and an axis without a
/// direction are not used, and a speed above PLI_MAX_ANGULAR_SPEED is cut to it. Both may read only: what else is to
/// change is changed before the step.
typedef struct pli_joint_controller {
    /// Before each step: the axis in the frame of this body's cluster, given the present one.
    pli_vec3 (*steer)(pli_vec3 local_axis, void* user);
    /// Wanted relative speed about the axis, rad/s, given the present one; NULL: turns freely.
    float (*speed)(float present, void* user);
    void* user;
} pli_joint_controller;

typedef struct pli_angular_joint_def {
    int cluster;
    pli_joint_end other;
    pli_vec3 axis; ///< world, of any length but zero; both ends turn about it
    pli_joint_softness softness;
    pli_joint_controller controller;
    uint32_t cookie;
} pli_angular_joint_def;

PLI_API pli_angular_joint_def pli_angular_joint_def_default(void);
/// A hinge without a pivot. Bullet name: appendAngularJoint
PLI_API pli_status pli_body_add_angular_joint(pli_body* body, const pli_angular_joint_def* def, pli_joint_id* joint);

/// @return PLI_ERROR_STALE_ID
PLI_API pli_status pli_body_remove_joint(pli_body* body, pli_joint_id joint);
PLI_API int pli_body_joint_count(const pli_body* body);

#ifdef __cplusplus
}
#endif
#endif
