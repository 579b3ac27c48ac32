#ifndef PLIANT_JOINT_H
#define PLIANT_JOINT_H

/// Joints between a cluster of a body and a cluster, a rigid body or the world. A joint sees the mass of the cluster,
/// not that of what hangs from it by links. To hold a node of a large body take an anchor or a target (anchor.h,
/// target.h).

#include "cluster.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Names a joint of one body; all zero is no joint.
typedef struct pli_joint_id {
    int32_t index1;      ///< index in the library's table plus one; 0: no joint
    uint32_t generation; ///< tells the joint from earlier ones at that index
} pli_joint_id;

/// The other end of a joint: a cluster of `body`, or `rigid`, or the world when both are NULL.
typedef struct pli_joint_end {
    pli_body* body;   ///< of the same world, also the body itself; default NULL
    int cluster;      ///< of `body`, default 0
    pli_rigid* rigid; ///< of the same world; default NULL
} pli_joint_end;

/// How hard a joint corrects.
typedef struct pli_joint_softness {
    float error_reduction; ///< [0, 1], default 1: share of the error corrected per step. Bullet name: erp
    float velocity_factor; ///< [0, 1], default 1: share of the relative velocity removed. Bullet name: cfm
    /// [0, 1], default 1: share of the correction that is a displacement, not a velocity. For clusters that are only a
    /// part of their body the whole correction is a velocity, since links would turn a displacement into energy (not in
    /// reference mode). A rigid body is not displaced; in reference mode it takes this share as a velocity, which
    /// changes the momentum.
    float split;
} pli_joint_softness;

/// A ball and socket.
typedef struct pli_linear_joint_def {
    int cluster;                 ///< of this body, default 0
    pli_joint_end other;         ///< default: the world
    pli_vec3 position;           ///< m, world, up to PLI_MAX_COORDINATE, default zero: the point where both ends are
                                 ///< held together
    pli_joint_softness softness; ///< defaults as named there
    uint32_t cookie;             ///< set by the default function
} pli_linear_joint_def;

/// Defaults of the fields.
PLI_API pli_linear_joint_def pli_linear_joint_def_default(void);

/// Holds a point of two ends together; both turn about it freely. Bullet name: appendLinearJoint
/// @param joint receives the id; may be NULL
/// @return PLI_ERROR_INDEX_OUT_OF_RANGE (a cluster), PLI_ERROR_INVALID_VALUE (both ends the same cluster, two other
///         ends, another world), PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_add_linear_joint(pli_body* body, const pli_linear_joint_def* def, pli_joint_id* joint);

/// Drives and steers an angular joint. Both callbacks may be NULL. A speed that is not finite and an axis without a
/// direction are ignored; a speed above PLI_MAX_ANGULAR_SPEED is cut to it. Both are called on the thread that steps
/// and may read only.
typedef struct pli_joint_controller {
    /// Before each step: the axis in the frame of this body's cluster, given the present one.
    pli_vec3 (*steer)(pli_vec3 local_axis, void* user);
    /// Wanted speed about the axis, of this body's cluster relative to the other end, rad/s, given the present one.
    /// NULL: it turns freely.
    float (*speed)(float present, void* user);
    void* user; ///< handed to both
} pli_joint_controller;

/// A hinge without a pivot.
typedef struct pli_angular_joint_def {
    int cluster;                     ///< of this body, default 0
    pli_joint_end other;             ///< default: the world
    pli_vec3 axis;                   ///< world, of any length but zero, required; both ends turn about it
    pli_joint_softness softness;     ///< defaults as named there
    pli_joint_controller controller; ///< default: none, turns freely
    uint32_t cookie;                 ///< set by the default function
} pli_angular_joint_def;

/// Defaults of the fields; `axis` has to be set.
PLI_API pli_angular_joint_def pli_angular_joint_def_default(void);

/// Lets two ends turn relative to each other about one axis only, wherever they are. Together with a linear joint it
/// makes a hinge. Bullet name: appendAngularJoint
/// @param joint receives the id; may be NULL
/// @return as pli_body_add_linear_joint, PLI_ERROR_INVALID_VALUE also for an axis without a direction
PLI_API pli_status pli_body_add_angular_joint(pli_body* body, const pli_angular_joint_def* def, pli_joint_id* joint);

/// Removes one joint of either kind.
/// @return PLI_ERROR_STALE_ID when the body has no such joint (any more), PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_remove_joint(pli_body* body, pli_joint_id joint);

/// Number of joints of both kinds that were added to this body.
PLI_API int pli_body_joint_count(const pli_body* body);

#ifdef __cplusplus
}
#endif
#endif
