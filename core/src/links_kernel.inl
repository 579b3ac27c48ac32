/* The arithmetic of btSoftBody::PSolve_Links on eight links at once. The including file chooses the instruction set and
   the name of the kernel. */

#include "links_kernel.h"
#include "simd.h"

/* Links with nothing to move, or without length, stay as they are. */
PLII_SIMD_INLINE void links_solve(plii_records8* a, plii_records8* b, plii_float8 rest, plii_float8 inverse_stiffness) {
    const plii_float8 x = plii_float8_sub(b->x, a->x), y = plii_float8_sub(b->y, a->y), z = plii_float8_sub(b->z, a->z);
    const plii_float8 length =
        plii_float8_add(plii_float8_add(plii_float8_mul(x, x), plii_float8_mul(y, y)), plii_float8_mul(z, z));
    const plii_float8 mass_term = plii_float8_mul(plii_float8_add(a->w, b->w), inverse_stiffness);
    const plii_float8 sum = plii_float8_add(rest, length);
    plii_float8 k = plii_float8_div(plii_float8_sub(rest, length), plii_float8_mul(mass_term, sum));
    k = plii_float8_where_greater(mass_term, plii_float8_all(0.0f), k);
    k = plii_float8_where_greater(sum, plii_float8_all(PLII_EPSILON), k);
    const plii_float8 ka = plii_float8_mul(k, a->w), kb = plii_float8_mul(k, b->w);
    a->x = plii_float8_sub(a->x, plii_float8_mul(x, ka));
    a->y = plii_float8_sub(a->y, plii_float8_mul(y, ka));
    a->z = plii_float8_sub(a->z, plii_float8_mul(z, ka));
    b->x = plii_float8_add(b->x, plii_float8_mul(x, kb));
    b->y = plii_float8_add(b->y, plii_float8_mul(y, kb));
    b->z = plii_float8_add(b->z, plii_float8_mul(z, kb));
}

PLII_SIMD_INLINE void links_run(const plii_links_task* task, const plii_link_run* run, int begin, int end,
                                ptrdiff_t stride) {
    const plii_float8 inverse_stiffness =
        plii_float8_all(task->inverse_stiffnesses[run->tag & (PLII_LINK_TAG_BENDING - 1)]);
    const float* rest = task->rest_squared + (ptrdiff_t)PLII_LINK_GROUP * (run->first_group + begin);
    pli_vec4* low = task->body->positions + run->node + PLII_LINK_GROUP * stride * begin;
    for (int g = begin; g < end; ++g, low += PLII_LINK_GROUP * stride, rest += PLII_LINK_GROUP) {
        pli_vec4* high = low + run->offset;
        plii_records8 a = plii_records8_load(low, stride), b = plii_records8_load(high, stride);
        links_solve(&a, &b, plii_float8_load(rest), inverse_stiffness);
        plii_records8_store(low, stride, a);
        plii_records8_store(high, stride, b);
    }
}

/* The strides of grids get code of their own. */
static void links_run_any(const plii_links_task* task, const plii_link_run* run, int begin, int end) {
    switch (run->stride) {
    case 1:
        links_run(task, run, begin, end, 1);
        return;
    case 2:
        links_run(task, run, begin, end, 2);
        return;
    default:
        links_run(task, run, begin, end, run->stride);
    }
}

static void links_blocks(const plii_links_task* task, int begin, int end) {
    const plii_link_colors* colors = task->colors;
    const float* rest = task->rest_squared + (ptrdiff_t)PLII_LINK_GROUP * (colors->run_group_count + begin);
    for (int i = begin; i < end; ++i, rest += PLII_LINK_GROUP) {
        const int* nodes_a = colors->block_nodes[i][0];
        const int* nodes_b = colors->block_nodes[i][1];
        const int material = colors->block_tags[i] & (PLII_LINK_TAG_BENDING - 1);
        plii_records8 a = plii_records8_gather(task->body->positions, nodes_a);
        plii_records8 b = plii_records8_gather(task->body->positions, nodes_b);
        links_solve(&a, &b, plii_float8_load(rest), plii_float8_all(task->inverse_stiffnesses[material]));
        plii_records8_scatter(task->body->positions, nodes_a, a);
        plii_records8_scatter(task->body->positions, nodes_b, b);
    }
}

static void links_color(const plii_links_task* task, int begin, int end) {
    const plii_link_colors* colors = task->colors;
    const plii_link_color* color = &colors->colors[task->color];
    int first = 0; /* groups of the colour before the run */
    for (int r = color[0].first_run; r < color[1].first_run && first < end; ++r) {
        const plii_link_run* run = &colors->runs[r];
        const int from = begin > first ? begin - first : 0;
        const int to = end - first < run->group_count ? end - first : run->group_count;
        if (from < to) { links_run_any(task, run, from, to); }
        first += run->group_count;
    }
    const int from = begin > first ? begin - first : 0;
    if (end > first) { links_blocks(task, color[0].first_block + from, color[0].first_block + end - first); }
}

/* One link in all lanes, after the other. */
static void links_serial(const plii_links_task* task) {
    const plii_link_colors* colors = task->colors;
    const float* rest = task->rest_squared + plii_link_colors_slot_count(colors) - colors->serial_count;
    for (int i = 0; i < colors->serial_count; ++i) {
        const int link = colors->serial_links[i];
        int nodes[2][PLII_LINK_GROUP];
        for (int lane = 0; lane < PLII_LINK_GROUP; ++lane) {
            nodes[0][lane] = task->body->links[link].nodes[0];
            nodes[1][lane] = task->body->links[link].nodes[1];
        }
        const int material = plii_link_colors_tag(task->body, link) & (PLII_LINK_TAG_BENDING - 1);
        plii_records8 a = plii_records8_gather(task->body->positions, nodes[0]);
        plii_records8 b = plii_records8_gather(task->body->positions, nodes[1]);
        links_solve(&a, &b, plii_float8_all(rest[i]), plii_float8_all(task->inverse_stiffnesses[material]));
        plii_records8_scatter(task->body->positions, nodes[0], a);
        plii_records8_scatter(task->body->positions, nodes[1], b);
    }
}
