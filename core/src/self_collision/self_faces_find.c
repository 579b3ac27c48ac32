/* Which nodes and faces, and which edges, of one body could come together, and the plane between their sides. */

#include "base/csr.h"
#include "geometry/closest_point.h"
#include "math/bounds.h"
#include "math/range.h"
#include "self_collision/self_faces_impl.h"

/* Of the thickness: what rounding may take from a distance. */
#define SELF_FACES_SLACK 0.01f

// --------------------------------------------------------------------------------------------------------------- edges

/* Sorted by the first node, then looked for among those of the same node. */
void plii_self_faces_find_edges(const pli_body* body, plii_self_faces_state* state) {
    const int corner_count = 3 * body->topology->face_count;
    for (int c = 0; c < corner_count; ++c) {
        const int* face = body->topology->faces[c / 3];
        const int a = face[c % 3], b = face[(c + 1) % 3];
        state->firsts[c] = a < b ? a : b;
        state->seconds[c] = a < b ? b : a;
    }
    plii_csr_sort(body->node_count, corner_count, state->firsts, state->rows, state->corners);
    int kept = 0;
    double length = 0.0;
    for (int i = 0; i < body->node_count; ++i) {
        const int begin = kept;
        for (int k = state->rows[i]; k < state->rows[i + 1]; ++k) {
            const int other = state->seconds[state->corners[k]];
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

// ------------------------------------------------------------------------------------------------------ nearest points

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
        plii_closest_feature closest;
        (void)plii_closest_point_on_triangle(p[0], p[1], p[2], p[3], &closest);
        weights[0] = 1.0f;
        weights[1] = -closest.weights.x;
        weights[2] = -closest.weights.y;
        weights[3] = -closest.weights.z;
    }
    pli_vec3 apart = pli_vec3_make(0, 0, 0);
    for (int k = 1; k < 4; ++k) { /* about node 0: weights sum up to 0 */
        apart = pli_vec3_add(apart, pli_vec3_scale(pli_vec3_sub(p[k], p[0]), weights[k]));
    }
    return apart;
}

// ---------------------------------------------------------------------------------------------------------- the search

static pli_bounds self_faces_box(const pli_body* body, const int* nodes, int count) {
    pli_bounds box = {plii_xyz(body->previous[nodes[0]]), plii_xyz(body->previous[nodes[0]])};
    for (int k = 1; k < count; ++k) {
        box = plii_bounds_add(box, plii_xyz(body->previous[nodes[k]]));
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
    plii_self_faces_state* state;
    pli_bounds box; /* of the item */
    int item;       /* node or edge that is looked for */
    bool is_edges;
    bool has_memory;
} self_faces_search;

static void self_faces_hit(int item, void* user) {
    self_faces_search* search = user;
    plii_self_faces_state* state = search->state;
    const pli_body* body = search->body;
    plii_self_faces_pair pair = {.is_edges = search->is_edges, .target = -1.0f};
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
    plii_self_faces_state* state = search->state;
    const int targets = search->is_edges ? state->edge_count : body->topology->face_count;
    if (!PLII_RESERVE(body->context, &state->boxes, &state->box_capacity, targets)) {
        search->has_memory = false;
        return;
    }
    for (int i = 0; i < targets; ++i) {
        state->boxes[i] = search->is_edges ? self_faces_box(body, state->edges[i], 2)
                                           : self_faces_box(body, body->topology->faces[i], 3);
    }
    if (!plii_bvh_build(body->context, &state->tree, targets, state->boxes)) {
        search->has_memory = false;
        return;
    }
    const int count = search->is_edges ? state->edge_count : body->node_count;
    for (int i = 0; i < count; ++i) {
        search->item = i;
        search->box = search->is_edges ? self_faces_box(body, state->edges[i], 2) : self_faces_box(body, &i, 1);
        plii_bvh_overlaps(&state->tree, plii_bounds_grow(search->box, state->reach), self_faces_hit, search);
    }
}

/* How far nodes are about to move in this step, with some room for constraints. */
static float self_faces_wanted_travel(const pli_body* body, const plii_self_faces_state* state) {
    float squared = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 motion = pli_vec3_sub(plii_xyz(body->positions[i]), plii_xyz(body->previous[i]));
        squared = plii_max(squared, pli_vec3_length_squared(motion));
    }
    const float most = state->def.max_travel > 0.0f ? state->def.max_travel : 0.5f * state->mean_edge_length;
    return plii_min(most, 1.25f * sqrtf(squared) + 0.5f * state->def.thickness);
}

/* Counts how far nodes have got. What is not finite goes on being so, and is caught elsewhere. */
static void self_faces_count_motion(const pli_body* body, plii_self_faces_state* state, const plii_self_nodes* nodes) {
    float squared = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 x = plii_self_start(nodes, i);
        squared = plii_max(squared, pli_vec3_length_squared(pli_vec3_sub(x, state->last[i])));
        state->last[i] = x;
    }
    state->moved += sqrtf(squared) * (1.0f + 1e-5f);
}

void plii_self_faces_begin(pli_body* body, plii_self_faces_state* state) {
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

// ------------------------------------------------------------------------------------------ pairs of a step or substep

static float self_faces_distance_at_rest(const plii_self_faces_state* state, const plii_self_faces_pair* pair) {
    pli_vec3 x[4];
    float weights[4];
    for (int k = 0; k < 4; ++k) {
        x[k] = state->rest[pair->nodes[k]];
    }
    return pli_vec3_length(self_faces_nearest(x, pair->is_edges, weights));
}

/* Looks at a pair as it is at the start of a step or substep, where `last` is. True when it could come together in it
   and has a normal. */
static bool self_faces_activate(plii_self_faces_state* state, int index) {
    plii_self_faces_pair* pair = &state->pairs[index];
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

void plii_self_faces_restart(pli_body* body, plii_self_faces_state* state, const plii_self_nodes* nodes, float motion) {
    state->motion = motion;
    self_faces_count_motion(body, state, nodes);
    state->active_count = 0;
    for (int i = 0; i < state->pair_count; ++i) {
        if (state->due[i] > state->moved + motion || !self_faces_activate(state, i)) { continue; }
        if (!PLII_RESERVE(body->context, &state->active, &state->active_capacity, state->active_count + 1)) {
            state->report.is_truncated = true;
            return;
        }
        state->active[state->active_count++] = i;
    }
}
