/* The arithmetic of btSoftBody::PSolve_Links on eight links at once. The including file chooses the instruction set and
   the name of the kernel.

   A processor keeps some 300 operations in flight, and a link is a long chain of them. So a few groups are measured,
   then moved: there is always enough to do that waits for nothing. Positions are kept from one to the other, since what
   limits a block is how many places of memory are read and written. */

#include "links_kernel.h"
#include "simd.h"

enum { LINKS_BATCH = 8 }; /* groups */

/* First nodes of links, and the others. */
typedef struct links_nodes {
    plii_packed8 a, b;
} links_nodes;

typedef struct links_group {
    links_nodes nodes;          /* kept where a register holds two of them, */
    plii_packed8 delta;         /* or else this, from the first ones to the others */
    plii_float8 move_a, move_b; /* along the difference, towards each other */
} links_group;

/* Links with nothing to move, or without length, and lanes without a link have a divisor of 0: nothing moves. */
PLII_SIMD_INLINE void links_measure(links_group* group, links_nodes nodes, plii_float8 rest,
                                    plii_float8 inverse_stiffness) {
    const plii_packed8 delta = plii_packed8_sub(nodes.b, nodes.a);
    const plii_records8 d = plii_packed8_turn(delta);
    const plii_float8 length = plii_float8_add(plii_float8_add(plii_float8_mul(d.x, d.x), plii_float8_mul(d.y, d.y)),
                                               plii_float8_mul(d.z, d.z));
    const plii_float8 mass_a = plii_packed8_turn(nodes.a).w, mass_b = plii_packed8_turn(nodes.b).w;
    const plii_float8 mass_term = plii_float8_mul(plii_float8_add(mass_a, mass_b), inverse_stiffness);
    const plii_float8 sum = plii_float8_add(rest, length);
    const plii_float8 divisor =
        plii_float8_where_greater(sum, plii_float8_all(PLII_EPSILON), plii_float8_mul(mass_term, sum));
    const plii_float8 k = plii_float8_where_greater(divisor, plii_float8_all(0.0f),
                                                    plii_float8_div(plii_float8_sub(rest, length), divisor));
    group->move_a = plii_float8_mul(k, mass_a);
    group->move_b = plii_float8_mul(k, mass_b);
    if (PLII_SIMD_RECORDS > 1) {
        group->nodes = nodes;
    } else {
        group->delta = delta;
    }
}

PLII_SIMD_INLINE plii_packed8 links_delta(const links_group* group) {
    return PLII_SIMD_RECORDS > 1 ? plii_packed8_sub(group->nodes.b, group->nodes.a) : group->delta;
}

/* First nodes and others by turns. */
PLII_SIMD_INLINE bool links_is_mixed(ptrdiff_t stride, ptrdiff_t offset) {
    return stride == 2 && offset == 1;
}
PLII_SIMD_INLINE links_nodes links_load(const pli_vec4* at, ptrdiff_t stride, ptrdiff_t offset) {
    links_nodes nodes;
    if (links_is_mixed(stride, offset)) {
        plii_packed8_load_mixed(at, &nodes.a, &nodes.b);
    } else {
        nodes = (links_nodes){plii_packed8_load(at, stride), plii_packed8_load(at + offset, stride)};
    }
    return nodes;
}
PLII_SIMD_INLINE void links_move(const links_group* g, pli_vec4* at, ptrdiff_t stride, ptrdiff_t offset) {
    const links_nodes nodes = PLII_SIMD_RECORDS > 1 ? g->nodes : links_load(at, stride, offset);
    const plii_packed8 delta = links_delta(g);
    const plii_packed8 a = plii_packed8_sub_scaled(nodes.a, delta, g->move_a);
    const plii_packed8 b = plii_packed8_add_scaled(nodes.b, delta, g->move_b);
    if (links_is_mixed(stride, offset)) {
        plii_packed8_store_mixed(at, a, b);
    } else {
        plii_packed8_store(at, stride, a);
        plii_packed8_store(at + offset, stride, b);
    }
}

PLII_SIMD_INLINE void links_run(const plii_links_task* task, const plii_link_run* run, int begin, int end,
                                ptrdiff_t stride, ptrdiff_t offset) {
    const plii_float8 inverse_stiffness =
        plii_float8_all(task->inverse_stiffnesses[run->tag & (PLII_LINK_TAG_BENDING - 1)]);
    const float* rest = task->rest_squared + (ptrdiff_t)PLII_LINK_GROUP * (run->first_group + begin);
    const ptrdiff_t step = PLII_LINK_GROUP * stride;
    pli_vec4* first = task->body->positions + run->node + step * begin;
    links_group groups[LINKS_BATCH];
    for (int left = end - begin; left > 0; left -= LINKS_BATCH) {
        const int count = left < LINKS_BATCH ? left : LINKS_BATCH;
        for (int i = 0; i < count; ++i) {
            links_measure(&groups[i], links_load(first + i * step, stride, offset),
                          plii_float8_load(rest + (ptrdiff_t)PLII_LINK_GROUP * i), inverse_stiffness);
        }
        for (int i = 0; i < count; ++i) {
            links_move(&groups[i], first + i * step, stride, offset);
        }
        first += count * step;
        rest += PLII_LINK_GROUP * count;
    }
}

/* The strides of grids get code of their own. */
static void links_run_any(const plii_links_task* task, const plii_link_run* run, int begin, int end) {
    if (run->stride == 1) {
        links_run(task, run, begin, end, 1, run->offset);
    } else if (run->stride == 2 && run->offset == 1) {
        links_run(task, run, begin, end, 2, 1);
    } else {
        links_run(task, run, begin, end, run->stride, run->offset);
    }
}

PLII_SIMD_INLINE links_nodes links_gather(const pli_vec4* positions, const uint32_t places[2][PLII_LINK_GROUP]) {
    return (links_nodes){plii_packed8_gather(positions, places[0]), plii_packed8_gather(positions, places[1])};
}
PLII_SIMD_INLINE void links_measure_block(links_group* group, const pli_vec4* positions,
                                          const uint32_t places[2][PLII_LINK_GROUP], const float* rest,
                                          float inverse_stiffness) {
    links_measure(group, links_gather(positions, places), plii_float8_load(rest), plii_float8_all(inverse_stiffness));
}
PLII_SIMD_INLINE void links_move_block(const links_group* g, pli_vec4* positions,
                                       const uint32_t places[2][PLII_LINK_GROUP]) {
    const bool is_kept = PLII_SIMD_RECORDS > 1;
    const plii_packed8 delta = links_delta(g);
    const plii_packed8 a = is_kept ? g->nodes.a : plii_packed8_gather(positions, places[0]);
    plii_packed8_scatter(positions, places[0], plii_packed8_sub_scaled(a, delta, g->move_a));
    const plii_packed8 b = is_kept ? g->nodes.b : plii_packed8_gather(positions, places[1]);
    plii_packed8_scatter(positions, places[1], plii_packed8_add_scaled(b, delta, g->move_b));
}

static void links_blocks(const plii_links_task* task, int begin, int end) {
    const plii_link_colors* colors = task->colors;
    pli_vec4* restrict positions = task->body->positions;
    const float* inverse_stiffnesses = task->inverse_stiffnesses;
    const float* rest = task->rest_squared + (ptrdiff_t)PLII_LINK_GROUP * (colors->run_group_count + begin);
    links_group groups[LINKS_BATCH];
    for (int first = begin; first < end; first += LINKS_BATCH) {
        const int count = end - first < LINKS_BATCH ? end - first : LINKS_BATCH;
        const uint32_t(*places)[2][PLII_LINK_GROUP] =
            (const uint32_t(*)[2][PLII_LINK_GROUP])colors->block_places + first;
        const plii_link_tag* tags = colors->block_tags + first;
        if (count == 1) { /* the next colour waits for this one: not by way of memory */
            links_group group;
            links_measure_block(&group, positions, places[0], rest,
                                inverse_stiffnesses[tags[0] & (PLII_LINK_TAG_BENDING - 1)]);
            links_move_block(&group, positions, places[0]);
            return;
        }
        for (int i = 0; i < count; ++i) {
            links_measure_block(&groups[i], positions, places[i], rest + (ptrdiff_t)PLII_LINK_GROUP * i,
                                inverse_stiffnesses[tags[i] & (PLII_LINK_TAG_BENDING - 1)]);
        }
        for (int i = 0; i < count; ++i) {
            links_move_block(&groups[i], positions, places[i]);
        }
        rest += PLII_LINK_GROUP * count;
    }
}

static void links_color(const plii_links_task* task, int begin, int end) {
    const plii_link_colors* colors = task->colors;
    const plii_link_color* color = &colors->colors[task->color];
    for (int r = color[0].first_run; r < color[1].first_run; ++r) {
        const plii_link_part part = plii_link_run_part(&colors->runs[r], color, begin, end);
        if (part.begin < part.end) { links_run_any(task, &colors->runs[r], part.begin, part.end); }
    }
    const plii_link_part part = plii_link_block_part(color, begin, end);
    links_blocks(task, part.begin, part.end);
}

/* One link after the other: all lanes have its nodes, only the last one, which is stored last, moves them. */
static void links_serial(const plii_links_task* task) {
    const plii_link_colors* colors = task->colors;
    pli_body* body = task->body;
    const float* rest = task->rest_squared + plii_link_colors_slot_count(colors) - colors->serial_count;
    for (int i = 0; i < colors->serial_count; ++i) {
        const int link = colors->serial_links[i];
        uint32_t places[2][PLII_LINK_GROUP];
        float rests[PLII_LINK_GROUP];
        for (int lane = 0; lane < PLII_LINK_GROUP; ++lane) {
            places[0][lane] = plii_simd_place(body->links[link].nodes[0]);
            places[1][lane] = plii_simd_place(body->links[link].nodes[1]);
            rests[lane] = lane == PLII_LINK_GROUP - 1 ? rest[i] : PLII_LINKS_NO_LINK;
        }
        links_group group;
        links_measure_block(&group, body->positions, (const uint32_t(*)[PLII_LINK_GROUP])places, rests,
                            task->inverse_stiffnesses[plii_link_colors_tag(body, link) & (PLII_LINK_TAG_BENDING - 1)]);
        links_move_block(&group, body->positions, (const uint32_t(*)[PLII_LINK_GROUP])places);
    }
}

static void links_sweep(const plii_links_task* task) {
    const plii_link_colors* colors = task->colors;
    for (const plii_link_color* color = colors->colors; color < colors->colors + colors->color_count; ++color) {
        for (int r = color[0].first_run; r < color[1].first_run; ++r) {
            links_run_any(task, &colors->runs[r], 0, colors->runs[r].group_count);
        }
        links_blocks(task, color[0].first_block, color[1].first_block);
    }
    if (colors->serial_count > 0) { links_serial(task); }
}
