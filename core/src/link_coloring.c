/* Colours of links. First come the classes of links with the same difference of node indices, if there are many of
   them: the rows, columns and diagonals of grids. Links a, a + d are chains a, a + d, a + 2 d, ..., so two colours
   suffice: the parity of the whole part of a / d. All other links are coloured greedily in the order of their nodes.
   Linear time but for a sweep over the nodes per class. */

#include "link_colors.h"

#include "simd.h"

#include <stdlib.h>
#include <string.h>

enum {
    LINK_COLORS_CLASSES = 32,
    LINK_COLORS_GREEDY = 64,
    LINK_COLORS_MAX = 2 * LINK_COLORS_CLASSES + LINK_COLORS_GREEDY,
    LINK_COLORS_LEAST_CLASS = 4 * PLII_LINK_GROUP, /* links */
    LINK_COLORS_NEAR = 16,                         /* classes of smaller differences are not searched in node order */
    LINK_COLORS_NONE = 0xffff,
    LINK_COLORS_IN_RUN = 0xfffe
};

/* Sides of the links of a class. */
enum { LINK_COLORS_OPEN, LINK_COLORS_EVEN, LINK_COLORS_ODD };

/* What making colours needs for a while. */
typedef struct link_colors_work {
    const pli_body* body;
    int node_count, link_count, tag_count; /* tags as key: material, then bending */
    int color_count, class_count;
    int classes[LINK_COLORS_CLASSES]; /* differences of node indices, ascending */
    plii_link_colors made;            /* with room for the largest numbers */
    uint64_t* masks;                  /* [node_count] greedy colours of the links around */
    int* places;                      /* [node_count] counts; or the link of a class by its smaller node, plus 1 */
    int* list;                        /* [link_count] */
    int* order;                       /* [link_count] */
    int* tag_begin;                   /* [tag_count + 1] */
    uint16_t* colors;                 /* [link_count] */
    uint8_t* sides;                   /* [node_count] of the links of a class */
    void* storage;
    size_t storage_size;
} link_colors_work;

/* Links that may become a run: equal strides and tags so far. */
typedef struct link_colors_row {
    int node, stride, link, link_stride, count;
    int last_node, last_link;
    plii_link_tag tag;
} link_colors_row;

// ---------------------------------------------------------------------------------------------------------- storage

/* Parts of one block of memory; with base NULL only the size is taken. */
typedef struct link_colors_carver {
    char* base;
    size_t used;
} link_colors_carver;

static void* link_colors_carve(link_colors_carver* carver, size_t size) {
    const size_t at = carver->used;
    carver->used += (size + 63) / 64 * 64;
    return carver->base != NULL ? carver->base + at : NULL;
}

static void link_colors_carve_result(link_colors_carver* carver, plii_link_colors* colors, int color_count,
                                     int run_count, int run_link_count, int block_count, int serial_count) {
    colors->colors = link_colors_carve(carver, ((size_t)color_count + 1) * sizeof *colors->colors);
    colors->runs = link_colors_carve(carver, (size_t)run_count * sizeof *colors->runs);
    colors->run_links = link_colors_carve(carver, (size_t)run_link_count * sizeof *colors->run_links);
    colors->block_places = link_colors_carve(carver, (size_t)block_count * sizeof *colors->block_places);
    colors->block_links = link_colors_carve(carver, (size_t)block_count * sizeof *colors->block_links);
    colors->block_tags = link_colors_carve(carver, (size_t)block_count * sizeof *colors->block_tags);
    colors->serial_links = link_colors_carve(carver, (size_t)serial_count * sizeof *colors->serial_links);
}

static int link_colors_max_block_count(const pli_body* body, int link_count) {
    const int64_t parts = (int64_t)LINK_COLORS_MAX * 2 * body->material_count;
    const int64_t blocks = link_count / PLII_LINK_GROUP + parts;
    return blocks < link_count ? (int)blocks : link_count;
}

/* Of each kind, never all at once. */
static void link_colors_carve_work(link_colors_carver* carver, link_colors_work* work) {
    const size_t nodes = (size_t)work->node_count, links = (size_t)work->link_count;
    link_colors_carve_result(carver, &work->made, LINK_COLORS_MAX, work->link_count / PLII_LINK_GROUP, work->link_count,
                             link_colors_max_block_count(work->body, work->link_count), work->link_count);
    work->masks = link_colors_carve(carver, nodes * sizeof *work->masks);
    work->places = link_colors_carve(carver, nodes * sizeof *work->places);
    work->list = link_colors_carve(carver, links * sizeof *work->list);
    work->order = link_colors_carve(carver, links * sizeof *work->order);
    work->tag_begin = link_colors_carve(carver, ((size_t)work->tag_count + 1) * sizeof *work->tag_begin);
    work->colors = link_colors_carve(carver, links * sizeof *work->colors);
    work->sides = link_colors_carve(carver, nodes * sizeof *work->sides);
}

static link_colors_work link_colors_work_of(const pli_body* body, int node_count, int link_count) {
    return (link_colors_work){
        .body = body, .node_count = node_count, .link_count = link_count, .tag_count = 2 * body->material_count};
}

static size_t link_colors_work_size(const pli_body* body, int node_count, int link_count) {
    link_colors_work work = link_colors_work_of(body, node_count, link_count);
    link_colors_carver carver = {0};
    link_colors_carve_work(&carver, &work);
    return carver.used;
}

// ----------------------------------------------------------------------------------------------------------- classes

static int link_colors_tag_key(const pli_body* body, int link) {
    const int tag = plii_link_colors_tag(body, link);
    return 2 * (tag & (PLII_LINK_TAG_BENDING - 1)) + ((tag & PLII_LINK_TAG_BENDING) != 0);
}
static int link_colors_low_node(const pli_body* body, int link) {
    const int* nodes = body->links[link].nodes;
    return nodes[0] < nodes[1] ? nodes[0] : nodes[1];
}
static int link_colors_difference(const pli_body* body, int link) {
    const int* nodes = body->links[link].nodes;
    return nodes[0] < nodes[1] ? nodes[1] - nodes[0] : nodes[0] - nodes[1];
}

/* Differences that enough links have, and those links in link order, class by class. Leaves all places zero. */
static void link_colors_find_classes(link_colors_work* work, int class_begin[LINK_COLORS_CLASSES + 1]) {
    const pli_body* body = work->body;
    const int least = work->link_count / LINK_COLORS_CLASSES > LINK_COLORS_LEAST_CLASS
                          ? work->link_count / LINK_COLORS_CLASSES
                          : LINK_COLORS_LEAST_CLASS;
    int* places = work->places;
    for (int i = 0; i < work->link_count; ++i) {
        places[link_colors_difference(body, i)] += 1;
    }
    int sum = 0;
    for (int d = 1; d < work->node_count; ++d) {
        const int count = places[d];
        places[d] = 0;
        if (count >= least && work->class_count < LINK_COLORS_CLASSES) {
            class_begin[work->class_count] = sum;
            work->classes[work->class_count++] = d;
            places[d] = work->class_count;
            sum += count;
        }
    }
    class_begin[work->class_count] = sum;
    places[0] = 0;
    int next[LINK_COLORS_CLASSES];
    memcpy(next, class_begin, sizeof next);
    for (int i = 0; i < work->link_count && work->class_count > 0; ++i) {
        const int k = places[link_colors_difference(body, i)];
        if (k > 0) { work->list[next[k - 1]++] = i; }
    }
    for (int k = 0; k < work->class_count; ++k) {
        places[work->classes[k]] = 0;
    }
}

static void link_colors_end_row(link_colors_work* work, const link_colors_row* row, int offset, bool with_link_stride,
                                int color) {
    plii_link_colors* made = &work->made;
    const int group_count = row->count / PLII_LINK_GROUP, taken = group_count * PLII_LINK_GROUP;
    int node = row->node;
    if (group_count > 0) {
        plii_link_run* run = &made->runs[made->run_count++];
        *run = (plii_link_run){.node = row->node,
                               .stride = row->stride,
                               .offset = offset,
                               .link = with_link_stride ? row->link : made->run_link_count,
                               .link_stride = with_link_stride ? row->link_stride : 0,
                               .first_group = made->run_group_count,
                               .group_count = group_count,
                               .tag = row->tag};
        made->run_group_count += group_count;
    }
    for (int i = 0; i < row->count; ++i, node += row->stride) {
        const int link = work->places[node] - 1;
        work->colors[link] = (uint16_t)(i < taken ? LINK_COLORS_IN_RUN : color);
        if (i < taken && !with_link_stride) { made->run_links[made->run_link_count++] = link; }
    }
}

/* Lengthens the row by the link at a node, or begins a new one with it. */
static void link_colors_add_to_row(link_colors_work* work, link_colors_row* row, int node, int offset,
                                   bool with_link_stride, int color) {
    const int link = work->places[node] - 1;
    const plii_link_tag tag = plii_link_colors_tag(work->body, link);
    const int stride = node - row->last_node, link_stride = link - row->last_link;
    if (row->count == 1 && tag == row->tag) {
        row->stride = stride;
        row->link_stride = link_stride;
    }
    if (row->count > 0 && tag == row->tag && stride == row->stride &&
        (!with_link_stride || link_stride == row->link_stride)) {
        row->count += 1;
    } else {
        link_colors_end_row(work, row, offset, with_link_stride, color);
        *row = (link_colors_row){.node = node, .link = link, .count = 1, .tag = tag};
    }
    row->last_node = node;
    row->last_link = link;
}

static uint8_t link_colors_other_side(uint8_t side) {
    return side == LINK_COLORS_EVEN ? LINK_COLORS_ODD : LINK_COLORS_EVEN;
}

static void link_colors_set_sides(link_colors_work* work, int first, int last, uint8_t side) {
    for (int node = first; node <= last; ++node) {
        if (work->places[node] > 0) { work->sides[node] = side; }
    }
}

/* Gives the links of a class one of two sides. A chain may begin with either side; it takes that of the nearest link,
   so that links that lie together in memory get the same one. */
static void link_colors_take_sides(link_colors_work* work, int d) {
    const int* places = work->places;
    uint8_t* sides = work->sides;
    int open_first = PLI_NULL_INDEX, open_last = PLI_NULL_INDEX; /* links that may still choose */
    int before = PLI_NULL_INDEX;                                 /* the last link before those */
    memset(sides, LINK_COLORS_OPEN, (size_t)work->node_count);
    for (int node = 0; node < work->node_count; ++node) {
        if (places[node] == 0) { continue; }
        const bool is_start = node < d || places[node - d] == 0;
        if (is_start) {
            open_first = open_first == PLI_NULL_INDEX ? node : open_first;
            open_last = node;
            continue;
        }
        if (open_first != PLI_NULL_INDEX) {
            const bool is_awaited = sides[node - d] == LINK_COLORS_OPEN;
            const bool is_near_before =
                before != PLI_NULL_INDEX && (is_awaited || open_first - before <= node - open_last);
            uint8_t side = LINK_COLORS_EVEN;
            if (is_near_before) {
                side = sides[before];
            } else if (!is_awaited) {
                side = link_colors_other_side(sides[node - d]);
            }
            link_colors_set_sides(work, open_first, open_last, side);
            open_first = PLI_NULL_INDEX;
        }
        sides[node] = link_colors_other_side(sides[node - d]);
        before = node;
    }
    if (open_first != PLI_NULL_INDEX) {
        link_colors_set_sides(work, open_first, open_last,
                              before != PLI_NULL_INDEX ? sides[before] : (uint8_t)LINK_COLORS_EVEN);
    }
}

static int link_colors_compare_runs(const void* a, const void* b) {
    const int node_a = ((const plii_link_run*)a)->node, node_b = ((const plii_link_run*)b)->node;
    return (node_a > node_b) - (node_a < node_b);
}

/* Of the last colour, by node: parts of it are parts of the body. */
static void link_colors_sort_runs(plii_link_colors* made, int color) {
    const int first = made->colors[color].first_run;
    int group = made->colors[color].first_group;
    qsort(&made->runs[first], (size_t)(made->run_count - first), sizeof *made->runs, link_colors_compare_runs);
    for (int r = first; r < made->run_count; ++r) {
        made->runs[r].first_group = group;
        group += made->runs[r].group_count;
    }
}

/* One of the two colours of a class, if it has links, in an order of nodes that makes strides constant: near nodes
   2 d apart, others one after the other. */
static void link_colors_make_runs(link_colors_work* work, int d, uint8_t side, bool with_link_stride) {
    const int color = work->color_count;
    const int stride = d < LINK_COLORS_NEAR ? 2 * d : 1;
    link_colors_row row = {0};
    work->made.colors[color].first_run = work->made.run_count;
    work->made.colors[color].first_group = work->made.run_group_count;
    for (int first = 0; first < stride; ++first) {
        for (int64_t node = first; node < work->node_count; node += stride) {
            if (work->places[node] > 0 && work->sides[node] == side) {
                link_colors_add_to_row(work, &row, (int)node, d, with_link_stride, color);
            }
        }
    }
    if (row.count == 0) { return; }
    link_colors_end_row(work, &row, d, with_link_stride, color);
    link_colors_sort_runs(&work->made, color);
    work->color_count += 1;
}

/* Both colours of a class, unless too few of its links form runs. */
static bool link_colors_try_class(link_colors_work* work, int class_index, int count, bool with_link_stride) {
    const plii_link_colors before = work->made;
    const int colors_before = work->color_count;
    link_colors_make_runs(work, work->classes[class_index], LINK_COLORS_EVEN, with_link_stride);
    link_colors_make_runs(work, work->classes[class_index], LINK_COLORS_ODD, with_link_stride);
    const int in_runs = PLII_LINK_GROUP * (work->made.run_group_count - before.run_group_count);
    if (in_runs >= count / 4 * 3) { return true; }
    work->made = before;
    work->color_count = colors_before;
    return false;
}

static void link_colors_take_classes(link_colors_work* work) {
    int class_begin[LINK_COLORS_CLASSES + 1] = {0};
    link_colors_find_classes(work, class_begin);
    for (int k = 0; k < work->class_count; ++k) {
        int count = 0;
        for (int i = class_begin[k]; i < class_begin[k + 1]; ++i) {
            /* A second link between the same two nodes is left to the greedy colours. */
            int* place = &work->places[link_colors_low_node(work->body, work->list[i])];
            if (*place == 0) {
                *place = work->list[i] + 1;
                count += 1;
            }
        }
        link_colors_take_sides(work, work->classes[k]);
        const bool is_taken =
            link_colors_try_class(work, k, count, true) || link_colors_try_class(work, k, count, false);
        for (int i = class_begin[k]; i < class_begin[k + 1]; ++i) {
            work->places[link_colors_low_node(work->body, work->list[i])] = 0;
            if (!is_taken) { work->colors[work->list[i]] = LINK_COLORS_NONE; }
        }
    }
}

// ------------------------------------------------------------------------------------------------------ other links

/* Links without a colour by their smaller node, in `list`. */
static int link_colors_sort_rest(link_colors_work* work) {
    int* begin = work->places;
    for (int i = 0; i < work->link_count; ++i) {
        if (work->colors[i] == LINK_COLORS_NONE) { ++begin[link_colors_low_node(work->body, i)]; }
    }
    int count = 0;
    for (int i = 0; i < work->node_count; ++i) {
        const int own = begin[i];
        begin[i] = count;
        count += own;
    }
    for (int i = 0; i < work->link_count && count > 0; ++i) {
        if (work->colors[i] == LINK_COLORS_NONE) { work->list[begin[link_colors_low_node(work->body, i)]++] = i; }
    }
    return count;
}

static void link_colors_take_greedily(link_colors_work* work) {
    const int count = link_colors_sort_rest(work);
    uint64_t all_used = 0;
    for (int i = 0; i < count; ++i) {
        const int link = work->list[i];
        uint64_t* a = &work->masks[work->body->links[link].nodes[0]];
        uint64_t* b = &work->masks[work->body->links[link].nodes[1]];
        const uint64_t is_free = ~(*a | *b);
        if (is_free == 0) {
            work->made.serial_links[work->made.serial_count++] = link;
            continue;
        }
        const uint64_t lowest = is_free & (~is_free + 1);
        *a |= lowest;
        *b |= lowest;
        all_used |= lowest;
        int color = work->color_count;
        for (uint64_t bit = lowest; bit > 1; bit >>= 1) {
            ++color;
        }
        work->colors[link] = (uint16_t)color;
    }
    for (; all_used != 0; all_used >>= 1) {
        plii_link_color* color = &work->made.colors[work->color_count++];
        color->first_run = work->made.run_count;
        color->first_group = work->made.run_group_count;
    }
}

/* Links in blocks by colour, then tag, then smaller node, in `list`; `begin` by colour. */
static void link_colors_sort_blocks(link_colors_work* work, int begin[LINK_COLORS_MAX + 1]) {
    int* node_begin = work->places;
    memset(node_begin, 0, (size_t)work->node_count * sizeof *node_begin);
    for (int i = 0; i < work->link_count; ++i) {
        if (work->colors[i] < LINK_COLORS_MAX) {
            ++node_begin[link_colors_low_node(work->body, i)];
            ++work->tag_begin[link_colors_tag_key(work->body, i) + 1];
            ++begin[work->colors[i] + 1];
        }
    }
    int count = 0;
    for (int i = 0; i < work->node_count; ++i) {
        const int own = node_begin[i];
        node_begin[i] = count;
        count += own;
    }
    for (int k = 0; k < work->tag_count; ++k) {
        work->tag_begin[k + 1] += work->tag_begin[k];
    }
    for (int k = 0; k < LINK_COLORS_MAX; ++k) {
        begin[k + 1] += begin[k];
    }
    for (int i = 0; i < work->link_count && count > 0; ++i) {
        if (work->colors[i] < LINK_COLORS_MAX) { work->list[node_begin[link_colors_low_node(work->body, i)]++] = i; }
    }
    for (int i = 0; i < count; ++i) {
        const int link = work->list[i];
        work->order[work->tag_begin[link_colors_tag_key(work->body, link)]++] = link;
    }
    int next[LINK_COLORS_MAX];
    memcpy(next, begin, sizeof next);
    for (int i = 0; i < count; ++i) {
        const int link = work->order[i];
        work->list[next[work->colors[link]]++] = link;
    }
}

static void link_colors_fill_block(link_colors_work* work, const int* links, int count) {
    plii_link_colors* made = &work->made;
    const int block = made->block_count++;
    made->block_tags[block] = plii_link_colors_tag(work->body, links[0]);
    const int empty = PLII_LINK_GROUP - count;
    for (int k = 0; k < PLII_LINK_GROUP; ++k) {
        const int link = links[k < empty ? k % count : k - empty];
        made->block_links[block][k] = k < empty ? PLI_NULL_INDEX : link;
        made->block_places[block][0][k] = plii_simd_place(work->body->links[link].nodes[0]);
        made->block_places[block][1][k] = plii_simd_place(work->body->links[link].nodes[1]);
    }
}

static void link_colors_make_blocks(link_colors_work* work) {
    int begin[LINK_COLORS_MAX + 1] = {0};
    link_colors_sort_blocks(work, begin);
    for (int color = 0; color < work->color_count; ++color) {
        work->made.colors[color].first_block = work->made.block_count;
        int first = begin[color];
        while (first < begin[color + 1]) {
            const plii_link_tag tag = plii_link_colors_tag(work->body, work->list[first]);
            int count = 1;
            while (count < PLII_LINK_GROUP && first + count < begin[color + 1] &&
                   plii_link_colors_tag(work->body, work->list[first + count]) == tag) {
                ++count;
            }
            link_colors_fill_block(work, &work->list[first], count);
            first += count;
        }
    }
    plii_link_color* end = &work->made.colors[work->color_count];
    end->first_run = work->made.run_count;
    end->first_group = work->made.run_group_count;
    end->first_block = work->made.block_count;
    work->made.color_count = work->color_count;
}

// ------------------------------------------------------------------------------------------------------ the service

/* `storage` is zeroed and of link_colors_work_size; it becomes part of the result where there is no memory for a block
   that just holds what was made. */
static void link_colors_make(const pli_body* body, void* storage, size_t storage_size, plii_link_colors* colors) {
    link_colors_work work = link_colors_work_of(body, body->node_count, body->link_count);
    link_colors_carver carver = {.base = storage};
    link_colors_carve_work(&carver, &work);
    memset(work.colors, 0xff, (size_t)body->link_count * sizeof *work.colors);
    link_colors_take_classes(&work);
    link_colors_take_greedily(&work);
    link_colors_make_blocks(&work);

    const plii_link_colors* made = &work.made;
    *colors = *made;
    carver = (link_colors_carver){0};
    link_colors_carve_result(&carver, colors, made->color_count, made->run_count, made->run_link_count,
                             made->block_count, made->serial_count);
    carver = (link_colors_carver){.base = plii_allocate(body->context, carver.used)};
    if (carver.base == NULL) {
        *colors = *made;
        colors->storage = storage;
        colors->storage_size = storage_size;
        return;
    }
    link_colors_carve_result(&carver, colors, made->color_count, made->run_count, made->run_link_count,
                             made->block_count, made->serial_count);
    colors->storage = carver.base;
    colors->storage_size = carver.used;
    memcpy(colors->colors, made->colors, ((size_t)made->color_count + 1) * sizeof *made->colors);
    memcpy(colors->runs, made->runs, (size_t)made->run_count * sizeof *made->runs);
    memcpy(colors->run_links, made->run_links, (size_t)made->run_link_count * sizeof *made->run_links);
    memcpy(colors->block_places, made->block_places, (size_t)made->block_count * sizeof *made->block_places);
    memcpy(colors->block_links, made->block_links, (size_t)made->block_count * sizeof *made->block_links);
    memcpy(colors->block_tags, made->block_tags, (size_t)made->block_count * sizeof *made->block_tags);
    memcpy(colors->serial_links, made->serial_links, (size_t)made->serial_count * sizeof *made->serial_links);
    plii_release(body->context, storage, storage_size);
}

static int link_colors_run_link(const plii_link_colors* colors, const plii_link_run* run, int place) {
    return run->link_stride == 0 ? colors->run_links[run->link + place] : run->link + place * run->link_stride;
}

void plii_link_colors_gather(const plii_link_colors* colors, const float* values, int stride, float filler,
                             float* slots) {
    for (int r = 0; r < colors->run_count; ++r) {
        const plii_link_run* run = &colors->runs[r];
        for (int g = 0; g < run->group_count; ++g) {
            for (int lane = 0; lane < PLII_LINK_GROUP; ++lane) {
                const int place = g * PLII_LINK_GROUP + plii_simd_record(lane);
                *slots++ = values[(ptrdiff_t)stride * link_colors_run_link(colors, run, place)];
            }
        }
    }
    for (int b = 0; b < colors->block_count; ++b) {
        for (int lane = 0; lane < PLII_LINK_GROUP; ++lane) {
            const int link = colors->block_links[b][plii_simd_record(lane)];
            *slots++ = link != PLI_NULL_INDEX ? values[(ptrdiff_t)stride * link] : filler;
        }
    }
    for (int i = 0; i < colors->serial_count; ++i) {
        *slots++ = values[(ptrdiff_t)stride * colors->serial_links[i]];
    }
}

bool plii_link_slots_make(const pli_body* body, const plii_link_colors* colors, plii_link_slots* slots) {
    slots->size = (size_t)plii_link_colors_slot_count(colors) * sizeof *slots->values;
    slots->values = plii_allocate(body->context, slots->size);
    return slots->values != NULL || slots->size == 0;
}

void plii_link_slots_release(const pli_body* body, plii_link_slots* slots) {
    plii_release(body->context, slots->values, slots->size);
    *slots = (plii_link_slots){0};
}

size_t plii_link_slots_max_size(const pli_body* body, int link_count) {
    const size_t in_blocks = (size_t)PLII_LINK_GROUP * (size_t)link_colors_max_block_count(body, link_count);
    return (in_blocks + (size_t)link_count) * sizeof(float);
}

void plii_link_slots_replace(const pli_body* body, const plii_link_colors* colors, int link_count, void* block,
                             plii_link_slots* slots) {
    plii_link_slots_release(body, slots);
    const size_t max_size = plii_link_slots_max_size(body, link_count);
    if (plii_link_slots_make(body, colors, slots)) {
        plii_release(body->context, block, max_size);
    } else {
        *slots = (plii_link_slots){block, max_size};
    }
}

static pli_status link_colors_enable(pli_body* body, void* state) {
    const size_t size = link_colors_work_size(body, body->node_count, body->link_count);
    void* storage = plii_allocate(body->context, size);
    if (storage == NULL) { return PLI_ERROR_OUT_OF_MEMORY; }
    plii_link_colors* colors = state;
    link_colors_make(body, storage, size, colors);
    if (colors->storage == storage) { /* it would stay far too large */
        plii_release(body->context, storage, size);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    return PLI_OK;
}

static void link_colors_disable(pli_body* body, void* state) {
    const plii_link_colors* colors = state;
    plii_release(body->context, colors->storage, colors->storage_size);
}

static size_t link_colors_bytes(const pli_body* body, const void* state) {
    (void)body;
    return ((const plii_link_colors*)state)->storage_size;
}

static int link_colors_topology_blocks(const pli_body* body, const void* state, const plii_topology_change* change,
                                       size_t* sizes) {
    (void)state;
    sizes[0] = link_colors_work_size(body, change->node_count, change->link_count);
    return 1;
}

static void link_colors_topology_commit(pli_body* body, void* state, const plii_topology_change* change,
                                        void** blocks) {
    plii_link_colors* colors = state;
    plii_release(body->context, colors->storage, colors->storage_size);
    link_colors_make(body, blocks[0], link_colors_work_size(body, change->node_count, change->link_count), colors);
}

const plii_feature_class plii_link_colors_class = {
    .name = "link colors",
    .state_size = sizeof(plii_link_colors),
    .enable = link_colors_enable,
    .disable = link_colors_disable,
    .bytes = link_colors_bytes,
    .topology_blocks = link_colors_topology_blocks,
    .topology_commit = link_colors_topology_commit,
};
