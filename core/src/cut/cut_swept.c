/* Cutting along the surface that a ray sweeps, as a mouse does between two frames.

   The surface is one triangle or two, each a plane blade with an outline. Edges that a blade crosses get a node there,
   or, near one of their ends, use that end. Faces that a blade crosses from edge to edge are parted along it, and the
   surface is opened along these new edges. A face in which a blade ends is only refined: its node stays closed, as the
   tip of the cut. A single edge between two tips stays closed too. Both are kept with the body. A sweep that goes on
   where the last one ended opens its first face up to the tip at it, so many short sweeps make one cut, and a cut that
   returns to its start closes. Where the body has moved meanwhile, so that the ray has left the faces at that tip, the
   cut first goes from the tip to the ray. */

#include "body/pipeline.h"
#include "cut/topology_edit.h"
#include "math/bounds.h"
#include "math/dvec3.h"
#include "pliant/cut.h"

/* A crossing nearer to the end of an edge than this share of it uses the end. */
#define SWEPT_SNAP 0.05
/* Marks of nodes, */
enum { SWEPT_ON_BLADE = 1, SWEPT_HAS_FACE = 2, SWEPT_IS_TIP = 4, SWEPT_BELOW = 8, SWEPT_ABOVE = 16 };
/* and flags of edges. */
enum { SWEPT_OF_FACE = 1, SWEPT_CROSSED = 2 };
/* Flags of borders. */
enum { SWEPT_FACE_BELOW = 4, SWEPT_FACE_ABOVE = 8 };
/* A ray goes on from another when its ends are as near as this share of its length. */
#define SWEPT_SAME_RAY 1e-4f

/* What a cut has not opened yet. */
typedef struct swept_tip {
    int node, face; /* not parted; at it, with the last ray in it, or none */
} swept_tip;

typedef struct swept_ends {
    swept_tip* tips;
    int tip_count, tip_capacity;
    int (*edges)[2]; /* of the cut, between tips */
    int edge_count, edge_capacity;
} swept_ends;

// ----------------------------------------------------------------------------------------------------------- the blade

/* In double: blades are long and thin. */
typedef struct swept_blade {
    plii_dvec3 corners[3];
    plii_dvec3 normal;
    plii_dvec3 inward[3]; /* of the side from corner k to the next */
} swept_blade;

static plii_dvec3 swept_unit(plii_dvec3 a) {
    const double length = plii_dvec3_length(a);
    return plii_dvec3_make(a.x / length, a.y / length, a.z / length);
}

/* False when the triangle has no area. */
static bool swept_make_blade(const pli_vec3 corners[3], swept_blade* blade) {
    for (int k = 0; k < 3; ++k) {
        blade->corners[k] = plii_dvec3_from(corners[k]);
    }
    const plii_dvec3 ab = plii_dvec3_sub(blade->corners[1], blade->corners[0]);
    const plii_dvec3 ac = plii_dvec3_sub(blade->corners[2], blade->corners[0]);
    const plii_dvec3 cross = plii_dvec3_cross(ab, ac);
    const double longest = plii_dvec3_dot(ab, ab) + plii_dvec3_dot(ac, ac);
    if (!(plii_dvec3_length(cross) > 1e-12 * longest)) { return false; }
    blade->normal = swept_unit(cross);
    for (int k = 0; k < 3; ++k) {
        const plii_dvec3 side = plii_dvec3_sub(blade->corners[(k + 1) % 3], blade->corners[k]);
        blade->inward[k] = swept_unit(plii_dvec3_cross(blade->normal, side));
    }
    return true;
}

/* Whether a point of the blade's plane is inside of its outline, which is part of it. */
static bool swept_is_inside(const swept_blade* blade, plii_dvec3 point) {
    for (int k = 0; k < 3; ++k) {
        if (plii_dvec3_dot(blade->inward[k], plii_dvec3_sub(point, blade->corners[k])) < -1e-9) { return false; }
    }
    return true;
}

/* A sweep, and one of its blades on the present state of the edit. */
typedef struct swept_pass {
    plii_edit edit;
    swept_ends ends; /* of the sweep so far */
    int parted;      /* links */
    /* Of the blade. */
    swept_blade blade;
    int node_count;        /* before the pass */
    double* heights;       /* [node_count] over the blade's plane */
    uint8_t* marks;        /* [node_count] */
    plii_edge_map edges;   /* that the blade meets, and those around */
    plii_edge_map borders; /* between two nodes on the blade */
    plii_edge_map cuts;    /* to be opened */
} swept_pass;

static plii_dvec3 swept_point(const swept_pass* pass, int node) {
    return plii_dvec3_from(plii_edit_position(&pass->edit, node));
}
static bool swept_is(const swept_pass* pass, unsigned mark, int node) {
    return node < pass->node_count && (pass->marks[node] & mark) != 0;
}
static void swept_mark(const swept_pass* pass, int node, unsigned mark) {
    pass->marks[node] = (uint8_t)(pass->marks[node] | mark);
}

/* Where the blade's plane crosses an edge, as a share from a to b; negative when it does not inside of the blade. */
static double swept_crossing(const swept_pass* pass, int a, int b) {
    const double height_a = pass->heights[a], height_b = pass->heights[b];
    if ((height_a > 0.0 && height_b > 0.0) || (height_a < 0.0 && height_b < 0.0) || height_a == height_b) {
        return -1.0;
    }
    const double t = height_a / (height_a - height_b);
    const plii_dvec3 start = swept_point(pass, a), edge = plii_dvec3_sub(swept_point(pass, b), start);
    return swept_is_inside(&pass->blade, plii_dvec3_add_scaled(start, edge, t)) ? t : -1.0;
}

// --------------------------------------------------------------------------------------------------------- what is met

static void swept_meet_edge(swept_pass* pass, int end_a, int end_b, unsigned flags) {
    const int a = end_a < end_b ? end_a : end_b, b = end_a < end_b ? end_b : end_a;
    if (pass->heights[a] == 0.0 && pass->heights[b] == 0.0) { /* in the plane */
        if (swept_is_inside(&pass->blade, swept_point(pass, a))) { swept_mark(pass, a, SWEPT_ON_BLADE); }
        if (swept_is_inside(&pass->blade, swept_point(pass, b))) { swept_mark(pass, b, SWEPT_ON_BLADE); }
        return;
    }
    const double t = swept_crossing(pass, a, b);
    if (t < 0.0) { return; }
    if (t <= SWEPT_SNAP || t >= 1.0 - SWEPT_SNAP) {
        swept_mark(pass, t <= SWEPT_SNAP ? a : b, SWEPT_ON_BLADE);
        return;
    }
    plii_edge* edge = plii_edit_add_edge(&pass->edit, &pass->edges, a, b);
    edge->share = (float)t;
    edge->flags |= flags | SWEPT_CROSSED;
}

static void swept_find_edges(swept_pass* pass) {
    const plii_edit* edit = &pass->edit;
    for (PLII_EACH(const plii_edit_link, link, edit->links, edit->link_count)) {
        if (!plii_edit_link_is_bending(link)) { swept_meet_edge(pass, link->nodes[0], link->nodes[1], 0); }
    }
    for (PLII_EACH(const plii_edit_face, face, edit->faces, edit->face_count)) {
        for (int j = 2, k = 0; k < 3; j = k++) {
            swept_mark(pass, face->nodes[k], SWEPT_HAS_FACE);
            swept_meet_edge(pass, face->nodes[j], face->nodes[k], SWEPT_OF_FACE);
        }
    }
    /* An edge with an end on the blade is met there. */
    for (PLII_EACH(plii_edge, edge, pass->edges.edges, pass->edges.count)) {
        if (swept_is(pass, SWEPT_ON_BLADE, edge->a) || swept_is(pass, SWEPT_ON_BLADE, edge->b)) { edge->flags = 0; }
    }
}

static bool swept_meets_something(const swept_pass* pass) {
    bool meets = pass->edges.count > 0;
    for (int i = 0; i < pass->node_count; ++i) {
        meets = meets || swept_is(pass, SWEPT_ON_BLADE, i);
    }
    return meets;
}

static bool swept_meets_tetra(const int nodes[4], const void* user) {
    const swept_pass* pass = user;
    for (int j = 0; j < 4; ++j) {
        if (swept_is(pass, SWEPT_ON_BLADE, nodes[j])) { return true; }
        for (int k = j + 1; k < 4; ++k) {
            const plii_edge* edge = plii_edge_map_find(&pass->edges, nodes[j], nodes[k]);
            if (edge != NULL && (edge->flags & SWEPT_CROSSED) != 0) { return true; }
        }
    }
    return false;
}

// ------------------------------------------------------------------------------------------------- links without faces

/* The edge of a link that the blade crosses away from faces, or NULL. */
static plii_edge* swept_crossed_edge(const swept_pass* pass, int a, int b) {
    plii_edge* edge = plii_edge_map_find(&pass->edges, a, b);
    return edge != NULL && edge->flags == SWEPT_CROSSED ? edge : NULL;
}

static bool swept_removes(const plii_edit_link* link, void* user) {
    const swept_pass* pass = user;
    const int a = link->nodes[0], b = link->nodes[1];
    if (plii_edit_link_is_bending(link)) {
        return !swept_is(pass, SWEPT_ON_BLADE, a) && !swept_is(pass, SWEPT_ON_BLADE, b) &&
               swept_crossing(pass, a, b) >= 0.0;
    }
    return (pass->marks[a] & pass->marks[b] & SWEPT_HAS_FACE) != 0 && swept_crossed_edge(pass, a, b) != NULL;
}

static void swept_part_rope_links(swept_pass* pass) {
    plii_edit* edit = &pass->edit;
    const int count = edit->link_count;
    for (int i = 0; i < count; ++i) {
        plii_edge* edge = swept_crossed_edge(pass, edit->links[i].nodes[0], edit->links[i].nodes[1]);
        if (edge == NULL) { continue; }
        if (edge->first == PLI_NULL_INDEX) {
            edge->first = plii_edit_add_node(edit, edge->a, edge->b, edge->share);
            (void)plii_edit_copy_node(edit, edge->first);
        }
        plii_edit_split_link(edit, i, edge->a, edge->share, edge->first, edge->first + 1);
        pass->parted += 1;
    }
}

static int swept_rope_side(const swept_pass* pass, int other) {
    const double height = other < pass->node_count ? pass->heights[other] : 0.0;
    return height > 0.0 ? SWEPT_ABOVE : height < 0.0 ? SWEPT_BELOW : 0;
}

static void swept_part_rope_nodes(swept_pass* pass) {
    plii_edit* edit = &pass->edit;
    for (PLII_EACH(const plii_edit_link, link, edit->links, edit->link_count)) {
        for (int k = 0; k < 2; ++k) {
            if (!swept_is(pass, SWEPT_ON_BLADE, link->nodes[k])) { continue; }
            swept_mark(pass, link->nodes[k], (unsigned)swept_rope_side(pass, link->nodes[1 - k]));
        }
    }
    /* Copies of the nodes, by node; 0 is none, since copies come last. */
    int* copies = PLII_TAKE(&edit->scratch, int, pass->node_count);
    for (int i = 0; copies != NULL && i < pass->node_count; ++i) {
        const unsigned marks = pass->marks[i], both = SWEPT_BELOW | SWEPT_ABOVE;
        if ((marks & (SWEPT_ON_BLADE | SWEPT_HAS_FACE)) != SWEPT_ON_BLADE || (marks & both) != both) { continue; }
        copies[i] = plii_edit_copy_node(edit, i);
        pass->parted += 1;
    }
    for (int i = 0; copies != NULL && i < edit->link_count; ++i) {
        const int nodes[2] = {edit->links[i].nodes[0], edit->links[i].nodes[1]};
        for (int k = 0; k < 2; ++k) {
            if (nodes[k] < pass->node_count && copies[nodes[k]] != 0 &&
                swept_rope_side(pass, nodes[1 - k]) == SWEPT_BELOW) {
                edit->links[i].nodes[k] = copies[nodes[k]];
            }
        }
    }
}

// --------------------------------------------------------------------------------------------------------------- faces

static void swept_add_nodes(swept_pass* pass) {
    plii_edge_map* edges = &pass->edges;
    const int* order = plii_edge_map_order(edges, pass->node_count, &pass->edit.scratch);
    for (int i = 0; order != NULL && i < edges->count; ++i) {
        plii_edge* edge = &edges->edges[order[i]];
        if (edge->flags != (SWEPT_OF_FACE | SWEPT_CROSSED)) { continue; }
        edge->node = plii_edit_add_node(&pass->edit, edge->a, edge->b, edge->share);
    }
}

static void swept_open(swept_pass* pass, int a, int b) {
    (void)plii_edit_add_edge(&pass->edit, &pass->cuts, a, b);
}

static void swept_open_closed_edges(swept_pass* pass) {
    const swept_ends* ends = &pass->ends;
    for (int i = 0; i < ends->edge_count; ++i) {
        const int a = ends->edges[i][0], b = ends->edges[i][1];
        const int node = plii_edge_map_node(&pass->edges, a, b);
        swept_open(pass, a, node != PLI_NULL_INDEX ? node : b);
        if (node != PLI_NULL_INDEX) { swept_open(pass, node, b); }
    }
}

/* Which edges of one face will be opened. */
static void swept_judge_face(swept_pass* pass, const int* nodes) {
    int crossings[3], crossing_count = 0, crossed = 0; /* `crossed`: an edge, from the corner to the next */
    int on_count = 0, on = 0, tip = PLI_NULL_INDEX;
    for (int k = 0; k < 3; ++k) {
        const int node = plii_edge_map_node(&pass->edges, nodes[k], nodes[(k + 1) % 3]);
        if (node != PLI_NULL_INDEX) {
            crossings[crossing_count++] = node;
            crossed = k;
        }
        if (swept_is(pass, SWEPT_ON_BLADE, nodes[k])) {
            ++on_count;
            on = nodes[k];
        } else if (swept_is(pass, SWEPT_IS_TIP, nodes[k])) {
            tip = nodes[k];
        }
    }
    if (crossing_count == 2) { swept_open(pass, crossings[0], crossings[1]); }
    if (crossing_count == 1) {
        const int first = nodes[crossed], second = nodes[(crossed + 1) % 3], opposite = nodes[(crossed + 2) % 3];
        if (swept_is(pass, SWEPT_ON_BLADE, opposite) || swept_is(pass, SWEPT_IS_TIP, opposite)) {
            swept_open(pass, crossings[0], opposite);
        } else if (swept_is(pass, SWEPT_IS_TIP, first) || swept_is(pass, SWEPT_IS_TIP, second)) {
            swept_open(pass, crossings[0], swept_is(pass, SWEPT_IS_TIP, first) ? first : second);
        }
    }
    if (crossing_count == 0 && on_count == 1 && tip != PLI_NULL_INDEX) { swept_open(pass, on, tip); }
    if (crossing_count > 0 || on_count < 2) { return; }
    for (int k = 0; k < 3; ++k) {
        const int a = nodes[k], b = nodes[(k + 1) % 3];
        if (!swept_is(pass, SWEPT_ON_BLADE, a) || !swept_is(pass, SWEPT_ON_BLADE, b)) { continue; }
        /* A face with all nodes on the blade counts as above. */
        const bool is_below = on_count == 2 && pass->heights[nodes[(k + 2) % 3]] < 0.0;
        plii_edge* border = plii_edit_add_edge(&pass->edit, &pass->borders, a, b);
        border->flags |= is_below ? SWEPT_FACE_BELOW : SWEPT_FACE_ABOVE;
    }
}

static void swept_judge_faces(swept_pass* pass) {
    for (int i = 0; i < pass->edit.face_count; ++i) {
        swept_judge_face(pass, pass->edit.faces[i].nodes);
    }
    /* An edge between two nodes on the blade is opened when it has faces on both sides of the plane. */
    for (PLII_EACH(const plii_edge, border, pass->borders.edges, pass->borders.count)) {
        if (border->flags == (SWEPT_FACE_BELOW | SWEPT_FACE_ABOVE)) { swept_open(pass, border->a, border->b); }
    }
}

// ---------------------------------------------------------------------------------------------------------------- tips

/* Tips are the nodes of the cut that are still closed. */
static void swept_find_tips(swept_pass* pass, const uint8_t* is_parted, int node_count) {
    swept_ends* ends = &pass->ends;
    PLII_REMOVE_IF(swept_tip, tip, ends->tips, ends->tip_count, is_parted[tip->node] != 0);
    for (int i = 0; i < node_count; ++i) {
        const unsigned marks = i < pass->node_count ? pass->marks[i] : SWEPT_ON_BLADE | SWEPT_HAS_FACE;
        const bool is_on_surface = (marks & (SWEPT_ON_BLADE | SWEPT_HAS_FACE)) == (SWEPT_ON_BLADE | SWEPT_HAS_FACE);
        if (!is_on_surface || is_parted[i] != 0 || (marks & SWEPT_IS_TIP) != 0) { continue; }
        if (!PLII_EDIT_GROW(&pass->edit, &ends->tips, &ends->tip_capacity, ends->tip_count)) { return; }
        ends->tips[ends->tip_count++].node = i;
    }
}

/* An edge is open when one of its ends is parted. */
static void swept_find_closed_edges(swept_pass* pass, const uint8_t* is_parted) {
    swept_ends* ends = &pass->ends;
    ends->edge_count = 0;
    for (PLII_EACH(const plii_edge, edge, pass->cuts.edges, pass->cuts.count)) {
        if (is_parted[edge->a] != 0 || is_parted[edge->b] != 0) { continue; }
        if (!PLII_EDIT_GROW(&pass->edit, &ends->edges, &ends->edge_capacity, ends->edge_count)) { return; }
        ends->edges[ends->edge_count][0] = edge->a;
        ends->edges[ends->edge_count++][1] = edge->b;
    }
}

static void swept_separate(swept_pass* pass) {
    const int node_count = pass->edit.node_count;
    uint8_t* is_parted = PLII_TAKE(&pass->edit.scratch, uint8_t, node_count);
    if (is_parted == NULL) { return; }
    plii_cut_separate(&pass->edit, &pass->cuts, pass->heights, pass->node_count, is_parted, &pass->parted);
    swept_find_tips(pass, is_parted, node_count);
    swept_find_closed_edges(pass, is_parted);
}

// ----------------------------------------------------------------------------------------------------------- the whole

static pli_status swept_run_pass(swept_pass* pass) {
    plii_edit* edit = &pass->edit;
    for (int i = 0; i < pass->node_count; ++i) {
        const plii_dvec3 offset = plii_dvec3_sub(swept_point(pass, i), pass->blade.corners[0]);
        pass->heights[i] = plii_dvec3_dot(pass->blade.normal, offset);
    }
    for (int i = 0; i < pass->ends.tip_count; ++i) {
        swept_mark(pass, pass->ends.tips[i].node, SWEPT_IS_TIP);
    }
    swept_find_edges(pass);
    PLII_TRY(plii_edit_check_tetras(edit, swept_meets_tetra, pass, "the blade meets"));
    const int link_count = edit->link_count;
    plii_edit_remove_links(edit, swept_removes, pass); /* also those over the inside of a face */
    pass->parted += link_count - edit->link_count;
    if (!swept_meets_something(pass)) { return PLI_OK; }
    swept_part_rope_links(pass);
    swept_part_rope_nodes(pass);
    swept_add_nodes(pass);
    if (edit->scratch.is_short) { return PLI_ERROR_OUT_OF_MEMORY; } /* links may name nodes that are not there */
    swept_judge_faces(pass);
    swept_open_closed_edges(pass);
    for (PLII_EACH(const plii_edit_link, link, edit->links, edit->link_count)) {
        pass->parted += plii_edge_map_node(&pass->edges, link->nodes[0], link->nodes[1]) != PLI_NULL_INDEX;
    }
    plii_edit_split(edit, &pass->edges);
    swept_separate(pass);
    return PLI_OK;
}

/* Cuts by one triangle. PLI_ERROR_OUT_OF_MEMORY has no message yet. */
static pli_status swept_cut(swept_pass* pass, const pli_vec3 corners[3]) {
    if (!swept_make_blade(corners, &pass->blade)) { return PLI_OK; }
    plii_scratch* scratch = &pass->edit.scratch;
    pass->node_count = pass->edit.node_count;
    pass->edges = pass->borders = pass->cuts = (plii_edge_map){.table.context = pass->edit.context};
    pass->heights = PLII_TAKE(scratch, double, pass->node_count);
    pass->marks = PLII_TAKE(scratch, uint8_t, pass->node_count);
    const pli_status status = scratch->is_short ? PLI_ERROR_OUT_OF_MEMORY : swept_run_pass(pass);
    plii_scratch_free(scratch);
    plii_edge_map_free(&pass->edges);
    plii_edge_map_free(&pass->borders);
    plii_edge_map_free(&pass->cuts);
    return status;
}

// ----------------------------------------------------------------------------------------------------------- the trace

typedef struct trace_state {
    bool has_ray;
    pli_vec3 ray[2]; /* the last ray of the last sweep */
    swept_ends ends;
} trace_state;

static bool trace_copy_ends(pli_context* context, const swept_ends* from, swept_ends* to) {
    *to = *from;
    to->tips = plii_duplicate(context, from->tips, (size_t)from->tip_capacity * sizeof *to->tips);
    to->edges = plii_duplicate(context, from->edges, (size_t)from->edge_capacity * sizeof *to->edges);
    return (to->tips != NULL || from->tip_capacity == 0) && (to->edges != NULL || from->edge_capacity == 0);
}

/* A cut of another kind ends the sweep; a swept cut sets its ends after this. */
static void trace_forget(pli_body* body, void* state) {
    trace_state* trace = state;
    trace->has_ray = false;
    trace->ends.tip_count = trace->ends.edge_count = 0;
}

const plii_feature_class plii_trace_class = {
    .name = "cut trace",
    .is_made_by_calls = true, /* by one that meets nothing, too */
    .state_size = sizeof(trace_state),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_SPAN(trace_state, has_ray, ray, PLII_SAVED, "B6f")),
    .arrays = PLII_ARRAYS(
        {PLII_COUNTED_LIST(trace_state, ends.tips, ends.tip_capacity, ends.tip_count), PLII_SAVED_AS("ni")},
        {PLII_COUNTED_LIST(trace_state, ends.edges, ends.edge_capacity, ends.edge_count), PLII_SAVED_AS("2n")}),
    .build = trace_forget,
};

/* Blades that pass the body by are not worth a copy of it. */
static bool swept_may_meet(const pli_body* body, const pli_vec3* corners) {
    return plii_bounds_overlap(plii_bounds_of_triangle(corners[0], corners[1], corners[2]), body->bounds);
}

static bool swept_is_in_face(const plii_edit* edit, int face, const pli_vec3 ray[2]) {
    const int* nodes = edit->faces[face].nodes;
    const pli_vec3 corners[3] = {plii_edit_position(edit, nodes[0]), plii_edit_position(edit, nodes[1]),
                                 plii_edit_position(edit, nodes[2])};
    swept_blade blade; /* the face */
    if (!swept_make_blade(corners, &blade)) { return false; }
    const plii_dvec3 start = plii_dvec3_from(ray[0]), way = plii_dvec3_sub(plii_dvec3_from(ray[1]), start);
    const plii_dvec3 height = plii_dvec3_sub(blade.corners[0], start);
    const double t = plii_dvec3_dot(blade.normal, height) / plii_dvec3_dot(blade.normal, way);
    return t >= 0.0 && t <= 1.0 && swept_is_inside(&blade, plii_dvec3_add_scaled(start, way, t));
}

/* Moves the first of two rays to a tip that has left it, unless the tip is past the second one, or farther away than
   the ray is long: then the body was put elsewhere. */
static void swept_catch_up(const swept_pass* pass, pli_vec3 rays[4]) {
    const pli_vec3 way = pli_vec3_sub(rays[1], rays[0]);
    for (int i = 0; i < pass->ends.tip_count; ++i) {
        const int face = pass->ends.tips[i].face;
        if (face < 0 || face >= pass->edit.face_count || swept_is_in_face(&pass->edit, face, rays)) { continue; }
        const pli_vec3 tip = plii_edit_position(&pass->edit, pass->ends.tips[i].node), arm = pli_vec3_sub(tip, rays[0]);
        const float share = pli_vec3_dot(arm, way) / pli_vec3_length_squared(way);
        const pli_vec3 foot = pli_vec3_lerp(rays[0], rays[1], share), shift = pli_vec3_sub(tip, foot);
        const pli_vec3 sweep = pli_vec3_sub(pli_vec3_lerp(rays[2], rays[3], share), foot);
        if (pli_vec3_length(shift) > pli_vec3_length(way) || pli_vec3_dot(pli_vec3_sub(sweep, shift), sweep) <= 0.0f) {
            continue;
        }
        rays[0] = pli_vec3_add(rays[0], shift);
        rays[1] = pli_vec3_add(rays[1], shift);
        return;
    }
}

static pli_status swept_cut_all(swept_pass* pass, pli_vec3 rays[4]) {
    plii_edit* edit = &pass->edit;
    swept_ends* ends = &pass->ends;
    swept_catch_up(pass, rays);
    const pli_vec3 corners[2][3] = {{rays[0], rays[1], rays[3]}, {rays[0], rays[3], rays[2]}};
    for (int i = 0; i < 2; ++i) {
        if (swept_may_meet(edit->body, corners[i])) { PLII_TRY(swept_cut(pass, corners[i])); }
    }
    for (int i = 0; i < ends->tip_count; ++i) {
        ends->tips[i].face = PLI_NULL_INDEX;
        for (int face = 0; face < edit->face_count; ++face) {
            const int *nodes = edit->faces[face].nodes, tip = ends->tips[i].node;
            const bool is_at_tip = nodes[0] == tip || nodes[1] == tip || nodes[2] == tip;
            if (is_at_tip && swept_is_in_face(edit, face, rays + 2)) { ends->tips[i].face = face; }
        }
    }
    edit->is_unchanged = edit->node_count == edit->old_node_count && edit->link_count == edit->old_link_count;
    return PLI_OK;
}

/* Cuts and leaves the ends of the cut in `trace`. */
static pli_status swept_run(pli_body* body, trace_state* trace, pli_vec3 rays[4], bool goes_on, const char* function,
                            int* parted) {
    swept_pass pass = {.parted = 0};
    PLII_TRY(plii_edit_open(body, function, &pass.edit));
    const bool is_ready = !goes_on || trace_copy_ends(body->context, &trace->ends, &pass.ends);
    const pli_status status =
        plii_edit_end(&pass.edit, is_ready ? swept_cut_all(&pass, rays) : PLI_ERROR_OUT_OF_MEMORY);
    if (status == PLI_OK) {
        *parted = pass.parted;
        PLII_SWAP(swept_ends, trace->ends, pass.ends);
    }
    PLII_RELEASE(body->context, pass.ends.tips, pass.ends.tip_capacity);
    PLII_RELEASE(body->context, pass.ends.edges, pass.ends.edge_capacity);
    return status;
}

pli_status pli_body_cut_swept(pli_body* body, pli_vec3 from_start, pli_vec3 from_end, pli_vec3 to_start,
                              pli_vec3 to_end, int* parted) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    pli_vec3 rays[4] = {from_start, from_end, to_start, to_end};
    PLII_TRY(plii_check_finite_points(body->context, 4, rays, "end", __func__));
    PLII_TRY_ENABLE(body, trace_state, trace, plii_trace_class);
    const float reach = SWEPT_SAME_RAY * pli_vec3_length(pli_vec3_sub(from_end, from_start));
    const bool goes_on = trace->has_ray && pli_vec3_length(pli_vec3_sub(from_start, trace->ray[0])) <= reach &&
                         pli_vec3_length(pli_vec3_sub(from_end, trace->ray[1])) <= reach;
    const pli_vec3 corners[2][3] = {{from_start, from_end, to_end}, {from_start, to_end, to_start}};
    int count = 0;
    if (swept_may_meet(body, corners[0]) || swept_may_meet(body, corners[1])) {
        const pli_status status = swept_run(body, trace, rays, goes_on, __func__, &count);
        if (status != PLI_OK) {
            plii_feature_undo(body, &plii_trace_class);
            return status;
        }
    } else if (!goes_on) {
        trace_forget(body, trace);
    }
    trace->has_ray = true;
    trace->ray[0] = to_start;
    trace->ray[1] = to_end;
    if (parted != NULL) { *parted = count; }
    return plii_body_changed(body, PLI_OK);
}
