/* The arithmetic of btSoftBody::PSolve_Links on eight links at once. The including file chooses the instruction set and
   the name of the kernel.

   A processor keeps some 300 operations in flight, and a link is a long chain of them. So a few groups of links are
   measured, then moved, and a few groups of quads are solved round by round: there is always enough to do that waits
   for nothing. */

#include "solver/coloring/link_quads_kernel.h"
#include "solver/pbd/links_kernel.h"

enum { LINKS_BATCH = 8, LINKS_QUADS_BATCH = 6 }; /* groups */

PLII_SIMD_INLINE plii_float8 links_inverse_stiffness(const plii_links_task* task, plii_link_tag tag) {
    return plii_float8_all(task->inverse_stiffnesses[tag & (PLII_LINK_TAG_BENDING - 1)]);
}

/* Of links with nothing to move, or without length, and of lanes without a link nothing moves. */
PLII_SIMD_INLINE plii_float8 links_factor(plii_float8 length_squared, plii_float8 mass_a, plii_float8 mass_b,
                                          plii_float8 rest_squared, plii_float8 inverse_stiffness) {
    const plii_float8 mass_term = plii_float8_mul(plii_float8_add(mass_a, mass_b), inverse_stiffness);
    const plii_float8 sum = plii_float8_add(rest_squared, length_squared);
    const plii_float8 divisor = plii_float8_mul(mass_term, sum);
    /* The quotient, which takes longest, waits for no comparison. */
    const plii_float8 factor = plii_float8_div(plii_float8_sub(rest_squared, length_squared), divisor);
    const plii_float8 positive = plii_float8_where_greater(sum, plii_float8_all(PLII_EPSILON), divisor);
    return plii_float8_where_greater(positive, plii_float8_all(0.0f), factor);
}
PLII_SIMD_INLINE plii_float8 links_length_squared(plii_float8 x, plii_float8 y, plii_float8 z) {
    return plii_float8_add(plii_float8_add(plii_float8_mul(x, x), plii_float8_mul(y, y)), plii_float8_mul(z, z));
}

// -------------------------------------------------------------------------------------------------------- single links

/* First nodes of eight links, and the others. */
typedef struct links_nodes {
    plii_packed8 a, b;
} links_nodes;

/* Positions are kept from one to the other as they lie in memory, since what limits single links is how many places of
   memory are read and written. */
typedef struct links_group {
    links_nodes nodes;          /* kept where a register holds two of them, */
    plii_packed8 delta;         /* or else this, from the first ones to the others */
    plii_float8 move_a, move_b; /* along the difference, towards each other */
} links_group;

PLII_SIMD_INLINE void links_measure(links_group* group, links_nodes nodes, const float* rest_squared,
                                    plii_float8 inverse_stiffness) {
    const plii_packed8 delta = plii_packed8_sub(nodes.b, nodes.a);
    const plii_records8 d = plii_packed8_turn(delta);
    const plii_float8 mass_a = plii_packed8_turn(nodes.a).w, mass_b = plii_packed8_turn(nodes.b).w;
    const plii_float8 factor = links_factor(links_length_squared(d.x, d.y, d.z), mass_a, mass_b,
                                            plii_float8_load(rest_squared), inverse_stiffness);
    group->move_a = plii_float8_mul(factor, mass_a);
    group->move_b = plii_float8_mul(factor, mass_b);
    if (PLII_SIMD_RECORDS > 1) {
        group->nodes = nodes;
    } else {
        group->delta = delta;
    }
}

PLII_SIMD_INLINE plii_packed8 links_delta(const links_group* group) {
    return PLII_SIMD_RECORDS > 1 ? plii_packed8_sub(group->nodes.b, group->nodes.a) : group->delta;
}

PLII_SIMD_INLINE void links_measure_single(links_group* group, const pli_vec4* positions, plii_quad_places places,
                                           const float* rest, plii_float8 inverse_stiffness) {
    const links_nodes nodes = {plii_packed8_gather(positions, places[0]), plii_packed8_gather(positions, places[1])};
    links_measure(group, nodes, rest, inverse_stiffness);
}
PLII_SIMD_INLINE void links_move_single(const links_group* g, pli_vec4* positions, plii_quad_places places) {
    const bool is_kept = PLII_SIMD_RECORDS > 1;
    const plii_packed8 delta = links_delta(g);
    const plii_packed8 a = is_kept ? g->nodes.a : plii_packed8_gather(positions, places[0]);
    plii_packed8_scatter(positions, places[0], plii_packed8_sub_scaled(a, delta, g->move_a));
    const plii_packed8 b = is_kept ? g->nodes.b : plii_packed8_gather(positions, places[1]);
    plii_packed8_scatter(positions, places[1], plii_packed8_add_scaled(b, delta, g->move_b));
}

/* One group or two: the next colour waits for them, so they do not go through memory. */
PLII_SIMD_INLINE void links_one_group(const plii_links_task* task, const plii_link_group* group,
                                      plii_quad_places places, const float* rest) {
    links_group measured;
    links_measure_single(&measured, task->body->positions, places, rest, links_inverse_stiffness(task, group->tag));
    links_move_single(&measured, task->body->positions, places);
}
PLII_SIMD_INLINE void links_two_groups(const plii_links_task* task, const plii_link_group* groups,
                                       plii_quad_places places, const float* rest) {
    pli_vec4* positions = task->body->positions;
    links_group first, second;
    links_measure_single(&first, positions, places, rest, links_inverse_stiffness(task, groups[0].tag));
    links_measure_single(&second, positions, places + 2, rest + PLII_LINK_LANES,
                         links_inverse_stiffness(task, groups[1].tag));
    links_move_single(&first, positions, places);
    links_move_single(&second, positions, places + 2);
}

/* Groups of single links, whose slots and places follow each other. */
static void links_singles(const plii_links_task* task, const plii_link_group* groups, int count) {
    pli_vec4* restrict positions = task->body->positions;
    const plii_quad_places places = plii_quad_places_of(task->colors, groups);
    const float* rest = task->rest_squared + plii_quad_first_slot(groups);
    if (count == 1) {
        links_one_group(task, groups, places, rest);
        return;
    }
    if (count == 2) {
        links_two_groups(task, groups, places, rest);
        return;
    }
    links_group measured[LINKS_BATCH];
    for (int i = 0; i < count; ++i) {
        links_measure_single(&measured[i], positions, places + 2 * i, rest + (ptrdiff_t)PLII_LINK_LANES * i,
                             links_inverse_stiffness(task, groups[i].tag));
    }
    for (int i = 0; i < count; ++i) {
        links_move_single(&measured[i], positions, places + 2 * i);
    }
}

// ------------------------------------------------------------------------------------------------------------- quads

typedef struct links_quads {
    plii_records8 nodes[4];
} links_quads;

/* From node a to node b of eight quads. */
typedef struct links_difference {
    plii_float8 x, y, z, length_squared;
} links_difference;

PLII_SIMD_INLINE links_difference links_measure_pair(const plii_records8* a, const plii_records8* b) {
    const plii_float8 x = plii_float8_sub(b->x, a->x), y = plii_float8_sub(b->y, a->y), z = plii_float8_sub(b->z, a->z);
    return (links_difference){x, y, z, links_length_squared(x, y, z)};
}

PLII_SIMD_INLINE void links_move_pair(plii_records8* a, plii_records8* b, const links_difference* delta,
                                      plii_float8 factor) {
    const plii_float8 move_a = plii_float8_mul(factor, a->w), move_b = plii_float8_mul(factor, b->w);
    a->x = plii_float8_sub(a->x, plii_float8_mul(delta->x, move_a));
    a->y = plii_float8_sub(a->y, plii_float8_mul(delta->y, move_a));
    a->z = plii_float8_sub(a->z, plii_float8_mul(delta->z, move_a));
    b->x = plii_float8_add(b->x, plii_float8_mul(delta->x, move_b));
    b->y = plii_float8_add(b->y, plii_float8_mul(delta->y, move_b));
    b->z = plii_float8_add(b->z, plii_float8_mul(delta->z, move_b));
}

PLII_SIMD_LARGE void links_solve_one(plii_records8* a, plii_records8* b, const float* rest,
                                     plii_float8 inverse_stiffness) {
    const links_difference delta = links_measure_pair(a, b);
    links_move_pair(a, b, &delta,
                    links_factor(delta.length_squared, a->w, b->w, plii_float8_load(rest), inverse_stiffness));
}
/* Links between a and b and between c and d. */
PLII_SIMD_LARGE void links_solve_two(plii_records8* a, plii_records8* b, plii_records8* c, plii_records8* d,
                                     const float* rest, plii_float8 inverse_stiffness) {
    const links_difference ab = links_measure_pair(a, b), cd = links_measure_pair(c, d);
    const plii_float8 factor_ab =
        links_factor(ab.length_squared, a->w, b->w, plii_float8_load(rest), inverse_stiffness);
    const plii_float8 factor_cd =
        links_factor(cd.length_squared, c->w, d->w, plii_float8_load(rest + PLII_LINK_LANES), inverse_stiffness);
    links_move_pair(a, b, &ab, factor_ab);
    links_move_pair(c, d, &cd, factor_cd);
}

/* Two pairs of nodes, of which both, one or none have links; gives the rest lengths of what follows. */
PLII_SIMD_INLINE const float* links_round(links_quads* quads, int round, int pairs, const float* rest,
                                          plii_float8 inverse_stiffness) {
    const uint8_t *first = plii_link_pair_nodes[2 * round], *second = plii_link_pair_nodes[2 * round + 1];
    plii_records8 *a = &quads->nodes[first[0]], *b = &quads->nodes[first[1]];
    plii_records8 *c = &quads->nodes[second[0]], *d = &quads->nodes[second[1]];
    const int own = pairs >> 2 * round & 3;
    if (own == 3) {
        links_solve_two(a, b, c, d, rest, inverse_stiffness);
        return rest + 2 * PLII_LINK_LANES;
    }
    if (own == 0) { return rest; }
    if (own == 1) {
        links_solve_one(a, b, rest, inverse_stiffness);
    } else {
        links_solve_one(c, d, rest, inverse_stiffness);
    }
    return rest + PLII_LINK_LANES;
}

PLII_SIMD_LARGE void links_gather(links_quads* quads, const pli_vec4* positions, plii_quad_places places) {
    quads->nodes[0] = plii_quad_gather(positions, places[0]);
    quads->nodes[1] = plii_quad_gather(positions, places[1]);
    quads->nodes[2] = plii_quad_gather(positions, places[2]);
    quads->nodes[3] = plii_quad_gather(positions, places[3]);
}
PLII_SIMD_LARGE void links_scatter(const links_quads* quads, pli_vec4* positions, plii_quad_places places) {
    plii_quad_scatter(positions, places[3], &quads->nodes[3]);
    plii_quad_scatter(positions, places[2], &quads->nodes[2]);
    plii_quad_scatter(positions, places[1], &quads->nodes[1]);
    plii_quad_scatter(positions, places[0], &quads->nodes[0]);
}

/* One group: the next colour waits for it, so it does not go through memory. */
PLII_SIMD_INLINE void links_one_quads(const plii_links_task* task, const plii_link_group* group, int pairs) {
    const plii_float8 inverse_stiffness = links_inverse_stiffness(task, group->tag);
    const plii_quad_places places = plii_quad_places_of(task->colors, group);
    const float* rest = task->rest_squared + plii_quad_first_slot(group);
    links_quads own;
    links_gather(&own, task->body->positions, places);
    rest = links_round(&own, 0, pairs, rest, inverse_stiffness);
    rest = links_round(&own, 1, pairs, rest, inverse_stiffness);
    links_round(&own, 2, pairs, rest, inverse_stiffness);
    links_scatter(&own, task->body->positions, places);
}

/* Groups with links between the same nodes, whose places follow each other. */
PLII_SIMD_INLINE void links_quads_of(const plii_links_task* task, const plii_link_group* groups, int count, int pairs) {
    if (count == 1) {
        links_one_quads(task, groups, pairs);
        return;
    }
    pli_vec4* positions = task->body->positions;
    const plii_quad_places places = plii_quad_places_of(task->colors, groups);
    links_quads quads[LINKS_QUADS_BATCH];
    const float* rest[LINKS_QUADS_BATCH];
    for (int i = 0; i < count; ++i) {
        links_quads own;
        rest[i] = task->rest_squared + plii_quad_first_slot(&groups[i]);
        links_gather(&own, positions, places + 4 * i);
        rest[i] = links_round(&own, 0, pairs, rest[i], links_inverse_stiffness(task, groups[i].tag));
        quads[i] = own;
    }
    for (int i = 0; i < count; ++i) {
        links_quads own = quads[i];
        rest[i] = links_round(&own, 1, pairs, rest[i], links_inverse_stiffness(task, groups[i].tag));
        quads[i] = own;
    }
    for (int i = 0; i < count; ++i) {
        links_quads own = quads[i];
        links_round(&own, 2, pairs, rest[i], links_inverse_stiffness(task, groups[i].tag));
        links_scatter(&own, positions, places + 4 * i);
    }
}

/* What most quads are gets code of its own. */
static void links_groups(const plii_links_task* task, int begin, int end) {
    const plii_link_group* group = &task->colors->groups[begin];
    for (int left = end - begin, count = 0; left > 0; left -= count, group += count) {
        const bool is_single = group->pairs == PLII_LINK_SINGLE;
        count = plii_quad_batch(group, left, is_single ? LINKS_BATCH : LINKS_QUADS_BATCH);
        if (is_single) {
            links_singles(task, group, count);
        } else if (PLII_SIMD_RECORDS > 1 && group->pairs == PLII_LINK_TWO_TRIANGLES) {
            links_quads_of(task, group, count, PLII_LINK_TWO_TRIANGLES);
        } else if (PLII_SIMD_RECORDS > 1 && group->pairs == PLII_LINK_ALL_PAIRS) {
            links_quads_of(task, group, count, PLII_LINK_ALL_PAIRS);
        } else {
            links_quads_of(task, group, count, group->pairs);
        }
    }
}

// ------------------------------------------------------------------------------------------------------------- sweeps

/* One link after the other. */
static void links_serial(const plii_links_task* task) {
    const plii_link_colors* colors = task->colors;
    pli_body* body = task->body;
    const float* rest = task->rest_squared + plii_link_colors_first_serial_slot(colors);
    for (int i = 0; i < colors->serial_count; ++i) {
        const int link = colors->serial_links[i];
        uint32_t places[2][PLII_LINK_LANES];
        float rests[PLII_LINK_LANES];
        plii_quad_places_of_link(body, link, places);
        for (int lane = 0; lane < PLII_LINK_LANES; ++lane) {
            rests[lane] = lane == PLII_LINK_LANES - 1 ? rest[i] : PLII_LINKS_NO_LINK;
        }
        links_group group;
        links_measure_single(&group, body->positions, (plii_quad_places)places, rests,
                             links_inverse_stiffness(task, plii_link_tag_of(body, link)));
        links_move_single(&group, body->positions, (plii_quad_places)places);
    }
}

static void links_sweep(const plii_links_task* task) {
    const plii_link_colors* colors = task->colors;
    for (const plii_link_color* color = colors->colors; color < colors->colors + colors->color_count; ++color) {
        links_groups(task, color->first_group, color->first_group + color->group_count);
    }
    if (colors->serial_count > 0) { links_serial(task); }
}
