#ifndef PLII_LINK_RUNS_KERNEL_H
#define PLII_LINK_RUNS_KERNEL_H

/* What kernels over runs have in common: the nodes of a group, in records and in planes. The including file has chosen
   the instruction set. Callers give steps and turns as constants. */

#include "link_runs.h"
#include "node_planes.h"
#include "simd.h"

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

/* Where eight links have their nodes in planes: all in a row, or two rows of four, of the even and the odd links; or
   first and other nodes take turns in two rows of eight. */
enum { PLII_RUN_WHOLE, PLII_RUN_HALVES, PLII_RUN_TURNS };

typedef struct plii_run_places {
    ptrdiff_t a[2], b[2]; /* of the first and the second link, which are those of the first even and odd ones */
} plii_run_places;

/* How many places it is to the next group. */
PLII_SIMD_INLINE ptrdiff_t plii_run_places_way(const plii_link_run* run) {
    return plii_link_run_group_way(run->offset, run->step) / 2;
}
PLII_SIMD_INLINE plii_run_places plii_run_places_of(const plii_planes* planes, const plii_link_run* run, int group) {
    const ptrdiff_t a = plii_link_run_node(run, group), b = a + run->offset;
    return (plii_run_places){{plii_planes_place(planes, a), plii_planes_place(planes, a + 1)},
                             {plii_planes_place(planes, b), plii_planes_place(planes, b + 1)}};
}
PLII_SIMD_INLINE plii_run_places plii_run_places_after(plii_run_places at, ptrdiff_t way) {
    return (plii_run_places){{at.a[0] + way, at.a[1] + way}, {at.b[0] + way, at.b[1] + way}};
}
PLII_SIMD_INLINE plii_run_places plii_run_places_odd(plii_run_places at) {
    return (plii_run_places){{at.a[1], at.a[1]}, {at.b[1], at.b[1]}};
}

/* One component of both. */
typedef struct plii_run_numbers {
    plii_float8 a, b;
} plii_run_numbers;

PLII_SIMD_INLINE plii_run_numbers plii_run_load_plane(const float* plane, const plii_run_places* at, int kind) {
    plii_run_numbers numbers;
    if (kind == PLII_RUN_TURNS) {
        plii_float8_load_turns(plane + at->a[0], plane + at->a[1], &numbers.a, &numbers.b);
    } else if (kind == PLII_RUN_HALVES) {
        numbers = (plii_run_numbers){plii_float8_load_halves(plane + at->a[0], plane + at->a[1]),
                                     plii_float8_load_halves(plane + at->b[0], plane + at->b[1])};
    } else {
        numbers = (plii_run_numbers){plii_float8_load(plane + at->a[0]), plii_float8_load(plane + at->b[0])};
    }
    return numbers;
}
PLII_SIMD_INLINE void plii_run_store_plane(float* plane, const plii_run_places* at, int kind,
                                           plii_run_numbers numbers) {
    if (kind == PLII_RUN_TURNS) {
        plii_float8_store_turns(plane + at->a[0], plane + at->a[1], numbers.a, numbers.b);
    } else if (kind == PLII_RUN_HALVES) {
        plii_float8_store_halves(plane + at->a[0], plane + at->a[1], numbers.a);
        plii_float8_store_halves(plane + at->b[0], plane + at->b[1], numbers.b);
    } else {
        plii_float8_store(plane + at->a[0], numbers.a);
        plii_float8_store(plane + at->b[0], numbers.b);
    }
}
/* b - a */
PLII_SIMD_INLINE plii_float8 plii_run_difference(plii_run_numbers numbers) {
    return plii_float8_sub(numbers.b, numbers.a);
}
/* a - delta move_a, b + delta move_b */
PLII_SIMD_INLINE plii_run_numbers plii_run_moved(plii_run_numbers numbers, plii_float8 delta, plii_float8 move_a,
                                                 plii_float8 move_b) {
    numbers.a = plii_float8_sub(numbers.a, plii_float8_mul(delta, move_a));
    numbers.b = plii_float8_add(numbers.b, plii_float8_mul(delta, move_b));
    return numbers;
}

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
        const int full_count = run->group_count - (run->skipped_count > 0);
        solve(task, run, part.begin, part.end < full_count ? part.end : full_count);
    }
}

#endif
