/* Cutting along the surface that a ray sweeps, as a mouse does between two frames.

   The surface is one triangle or two, each a plane blade with an outline. Edges that a blade crosses get a node there,
   or, near one of their ends, use that end. Faces that a blade crosses from edge to edge are parted along it, and the
   surface is opened along these new edges. A face in which a blade ends is only refined: its node stays closed, as the
   tip of the cut. A single edge between two tips stays closed too. Both are kept with the body. A sweep that goes on
   where the last one ended opens its first face up to the tip at it, so many short sweeps make one cut, and a cut that
   returns to its start closes. */

#include "body/pipeline.h"
#include "cut/cut_separate.h"
#include "math/bounds.h"
#include "math/range.h"
#include "pliant/cut.h"

#include <string.h>

/* A crossing nearer to the end of an edge than this share of it uses the end. */
#define SWEPT_SNAP 0.05
/* A ray goes on from another when its ends are as near as this share of its length. */
#define SWEPT_SAME_RAY 1e-4f

enum { SWEPT_ON_BLADE = 1, SWEPT_HAS_FACE = 2, SWEPT_IS_TIP = 4, SWEPT_BELOW = 8, SWEPT_ABOVE = 16 };
enum { SWEPT_OF_FACE = 1, SWEPT_CROSSED = 2, SWEPT_FACE_BELOW = 4, SWEPT_FACE_ABOVE = 8 };

// ------------------------------------------------------------------------------------ what lasts between sweeps

/* What a cut has not opened yet. */
typedef struct trace_ends {
    int* tips; /* nodes of the cut that are not parted */
    int tip_count, tip_capacity;
    int (*edges)[2]; /* of the cut, between tips */
    int edge_count, edge_capacity;
} trace_ends;

typedef struct trace_state {
    bool has_ray;
    pli_vec3 ray[2]; /* the last ray of the last sweep */
    trace_ends ends;
} trace_state;

static void trace_release_ends(pli_context* context, trace_ends* ends) {
    plii_release(context, ends->tips, (size_t)ends->tip_capacity * sizeof *ends->tips);
    plii_release(context, ends->edges, (size_t)ends->edge_capacity * sizeof *ends->edges);
}

static bool trace_copy_ends(pli_context* context, const trace_ends* from, trace_ends* to) {
    if (!PLII_RESERVE(context, &to->tips, &to->tip_capacity, from->tip_count) ||
        !PLII_RESERVE(context, &to->edges, &to->edge_capacity, from->edge_count)) {
        return false;
    }
    for (int i = 0; i < from->tip_count; ++i) {
        to->tips[i] = from->tips[i];
    }
    for (int i = 0; i < from->edge_count; ++i) {
        to->edges[i][0] = from->edges[i][0];
        to->edges[i][1] = from->edges[i][1];
    }
    to->tip_count = from->tip_count;
    to->edge_count = from->edge_count;
    return true;
}

static void trace_disable(pli_body* body, void* state) {
    trace_release_ends(body->context, &((trace_state*)state)->ends);
}

static size_t trace_bytes(const pli_body* body, const void* state) {
    const trace_ends* ends = &((const trace_state*)state)->ends;
    (void)body;
    return (size_t)ends->tip_capacity * sizeof *ends->tips + (size_t)ends->edge_capacity * sizeof *ends->edges;
}

static void trace_forget(trace_state* trace) {
    trace->has_ray = false;
    trace->ends.tip_count = 0;
    trace->ends.edge_count = 0;
}

/* A cut of another kind ends the sweep; a swept cut sets its ends after this. */
static void trace_topology_commit(pli_body* body, void* state, const plii_topology_change* change, void** blocks) {
    (void)body;
    (void)change;
    (void)blocks;
    trace_forget(state);
}

static const plii_feature_class trace_class = {
    .name = "cut trace",
    .state_size = sizeof(trace_state),
    .disable = trace_disable,
    .bytes = trace_bytes,
    .topology_commit = trace_topology_commit,
};

static bool trace_ends_at(const trace_state* trace, pli_vec3 start, pli_vec3 end) {
    const float reach = SWEPT_SAME_RAY * pli_vec3_length(pli_vec3_sub(end, start));
    return trace->has_ray && pli_vec3_length(pli_vec3_sub(start, trace->ray[0])) <= reach &&
           pli_vec3_length(pli_vec3_sub(end, trace->ray[1])) <= reach;
}

// ----------------------------------------------------------------------------------------------------- the blade

typedef struct swept_vector {
    double x, y, z;
} swept_vector;

/* In double: blades are long and thin. */
typedef struct swept_blade {
    swept_vector corners[3];
    swept_vector normal;
    swept_vector inward[3]; /* of the side from corner k to the next */
} swept_blade;

static swept_vector swept_wide(pli_vec3 v) {
    return (swept_vector){(double)v.x, (double)v.y, (double)v.z};
}
static swept_vector swept_minus(swept_vector a, swept_vector b) {
    return (swept_vector){a.x - b.x, a.y - b.y, a.z - b.z};
}
static swept_vector swept_lerp(swept_vector a, swept_vector b, double t) {
    return (swept_vector){a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t};
}
static double swept_dot(swept_vector a, swept_vector b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static swept_vector swept_cross(swept_vector a, swept_vector b) {
    return (swept_vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static swept_vector swept_unit(swept_vector a) {
    const double length = sqrt(swept_dot(a, a));
    return (swept_vector){a.x / length, a.y / length, a.z / length};
}

/* False when the triangle has no area. */
static bool swept_make_blade(pli_vec3 a, pli_vec3 b, pli_vec3 c, swept_blade* blade) {
    const pli_vec3 corners[3] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
        blade->corners[k] = swept_wide(corners[k]);
    }
    const swept_vector ab = swept_minus(blade->corners[1], blade->corners[0]);
    const swept_vector ac = swept_minus(blade->corners[2], blade->corners[0]);
    const swept_vector cross = swept_cross(ab, ac);
    const double longest = swept_dot(ab, ab) + swept_dot(ac, ac);
    if (!(sqrt(swept_dot(cross, cross)) > 1e-12 * longest)) { return false; }
    blade->normal = swept_unit(cross);
    for (int k = 0; k < 3; ++k) {
        const swept_vector side = swept_minus(blade->corners[(k + 1) % 3], blade->corners[k]);
        blade->inward[k] = swept_unit(swept_cross(blade->normal, side));
    }
    return true;
}

static double swept_height_over(const swept_blade* blade, swept_vector point) {
    return swept_dot(blade->normal, swept_minus(point, blade->corners[0]));
}

/* Whether a point of the blade's plane is inside of its outline, which is part of it. */
static bool swept_is_inside(const swept_blade* blade, swept_vector point) {
    for (int k = 0; k < 3; ++k) {
        if (swept_dot(blade->inward[k], swept_minus(point, blade->corners[k])) < -1e-9) { return false; }
    }
    return true;
}

// -------------------------------------------------------------------------------------------- what the blade meets

typedef struct swept_work {
    plii_edit edit;
    const char* function;
    trace_ends ends; /* of the sweep so far */
    int parted;      /* links */
    bool is_changed; /* something was cut */
} swept_work;

/* One blade on the present state of the edit. */
typedef struct swept_pass {
    swept_work* work;
    plii_edit* edit;
    const swept_blade* blade;
    int node_count;        /* before the pass */
    double* heights;       /* [node_count] over the blade's plane */
    uint8_t* marks;        /* [node_count] */
    plii_edge_map edges;   /* that the blade meets, and those around */
    plii_edge_map borders; /* between two nodes on the blade */
    plii_edge_map cuts;    /* to be opened */
} swept_pass;

static swept_vector swept_point(const swept_pass* pass, int node) {
    return swept_wide(plii_edit_position(pass->edit, node));
}

static bool swept_is_on_blade(const swept_pass* pass, int node) {
    return node < pass->node_count && (pass->marks[node] & SWEPT_ON_BLADE) != 0;
}

static bool swept_is_tip(const swept_pass* pass, int node) {
    return node < pass->node_count && (pass->marks[node] & SWEPT_IS_TIP) != 0;
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
    return swept_is_inside(pass->blade, swept_lerp(swept_point(pass, a), swept_point(pass, b), t)) ? t : -1.0;
}

static bool swept_meet_edge(swept_pass* pass, int end_a, int end_b, unsigned flags) {
    const int a = end_a < end_b ? end_a : end_b, b = end_a < end_b ? end_b : end_a;
    if (pass->heights[a] == 0.0 && pass->heights[b] == 0.0) { /* in the plane */
        if (swept_is_inside(pass->blade, swept_point(pass, a))) { swept_mark(pass, a, SWEPT_ON_BLADE); }
        if (swept_is_inside(pass->blade, swept_point(pass, b))) { swept_mark(pass, b, SWEPT_ON_BLADE); }
        return true;
    }
    const double t = swept_crossing(pass, a, b);
    if (t < 0.0) { return true; }
    if (t <= SWEPT_SNAP || t >= 1.0 - SWEPT_SNAP) {
        swept_mark(pass, t <= SWEPT_SNAP ? a : b, SWEPT_ON_BLADE);
        return true;
    }
    const int place = plii_edge_map_add(&pass->edges, a, b);
    if (place == PLI_NULL_INDEX) { return false; }
    pass->edges.edges[place].share = (float)t;
    pass->edges.edges[place].flags |= flags | SWEPT_CROSSED;
    return true;
}

static bool swept_find_edges(swept_pass* pass) {
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
            swept_mark(pass, nodes[k], SWEPT_HAS_FACE);
            if (!swept_meet_edge(pass, nodes[j], nodes[k], SWEPT_OF_FACE)) { return false; }
        }
    }
    /* An edge with an end on the blade is met there. */
    for (int i = 0; i < pass->edges.count; ++i) {
        plii_edge* edge = &pass->edges.edges[i];
        if (swept_is_on_blade(pass, edge->a) || swept_is_on_blade(pass, edge->b)) { edge->flags = 0; }
    }
    return true;
}

static bool swept_meets_something(const swept_pass* pass) {
    for (int i = 0; i < pass->edges.count; ++i) {
        if (pass->edges.edges[i].flags != 0) { return true; }
    }
    for (int i = 0; i < pass->node_count; ++i) {
        if (swept_is_on_blade(pass, i)) { return true; }
    }
    return false;
}

static bool swept_is_crossed(const swept_pass* pass, int a, int b) {
    const int place = plii_edge_map_find(&pass->edges, a, b);
    return place != PLI_NULL_INDEX && (pass->edges.edges[place].flags & SWEPT_CROSSED) != 0;
}

static pli_status swept_check_tetras(const swept_pass* pass) {
    const plii_topology* topology = pass->edit->old_topology;
    for (int i = 0; i < topology->tetra_count; ++i) {
        const int* nodes = topology->tetras[i];
        bool is_met = false;
        for (int j = 0; j < 4; ++j) {
            is_met = is_met || swept_is_on_blade(pass, nodes[j]);
            for (int k = j + 1; k < 4; ++k) {
                is_met = is_met || swept_is_crossed(pass, nodes[j], nodes[k]);
            }
        }
        if (is_met) {
            return plii_fail(pass->edit->context, PLI_ERROR_INVALID_MESH, pass->work->function,
                             "the blade meets tetrahedron %d, tetrahedra cannot be cut", i);
        }
    }
    return PLI_OK;
}

// -------------------------------------------------------------------------------------------- links without faces

/* Bending links and braces inside of a surface go when they are crossed. */
static void swept_remove_links(swept_pass* pass) {
    plii_edit* edit = pass->edit;
    for (int i = 0; i < edit->link_count;) {
        const plii_edit_link* link = &edit->links[i];
        const int a = link->nodes[0], b = link->nodes[1];
        bool is_removed = false;
        if (plii_edit_link_is_bending(link)) {
            is_removed =
                !swept_is_on_blade(pass, a) && !swept_is_on_blade(pass, b) && swept_crossing(pass, a, b) >= 0.0;
        } else if ((pass->marks[a] & pass->marks[b] & SWEPT_HAS_FACE) != 0) {
            const int place = plii_edge_map_find(&pass->edges, a, b);
            is_removed = place != PLI_NULL_INDEX && pass->edges.edges[place].flags == SWEPT_CROSSED;
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

/* A rope that is crossed gets two ends. Their nodes lie behind each other. */
static bool swept_part_rope_links(swept_pass* pass) {
    plii_edit* edit = pass->edit;
    const int count = edit->link_count;
    for (int i = 0; i < count; ++i) {
        const plii_edit_link link = edit->links[i];
        const int place = plii_edge_map_find(&pass->edges, link.nodes[0], link.nodes[1]);
        if (place == PLI_NULL_INDEX || pass->edges.edges[place].flags != SWEPT_CROSSED) { continue; }
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

static int swept_rope_side(const swept_pass* pass, int other) {
    const double height = other < pass->node_count ? pass->heights[other] : 0.0;
    return height > 0.0 ? SWEPT_ABOVE : height < 0.0 ? SWEPT_BELOW : 0;
}

/* A node of a rope on the blade is doubled; the copy takes the links below. */
static bool swept_part_rope_nodes(swept_pass* pass) {
    plii_edit* edit = pass->edit;
    for (int i = 0; i < edit->link_count; ++i) {
        const int* nodes = edit->links[i].nodes;
        for (int k = 0; k < 2; ++k) {
            if (!swept_is_on_blade(pass, nodes[k])) { continue; }
            swept_mark(pass, nodes[k], (unsigned)swept_rope_side(pass, nodes[1 - k]));
        }
    }
    /* Copies of the nodes, by node; 0 is none, since copies come last. */
    const size_t copies_size = (size_t)pass->node_count * sizeof(int);
    int* copies = plii_allocate(edit->context, copies_size);
    bool ok = copies != NULL;
    for (int i = 0; ok && i < pass->node_count; ++i) {
        const unsigned marks = pass->marks[i], both = SWEPT_BELOW | SWEPT_ABOVE;
        if ((marks & (SWEPT_ON_BLADE | SWEPT_HAS_FACE)) != SWEPT_ON_BLADE || (marks & both) != both) { continue; }
        copies[i] = plii_edit_copy_node(edit, i);
        ok = copies[i] != PLI_NULL_INDEX;
        pass->work->parted += 1;
        pass->work->is_changed = true;
    }
    for (int i = 0; ok && i < edit->link_count; ++i) {
        const int nodes[2] = {edit->links[i].nodes[0], edit->links[i].nodes[1]};
        for (int k = 0; k < 2; ++k) {
            if (nodes[k] < pass->node_count && copies[nodes[k]] != 0 &&
                swept_rope_side(pass, nodes[1 - k]) == SWEPT_BELOW) {
                edit->links[i].nodes[k] = copies[nodes[k]];
            }
        }
    }
    plii_release(edit->context, copies, copies_size);
    return ok;
}

// --------------------------------------------------------------------------------------------------------- faces

static bool swept_add_nodes(swept_pass* pass) {
    plii_edge_map* edges = &pass->edges;
    const size_t order_size = (size_t)edges->count * sizeof(int);
    int* order = plii_allocate(pass->edit->context, order_size);
    if (order == NULL && order_size > 0) { return false; }
    bool ok = plii_edge_map_order(edges, pass->node_count, order);
    for (int i = 0; ok && i < edges->count; ++i) {
        plii_edge* edge = &edges->edges[order[i]];
        if (edge->flags != (SWEPT_OF_FACE | SWEPT_CROSSED)) { continue; }
        edge->node = plii_edit_add_node(pass->edit, edge->a, edge->b, edge->share);
        ok = edge->node != PLI_NULL_INDEX;
        pass->work->is_changed = true;
    }
    plii_release(pass->edit->context, order, order_size);
    return ok;
}

static bool swept_open(swept_pass* pass, int a, int b) {
    return plii_edge_map_add(&pass->cuts, a, b) != PLI_NULL_INDEX;
}

static bool swept_note_border(swept_pass* pass, int a, int b, double height) {
    const int place = plii_edge_map_add(&pass->borders, a, b);
    if (place == PLI_NULL_INDEX) { return false; }
    pass->borders.edges[place].flags |= height < 0.0 ? SWEPT_FACE_BELOW : SWEPT_FACE_ABOVE;
    return true;
}

/* Edges that stayed closed, which may be crossed by now. */
static bool swept_open_closed_edges(swept_pass* pass) {
    const trace_ends* ends = &pass->work->ends;
    for (int i = 0; i < ends->edge_count; ++i) {
        const int a = ends->edges[i][0], b = ends->edges[i][1];
        const int place = plii_edge_map_find(&pass->edges, a, b);
        const int node = place != PLI_NULL_INDEX ? pass->edges.edges[place].node : PLI_NULL_INDEX;
        const bool ok =
            node != PLI_NULL_INDEX ? swept_open(pass, a, node) && swept_open(pass, node, b) : swept_open(pass, a, b);
        if (!ok) { return false; }
    }
    return true;
}

/* Which edges of one face will be opened. */
static bool swept_judge_face(swept_pass* pass, const int* nodes) {
    int crossings[3], crossing_count = 0, crossed = 0; /* `crossed`: an edge, from the corner to the next */
    int on_count = 0, on = 0, tip = PLI_NULL_INDEX;
    for (int k = 0; k < 3; ++k) {
        const int place = plii_edge_map_find(&pass->edges, nodes[k], nodes[(k + 1) % 3]);
        const int node = place != PLI_NULL_INDEX ? pass->edges.edges[place].node : PLI_NULL_INDEX;
        if (node != PLI_NULL_INDEX) {
            crossings[crossing_count++] = node;
            crossed = k;
        }
        if (swept_is_on_blade(pass, nodes[k])) {
            ++on_count;
            on = nodes[k];
        } else if (swept_is_tip(pass, nodes[k])) {
            tip = nodes[k];
        }
    }
    if (crossing_count == 2) { return swept_open(pass, crossings[0], crossings[1]); }
    if (crossing_count == 1) {
        const int first = nodes[crossed], second = nodes[(crossed + 1) % 3], opposite = nodes[(crossed + 2) % 3];
        if (swept_is_on_blade(pass, opposite) || swept_is_tip(pass, opposite)) {
            return swept_open(pass, crossings[0], opposite);
        }
        if (swept_is_tip(pass, first)) { return swept_open(pass, crossings[0], first); }
        return !swept_is_tip(pass, second) || swept_open(pass, crossings[0], second);
    }
    if (crossing_count == 0 && on_count == 1 && tip != PLI_NULL_INDEX) { return swept_open(pass, on, tip); }
    if (crossing_count > 0 || on_count < 2) { return true; }
    bool ok = true;
    for (int k = 0; ok && k < 3; ++k) {
        const int a = nodes[k], b = nodes[(k + 1) % 3];
        if (!swept_is_on_blade(pass, a) || !swept_is_on_blade(pass, b)) { continue; }
        /* A face with all nodes on the blade counts as above. */
        ok = swept_note_border(pass, a, b, on_count == 3 ? 0.0 : pass->heights[nodes[(k + 2) % 3]]);
    }
    return ok;
}

static bool swept_judge_faces(swept_pass* pass) {
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

// ---------------------------------------------------------------------------------------------------------- tips

static bool swept_push_tip(swept_work* work, int node) {
    trace_ends* ends = &work->ends;
    if (!PLII_RESERVE(work->edit.context, &ends->tips, &ends->tip_capacity, ends->tip_count + 1)) { return false; }
    ends->tips[ends->tip_count++] = node;
    return true;
}

/* Tips are the nodes of the cut that are still closed. */
static bool swept_find_tips(swept_pass* pass, const uint8_t* is_parted, int node_count) {
    trace_ends* ends = &pass->work->ends;
    int kept = 0;
    for (int i = 0; i < ends->tip_count; ++i) {
        if (is_parted[ends->tips[i]] == 0) { ends->tips[kept++] = ends->tips[i]; }
    }
    ends->tip_count = kept;
    for (int i = 0; i < node_count; ++i) {
        const unsigned marks = i < pass->node_count ? pass->marks[i] : SWEPT_ON_BLADE | SWEPT_HAS_FACE;
        const bool is_on_surface = (marks & (SWEPT_ON_BLADE | SWEPT_HAS_FACE)) == (SWEPT_ON_BLADE | SWEPT_HAS_FACE);
        if (!is_on_surface || is_parted[i] != 0 || (marks & SWEPT_IS_TIP) != 0) { continue; }
        if (!swept_push_tip(pass->work, i)) { return false; }
    }
    return true;
}

/* An edge is open when one of its ends is parted. */
static bool swept_find_closed_edges(swept_pass* pass, const uint8_t* is_parted) {
    trace_ends* ends = &pass->work->ends;
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

static bool swept_separate(swept_pass* pass) {
    const int node_count = pass->edit->node_count;
    uint8_t* is_parted = plii_allocate(pass->edit->context, (size_t)node_count);
    const bool ok =
        is_parted != NULL &&
        plii_cut_separate(pass->edit, &pass->cuts, pass->heights, pass->node_count, is_parted, &pass->work->parted) &&
        swept_find_tips(pass, is_parted, node_count) && swept_find_closed_edges(pass, is_parted);
    pass->work->is_changed = pass->work->is_changed || pass->edit->node_count > node_count;
    plii_release(pass->edit->context, is_parted, (size_t)node_count);
    return ok;
}

// ----------------------------------------------------------------------------------------------------- the whole

static int swept_crossed_links(const swept_pass* pass) {
    int count = 0;
    for (int i = 0; i < pass->edit->link_count; ++i) {
        const int place =
            plii_edge_map_find(&pass->edges, pass->edit->links[i].nodes[0], pass->edit->links[i].nodes[1]);
        count += place != PLI_NULL_INDEX && pass->edges.edges[place].node != PLI_NULL_INDEX;
    }
    return count;
}

static pli_status swept_run_pass(swept_pass* pass) {
    plii_edit* edit = pass->edit;
    for (int i = 0; i < pass->node_count; ++i) {
        pass->heights[i] = swept_height_over(pass->blade, swept_point(pass, i));
    }
    for (int i = 0; i < pass->work->ends.tip_count; ++i) {
        swept_mark(pass, pass->work->ends.tips[i], SWEPT_IS_TIP);
    }
    if (!swept_find_edges(pass)) { return PLI_ERROR_OUT_OF_MEMORY; }
    PLII_TRY(swept_check_tetras(pass));
    swept_remove_links(pass); /* also those over the inside of a face */
    if (!swept_meets_something(pass)) { return PLI_OK; }
    bool ok = swept_part_rope_links(pass) && swept_part_rope_nodes(pass) && swept_add_nodes(pass) &&
              swept_judge_faces(pass) && swept_open_closed_edges(pass);
    if (!ok) { return PLI_ERROR_OUT_OF_MEMORY; }
    pass->work->parted += swept_crossed_links(pass);
    ok = plii_edit_add_crossed_faces(edit, &pass->edges);
    plii_edit_learn_rest_lengths(edit, &pass->edges);
    ok = ok && plii_edit_split_links(edit, &pass->edges) && plii_edit_split_faces(edit, &pass->edges) &&
         swept_separate(pass);
    return ok ? PLI_OK : PLI_ERROR_OUT_OF_MEMORY;
}

static pli_status swept_cut(swept_work* work, const swept_blade* blade) {
    plii_edit* edit = &work->edit;
    pli_context* context = edit->context;
    swept_pass pass = {.work = work, .edit = edit, .blade = blade, .node_count = edit->node_count};
    pass.edges.context = pass.borders.context = pass.cuts.context = context;
    const size_t height_size = (size_t)pass.node_count * sizeof *pass.heights;
    pass.heights = plii_allocate(context, height_size);
    pass.marks = plii_allocate(context, (size_t)pass.node_count);
    const pli_status status =
        pass.heights != NULL && pass.marks != NULL ? swept_run_pass(&pass) : PLI_ERROR_OUT_OF_MEMORY;
    plii_release(context, pass.heights, height_size);
    plii_release(context, pass.marks, (size_t)pass.node_count);
    plii_edge_map_free(&pass.edges);
    plii_edge_map_free(&pass.borders);
    plii_edge_map_free(&pass.cuts);
    return status;
}

/* Blades that pass the body by are not worth a copy of it. */
static bool swept_may_meet(const pli_body* body, const pli_vec3* corners) {
    const pli_bounds bounds = {plii_vec3_min(corners[0], plii_vec3_min(corners[1], corners[2])),
                               plii_vec3_max(corners[0], plii_vec3_max(corners[1], corners[2]))};
    return plii_bounds_overlap(bounds, body->bounds);
}

/* `corners` of two triangles. */
static pli_status swept_cut_all(swept_work* work, const pli_vec3 (*corners)[3]) {
    const pli_body* body = work->edit.body;
    for (int i = 0; i < 2; ++i) {
        swept_blade blade;
        if (!swept_make_blade(corners[i][0], corners[i][1], corners[i][2], &blade)) { continue; }
        if (swept_may_meet(body, corners[i])) { PLII_TRY(swept_cut(work, &blade)); }
    }
    return PLI_OK;
}

/* Cuts and leaves the ends of the cut in `trace`. */
static pli_status swept_run(pli_body* body, trace_state* trace, const pli_vec3 (*corners)[3], bool goes_on,
                            const char* function, int* parted) {
    swept_work work = {.function = function};
    PLII_TRY(plii_edit_open(body, function, &work.edit));
    const bool is_ready = !goes_on || trace_copy_ends(body->context, &trace->ends, &work.ends);
    pli_status status = is_ready ? swept_cut_all(&work, corners) : PLI_ERROR_OUT_OF_MEMORY;
    if (status == PLI_ERROR_OUT_OF_MEMORY) {
        plii_fail(body->context, status, function, "no memory to cut %d nodes, %d links and %d faces", body->node_count,
                  body->link_count, body->topology->face_count);
    }
    if (status == PLI_OK && work.is_changed) { status = plii_edit_commit(&work.edit, function); }
    if (status == PLI_OK) {
        *parted = work.parted;
        const trace_ends old = trace->ends;
        trace->ends = work.ends;
        work.ends = old;
    }
    trace_release_ends(body->context, &work.ends);
    plii_edit_close(&work.edit);
    return status;
}

pli_status pli_body_cut_swept(pli_body* body, pli_vec3 from_start, pli_vec3 from_end, pli_vec3 to_start,
                              pli_vec3 to_end, int* parted) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    if (!plii_vec3_is_finite(from_start) || !plii_vec3_is_finite(from_end) || !plii_vec3_is_finite(to_start) ||
        !plii_vec3_is_finite(to_end)) {
        return PLII_FAIL(body->context, PLI_ERROR_NOT_FINITE, "an end of a ray is not finite");
    }
    const pli_vec3 ends[4] = {from_start, from_end, to_start, to_end};
    PLII_TRY(plii_check_places(body->context, 4, ends, "end", __func__));
    const bool was_enabled = plii_feature_state(body, &trace_class) != NULL;
    void* state = NULL;
    PLII_TRY(plii_feature_enable(body, &trace_class, &state));
    trace_state* trace = state;
    const bool goes_on = trace_ends_at(trace, from_start, from_end);
    const pli_vec3 corners[2][3] = {{from_start, from_end, to_end}, {from_start, to_end, to_start}};
    int count = 0;
    if (swept_may_meet(body, corners[0]) || swept_may_meet(body, corners[1])) {
        const pli_status status = swept_run(body, trace, corners, goes_on, __func__, &count);
        if (status != PLI_OK) {
            if (!was_enabled) { plii_feature_disable(body, &trace_class); }
            return status;
        }
    } else if (!goes_on) {
        trace_forget(trace);
    }
    trace->has_ray = true;
    trace->ray[0] = to_start;
    trace->ray[1] = to_end;
    if (parted != NULL) { *parted = count; }
    return PLI_OK;
}
