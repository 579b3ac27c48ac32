/* Runs of links. First come the classes of links with the same difference of node indices, if there are many of them:
   the rows, columns and diagonals of grids. Links a, a + d are chains a, a + d, a + 2 d, ..., so two colours suffice:
   the parity of the whole part of a / d. Linear time but for a sweep over the nodes per class. */

#include "link_runs.h"

#include "link_quads.h"

#include <stdlib.h>
#include <string.h>

enum {
    LINK_RUNS_LEAST_CLASS = 4 * PLII_LINK_LANES, /* links */
    LINK_RUNS_NEAR = 16                          /* classes of smaller differences are not searched in node order */
};

/* Sides of the links of a class. */
enum { LINK_RUNS_OPEN, LINK_RUNS_EVEN, LINK_RUNS_ODD };

/* Links that may become a run: equal strides and tags so far. */
typedef struct link_runs_row {
    int node, stride, link, link_stride, count;
    int last_node, last_link;
    plii_link_tag tag;
} link_runs_row;

static int link_runs_low_node(const pli_body* body, int link) {
    const int* nodes = body->links[link].nodes;
    return nodes[0] < nodes[1] ? nodes[0] : nodes[1];
}
static int link_runs_difference(const pli_body* body, int link) {
    const int* nodes = body->links[link].nodes;
    return nodes[0] < nodes[1] ? nodes[1] - nodes[0] : nodes[0] - nodes[1];
}

/* Differences that enough links have, and those links in link order, class by class. Leaves all places zero. */
static void link_runs_find_classes(plii_link_runs_work* work, int class_begin[PLII_LINK_RUNS_MAX_CLASSES + 1]) {
    const pli_body* body = work->body;
    const int least = work->body->link_count / PLII_LINK_RUNS_MAX_CLASSES > LINK_RUNS_LEAST_CLASS
                          ? work->body->link_count / PLII_LINK_RUNS_MAX_CLASSES
                          : LINK_RUNS_LEAST_CLASS;
    int* places = work->places;
    for (int i = 0; i < work->body->link_count; ++i) {
        places[link_runs_difference(body, i)] += 1;
    }
    int sum = 0;
    for (int d = 1; d < work->body->node_count; ++d) {
        const int count = places[d];
        places[d] = 0;
        if (count >= least && work->class_count < PLII_LINK_RUNS_MAX_CLASSES) {
            class_begin[work->class_count] = sum;
            work->classes[work->class_count++] = d;
            places[d] = work->class_count;
            sum += count;
        }
    }
    class_begin[work->class_count] = sum;
    places[0] = 0;
    int next[PLII_LINK_RUNS_MAX_CLASSES];
    memcpy(next, class_begin, sizeof next);
    for (int i = 0; i < work->body->link_count && work->class_count > 0; ++i) {
        const int k = places[link_runs_difference(body, i)];
        if (k > 0) { work->list[next[k - 1]++] = i; }
    }
    for (int k = 0; k < work->class_count; ++k) {
        places[work->classes[k]] = 0;
    }
}

static void link_runs_end_row(plii_link_runs_work* work, const link_runs_row* row, int offset, bool with_link_stride) {
    plii_link_runs* made = &work->made;
    const int group_count = row->count / PLII_LINK_LANES, taken = group_count * PLII_LINK_LANES;
    int node = row->node;
    if (group_count > 0) {
        plii_link_run* run = &made->runs[made->run_count++];
        *run = (plii_link_run){.node = row->node,
                               .stride = row->stride,
                               .offset = offset,
                               .link = with_link_stride ? row->link : made->run_link_count,
                               .link_stride = with_link_stride ? row->link_stride : 0,
                               .first_group = made->group_count,
                               .group_count = group_count,
                               .tag = row->tag};
        made->group_count += group_count;
    }
    for (int i = 0; i < row->count; ++i, node += row->stride) {
        const int link = work->places[node] - 1;
        work->is_used[link] = i < taken;
        if (i < taken && !with_link_stride) { made->run_links[made->run_link_count++] = link; }
    }
}

/* Lengthens the row by the link at a node, or begins a new one with it. */
static void link_runs_add_to_row(plii_link_runs_work* work, link_runs_row* row, int node, int offset,
                                 bool with_link_stride) {
    const int link = work->places[node] - 1;
    const plii_link_tag tag = plii_link_tag_of(work->body, link);
    const int stride = node - row->last_node, link_stride = link - row->last_link;
    if (row->count == 1 && tag == row->tag) {
        row->stride = stride;
        row->link_stride = link_stride;
    }
    if (row->count > 0 && tag == row->tag && stride == row->stride &&
        (!with_link_stride || link_stride == row->link_stride)) {
        row->count += 1;
    } else {
        link_runs_end_row(work, row, offset, with_link_stride);
        *row = (link_runs_row){.node = node, .link = link, .count = 1, .tag = tag};
    }
    row->last_node = node;
    row->last_link = link;
}

static uint8_t link_runs_other_side(uint8_t side) {
    return side == LINK_RUNS_EVEN ? LINK_RUNS_ODD : LINK_RUNS_EVEN;
}

static void link_runs_set_sides(plii_link_runs_work* work, int first, int last, uint8_t side) {
    for (int node = first; node <= last; ++node) {
        if (work->places[node] > 0) { work->sides[node] = side; }
    }
}

/* Gives the links of a class one of two sides. A chain may begin with either side; it takes that of the nearest link,
   so that links that lie together in memory get the same one. */
static void link_runs_take_sides(plii_link_runs_work* work, int d) {
    const int* places = work->places;
    uint8_t* sides = work->sides;
    int open_first = PLI_NULL_INDEX, open_last = PLI_NULL_INDEX; /* links that may still choose */
    int before = PLI_NULL_INDEX;                                 /* the last link before those */
    memset(sides, LINK_RUNS_OPEN, (size_t)work->body->node_count);
    for (int node = 0; node < work->body->node_count; ++node) {
        if (places[node] == 0) { continue; }
        const bool is_start = node < d || places[node - d] == 0;
        if (is_start) {
            open_first = open_first == PLI_NULL_INDEX ? node : open_first;
            open_last = node;
            continue;
        }
        if (open_first != PLI_NULL_INDEX) {
            const bool is_awaited = sides[node - d] == LINK_RUNS_OPEN;
            const bool is_near_before =
                before != PLI_NULL_INDEX && (is_awaited || open_first - before <= node - open_last);
            uint8_t side = LINK_RUNS_EVEN;
            if (is_near_before) {
                side = sides[before];
            } else if (!is_awaited) {
                side = link_runs_other_side(sides[node - d]);
            }
            link_runs_set_sides(work, open_first, open_last, side);
            open_first = PLI_NULL_INDEX;
        }
        sides[node] = link_runs_other_side(sides[node - d]);
        before = node;
    }
    if (open_first != PLI_NULL_INDEX) {
        link_runs_set_sides(work, open_first, open_last,
                            before != PLI_NULL_INDEX ? sides[before] : (uint8_t)LINK_RUNS_EVEN);
    }
}

static int link_runs_compare_runs(const void* a, const void* b) {
    const int node_a = ((const plii_link_run*)a)->node, node_b = ((const plii_link_run*)b)->node;
    return (node_a > node_b) - (node_a < node_b);
}

/* Of the last colour, by node: parts of it are parts of the body. */
static void link_runs_sort_runs(plii_link_runs* made, int color) {
    const int first = made->colors[color].first_run;
    int group = made->colors[color].first_group;
    qsort(&made->runs[first], (size_t)(made->run_count - first), sizeof *made->runs, link_runs_compare_runs);
    for (int r = first; r < made->run_count; ++r) {
        made->runs[r].first_group = group;
        group += made->runs[r].group_count;
    }
}

/* One of the two colours of a class, if it has links, in an order of nodes that makes strides constant: near nodes
   2 d apart, others one after the other. */
static void link_runs_make_runs(plii_link_runs_work* work, int d, uint8_t side, bool with_link_stride) {
    const int color = work->made.color_count;
    const int stride = d < LINK_RUNS_NEAR ? 2 * d : 1;
    link_runs_row row = {0};
    work->made.colors[color].first_run = work->made.run_count;
    work->made.colors[color].first_group = work->made.group_count;
    for (int first = 0; first < stride; ++first) {
        for (int64_t node = first; node < work->body->node_count; node += stride) {
            if (work->places[node] > 0 && work->sides[node] == side) {
                link_runs_add_to_row(work, &row, (int)node, d, with_link_stride);
            }
        }
    }
    if (row.count > 0) { link_runs_end_row(work, &row, d, with_link_stride); }
    if (work->made.run_count == work->made.colors[color].first_run) { return; }
    link_runs_sort_runs(&work->made, color);
    work->made.color_count += 1;
}

/* Both colours of a class, unless too few of its links form runs. */
static bool link_runs_try_class(plii_link_runs_work* work, int class_index, int count, bool with_link_stride) {
    const plii_link_runs before = work->made;
    link_runs_make_runs(work, work->classes[class_index], LINK_RUNS_EVEN, with_link_stride);
    link_runs_make_runs(work, work->classes[class_index], LINK_RUNS_ODD, with_link_stride);
    const int in_runs = PLII_LINK_LANES * (work->made.group_count - before.group_count);
    if (in_runs >= count / 4 * 3) { return true; }
    work->made = before;
    return false;
}

void plii_link_runs_find(plii_link_runs_work* work) {
    int class_begin[PLII_LINK_RUNS_MAX_CLASSES + 1] = {0};
    link_runs_find_classes(work, class_begin);
    for (int k = 0; k < work->class_count; ++k) {
        int count = 0;
        for (int i = class_begin[k]; i < class_begin[k + 1]; ++i) {
            /* A second link between the same two nodes is left out. */
            int* place = &work->places[link_runs_low_node(work->body, work->list[i])];
            if (*place == 0) {
                *place = work->list[i] + 1;
                count += 1;
            }
        }
        link_runs_take_sides(work, work->classes[k]);
        const bool is_taken = link_runs_try_class(work, k, count, true) || link_runs_try_class(work, k, count, false);
        for (int i = class_begin[k]; i < class_begin[k + 1]; ++i) {
            work->places[link_runs_low_node(work->body, work->list[i])] = 0;
            if (!is_taken) { work->is_used[work->list[i]] = 0; }
        }
    }
    plii_link_runs* made = &work->made;
    made->colors[made->color_count] = (plii_link_run_color){made->run_count, made->group_count};
}
