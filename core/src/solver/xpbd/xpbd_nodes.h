#pragma once

/* Passes over the nodes between sweeps, one kernel per instruction set, from xpbd_nodes_base.c. */

#include "body/body_impl.h"

/* The w of velocities and accelerations is 0, that of positions, displacements and what they were at the start of the
   substep is the inverse mass. Ranges of nodes take one as their task. */
typedef struct plii_xpbd_nodes {
    pli_vec4 *positions, *velocities, *displacements, *start_displacements;
    const pli_vec4 *previous, *accelerations;
    float dt, inverse_dt; /* of the substep */
    bool follows;         /* positions, with the nodes */
} plii_xpbd_nodes;

typedef struct plii_xpbd_nodes_kernel {
    pli_range_fn* begin;  /* from the end of the prediction to the first substep, and moves */
    pli_range_fn* move;   /* freely, to the end of a substep */
    pli_range_fn* finish; /* after the sweeps of a substep: velocities */
    pli_range_fn* finish_and_move;
} plii_xpbd_nodes_kernel;

extern const plii_xpbd_nodes_kernel plii_xpbd_nodes_base, plii_xpbd_nodes_avx2;
