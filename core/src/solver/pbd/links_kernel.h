#ifndef PLII_LINKS_KERNEL_H
#define PLII_LINKS_KERNEL_H

/* Links on positions by colours, eight at a time; one function per instruction set, from links_kernel.inl. */

#include "solver/coloring/link_colors.h"

/* In place of a squared rest length: nothing moves. */
#define PLII_LINKS_NO_LINK (-INFINITY)

typedef struct plii_links_task {
    pli_body* body;
    const plii_link_colors* colors;
    const float* rest_squared;        /* by slot, m^2 */
    const float* inverse_stiffnesses; /* [material_count] */
} plii_links_task;

/* Groups [begin, end) of quads, all of one colour. */
typedef void plii_links_groups_fn(const plii_links_task* task, int begin, int end);
/* The serial list; or all colours one after the other, and then the serial list. */
typedef void plii_links_whole_fn(const plii_links_task* task);

typedef struct plii_links_kernel {
    plii_links_groups_fn* groups;
    plii_links_whole_fn *serial, *sweep;
} plii_links_kernel;

extern const plii_links_kernel plii_links_kernel_portable, plii_links_kernel_sse2, plii_links_kernel_avx2,
    plii_links_kernel_neon;

#endif
