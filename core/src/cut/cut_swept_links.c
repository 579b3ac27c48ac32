/* A swept cut through links that no face has: ropes, bending links, and braces inside of a surface. */

#include "cut/cut_swept_impl.h"

/* The edge of a link that the blade crosses away from faces, or NULL. */
static plii_edge* swept_crossed_edge(const plii_swept_pass* pass, int a, int b) {
    plii_edge* edge = plii_edge_map_find(&pass->edges, a, b);
    return edge != NULL && edge->flags == PLII_SWEPT_CROSSED ? edge : NULL;
}

static bool swept_removes(const plii_edit_link* link, void* user) {
    const plii_swept_pass* pass = user;
    const int a = link->nodes[0], b = link->nodes[1];
    if (plii_edit_link_is_bending(link)) {
        return !plii_swept_is_on_blade(pass, a) && !plii_swept_is_on_blade(pass, b) &&
               plii_swept_crossing(pass, a, b) >= 0.0;
    }
    return (pass->marks[a] & pass->marks[b] & PLII_SWEPT_HAS_FACE) != 0 && swept_crossed_edge(pass, a, b) != NULL;
}

void plii_swept_remove_links(plii_swept_pass* pass) {
    const int count = pass->edit->link_count;
    plii_edit_remove_links(pass->edit, swept_removes, pass);
    pass->work->parted += count - pass->edit->link_count;
}

bool plii_swept_part_rope_links(plii_swept_pass* pass) {
    plii_edit* edit = pass->edit;
    const int count = edit->link_count;
    for (int i = 0; i < count; ++i) {
        plii_edge* edge = swept_crossed_edge(pass, edit->links[i].nodes[0], edit->links[i].nodes[1]);
        if (edge == NULL) { continue; }
        if (edge->first == PLI_NULL_INDEX) {
            edge->first = plii_edit_add_node(edit, edge->a, edge->b, edge->share);
            if (edge->first == PLI_NULL_INDEX || plii_edit_copy_node(edit, edge->first) == PLI_NULL_INDEX) {
                return false;
            }
        }
        const bool is_forward = edit->links[i].nodes[0] == edge->a;
        const int at_a = edge->first, at_b = edge->first + 1;
        if (!plii_edit_split_link(edit, i, is_forward ? edge->share : 1.0f - edge->share, is_forward ? at_a : at_b,
                                  is_forward ? at_b : at_a)) {
            return false;
        }
        pass->work->parted += 1;
    }
    return true;
}

static int swept_rope_side(const plii_swept_pass* pass, int other) {
    const double height = other < pass->node_count ? pass->heights[other] : 0.0;
    return height > 0.0 ? PLII_SWEPT_ABOVE : height < 0.0 ? PLII_SWEPT_BELOW : 0;
}

bool plii_swept_part_rope_nodes(plii_swept_pass* pass) {
    plii_edit* edit = pass->edit;
    for (int i = 0; i < edit->link_count; ++i) {
        const int* nodes = edit->links[i].nodes;
        for (int k = 0; k < 2; ++k) {
            if (!plii_swept_is_on_blade(pass, nodes[k])) { continue; }
            plii_swept_mark(pass, nodes[k], (unsigned)swept_rope_side(pass, nodes[1 - k]));
        }
    }
    /* Copies of the nodes, by node; 0 is none, since copies come last. */
    int* copies = PLII_TAKE(&pass->scratch, int, pass->node_count);
    for (int i = 0; copies != NULL && i < pass->node_count; ++i) {
        const unsigned marks = pass->marks[i], both = PLII_SWEPT_BELOW | PLII_SWEPT_ABOVE;
        if ((marks & (PLII_SWEPT_ON_BLADE | PLII_SWEPT_HAS_FACE)) != PLII_SWEPT_ON_BLADE || (marks & both) != both) {
            continue;
        }
        copies[i] = plii_edit_copy_node(edit, i);
        if (copies[i] == PLI_NULL_INDEX) { return false; }
        pass->work->parted += 1;
    }
    for (int i = 0; copies != NULL && i < edit->link_count; ++i) {
        const int nodes[2] = {edit->links[i].nodes[0], edit->links[i].nodes[1]};
        for (int k = 0; k < 2; ++k) {
            if (nodes[k] < pass->node_count && copies[nodes[k]] != 0 &&
                swept_rope_side(pass, nodes[1 - k]) == PLII_SWEPT_BELOW) {
                edit->links[i].nodes[k] = copies[nodes[k]];
            }
        }
    }
    return copies != NULL;
}
