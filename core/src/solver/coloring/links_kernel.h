#pragma once

/* Lengths of links by colours, in vectors, of the position-based solver and XPBD; links_kernel_base.c. */

#include "solver/coloring/link_coloring.h"

/* In place of a rest length under XPBD: nothing moves. */
#define PLII_LINKS_NO_LINK (-INFINITY)

typedef struct plii_links_task {
    const pli_body* body;
    const plii_link_colors* colors;
    const float* rest;    /* by slot; squared on positions, m^2, and above 0, else m */
    const float* weights; /* by slot, of links on positions: 1 / mass term, kg, 0 where nothing moves; NULL: XPBD */
    pli_vec4* moved;      /* positions, or displacements under XPBD; w = inverse mass */
    /* XPBD only. */
    const float *compliances, *dampings; /* by slot, m/N and s: see plii_xpbd_multiplier; NULL: all are 0 */
    float softening;                     /* the least compliance over dt^2, as a share of the mass term */
    float inverse_dt;                    /* of a substep, 1/s */
    float* vectors;                      /* [3 * slot count] see plii_links_start_colors */
    const pli_vec4* start_displacements; /* the displacements at the start of the substep */
    float* multipliers;                  /* by slot */
    bool reads_multipliers, writes_multipliers;
} plii_links_task;

typedef struct plii_links_kernel {
    void (*groups)(const plii_links_task* task, int begin, int end);         /* all of one colour */
    void (*gather_vectors)(const plii_links_task* task, int begin, int end); /* groups */
} plii_links_kernel;

extern const plii_links_kernel plii_links_kernel_base, plii_links_kernel_avx2, plii_links_kernel_avx512;

/* All colours, with the threads of the context. */
void plii_links_sweep_colors(const plii_links_task* task);
/* Fills in the vectors from node to node of each link where the displacements of XPBD are 0: x of a row, y, z. */
void plii_links_start_colors(const plii_links_task* task);
