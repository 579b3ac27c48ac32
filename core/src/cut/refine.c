/* Refining a body along an implicit surface, and cutting it there. Nodes, links, faces, masses and velocities come in
   the order and with the bits of btSoftBody::refine, in linear time.

   With `reset_rest_lengths` all of Bullet's rules are kept. Without, those that harm are mended: the root search does
   not give up; a node on the surface is doubled only where parts of the body on both sides need it, and so is a link,
   which leaves no loose links and nodes behind; links keep their rest shape. Cuts through the inside of faces that
   leave nothing behind in Bullet give the same nodes, links and faces either way. */

#include "cut/topology_edit.h"
#include "pliant/cut.h"

typedef struct refine_work {
    plii_edit edit;
    pli_refine_def def;
    float* values;       /* [old nodes] of the surface */
    plii_edge_map edges; /* crossed by the surface */
    pli_status status;   /* of the callback */
} refine_work;

/* How near to the end of a link a jump of the surface may part it. */
#define REFINE_MIN_SHARE 1e-4f
/* What lies at a node that is on the surface. */
enum { REFINE_INSIDE = 1, REFINE_OUTSIDE = 2 };

PLII_DEFINE_DEFAULT(pli_refine_def, .accuracy = 1e-4f, .cut = true)

// ------------------------------------------------------------------------------------------------ the surface

/* The first value that is out of range is kept as the error. */
static float refine_evaluate(refine_work* work, pli_vec3 point) {
    const float value = work->def.surface(point, work->def.user);
    if (!plii_is_within(value, PLI_MAX_SURFACE_VALUE) && work->status == PLI_OK) {
        work->status =
            plii_fail(work->edit.context, plii_is_finite(value) ? PLI_ERROR_INVALID_VALUE : PLI_ERROR_NOT_FINITE,
                      work->edit.function, "the surface is %g at (%g, %g, %g)", (double)value, (double)point.x,
                      (double)point.y, (double)point.z);
    }
    return value;
}

static bool refine_is_crossed(const refine_work* work, int a, int b) {
    const float low = plii_min(work->values[a], work->values[b]), high = plii_max(work->values[a], work->values[b]);
    return !(low > -work->def.accuracy) && !(high < work->def.accuracy);
}

typedef struct refine_bracket {
    float span[2];   /* shares of the edge */
    float values[2]; /* below and above 0 */
} refine_bracket;

static void refine_narrow(refine_bracket* bracket, float t, float value) {
    const int end = value < 0.0f ? 0 : 1;
    bracket->span[end] = t;
    bracket->values[end] = value;
}

/* Halves the bracket until a value is good enough or floats end, as at a jump of the surface. */
static float refine_bisect(refine_work* work, pli_vec3 a, pli_vec3 b, refine_bracket bracket) {
    float t = bracket.span[1];
    for (int i = 0; i < 64; ++i) {
        const float middle = plii_lerp(bracket.span[0], bracket.span[1], 0.5f);
        if (middle == bracket.span[0] || middle == bracket.span[1]) { break; }
        t = middle;
        const float value = refine_evaluate(work, pli_vec3_lerp(a, b, t));
        if (work->status != PLI_OK || fabsf(value) < work->def.accuracy) { break; }
        refine_narrow(&bracket, t, value);
    }
    return plii_clamp(t, REFINE_MIN_SHARE, 1.0f - REFINE_MIN_SHARE);
}

/* Where the surface crosses an edge, as a share of it; -1 when that is not found. Regula falsi. */
static float refine_solve(refine_work* work, int node_a, int node_b) {
    const pli_vec3 a = plii_edit_position(&work->edit, node_a), b = plii_edit_position(&work->edit, node_b);
    refine_bracket bracket = {{0.0f, 1.0f}, {work->values[node_a], work->values[node_b]}};
    if (bracket.values[0] > bracket.values[1]) {
        bracket = (refine_bracket){{1.0f, 0.0f}, {bracket.values[1], bracket.values[0]}};
    }
    for (int i = 0; i < 256; ++i) {
        const float along = bracket.values[0] / (bracket.values[0] - bracket.values[1]);
        const float t = plii_lerp(bracket.span[0], bracket.span[1], along);
        const float value = refine_evaluate(work, pli_vec3_lerp(a, b, t));
        if (work->status != PLI_OK || !(t > 0.0f && t < 1.0f)) { break; }
        if (fabsf(value) < work->def.accuracy) { return t; }
        refine_narrow(&bracket, t, value);
    }
    if (work->def.reset_rest_lengths || work->status != PLI_OK) { return -1.0f; }
    return refine_bisect(work, a, b, bracket);
}

// -------------------------------------------------------------------------------------------------- refining

/* Bending links across the surface. */
static bool refine_removes(const plii_edit_link* link, void* user) {
    const float* values = user;
    return plii_edit_link_is_bending(link) && !(values[link->nodes[0]] * values[link->nodes[1]] > 0.0f);
}

static void refine_add_edge(refine_work* work, int a, int b) {
    if (refine_is_crossed(work, a, b)) { (void)plii_edit_add_edge(&work->edit, &work->edges, a, b); }
}

static void refine_find_edges(refine_work* work) {
    const plii_edit* edit = &work->edit;
    for (PLII_EACH(const plii_edit_link, link, edit->links, edit->link_count)) {
        refine_add_edge(work, link->nodes[0], link->nodes[1]);
    }
    for (PLII_EACH(const plii_edit_face, face, edit->faces, edit->face_count)) {
        for (int k = 0; k < 3; ++k) {
            refine_add_edge(work, face->nodes[k], face->nodes[(k + 1) % 3]);
        }
    }
}

static bool refine_crosses_tetra(const int nodes[4], const void* work) {
    for (int k = 0; k < 4; ++k) {
        for (int j = 0; j < k; ++j) {
            if (refine_is_crossed(work, nodes[j], nodes[k])) { return true; }
        }
    }
    return false;
}

/* New nodes on the edges, in the order of their ends. */
static void refine_add_nodes(refine_work* work) {
    plii_edge_map* edges = &work->edges;
    const int* order = plii_edge_map_order(edges, work->edit.node_count, &work->edit.scratch);
    for (int i = 0; order != NULL && i < edges->count; ++i) {
        plii_edge* edge = &edges->edges[order[i]];
        const float t = refine_solve(work, edge->a, edge->b);
        if (work->status != PLI_OK) { return; }
        if (!(t > 0.0f)) { continue; }
        edge->share = t;
        edge->node = plii_edit_add_node(&work->edit, edge->a, edge->b, t);
    }
}

// --------------------------------------------------------------------------------------------- Bullet's cutting

/* A node on the surface is new, or near enough to it. */
static bool refine_is_on_surface(const refine_work* work, int node) {
    return node >= work->edit.old_node_count || fabsf(work->values[node]) < work->def.accuracy;
}

static void refine_replace(int* nodes, int count, const int* copies) {
    for (int k = 0; k < count; ++k) {
        if (copies[nodes[k]] != 0) { nodes[k] = copies[nodes[k]]; }
    }
}

/* Nodes on the surface get a copy for the inside; with `sides` only those with something on both. 0 stands for none. */
static void refine_copy_nodes(refine_work* work, const uint8_t* sides, int* copies, int node_count) {
    for (int i = 0; i < node_count; ++i) {
        if (!refine_is_on_surface(work, i)) { continue; }
        if (sides != NULL && sides[i] != (REFINE_INSIDE | REFINE_OUTSIDE)) { continue; }
        copies[i] = plii_edit_copy_node(&work->edit, i);
    }
}

/* Both, of a link whose ends have copies. */
static unsigned refine_side_as_reference(const refine_work* work, const int* copies, const int* nodes, int count) {
    bool is_inside = true, is_doubled = count == 2;
    for (int k = 0; k < count; ++k) {
        is_inside = is_inside && (refine_is_on_surface(work, nodes[k]) || work->values[nodes[k]] < 0.0f);
        is_doubled = is_doubled && copies[nodes[k]] != 0;
    }
    return is_doubled ? REFINE_INSIDE | REFINE_OUTSIDE : is_inside ? REFINE_INSIDE : REFINE_OUTSIDE;
}

/* An end that nothing else has; `user` counts what is at each node. */
static bool refine_is_loose(const plii_edit_link* link, void* user) {
    int *a = (int*)user + link->nodes[0], *b = (int*)user + link->nodes[1];
    const bool is_loose = *a == 1 || *b == 1;
    *a -= is_loose;
    *b -= is_loose;
    return is_loose;
}

static void refine_remove_loose_links(refine_work* work) {
    plii_edit* edit = &work->edit;
    int* ranks = PLII_TAKE(&edit->scratch, int, edit->node_count);
    if (ranks == NULL) { return; }
    for (int i = 0; i < edit->link_count; ++i) {
        ++ranks[edit->links[i].nodes[0]];
        ++ranks[edit->links[i].nodes[1]];
    }
    for (int i = 0; i < edit->face_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            ++ranks[edit->faces[i].nodes[k]];
        }
    }
    plii_edit_remove_links(edit, refine_is_loose, ranks);
}

// ------------------------------------------------------------------------------------------------ mended cutting

/* The side of an element by its first node that is not on the surface; inside when all are. */
static unsigned refine_side(const refine_work* work, const int* nodes, int count) {
    for (int k = 0; k < count; ++k) {
        if (!refine_is_on_surface(work, nodes[k])) {
            return work->values[nodes[k]] < 0.0f ? REFINE_INSIDE : REFINE_OUTSIDE;
        }
    }
    return REFINE_INSIDE;
}

/* Notes the sides of the faces along each edge that lies on the surface. */
static void refine_find_borders(refine_work* work, plii_edge_map* borders) {
    for (int i = 0; i < work->edit.face_count; ++i) {
        const int* nodes = work->edit.faces[i].nodes;
        const unsigned side = refine_side(work, nodes, 3);
        for (int j = 2, k = 0; k < 3; j = k++) {
            if (!refine_is_on_surface(work, nodes[j]) || !refine_is_on_surface(work, nodes[k])) { continue; }
            plii_edit_add_edge(&work->edit, borders, nodes[j], nodes[k])->flags |= side;
        }
    }
}

/* A link on the surface belongs to the sides of its faces, and to the outside when it has none. */
static unsigned refine_link_side(const refine_work* work, const plii_edge_map* borders, const plii_edit_link* link) {
    const bool is_on_surface = refine_is_on_surface(work, link->nodes[0]) && refine_is_on_surface(work, link->nodes[1]);
    if (!is_on_surface) { return refine_side(work, link->nodes, 2); }
    const plii_edge* border = plii_edge_map_find(borders, link->nodes[0], link->nodes[1]);
    return border != NULL ? border->flags : REFINE_OUTSIDE;
}

static void refine_mark_sides(const int* nodes, int count, unsigned side, uint8_t* sides) {
    for (int k = 0; k < count; ++k) {
        sides[nodes[k]] = (uint8_t)(sides[nodes[k]] | side);
    }
}

static void refine_find_sides(const refine_work* work, const plii_edge_map* borders, uint8_t* sides) {
    const plii_edit* edit = &work->edit;
    for (PLII_EACH(const plii_edit_link, link, edit->links, edit->link_count)) {
        refine_mark_sides(link->nodes, 2, refine_link_side(work, borders, link), sides);
    }
    for (PLII_EACH(const plii_edit_face, face, edit->faces, edit->face_count)) {
        refine_mark_sides(face->nodes, 3, refine_side(work, face->nodes, 3), sides);
    }
}

/* Without `borders` as in Bullet. */
static void refine_detach(refine_work* work, const plii_edge_map* borders, const int* copies) {
    plii_edit* edit = &work->edit;
    const int link_count = edit->link_count;
    for (int i = 0; i < link_count; ++i) {
        plii_edit_link inner = edit->links[i];
        const unsigned side = borders != NULL ? refine_link_side(work, borders, &inner)
                                              : refine_side_as_reference(work, copies, inner.nodes, 2);
        const bool is_kept = borders == NULL && i == 0 && side == REFINE_INSIDE; /* never link 0 */
        if ((side & REFINE_INSIDE) == 0 || is_kept) { continue; }
        refine_replace(inner.nodes, 2, copies);
        if ((side & REFINE_OUTSIDE) != 0) {
            plii_edit_add_link(edit, inner);
        } else {
            edit->links[i] = inner;
        }
    }
    for (PLII_EACH(plii_edit_face, face, edit->faces, edit->face_count)) {
        const unsigned side = borders != NULL ? refine_side(work, face->nodes, 3)
                                              : refine_side_as_reference(work, copies, face->nodes, 3);
        if (side == REFINE_INSIDE) { refine_replace(face->nodes, 3, copies); }
    }
}

static void refine_part(refine_work* work, int* copies, int node_count) {
    plii_edge_map borders = {.table.context = work->edit.context};
    uint8_t* sides = PLII_TAKE(&work->edit.scratch, uint8_t, node_count);
    if (sides == NULL) { return; }
    refine_find_borders(work, &borders);
    refine_find_sides(work, &borders, sides);
    refine_copy_nodes(work, sides, copies, node_count);
    refine_detach(work, &borders, copies);
    plii_edge_map_free(&borders);
}

// ------------------------------------------------------------------------------------------------ the whole

static bool refine_touches_tetra(const int nodes[4], const void* user) {
    const int* copies = user;
    return copies[nodes[0]] != 0 || copies[nodes[1]] != 0 || copies[nodes[2]] != 0 || copies[nodes[3]] != 0;
}

static pli_status refine_cut(refine_work* work) {
    const int node_count = work->edit.node_count;
    int* copies = PLII_TAKE(&work->edit.scratch, int, node_count);
    if (copies == NULL) { return PLI_ERROR_OUT_OF_MEMORY; }
    if (work->def.reset_rest_lengths) {
        refine_copy_nodes(work, NULL, copies, node_count);
        refine_detach(work, NULL, copies);
        refine_remove_loose_links(work);
    } else {
        refine_part(work, copies, node_count);
    }
    return plii_edit_check_tetras(&work->edit, refine_touches_tetra, copies, "the surface touches");
}

/* Errors but the lack of memory have given their message. */
static pli_status refine_run(refine_work* work) {
    plii_edit* edit = &work->edit;
    work->values = PLII_TAKE(&edit->scratch, float, edit->node_count);
    if (work->values == NULL) { return PLI_ERROR_OUT_OF_MEMORY; }
    for (int i = 0; i < edit->old_node_count && work->status == PLI_OK; ++i) {
        work->values[i] = refine_evaluate(work, plii_edit_position(edit, i));
    }
    PLII_TRY(work->status);
    PLII_TRY(plii_edit_check_tetras(edit, refine_crosses_tetra, work, "the surface crosses"));
    plii_edit_remove_links(edit, refine_removes, work->values);
    refine_find_edges(work);
    refine_add_nodes(work);
    PLII_TRY(work->status);
    if (edit->scratch.is_short) { return PLI_ERROR_OUT_OF_MEMORY; } /* nodes are missing */
    plii_edit_split(edit, &work->edges);
    return work->def.cut ? refine_cut(work) : PLI_OK;
}

pli_status pli_body_refine(pli_body* body, const pli_refine_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    pli_context* context = body->context;
    PLII_TRY(PLII_CHECK_MADE(context, pli_refine_def, def, __func__));
    if (def->surface == NULL) { return PLII_FAIL(context, PLI_ERROR_NULL_ARGUMENT, "def->surface is null"); }
    PLII_TRY(plii_check_between(context, def->accuracy, PLII_ABOVE_0, FLT_MAX, "accuracy", __func__));
    refine_work work = {.def = *def, .edges.table.context = context};
    PLII_TRY(plii_edit_open(body, __func__, &work.edit));
    work.edit.takes_rest_shape = def->reset_rest_lengths;
    const pli_status status = refine_run(&work);
    plii_edge_map_free(&work.edges);
    return plii_body_changed(body, plii_edit_end(&work.edit, status));
}
