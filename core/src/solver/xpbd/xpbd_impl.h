#pragma once

/* What the kinds of constraints know of the XPBD solver: where nodes are, and how to take part in its sweeps. And its
   passes over the nodes between sweeps, one kernel per instruction set, from xpbd_nodes_base.c. */

#include "body/pipeline.h"
#include "body/substep.h"
#include "pliant/xpbd.h"

/* plii_feature_enable_with for a kind, which takes part in sweeps then; fails unless the body is stepped by XPBD. */
pli_status plii_xpbd_enable_kind(pli_body* body, const plii_feature_class* klass, const void* given, size_t size,
                                 const char* function, void** state);

/* Of constraints, and of what is their own. */
static inline float plii_xpbd_softening(float softening, const plii_substep* substep) {
    return softening + (1.0f + softening) * substep->lag;
}

/* Change of the multiplier of a constraint (Macklin and others 2016, equations 18 and 26), 0 where it cannot act.
   c: its value; weight: sum of w |gradient|^2; c_motion: change of c by the motion in this substep; softening: the
   least compliance over dt^2, as a share of the weight. */
static inline float plii_xpbd_multiplier(float c, float weight, float compliance, float damping, float softening,
                                         float multiplier, float c_motion, const plii_substep* substep) {
    const float alpha = compliance * substep->inverse_dt * substep->inverse_dt;
    const float gamma = compliance * damping * substep->inverse_dt;
    const float divisor = (1.0f + gamma) * weight + plii_max(alpha, plii_xpbd_softening(softening, substep) * weight);
    const float change = (-c - alpha * multiplier - gamma * c_motion) / divisor;
    return weight > 0.0f && plii_is_finite(change) ? change : 0.0f;
}

/* The w of velocities and accelerations is 0, that of positions, displacements and what they were at the start of the
   substep is the inverse mass. Ranges of nodes take one as their task. */
typedef struct plii_xpbd_nodes {
    plii_substep substep;
    pli_vec4 *positions, *velocities;
    const pli_vec4 *previous, *accelerations;
    bool follows; /* positions, with the nodes */
} plii_xpbd_nodes;

typedef struct plii_xpbd_nodes_kernel {
    pli_range_fn* begin;  /* from the end of the prediction to the first substep, and moves */
    pli_range_fn* move;   /* freely, to the end of a substep */
    pli_range_fn* finish; /* after the sweeps of a substep: velocities */
    pli_range_fn* finish_and_move;
} plii_xpbd_nodes_kernel;

extern const plii_xpbd_nodes_kernel plii_xpbd_nodes_base, plii_xpbd_nodes_avx2;
