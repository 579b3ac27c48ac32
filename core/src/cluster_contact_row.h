#ifndef PLII_CLUSTER_CONTACT_ROW_H
#define PLII_CLUSTER_CONTACT_ROW_H

#include "joint_side.h"

/* A contact prepared for the iterations of one step. Directions are the normal, from side 1 to side 0, and two
   tangents. */
typedef struct plii_contact_row {
    pli_vec4 directions[3];
    pli_vec4 turns[2][3];   /* arm x direction of each side */
    float masses[4];        /* that impulses along the directions meet, kg; 0 where nothing can move */
    float impulses[4];      /* along the directions so far, N s */
    float wanted_speeds[4]; /* along the directions, m/s */
    float friction;         /* Coulomb's coefficient */
    float limit;            /* of the impulse along the normal, N s */
    plii_joint_target targets[2];
} plii_contact_row;

/* `normal` is a unit vector. Friction, limit and a wanted speed along the normal are the caller's to set. */
void plii_contact_row_make(const plii_joint_target targets[2], const pli_vec3 arms[2], pli_vec3 normal,
                           plii_contact_row* row);
/* `rigid_arm` is that of a side 1 that is a rigid body. */
void plii_contact_row_solve(plii_contact_row* row, const pli_vec3* rigid_arm);
/* Hands the impulses of all iterations on to the nodes of the clusters. */
void plii_contact_row_finish(const plii_contact_row* row);

#endif
