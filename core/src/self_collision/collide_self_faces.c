/* Self-collision of faces: nodes with faces and edges with edges that have no node in common.

   Pairs within reach are collected once per step; of those, a substep looks at the ones that could come together in it.
   Nearest points at the start of a step (or substep) give each pair a plane between its two sides. Pairs nearer than
   the thickness are pushed apart along its normal, like other contacts; whatever constraints do after that, motions are
   in the end cut short where a pair would get to the wrong side of its plane. So nothing that starts apart ever
   crosses. Lan and others, "Penetration-free Projective Dynamics", and Chen and others, "Offset Geometric Contact", cut
   motions short in the same spirit. */

#include "body/pipeline.h"
#include "geometry/box_tree.h"
#include "geometry/closest_point.h"
#include "math/bounds.h"
#include "math/range.h"
#include "self_collision/self_collision_impl.h"

#define SELF_FACES_MAX_PASSES 16
/* Share of its distance that a pair keeps at least. */
#define SELF_FACES_KEPT 0.2f
/* Of the thickness: how far constraints may move a node in a substep beyond its free motion. */
#define SELF_FACES_SUBSTEP_ROOM 0.1f
/* Of the thickness: what rounding may take from a distance. */
#define SELF_FACES_SLACK 0.01f

typedef struct self_faces_pair {
    int nodes[4];   /* node and face, or edge and edge */
    bool is_edges;  /* first side: 2 nodes instead of 1 */
    float target;   /* m, distance to keep; < 0: not known yet */
    float distance; /* m, at the start */
    float weights[4];
    pli_vec3 normal; /* unit, from the second side to the first */
    float middle;    /* along the normal, from the start of the first node */
} self_faces_pair;

typedef struct self_faces_state {
    pli_self_faces_def def;
    float travel;           /* m that a node may move in this step, */
    float motion;           /* in this step or substep */
    float reach;            /* m, of the last search; 0: none */
    float moved;            /* m that a node has moved since then at most */
    float mean_edge_length; /* m, at rest */
    pli_vec3* rest;         /* [node_count] */
    pli_vec4* starts;       /* [node_count] at the start of the step */
    pli_vec3* was;          /* [node_count] before motions are cut short */
    pli_vec3* last;         /* [node_count] where `moved` has counted to */
    int* rows;              /* [node_count + 1] of edges by their first node */
    int (*edges)[2];        /* [3 * face_count], of which edge_count are in use */
    int edge_count;
    pli_bounds* boxes;
    self_faces_pair* pairs;
    float* due;  /* [pair_count] value of `moved` up to which a pair cannot come together */
    int* active; /* pairs to be solved in this step or substep */
    int box_capacity, pair_count, pair_capacity, due_capacity, active_count, active_capacity;
    plii_box_tree tree;
    pli_self_faces_report report;
} self_faces_state;

// ------------------------------------------------------------------------------------------------------------ edges

static void self_faces_edge(const int face[3], int k, int* a, int* b) {
    const int i = face[k], j = face[(k + 1) % 3];
    *a = i < j ? i : j;
    *b = i < j ? j : i;
}

/* Edges of all faces, each once: sorted by the first node, then looked for among those of the same node. */
static void self_faces_find_edges(const pli_body* body, self_faces_state* state) {
    const plii_topology* topology = body->topology;
    int* rows = state->rows;
    for (int i = 0; i <= body->node_count; ++i) {
        rows[i] = 0;
    }
    int a = 0, b = 0;
    for (int f = 0; f < topology->face_count; ++f) {
        for (int k = 0; k < 3; ++k) {
            self_faces_edge(topology->faces[f], k, &a, &b);
            ++rows[a];
        }
    }
    int sum = 0;
    for (int i = 0; i <= body->node_count; ++i) {
        sum += rows[i];
        rows[i] = sum;
    }
    for (int f = topology->face_count - 1; f >= 0; --f) {
        for (int k = 2; k >= 0; --k) {
            self_faces_edge(topology->faces[f], k, &a, &b);
            int* edge = state->edges[--rows[a]];
            edge[0] = a;
            edge[1] = b;
        }
    }
    int kept = 0;
    double length = 0.0;
    for (int i = 0; i < body->node_count; ++i) {
        const int begin = kept;
        for (int k = rows[i]; k < rows[i + 1]; ++k) {
            const int other = state->edges[k][1];
            bool is_new = other != i;
            for (int m = begin; m < kept && is_new; ++m) {
                is_new = state->edges[m][1] != other;
            }
            if (!is_new) { continue; }
            state->edges[kept][0] = i;
            state->edges[kept++][1] = other;
            length += (double)sqrtf(pli_vec3_length_squared(pli_vec3_sub(state->rest[other], state->rest[i])));
        }
    }
    state->edge_count = kept;
    state->mean_edge_length = kept > 0 ? (float)(length / kept) : 0.0f;
}

// --------------------------------------------------------------------------------------------------- nearest points

/* Nearest points of segments (Ericson, Real-Time Collision Detection, 5.1.9): shares along each. */
static void self_faces_nearest_on_edges(const pli_vec3 p[4], float* s, float* t) {
    const pli_vec3 d1 = pli_vec3_sub(p[1], p[0]), d2 = pli_vec3_sub(p[3], p[2]), r = pli_vec3_sub(p[0], p[2]);
    const float a = pli_vec3_length_squared(d1), e = pli_vec3_length_squared(d2), f = pli_vec3_dot(d2, r);
    const float c = pli_vec3_dot(d1, r), b = pli_vec3_dot(d1, d2);
    *s = *t = 0.0f;
    if (!(a > 0.0f)) {
        *t = e > 0.0f ? plii_clamp(f / e, 0.0f, 1.0f) : 0.0f;
        return;
    }
    if (!(e > 0.0f)) {
        *s = plii_clamp(-c / a, 0.0f, 1.0f);
        return;
    }
    const float denominator = a * e - b * b;
    if (denominator > 1e-6f * a * e) { *s = plii_clamp((b * f - c * e) / denominator, 0.0f, 1.0f); }
    *t = (b * *s + f) / e;
    if (*t < 0.0f || *t > 1.0f) {
        *t = plii_clamp(*t, 0.0f, 1.0f);
        *s = plii_clamp((b * *t - c) / a, 0.0f, 1.0f);
    }
}

/* From the second side to the first between nearest points; `weights` of the nodes, negative on the second side. */
static pli_vec3 self_faces_nearest(const pli_vec3 p[4], bool is_edges, float weights[4]) {
    if (is_edges) {
        float s = 0.0f, t = 0.0f;
        self_faces_nearest_on_edges(p, &s, &t);
        weights[0] = 1.0f - s;
        weights[1] = s;
        weights[2] = t - 1.0f;
        weights[3] = -t;
    } else {
        plii_triangle_place place;
        (void)plii_closest_point_on_triangle(p[0], p[1], p[2], p[3], &place);
        weights[0] = 1.0f;
        weights[1] = -place.weights.x;
        weights[2] = -place.weights.y;
        weights[3] = -place.weights.z;
    }
    pli_vec3 apart = pli_vec3_make(0, 0, 0);
    for (int k = 1; k < 4; ++k) { /* about node 0: weights sum up to 0 */
        apart = pli_vec3_add(apart, pli_vec3_scale(pli_vec3_sub(p[k], p[0]), weights[k]));
    }
    return apart;
}

// ------------------------------------------------------------------------------------------------------- the search

static pli_bounds self_faces_box(const pli_body* body, const int* nodes, int count) {
    pli_bounds box = {plii_xyz(body->previous[nodes[0]]), plii_xyz(body->previous[nodes[0]])};
    for (int k = 1; k < count; ++k) {
        box.min = plii_vec3_min(box.min, plii_xyz(body->previous[nodes[k]]));
        box.max = plii_vec3_max(box.max, plii_xyz(body->previous[nodes[k]]));
    }
    return box;
}

static float self_faces_box_distance(const pli_bounds* a, const pli_bounds* b) {
    const pli_vec3 zero = pli_vec3_make(0, 0, 0);
    const pli_vec3 apart = plii_vec3_max(pli_vec3_sub(a->min, b->max), pli_vec3_sub(b->min, a->max));
    return pli_vec3_length(plii_vec3_max(apart, zero));
}

typedef struct self_faces_search {
    pli_body* body;
    self_faces_state* state;
    pli_bounds box; /* of the item */
    int item;       /* node or edge that is looked for */
    bool is_edges;
    bool has_memory;
} self_faces_search;

static void self_faces_hit(int item, void* user) {
    self_faces_search* search = user;
    self_faces_state* state = search->state;
    const pli_body* body = search->body;
    self_faces_pair pair = {.is_edges = search->is_edges, .target = -1.0f};
    if (search->is_edges) {
        if (item <= search->item) { return; }
        const int *a = state->edges[search->item], *b = state->edges[item];
        if (a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1]) { return; }
        pair.nodes[0] = a[0], pair.nodes[1] = a[1], pair.nodes[2] = b[0], pair.nodes[3] = b[1];
    } else {
        const int* face = body->topology->faces[item];
        if (face[0] == search->item || face[1] == search->item || face[2] == search->item) { return; }
        pair.nodes[0] = search->item, pair.nodes[1] = face[0], pair.nodes[2] = face[1], pair.nodes[3] = face[2];
    }
    float mobility = 0.0f;
    for (int k = 0; k < 4; ++k) {
        mobility += body->positions[pair.nodes[k]].w;
    }
    const float distance = self_faces_box_distance(&search->box, &state->boxes[item]);
    if (!(mobility > 0.0f) || !(distance <= state->reach)) { return; }
    if (!PLII_RESERVE(body->context, &state->pairs, &state->pair_capacity, state->pair_count + 1) ||
        !PLII_RESERVE(body->context, &state->due, &state->due_capacity, state->pair_count + 1)) {
        search->has_memory = false;
        return;
    }
    state->due[state->pair_count] = 0.5f * (distance - state->def.thickness);
    state->pairs[state->pair_count++] = pair;
}

static void self_faces_search_run(self_faces_search* search) {
    pli_body* body = search->body;
    self_faces_state* state = search->state;
    const int targets = search->is_edges ? state->edge_count : body->topology->face_count;
    if (!PLII_RESERVE(body->context, &state->boxes, &state->box_capacity, targets)) {
        search->has_memory = false;
        return;
    }
    for (int i = 0; i < targets; ++i) {
        state->boxes[i] = search->is_edges ? self_faces_box(body, state->edges[i], 2)
                                           : self_faces_box(body, body->topology->faces[i], 3);
    }
    if (!plii_box_tree_build(body->context, &state->tree, targets, state->boxes)) {
        search->has_memory = false;
        return;
    }
    const int count = search->is_edges ? state->edge_count : body->node_count;
    for (int i = 0; i < count; ++i) {
        search->item = i;
        search->box = search->is_edges ? self_faces_box(body, state->edges[i], 2) : self_faces_box(body, &i, 1);
        plii_box_tree_overlaps(&state->tree, plii_bounds_grow(search->box, state->reach), self_faces_hit, search);
    }
}

/* How far nodes are about to move in this step, with some room for constraints. */
static float self_faces_wanted_travel(const pli_body* body, const self_faces_state* state) {
    float squared = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 motion = pli_vec3_sub(plii_xyz(body->positions[i]), plii_xyz(body->previous[i]));
        squared = plii_max(squared, pli_vec3_length_squared(motion));
    }
    const float most = state->def.max_travel > 0.0f ? state->def.max_travel : 0.5f * state->mean_edge_length;
    return plii_min(most, 1.25f * sqrtf(squared) + 0.5f * state->def.thickness);
}

/* Counts how far nodes have got. What is not finite goes on being so, and is caught elsewhere. */
static void self_faces_count_motion(const pli_body* body, self_faces_state* state, const plii_self_nodes* nodes) {
    float squared = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 x = plii_self_start(nodes, i);
        squared = plii_max(squared, pli_vec3_length_squared(pli_vec3_sub(x, state->last[i])));
        state->last[i] = x;
    }
    state->moved += sqrtf(squared) * (1.0f + 1e-5f);
}

static void self_faces_begin(pli_body* body, self_faces_state* state) {
    const plii_self_nodes nodes = {NULL, body->previous, body->previous};
    state->report = (pli_self_faces_report){.pairs = state->pair_count};
    state->travel = self_faces_wanted_travel(body, state);
    self_faces_count_motion(body, state, &nodes);
    const float room = 0.5f * (state->reach - state->def.thickness);
    if (state->reach > 0.0f && state->moved + state->travel <= room) { return; }
    state->reach = state->def.thickness + 2.0f * state->travel;
    state->moved = 0.0f;
    state->pair_count = 0;
    self_faces_search search = {.body = body, .state = state, .has_memory = true};
    self_faces_search_run(&search);
    search.is_edges = true;
    self_faces_search_run(&search);
    if (!search.has_memory) { state->reach = 0.0f; }
    state->report.pairs = state->pair_count;
    state->report.is_truncated = !search.has_memory;
}

// --------------------------------------------------------------------------------------------------------- contacts

static float self_faces_distance_at_rest(const self_faces_state* state, const self_faces_pair* pair) {
    pli_vec3 x[4];
    float weights[4];
    for (int k = 0; k < 4; ++k) {
        x[k] = state->rest[pair->nodes[k]];
    }
    return pli_vec3_length(self_faces_nearest(x, pair->is_edges, weights));
}

/* Takes a pair as it is at the start of a step or substep, where `last` is. True when it could come together in it and
 * has a normal. */
static bool self_faces_take(self_faces_state* state, int index) {
    self_faces_pair* pair = &state->pairs[index];
    const float thickness = state->def.thickness;
    pli_vec3 x[4];
    for (int k = 0; k < 4; ++k) {
        x[k] = state->last[pair->nodes[k]];
    }
    const pli_vec3 apart = self_faces_nearest(x, pair->is_edges, pair->weights);
    const float distance = pli_vec3_length(apart);
    if (!(distance > 1e-6f * thickness) || !plii_is_finite(distance)) { return false; }
    float gap = distance - (1.0f + SELF_FACES_SLACK) * thickness;
    if (gap < 2.0f * state->motion) {
        if (pair->target < 0.0f) { pair->target = plii_min(thickness, self_faces_distance_at_rest(state, pair)); }
        gap = distance - pair->target - SELF_FACES_SLACK * thickness;
    }
    state->due[index] = state->moved + 0.5f * gap;
    if (gap >= 2.0f * state->motion) { return false; }
    pair->normal = plii_vec3_divide(apart, distance);
    /* The sides as they are, not as nearest points say: those are rounded. */
    float low = FLT_MAX, high = -FLT_MAX;
    for (int k = 0; k < 4; ++k) {
        const float level = pli_vec3_dot(pair->normal, pli_vec3_sub(x[k], x[0]));
        const bool is_first = k == 0 || (k == 1 && pair->is_edges);
        if (is_first) {
            low = plii_min(low, level);
        } else {
            high = plii_max(high, level);
        }
    }
    pair->middle = 0.5f * (low + high);
    pair->distance = low - high;
    return pair->distance > 0.0f;
}

/* Collects the pairs that could come together when no node moves by more than `motion`. */
static void self_faces_restart(pli_body* body, self_faces_state* state, const plii_self_nodes* nodes, float motion) {
    state->motion = motion;
    self_faces_count_motion(body, state, nodes);
    state->active_count = 0;
    for (int i = 0; i < state->pair_count; ++i) {
        if (state->due[i] > state->moved + motion || !self_faces_take(state, i)) { continue; }
        if (!PLII_RESERVE(body->context, &state->active, &state->active_capacity, state->active_count + 1)) {
            state->report.is_truncated = true;
            return;
        }
        state->active[state->active_count++] = i;
    }
}

/* True when the pair was too near. */
static bool self_faces_part(const plii_self_nodes* nodes, const self_faces_pair* pair, float friction) {
    float weight = 0.0f, distance = 0.0f;
    pli_vec3 motion = pli_vec3_make(0, 0, 0);
    for (int k = 0; k < 4; ++k) {
        const int node = pair->nodes[k];
        weight += pair->weights[k] * pair->weights[k] * nodes->offsets[node].w;
        distance += pair->weights[k] * pli_vec3_dot(pair->normal, plii_self_difference(nodes, pair->nodes[0], node));
        motion = pli_vec3_add(motion, pli_vec3_scale(plii_self_motion(nodes, node), pair->weights[k]));
    }
    if (!(distance < pair->target) || !(weight > 0.0f)) { return false; }
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(pair->normal, pli_vec3_dot(motion, pair->normal)));
    const pli_vec3 change = pli_vec3_sub(pli_vec3_scale(pair->normal, (pair->target - distance) / weight),
                                         pli_vec3_scale(sliding, friction / weight));
    for (int k = 0; k < 4; ++k) {
        const int node = pair->nodes[k];
        plii_self_move(nodes, node, change, nodes->offsets[node].w * pair->weights[k]);
    }
    return true;
}

static void self_faces_solve(self_faces_state* state, const plii_self_nodes* nodes) {
    const float near = state->def.thickness;
    int contacts = 0;
    for (int i = 0; i < state->active_count; ++i) {
        const self_faces_pair* pair = &state->pairs[state->active[i]];
        if (pair->distance > pair->target + near) { continue; }
        contacts += self_faces_part(nodes, pair, state->def.friction);
    }
    state->report.contacts = contacts;
}

// ----------------------------------------------------------------------------------------------- cutting motions short

static void self_faces_limit_motion(const pli_body* body, self_faces_state* state, const plii_self_nodes* nodes) {
    const pli_vec4* step_starts = body->solver_class->has_substeps ? body->previous : state->starts;
    for (int i = 0; i < body->node_count; ++i) {
        if (!(nodes->offsets[i].w > 0.0f)) { continue; }
        const pli_vec3 motion = plii_self_motion(nodes, i);
        const float squared = pli_vec3_length_squared(motion);
        if (squared > state->motion * state->motion) {
            plii_self_move(nodes, i, motion, state->motion / sqrtf(squared) - 1.0f);
            state->report.shortened += 1;
        }
        const pli_vec3 moved = pli_vec3_sub(plii_self_position(nodes, i), plii_xyz(step_starts[i]));
        const float all_squared = pli_vec3_length_squared(moved);
        if (all_squared > state->travel * state->travel) {
            plii_self_move(nodes, i, moved, state->travel / sqrtf(all_squared) - 1.0f);
            state->report.shortened += 1;
        }
    }
}

/* Levels of the nodes of a pair along its normal, about the middle; positive on the first side. */
static void self_faces_levels(const plii_self_nodes* nodes, const self_faces_pair* pair, float sign[4],
                              float level[4]) {
    const pli_vec3 origin = plii_self_start(nodes, pair->nodes[0]);
    for (int k = 0; k < 4; ++k) {
        const pli_vec3 x = pli_vec3_sub(plii_self_position(nodes, pair->nodes[k]), origin);
        sign[k] = k == 0 || (k == 1 && pair->is_edges) ? 1.0f : -1.0f;
        level[k] = sign[k] * (pli_vec3_dot(pair->normal, x) - pair->middle);
    }
}

/* Motions of the nodes of a pair end where they would come too near to its plane. True when one did. */
static bool self_faces_shorten(const plii_self_nodes* nodes, const self_faces_pair* pair, bool is_forced) {
    float sign[4], level[4], first = FLT_MAX, second = FLT_MAX;
    self_faces_levels(nodes, pair, sign, level);
    for (int k = 0; k < 4; ++k) {
        if (sign[k] > 0.0f) {
            first = plii_min(first, level[k]);
        } else {
            second = plii_min(second, level[k]);
        }
    }
    const float kept = 0.5f * SELF_FACES_KEPT * pair->distance;
    if (!is_forced && first + second >= 2.0f * kept) { return false; } /* apart, if not at this plane */
    bool is_shortened = false;
    for (int k = 0; k < 4; ++k) {
        if (!(level[k] < kept)) { continue; }
        const int node = pair->nodes[k];
        const pli_vec3 motion = plii_self_motion(nodes, node);
        const float change = sign[k] * pli_vec3_dot(pair->normal, motion);
        /* A little more than needed, lest rounding brings the pair back in the next pass. */
        const float share = change < 0.0f ? plii_clamp((level[k] - 1.01f * kept) / change, 0.0f, 1.0f) : 0.0f;
        if (share > 0.0f) {
            plii_self_move(nodes, node, motion, -share);
            is_shortened = true;
        }
    }
    return is_shortened;
}

/* After all constraints of a step or substep. */
static void self_faces_finish(const pli_body* body, self_faces_state* state, const plii_self_nodes* nodes) {
    self_faces_limit_motion(body, state, nodes);
    bool is_done = false;
    for (int pass = 0; pass <= SELF_FACES_MAX_PASSES && !is_done; ++pass) {
        is_done = true;
        for (int i = 0; i < state->active_count; ++i) {
            if (self_faces_shorten(nodes, &state->pairs[state->active[i]], pass == SELF_FACES_MAX_PASSES)) {
                is_done = false;
                state->report.shortened += 1;
            }
        }
    }
}

// ------------------------------------------------------------------------------------------------------ the feature

static plii_self_nodes self_faces_nodes(pli_body* body, const self_faces_state* state) {
    return (plii_self_nodes){NULL, body->positions, state->starts};
}

static void self_faces_run_prepare(pli_body* body, void* data, const plii_step* step) {
    self_faces_state* state = data;
    (void)step;
    for (int i = 0; i < body->node_count; ++i) {
        state->starts[i] = body->previous[i];
    }
    const plii_self_nodes nodes = self_faces_nodes(body, state);
    self_faces_begin(body, state);
    self_faces_restart(body, state, &nodes, state->travel);
}

static void self_faces_run_position(pli_body* body, void* data, const plii_step* step) {
    const plii_self_nodes nodes = self_faces_nodes(body, data);
    (void)step;
    self_faces_solve(data, &nodes);
}

/* After velocities were taken from positions: they follow. */
static void self_faces_run_finish(pli_body* body, void* data, const plii_step* step) {
    self_faces_state* state = data;
    if (body->solver_class->has_substeps) { return; }
    const plii_self_nodes nodes = self_faces_nodes(body, state);
    for (int i = 0; i < body->node_count; ++i) {
        state->was[i] = plii_xyz(body->positions[i]);
    }
    self_faces_finish(body, state, &nodes);
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 change = pli_vec3_sub(plii_xyz(body->positions[i]), state->was[i]);
        plii_set_xyz(&body->velocities[i],
                     pli_vec3_add(plii_xyz(body->velocities[i]), pli_vec3_scale(change, step->inverse_dt)));
    }
}

static void self_faces_begin_substeps(pli_body* body, void* data) {
    self_faces_begin(body, data);
}

static void self_faces_restart_substep(pli_body* body, void* data, const plii_substep* substep) {
    self_faces_state* state = data;
    const plii_self_nodes nodes = plii_self_nodes_of_substep(body, substep);
    float squared = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        squared = plii_max(squared, pli_vec3_length_squared(plii_self_motion(&nodes, i)));
    }
    const float motion = 1.25f * sqrtf(squared) + SELF_FACES_SUBSTEP_ROOM * state->def.thickness;
    self_faces_restart(body, state, &nodes, plii_min(motion, state->travel));
}

static void self_faces_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const plii_self_nodes nodes = plii_self_nodes_of_substep(body, substep);
    self_faces_solve(data, &nodes);
    self_faces_finish(body, data, &nodes);
}

enum { SELF_FACES_BLOCKS = 6 };

static void self_faces_sizes(int node_count, int face_count, size_t sizes[SELF_FACES_BLOCKS]) {
    sizes[0] = (size_t)node_count * sizeof(pli_vec3);
    sizes[1] = (size_t)node_count * sizeof(pli_vec4);
    sizes[2] = (size_t)node_count * sizeof(pli_vec3);
    sizes[3] = ((size_t)node_count + 1) * sizeof(int);
    sizes[4] = 3 * (size_t)face_count * sizeof(int[2]);
    sizes[5] = (size_t)node_count * sizeof(pli_vec3);
}

static void self_faces_take_blocks(self_faces_state* state, void* blocks[SELF_FACES_BLOCKS]) {
    state->rest = blocks[0];
    state->starts = blocks[1];
    state->was = blocks[2];
    state->rows = blocks[3];
    state->edges = blocks[4];
    state->last = blocks[5];
}

static void self_faces_release_blocks(pli_body* body, const self_faces_state* state, int node_count, int face_count) {
    size_t sizes[SELF_FACES_BLOCKS];
    void* const blocks[SELF_FACES_BLOCKS] = {state->rest, state->starts, state->was,
                                             state->rows, state->edges,  state->last};
    self_faces_sizes(node_count, face_count, sizes);
    for (int i = 0; i < SELF_FACES_BLOCKS; ++i) {
        plii_release(body->context, blocks[i], sizes[i]);
    }
}

static pli_status self_faces_enable(pli_body* body, void* data) {
    self_faces_state* state = data;
    const int face_count = body->topology->face_count;
    size_t sizes[SELF_FACES_BLOCKS];
    void* blocks[SELF_FACES_BLOCKS];
    bool is_complete = true;
    self_faces_sizes(body->node_count, face_count, sizes);
    for (int i = 0; i < SELF_FACES_BLOCKS; ++i) {
        blocks[i] = plii_allocate(body->context, sizes[i]);
        is_complete = is_complete && blocks[i] != NULL;
    }
    self_faces_take_blocks(state, blocks);
    if (!is_complete) {
        self_faces_release_blocks(body, state, body->node_count, face_count);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    for (int i = 0; i < body->node_count; ++i) {
        state->rest[i] = plii_xyz(body->positions[i]);
    }
    self_faces_find_edges(body, state);
    return PLI_OK;
}

static void self_faces_disable(pli_body* body, void* data) {
    self_faces_state* state = data;
    self_faces_release_blocks(body, state, body->node_count, body->topology->face_count);
    plii_release(body->context, state->boxes, (size_t)state->box_capacity * sizeof *state->boxes);
    plii_release(body->context, state->pairs, (size_t)state->pair_capacity * sizeof *state->pairs);
    plii_release(body->context, state->due, (size_t)state->due_capacity * sizeof *state->due);
    plii_release(body->context, state->active, (size_t)state->active_capacity * sizeof *state->active);
    plii_box_tree_free(body->context, &state->tree);
}

static size_t self_faces_bytes(const pli_body* body, const void* data) {
    const self_faces_state* state = data;
    size_t sizes[SELF_FACES_BLOCKS];
    self_faces_sizes(body->node_count, body->topology->face_count, sizes);
    size_t bytes = (size_t)state->box_capacity * sizeof *state->boxes +
                   (size_t)state->pair_capacity * sizeof *state->pairs +
                   (size_t)state->due_capacity * sizeof *state->due +
                   (size_t)state->active_capacity * sizeof *state->active + plii_box_tree_bytes(&state->tree);
    for (int i = 0; i < SELF_FACES_BLOCKS; ++i) {
        bytes += sizes[i];
    }
    return bytes;
}

static int self_faces_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                      size_t* sizes) {
    (void)body;
    (void)data;
    self_faces_sizes(change->node_count, change->face_count, sizes);
    return SELF_FACES_BLOCKS;
}

static void self_faces_topology_commit(pli_body* body, void* data, const plii_topology_change* change, void** blocks) {
    self_faces_state* state = data;
    plii_self_carry_rest(body, change, state->rest, blocks[0]);
    self_faces_release_blocks(body, state, change->old_node_count, change->old_face_count);
    self_faces_take_blocks(state, blocks);
    self_faces_find_edges(body, state);
    state->pair_count = state->active_count = 0;
    state->reach = 0.0f;
}

static const plii_feature_class self_faces_class;
static const plii_substep_class self_faces_kind = {
    .order = PLII_SUBSTEP_ORDER_SELF_FACES,
    .klass = &self_faces_class,
    .begin = self_faces_begin_substeps,
    .restart = self_faces_restart_substep,
    .sweep = self_faces_sweep,
};
static const plii_feature_class self_faces_class = {
    .name = "self-collision of faces",
    .state_size = sizeof(self_faces_state),
    .stages = {[PLII_STAGE_PREPARE] = {self_faces_run_prepare, PLII_ORDER_SELF_COLLISION},
               [PLII_STAGE_POSITION] = {self_faces_run_position, PLII_ORDER_SELF_COLLISION},
               [PLII_STAGE_FINISH] = {self_faces_run_finish, PLII_ORDER_SELF_FACES_LAST}},
    .substepped = &self_faces_kind,
    .enable = self_faces_enable,
    .disable = self_faces_disable,
    .bytes = self_faces_bytes,
    .topology_blocks = self_faces_topology_blocks,
    .topology_commit = self_faces_topology_commit,
};

// --------------------------------------------------------------------------------------------------------- settings

pli_self_faces_def pli_self_faces_def_default(void) {
    return (pli_self_faces_def){.thickness = 0.01f, .friction = 0.1f, .cookie = PLII_DEF_COOKIE};
}

pli_status pli_body_enable_self_faces(pli_body* body, const pli_self_faces_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    const pli_self_faces_def used = def != NULL ? *def : pli_self_faces_def_default();
    if (used.cookie != PLII_DEF_COOKIE) {
        return PLII_FAIL(body->context, PLI_ERROR_INVALID_DEF, "start from pli_self_faces_def_default()");
    }
    PLII_TRY(plii_self_check_value(body, used.thickness, 0.0f, PLI_MAX_COORDINATE, true, "thickness", __func__));
    PLII_TRY(plii_self_check_value(body, used.friction, 0.0f, 1.0f, false, "friction", __func__));
    PLII_TRY(plii_self_check_value(body, used.max_travel, 0.0f, PLI_MAX_COORDINATE, false, "max_travel", __func__));
    if (body->topology->face_count == 0) {
        return PLII_FAIL(body->context, PLI_ERROR_INVALID_MESH, "the body has no faces");
    }
    void* data = NULL;
    PLII_TRY(plii_feature_enable(body, &self_faces_class, &data));
    self_faces_state* state = data;
    state->def = used;
    state->reach = 0.0f;
    return PLI_OK;
}

pli_status pli_body_disable_self_faces(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    plii_feature_disable(body, &self_faces_class);
    return PLI_OK;
}

pli_self_faces_report pli_body_get_self_faces_report(const pli_body* body) {
    const self_faces_state* state =
        plii_check_body(body, __func__) == PLI_OK ? plii_feature_state(body, &self_faces_class) : NULL;
    return state != NULL ? state->report : (pli_self_faces_report){0};
}
