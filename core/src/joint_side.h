#ifndef PLII_JOINT_SIDE_H
#define PLII_JOINT_SIDE_H

/* One end of a joint or of a cluster contact while a step is solved: a cluster, a rigid body, or something that does
   not move. Bullet: btSoftBody::Body, in its order of operations. */

#include "cluster_impl.h"
#include "rigid_impl.h"

typedef struct plii_joint_side {
    plii_cluster* cluster; /* or NULL */
    pli_rigid* rigid;      /* or NULL */
    pli_transform frame;   /* at the time of plii_joint_side_of_ */
    pli_vec3 rest_centre;  /* of the cluster; zero else */
    float inverse_mass;
    pli_mat3 inverse_inertia;
} plii_joint_side;

plii_joint_side plii_joint_side_of_cluster(const pli_body* body, int cluster);
plii_joint_side plii_joint_side_of_rigid(pli_rigid* rigid);
plii_joint_side plii_joint_side_of_world(void);

/* Impulse per unit of relative velocity at offsets r_a and r_b; zero when neither side can move.
   Bullet: ImpulseMatrix(ima, iia, ra, imb, iib, rb) */
pli_mat3 plii_joint_impulse_matrix(const plii_joint_side* a, pli_vec3 r_a, const plii_joint_side* b, pli_vec3 r_b);
/* Bullet: AngularImpulseMatrix */
pli_mat3 plii_joint_angular_impulse_matrix(const plii_joint_side* a, const plii_joint_side* b);

/* Velocity along a unit vector per unit of impulse along it, 1/kg; in proportion to the square of another length. */
float plii_joint_side_response(const plii_joint_side* side, pli_vec3 offset, pli_vec3 direction);

pli_vec3 plii_joint_side_velocity_at(const plii_joint_side* side, pli_vec3 offset);
pli_vec3 plii_joint_side_angular_velocity(const plii_joint_side* side);

/* Velocity impulses change the velocity at once; drift impulses move the nodes of a cluster at the end of the step,
   and are velocity impulses for a rigid body. */
void plii_joint_side_apply_impulse(plii_joint_side* side, pli_vec3 impulse, pli_vec3 offset);
void plii_joint_side_apply_drift(plii_joint_side* side, pli_vec3 impulse, pli_vec3 offset);
void plii_joint_side_apply_torque_impulse(plii_joint_side* side, pli_vec3 impulse);
void plii_joint_side_apply_torque_drift(plii_joint_side* side, pli_vec3 impulse);

#endif
