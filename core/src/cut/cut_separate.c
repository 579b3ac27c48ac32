/* Opening a surface along edges. Linear in the size of the body. */

#include "base/csr.h"
#include "base/union_find.h"
#include "cut/topology_edit.h"

/* Corners are numbered by faces. Those at one end of a cut edge fall into groups, named by their first corner. */
typedef struct separate_group {
    int node;    /* that it gets */
    double side; /* sum of the heights around */
} separate_group;

/* What the faces along an edge make of it; one list per edge. */
typedef struct separate_pair {
    int a, b; /* in the order of the edge */
    int next;
} separate_pair;

typedef struct separate_work {
    plii_edit* edit;
    plii_scratch scratch;
    const plii_edge_map* cuts;
    const double* heights;
    int height_count, node_count; /* before nodes were copied */
    int *begin, *corners;         /* [node_count + 1], [3 * face_count] corners of each node, in the order of faces */
    int* parents;                 /* [3 * face_count] a forest over the corners */
    separate_group* groups;       /* [3 * face_count] */
    int* last_corner1;            /* [node_count] scratch; corner + 1, 0: none */
    uint8_t* is_end;              /* [node_count] of a cut edge */
    int (*sides)[2];              /* [node_count] the node of the group below and above, of parted nodes */
    plii_edge_map edges;
    separate_pair* pairs;
    int pair_count, pair_capacity;
} separate_work;

static double separate_height(const separate_work* work, int node) {
    return node < work->height_count ? work->heights[node] : 0.0;
}

/* The node that a copy was made of; edits copy only nodes that were there before. */
static int separate_original(const separate_work* work, int node) {
    return node < work->node_count ? node : work->edit->nodes[node].origin.a;
}

/* The `step`th node after that of a corner, around its face. */
static int separate_node_after(const separate_work* work, int corner, int step) {
    return work->edit->faces[corner / 3].nodes[(corner + step) % 3];
}

static bool separate_gather(separate_work* work) {
    const int corner_count = 3 * work->edit->face_count;
    int* nodes = PLII_TAKE(&work->scratch, int, corner_count);
    work->begin = PLII_TAKE(&work->scratch, int, (size_t)work->node_count + 1);
    work->corners = PLII_TAKE(&work->scratch, int, corner_count);
    work->parents = PLII_TAKE(&work->scratch, int, corner_count);
    work->groups = PLII_TAKE(&work->scratch, separate_group, corner_count);
    work->last_corner1 = PLII_TAKE(&work->scratch, int, work->node_count);
    work->is_end = PLII_TAKE(&work->scratch, uint8_t, work->node_count);
    work->sides = PLII_TAKE(&work->scratch, int[2], work->node_count);
    if (work->scratch.is_short) { return false; }
    for (int c = 0; c < corner_count; ++c) {
        nodes[c] = separate_node_after(work, c, 0);
    }
    plii_csr_sort(work->node_count, corner_count, nodes, work->begin, work->corners);
    plii_union_start(corner_count, work->parents);
    for (int i = 0; i < work->cuts->count; ++i) {
        work->is_end[work->cuts->edges[i].a] = work->is_end[work->cuts->edges[i].b] = 1;
    }
    return true;
}

/* Joins the corners at a node whose faces share an edge that is not cut. */
static void separate_group_corners(const separate_work* work, int node) {
    for (int i = work->begin[node]; i < work->begin[node + 1]; ++i) {
        for (int k = 1; k < 3; ++k) {
            const int other = separate_node_after(work, work->corners[i], k);
            if (plii_edge_map_find(work->cuts, node, other) != NULL) { continue; }
            const int last1 = work->last_corner1[other];
            if (last1 != 0) { plii_union_join(work->parents, work->corners[i], last1 - 1); }
            work->last_corner1[other] = work->corners[i] + 1;
        }
    }
    for (int i = work->begin[node]; i < work->begin[node + 1]; ++i) {
        const int root = plii_union_root(work->parents, work->corners[i]);
        for (int k = 1; k < 3; ++k) {
            const int other = separate_node_after(work, work->corners[i], k);
            work->last_corner1[other] = 0;
            work->groups[root].side += separate_height(work, other);
        }
    }
}

/* A node for each group. The first group is that of the first face and keeps the node. */
static void separate_copy(separate_work* work, int node, uint8_t* is_parted) {
    bool has_side[2] = {false, false};
    work->sides[node][0] = work->sides[node][1] = node;
    for (int i = work->begin[node]; i < work->begin[node + 1]; ++i) {
        if (work->parents[work->corners[i]] != work->corners[i]) { continue; }
        separate_group* group = &work->groups[work->corners[i]];
        group->node = node;
        if (i != work->begin[node]) {
            group->node = plii_edit_copy_node(work->edit, node);
            is_parted[node] = 1;
        }
        const int side = group->side > 0.0 ? 1 : 0;
        if (group->side != 0.0 && !has_side[side]) {
            has_side[side] = true;
            work->sides[node][side] = group->node;
        }
    }
}

static void separate_note_pair(separate_work* work, int a, int b) {
    const int original_a = separate_original(work, a), original_b = separate_original(work, b);
    plii_edge* edge = plii_edit_add_edge(work->edit, &work->edges, original_a, original_b);
    if (!PLII_EDIT_GROW(work->edit, &work->pairs, &work->pair_capacity, work->pair_count)) { return; }
    const separate_pair pair = {original_a == edge->a ? a : b, original_a == edge->a ? b : a, PLI_NULL_INDEX};
    int* link = &edge->first;
    for (; *link != PLI_NULL_INDEX; link = &work->pairs[*link].next) {
        if (work->pairs[*link].a == pair.a && work->pairs[*link].b == pair.b) { return; }
    }
    work->pairs[work->pair_count] = pair;
    *link = work->pair_count++;
}

/* Gives the faces their nodes and notes what becomes of edges with a parted end. */
static void separate_rewrite_faces(separate_work* work, const uint8_t* is_parted) {
    const int corner_count = 3 * work->edit->face_count;
    for (int c = 0; c < corner_count; ++c) {
        int* node = &work->edit->faces[c / 3].nodes[c % 3];
        if (is_parted[*node] != 0) { *node = work->groups[plii_union_root(work->parents, c)].node; }
    }
    for (int i = 0; i < corner_count; ++i) {
        const int corner = work->corners[i], node = separate_node_after(work, corner, 0);
        if (is_parted[separate_original(work, node)] == 0) { continue; }
        for (int k = 1; k < 3; ++k) {
            separate_note_pair(work, node, separate_node_after(work, corner, k));
        }
    }
}

static int separate_end_by_side(const separate_work* work, int node, int other, const uint8_t* is_parted) {
    const double height = separate_height(work, other);
    return is_parted[node] != 0 && height != 0.0 ? work->sides[node][height > 0.0 ? 1 : 0] : node;
}

/* Bending links of parted nodes go: the side that they belong to is not known. */
static bool separate_removes(const plii_edit_link* link, void* user) {
    const uint8_t* is_parted = user;
    return plii_edit_link_is_bending(link) && (is_parted[link->nodes[0]] != 0 || is_parted[link->nodes[1]] != 0);
}

static void separate_rewrite_links(separate_work* work, uint8_t* is_parted, int* doubled) {
    plii_edit* edit = work->edit;
    plii_edit_remove_links(edit, separate_removes, is_parted);
    const int count = edit->link_count;
    for (int i = 0; i < count; ++i) {
        const plii_edit_link link = edit->links[i];
        const int a = link.nodes[0], b = link.nodes[1];
        if (is_parted[a] == 0 && is_parted[b] == 0) { continue; }
        const plii_edge* edge = plii_edge_map_find(&work->edges, a, b);
        if (edge == NULL) {
            edit->links[i].nodes[0] = separate_end_by_side(work, a, b, is_parted);
            edit->links[i].nodes[1] = separate_end_by_side(work, b, a, is_parted);
            continue;
        }
        int made = 0;
        for (int k = edge->first; k != PLI_NULL_INDEX; k = work->pairs[k].next, ++made) {
            plii_edit_link part = link;
            part.nodes[0] = a == edge->a ? work->pairs[k].a : work->pairs[k].b;
            part.nodes[1] = a == edge->a ? work->pairs[k].b : work->pairs[k].a;
            if (made == 0) {
                edit->links[i] = part;
            } else {
                plii_edit_add_link(edit, part);
            }
        }
        if (made > 1 && a < work->height_count && b < work->height_count) { *doubled += 1; }
    }
}

void plii_cut_separate(plii_edit* edit, const plii_edge_map* cuts, const double* heights, int height_count,
                       uint8_t* is_parted, int* doubled) {
    if (cuts->count == 0) { return; }
    separate_work work = {.edit = edit,
                          .scratch = {.context = edit->context},
                          .cuts = cuts,
                          .heights = heights,
                          .height_count = height_count,
                          .node_count = edit->node_count,
                          .edges.table.context = edit->context};
    if (separate_gather(&work)) {
        for (int i = 0; i < work.node_count; ++i) {
            if (work.is_end[i] == 0) { continue; }
            separate_group_corners(&work, i);
            separate_copy(&work, i, is_parted);
        }
        separate_rewrite_faces(&work, is_parted);
        separate_rewrite_links(&work, is_parted, doubled);
    }
    edit->scratch.is_short |= work.scratch.is_short;
    plii_scratch_free(&work.scratch);
    PLII_RELEASE(edit->context, work.pairs, work.pair_capacity);
    plii_edge_map_free(&work.edges);
}
