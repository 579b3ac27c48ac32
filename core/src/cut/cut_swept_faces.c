/* A swept cut through faces: nodes on their edges, the edges that are opened, and the ends of the cut that stay closed.
 */

#include "cut/cut_separate.h"
#include "cut/cut_swept_impl.h"

/* Flags of borders. */
enum { SWEPT_FACE_BELOW = 4, SWEPT_FACE_ABOVE = 8 };

bool plii_swept_add_nodes(plii_swept_pass* pass) {
    plii_edge_map* edges = &pass->edges;
    const int* order = plii_edge_map_order(edges, pass->node_count, &pass->scratch);
    for (int i = 0; !pass->scratch.is_short && i < edges->count; ++i) {
        plii_edge* edge = &edges->edges[order[i]];
        if (edge->flags != (PLII_SWEPT_OF_FACE | PLII_SWEPT_CROSSED)) { continue; }
        edge->node = plii_edit_add_node(pass->edit, edge->a, edge->b, edge->share);
        if (edge->node == PLI_NULL_INDEX) { return false; }
    }
    return !pass->scratch.is_short;
}

static bool swept_open(plii_swept_pass* pass, int a, int b) {
    return plii_edge_map_add(&pass->cuts, a, b) != NULL;
}

static bool swept_note_border(plii_swept_pass* pass, int a, int b, double height) {
    plii_edge* border = plii_edge_map_add(&pass->borders, a, b);
    if (border != NULL) { border->flags |= height < 0.0 ? SWEPT_FACE_BELOW : SWEPT_FACE_ABOVE; }
    return border != NULL;
}

bool plii_swept_open_closed_edges(plii_swept_pass* pass) {
    const plii_swept_ends* ends = &pass->work->ends;
    for (int i = 0; i < ends->edge_count; ++i) {
        const int a = ends->edges[i][0], b = ends->edges[i][1];
        const int node = plii_edge_map_node(&pass->edges, a, b);
        const bool ok =
            node != PLI_NULL_INDEX ? swept_open(pass, a, node) && swept_open(pass, node, b) : swept_open(pass, a, b);
        if (!ok) { return false; }
    }
    return true;
}

/* Which edges of one face will be opened. */
static bool swept_judge_face(plii_swept_pass* pass, const int* nodes) {
    int crossings[3], crossing_count = 0, crossed = 0; /* `crossed`: an edge, from the corner to the next */
    int on_count = 0, on = 0, tip = PLI_NULL_INDEX;
    for (int k = 0; k < 3; ++k) {
        const int node = plii_edge_map_node(&pass->edges, nodes[k], nodes[(k + 1) % 3]);
        if (node != PLI_NULL_INDEX) {
            crossings[crossing_count++] = node;
            crossed = k;
        }
        if (plii_swept_is_on_blade(pass, nodes[k])) {
            ++on_count;
            on = nodes[k];
        } else if (plii_swept_is_tip(pass, nodes[k])) {
            tip = nodes[k];
        }
    }
    if (crossing_count == 2) { return swept_open(pass, crossings[0], crossings[1]); }
    if (crossing_count == 1) {
        const int first = nodes[crossed], second = nodes[(crossed + 1) % 3], opposite = nodes[(crossed + 2) % 3];
        if (plii_swept_is_on_blade(pass, opposite) || plii_swept_is_tip(pass, opposite)) {
            return swept_open(pass, crossings[0], opposite);
        }
        if (plii_swept_is_tip(pass, first)) { return swept_open(pass, crossings[0], first); }
        return !plii_swept_is_tip(pass, second) || swept_open(pass, crossings[0], second);
    }
    if (crossing_count == 0 && on_count == 1 && tip != PLI_NULL_INDEX) { return swept_open(pass, on, tip); }
    if (crossing_count > 0 || on_count < 2) { return true; }
    bool ok = true;
    for (int k = 0; ok && k < 3; ++k) {
        const int a = nodes[k], b = nodes[(k + 1) % 3];
        if (!plii_swept_is_on_blade(pass, a) || !plii_swept_is_on_blade(pass, b)) { continue; }
        /* A face with all nodes on the blade counts as above. */
        ok = swept_note_border(pass, a, b, on_count == 3 ? 0.0 : pass->heights[nodes[(k + 2) % 3]]);
    }
    return ok;
}

bool plii_swept_judge_faces(plii_swept_pass* pass) {
    for (int i = 0; i < pass->edit->face_count; ++i) {
        if (!swept_judge_face(pass, pass->edit->faces[i].nodes)) { return false; }
    }
    /* An edge between two nodes on the blade is opened when it has faces on both sides of the plane. */
    for (int i = 0; i < pass->borders.count; ++i) {
        const plii_edge* border = &pass->borders.edges[i];
        if (border->flags == (SWEPT_FACE_BELOW | SWEPT_FACE_ABOVE) && !swept_open(pass, border->a, border->b)) {
            return false;
        }
    }
    return true;
}

// ---------------------------------------------------------------------------------------------------------------- tips

/* Tips are the nodes of the cut that are still closed. */
static bool swept_find_tips(plii_swept_pass* pass, const uint8_t* is_parted, int node_count) {
    plii_swept_ends* ends = &pass->work->ends;
    int kept = 0;
    for (int i = 0; i < ends->tip_count; ++i) {
        if (is_parted[ends->tips[i]] == 0) { ends->tips[kept++] = ends->tips[i]; }
    }
    ends->tip_count = kept;
    for (int i = 0; i < node_count; ++i) {
        const unsigned marks = i < pass->node_count ? pass->marks[i] : PLII_SWEPT_ON_BLADE | PLII_SWEPT_HAS_FACE;
        const bool is_on_surface =
            (marks & (PLII_SWEPT_ON_BLADE | PLII_SWEPT_HAS_FACE)) == (PLII_SWEPT_ON_BLADE | PLII_SWEPT_HAS_FACE);
        if (!is_on_surface || is_parted[i] != 0 || (marks & PLII_SWEPT_IS_TIP) != 0) { continue; }
        if (!PLII_RESERVE(pass->edit->context, &ends->tips, &ends->tip_capacity, ends->tip_count + 1)) { return false; }
        ends->tips[ends->tip_count++] = i;
    }
    return true;
}

/* An edge is open when one of its ends is parted. */
static bool swept_find_closed_edges(plii_swept_pass* pass, const uint8_t* is_parted) {
    plii_swept_ends* ends = &pass->work->ends;
    ends->edge_count = 0;
    for (int i = 0; i < pass->cuts.count; ++i) {
        const plii_edge* edge = &pass->cuts.edges[i];
        if (is_parted[edge->a] != 0 || is_parted[edge->b] != 0) { continue; }
        if (!PLII_RESERVE(pass->edit->context, &ends->edges, &ends->edge_capacity, ends->edge_count + 1)) {
            return false;
        }
        ends->edges[ends->edge_count][0] = edge->a;
        ends->edges[ends->edge_count++][1] = edge->b;
    }
    return true;
}

bool plii_swept_separate(plii_swept_pass* pass) {
    const int node_count = pass->edit->node_count;
    uint8_t* is_parted = PLII_TAKE(&pass->scratch, uint8_t, node_count);
    return is_parted != NULL &&
           plii_cut_separate(pass->edit, &pass->cuts, pass->heights, pass->node_count, is_parted,
                             &pass->work->parted) &&
           swept_find_tips(pass, is_parted, node_count) && swept_find_closed_edges(pass, is_parted);
}
