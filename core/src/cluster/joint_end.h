#pragma once

/* One end of a joint or cluster contact in a solve: a cluster, a rigid body, or what does not move. Bullet: Body. */

#include "body/rigid_impl.h"
#include "cluster/cluster_impl.h"

/* What impulses act on. */
typedef struct plii_joint_target {
    plii_cluster* cluster; /* or NULL */
    pli_rigid* rigid;      /* or NULL */
} plii_joint_target;

typedef struct plii_joint_end {
    plii_joint_target target;
    pli_transform frame;  /* at the time of plii_joint_end_of_ */
    pli_vec3 rest_centre; /* of the cluster; zero else */
    float inverse_mass;
    pli_mat3 inverse_inertia;
    bool has_factors; /* of side 1: those of the rigid body count, which Bullet leaves out */
} plii_joint_end;

plii_joint_end plii_joint_end_of_cluster(const pli_body* body, int cluster);
plii_joint_end plii_joint_end_of_rigid(pli_rigid* rigid);

/* Impulse per unit of relative velocity at two offsets; zero when neither side can move. Bullet: ImpulseMatrix */
pli_mat3 plii_joint_impulse_matrix(const plii_joint_end* a, pli_vec3 r_a, const plii_joint_end* b, pli_vec3 r_b);
/* Bullet: AngularImpulseMatrix */
pli_mat3 plii_joint_angular_impulse_matrix(const plii_joint_end* a, const plii_joint_end* b);
/* The inverse one, with factors where these count. */
pli_mat3 plii_joint_end_inertia(const plii_joint_end* side);

/* Velocity along a unit vector per unit of impulse along it, 1/kg; in proportion to the square of another length. */
float plii_joint_end_response(const plii_joint_end* side, pli_vec3 offset, pli_vec3 direction);

static inline pli_vec3 plii_joint_velocity_at(const plii_joint_target* target, pli_vec3 offset) {
    if (target->rigid != NULL) { return plii_rigid_velocity_at(target->rigid, offset); }
    if (target->cluster == NULL) { return pli_vec3_make(0, 0, 0); }
    const plii_cluster* cluster = target->cluster;
    return pli_vec3_add(plii_xyz(cluster->linear_velocity),
                        pli_vec3_cross(plii_xyz(cluster->angular_velocity), offset));
}
pli_vec3 plii_joint_angular_velocity(const plii_joint_target* target);

/* Impulses change velocities at once; drifts move nodes at the end of the step, and act on rigid bodies as impulses. */
static inline void plii_joint_apply(const plii_joint_target* target, pli_vec3 impulse, pli_vec3 offset, bool is_drift) {
    if (target->rigid != NULL) { plii_rigid_apply_impulse(target->rigid, impulse, offset); }
    plii_cluster* cluster = target->cluster;
    if (cluster == NULL) { return; }
    const pli_vec3 change = pli_vec3_scale(impulse, cluster->inverse_mass);
    const pli_vec3 angular_change = pli_mat3_mul_vec3(cluster->inverse_inertia, pli_vec3_cross(offset, impulse));
    plii_cluster_impulse_add(is_drift ? &cluster->drift : &cluster->impulse, change, angular_change, 1);
    if (is_drift) { return; }
    plii_add_xyz(&cluster->linear_velocity, change);
    plii_add_xyz(&cluster->angular_velocity, angular_change);
}
void plii_joint_apply_torque(const plii_joint_target* target, pli_vec3 impulse, bool is_drift);
