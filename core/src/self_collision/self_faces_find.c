/* Which nodes and faces, and which edges, of one body could come together, and the plane between their sides. */

#include "base/csr.h"
#include "geometry/closest_point.h"
#include "math/bounds.h"
#include "self_collision/self_faces_impl.h"

/* Of the thickness: what rounding may take from a distance. */
#define SELF_FACES_SLACK 0.01f

/* Sorted by the first node, then looked for among those of the same node. */
void plii_self_faces_find_edges(const pli_body* body, plii_self_faces_state* state) {
    const int(*faces)[3] = (const int(*)[3])body->topology->faces;
    plii_csr_sort_edges(body->node_count, body->topology->face_count, faces, state->firsts, state->rows,
                        state->corners);
    int kept = 0;
    double length = 0.0;
    for (int i = 0; i < body->node_count; ++i) {
        const int begin = kept;
        for (int k = state->rows[i]; k < state->rows[i + 1]; ++k) {
            const int c = state->corners[k], other = faces[c / 3][c % 3] + (faces[c / 3][(c + 1) % 3] - i);
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

/* From the second side to the first between nearest points of a pair whose nodes are `at`, by index; `weights` of the
   nodes, negative on the second side. */
static pli_vec3 self_faces_nearest(const pli_vec3* at, const plii_self_faces_pair* pair, float weights[4]) {
    const int* nodes = pair->nodes;
    const pli_vec3 p[4] = {at[nodes[0]], at[nodes[1]], at[nodes[2]], at[nodes[3]]};
    if (pair->is_edges) {
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

typedef struct self_faces_search {
    pli_body* body;
    plii_self_faces_state* state;
    bool is_edges;
} self_faces_search;

/* Of one item. */
typedef struct self_faces_query {
    const self_faces_search* search;
    plii_self_faces_hits* hits;
    pli_bounds box;
    int item; /* node or edge that is looked for */
} self_faces_query;

static void self_faces_set_nodes(const self_faces_search* search, int item, int other, int nodes[4]) {
    const int *a = search->state->edges[item], *b = search->state->edges[other];
    const int* face = search->body->topology->faces[other];
    nodes[0] = search->is_edges ? a[0] : item;
    nodes[1] = search->is_edges ? a[1] : face[0];
    nodes[2] = search->is_edges ? b[0] : face[1];
    nodes[3] = search->is_edges ? b[1] : face[2];
}

static void self_faces_hit(int other, void* user) {
    self_faces_query* query = user;
    const self_faces_search* search = query->search;
    const plii_self_faces_state* state = search->state;
    const pli_body* body = search->body;
    if (search->is_edges && other <= query->item) { return; }
    int nodes[4];
    self_faces_set_nodes(search, query->item, other, nodes);
    const int second = search->is_edges ? 2 : 1; /* where that side begins */
    for (int k = second; k < 4; ++k) {
        if (nodes[k] == nodes[0] || nodes[k] == nodes[second - 1]) { return; }
    }
    const pli_bounds *a = &query->box, *b = &state->boxes[other];
    const pli_vec3 apart = plii_vec3_max(pli_vec3_sub(a->min, b->max), pli_vec3_sub(b->min, a->max));
    const float distance = pli_vec3_length(plii_vec3_max(apart, pli_vec3_make(0, 0, 0)));
    if (!(distance <= state->reach)) { return; }
    plii_self_faces_hits* hits = query->hits;
    if (!PLII_GROW(body->context, &hits->items, &hits->capacity, hits->count)) {
        hits->is_truncated = true;
        return;
    }
    hits->items[hits->count++] = (plii_self_faces_hit){query->item, other, distance};
}

static void self_faces_search_block(int begin, int end, int block, void* data) {
    const self_faces_search* search = data;
    const plii_self_faces_state* state = search->state;
    self_faces_query query = {.search = search, .hits = &search->state->hits[block]};
    query.hits->count = 0;
    query.hits->is_truncated = false;
    for (int i = begin; i < end; ++i) {
        query.item = i;
        query.box = search->is_edges ? state->boxes[i] : self_faces_box(search->body, &i, 1);
        plii_bvh_overlaps(&state->tree, plii_bounds_grow(query.box, state->reach), self_faces_hit, &query);
    }
}

/* Adds what was found to the pairs; false without memory for all of it. */
static bool self_faces_take_hits(const self_faces_search* search, const plii_self_faces_hits* hits) {
    plii_self_faces_state* state = search->state;
    pli_context* context = search->body->context;
    if (!PLII_RESERVE_MORE(context, &state->pairs, &state->pair_capacity, state->pair_count, hits->count) ||
        !PLII_RESERVE_MORE(context, &state->due, &state->due_capacity, state->pair_count, hits->count)) {
        return false;
    }
    for (int k = 0; k < hits->count; ++k) {
        const plii_self_faces_hit hit = hits->items[k];
        plii_self_faces_pair pair = {.is_edges = search->is_edges, .target = -1.0f};
        self_faces_set_nodes(search, hit.item, hit.other, pair.nodes);
        state->due[state->pair_count] = 0.5f * (hit.distance - state->def.thickness);
        state->pairs[state->pair_count++] = pair;
    }
    return !hits->is_truncated;
}

enum { SELF_FACES_ITEM_NS = 2000, SELF_FACES_PAIR_NS = 10 };
/* In the order of items, whatever the threads. */
static bool self_faces_find_pairs(self_faces_search* search, int count) {
    pli_context* context = search->body->context;
    const plii_blocks blocks = plii_blocks_of(count, plii_grain(SELF_FACES_ITEM_NS), PLII_MOST_BLOCKS);
    const bool has_threads = plii_has_threads(context);
    if (has_threads) { plii_run_blocks(context, blocks, count, self_faces_search_block, search); }
    bool has_memory = true;
    for (int b = 0; b < blocks.count; ++b) {
        const int begin = b * blocks.size, left = count - begin;
        if (!has_threads) {
            self_faces_search_block(begin, begin + (left < blocks.size ? left : blocks.size), 0, search);
        }
        has_memory = self_faces_take_hits(search, &search->state->hits[has_threads ? b : 0]) && has_memory;
    }
    return has_memory;
}

/* False when there was no memory for all. */
static bool self_faces_search_run(pli_body* body, plii_self_faces_state* state, bool is_edges) {
    self_faces_search search = {.body = body, .state = state, .is_edges = is_edges};
    const int targets = is_edges ? state->edge_count : body->topology->face_count;
    if (!PLII_RESERVE(body->context, &state->boxes, &state->box_capacity, targets)) { return false; }
    for (int i = 0; i < targets; ++i) {
        state->boxes[i] =
            is_edges ? self_faces_box(body, state->edges[i], 2) : self_faces_box(body, body->topology->faces[i], 3);
    }
    if (!plii_bvh_build(body->context, &state->tree, targets, state->boxes)) { return false; }
    return self_faces_find_pairs(&search, is_edges ? state->edge_count : body->node_count);
}

// ------------------------------------------------------------------------------------------------------------- motions

/* Beside the common motion, of all nodes or of pinned ones. */
static float self_faces_largest(const pli_body* body, const plii_substep* substep, const pli_vec3* from,
                                bool are_pinned) {
    const pli_vec3 common = plii_self_common_motion(body, substep, from);
    float squared = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        if (are_pinned && substep->displacements[i].w > 0.0f) { continue; }
        const pli_vec3 motion = pli_vec3_sub(plii_self_motion_from(body, substep, from, i), common);
        squared = plii_max(squared, pli_vec3_length_squared(motion));
    }
    return sqrtf(squared);
}

float plii_self_faces_bound(const pli_body* body, const plii_substep* substep, float room, float most) {
    const float wanted = 1.25f * self_faces_largest(body, substep, NULL, false) + room;
    return wanted > most ? plii_max(most, self_faces_largest(body, substep, NULL, true)) : wanted;
}

/* Counts how far nodes have got. What is not finite goes on being so, and is caught elsewhere. */
static void self_faces_count_motion(const pli_body* body, plii_self_faces_state* state, const plii_substep* substep) {
    state->moved += self_faces_largest(body, substep, state->last, false) * (1.0f + 1e-5f);
    for (int i = 0; i < body->node_count; ++i) {
        state->last[i] = plii_substep_start(body, substep, i);
    }
}

void plii_self_faces_begin(pli_body* body, void* data) {
    plii_self_faces_state* state = data;
    const plii_substep start = plii_substep_of_step(body, body->previous, body->previous);
    state->report = (pli_self_faces_report){.pairs = state->pair_count};
    const plii_substep predicted = plii_substep_of_step(body, body->positions, body->previous);
    const float most = state->def.max_travel > 0.0f ? state->def.max_travel : state->mean_edge_length;
    state->travel = plii_self_faces_bound(body, &predicted, 0.5f * state->def.thickness, most);
    self_faces_count_motion(body, state, &start);
    const float room = 0.5f * (state->reach - state->def.thickness);
    if (state->reach > 0.0f && state->moved + state->travel <= room) { return; }
    state->reach = state->def.thickness + 2.0f * state->travel;
    state->moved = 0.0f;
    state->pair_count = 0;
    bool has_memory = self_faces_search_run(body, state, false);
    has_memory = self_faces_search_run(body, state, true) && has_memory;
    if (!has_memory) { state->reach = 0.0f; }
    state->report.pairs = state->pair_count;
    state->report.is_truncated = !has_memory;
}

// ------------------------------------------------------------------------------------------ pairs of a step or substep

/* Looks at a pair at the start, where `last` is. True when it has a normal and could come together. */
static bool self_faces_activate(plii_self_faces_state* state, int index) {
    plii_self_faces_pair* pair = &state->pairs[index];
    const float thickness = state->def.thickness;
    const pli_vec3 apart = self_faces_nearest(state->last, pair, pair->weights);
    const float distance = pli_vec3_length(apart);
    if (!(distance > 1e-6f * thickness) || !plii_is_finite(distance)) { return false; }
    float gap = distance - (1.0f + SELF_FACES_SLACK) * thickness;
    if (gap < 2.0f * state->motion) {
        if (pair->target < 0.0f) {
            float unused[4];
            pair->target = plii_min(thickness, pli_vec3_length(self_faces_nearest(state->rest, pair, unused)));
        }
        gap = distance - pair->target - SELF_FACES_SLACK * thickness;
    }
    state->due[index] = state->moved + 0.5f * gap;
    if (gap >= 2.0f * state->motion) { return false; }
    pair->normal = plii_vec3_divide(apart, distance);
    /* The sides as they are, not as nearest points say: those are rounded. */
    float low = FLT_MAX, high = -FLT_MAX;
    const pli_vec3 first = state->last[pair->nodes[0]];
    for (int k = 0; k < 4; ++k) {
        const float level = pli_vec3_dot(pair->normal, pli_vec3_sub(state->last[pair->nodes[k]], first));
        if (k == 0 || (k == 1 && pair->is_edges)) {
            low = plii_min(low, level);
        } else {
            high = plii_max(high, level);
        }
    }
    pair->middle = 0.5f * (low + high);
    pair->distance = low - high;
    return pair->distance > 0.0f;
}

typedef struct self_faces_restart {
    const pli_body* body;
    plii_self_faces_state* state;
    int counts[PLII_MOST_BLOCKS];
} self_faces_restart;

/* Those of a block go to where it begins. Pairs of pinned nodes are kept and wait: nodes that are let go must not go
   through what they were held beside. */
static void self_faces_restart_block(int begin, int end, int block, void* data) {
    self_faces_restart* restart = data;
    plii_self_faces_state* state = restart->state;
    const pli_vec4* x = restart->body->positions;
    int count = begin;
    for (int i = begin; i < end; ++i) {
        const int* nodes = state->pairs[i].nodes;
        const bool is_due = !(state->due[i] > state->moved + state->motion);
        const bool moves = is_due && x[nodes[0]].w + x[nodes[1]].w + x[nodes[2]].w + x[nodes[3]].w > 0.0f;
        if (moves && self_faces_activate(state, i)) { state->active[count++] = i; }
    }
    restart->counts[block] = count - begin;
}

void plii_self_faces_restart(pli_body* body, plii_self_faces_state* state, const plii_substep* substep, float motion) {
    state->motion = motion;
    self_faces_count_motion(body, state, substep);
    state->active_count = 0;
    if (!PLII_RESERVE(body->context, &state->active, &state->active_capacity, state->pair_count)) {
        state->report.is_truncated = true;
        return;
    }
    const int count = state->pair_count;
    const plii_blocks blocks = plii_blocks_of(count, plii_grain(SELF_FACES_PAIR_NS), PLII_MOST_BLOCKS);
    self_faces_restart restart = {.body = body, .state = state};
    plii_run_blocks(body->context, blocks, count, self_faces_restart_block, &restart);
    for (int b = 0; b < blocks.count; ++b) {
        memmove(&state->active[state->active_count], &state->active[b * blocks.size],
                (size_t)restart.counts[b] * sizeof *state->active);
        state->active_count += restart.counts[b];
    }
}
