/* Links of runs in planes, and the arithmetic of a link, which is that of btSoftBody::PSolve_Links. The including file
   chooses the instruction set. */

#include "solver/coloring/link_planes_kernel.h"
#include "solver/pbd/links_kernel.h"

/* Of links with nothing to move, or without length, and of lanes without a link nothing moves. */
PLII_SIMD_INLINE plii_wide links_factor(plii_wide length_squared, plii_wide mass_a, plii_wide mass_b,
                                        plii_wide rest_squared, plii_wide inverse_stiffness) {
    const plii_wide mass_term = plii_wide_mul(plii_wide_add(mass_a, mass_b), inverse_stiffness);
    const plii_wide sum = plii_wide_add(rest_squared, length_squared);
    const plii_wide divisor = plii_wide_mul(mass_term, sum);
    /* The quotient, which takes longest, waits for no comparison. */
    const plii_wide factor = plii_wide_div(plii_wide_sub(rest_squared, length_squared), divisor);
    const plii_wide positive = plii_wide_where_greater(sum, plii_wide_all(PLII_EPSILON), divisor);
    return plii_wide_where_greater(positive, plii_wide_all(0.0f), factor);
}
PLII_SIMD_INLINE plii_wide links_length_squared(plii_wide x, plii_wide y, plii_wide z) {
    return plii_wide_add(plii_wide_add(plii_wide_mul(x, x), plii_wide_mul(y, y)), plii_wide_mul(z, z));
}

typedef struct links_planes_task {
    plii_planes planes;
    const float* rest_squared; /* by slot */
    plii_wide inverse_stiffness;
} links_planes_task;

PLII_SIMD_INLINE void links_planes_solve(const void* data, const plii_run_places* at, plii_run_block block,
                                         plii_run_slots slots) {
    const links_planes_task* task = data;
    const plii_planes* planes = &task->planes;
    const plii_run_numbers x = plii_run_load_plane(planes->x, at, block);
    const plii_run_numbers y = plii_run_load_plane(planes->y, at, block);
    const plii_run_numbers z = plii_run_load_plane(planes->z, at, block);
    const plii_run_numbers w = plii_run_load_plane(planes->w, at, block);
    const plii_wide dx = plii_run_difference(x), dy = plii_run_difference(y), dz = plii_run_difference(z);
    const plii_wide factor =
        links_factor(links_length_squared(dx, dy, dz), w.a, w.b, plii_run_load_slots(task->rest_squared, block, slots),
                     task->inverse_stiffness);
    const plii_wide move_a = plii_wide_mul(factor, w.a), move_b = plii_wide_mul(factor, w.b);
    plii_run_store_plane(planes->x, at, block, plii_run_moved(x, dx, move_a, move_b));
    plii_run_store_plane(planes->y, at, block, plii_run_moved(y, dy, move_a, move_b));
    plii_run_store_plane(planes->z, at, block, plii_run_moved(z, dz, move_a, move_b));
}

static void links_planes_run(const void* data, const plii_link_run* run, int begin, int end) {
    const plii_links_task* task = data;
    const float inverse_stiffness = task->inverse_stiffnesses[run->tag & (PLII_LINK_TAG_BENDING - 1)];
    const links_planes_task own = {task->planes, task->rest_squared, plii_wide_all(inverse_stiffness)};
    plii_run_in_planes(&own.planes, run, begin, end, links_planes_solve, &own);
}

static void links_in_planes(const plii_links_task* task, int color, int begin, int end) {
    plii_runs_solve(&task->colors->runs, color, begin, end, links_planes_run, task);
}
