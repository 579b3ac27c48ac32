/* The length constraint of XPBD on eight links at once: in stages over a few groups, quads round by round, as in
   links_kernel.inl. The including file chooses the instruction set and the name of the kernel. */

#include "solver/coloring/link_quads_kernel.h"
#include "solver/coloring/link_runs_kernel.h"
#include "solver/xpbd/xpbd_links_planes.inl"

#include <string.h>

enum { XPBD_LINKS_BATCH = 8, XPBD_LINKS_QUADS_BATCH = 4 }; /* groups */

/* How multipliers of a group in records lie. */
static const plii_run_block xpbd_links_group_block = {PLII_RUN_ALL, PLII_LINK_LANES};
static const plii_run_slots xpbd_links_group_slots = {0, {0, 0}};

// ---------------------------------------------------------------------------------------------------------- in stages

PLII_SIMD_INLINE xpbd_links_vector xpbd_links_xyz(plii_records8 a) {
    return (xpbd_links_vector){a.x, a.y, a.z};
}

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

PLII_SIMD_INLINE void xpbd_links_measure(xpbd_links_group* group, xpbd_links_nodes a, xpbd_links_nodes b) {
    group->delta = plii_packed8_add(plii_packed8_sub(b.positions, a.positions),
                                    plii_packed8_sub(b.displacements, a.displacements));
    const xpbd_links_vector d = xpbd_links_xyz(plii_packed8_turn(group->delta));
    group->length_squared = group->motion = xpbd_links_dot(d, d);
    group->mass_a = plii_packed8_turn(a.displacements).w;
    group->mass_b = plii_packed8_turn(b.displacements).w;
}

PLII_SIMD_INLINE void xpbd_links_measure_motion(xpbd_links_group* group, plii_packed8 displacements_a,
                                                plii_packed8 displacements_b, plii_packed8 carried_a,
                                                plii_packed8 carried_b) {
    const plii_packed8 motion =
        plii_packed8_sub(plii_packed8_sub(displacements_b, carried_b), plii_packed8_sub(displacements_a, carried_a));
    group->motion =
        xpbd_links_dot(xpbd_links_xyz(plii_packed8_turn(group->delta)), xpbd_links_xyz(plii_packed8_turn(motion)));
}

PLII_SIMD_INLINE void xpbd_links_divide(xpbd_links_group* group, const plii_xpbd_link_softness* softness,
                                        const float* rest_lengths, xpbd_links_multipliers multipliers) {
    const plii_float8 weight = plii_float8_add(group->mass_a, group->mass_b);
    const plii_float8 factor =
        xpbd_links_factor(group->length_squared, group->motion, weight, softness, plii_float8_load(rest_lengths),
                          multipliers, xpbd_links_group_block, xpbd_links_group_slots);
    group->mass_a = plii_float8_mul(group->mass_a, factor);
    group->mass_b = plii_float8_mul(group->mass_b, factor);
}

// --------------------------------------------------------------------------------------------------------- in runs

typedef struct xpbd_links_pair {
    xpbd_links_nodes a, b;
} xpbd_links_pair;

PLII_SIMD_INLINE xpbd_links_pair xpbd_links_load(const plii_xpbd_links_task* task, ptrdiff_t first,
                                                 plii_run_form form) {
    const plii_run_records positions = plii_run_load(task->body->positions + first, form);
    const plii_run_records displacements = plii_run_load(task->substep->displacements + first, form);
    return (xpbd_links_pair){{positions.a, displacements.a}, {positions.b, displacements.b}};
}
PLII_SIMD_INLINE void xpbd_links_load_motion(xpbd_links_group* group, const plii_xpbd_substep* substep, ptrdiff_t first,
                                             plii_run_form form) {
    const plii_run_records displacements = plii_run_load(substep->displacements + first, form);
    const plii_run_records carried = plii_run_load(substep->carried + first, form);
    xpbd_links_measure_motion(group, displacements.a, displacements.b, carried.a, carried.b);
}

PLII_SIMD_INLINE void xpbd_links_run(const plii_xpbd_links_task* task, const plii_link_run* run, int begin, int end,
                                     plii_run_form form) {
    const plii_xpbd_link_softness* softness = xpbd_links_softness(task, run->tag);
    const ptrdiff_t way = plii_run_way(form);
    ptrdiff_t slot = (ptrdiff_t)PLII_LINK_LANES * (run->first_group + begin);
    ptrdiff_t first = plii_link_run_node(run, begin);
    xpbd_links_group groups[XPBD_LINKS_BATCH];
    for (int left = end - begin; left > 0; left -= XPBD_LINKS_BATCH) {
        const int count = left < XPBD_LINKS_BATCH ? left : XPBD_LINKS_BATCH;
        for (int i = 0; i < count; ++i) {
            const xpbd_links_pair nodes = xpbd_links_load(task, first + i * way, form);
            xpbd_links_measure(&groups[i], nodes.a, nodes.b);
            if (xpbd_links_is_damped(softness)) {
                xpbd_links_load_motion(&groups[i], task->substep, first + i * way, form);
            }
        }
        for (int i = 0; i < count; ++i) {
            const float* rest = task->rest_lengths + slot + PLII_LINK_LANES * i;
            xpbd_links_divide(&groups[i], softness, rest,
                              xpbd_links_multipliers_of(task, slot + (ptrdiff_t)PLII_LINK_LANES * i));
        }
        for (int i = 0; i < count; ++i) {
            const xpbd_links_group* g = &groups[i];
            pli_vec4* at = task->substep->displacements + first + i * way;
            const plii_run_records before = plii_run_load(at, form);
            plii_run_store(at, form,
                           (plii_run_records){plii_packed8_sub(before.a, plii_packed8_scale_xyz(g->delta, g->mass_a)),
                                              plii_packed8_add(before.b, plii_packed8_scale_xyz(g->delta, g->mass_b))});
        }
        first += count * way;
        slot += PLII_LINK_LANES * count;
    }
}

/* Each form gets code of its own. */
static void xpbd_links_run_of_any_form(const void* data, const plii_link_run* run, int begin, int end) {
    const plii_xpbd_links_task* task = data;
    if (run->offset == 1) {
        xpbd_links_run(task, run, begin, end, (plii_run_form){1, 1, 1});
    } else if (run->offset == 2) {
        xpbd_links_run(task, run, begin, end, (plii_run_form){2, 1, 2});
    } else if (run->step == 2) {
        xpbd_links_run(task, run, begin, end, (plii_run_form){run->offset, 2, 0});
    } else {
        xpbd_links_run(task, run, begin, end, (plii_run_form){run->offset, 1, 0});
    }
}

// ------------------------------------------------------------------------------------------------------- in single
// links

PLII_SIMD_INLINE xpbd_links_nodes xpbd_links_gather_single(const plii_xpbd_links_task* task, const uint32_t* places) {
    return (xpbd_links_nodes){plii_packed8_gather(task->body->positions, places),
                              plii_packed8_gather(task->substep->displacements, places)};
}
PLII_SIMD_INLINE void xpbd_links_measure_single(xpbd_links_group* group, const plii_xpbd_links_task* task,
                                                const uint32_t* a, const uint32_t* b, bool is_damped) {
    xpbd_links_measure(group, xpbd_links_gather_single(task, a), xpbd_links_gather_single(task, b));
    if (is_damped) {
        const plii_xpbd_substep* substep = task->substep;
        xpbd_links_measure_motion(group, plii_packed8_gather(substep->displacements, a),
                                  plii_packed8_gather(substep->displacements, b),
                                  plii_packed8_gather(substep->carried, a), plii_packed8_gather(substep->carried, b));
    }
}
PLII_SIMD_INLINE void xpbd_links_move_single(const xpbd_links_group* g, pli_vec4* displacements, const uint32_t* a,
                                             const uint32_t* b) {
    const plii_packed8 change_a = plii_packed8_scale_xyz(g->delta, g->mass_a);
    plii_packed8_scatter(displacements, a, plii_packed8_sub(plii_packed8_gather(displacements, a), change_a));
    const plii_packed8 change_b = plii_packed8_scale_xyz(g->delta, g->mass_b);
    plii_packed8_scatter(displacements, b, plii_packed8_add(plii_packed8_gather(displacements, b), change_b));
}

/* Groups of single links, whose slots and places follow each other. */
static void xpbd_links_singles(const plii_xpbd_links_task* task, const plii_link_group* groups, int count) {
    const ptrdiff_t slot = plii_quad_first_slot(task->colors, groups);
    const plii_quad_places places = plii_quad_places_of(task->colors, groups);
    xpbd_links_group measured[XPBD_LINKS_BATCH];
    for (int i = 0; i < count; ++i) {
        xpbd_links_measure_single(&measured[i], task, places[2 * i], places[2 * i + 1],
                                  xpbd_links_is_damped(xpbd_links_softness(task, groups[i].tag)));
    }
    for (int i = 0; i < count; ++i) {
        xpbd_links_divide(&measured[i], xpbd_links_softness(task, groups[i].tag),
                          task->rest_lengths + slot + PLII_LINK_LANES * i,
                          xpbd_links_multipliers_of(task, slot + (ptrdiff_t)PLII_LINK_LANES * i));
    }
    for (int i = 0; i < count; ++i) {
        xpbd_links_move_single(&measured[i], task->substep->displacements, places[2 * i], places[2 * i + 1]);
    }
}

// ----------------------------------------------------------------------------------------------------------- in quads

/* The nodes of eight quads: where they were, how far they moved, and how far when the substep began. */
typedef struct xpbd_links_quads {
    plii_records8 displacements[4];
    xpbd_links_vector positions[4];
} xpbd_links_quads;
typedef struct xpbd_links_starts {
    xpbd_links_vector carried[4];
} xpbd_links_starts;

/* What the rounds of a group go on with. */
typedef struct xpbd_links_rows {
    const float* rest_lengths;
    xpbd_links_multipliers multipliers;
    plii_xpbd_link_softness softness;
} xpbd_links_rows;

typedef struct xpbd_links_link {
    xpbd_links_vector delta;
    plii_float8 length_squared;
    plii_float8 motion; /* along delta in this substep, only where it is damped */
} xpbd_links_link;

PLII_SIMD_INLINE xpbd_links_vector xpbd_links_sum(xpbd_links_vector a, xpbd_links_vector b) {
    return (xpbd_links_vector){plii_float8_add(a.x, b.x), plii_float8_add(a.y, b.y), plii_float8_add(a.z, b.z)};
}

/* Without `starts` the link is not damped. */
PLII_SIMD_INLINE xpbd_links_link xpbd_links_measure_pair(const xpbd_links_quads* quads, const xpbd_links_starts* starts,
                                                         int a, int b) {
    const xpbd_links_vector moved_a = xpbd_links_xyz(quads->displacements[a]);
    const xpbd_links_vector moved_b = xpbd_links_xyz(quads->displacements[b]);
    xpbd_links_link link;
    link.delta = xpbd_links_sum(xpbd_links_difference(quads->positions[a], quads->positions[b]),
                                xpbd_links_difference(moved_a, moved_b));
    link.length_squared = link.motion = xpbd_links_dot(link.delta, link.delta);
    if (starts != NULL) {
        const xpbd_links_vector motion = xpbd_links_difference(xpbd_links_difference(starts->carried[a], moved_a),
                                                               xpbd_links_difference(starts->carried[b], moved_b));
        link.motion = xpbd_links_dot(link.delta, motion);
    }
    return link;
}

PLII_SIMD_INLINE plii_float8 xpbd_links_row_factor(const xpbd_links_link* link, plii_float8 weight,
                                                   const xpbd_links_rows* rows, int row) {
    const ptrdiff_t slot = (ptrdiff_t)PLII_LINK_LANES * row;
    xpbd_links_multipliers multipliers = rows->multipliers;
    multipliers.values += slot;
    return xpbd_links_factor(link->length_squared, link->motion, weight, &rows->softness,
                             plii_float8_load(rows->rest_lengths + slot), multipliers, xpbd_links_group_block,
                             xpbd_links_group_slots);
}

PLII_SIMD_INLINE void xpbd_links_move_pair(plii_records8* a, plii_records8* b, const xpbd_links_vector* delta,
                                           plii_float8 factor) {
    const plii_float8 move_a = plii_float8_mul(factor, a->w), move_b = plii_float8_mul(factor, b->w);
    a->x = plii_float8_sub(a->x, plii_float8_mul(delta->x, move_a));
    a->y = plii_float8_sub(a->y, plii_float8_mul(delta->y, move_a));
    a->z = plii_float8_sub(a->z, plii_float8_mul(delta->z, move_a));
    b->x = plii_float8_add(b->x, plii_float8_mul(delta->x, move_b));
    b->y = plii_float8_add(b->y, plii_float8_mul(delta->y, move_b));
    b->z = plii_float8_add(b->z, plii_float8_mul(delta->z, move_b));
}

PLII_SIMD_LARGE void xpbd_links_solve_one(xpbd_links_quads* quads, const xpbd_links_starts* starts, int a, int b,
                                          const xpbd_links_rows* rows) {
    plii_records8* moved = quads->displacements;
    const xpbd_links_link link = xpbd_links_measure_pair(quads, starts, a, b);
    const plii_float8 factor = xpbd_links_row_factor(&link, plii_float8_add(moved[a].w, moved[b].w), rows, 0);
    xpbd_links_move_pair(&moved[a], &moved[b], &link.delta, factor);
}
/* Links between a and b and between c and d. */
PLII_SIMD_LARGE void xpbd_links_solve_two(xpbd_links_quads* quads, const xpbd_links_starts* starts, int a, int b, int c,
                                          int d, const xpbd_links_rows* rows) {
    plii_records8* moved = quads->displacements;
    const xpbd_links_link ab = xpbd_links_measure_pair(quads, starts, a, b);
    const xpbd_links_link cd = xpbd_links_measure_pair(quads, starts, c, d);
    const plii_float8 factor_ab = xpbd_links_row_factor(&ab, plii_float8_add(moved[a].w, moved[b].w), rows, 0);
    const plii_float8 factor_cd = xpbd_links_row_factor(&cd, plii_float8_add(moved[c].w, moved[d].w), rows, 1);
    xpbd_links_move_pair(&moved[a], &moved[b], &ab.delta, factor_ab);
    xpbd_links_move_pair(&moved[c], &moved[d], &cd.delta, factor_cd);
}

/* Two pairs of nodes, of which both, one or none have links. */
PLII_SIMD_INLINE void xpbd_links_round(xpbd_links_quads* quads, const xpbd_links_starts* starts, int round, int pairs,
                                       xpbd_links_rows* rows) {
    const uint8_t *first = plii_link_pair_nodes[2 * round], *second = plii_link_pair_nodes[2 * round + 1];
    const int own = pairs >> 2 * round & 3;
    if (own == 3) {
        xpbd_links_solve_two(quads, starts, first[0], first[1], second[0], second[1], rows);
    } else if (own == 1) {
        xpbd_links_solve_one(quads, starts, first[0], first[1], rows);
    } else if (own == 2) {
        xpbd_links_solve_one(quads, starts, second[0], second[1], rows);
    }
    const int done = (own & 1) + (own >> 1);
    rows->rest_lengths += PLII_LINK_LANES * done;
    rows->multipliers.values += PLII_LINK_LANES * done;
}

PLII_SIMD_INLINE void xpbd_links_gather_node(xpbd_links_quads* quads, xpbd_links_starts* starts,
                                             const plii_xpbd_links_task* task, int node, const uint32_t* places) {
    const plii_records8 position = plii_quad_gather(task->body->positions, places);
    quads->positions[node] = xpbd_links_xyz(position);
    quads->displacements[node] = plii_quad_gather(task->substep->displacements, places);
    if (starts != NULL) {
        const plii_records8 carried = plii_quad_gather(task->substep->carried, places);
        starts->carried[node] = xpbd_links_xyz(carried);
    }
}
PLII_SIMD_LARGE void xpbd_links_gather(xpbd_links_quads* quads, xpbd_links_starts* starts,
                                       const plii_xpbd_links_task* task, plii_quad_places places) {
    xpbd_links_gather_node(quads, starts, task, 0, places[0]);
    xpbd_links_gather_node(quads, starts, task, 1, places[1]);
    xpbd_links_gather_node(quads, starts, task, 2, places[2]);
    xpbd_links_gather_node(quads, starts, task, 3, places[3]);
}
PLII_SIMD_LARGE void xpbd_links_scatter(const xpbd_links_quads* quads, const plii_xpbd_links_task* task,
                                        plii_quad_places places) {
    pli_vec4* displacements = task->substep->displacements;
    plii_quad_scatter(displacements, places[3], &quads->displacements[3]);
    plii_quad_scatter(displacements, places[2], &quads->displacements[2]);
    plii_quad_scatter(displacements, places[1], &quads->displacements[1]);
    plii_quad_scatter(displacements, places[0], &quads->displacements[0]);
}

/* Groups with links between the same nodes, whose places follow each other; damped ones all, or none. */
PLII_SIMD_INLINE void xpbd_links_quads_of(const plii_xpbd_links_task* task, const plii_link_group* groups, int count,
                                          int pairs, bool is_damped) {
    const plii_quad_places places = plii_quad_places_of(task->colors, groups);
    xpbd_links_quads quads[XPBD_LINKS_QUADS_BATCH];
    xpbd_links_starts starts[XPBD_LINKS_QUADS_BATCH];
    xpbd_links_rows rows[XPBD_LINKS_QUADS_BATCH];
    for (int i = 0; i < count; ++i) {
        const ptrdiff_t slot = plii_quad_first_slot(task->colors, &groups[i]);
        xpbd_links_quads own;
        rows[i] = (xpbd_links_rows){task->rest_lengths + slot, xpbd_links_multipliers_of(task, slot),
                                    *xpbd_links_softness(task, groups[i].tag)};
        xpbd_links_gather(&own, is_damped ? &starts[i] : NULL, task, places + 4 * i);
        xpbd_links_round(&own, is_damped ? &starts[i] : NULL, 0, pairs, &rows[i]);
        quads[i] = own;
    }
    for (int i = 0; i < count; ++i) {
        xpbd_links_quads own = quads[i];
        xpbd_links_round(&own, is_damped ? &starts[i] : NULL, 1, pairs, &rows[i]);
        memcpy(quads[i].displacements, own.displacements, sizeof own.displacements);
    }
    for (int i = 0; i < count; ++i) {
        xpbd_links_quads own = quads[i];
        xpbd_links_round(&own, is_damped ? &starts[i] : NULL, 2, pairs, &rows[i]);
        xpbd_links_scatter(&own, task, places + 4 * i);
    }
}

/* What most quads are gets code of its own. */
static void xpbd_links_groups(const plii_xpbd_links_task* task, int begin, int end) {
    const plii_link_group* group = &task->colors->groups[begin];
    for (int left = end - begin, count = 0; left > 0; left -= count, group += count) {
        if (group->pairs == PLII_LINK_SINGLE) {
            count = plii_quad_batch(group, left, XPBD_LINKS_BATCH);
            xpbd_links_singles(task, group, count);
            continue;
        }
        const int most = plii_quad_batch(group, left, XPBD_LINKS_QUADS_BATCH);
        const bool is_damped = xpbd_links_is_damped(xpbd_links_softness(task, group->tag));
        for (count = 1;
             count < most && xpbd_links_is_damped(xpbd_links_softness(task, group[count].tag)) == is_damped;) {
            ++count;
        }
        if (is_damped) {
            xpbd_links_quads_of(task, group, count, group->pairs, true);
        } else if (PLII_SIMD_RECORDS > 1 && group->pairs == PLII_LINK_TWO_TRIANGLES) {
            xpbd_links_quads_of(task, group, count, PLII_LINK_TWO_TRIANGLES, false);
        } else {
            xpbd_links_quads_of(task, group, count, group->pairs, false);
        }
    }
}

// ------------------------------------------------------------------------------------------------------------- sweeps

static void xpbd_links_runs(const plii_xpbd_links_task* task, int color, int begin, int end) {
    plii_runs_solve(&task->colors->runs, color, begin, end, xpbd_links_run_of_any_form, task);
}

/* One link after the other. */
static void xpbd_links_serial(const plii_xpbd_links_task* task) {
    const plii_link_colors* colors = task->colors;
    const pli_body* body = task->body;
    const ptrdiff_t first_slot = plii_link_colors_first_serial_slot(colors);
    const int last = PLII_LINK_LANES - 1;
    for (int i = 0; i < colors->serial_count; ++i) {
        const int link = colors->serial_links[i];
        uint32_t places[2][PLII_LINK_LANES];
        float rests[PLII_LINK_LANES], multipliers[PLII_LINK_LANES] = {0.0f};
        plii_quad_places_of_link(body, link, places);
        multipliers[last] = task->multipliers[first_slot + i];
        for (int lane = 0; lane < PLII_LINK_LANES; ++lane) {
            rests[lane] = lane == last ? task->rest_lengths[first_slot + i] : PLII_XPBD_NO_LINK;
        }
        const plii_xpbd_link_softness* softness = xpbd_links_softness(task, plii_link_tag_of(body, link));
        xpbd_links_group group;
        xpbd_links_measure_single(&group, task, places[0], places[1], xpbd_links_is_damped(softness));
        xpbd_links_multipliers own = xpbd_links_multipliers_of(task, 0);
        own.values = multipliers;
        xpbd_links_divide(&group, softness, rests, own);
        xpbd_links_move_single(&group, task->substep->displacements, places[0], places[1]);
        task->multipliers[first_slot + i] = multipliers[last];
    }
}
