/* Colours of links: quads in the order in which they were found, then links that are in none, each with the lowest
   colour that is free at its nodes, one whose last group has lanes left before others. Linear time. */

#include "solver/coloring/link_coloring.h"
#include "body/pipeline.h"

enum {
    LINK_COLORS_MAX = 64,
    LINK_COLORS_QUADS_NODES = 80 /* a smaller body has too few quads for their colours */
};

/* Quads and single links in one order: index of a quad, or quad count + index of a single link. */
typedef struct link_colors_work {
    const pli_body* body;
    plii_scratch scratch;
    plii_link_quads quads;
    uint64_t* masks;                /* [node_count] colours of the links around */
    uint64_t open;                  /* colours whose last group has lanes left */
    uint8_t lanes[LINK_COLORS_MAX]; /* how many it has taken */
    int* counts;                    /* as many as there are keys of a kind at most, and one */
    int *order, *sorted;            /* [link_count] */
    int count;                      /* of them */
    int* colors;                    /* [link_count] of those */
    int color_limit;                /* the colours are below it */
} link_colors_work;

/* A quad or a single link: what a lane of a group gets. */
typedef struct link_colors_item {
    int nodes[4], links[PLII_LINK_PAIRS]; /* or PLI_NULL_INDEX */
    uint8_t pairs;
} link_colors_item;

/* False when out of memory. */
static bool link_colors_take_memory(link_colors_work* work) {
    const int nodes = work->body->node_count, links = work->body->link_count;
    plii_link_quads* quads = &work->quads;
    plii_scratch* scratch = &work->scratch;
    quads->quads = PLII_TAKE(scratch, plii_link_quad, links / 3);
    quads->links = PLII_TAKE(scratch, int, links);
    quads->halves = PLII_TAKE(scratch, plii_half_link, 2 * (size_t)links);
    quads->begin = PLII_TAKE(scratch, int, (size_t)nodes + 1);
    quads->open = PLII_TAKE(scratch, int, nodes);
    quads->marks = PLII_TAKE(scratch, uint8_t, nodes);
    quads->is_used = PLII_TAKE(scratch, uint8_t, links);
    work->masks = PLII_TAKE(scratch, uint64_t, nodes);
    work->counts = PLII_TAKE(scratch, int, LINK_COLORS_MAX + (size_t)nodes + (size_t)links + 1);
    work->order = PLII_TAKE(scratch, int, links);
    work->sorted = PLII_TAKE(scratch, int, links);
    work->colors = PLII_TAKE(scratch, int, links);
    return !scratch->is_short;
}

static uint8_t link_colors_pairs_at(const link_colors_work* work, int index) {
    return index < work->quads.quad_count ? work->quads.quads[index].pairs : PLII_LINK_SINGLE;
}

static link_colors_item link_colors_item_at(const link_colors_work* work, int index) {
    const plii_link_quads* quads = &work->quads;
    const bool is_quad = index < quads->quad_count;
    const int* link =
        &quads->links[is_quad ? quads->quads[index].first_link : quads->in_quads + index - quads->quad_count];
    const int* nodes = is_quad ? quads->quads[index].nodes : work->body->links[*link].nodes;
    link_colors_item item = {.pairs = link_colors_pairs_at(work, index)};
    for (int k = 0; k < 4; ++k) {
        item.nodes[k] = nodes[is_quad || k == 1 ? k : 0];
    }
    for (int k = 0; k < PLII_LINK_PAIRS; ++k) {
        item.links[k] = (item.pairs >> k & 1) != 0 ? *link++ : PLI_NULL_INDEX;
    }
    return item;
}

/* The colour of an item at nodes whose colours are `used`; one of its own when none is free. */
static int link_colors_take_color(link_colors_work* work, uint64_t used) {
    const uint64_t open = ~used & work->open, free = open != 0 ? open : ~used;
    if (free == 0) { return work->color_limit++; }
    const int color = __builtin_ctzll(free);
    const uint64_t bit = UINT64_C(1) << color;
    uint8_t* lanes = &work->lanes[color];
    *lanes = (uint8_t)((*lanes + 1) % PLII_LINK_LANES);
    work->open = *lanes != 0 ? work->open | bit : work->open & ~bit;
    return color;
}

static void link_colors_assign(link_colors_work* work) {
    work->count = work->quads.quad_count + work->quads.single_count;
    work->color_limit = LINK_COLORS_MAX;
    for (int i = 0; i < work->count; ++i) {
        const link_colors_item item = link_colors_item_at(work, i);
        uint64_t used = 0;
        for (int k = 0; k < 4; ++k) {
            used |= work->masks[item.nodes[k]];
        }
        const int color = link_colors_take_color(work, used);
        for (int k = 0; k < 4 && color < LINK_COLORS_MAX; ++k) {
            work->masks[item.nodes[k]] |= UINT64_C(1) << color;
        }
        work->colors[i] = color;
        work->order[i] = i;
    }
}

typedef int link_colors_key_fn(const link_colors_work* work, int index);

static int link_colors_by_node(const link_colors_work* work, int index) {
    const link_colors_item item = link_colors_item_at(work, index);
    int low = item.nodes[0];
    for (int k = 1; k < 4; ++k) {
        low = item.nodes[k] < low ? item.nodes[k] : low;
    }
    return low;
}
static int link_colors_by_pairs(const link_colors_work* work, int index) {
    return (1 << PLII_LINK_PAIRS) - 1 - link_colors_pairs_at(work, index);
}
static int link_colors_by_color(const link_colors_work* work, int index) {
    return work->colors[index];
}

/* Stable. */
static void link_colors_sort(link_colors_work* work, link_colors_key_fn* key, int key_count) {
    int* begin = work->counts;
    memset(begin, 0, ((size_t)key_count + 1) * sizeof *begin);
    for (int i = 0; i < work->count; ++i) {
        ++begin[key(work, work->order[i])];
    }
    plii_csr_sum(key_count, begin);
    for (int i = work->count - 1; i >= 0; --i) {
        work->sorted[--begin[key(work, work->order[i])]] = work->order[i];
    }
    PLII_SWAP(int*, work->order, work->sorted);
}

/* Adds a group of items of one colour; with no memory in `made` only to its counts. Empty lanes come first. */
static void link_colors_make_group(const link_colors_work* work, int first, int end, plii_link_colors* made) {
    const int count = end - first, empty = PLII_LINK_LANES - count;
    uint8_t pairs = 0;
    for (int i = first; i < end; ++i) {
        pairs |= link_colors_pairs_at(work, work->order[i]);
    }
    /* Kernels have code of its own for two triangles: an empty row costs less there than a kind of few groups. */
    const bool lacks_one = (pairs & ~PLII_LINK_TWO_TRIANGLES) == 0 && __builtin_popcount(pairs) == 4;
    if (lacks_one && 2 * count >= PLII_LINK_LANES) { pairs = PLII_LINK_TWO_TRIANGLES; }
    made->linked_row_count += __builtin_popcount(pairs);
    /* In vectors of two groups rows cost little, and two groups in a row are rarely of one kind. */
    if (work->body->context->def.simd == PLI_SIMD_AVX512 && pairs != PLII_LINK_SINGLE) {
        pairs = (pairs & ~PLII_LINK_PATH) == 0 ? PLII_LINK_PATH : PLII_LINK_ALL_PAIRS;
    }
    const int node_count = pairs == PLII_LINK_SINGLE ? 2 : 4;
    if (made->groups != NULL) {
        made->groups[made->group_count] = (plii_link_group){
            .first_row = made->row_count, .first_scaled_index = made->scaled_index_count, .pairs = pairs};
        for (int lane = 0; lane < PLII_LINK_LANES; ++lane) {
            const bool is_empty = lane < empty;
            const link_colors_item item =
                link_colors_item_at(work, work->order[first + (is_empty ? lane % count : lane - empty)]);
            for (int k = 0; k < node_count; ++k) {
                made->scaled_indices[made->scaled_index_count + k][lane] = plii_scaled_index(item.nodes[k]);
            }
            int(*row)[PLII_LINK_LANES] = &made->row_links[made->row_count];
            for (int k = 0; k < PLII_LINK_PAIRS; ++k) {
                if ((pairs >> k & 1) != 0) { (*row++)[lane] = is_empty ? PLI_NULL_INDEX : item.links[k]; }
            }
        }
    }
    made->group_count += 1;
    made->scaled_index_count += node_count;
    made->row_count += __builtin_popcount(pairs);
}

/* Items of a group have one colour. */
static void link_colors_make_groups(const link_colors_work* work, plii_link_colors* made) {
    for (int first = 0; first < work->count;) {
        const int color = work->colors[work->order[first]], first_group = made->group_count;
        int end = first;
        while (end < work->count && work->colors[work->order[end]] == color) {
            if (++end - first < PLII_LINK_LANES) { continue; }
            link_colors_make_group(work, first, end, made);
            first = end;
        }
        if (first < end) { link_colors_make_group(work, first, end, made); }
        first = end;
        if (made->groups != NULL) {
            made->colors[made->color_count] = (plii_link_color){first_group, made->group_count - first_group, 0, 0};
        }
        made->color_count += 1;
    }
}

/* False when out of memory. */
static bool link_colors_cut(const link_colors_work* work, plii_link_colors* colors) {
    const int node_count = work->body->node_count;
    int item = 0;
    for (PLII_EACH(plii_link_color, color, colors->colors, colors->color_count)) {
        const int end = color->first_group + color->group_count, first = item;
        color->first_cut = colors->cut_count;
        for (int i = color->first_group; i < end;) {
            if (!PLII_GROW(work->body->context, &colors->cuts, &colors->cut_capacity, colors->cut_count)) {
                return false;
            }
            int *groups = colors->cuts[colors->cut_count++].groups, part = 0;
            color->cut_count += 1;
            for (int64_t node, before = 0; i < end; ++i, before = node) {
                node = link_colors_by_node(work, work->order[first + PLII_LINK_LANES * (i - color->first_group)]);
                if (node < before) { break; } /* the next kind */
                while (part <= node * PLII_LINK_PARTS / node_count) {
                    groups[part++] = i;
                }
            }
            while (part <= PLII_LINK_PARTS) {
                groups[part++] = i;
            }
        }
        while (item < work->count && work->colors[work->order[item]] == work->colors[work->order[first]]) {
            ++item;
        }
    }
    return true;
}

static bool link_colors_fill(const link_colors_work* work, plii_link_colors* colors) {
    pli_context* context = work->body->context;
    plii_link_colors needed = {0};
    link_colors_make_groups(work, &needed);
    if (!PLII_RESERVE(context, &colors->colors, &colors->color_capacity, needed.color_count) ||
        !PLII_RESERVE(context, &colors->groups, &colors->group_capacity, needed.group_count) ||
        !PLII_RESERVE(context, &colors->scaled_indices, &colors->scaled_index_capacity, needed.scaled_index_count) ||
        !PLII_RESERVE(context, &colors->row_links, &colors->row_capacity, needed.row_count)) {
        return false;
    }
    colors->color_count = colors->group_count = colors->row_count = colors->scaled_index_count = colors->cut_count = 0;
    colors->linked_row_count = 0;
    link_colors_make_groups(work, colors);
    const bool is_shared = context->def.parallel_for != NULL && work->body->link_count >= PLII_LINKS_SHARED;
    return !is_shared || link_colors_cut(work, colors);
}

/* They are not current when out of memory. */
static void link_colors_make(pli_body* body, plii_link_colors* colors) {
    link_colors_work work = {.body = body, .scratch.context = body->context};
    colors->is_current = link_colors_take_memory(&work);
    if (colors->is_current) {
        plii_link_quads_find(body, body->node_count >= LINK_COLORS_QUADS_NODES, &work.quads);
        link_colors_assign(&work);
        link_colors_sort(&work, link_colors_by_node, body->node_count);
        link_colors_sort(&work, link_colors_by_pairs, 1 << PLII_LINK_PAIRS);
        link_colors_sort(&work, link_colors_by_color, work.color_limit);
        colors->is_current = link_colors_fill(&work, colors);
    }
    plii_scratch_free(&work.scratch);
}

const plii_link_colors* plii_link_colors_of(pli_body* body) {
    plii_link_colors* colors = plii_feature_state(body, &plii_link_colors_class);
    if (!colors->is_current) { link_colors_make(body, colors); }
    return colors->is_current ? colors : NULL;
}

static void link_colors_topology_commit(pli_body* body, void* state, const plii_topology_change* change) {
    ((plii_link_colors*)state)->is_current = false;
}

const plii_feature_class plii_link_colors_class = {
    .name = "link colors",
    .state_size = sizeof(plii_link_colors),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_SPAN(plii_link_colors, is_current, linked_row_count, PLII_LEFT, NULL)),
    .arrays = PLII_ARRAYS(PLII_LEFT_LIST(plii_link_colors, colors, color_capacity),
                          PLII_LEFT_LIST(plii_link_colors, groups, group_capacity),
                          PLII_LEFT_LIST(plii_link_colors, scaled_indices, scaled_index_capacity),
                          PLII_LEFT_LIST(plii_link_colors, row_links, row_capacity),
                          PLII_LEFT_LIST(plii_link_colors, cuts, cut_capacity)),
    .topology_commit = link_colors_topology_commit,
};
