#ifndef PLII_LINK_RUNS_KERNEL_H
#define PLII_LINK_RUNS_KERNEL_H

/* What kernels over runs in records have in common: the nodes of a group. The including file has chosen the instruction
   set. Callers give steps and turns as constants. */

#include "solver/coloring/link_runs_order.h"

/* How the nodes of a group lie: see plii_link_run. */
typedef struct plii_run_form {
    ptrdiff_t offset;
    int step, turns; /* the offset where nodes take turns, else 0 */
} plii_run_form;

PLII_SIMD_INLINE ptrdiff_t plii_run_way(plii_run_form form) {
    return form.turns != 0 ? 2 * PLII_LINK_LANES : form.step * PLII_LINK_LANES;
}

/* First nodes of links, and the others. */
typedef struct plii_run_records {
    plii_packed8 a, b;
} plii_run_records;

PLII_SIMD_INLINE plii_run_records plii_run_load(const pli_vec4* first, plii_run_form form) {
    plii_run_records nodes;
    if (form.turns != 0) {
        plii_packed8_load_turns(first, form.turns, &nodes.a, &nodes.b);
    } else {
        nodes =
            (plii_run_records){plii_packed8_load(first, form.step), plii_packed8_load(first + form.offset, form.step)};
    }
    return nodes;
}
PLII_SIMD_INLINE void plii_run_store(pli_vec4* first, plii_run_form form, plii_run_records nodes) {
    if (form.turns != 0) {
        plii_packed8_store_turns(first, form.turns, nodes.a, nodes.b);
    } else {
        plii_packed8_store(first, form.step, nodes.a);
        plii_packed8_store(first + form.offset, form.step, nodes.b);
    }
}

#endif
