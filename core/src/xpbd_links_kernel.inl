/* The length constraint of XPBD on eight links at once, in stages over a few groups as in links_kernel.inl. The
   including file chooses the instruction set and the name of the kernel. */

#include "simd.h"
#include "xpbd_links_kernel.h"

#include <float.h>

enum { XPBD_LINKS_BATCH = 8 }; /* groups */

typedef struct xpbd_links_group {
    plii_packed8 delta; /* from the first nodes to the others */
    plii_float8 length_squared;
    plii_float8 motion;         /* along delta in this substep, only where it is damped */
    plii_float8 mass_a, mass_b; /* inverse masses, later moves along delta */
} xpbd_links_group;

/* The nodes of a group: where they were, how far they moved, and how far when the substep began. */
typedef struct xpbd_links_nodes {
    plii_packed8 positions, displacements;
} xpbd_links_nodes;

PLII_SIMD_INLINE plii_float8 xpbd_links_dot(plii_float8 ax, plii_float8 ay, plii_float8 az, plii_float8 bx,
                                            plii_float8 by, plii_float8 bz) {
    return plii_float8_add(plii_float8_add(plii_float8_mul(ax, bx), plii_float8_mul(ay, by)), plii_float8_mul(az, bz));
}

PLII_SIMD_INLINE void xpbd_links_measure(xpbd_links_group* group, xpbd_links_nodes a, xpbd_links_nodes b) {
    group->delta = plii_packed8_add(plii_packed8_sub(b.positions, a.positions),
                                    plii_packed8_sub(b.displacements, a.displacements));
    const plii_records8 d = plii_packed8_turn(group->delta);
    group->length_squared = xpbd_links_dot(d.x, d.y, d.z, d.x, d.y, d.z);
    group->mass_a = plii_packed8_turn(a.displacements).w;
    group->mass_b = plii_packed8_turn(b.displacements).w;
}

PLII_SIMD_INLINE void xpbd_links_measure_motion(xpbd_links_group* group, plii_packed8 displacements_a,
                                                plii_packed8 displacements_b, plii_packed8 carried_a,
                                                plii_packed8 carried_b) {
    const plii_records8 motion = plii_packed8_turn(
        plii_packed8_sub(plii_packed8_sub(displacements_b, carried_b), plii_packed8_sub(displacements_a, carried_a)));
    const plii_records8 d = plii_packed8_turn(group->delta);
    group->motion = xpbd_links_dot(d.x, d.y, d.z, motion.x, motion.y, motion.z);
}

PLII_SIMD_INLINE bool xpbd_links_is_damped(const plii_xpbd_link_softness* softness) {
    return softness->gamma > 0.0f;
}
PLII_SIMD_INLINE bool xpbd_links_is_soft(const plii_xpbd_link_softness* softness) {
    return softness->alpha > 0.0f;
}

PLII_SIMD_INLINE plii_float8 xpbd_links_where_finite(plii_float8 a) {
    a = plii_float8_where_greater(plii_float8_all(INFINITY), a, a);
    return plii_float8_where_greater(a, plii_float8_all(-INFINITY), a);
}

/* plii_xpbd_multiplier, then the moves. Links without length have no direction; lanes without a link have an infinite
   value, and so no finite change. */
PLII_SIMD_INLINE void xpbd_links_divide(xpbd_links_group* group, const plii_xpbd_link_softness* softness,
                                        const float* rest_lengths, float* multipliers) {
    const plii_float8 zero = plii_float8_all(0.0f);
    const plii_float8 length = plii_float8_sqrt(group->length_squared);
    const plii_float8 weight = plii_float8_add(group->mass_a, group->mass_b);
    plii_float8 force = plii_float8_sub(plii_float8_load(rest_lengths), length), move;
    if (xpbd_links_is_soft(softness)) {
        const plii_float8 inverse =
            plii_float8_where_greater(length, zero, plii_float8_div(plii_float8_all(1.0f), length));
        const plii_float8 alpha = plii_float8_all(softness->alpha), gamma = plii_float8_all(softness->gamma);
        force = plii_float8_sub(force, plii_float8_mul(alpha, plii_float8_load(multipliers)));
        if (xpbd_links_is_damped(softness)) {
            force = plii_float8_sub(force, plii_float8_mul(gamma, plii_float8_mul(group->motion, inverse)));
        }
        const plii_float8 divisor =
            plii_float8_add(plii_float8_mul(plii_float8_all(1.0f + softness->gamma), weight), alpha);
        const plii_float8 change =
            xpbd_links_where_finite(plii_float8_where_greater(weight, zero, plii_float8_div(force, divisor)));
        plii_float8_store(multipliers, plii_float8_add(plii_float8_load(multipliers), change));
        move = plii_float8_mul(change, inverse);
    } else {
        const plii_float8 divisor = plii_float8_mul(weight, length);
        move = xpbd_links_where_finite(plii_float8_where_greater(divisor, zero, plii_float8_div(force, divisor)));
    }
    group->mass_a = plii_float8_mul(group->mass_a, move);
    group->mass_b = plii_float8_mul(group->mass_b, move);
}

PLII_SIMD_INLINE const plii_xpbd_link_softness* xpbd_links_softness(const plii_xpbd_links_task* task,
                                                                    plii_link_tag tag) {
    return &task->softness[2 * (tag & (PLII_LINK_TAG_BENDING - 1)) + ((tag & PLII_LINK_TAG_BENDING) != 0)];
}

// --------------------------------------------------------------------------------------------------------- in runs

PLII_SIMD_INLINE xpbd_links_nodes xpbd_links_load(const plii_xpbd_links_task* task, ptrdiff_t first, ptrdiff_t stride) {
    return (xpbd_links_nodes){plii_packed8_load(task->body->positions + first, stride),
                              plii_packed8_load(task->substep->displacements + first, stride)};
}
PLII_SIMD_INLINE void xpbd_links_load_motion(xpbd_links_group* group, const plii_xpbd_substep* substep, ptrdiff_t a,
                                             ptrdiff_t b, ptrdiff_t stride) {
    xpbd_links_measure_motion(group, plii_packed8_load(substep->displacements + a, stride),
                              plii_packed8_load(substep->displacements + b, stride),
                              plii_packed8_load(substep->carried + a, stride),
                              plii_packed8_load(substep->carried + b, stride));
}

PLII_SIMD_INLINE void xpbd_links_run(const plii_xpbd_links_task* task, const plii_link_run* run, int begin, int end,
                                     ptrdiff_t stride, ptrdiff_t offset) {
    const plii_xpbd_link_softness* softness = xpbd_links_softness(task, run->tag);
    const bool is_damped = xpbd_links_is_damped(softness);
    const ptrdiff_t step = PLII_LINK_GROUP * stride;
    const bool is_mixed = stride == 2 && offset == 1;
    ptrdiff_t slot = (ptrdiff_t)PLII_LINK_GROUP * (run->first_group + begin);
    ptrdiff_t first = run->node + step * begin;
    xpbd_links_group groups[XPBD_LINKS_BATCH];
    for (int left = end - begin; left > 0; left -= XPBD_LINKS_BATCH) {
        const int count = left < XPBD_LINKS_BATCH ? left : XPBD_LINKS_BATCH;
        for (int i = 0; i < count; ++i) {
            const ptrdiff_t a = first + i * step;
            xpbd_links_nodes nodes_a, nodes_b;
            if (is_mixed) {
                plii_packed8_load_mixed(task->body->positions + a, &nodes_a.positions, &nodes_b.positions);
                plii_packed8_load_mixed(task->substep->displacements + a, &nodes_a.displacements,
                                        &nodes_b.displacements);
            } else {
                nodes_a = xpbd_links_load(task, a, stride);
                nodes_b = xpbd_links_load(task, a + offset, stride);
            }
            xpbd_links_measure(&groups[i], nodes_a, nodes_b);
            if (is_damped) { xpbd_links_load_motion(&groups[i], task->substep, a, a + offset, stride); }
        }
        for (int i = 0; i < count; ++i) {
            xpbd_links_divide(&groups[i], softness, task->rest_lengths + slot + PLII_LINK_GROUP * i,
                              task->multipliers + slot + PLII_LINK_GROUP * i);
        }
        for (int i = 0; i < count; ++i) {
            const xpbd_links_group* g = &groups[i];
            pli_vec4* at = task->substep->displacements + first + i * step;
            plii_packed8 a, b;
            if (is_mixed) {
                plii_packed8_load_mixed(at, &a, &b);
            } else {
                a = plii_packed8_load(at, stride);
                b = plii_packed8_load(at + offset, stride);
            }
            a = plii_packed8_sub(a, plii_packed8_scale_xyz(g->delta, g->mass_a));
            b = plii_packed8_add(b, plii_packed8_scale_xyz(g->delta, g->mass_b));
            if (is_mixed) {
                plii_packed8_store_mixed(at, a, b);
            } else {
                plii_packed8_store(at, stride, a);
                plii_packed8_store(at + offset, stride, b);
            }
        }
        first += count * step;
        slot += PLII_LINK_GROUP * count;
    }
}

/* The strides of grids get code of their own. */
static void xpbd_links_run_any(const plii_xpbd_links_task* task, const plii_link_run* run, int begin, int end) {
    if (run->stride == 1) {
        xpbd_links_run(task, run, begin, end, 1, run->offset);
    } else if (run->stride == 2 && run->offset == 1) {
        xpbd_links_run(task, run, begin, end, 2, 1);
    } else {
        xpbd_links_run(task, run, begin, end, run->stride, run->offset);
    }
}

// ------------------------------------------------------------------------------------------------------- in blocks

PLII_SIMD_INLINE xpbd_links_nodes xpbd_links_gather(const plii_xpbd_links_task* task, const uint32_t* places) {
    return (xpbd_links_nodes){plii_packed8_gather(task->body->positions, places),
                              plii_packed8_gather(task->substep->displacements, places)};
}
PLII_SIMD_INLINE void xpbd_links_measure_block(xpbd_links_group* group, const plii_xpbd_links_task* task,
                                               const uint32_t* a, const uint32_t* b, bool is_damped) {
    xpbd_links_measure(group, xpbd_links_gather(task, a), xpbd_links_gather(task, b));
    if (is_damped) {
        const plii_xpbd_substep* substep = task->substep;
        xpbd_links_measure_motion(group, plii_packed8_gather(substep->displacements, a),
                                  plii_packed8_gather(substep->displacements, b),
                                  plii_packed8_gather(substep->carried, a), plii_packed8_gather(substep->carried, b));
    }
}
PLII_SIMD_INLINE void xpbd_links_move_block(const xpbd_links_group* g, pli_vec4* displacements, const uint32_t* a,
                                            const uint32_t* b) {
    const plii_packed8 change_a = plii_packed8_scale_xyz(g->delta, g->mass_a);
    plii_packed8_scatter(displacements, a, plii_packed8_sub(plii_packed8_gather(displacements, a), change_a));
    const plii_packed8 change_b = plii_packed8_scale_xyz(g->delta, g->mass_b);
    plii_packed8_scatter(displacements, b, plii_packed8_add(plii_packed8_gather(displacements, b), change_b));
}

static void xpbd_links_blocks(const plii_xpbd_links_task* task, int begin, int end) {
    const plii_link_colors* colors = task->colors;
    const ptrdiff_t first_slot = (ptrdiff_t)PLII_LINK_GROUP * colors->run_group_count;
    xpbd_links_group groups[XPBD_LINKS_BATCH];
    for (int first = begin; first < end; first += XPBD_LINKS_BATCH) {
        const int count = end - first < XPBD_LINKS_BATCH ? end - first : XPBD_LINKS_BATCH;
        const ptrdiff_t slot = first_slot + (ptrdiff_t)PLII_LINK_GROUP * first;
        const uint32_t(*places)[2][PLII_LINK_GROUP] =
            (const uint32_t(*)[2][PLII_LINK_GROUP])colors->block_places + first;
        for (int i = 0; i < count; ++i) {
            xpbd_links_measure_block(&groups[i], task, places[i][0], places[i][1],
                                     xpbd_links_is_damped(xpbd_links_softness(task, colors->block_tags[first + i])));
        }
        for (int i = 0; i < count; ++i) {
            const plii_xpbd_link_softness* softness = xpbd_links_softness(task, colors->block_tags[first + i]);
            xpbd_links_divide(&groups[i], softness, task->rest_lengths + slot + PLII_LINK_GROUP * i,
                              task->multipliers + slot + PLII_LINK_GROUP * i);
        }
        for (int i = 0; i < count; ++i) {
            xpbd_links_move_block(&groups[i], task->substep->displacements, places[i][0], places[i][1]);
        }
    }
}

static void xpbd_links_color(const plii_xpbd_links_task* task, int begin, int end) {
    const plii_link_colors* colors = task->colors;
    const plii_link_color* color = &colors->colors[task->color];
    for (int r = color[0].first_run; r < color[1].first_run; ++r) {
        const plii_link_part part = plii_link_run_part(&colors->runs[r], color, begin, end);
        if (part.begin < part.end) { xpbd_links_run_any(task, &colors->runs[r], part.begin, part.end); }
    }
    const plii_link_part part = plii_link_block_part(color, begin, end);
    xpbd_links_blocks(task, part.begin, part.end);
}

/* One link after the other: all lanes have its nodes, only the last one, which is stored last, moves them. */
static void xpbd_links_serial(const plii_xpbd_links_task* task) {
    const plii_link_colors* colors = task->colors;
    const pli_body* body = task->body;
    const ptrdiff_t first_slot = plii_link_colors_slot_count(colors) - colors->serial_count;
    for (int i = 0; i < colors->serial_count; ++i) {
        const int link = colors->serial_links[i];
        uint32_t places[2][PLII_LINK_GROUP];
        const int last = PLII_LINK_GROUP - 1;
        float rests[PLII_LINK_GROUP], multipliers[PLII_LINK_GROUP] = {0.0f};
        multipliers[last] = task->multipliers[first_slot + i];
        for (int lane = 0; lane < PLII_LINK_GROUP; ++lane) {
            places[0][lane] = plii_simd_place(body->links[link].nodes[0]);
            places[1][lane] = plii_simd_place(body->links[link].nodes[1]);
            rests[lane] = lane == last ? task->rest_lengths[first_slot + i] : PLII_XPBD_NO_LINK;
        }
        const plii_xpbd_link_softness* softness = xpbd_links_softness(task, plii_link_colors_tag(body, link));
        xpbd_links_group group;
        group.motion = plii_float8_all(0.0f);
        xpbd_links_measure_block(&group, task, places[0], places[1], xpbd_links_is_damped(softness));
        xpbd_links_divide(&group, softness, rests, multipliers);
        xpbd_links_move_block(&group, task->substep->displacements, places[0], places[1]);
        task->multipliers[first_slot + i] = multipliers[last];
    }
}
