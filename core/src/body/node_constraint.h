#pragma once

/* What a rigid body demands of a node, or of a point of a face, in a form that a solver can take into its system
   instead of running the feature's own position solve; see plii_solver_class.solves_constraints. */

#include "pliant/rigid.h"

#define PLII_ANCHOR_RECOVERY_RATE 4.0f /* 1/s: what is farther off, as after a jump of its body, comes back faster */
typedef struct plii_node_constraint {
    int node; /* PLI_NULL_INDEX for a point of a face, which has these: */
    int face_nodes[3];
    pli_vec3 weights;
    pli_rigid* rigid;
    bool is_anchor;
    /* In the frame of the rigid body: where an anchor holds the node, the surface is at a face, a node goes along. */
    pli_vec3 pivot;
    bool has_pivot; /* of a node that is not anchored */
    bool leads;     /* anchors: the node goes from `start` to `end` in this step, whatever else pulls at it */
    pli_vec3 start, end;
    pli_vec3 normal; /* contacts, and what follows: out of the rigid body, unit */
    float offset;    /* gap = dot(normal, x) + offset, with the rigid body where it was when the contact was found */
    float friction;  /* Coulomb's coefficient of the pair */
    float hardness;  /* fraction of the error at the start of the step that goes in one step */
    float recovery_speed; /* m/s: the error goes at this speed at most, so that it does not throw nodes off */
    float squeeze;        /* m: of what it needs between this surface and another one, so much the node does not have */
    float influence;      /* [0, 1] fraction of what would hold the node wholly */
    pli_vec3* impulse;    /* N s: what it pushes the node by is added there; NULL: nobody asks */
} plii_node_constraint;

/* A spring from a node to a fixed point, implicit in time: at the end of a step h the impulse times h on the node is
   the hardness times what is left of the way. Solvers that set the positions of constraints need not ask. */
typedef struct plii_node_spring {
    int node;
    float hardness; /* kg: stiffness h^2; of one along a line, in stiffnesses of the solver's links */
    pli_vec3 way;   /* m, at the start of the step */
    pli_vec3 along; /* unit: acts along this line only; zero: in all directions */
} plii_node_spring;
