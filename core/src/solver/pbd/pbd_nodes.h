#pragma once

/* Passes over the nodes before and after the iterations, one kernel per instruction set, from pbd_nodes_base.c. */

#include "body/body_impl.h"

/* The w of velocities is 0, and previous positions have none. Ranges of nodes take one as their task. */
typedef struct plii_pbd_nodes {
    pli_vec4 *positions, *previous, *velocities;
    pli_vec3* forces; /* or NULL */
    float dt;         /* s */
    pli_vec3 gravity; /* change of velocities, m/s */
    float limit;      /* of the change by forces, m/s */
    float rate;       /* velocities for motions since the start of the step, 1/s */
} plii_pbd_nodes;

typedef struct plii_pbd_nodes_kernel {
    pli_range_fn* add_gravity;
    pli_range_fn* add_forces; /* where there are some, and move; forces become 0 */
    pli_range_fn* fly;        /* add gravity and move, where nothing else pulls */
    pli_range_fn* set_velocities;
} plii_pbd_nodes_kernel;

extern const plii_pbd_nodes_kernel plii_pbd_nodes_base, plii_pbd_nodes_avx2;
