/* Runs of links. First come the classes of links with the same difference of node indices, if there are many of them:
   the rows, columns and diagonals of grids. Links a, a + d are chains a, a + d, a + 2 d, ..., so two colours suffice:
   the parity of the whole part of a / d. What rows of links leave after their last whole group becomes a group with the
   links before it, which it skips. Linear time but for a sweep over the nodes per class. */

#include "solver/coloring/link_runs.h"

#include "solver/coloring/link_quads.h"

#include <string.h>

enum {
    LINK_RUNS_LEAST_CLASS = 4 * PLII_LINK_LANES, /* links */
    LINK_RUNS_LEAST_ROW = PLII_LINK_LANES /* classes of smaller differences that do not take turns have no rows */
};

/* Sides of the links of a class. */
enum { LINK_RUNS_OPEN, LINK_RUNS_EVEN, LINK_RUNS_ODD };

/* Links of a colour that may become a run: of one tag, nodes as plii_link_run says. */
typedef struct link_runs_row {
    int node, step, link, link_stride, count;
    int regular_count; /* the first ones, which have the stride */
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

/* Links of a row that are in runs; where two and two nodes take turns, an odd last link would begin its group with half
   a turn. */
static int link_runs_taken(const link_runs_row* row, int offset) {
    const bool has_turns = plii_link_run_has_turns(offset);
    return row->count < PLII_LINK_LANES ? 0 : has_turns ? row->count / offset * offset : row->count;
}

/* Groups that go on where the last run of the colour ends, with links of a row from `begin` on, lengthen it. */
static plii_link_run* link_runs_run_of(plii_link_runs* made, const link_runs_row* row, int offset, int begin) {
    const int node = row->node + plii_link_run_way(offset, row->step, begin);
    if (made->run_count > made->colors[made->color_count].first_run) {
        plii_link_run* last = &made->runs[made->run_count - 1];
        if (last->skipped_count == 0 && last->tag == row->tag && last->step == row->step &&
            plii_link_run_node(last, last->group_count) == node) {
            return last;
        }
    }
    plii_link_run* run = &made->runs[made->run_count++];
    *run = (plii_link_run){
        .node = node, .offset = offset, .first_group = made->group_count, .tag = row->tag, .step = (uint8_t)row->step};
    return run;
}

/* Links [begin, end) of a row come into runs. Those that an end skips come before `begin`. */
static void link_runs_add_groups(plii_link_runs_work* work, const link_runs_row* row, int offset, int begin, int end,
                                 bool has_stride) {
    plii_link_runs* made = &work->made;
    plii_link_run* run = link_runs_run_of(made, row, offset, begin);
    const int group_count = (end - begin + PLII_LINK_LANES - 1) / PLII_LINK_LANES;
    const int way = plii_link_run_way(offset, row->step, begin);
    made->sources[made->source_count++] =
        (plii_link_source){made->group_count, has_stride ? row->link + way * row->link_stride : made->run_link_count,
                           has_stride ? row->link_stride : 0};
    run->group_count += group_count;
    run->skipped_count = (uint8_t)(PLII_LINK_LANES * group_count - (end - begin));
    made->group_count += group_count;
    for (int i = begin; i < end && !has_stride; ++i) {
        made->run_links[made->run_link_count++] = work->places[row->node + plii_link_run_way(offset, row->step, i)] - 1;
    }
}

static void link_runs_end_row(plii_link_runs_work* work, const link_runs_row* row, int offset) {
    const int taken = link_runs_taken(row, offset);
    const bool has_stride = row->regular_count >= PLII_LINK_LANES;
    const int regular_count = has_stride && row->regular_count < taken ? row->regular_count : taken;
    const int in_groups = regular_count / PLII_LINK_LANES * PLII_LINK_LANES;
    if (in_groups > 0) { link_runs_add_groups(work, row, offset, 0, in_groups, has_stride); }
    if (in_groups < taken) { link_runs_add_groups(work, row, offset, in_groups, taken, false); }
    for (int i = 0; i < row->count; ++i) {
        work->is_used[work->places[row->node + plii_link_run_way(offset, row->step, i)] - 1] = i < taken;
    }
}

/* Links of which tags are taken together. */
enum { LINK_RUNS_ALL, LINK_RUNS_NOT_BENDING, LINK_RUNS_BENDING };

/* A colour of a class. */
typedef struct link_runs_half {
    int offset;
    uint8_t side, kind;
    bool with_link_stride;
} link_runs_half;

static bool link_runs_is_of_kind(const pli_body* body, int link, uint8_t kind) {
    const bool is_bending = (plii_link_tag_of(body, link) & PLII_LINK_TAG_BENDING) != 0;
    return kind == LINK_RUNS_ALL || is_bending == (kind == LINK_RUNS_BENDING);
}

static bool link_runs_begins_link(const plii_link_runs_work* work, const link_runs_half* half, int node) {
    return node >= 0 && node < work->body->node_count && work->places[node] > 0 && work->sides[node] == half->side &&
           link_runs_is_of_kind(work->body, work->places[node] - 1, half->kind);
}
/* No link of the colour has this node, nor the one opposite of it. */
static bool link_runs_is_between(const plii_link_runs_work* work, const link_runs_half* half, int node) {
    return !link_runs_begins_link(work, half, node) && !link_runs_begins_link(work, half, node - half->offset) &&
           !link_runs_begins_link(work, half, node + half->offset);
}

/* Whether the link is the next one of the row. */
static bool link_runs_continues(const plii_link_runs_work* work, const link_runs_half* half, link_runs_row* row,
                                int node, int link, plii_link_tag tag) {
    if (row->count == 0 || tag != row->tag) { return false; }
    const int way = node - row->node;
    if (row->count == 1 && way == 2 && !plii_link_run_has_turns(half->offset)) { row->step = 2; }
    if (way != plii_link_run_way(half->offset, row->step, row->count)) { return false; }
    if (row->step == 2 && !link_runs_is_between(work, half, node - 1)) { return false; }
    if (!half->with_link_stride) { return true; }
    if (row->count == 1 && (link - row->link) % way == 0) { row->link_stride = (link - row->link) / way; }
    const bool is_regular = row->regular_count == row->count && link == row->link + way * row->link_stride;
    if (is_regular) { row->regular_count += 1; }
    /* Others have room in the group of what is left. */
    const int in_groups = row->regular_count / PLII_LINK_LANES * PLII_LINK_LANES;
    return is_regular || row->count + 1 - in_groups <= PLII_LINK_LANES;
}

/* Lengthens the row by the link at a node, or begins a new one with it. */
static void link_runs_add_to_row(plii_link_runs_work* work, const link_runs_half* half, link_runs_row* row, int node) {
    const int link = work->places[node] - 1;
    const plii_link_tag tag = plii_link_tag_of(work->body, link);
    if (link_runs_continues(work, half, row, node, link, tag)) {
        row->count += 1;
    } else {
        link_runs_end_row(work, row, half->offset);
        *row = (link_runs_row){.node = node,
                               .step = 1,
                               .link = link,
                               .count = 1,
                               .regular_count = half->with_link_stride ? 1 : 0,
                               .tag = tag};
    }
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
            if (open_first != PLI_NULL_INDEX && node > open_last + 1) { /* another row */
                link_runs_set_sides(work, open_first, open_last,
                                    before != PLI_NULL_INDEX ? sides[before] : (uint8_t)LINK_RUNS_EVEN);
                before = open_last;
                open_first = PLI_NULL_INDEX;
            }
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

/* One of the two colours of a class, if it has links. */
static void link_runs_make_runs(plii_link_runs_work* work, const link_runs_half* half) {
    plii_link_runs* made = &work->made;
    link_runs_row row = {0};
    made->colors[made->color_count] = (plii_link_run_color){made->run_count, made->group_count};
    for (int node = 0; node < work->body->node_count; ++node) {
        if (link_runs_begins_link(work, half, node)) { link_runs_add_to_row(work, half, &row, node); }
    }
    if (row.count > 0) { link_runs_end_row(work, &row, half->offset); }
    if (made->run_count > made->colors[made->color_count].first_run) { made->color_count += 1; }
}

/* Ways to make runs of a class. A list of links is longer than a stride; more colours are slower, but links of two
   kinds by turns need them. */
typedef struct link_runs_way {
    bool with_link_stride, parts_kinds;
} link_runs_way;

static const link_runs_way link_runs_ways[] = {{true, false}, {false, false}, {true, true}, {false, true}};

/* All colours of a class; gives how many of its links are in runs. */
static int link_runs_make_class(plii_link_runs_work* work, int offset, link_runs_way way) {
    const int first_run = work->made.run_count;
    for (int side = LINK_RUNS_EVEN; side <= LINK_RUNS_ODD; ++side) {
        const int first_kind = way.parts_kinds ? LINK_RUNS_NOT_BENDING : LINK_RUNS_ALL;
        const int last_kind = way.parts_kinds ? LINK_RUNS_BENDING : LINK_RUNS_ALL;
        for (int kind = first_kind; kind <= last_kind; ++kind) {
            link_runs_make_runs(work, &(link_runs_half){offset, (uint8_t)side, (uint8_t)kind, way.with_link_stride});
        }
    }
    int count = 0;
    for (int r = first_run; r < work->made.run_count; ++r) {
        count += PLII_LINK_LANES * work->made.runs[r].group_count - work->made.runs[r].skipped_count;
    }
    return count;
}

/* In the first way that leaves no link, or else the one that leaves the fewest. False where only few form runs. */
static bool link_runs_try_class(plii_link_runs_work* work, int offset, int link_count) {
    const plii_link_runs before = work->made;
    const int way_count = work->body->link_tags != NULL ? 4 : 2;
    int best = 0, most = -1;
    for (int w = 0; w < way_count; ++w) {
        work->made = before;
        const int count = link_runs_make_class(work, offset, link_runs_ways[w]);
        if (count == link_count) { return true; }
        if (count > most) {
            most = count;
            best = w;
        }
    }
    work->made = before;
    if (most < link_count / 4 * 3) { return false; }
    link_runs_make_class(work, offset, link_runs_ways[best]);
    return true;
}

void plii_link_runs_find(plii_link_runs_work* work) {
    int class_begin[PLII_LINK_RUNS_MAX_CLASSES + 1] = {0};
    link_runs_find_classes(work, class_begin);
    for (int k = 0; k < work->class_count; ++k) {
        if (work->classes[k] > PLII_LINK_TURNS && work->classes[k] < LINK_RUNS_LEAST_ROW) { continue; }
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
        const bool is_taken = link_runs_try_class(work, work->classes[k], count);
        for (int i = class_begin[k]; i < class_begin[k + 1]; ++i) {
            work->places[link_runs_low_node(work->body, work->list[i])] = 0;
            if (!is_taken) { work->is_used[work->list[i]] = 0; }
        }
    }
    plii_link_runs* made = &work->made;
    made->colors[made->color_count] = (plii_link_run_color){made->run_count, made->group_count};
}
