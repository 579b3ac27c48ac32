/* Cutting one link in two, in the order of btSoftBody::cutLink; its ends give mass, and the halves share its length. */

#include "cut/topology_edit.h"
#include "pliant/cut.h"

typedef struct link_cut {
    plii_edit edit;
    int ends[2];  /* a, b */
    int nodes[2]; /* the new ends of the halves at a and at b */
    float share;
    plii_edge_map edges; /* of the faces along the link */
} link_cut;

static bool link_cut_matches(const link_cut* cut, int first, int second) {
    return (first == cut->ends[0] && second == cut->ends[1]) || (first == cut->ends[1] && second == cut->ends[0]);
}

static bool link_cut_meets(const int nodes[4], const void* user) {
    const link_cut* cut = user;
    int count = 0;
    for (int k = 0; k < 4; ++k) {
        count += nodes[k] == cut->ends[0] || nodes[k] == cut->ends[1];
    }
    return count == 2;
}

static pli_status link_cut_check(const link_cut* cut) {
    const plii_edit* edit = &cut->edit;
    PLII_TRY(plii_edit_check_tetras(edit, link_cut_meets, cut, "the link is an edge of"));
    for (int i = 0; i < edit->link_count; ++i) {
        if (link_cut_matches(cut, edit->links[i].nodes[0], edit->links[i].nodes[1])) { return PLI_OK; }
    }
    return plii_fail(edit->context, PLI_ERROR_INVALID_VALUE, edit->function, "no link joins nodes %d and %d",
                     cut->ends[0], cut->ends[1]);
}

static void link_cut_split_links(link_cut* cut) {
    cut->nodes[0] = plii_edit_add_node(&cut->edit, cut->ends[0], cut->ends[1], cut->share);
    cut->nodes[1] = plii_edit_copy_node(&cut->edit, cut->nodes[0]);
    const int count = cut->edit.link_count;
    for (int i = 0; i < count; ++i) {
        const int* nodes = cut->edit.links[i].nodes;
        if (!link_cut_matches(cut, nodes[0], nodes[1])) { continue; }
        plii_edit_split_link(&cut->edit, i, cut->ends[0], cut->share, cut->nodes[0], cut->nodes[1]);
    }
}

/* Links from both new nodes to a corner, once per corner. */
static void link_cut_add_spokes(link_cut* cut, int corner, uint16_t material) {
    plii_edge* edge = plii_edit_add_edge(&cut->edit, &cut->edges, cut->nodes[0], corner);
    if (edge->flags != 0) { return; }
    edge->flags = 1;
    const float rest_squared =
        plii_edit_median_squared(&cut->edit, &cut->edges, corner, cut->ends[0], cut->ends[1], cut->share);
    for (int i = 0; i < 2; ++i) {
        const plii_edit_link link = {{cut->nodes[i], corner}, rest_squared, (plii_link_tag)material};
        plii_edit_add_link(&cut->edit, link);
    }
}

static void link_cut_split_faces(link_cut* cut) {
    const int count = cut->edit.face_count;
    for (int i = 0; i < count; ++i) {
        for (int j = 2, k = 0; k < 3; j = k++) {
            plii_edit_face face = cut->edit.faces[i];
            if (!link_cut_matches(cut, face.nodes[j], face.nodes[k])) { continue; }
            const int first = face.nodes[j] == cut->ends[0] ? 0 : 1;
            const float share = first == 0 ? cut->share : 1.0f - cut->share;
            plii_edit_face second = face;
            second.nodes[j] = cut->nodes[1 - first];
            second.origin.share = face.origin.share * (1.0f - share);
            face.nodes[k] = cut->nodes[first];
            face.origin.share *= share;
            cut->edit.faces[i] = face;
            plii_edit_add_face(&cut->edit, second);
            link_cut_add_spokes(cut, face.nodes[(k + 1) % 3], face.material);
        }
    }
}

pli_status pli_body_cut_link(pli_body* body, int node_a, int node_b, float position) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(plii_check_node(body, node_a, __func__));
    PLII_TRY(plii_check_node(body, node_b, __func__));
    const float below_1 = 1.0f - FLT_EPSILON / 2.0f;
    PLII_TRY(plii_check_between(body->context, position, PLII_ABOVE_0, below_1, "position", __func__));
    link_cut cut = {.ends = {node_a, node_b}, .share = position, .edges.table.context = body->context};
    PLII_TRY(plii_edit_open(body, __func__, &cut.edit));
    const pli_status status = link_cut_check(&cut);
    if (status == PLI_OK) {
        plii_edge* edge = plii_edit_add_edge(&cut.edit, &cut.edges, node_a, node_b);
        edge->node = cut.edit.node_count;       /* the next one */
        plii_edit_learn(&cut.edit, &cut.edges); /* what the rest lengths of the new links follow from */
        link_cut_split_links(&cut);
        link_cut_split_faces(&cut);
    }
    plii_edge_map_free(&cut.edges);
    return plii_body_changed(body, plii_edit_end(&cut.edit, status));
}
