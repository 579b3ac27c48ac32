#ifndef PLII_XPBD_LINKS_KERNEL_H
#define PLII_XPBD_LINKS_KERNEL_H

/* Lengths of links under XPBD, by colours, eight at a time; one function per instruction set,
   from xpbd_links_kernel.inl. */

#include "solver/coloring/link_colors.h"
#include "solver/xpbd/xpbd_impl.h"

/* In place of a rest length: nothing moves. */
#define PLII_XPBD_NO_LINK (-INFINITY)

/* Of links of one tag: see plii_xpbd_multiplier. Both are 0 for rigid links, whose multipliers nobody needs. */
typedef struct plii_xpbd_link_softness {
    float alpha, gamma;
} plii_xpbd_link_softness;

typedef struct plii_xpbd_links_task {
    pli_body* body;
    const plii_link_colors* colors;
    const plii_substep* substep;
    const plii_xpbd_link_softness* softness; /* [2 * material_count] of a material, then of its bending links */
    const float* rest_lengths;               /* by slot, m */
    float* multipliers;                      /* by slot */
} plii_xpbd_links_task;

/* Groups [begin, end) of quads, all of one colour. */
typedef void plii_xpbd_links_groups_fn(const plii_xpbd_links_task* task, int begin, int end);
/* The serial list. */
typedef void plii_xpbd_links_serial_fn(const plii_xpbd_links_task* task);

typedef struct plii_xpbd_links_kernel {
    plii_xpbd_links_groups_fn* groups;
    plii_xpbd_links_serial_fn* serial;
} plii_xpbd_links_kernel;

extern const plii_xpbd_links_kernel plii_xpbd_links_kernel_portable, plii_xpbd_links_kernel_sse2,
    plii_xpbd_links_kernel_avx2, plii_xpbd_links_kernel_neon;

#endif
