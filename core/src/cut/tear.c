/* Tearing: nodes at the ends of links that are too long are parted, across the link. */

#include "cut/topology_edit.h"
#include "pliant/cut.h"

enum { TEAR_TRIALS = 4 }; /* per tear that is asked for; ends beyond which nothing hangs are in vain */

typedef struct tear {
    plii_edit edit;
    uint8_t* is_done; /* [edit.old_node_count] looked at in this call */
    /* Of one tear. */
    plii_scratch scratch;
    int node;        /* that is parted */
    pli_vec3 way;    /* along the link */
    int node_count;  /* before */
    double* heights; /* [node_count] of the neighbours, over the plane across the link */
} tear;

static pli_vec3 tear_way(const tear* t, int from, int to) {
    return pli_vec3_sub(plii_edit_position(&t->edit, to), plii_edit_position(&t->edit, from));
}

static bool tear_may_part(const tear* t, int node) {
    return node < t->edit.old_node_count && t->is_done[node] == 0 && t->edit.nodes[node].position.w > 0.0f;
}

/* The link that is stretched most, from an end that may be parted. */
static bool tear_find(const tear* t, float stretch, int ends[2]) {
    float most = stretch * stretch;
    ends[0] = PLI_NULL_INDEX;
    for (PLII_EACH(const plii_edit_link, link, t->edit.links, t->edit.link_count)) {
        const float square = pli_vec3_length_squared(tear_way(t, link->nodes[0], link->nodes[1])) / link->rest_squared;
        const int end = tear_may_part(t, link->nodes[0]) ? 0 : 1;
        const bool is_long = !plii_edit_link_is_bending(link) && square > most && square < INFINITY;
        if (!is_long || !tear_may_part(t, link->nodes[end])) { continue; }
        most = square;
        ends[0] = link->nodes[end];
        ends[1] = link->nodes[1 - end];
    }
    return ends[0] != PLI_NULL_INDEX;
}

static double tear_note_height(const tear* t, int node) {
    return t->heights[node] = (double)pli_vec3_dot(tear_way(t, t->node, node), t->way);
}

/* The edges between faces on the side of the link and others. */
static void tear_find_cuts(tear* t, plii_edge_map* edges, plii_edge_map* cuts) {
    for (PLII_EACH(const plii_edit_face, face, t->edit.faces, t->edit.face_count)) {
        for (int k = 0; k < 3; ++k) {
            if (face->nodes[k] != t->node) { continue; }
            const int a = face->nodes[(k + 1) % 3], b = face->nodes[(k + 2) % 3];
            const unsigned side = tear_note_height(t, a) + tear_note_height(t, b) > 0.0 ? 1 : 2;
            plii_edit_add_edge(&t->edit, edges, t->node, a)->flags |= side;
            plii_edit_add_edge(&t->edit, edges, t->node, b)->flags |= side;
        }
    }
    for (PLII_EACH(const plii_edge, edge, edges->edges, edges->count)) {
        if (edge->flags == 3) { plii_edit_add_edge(&t->edit, cuts, edge->a, edge->b); }
    }
}

/* Bending links from one side to the other. */
static bool tear_removes(const plii_edit_link* link, void* user) {
    const tear* t = user;
    const int a = link->nodes[0], b = link->nodes[1];
    return plii_edit_link_is_bending(link) && a < t->node_count && b < t->node_count &&
           t->heights[a] * t->heights[b] < 0.0;
}

static void tear_open(tear* t) {
    plii_edit* edit = &t->edit;
    plii_edge_map edges = {.table.context = edit->context}, cuts = edges;
    bool stays = false;
    for (PLII_EACH(const plii_edit_link, link, edit->links, edit->link_count)) {
        const int end = link->nodes[1] == t->node;
        stays = (link->nodes[end] == t->node && tear_note_height(t, link->nodes[1 - end]) <= 0.0) || stays;
    }
    tear_find_cuts(t, &edges, &cuts);
    if (edges.count == 0 && stays) { /* in a rope, or a net */
        const int copy = plii_edit_copy_node(edit, t->node);
        for (PLII_EACH(plii_edit_link, link, edit->links, edit->link_count)) {
            const int end = link->nodes[1] == t->node;
            if (link->nodes[end] == t->node && t->heights[link->nodes[1 - end]] > 0.0) { link->nodes[end] = copy; }
        }
    }
    int doubled = 0;
    uint8_t* is_parted = PLII_TAKE(&t->scratch, uint8_t, t->node_count);
    if (is_parted != NULL) { plii_cut_separate(edit, &cuts, t->heights, t->node_count, is_parted, &doubled); }
    if (edit->node_count > t->node_count) { plii_edit_remove_links(edit, tear_removes, t); }
    plii_edge_map_free(&edges);
    plii_edge_map_free(&cuts);
}

/* How many nodes are parted. */
static int tear_all(tear* t, float stretch, int most) {
    plii_edit* edit = &t->edit;
    int count = 0, ends[2];
    t->is_done = PLII_TAKE(&edit->scratch, uint8_t, edit->old_node_count);
    for (int trial = 0; trial / TEAR_TRIALS < most && count < most && !edit->scratch.is_short; ++trial) {
        if (!tear_find(t, stretch, ends)) { break; }
        t->scratch = (plii_scratch){.context = edit->context};
        t->node = ends[0];
        t->way = tear_way(t, ends[0], ends[1]);
        t->node_count = edit->node_count;
        t->heights = PLII_TAKE(&t->scratch, double, t->node_count);
        t->is_done[ends[0]] = 1;
        if (t->heights != NULL) { tear_open(t); }
        edit->scratch.is_short = edit->scratch.is_short || t->scratch.is_short;
        plii_scratch_free(&t->scratch);
        if (edit->node_count == t->node_count) { continue; }
        if (ends[1] < edit->old_node_count) { t->is_done[ends[1]] = 1; }
        ++count;
    }
    return count;
}

pli_status pli_body_tear(pli_body* body, float stretch, int most, int* torn) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(plii_check_between(body->context, stretch, PLII_ABOVE_0, PLI_MAX_FACTOR, "stretch", __func__));
    PLII_FAIL_IF(most < 1, body->context, PLI_ERROR_INVALID_VALUE, __func__, "most is %d, 1 at least", most);
    bool is_due = false; /* before a copy of the body is paid for */
    for (int i = 0; i < body->link_count && !is_due; ++i) {
        is_due = !plii_link_is_bending(body, i) && plii_body_stretch(body, i) > stretch;
    }
    int count = 0;
    if (is_due) {
        PLII_FAIL_IF(body->topology->tetra_count > 0, body->context, PLI_ERROR_INVALID_MESH, __func__,
                     "tetrahedra cannot be torn");
        tear t;
        PLII_TRY(plii_edit_open(body, __func__, &t.edit));
        count = tear_all(&t, 1.0f + stretch, most);
        t.edit.is_unchanged = count == 0;
        PLII_TRY(plii_edit_end(&t.edit, PLI_OK));
    }
    if (torn != NULL) { *torn = count; }
    return plii_body_changed(body, PLI_OK);
}
