#pragma once

/* Joints of a body: one list for all kinds, each kind a file with a class. */

#include "cluster/joint_end.h"
#include "pliant/joint.h"

typedef struct plii_joint plii_joint;

typedef struct plii_joint_class {
    bool is_angular; /* an axis and torques; else a point and impulses */
    /* Once per step, with both sides known; `iterations` solves follow. */
    void (*prepare)(plii_joint* joint, float dt, int iterations);
    pli_vec3 (*solve)(const plii_joint* joint); /* returns the impulse on the other end */
} plii_joint_class;
extern const plii_joint_class plii_linear_joint_class, plii_angular_joint_class;

struct plii_joint {
    const plii_joint_class* klass;
    int slot; /* of its id */
    int cluster;
    pli_joint_end other;
    pli_joint_softness softness;
    pli_vec3 local[2]; /* pivot or axis in the frame of each end */
    pli_vec3 force;    /* or torque of the last step, which the next one starts from */
    pli_joint_controller controller;
    /* Of the step in progress. */
    float split;  /* as set, or 0 where a cluster is a part of its body */
    bool is_idle; /* the other end is a rigid body that is not present */
    plii_joint_end sides[2];
    pli_vec3 world[2]; /* arm to the pivot, or axis */
    pli_vec3 drift, split_drift;
    /* The other end is a rigid body, which cannot be displaced. Bullet gives it a velocity after the last iteration,
       and momentum from nothing; here the share that is its own is solved for with the velocities. */
    bool keeps_momentum;
    pli_mat3 impulse_matrix;
    pli_vec3 impulse; /* of all iterations, on the other end */
};

/* Checks that all kinds share, then adds. `joint->cluster`, `other`, `softness` and `klass` are set; `local` is filled
   here from `world_value`, a point or an axis. `id` may be NULL. */
pli_status plii_joint_add(pli_body* body, plii_joint* joint, pli_vec3 world_value, pli_joint_id* id,
                          const char* function);

/* Splits `joint->drift`, a velocity, into displacement and what is solved for; responses: how much sides give way. */
void plii_joint_split_drift(plii_joint* joint, int iterations, float response, float other_response);
