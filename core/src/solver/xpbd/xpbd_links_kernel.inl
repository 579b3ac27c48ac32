/* The length constraint of XPBD on eight links at once: in stages over a few groups, quads round by round, as in
   links_kernel.inl. The including file chooses the instruction set and the name of the kernel. */

#include "solver/coloring/link_quads_kernel.h"
#include "solver/xpbd/xpbd_links_kernel.h"

#include <string.h>

enum { XPBD_LINKS_BATCH = 8, XPBD_LINKS_QUADS_BATCH = 4 }; /* groups */

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
    plii_float8 x, y, z;
} xpbd_links_vector;

/* b - a */
PLII_SIMD_INLINE xpbd_links_vector xpbd_links_difference(xpbd_links_vector a, xpbd_links_vector b) {
    return (xpbd_links_vector){plii_float8_sub(b.x, a.x), plii_float8_sub(b.y, a.y), plii_float8_sub(b.z, a.z)};
}
PLII_SIMD_INLINE plii_float8 xpbd_links_dot(xpbd_links_vector a, xpbd_links_vector b) {
    return plii_float8_add(plii_float8_add(plii_float8_mul(a.x, b.x), plii_float8_mul(a.y, b.y)),
                           plii_float8_mul(a.z, b.z));
}

PLII_SIMD_INLINE plii_float8 xpbd_links_where_finite(plii_float8 a) {
    a = plii_float8_where_greater(plii_float8_all(INFINITY), a, a);
    return plii_float8_where_greater(a, plii_float8_all(-INFINITY), a);
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
PLII_SIMD_LARGE plii_float8 xpbd_links_factor(plii_float8 length_squared, plii_float8 motion, plii_float8 weight,
                                              const plii_xpbd_link_softness* softness, plii_float8 rest_length,
                                              xpbd_links_multipliers multipliers) {
    const plii_float8 zero = plii_float8_all(0.0f);
    const plii_float8 length = plii_float8_sqrt(length_squared);
    plii_float8 force = plii_float8_sub(rest_length, length);
    if (!xpbd_links_is_soft(softness)) {
        return xpbd_links_where_finite(plii_float8_div(force, plii_float8_mul(weight, length)));
    }
    const plii_float8 inverse = plii_float8_where_greater(length, zero, plii_float8_div(plii_float8_all(1.0f), length));
    const plii_float8 alpha = plii_float8_all(softness->alpha), gamma = plii_float8_all(softness->gamma);
    plii_float8 multiplier = plii_float8_all(0.0f);
    if (multipliers.are_read) {
        multiplier = plii_float8_load(multipliers.values);
        force = plii_float8_sub(force, plii_float8_mul(alpha, multiplier));
    }
    if (xpbd_links_is_damped(softness)) {
        force = plii_float8_sub(force, plii_float8_mul(gamma, plii_float8_mul(motion, inverse)));
    }
    const plii_float8 divisor =
        plii_float8_add(plii_float8_mul(plii_float8_all(1.0f + softness->gamma), weight), alpha);
    const plii_float8 change =
        xpbd_links_where_finite(plii_float8_where_greater(weight, zero, plii_float8_div(force, divisor)));
    if (multipliers.are_written) { plii_float8_store(multipliers.values, plii_float8_add(multiplier, change)); }
    return plii_float8_mul(change, inverse);
}

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
    const plii_float8 factor = xpbd_links_factor(group->length_squared, group->motion, weight, softness,
                                                 plii_float8_load(rest_lengths), multipliers);
    group->mass_a = plii_float8_mul(group->mass_a, factor);
    group->mass_b = plii_float8_mul(group->mass_b, factor);
}

// ---------------------------------------------------------------------------------------------------- in single links

PLII_SIMD_INLINE xpbd_links_nodes xpbd_links_gather_single(const plii_xpbd_links_task* task, const uint32_t* places) {
    return (xpbd_links_nodes){plii_packed8_gather(task->body->positions, places),
                              plii_packed8_gather(task->substep->displacements, places)};
}
PLII_SIMD_INLINE void xpbd_links_measure_single(xpbd_links_group* group, const plii_xpbd_links_task* task,
                                                const uint32_t* a, const uint32_t* b, bool is_damped) {
    xpbd_links_measure(group, xpbd_links_gather_single(task, a), xpbd_links_gather_single(task, b));
    if (is_damped) {
        const plii_substep* substep = task->substep;
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
    const ptrdiff_t slot = plii_quad_first_slot(groups);
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
                             plii_float8_load(rows->rest_lengths + slot), multipliers);
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
        const ptrdiff_t slot = plii_quad_first_slot(&groups[i]);
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
