/* A swept cut through links that no face has: ropes, bending links, and braces inside of a surface. */

#include "cut/cut_swept_impl.h"

void plii_swept_remove_links(plii_swept_pass* pass) {
    plii_edit* edit = pass->edit;
    for (int i = 0; i < edit->link_count;) {
        const plii_edit_link* link = &edit->links[i];
        const int a = link->nodes[0], b = link->nodes[1];
        bool is_removed = false;
        if (plii_edit_link_is_bending(link)) {
            is_removed = !plii_swept_is_on_blade(pass, a) && !plii_swept_is_on_blade(pass, b) &&
                         plii_swept_crossing(pass, a, b) >= 0.0;
        } else if ((pass->marks[a] & pass->marks[b] & PLII_SWEPT_HAS_FACE) != 0) {
            const int place = plii_edge_map_find(&pass->edges, a, b);
            is_removed = place != PLI_NULL_INDEX && pass->edges.edges[place].flags == PLII_SWEPT_CROSSED;
        }
        if (is_removed) {
            plii_edit_remove_link(edit, i);
            pass->work->parted += 1;
            pass->work->is_changed = true;
        } else {
            ++i;
        }
    }
}

bool plii_swept_part_rope_links(plii_swept_pass* pass) {
    plii_edit* edit = pass->edit;
    const int count = edit->link_count;
    for (int i = 0; i < count; ++i) {
        const plii_edit_link link = edit->links[i];
        const int place = plii_edge_map_find(&pass->edges, link.nodes[0], link.nodes[1]);
        if (place == PLI_NULL_INDEX || pass->edges.edges[place].flags != PLII_SWEPT_CROSSED) { continue; }
        plii_edge* edge = &pass->edges.edges[place];
        if (edge->first == PLI_NULL_INDEX) {
            edge->first = plii_edit_add_node(edit, edge->a, edge->b, edge->share);
            if (edge->first == PLI_NULL_INDEX || plii_edit_copy_node(edit, edge->first) == PLI_NULL_INDEX) {
                return false;
            }
        }
        const bool is_forward = link.nodes[0] == edge->a;
        const float share = is_forward ? edge->share : 1.0f - edge->share;
        plii_edit_link second = link;
        second.nodes[0] = is_forward ? edge->first + 1 : edge->first;
        second.rest_squared = (1.0f - share) * (1.0f - share) * link.rest_squared;
        if (plii_edit_add_link(edit, second) == PLI_NULL_INDEX) { return false; }
        edit->links[i].nodes[1] = is_forward ? edge->first : edge->first + 1;
        edit->links[i].rest_squared = share * share * link.rest_squared;
        pass->work->parted += 1;
        pass->work->is_changed = true;
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
    const size_t copies_size = (size_t)pass->node_count * sizeof(int);
    int* copies = plii_allocate(edit->context, copies_size);
    bool ok = copies != NULL;
    for (int i = 0; ok && i < pass->node_count; ++i) {
        const unsigned marks = pass->marks[i], both = PLII_SWEPT_BELOW | PLII_SWEPT_ABOVE;
        if ((marks & (PLII_SWEPT_ON_BLADE | PLII_SWEPT_HAS_FACE)) != PLII_SWEPT_ON_BLADE || (marks & both) != both) {
            continue;
        }
        copies[i] = plii_edit_copy_node(edit, i);
        ok = copies[i] != PLI_NULL_INDEX;
        pass->work->parted += 1;
        pass->work->is_changed = true;
    }
    for (int i = 0; ok && i < edit->link_count; ++i) {
        const int nodes[2] = {edit->links[i].nodes[0], edit->links[i].nodes[1]};
        for (int k = 0; k < 2; ++k) {
            if (nodes[k] < pass->node_count && copies[nodes[k]] != 0 &&
                swept_rope_side(pass, nodes[1 - k]) == PLII_SWEPT_BELOW) {
                edit->links[i].nodes[k] = copies[nodes[k]];
            }
        }
    }
    plii_release(edit->context, copies, copies_size);
    return ok;
}
