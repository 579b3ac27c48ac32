#pragma once

/* Anchors: state shared by the feature (anchor.c) and its part in substeps (anchor_substep.c). */

#include "base/id_pool.h"
#include "body/substep_rigid.h"
#include "pliant/anchor.h"

typedef struct plii_anchor {
    int node, slot;
    pli_rigid* rigid;
    pli_vec3 pivot; /* in the frame of the rigid body */
    float influence;
    float compliance; /* m/N */
    bool is_idle;     /* in this step: the rigid body is not present */
    /* At the prediction, after which the host may move the rigid body. */
    pli_vec3 start; /* of the goal */
    unsigned pose_version;
    union { /* for one step */
        struct {
            pli_vec3 offset;      /* from the centre of the rigid body, world axes */
            pli_vec3 goal;        /* of the node */
            pli_vec3 goal_motion; /* of a rigid body that takes no impulses */
            pli_mat3 matrix;      /* from the change of displacement that is wanted to an impulse */
        } step;
        struct {
            plii_substep_rigid_pivot pivot;
            pli_vec3 goal;        /* of the node, at the start of the step */
            pli_vec3 goal_motion; /* in the step, of a rigid body that takes no impulses */
            pli_mat3 inverse;     /* of the sum of both inverse masses and the compliance */
            pli_vec3 multiplier;  /* kg m */
        } substeps;
    };
} plii_anchor;

/* Stays when the last anchor goes, so that old ids stay stale and the hardness is kept. */
typedef struct plii_anchors {
    float hardness;
    plii_anchor* items; /* in the order of creation */
    int item_count, item_capacity;
    plii_id_pool ids;
} plii_anchors;

/* The node is where the body's point is at the end of the step, whatever else pulls at it. */
bool plii_anchor_is_exact(const pli_body* body, const plii_anchor* anchor);
/* Of a static or kinematic body at the end of the step: where its host has put it since the prediction, else where its
   velocities lead it. */
pli_transform plii_anchor_end_pose(const pli_body* body, const plii_anchor* anchor);

extern const plii_feature_class plii_anchor_class;
extern const plii_substep_class plii_anchor_substepped;
