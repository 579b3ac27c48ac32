#ifndef PLII_LINK_PLANES_KERNEL_H
#define PLII_LINK_PLANES_KERNEL_H

/* What kernels over runs in planes have in common: the nodes of some links. The including file has chosen the
   instruction set. */

#include "math/simd_wide.h"
#include "solver/coloring/link_runs_order.h"
#include "solver/coloring/node_planes.h"

/* Links that are solved together: of groups that follow each other all, if their nodes are in steps of two; the even or
   the odd ones, in steps of one; all of one group, as halves of both; or all, where two and two nodes take turns. */
enum { PLII_RUN_ALL, PLII_RUN_EVEN, PLII_RUN_ODD, PLII_RUN_HALVES, PLII_RUN_TURNS };

typedef struct plii_run_block {
    int kind, count; /* constants where it is about speed */
} plii_run_block;

/* Where nodes lie in a plane: of the first and the second link, which are those of the first even and odd ones. */
typedef struct plii_run_places {
    ptrdiff_t a[2], b[2];
} plii_run_places;

PLII_SIMD_INLINE plii_run_places plii_run_places_of(const plii_planes* planes, const plii_link_run* run, int group) {
    const ptrdiff_t a = plii_link_run_node(run, group), b = a + run->offset;
    return (plii_run_places){{plii_planes_place(planes, a), plii_planes_place(planes, a + 1)},
                             {plii_planes_place(planes, b), plii_planes_place(planes, b + 1)}};
}
PLII_SIMD_INLINE plii_run_places plii_run_places_after(plii_run_places at, ptrdiff_t way) {
    return (plii_run_places){{at.a[0] + way, at.a[1] + way}, {at.b[0] + way, at.b[1] + way}};
}

/* One component of both. */
typedef struct plii_run_numbers {
    plii_wide a, b;
} plii_run_numbers;

PLII_SIMD_INLINE plii_run_numbers plii_run_load_plane(const float* plane, const plii_run_places* at,
                                                      plii_run_block block) {
    const int side = block.kind == PLII_RUN_ODD;
    plii_run_numbers numbers;
    if (block.kind == PLII_RUN_TURNS) {
        plii_wide_load_turns(plane + at->a[0], plane + at->a[1], block.count, &numbers.a, &numbers.b);
    } else if (block.kind == PLII_RUN_HALVES) {
        numbers.a = plii_wide_load_halves(plane + at->a[0], plane + at->a[1]);
        numbers.b = plii_wide_load_halves(plane + at->b[0], plane + at->b[1]);
    } else {
        numbers.a = plii_wide_load(plane + at->a[side], block.count);
        numbers.b = plii_wide_load(plane + at->b[side], block.count);
    }
    return numbers;
}
PLII_SIMD_INLINE void plii_run_store_plane(float* plane, const plii_run_places* at, plii_run_block block,
                                           plii_run_numbers numbers) {
    const int side = block.kind == PLII_RUN_ODD;
    if (block.kind == PLII_RUN_TURNS) {
        plii_wide_store_turns(plane + at->a[0], plane + at->a[1], block.count, numbers.a, numbers.b);
    } else if (block.kind == PLII_RUN_HALVES) {
        plii_wide_store_halves(plane + at->a[0], plane + at->a[1], numbers.a);
        plii_wide_store_halves(plane + at->b[0], plane + at->b[1], numbers.b);
    } else {
        plii_wide_store(plane + at->a[side], numbers.a, block.count);
        plii_wide_store(plane + at->b[side], numbers.b, block.count);
    }
}
/* b - a */
PLII_SIMD_INLINE plii_wide plii_run_difference(plii_run_numbers numbers) {
    return plii_wide_sub(numbers.b, numbers.a);
}
/* a - delta move_a, b + delta move_b */
PLII_SIMD_INLINE plii_run_numbers plii_run_moved(plii_run_numbers numbers, plii_wide delta, plii_wide move_a,
                                                 plii_wide move_b) {
    numbers.a = plii_wide_sub(numbers.a, plii_wide_mul(delta, move_a));
    numbers.b = plii_wide_add(numbers.b, plii_wide_mul(delta, move_b));
    return numbers;
}

/* Where a block has its numbers by slot: from its first group on in the order of slots, and what only kernels over
   planes read and write, where even links come first in a run with steps of one node, then the odd ones. */
typedef struct plii_run_slots {
    ptrdiff_t first, own[2]; /* of even and of odd links; of all the first one */
} plii_run_slots;

PLII_SIMD_INLINE plii_run_slots plii_run_slots_after(plii_run_slots slots, int group_count, ptrdiff_t own) {
    return (plii_run_slots){slots.first + PLII_LINK_LANES * (ptrdiff_t)group_count,
                            {slots.own[0] + own, slots.own[1] + own}};
}

PLII_SIMD_INLINE plii_wide plii_run_load_slots(const float* numbers, plii_run_block block, plii_run_slots slots) {
    const float* first = numbers + slots.first;
    switch (block.kind) {
    case PLII_RUN_ALL:
        return plii_wide_load_slots(first, block.count);
    case PLII_RUN_EVEN:
        return plii_wide_load_fours(first, block.count);
    case PLII_RUN_ODD:
        return plii_wide_load_fours(first + PLII_LINK_LANES / 2, block.count);
    case PLII_RUN_TURNS:
        return plii_wide_load_turned_slots(first, block.count);
    default:
        return plii_wide_load(first, block.count);
    }
}
PLII_SIMD_INLINE plii_wide plii_run_load_own(const float* numbers, plii_run_block block, plii_run_slots slots) {
    return block.kind == PLII_RUN_HALVES ? plii_wide_load_halves(numbers + slots.own[0], numbers + slots.own[1])
                                         : plii_wide_load(numbers + slots.own[block.kind == PLII_RUN_ODD], block.count);
}
PLII_SIMD_INLINE void plii_run_store_own(float* numbers, plii_run_block block, plii_run_slots slots, plii_wide a) {
    if (block.kind == PLII_RUN_HALVES) {
        plii_wide_store_halves(numbers + slots.own[0], numbers + slots.own[1], a);
    } else {
        plii_wide_store(numbers + slots.own[block.kind == PLII_RUN_ODD], a, block.count);
    }
}

/* A block, its nodes and its slots. */
typedef void plii_run_block_fn(const void* task, const plii_run_places* at, plii_run_block block, plii_run_slots slots);

/* Groups that fill a vector, then what is left. */
PLII_SIMD_INLINE void plii_run_blocks(plii_run_places at, ptrdiff_t way, plii_run_slots slots, int group_count,
                                      int kind, plii_run_block_fn* solve, const void* task) {
    enum { GROUPS = PLII_WIDE_LANES / PLII_LINK_LANES };
    for (; group_count >= GROUPS; group_count -= GROUPS) {
        solve(task, &at, (plii_run_block){kind, PLII_WIDE_LANES}, slots);
        at = plii_run_places_after(at, GROUPS * way);
        slots = plii_run_slots_after(slots, GROUPS, PLII_WIDE_LANES);
    }
    if (group_count > 0) { solve(task, &at, (plii_run_block){kind, PLII_LINK_LANES}, slots); }
}
PLII_SIMD_INLINE void plii_run_blocks_of_halves(plii_run_places at, ptrdiff_t way, plii_run_slots slots,
                                                int group_count, plii_run_block_fn* solve, const void* task) {
    enum { HALF = PLII_LINK_LANES / 2, GROUPS = PLII_WIDE_LANES / HALF };
    for (; group_count >= GROUPS; group_count -= GROUPS) {
        solve(task, &at, (plii_run_block){PLII_RUN_EVEN, PLII_WIDE_LANES}, slots);
        solve(task, &at, (plii_run_block){PLII_RUN_ODD, PLII_WIDE_LANES}, slots);
        at = plii_run_places_after(at, GROUPS * way);
        slots = plii_run_slots_after(slots, GROUPS, PLII_WIDE_LANES);
    }
    if (GROUPS > 2 && group_count > 1) {
        solve(task, &at, (plii_run_block){PLII_RUN_EVEN, HALF * group_count}, slots);
        solve(task, &at, (plii_run_block){PLII_RUN_ODD, HALF * group_count}, slots);
    } else if (group_count > 0) {
        solve(task, &at, (plii_run_block){PLII_RUN_HALVES, PLII_LINK_LANES}, slots);
    }
}

/* Groups [begin, end) of a run, without stages, as they have a third fewer operations than in records. */
PLII_SIMD_INLINE void plii_run_in_planes(const plii_planes* planes, const plii_link_run* run, int begin, int end,
                                         plii_run_block_fn* solve, const void* task) {
    const plii_run_places at = plii_run_places_of(planes, run, begin);
    const ptrdiff_t way = plii_link_run_group_way(run->offset, run->step) / 2; /* to the next group */
    const ptrdiff_t slot = (ptrdiff_t)PLII_LINK_LANES * (run->first_group + begin), half = PLII_LINK_LANES / 2;
    if (run->offset == 2 || run->offset == 1 || run->step == 2) {
        const plii_run_slots slots = {slot, {slot, slot}};
        if (run->offset == 2) {
            plii_run_blocks(at, way, slots, end - begin, PLII_RUN_TURNS, solve, task);
        } else {
            plii_run_blocks(at, way, slots, end - begin, PLII_RUN_ALL, solve, task);
        }
    } else {
        const bool is_end = plii_link_run_is_end(run, begin);
        const ptrdiff_t even = is_end ? slot : slot - half * begin;
        const ptrdiff_t odd = even + half * (is_end ? 1 : plii_link_run_full_count(run));
        plii_run_blocks_of_halves(at, way, (plii_run_slots){slot, {even, odd}}, end - begin, solve, task);
    }
}

#endif
