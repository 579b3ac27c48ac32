#ifndef PLII_LINK_RUNS_ORDER_H
#define PLII_LINK_RUNS_ORDER_H

/* In which order kernels go through the runs of a colour. */

#include "math/simd.h"
#include "solver/coloring/link_runs.h"

/* Groups [begin, end) of a run: either its end or what comes before. */
typedef void plii_run_groups_fn(const void* task, const plii_link_run* run, int begin, int end);

PLII_SIMD_INLINE void plii_run_solve_end(const plii_link_run* run, plii_run_groups_fn* solve, const void* task) {
    if (run->skipped_count > 0) { solve(task, run, run->group_count - 1, run->group_count); }
}

/* Groups [begin, end) of a colour. The end of a run has nodes of the group before it, and whichever comes second would
   wait until the other one is in memory; so the end comes one run earlier. */
PLII_SIMD_INLINE void plii_runs_solve(const plii_link_runs* runs, int color, int begin, int end,
                                      plii_run_groups_fn* solve, const void* task) {
    const plii_link_run_color* own = &runs->colors[color];
    const plii_link_part whole = plii_link_runs_part(runs, own, begin, end);
    if (whole.begin >= whole.end) { return; }
    const plii_link_run* run = plii_link_run_at(runs, own, whole.begin);
    const plii_link_run* last = plii_link_run_at(runs, own, whole.end - 1);
    const bool is_whole = plii_link_run_part(last, own, whole.begin, whole.end).end == last->group_count;
    const plii_link_run* without_end = is_whole ? last + 1 : last; /* from here on */
    if (run < without_end) { plii_run_solve_end(run, solve, task); }
    for (; run <= last; ++run) {
        if (run + 1 < without_end) { plii_run_solve_end(run + 1, solve, task); }
        const plii_link_part part = plii_link_run_part(run, own, whole.begin, whole.end);
        const int full_count = plii_link_run_full_count(run);
        solve(task, run, part.begin, part.end < full_count ? part.end : full_count);
    }
}

#endif
