/* What the blade of a swept cut meets: edges, nodes, and tetrahedra, which cannot be cut. */

#include "cut/cut_swept_impl.h"

/* A crossing nearer to the end of an edge than this share of it uses the end. */
#define SWEPT_SNAP 0.05

static bool swept_meet_edge(plii_swept_pass* pass, int end_a, int end_b, unsigned flags) {
    const int a = end_a < end_b ? end_a : end_b, b = end_a < end_b ? end_b : end_a;
    if (pass->heights[a] == 0.0 && pass->heights[b] == 0.0) { /* in the plane */
        if (plii_swept_is_inside(pass->blade, plii_swept_point(pass, a))) {
            plii_swept_mark(pass, a, PLII_SWEPT_ON_BLADE);
        }
        if (plii_swept_is_inside(pass->blade, plii_swept_point(pass, b))) {
            plii_swept_mark(pass, b, PLII_SWEPT_ON_BLADE);
        }
        return true;
    }
    const double t = plii_swept_crossing(pass, a, b);
    if (t < 0.0) { return true; }
    if (t <= SWEPT_SNAP || t >= 1.0 - SWEPT_SNAP) {
        plii_swept_mark(pass, t <= SWEPT_SNAP ? a : b, PLII_SWEPT_ON_BLADE);
        return true;
    }
    plii_edge* edge = plii_edge_map_add(&pass->edges, a, b);
    if (edge == NULL) { return false; }
    edge->share = (float)t;
    edge->flags |= flags | PLII_SWEPT_CROSSED;
    return true;
}

bool plii_swept_find_edges(plii_swept_pass* pass) {
    const plii_edit* edit = pass->edit;
    for (int i = 0; i < edit->link_count; ++i) {
        const plii_edit_link* link = &edit->links[i];
        if (!plii_edit_link_is_bending(link) && !swept_meet_edge(pass, link->nodes[0], link->nodes[1], 0)) {
            return false;
        }
    }
    for (int i = 0; i < edit->face_count; ++i) {
        const int* nodes = edit->faces[i].nodes;
        for (int j = 2, k = 0; k < 3; j = k++) {
            plii_swept_mark(pass, nodes[k], PLII_SWEPT_HAS_FACE);
            if (!swept_meet_edge(pass, nodes[j], nodes[k], PLII_SWEPT_OF_FACE)) { return false; }
        }
    }
    /* An edge with an end on the blade is met there. */
    for (int i = 0; i < pass->edges.count; ++i) {
        plii_edge* edge = &pass->edges.edges[i];
        if (plii_swept_is_on_blade(pass, edge->a) || plii_swept_is_on_blade(pass, edge->b)) { edge->flags = 0; }
    }
    return true;
}

bool plii_swept_meets_something(const plii_swept_pass* pass) {
    for (int i = 0; i < pass->edges.count; ++i) {
        if (pass->edges.edges[i].flags != 0) { return true; }
    }
    for (int i = 0; i < pass->node_count; ++i) {
        if (plii_swept_is_on_blade(pass, i)) { return true; }
    }
    return false;
}

static bool swept_meets_tetra(const int nodes[4], const void* user) {
    const plii_swept_pass* pass = user;
    for (int j = 0; j < 4; ++j) {
        if (plii_swept_is_on_blade(pass, nodes[j])) { return true; }
        for (int k = j + 1; k < 4; ++k) {
            const plii_edge* edge = plii_edge_map_find(&pass->edges, nodes[j], nodes[k]);
            if (edge != NULL && (edge->flags & PLII_SWEPT_CROSSED) != 0) { return true; }
        }
    }
    return false;
}

pli_status plii_swept_check_tetras(const plii_swept_pass* pass) {
    return plii_edit_check_tetras(pass->edit, swept_meets_tetra, pass, "the blade meets");
}
