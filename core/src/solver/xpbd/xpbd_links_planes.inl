/* Lengths of links of runs under XPBD in planes, and the arithmetic of a link. The including file chooses the
   instruction set. */

#include "solver/coloring/link_planes_kernel.h"
#include "solver/xpbd/xpbd_links_kernel.h"

PLII_SIMD_INLINE bool xpbd_links_is_damped(const plii_xpbd_link_softness* softness) {
    return softness->gamma > 0.0f;
}
PLII_SIMD_INLINE bool xpbd_links_is_soft(const plii_xpbd_link_softness* softness) {
    return softness->alpha > 0.0f;
}
PLII_SIMD_INLINE const plii_xpbd_link_softness* xpbd_links_softness(const plii_xpbd_links_task* task,
                                                                    plii_link_tag tag) {
    return &task->softness[2 * (tag & (PLII_LINK_TAG_BENDING - 1)) + ((tag & PLII_LINK_TAG_BENDING) != 0)];
}

typedef struct xpbd_links_vector {
    plii_wide x, y, z;
} xpbd_links_vector;

/* b - a */
PLII_SIMD_INLINE xpbd_links_vector xpbd_links_difference(xpbd_links_vector a, xpbd_links_vector b) {
    return (xpbd_links_vector){plii_wide_sub(b.x, a.x), plii_wide_sub(b.y, a.y), plii_wide_sub(b.z, a.z)};
}
PLII_SIMD_INLINE plii_wide xpbd_links_dot(xpbd_links_vector a, xpbd_links_vector b) {
    return plii_wide_add(plii_wide_add(plii_wide_mul(a.x, b.x), plii_wide_mul(a.y, b.y)), plii_wide_mul(a.z, b.z));
}

PLII_SIMD_INLINE plii_wide xpbd_links_where_finite(plii_wide a) {
    a = plii_wide_where_greater(plii_wide_all(INFINITY), a, a);
    return plii_wide_where_greater(a, plii_wide_all(-INFINITY), a);
}

/* Between the sweeps of a substep. */
typedef struct xpbd_links_multipliers {
    float* values;
    bool are_read, are_written;
} xpbd_links_multipliers;

PLII_SIMD_INLINE xpbd_links_multipliers xpbd_links_multipliers_of(const plii_xpbd_links_task* task, ptrdiff_t slot) {
    return (xpbd_links_multipliers){task->multipliers + slot, !task->substep->is_first_sweep,
                                    !task->substep->is_last_sweep};
}

/* plii_xpbd_multiplier over the length: how far to go along the difference, per inverse mass. `motion`: along the
   difference in this substep, only where it is damped. What is not finite does not move: rigid links without length or
   mass to move, and lanes without a link, whose value is infinite. */
PLII_SIMD_LARGE plii_wide xpbd_links_factor(plii_wide length_squared, plii_wide motion, plii_wide weight,
                                            const plii_xpbd_link_softness* softness, plii_wide rest_length,
                                            xpbd_links_multipliers multipliers, plii_run_block block,
                                            plii_run_slots slots) {
    const plii_wide zero = plii_wide_all(0.0f);
    const plii_wide length = plii_wide_sqrt(length_squared);
    plii_wide force = plii_wide_sub(rest_length, length);
    if (!xpbd_links_is_soft(softness)) {
        return xpbd_links_where_finite(plii_wide_div(force, plii_wide_mul(weight, length)));
    }
    const plii_wide inverse = plii_wide_where_greater(length, zero, plii_wide_div(plii_wide_all(1.0f), length));
    const plii_wide alpha = plii_wide_all(softness->alpha), gamma = plii_wide_all(softness->gamma);
    plii_wide multiplier = plii_wide_all(0.0f);
    if (multipliers.are_read) {
        multiplier = plii_run_load_own(multipliers.values, block, slots);
        force = plii_wide_sub(force, plii_wide_mul(alpha, multiplier));
    }
    if (xpbd_links_is_damped(softness)) {
        force = plii_wide_sub(force, plii_wide_mul(gamma, plii_wide_mul(motion, inverse)));
    }
    const plii_wide divisor = plii_wide_add(plii_wide_mul(plii_wide_all(1.0f + softness->gamma), weight), alpha);
    const plii_wide change =
        xpbd_links_where_finite(plii_wide_where_greater(weight, zero, plii_wide_div(force, divisor)));
    if (multipliers.are_written) {
        plii_run_store_own(multipliers.values, block, slots, plii_wide_add(multiplier, change));
    }
    return plii_wide_mul(change, inverse);
}

typedef struct xpbd_links_component {
    plii_run_numbers displacements;
    plii_wide delta;
} xpbd_links_component;

PLII_SIMD_INLINE xpbd_links_component xpbd_links_measure_plane(const float* positions, const float* displacements,
                                                               const plii_run_places* at, plii_run_block block) {
    const plii_run_numbers moved = plii_run_load_plane(displacements, at, block);
    return (xpbd_links_component){moved, plii_wide_add(plii_run_difference(plii_run_load_plane(positions, at, block)),
                                                       plii_run_difference(moved))};
}
PLII_SIMD_INLINE plii_wide xpbd_links_motion_in_plane(const xpbd_links_component* component, const float* carried,
                                                      const plii_run_places* at, plii_run_block block) {
    const plii_run_numbers moved = component->displacements, start = plii_run_load_plane(carried, at, block);
    return plii_wide_sub(plii_wide_sub(moved.b, start.b), plii_wide_sub(moved.a, start.a));
}
PLII_SIMD_INLINE void xpbd_links_move_plane(float* displacements, const plii_run_places* at, plii_run_block block,
                                            const xpbd_links_component* component, plii_wide move_a, plii_wide move_b) {
    plii_run_store_plane(displacements, at, block,
                         plii_run_moved(component->displacements, component->delta, move_a, move_b));
}

typedef struct xpbd_links_planes_task {
    plii_xpbd_planes planes;
    plii_xpbd_link_softness softness;
    const float* rest_lengths; /* by slot */
    xpbd_links_multipliers multipliers;
} xpbd_links_planes_task;

PLII_SIMD_INLINE void xpbd_links_planes_solve(const void* data, const plii_run_places* at, plii_run_block block,
                                              plii_run_slots slots) {
    const xpbd_links_planes_task* task = data;
    const plii_planes *positions = &task->planes.positions, *displacements = &task->planes.displacements;
    const xpbd_links_component x = xpbd_links_measure_plane(positions->x, displacements->x, at, block);
    const xpbd_links_component y = xpbd_links_measure_plane(positions->y, displacements->y, at, block);
    const xpbd_links_component z = xpbd_links_measure_plane(positions->z, displacements->z, at, block);
    const xpbd_links_vector delta = {x.delta, y.delta, z.delta};
    const plii_run_numbers masses = plii_run_load_plane(displacements->w, at, block);
    const plii_wide length_squared = xpbd_links_dot(delta, delta);
    plii_wide motion = length_squared;
    if (xpbd_links_is_damped(&task->softness)) {
        const plii_planes* carried = &task->planes.carried;
        const xpbd_links_vector moved = {xpbd_links_motion_in_plane(&x, carried->x, at, block),
                                         xpbd_links_motion_in_plane(&y, carried->y, at, block),
                                         xpbd_links_motion_in_plane(&z, carried->z, at, block)};
        motion = xpbd_links_dot(delta, moved);
    }
    const plii_wide factor =
        xpbd_links_factor(length_squared, motion, plii_wide_add(masses.a, masses.b), &task->softness,
                          plii_run_load_slots(task->rest_lengths, block, slots), task->multipliers, block, slots);
    const plii_wide move_a = plii_wide_mul(masses.a, factor), move_b = plii_wide_mul(masses.b, factor);
    xpbd_links_move_plane(displacements->x, at, block, &x, move_a, move_b);
    xpbd_links_move_plane(displacements->y, at, block, &y, move_a, move_b);
    xpbd_links_move_plane(displacements->z, at, block, &z, move_a, move_b);
}

static void xpbd_links_planes_run(const void* data, const plii_link_run* run, int begin, int end) {
    const plii_xpbd_links_task* task = data;
    const xpbd_links_planes_task own = {*task->substep->planes, *xpbd_links_softness(task, run->tag),
                                        task->rest_lengths, xpbd_links_multipliers_of(task, 0)};
    plii_run_in_planes(&own.planes.positions, run, begin, end, xpbd_links_planes_solve, &own);
}

static void xpbd_links_in_planes(const plii_xpbd_links_task* task, int color, int begin, int end) {
    plii_runs_solve(&task->colors->runs, color, begin, end, xpbd_links_planes_run, task);
}
