/* The length constraint on eight or sixteen links at once: that of btSoftBody::PSolve_Links, with
   the inverse of the mass term taken ahead, and that of XPBD; for the instruction set that the build selects.

   A link is a long chain of operations, so a few vectors are solved round by round: there is always enough to do that
   waits for nothing. Which constraint it is and which pairs of nodes have links are constants where it counts. */

#include "math/simd_wide.h"
#include "solver/coloring/links_kernel.h"

/* Vectors. The nodes of two fit into the registers of AVX-512; of four floats there are too few for one. */
enum { LINKS_BATCH = PLII_WIDE_GROUPS == 2 ? 2 : PLII_FLOAT8_IS_ONE ? 6 : 1, LINKS_UNROLLED = PLII_WIDE_GROUPS };
/* Constraints. Links of XPBD are rigid where none has a compliance, and damped where one has a damping. */
enum { LINKS_POSITIONS, LINKS_RIGID, LINKS_SOFT, LINKS_DAMPED };

/* Nodes a and b of a link go apart by the factor of its constraint, their difference and their inverse masses. */

/* Where the groups of a vector are: slots of their first rows, and indices of their nodes. */
typedef struct links_place {
    ptrdiff_t first, second;
    const uint32_t *first_nodes, *second_nodes;
} links_place;

/* Row `row` of numbers of links. */
PLII_SIMD_INLINE plii_wide links_row(const float* numbers, links_place place, int row) {
    numbers += row * PLII_LINK_LANES;
    return plii_wide_load(numbers + place.first, numbers + place.second);
}
PLII_SIMD_LARGE plii_wide_nodes links_gather(const pli_vec4* records, links_place place, int node) {
    return plii_wide_gather(records, place.first_nodes + node * PLII_LINK_LANES,
                            place.second_nodes + node * PLII_LINK_LANES);
}

/* 0 where it is not finite: there a - a is no number. */
PLII_SIMD_INLINE plii_wide links_where_finite(plii_wide a) {
    return plii_wide_where_greater(plii_wide_sub(a, a), plii_wide_all(-1.0f), a);
}

/* plii_xpbd_multiplier over the length. `motion`: along the difference in this substep, where it is damped. What is not
   finite does not move: rigid links without length or mass, and lanes without a link, whose value is infinite. */
PLII_SIMD_LARGE plii_wide links_factor_of_xpbd(plii_wide length_squared, plii_wide motion, plii_wide mass,
                                               plii_wide rest_length, const plii_links_task* task, int kind,
                                               links_place place, int row) {
    const plii_wide zero = plii_wide_all(0.0f);
    const plii_wide length = plii_wide_sqrt(length_squared);
    plii_wide force = plii_wide_sub(rest_length, length);
    const plii_wide least = plii_wide_mul(plii_wide_all(task->softening), mass);
    if (kind == LINKS_RIGID) {
        return links_where_finite(plii_wide_div(force, plii_wide_mul(plii_wide_add(mass, least), length)));
    }
    const plii_wide inverse = plii_wide_where_greater(length, zero, plii_wide_div(plii_wide_all(1.0f), length));
    const plii_wide inverse_dt_squared = plii_wide_all(task->inverse_dt * task->inverse_dt);
    const plii_wide alpha = plii_wide_mul(links_row(task->compliances, place, row), inverse_dt_squared);
    plii_wide multiplier = zero;
    if (task->reads_multipliers) {
        multiplier = links_row(task->multipliers, place, row);
        force = plii_wide_sub(force, plii_wide_mul(alpha, multiplier));
    }
    if (kind == LINKS_DAMPED) {
        const plii_wide gamma = plii_wide_mul(links_row(task->dampings, place, row), plii_wide_all(task->inverse_dt));
        force = plii_wide_sub(force, plii_wide_mul(gamma, plii_wide_mul(motion, inverse)));
        mass = plii_wide_mul(plii_wide_add(plii_wide_all(1.0f), gamma), mass);
    }
    const plii_wide divisor = plii_wide_add(mass, plii_wide_max(alpha, least));
    const plii_wide change = links_where_finite(plii_wide_where_greater(mass, zero, plii_wide_div(force, divisor)));
    if (task->writes_multipliers) {
        float* multipliers = task->multipliers + row * PLII_LINK_LANES;
        plii_wide_store(multipliers + place.first, multipliers + place.second, plii_wide_add(multiplier, change));
    }
    return plii_wide_mul(change, inverse);
}

/* The nodes of a vector of quads. */
typedef struct links_quads {
    plii_wide_nodes moved[4]; /* w: inverse mass */
    plii_wide_vec3 start_displacements[4];
} links_quads;

/* Of single links only two nodes count. Nodes that no link has are like the first one, which is stored last. */
PLII_SIMD_INLINE void links_gather_all(links_quads* quads, const plii_links_task* task, links_place place, int pairs,
                                       int kind) {
    const int count = pairs == PLII_LINK_SINGLE ? 2 : 4;
    PLII_UNROLL(4)
    for (int k = 0; k < count; ++k) {
        quads->moved[k] = links_gather(task->moved, place, k);
        if (kind == LINKS_DAMPED) {
            quads->start_displacements[k] = links_gather(task->start_displacements, place, k).at;
        }
    }
}
PLII_SIMD_INLINE void links_scatter_all(const links_quads* quads, const plii_links_task* task, links_place place,
                                        int pairs) {
    const int count = pairs == PLII_LINK_SINGLE ? 2 : 4;
    PLII_UNROLL(4)
    for (int k = count - 1; k >= 0; --k) {
        plii_wide_scatter(task->moved, place.first_nodes + k * PLII_LINK_LANES,
                          place.second_nodes + k * PLII_LINK_LANES, quads->moved[k]);
    }
}

/* From node a to node b of the links of a row. */
typedef struct links_measure {
    plii_wide_vec3 delta;
    plii_wide factor;
} links_measure;

PLII_SIMD_INLINE links_measure links_measured(const links_quads* quads, int a, int b, const plii_links_task* task,
                                              int kind, links_place place, int row) {
    links_measure own;
    own.delta = plii_wide_vec3_sub(quads->moved[b].at, quads->moved[a].at);
    if (kind != LINKS_POSITIONS) { /* from where they are at the start of the step */
        const links_place starts = {3 * place.first, 3 * place.second, NULL, NULL};
        const plii_wide_vec3 vectors = {links_row(task->vectors, starts, 3 * row),
                                        links_row(task->vectors, starts, 3 * row + 1),
                                        links_row(task->vectors, starts, 3 * row + 2)};
        own.delta = plii_wide_vec3_add(vectors, own.delta);
    }
    const plii_wide length_squared = plii_wide_vec3_dot(own.delta, own.delta);
    const plii_wide rest = links_row(task->rest, place, row);
    if (kind == LINKS_POSITIONS) {
        const plii_wide missing = plii_wide_sub(rest, length_squared), sum = plii_wide_add(rest, length_squared);
        own.factor = plii_wide_mul(plii_wide_div(missing, sum), links_row(task->weights, place, row));
        return own;
    }
    const plii_wide mass = plii_wide_add(quads->moved[a].w, quads->moved[b].w);
    plii_wide motion = length_squared;
    if (kind == LINKS_DAMPED) {
        motion = plii_wide_vec3_dot(
            own.delta, plii_wide_vec3_sub(plii_wide_vec3_sub(quads->moved[b].at, quads->start_displacements[b]),
                                          plii_wide_vec3_sub(quads->moved[a].at, quads->start_displacements[a])));
    }
    own.factor = links_factor_of_xpbd(length_squared, motion, mass, rest, task, kind, place, row);
    return own;
}
PLII_SIMD_INLINE void links_move(links_quads* quads, int a, int b, const links_measure* measure) {
    plii_wide_nodes *node_a = &quads->moved[a], *node_b = &quads->moved[b];
    const plii_wide move_a = plii_wide_mul(measure->factor, node_a->w);
    const plii_wide move_b = plii_wide_mul(measure->factor, node_b->w);
    node_a->at = plii_wide_vec3_sub(node_a->at, plii_wide_vec3_scale(measure->delta, move_a));
    node_b->at = plii_wide_vec3_add(node_b->at, plii_wide_vec3_scale(measure->delta, move_b));
}

/* Links before pair `pair` of the nodes. */
PLII_SIMD_INLINE int links_before(int pairs, int pair) {
    int count = 0;
    for (int k = 0; k < pair; ++k) {
        count += pairs >> k & 1;
    }
    return count;
}

/* Two pairs of nodes, of which both, one or none have links. */
PLII_SIMD_INLINE void links_round(links_quads* quads, int round, int pairs, const plii_links_task* task, int kind,
                                  links_place place) {
    const uint8_t *first = plii_link_pair_nodes[2 * round], *second = plii_link_pair_nodes[2 * round + 1];
    const int own = pairs >> 2 * round & 3, row = links_before(pairs, 2 * round);
    if (own == 3) {
        const links_measure ab = links_measured(quads, first[0], first[1], task, kind, place, row);
        const links_measure cd = links_measured(quads, second[0], second[1], task, kind, place, row + 1);
        links_move(quads, first[0], first[1], &ab);
        links_move(quads, second[0], second[1], &cd);
    } else if (own != 0) {
        const uint8_t* ends = own == 1 ? first : second;
        const links_measure only = links_measured(quads, ends[0], ends[1], task, kind, place, row);
        links_move(quads, ends[0], ends[1], &only);
    }
}

PLII_SIMD_INLINE links_place links_start(const plii_links_task* task, const plii_link_group* group) {
    const ptrdiff_t slot = (ptrdiff_t)PLII_LINK_LANES * group->first_row;
    const uint32_t* nodes = task->colors->scaled_indices[group->first_scaled_index];
    return (links_place){slot, slot, nodes, nodes};
}
/* Of vector `i` of `count` groups with links between the same nodes, whose rows and indices follow each other from
   `start` on; of an odd number of groups both halves of the last one are alike. */
PLII_SIMD_INLINE links_place links_place_of(links_place start, int count, int pairs, ptrdiff_t i) {
    const ptrdiff_t slots = PLII_LINK_LANES * links_before(pairs, PLII_LINK_PAIRS);
    const ptrdiff_t nodes = PLII_LINK_LANES * (pairs == PLII_LINK_SINGLE ? 2 : 4);
    const ptrdiff_t first = PLII_WIDE_GROUPS * i, second = first + 1 < count ? first + 1 : first;
    return (links_place){start.first + first * slots, start.first + second * slots, start.first_nodes + first * nodes,
                         start.first_nodes + second * nodes};
}

PLII_SIMD_INLINE void links_vectors(const plii_links_task* task, const plii_link_group* groups, int count, int vectors,
                                    int pairs, int kind) {
    const links_place start = links_start(task, groups);
    links_quads quads[LINKS_BATCH];
    PLII_UNROLL(LINKS_UNROLLED)
    for (int i = 0; i < vectors; ++i) {
        const links_place place = links_place_of(start, count, pairs, i);
        links_gather_all(&quads[i], task, place, pairs, kind);
        links_round(&quads[i], 0, pairs, task, kind, place);
    }
    PLII_UNROLL(LINKS_UNROLLED)
    for (int i = 0; i < vectors; ++i) {
        links_round(&quads[i], 1, pairs, task, kind, links_place_of(start, count, pairs, i));
    }
    PLII_UNROLL(LINKS_UNROLLED)
    for (int i = 0; i < vectors; ++i) {
        const links_place place = links_place_of(start, count, pairs, i);
        links_round(&quads[i], 2, pairs, task, kind, place);
        links_scatter_all(&quads[i], task, place, pairs);
    }
}
PLII_SIMD_INLINE void links_batch(const plii_links_task* task, const plii_link_group* groups, int count, int pairs,
                                  int kind) {
    if (PLII_WIDE_GROUPS == 2 && count <= 2) {
        links_vectors(task, groups, count, 1, pairs, kind);
    } else {
        links_vectors(task, groups, count, PLII_WIDE_GROUPS == 2 ? 2 : count, pairs, kind);
    }
}

PLII_SIMD_INLINE void links_one_by_one(const plii_links_task* task, const plii_link_group* group, int kind) {
    const links_place place = links_start(task, group);
    links_quads quads;
    links_gather_all(&quads, task, place, group->pairs, kind);
    for (int k = 0, row = 0; k < PLII_LINK_PAIRS; ++k) {
        if ((group->pairs >> k & 1) == 0) { continue; }
        const uint8_t* ends = plii_link_pair_nodes[k];
        const links_measure measure = links_measured(&quads, ends[0], ends[1], task, kind, place, row++);
        links_move(&quads, ends[0], ends[1], &measure);
    }
    links_scatter_all(&quads, task, place, group->pairs);
}

/* What most quads are gets code of its own; it would only be large where nodes do not fit into registers. In vectors
   of two groups quads are paths or have all pairs (link_coloring.c). */
PLII_SIMD_INLINE void links_batch_of_kind(const plii_links_task* task, const plii_link_group* groups, int count,
                                          int kind) {
    const int pairs = groups->pairs;
    if (!PLII_FLOAT8_IS_ONE) {
        links_one_by_one(task, groups, kind);
    } else if (pairs == PLII_LINK_SINGLE) {
        links_batch(task, groups, count, PLII_LINK_SINGLE, kind);
    } else if (pairs == PLII_LINK_PATH) {
        links_batch(task, groups, count, PLII_LINK_PATH, kind);
    } else if (PLII_WIDE_GROUPS == 2 || pairs == PLII_LINK_ALL_PAIRS) {
        links_batch(task, groups, count, PLII_LINK_ALL_PAIRS, kind);
    } else if (pairs == PLII_LINK_TWO_TRIANGLES) {
        links_batch(task, groups, count, PLII_LINK_TWO_TRIANGLES, kind);
    } else {
        links_batch(task, groups, count, pairs, kind);
    }
}
/* The first groups, as far as they may be solved together; returns how many they are. */
static int links_first_batch(const plii_links_task* task, const plii_link_group* groups, int most) {
    int count = 1;
    while (count < most && count < LINKS_BATCH * PLII_WIDE_GROUPS && groups[count].pairs == groups->pairs) {
        ++count;
    }
    const int kind = task->compliances == NULL ? LINKS_RIGID : task->dampings == NULL ? LINKS_SOFT : LINKS_DAMPED;
    if (task->weights != NULL) {
        links_batch_of_kind(task, groups, count, LINKS_POSITIONS);
    } else if (!PLII_FLOAT8_IS_ONE) { /* one code for all: three would be large */
        links_batch_of_kind(task, groups, count, kind);
    } else if (kind == LINKS_RIGID) {
        links_batch_of_kind(task, groups, count, LINKS_RIGID);
    } else if (kind == LINKS_SOFT) {
        links_batch_of_kind(task, groups, count, LINKS_SOFT);
    } else {
        links_batch_of_kind(task, groups, count, LINKS_DAMPED);
    }
    return count;
}

static void links_groups(const plii_links_task* task, int begin, int end) {
    while (begin < end) {
        begin += links_first_batch(task, &task->colors->groups[begin], end - begin);
    }
}
/* Of pair `pair` of the nodes, where they have links; returns where those of the next pair go. */
PLII_SIMD_INLINE float* links_gather_row(float* vectors, const plii_wide_nodes nodes[4], int pairs, int pair) {
    if ((pairs >> pair & 1) == 0) { return vectors; }
    const uint8_t* ends = plii_link_pair_nodes[pair];
    const plii_wide_vec3 delta = plii_wide_vec3_sub(nodes[ends[1]].at, nodes[ends[0]].at);
    plii_wide_store(vectors, vectors, delta.x);
    plii_wide_store(vectors + PLII_LINK_LANES, vectors + PLII_LINK_LANES, delta.y);
    plii_wide_store(vectors + 2 * PLII_LINK_LANES, vectors + 2 * PLII_LINK_LANES, delta.z);
    return vectors + 3 * PLII_LINK_LANES;
}

/* One group at a time: in the width of two both halves are alike. */
static void links_gather_vectors(const plii_links_task* task, int begin, int end) {
    const pli_vec4* positions = task->body->positions;
    for (const plii_link_group* group = &task->colors->groups[begin]; group < &task->colors->groups[end]; ++group) {
        const links_place place = links_start(task, group);
        float* vectors = task->vectors + 3 * place.first;
        plii_wide_nodes nodes[4] = {links_gather(positions, place, 0), links_gather(positions, place, 1)};
        vectors = links_gather_row(vectors, nodes, group->pairs, 0);
        if (group->pairs == PLII_LINK_SINGLE) { continue; }
        nodes[2] = links_gather(positions, place, 2);
        nodes[3] = links_gather(positions, place, 3);
        PLII_UNROLL(5)
        for (int k = 1; k < PLII_LINK_PAIRS; ++k) {
            vectors = links_gather_row(vectors, nodes, group->pairs, k);
        }
    }
}

const plii_links_kernel PLII_KERNEL_NAME(plii_links_kernel) = {links_groups, links_gather_vectors};
