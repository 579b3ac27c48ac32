/* The length constraint on eight links at once: that of btSoftBody::PSolve_Links, with the inverse of the mass term
   taken ahead, and that of XPBD; for the instruction set that the build selects.

   A link is a long chain of operations, so a few groups are solved round by round: there is always enough to do that
   waits for nothing. Which constraint it is and which pairs of nodes have links are constants where it counts. */

#include "solver/coloring/links_kernel.h"

/* Groups; of registers of four floats there are too few for the nodes of one. */
enum { LINKS_BATCH = PLII_FLOAT8_IS_ONE ? 6 : 1 };
/* Constraints. Links of XPBD are rigid where none has a compliance, and damped where one has a damping. */
enum { LINKS_POSITIONS, LINKS_RIGID, LINKS_SOFT, LINKS_DAMPED };

/* Nodes a and b of a link go apart by the factor of its constraint, their difference and their inverse masses. */

/* 0 where it is not finite: there a - a is no number. */
PLII_SIMD_INLINE plii_float8 links_where_finite(plii_float8 a) {
    return plii_float8_where_greater(plii_float8_sub(a, a), plii_float8_all(-1.0f), a);
}

/* plii_xpbd_multiplier over the length. `motion`: along the difference in this substep, where it is damped. What is not
   finite does not move: rigid links without length or mass, and lanes without a link, whose value is infinite. */
PLII_SIMD_LARGE plii_float8 links_factor_of_xpbd(plii_float8 length_squared, plii_float8 motion, plii_float8 mass,
                                                 plii_float8 rest_length, const plii_links_task* task, int kind,
                                                 ptrdiff_t slot) {
    const plii_float8 zero = plii_float8_all(0.0f);
    const plii_float8 length = plii_float8_sqrt(length_squared);
    plii_float8 force = plii_float8_sub(rest_length, length);
    const plii_float8 least = plii_float8_mul(plii_float8_all(task->softening), mass);
    if (kind == LINKS_RIGID) {
        return links_where_finite(plii_float8_div(force, plii_float8_mul(plii_float8_add(mass, least), length)));
    }
    const plii_float8 inverse = plii_float8_where_greater(length, zero, plii_float8_div(plii_float8_all(1.0f), length));
    const plii_float8 inverse_dt_squared = plii_float8_all(task->inverse_dt * task->inverse_dt);
    const plii_float8 alpha = plii_float8_mul(plii_float8_load(task->compliances + slot), inverse_dt_squared);
    float* multipliers = task->multipliers + slot;
    plii_float8 multiplier = zero;
    if (task->reads_multipliers) {
        multiplier = plii_float8_load(multipliers);
        force = plii_float8_sub(force, plii_float8_mul(alpha, multiplier));
    }
    if (kind == LINKS_DAMPED) {
        const plii_float8 gamma =
            plii_float8_mul(plii_float8_load(task->dampings + slot), plii_float8_all(task->inverse_dt));
        force = plii_float8_sub(force, plii_float8_mul(gamma, plii_float8_mul(motion, inverse)));
        mass = plii_float8_mul(plii_float8_add(plii_float8_all(1.0f), gamma), mass);
    }
    const plii_float8 divisor = plii_float8_add(mass, plii_float8_max(alpha, least));
    const plii_float8 change =
        links_where_finite(plii_float8_where_greater(mass, zero, plii_float8_div(force, divisor)));
    if (task->writes_multipliers) { plii_float8_store(multipliers, plii_float8_add(multiplier, change)); }
    return plii_float8_mul(change, inverse);
}

/* The nodes of eight quads. */
typedef struct links_quads {
    plii_vec3x8 moved[4], start_displacements[4];
    plii_float8 masses[4]; /* inverse */
} links_quads;

typedef const uint32_t (*links_indices)[PLII_LINK_LANES];

PLII_SIMD_LARGE void links_gather(links_quads* quads, int node, const plii_links_task* task,
                                  const uint32_t* scaled_indices, int kind) {
    const plii_nodes8 a = plii_nodes8_gather(task->moved, scaled_indices);
    quads->moved[node] = (plii_vec3x8){a.x, a.y, a.z};
    quads->masses[node] = a.w;
    if (kind != LINKS_DAMPED) { return; }
    const plii_nodes8 start_displacements = plii_nodes8_gather(task->start_displacements, scaled_indices);
    quads->start_displacements[node] =
        (plii_vec3x8){start_displacements.x, start_displacements.y, start_displacements.z};
}

/* From node a to node b of eight links. */
typedef struct links_measure {
    plii_vec3x8 delta;
    plii_float8 factor;
} links_measure;

PLII_SIMD_INLINE links_measure links_measured(const links_quads* quads, int a, int b, const plii_links_task* task,
                                              int kind, ptrdiff_t slot) {
    links_measure own;
    own.delta = plii_vec3x8_sub(quads->moved[b], quads->moved[a]);
    if (kind != LINKS_POSITIONS) { /* from where they are at the start of the step */
        const float* vectors = task->vectors + 3 * slot;
        const plii_vec3x8 apart = {plii_float8_load(vectors), plii_float8_load(vectors + PLII_LINK_LANES),
                                   plii_float8_load(vectors + 2 * PLII_LINK_LANES)};
        own.delta = plii_vec3x8_add(apart, own.delta);
    }
    const plii_float8 length_squared = plii_vec3x8_dot(own.delta, own.delta);
    const plii_float8 rest = plii_float8_load(task->rest + slot);
    if (kind == LINKS_POSITIONS) {
        const plii_float8 missing = plii_float8_sub(rest, length_squared), sum = plii_float8_add(rest, length_squared);
        own.factor = plii_float8_mul(plii_float8_div(missing, sum), plii_float8_load(task->weights + slot));
        return own;
    }
    const plii_float8 mass = plii_float8_add(quads->masses[a], quads->masses[b]);
    plii_float8 motion = length_squared;
    if (kind == LINKS_DAMPED) {
        motion = plii_vec3x8_dot(own.delta,
                                 plii_vec3x8_sub(plii_vec3x8_sub(quads->moved[b], quads->start_displacements[b]),
                                                 plii_vec3x8_sub(quads->moved[a], quads->start_displacements[a])));
    }
    own.factor = links_factor_of_xpbd(length_squared, motion, mass, rest, task, kind, slot);
    return own;
}
PLII_SIMD_INLINE void links_move(links_quads* quads, int a, int b, const links_measure* measure) {
    const plii_float8 move_a = plii_float8_mul(measure->factor, quads->masses[a]);
    const plii_float8 move_b = plii_float8_mul(measure->factor, quads->masses[b]);
    quads->moved[a] = plii_vec3x8_sub(quads->moved[a], plii_vec3x8_scale(measure->delta, move_a));
    quads->moved[b] = plii_vec3x8_add(quads->moved[b], plii_vec3x8_scale(measure->delta, move_b));
}

/* Links before pair `pair` of the nodes. */
PLII_SIMD_INLINE int links_before(int pairs, int pair) {
    int count = 0;
    for (int k = 0; k < pair; ++k) {
        count += pairs >> k & 1;
    }
    return count;
}

/* Two pairs of nodes, of which both, one or none have links. `slot`: of the first row of the group. */
PLII_SIMD_INLINE void links_round(links_quads* quads, int round, int pairs, const plii_links_task* task, int kind,
                                  ptrdiff_t slot) {
    const uint8_t *first = plii_link_pair_nodes[2 * round], *second = plii_link_pair_nodes[2 * round + 1];
    const int own = pairs >> 2 * round & 3;
    slot += PLII_LINK_LANES * links_before(pairs, 2 * round);
    if (own == 3) {
        const links_measure ab = links_measured(quads, first[0], first[1], task, kind, slot);
        const links_measure cd = links_measured(quads, second[0], second[1], task, kind, slot + PLII_LINK_LANES);
        links_move(quads, first[0], first[1], &ab);
        links_move(quads, second[0], second[1], &cd);
    } else if (own != 0) {
        const uint8_t* ends = own == 1 ? first : second;
        const links_measure only = links_measured(quads, ends[0], ends[1], task, kind, slot);
        links_move(quads, ends[0], ends[1], &only);
    }
}

/* Of single links only two nodes count. Nodes that no link has are like the first one, which is stored last. */
PLII_SIMD_INLINE void links_gather_all(links_quads* quads, const plii_links_task* task, links_indices scaled_indices,
                                       int pairs, int kind) {
    const int count = pairs == PLII_LINK_SINGLE ? 2 : 4;
    PLII_UNROLL(4)
    for (int k = 0; k < count; ++k) {
        links_gather(quads, k, task, scaled_indices[k], kind);
    }
}
PLII_SIMD_INLINE void links_scatter_all(const links_quads* quads, const plii_links_task* task,
                                        links_indices scaled_indices, int pairs) {
    const int count = pairs == PLII_LINK_SINGLE ? 2 : 4;
    PLII_UNROLL(4)
    for (int k = count - 1; k >= 0; --k) {
        const plii_nodes8 a = {quads->moved[k].x, quads->moved[k].y, quads->moved[k].z, quads->masses[k]};
        plii_nodes8_scatter(task->moved, scaled_indices[k], a);
    }
}

/* Groups with links between the same nodes; their rows and scaled indices follow each other. */
PLII_SIMD_INLINE void links_batch(const plii_links_task* task, const plii_link_group* groups, int count, int pairs,
                                  int kind) {
    const links_indices scaled_indices = (links_indices)&task->colors->scaled_indices[groups->first_scaled_index];
    const bool are_single = pairs == PLII_LINK_SINGLE;
    const int node_count = are_single ? 2 : 4;
    const ptrdiff_t slot = (ptrdiff_t)PLII_LINK_LANES * groups->first_row;
    const ptrdiff_t stride = PLII_LINK_LANES * links_before(pairs, PLII_LINK_PAIRS);
    links_quads quads[LINKS_BATCH];
    for (int i = 0; i < count; ++i) {
        links_gather_all(&quads[i], task, scaled_indices + node_count * i, pairs, kind);
        links_round(&quads[i], 0, pairs, task, kind, slot + i * stride);
    }
    for (int i = 0; i < count && !are_single; ++i) {
        links_round(&quads[i], 1, pairs, task, kind, slot + i * stride);
    }
    for (int i = 0; i < count; ++i) {
        if (!are_single) { links_round(&quads[i], 2, pairs, task, kind, slot + i * stride); }
        links_scatter_all(&quads[i], task, scaled_indices + node_count * i, pairs);
    }
}

PLII_SIMD_INLINE void links_one_by_one(const plii_links_task* task, const plii_link_group* group, int kind) {
    const links_indices scaled_indices = (links_indices)&task->colors->scaled_indices[group->first_scaled_index];
    ptrdiff_t slot = (ptrdiff_t)PLII_LINK_LANES * group->first_row;
    links_quads quads;
    links_gather_all(&quads, task, scaled_indices, group->pairs, kind);
    for (int k = 0; k < PLII_LINK_PAIRS; ++k) {
        if ((group->pairs >> k & 1) == 0) { continue; }
        const uint8_t* ends = plii_link_pair_nodes[k];
        const links_measure measure = links_measured(&quads, ends[0], ends[1], task, kind, slot);
        links_move(&quads, ends[0], ends[1], &measure);
        slot += PLII_LINK_LANES;
    }
    links_scatter_all(&quads, task, scaled_indices, group->pairs);
}

/* What most quads are gets code of its own; it would only be large where nodes do not fit into registers. */
PLII_SIMD_INLINE void links_batch_of_kind(const plii_links_task* task, const plii_link_group* groups, int count,
                                          int kind) {
    const int pairs = groups->pairs;
    if (!PLII_FLOAT8_IS_ONE) {
        links_one_by_one(task, groups, kind);
    } else if (pairs == PLII_LINK_SINGLE) {
        links_batch(task, groups, count, PLII_LINK_SINGLE, kind);
    } else if (pairs == PLII_LINK_TWO_TRIANGLES) {
        links_batch(task, groups, count, PLII_LINK_TWO_TRIANGLES, kind);
    } else if (pairs == PLII_LINK_ALL_PAIRS) {
        links_batch(task, groups, count, PLII_LINK_ALL_PAIRS, kind);
    } else if (pairs == PLII_LINK_PATH) {
        links_batch(task, groups, count, PLII_LINK_PATH, kind);
    } else {
        links_batch(task, groups, count, pairs, kind);
    }
}
/* The first groups, as far as they may be solved together; returns how many they are. */
static int links_first_batch(const plii_links_task* task, const plii_link_group* groups, int most) {
    int count = 1;
    while (count < most && count < LINKS_BATCH && groups[count].pairs == groups->pairs) {
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
PLII_SIMD_INLINE float* links_gather_row(float* vectors, const plii_nodes8 nodes[4], int pairs, int pair) {
    if ((pairs >> pair & 1) == 0) { return vectors; }
    const plii_nodes8 *a = &nodes[plii_link_pair_nodes[pair][0]], *b = &nodes[plii_link_pair_nodes[pair][1]];
    plii_float8_store(vectors, plii_float8_sub(b->x, a->x));
    plii_float8_store(vectors + PLII_LINK_LANES, plii_float8_sub(b->y, a->y));
    plii_float8_store(vectors + 2 * PLII_LINK_LANES, plii_float8_sub(b->z, a->z));
    return vectors + 3 * PLII_LINK_LANES;
}

static void links_gather_vectors(const plii_links_task* task, int begin, int end) {
    const plii_link_colors* colors = task->colors;
    const pli_vec4* positions = task->body->positions;
    for (const plii_link_group* group = &colors->groups[begin]; group < &colors->groups[end]; ++group) {
        const links_indices scaled_indices = (links_indices)&colors->scaled_indices[group->first_scaled_index];
        float* vectors = task->vectors + (ptrdiff_t)3 * PLII_LINK_LANES * group->first_row;
        plii_nodes8 nodes[4];
        nodes[0] = plii_nodes8_gather(positions, scaled_indices[0]);
        nodes[1] = plii_nodes8_gather(positions, scaled_indices[1]);
        vectors = links_gather_row(vectors, nodes, group->pairs, 0);
        if (group->pairs == PLII_LINK_SINGLE) { continue; }
        nodes[2] = plii_nodes8_gather(positions, scaled_indices[2]);
        nodes[3] = plii_nodes8_gather(positions, scaled_indices[3]);
        PLII_UNROLL(5)
        for (int k = 1; k < PLII_LINK_PAIRS; ++k) {
            vectors = links_gather_row(vectors, nodes, group->pairs, k);
        }
    }
}

const plii_links_kernel PLII_KERNEL_NAME(plii_links_kernel) = {links_groups, links_gather_vectors};
