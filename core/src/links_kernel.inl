/* The arithmetic of btSoftBody::PSolve_Links on eight links at once. The including file chooses the instruction set and
   the name of the kernel.

   A processor keeps some 150 operations in flight, and a link is a long chain of them. So a few groups go through one
   stage, then through the next: there is always enough to do that waits for nothing. */

#include "links_kernel.h"
#include "simd.h"

enum { LINKS_BATCH = 8, LINKS_FEW = 2 }; /* groups; so few need not wait for each other in any case */

typedef struct links_group {
    plii_packed8 delta;         /* from the first nodes to the others */
    plii_float8 mass_a, mass_b; /* inverse masses, later moves along delta */
    plii_float8 excess, divisor;
} links_group;

PLII_SIMD_INLINE void links_measure(links_group* group, plii_packed8 a, plii_packed8 b, plii_float8 rest,
                                    plii_float8 inverse_stiffness) {
    group->delta = plii_packed8_sub(b, a);
    const plii_records8 d = plii_packed8_turn(group->delta);
    const plii_float8 length = plii_float8_add(plii_float8_add(plii_float8_mul(d.x, d.x), plii_float8_mul(d.y, d.y)),
                                               plii_float8_mul(d.z, d.z));
    group->mass_a = plii_packed8_turn(a).w;
    group->mass_b = plii_packed8_turn(b).w;
    const plii_float8 mass_term = plii_float8_mul(plii_float8_add(group->mass_a, group->mass_b), inverse_stiffness);
    const plii_float8 sum = plii_float8_add(rest, length);
    group->excess = plii_float8_sub(rest, length);
    group->divisor = plii_float8_where_greater(sum, plii_float8_all(PLII_EPSILON), plii_float8_mul(mass_term, sum));
}

/* Links with nothing to move, or without length, and lanes without a link have a divisor of 0: nothing moves. */
PLII_SIMD_INLINE void links_divide(links_group* group) {
    const plii_float8 k = plii_float8_where_greater(group->divisor, plii_float8_all(0.0f),
                                                    plii_float8_div(group->excess, group->divisor));
    group->mass_a = plii_float8_mul(plii_float8_negate(k), group->mass_a);
    group->mass_b = plii_float8_mul(k, group->mass_b);
}

PLII_SIMD_INLINE void links_run(const plii_links_task* task, const plii_link_run* run, int begin, int end,
                                ptrdiff_t stride, ptrdiff_t offset) {
    const plii_float8 inverse_stiffness =
        plii_float8_all(task->inverse_stiffnesses[run->tag & (PLII_LINK_TAG_BENDING - 1)]);
    const float* rest = task->rest_squared + (ptrdiff_t)PLII_LINK_GROUP * (run->first_group + begin);
    const ptrdiff_t step = PLII_LINK_GROUP * stride;
    const bool is_mixed = stride == 2 && offset == 1;
    pli_vec4* first = task->body->positions + run->node + step * begin;
    links_group groups[LINKS_BATCH];
    for (int left = end - begin; left > 0; left -= LINKS_BATCH) {
        const int count = left < LINKS_BATCH ? left : LINKS_BATCH;
        for (int i = 0; i < count; ++i) {
            const pli_vec4* at = first + i * step;
            plii_packed8 a, b;
            if (is_mixed) {
                plii_packed8_load_mixed(at, &a, &b);
            } else {
                a = plii_packed8_load(at, stride);
                b = plii_packed8_load(at + offset, stride);
            }
            links_measure(&groups[i], a, b, plii_float8_load(rest + (ptrdiff_t)PLII_LINK_GROUP * i), inverse_stiffness);
        }
        for (int i = 0; i < count; ++i) {
            links_divide(&groups[i]);
        }
        for (int i = 0; i < count; ++i) {
            const links_group* g = &groups[i];
            pli_vec4* at = first + i * step;
            const plii_packed8 a = plii_packed8_scale(g->delta, g->mass_a), b = plii_packed8_scale(g->delta, g->mass_b);
            if (is_mixed) {
                plii_packed8_add_to_mixed(at, a, b);
            } else {
                plii_packed8_add_to(at, stride, a);
                plii_packed8_add_to(at + offset, stride, b);
            }
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

PLII_SIMD_INLINE void links_measure_block(links_group* group, const plii_links_task* task, const uint32_t* a,
                                          const uint32_t* b, plii_float8 rest, plii_link_tag tag) {
    const float inverse_stiffness = task->inverse_stiffnesses[tag & (PLII_LINK_TAG_BENDING - 1)];
    links_measure(group, plii_packed8_gather(task->body->positions, a), plii_packed8_gather(task->body->positions, b),
                  rest, plii_float8_all(inverse_stiffness));
}
PLII_SIMD_INLINE void links_move_block(const links_group* g, pli_vec4* positions, const uint32_t* a,
                                       const uint32_t* b) {
    plii_packed8_add_to_scattered(positions, a, plii_packed8_scale(g->delta, g->mass_a));
    plii_packed8_add_to_scattered(positions, b, plii_packed8_scale(g->delta, g->mass_b));
}

static void links_blocks(const plii_links_task* task, int begin, int end) {
    const plii_link_colors* colors = task->colors;
    const float* rest = task->rest_squared + (ptrdiff_t)PLII_LINK_GROUP * (colors->run_group_count + begin);
    links_group groups[LINKS_BATCH];
    for (int first = begin; first < end; first += LINKS_BATCH) {
        const int count = end - first < LINKS_BATCH ? end - first : LINKS_BATCH;
        const uint32_t(*places)[2][PLII_LINK_GROUP] =
            (const uint32_t(*)[2][PLII_LINK_GROUP])colors->block_places + first;
        if (count <= LINKS_FEW) {
            for (int i = 0; i < count; ++i) {
                links_group group;
                links_measure_block(&group, task, places[i][0], places[i][1],
                                    plii_float8_load(rest + (ptrdiff_t)PLII_LINK_GROUP * i),
                                    colors->block_tags[first + i]);
                links_divide(&group);
                links_move_block(&group, task->body->positions, places[i][0], places[i][1]);
            }
            return;
        }
        for (int i = 0; i < count; ++i) {
            links_measure_block(&groups[i], task, places[i][0], places[i][1],
                                plii_float8_load(rest + (ptrdiff_t)PLII_LINK_GROUP * i), colors->block_tags[first + i]);
        }
        for (int i = 0; i < count; ++i) {
            links_divide(&groups[i]);
        }
        for (int i = 0; i < count; ++i) {
            links_move_block(&groups[i], task->body->positions, places[i][0], places[i][1]);
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

/* One link after the other; only one lane moves anything. */
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
            rests[lane] = lane == 0 ? rest[i] : PLII_LINKS_NO_LINK;
        }
        links_group group;
        links_measure_block(&group, task, places[0], places[1], plii_float8_load(rests),
                            plii_link_colors_tag(body, link));
        links_divide(&group);
        links_move_block(&group, body->positions, places[0], places[1]);
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
