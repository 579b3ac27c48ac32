/* Pairs of nodes that could touch before the next search; see the header. Two nodes that go straight, i and j, come
   nearer than `distance` in the time around a moment u only if at u they are nearer than
   distance + margin_i + margin_j + (what they travel against each other between u and either end). */

#include "math/simd_float4.h"

#include "self_collision/self_node_pairs.h"

/* Of the thickness: how far a node may stray from its path before it is searched again. */
#define SELF_NODES_MIN_MARGIN 0.2f
#define SELF_NODES_MAX_MARGIN 0.5f
/* What becomes of a margin that was not needed, in a step. */
#define SELF_NODES_MARGIN_DECAY 0.9f
/* Of the thickness: the longest reach of the common search, and of nodes apart. For faster nodes a search is good for a
   shorter time. */
#define SELF_NODES_MAX_REACH 0.75f
#define SELF_NODES_MAX_REACH_APART 3.0f

/* More than folded cloth has, so that there is room before it folds. */
#define SELF_NODES_PAIRS_PER_NODE 6

// ------------------------------------------------------------------------------------------------------ paths

/* How far a node is off its path, squared; share: of the travel since the search. */
PLII_SIMD_INLINE float self_nodes_stray_squared(const plii_self_node_pairs* state, int node, float share) {
    const plii_float4 at = plii_float4_from(&state->at[node]), from = plii_float4_from(&state->searched[node]);
    const plii_float4 motion = share * plii_float4_from(&state->travel[node]);
    const plii_float4 stray = at - from - motion;
    return plii_lanes_dot(stray, stray);
}

PLII_SIMD_INLINE bool self_nodes_has_strayed(const plii_self_node_pairs* state, int node, float share) {
    const float margin = state->travel[node].w;
    return self_nodes_stray_squared(state, node, share) > margin * margin;
}

/* A node that strayed is expected to do so again; one that strays by as much as it goes has no path. */
static void self_nodes_set_travel(plii_self_node_pairs* state, int node, pli_vec3 motion, float share, float decay) {
    const float thickness = state->thickness;
    const float stray = 1.5f * sqrtf(self_nodes_stray_squared(state, node, share));
    const float before = decay * state->travel[node].w, least = SELF_NODES_MIN_MARGIN * thickness,
                most = plii_max(before, SELF_NODES_MAX_MARGIN * thickness);
    const float margin = plii_clamp(plii_max(stray, before), least, most);
    const bool is_lost = !(stray <= pli_vec3_length(motion));
    state->travel[node] = is_lost ? (pli_vec4){0, 0, 0, margin} : (pli_vec4){motion.x, motion.y, motion.z, margin};
}

static pli_vec3 self_nodes_mean_travel(const plii_self_node_pairs* state, int node_count) {
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < node_count; ++i) {
        sum = pli_vec3_add(sum, plii_xyz(state->travel[i]));
    }
    return node_count > 0 ? pli_vec3_scale(sum, 1.0f / (float)node_count) : sum;
}

/* Margin and travel beside the drift, to either side of the middle. */
static float self_nodes_reach(const plii_self_node_pairs* state, int node) {
    const pli_vec4 motion = state->travel[node];
    return motion.w + 0.5f * pli_vec3_length(pli_vec3_sub(plii_xyz(motion), state->drift));
}

// ------------------------------------------------------------------------------------------------------ pairs

/* Links that only resist bending do not keep a distance. */
static void self_nodes_mark_linked(const pli_body* body, const plii_link_graph* graph, plii_self_node_pairs* state,
                                   int node) {
    for (int k = graph->begin[node]; k < graph->begin[node + 1]; ++k) {
        const plii_half_link half = graph->halves[k];
        const bool is_bending = body->link_tags != NULL && (body->link_tags[half.link] & PLII_LINK_TAG_BENDING) != 0;
        if (!is_bending) { state->linked_to[half.neighbour] = node; }
    }
}

static bool self_nodes_reserve(const pli_body* body, plii_self_node_pairs* state, int more) {
    if (state->count <= INT32_MAX - more &&
        PLII_RESERVE(body->context, &state->pairs, &state->capacity, state->count + more)) {
        return true;
    }
    state->is_truncated = true;
    return false;
}

/* Keeps a pair that can touch, where links of `a` have been marked; `half` of the travel is on either side of a moment
   when they are so far from each other. There is room; the pair is written in any case, as hardly predictable branches
   cost more. */
static void self_nodes_keep(plii_self_node_pairs* state, int a, int b, float distance_squared, float half) {
    const plii_float4 motion = plii_float4_from(&state->travel[a]), other_travel = plii_float4_from(&state->travel[b]);
    const plii_float4 against = other_travel - motion;
    const float limit =
        state->thickness + (state->travel[a].w + state->travel[b].w) + half * sqrtf(plii_lanes_dot(against, against));
    state->pairs[state->count] = (plii_self_pair){a, b, state->thickness};
    state->count += (state->linked_to[b] != a) & (distance_squared < limit * limit);
}

/* Of pairs from `first` on: the distance to keep. Those that coincide at rest are dropped. */
static void self_nodes_set_distances(plii_self_node_pairs* state, int first) {
    int count = first;
    for (int k = first; k < state->count; ++k) {
        plii_self_pair pair = state->pairs[k];
        pair.distance =
            plii_min(state->thickness, pli_vec3_length(pli_vec3_sub(state->rest[pair.b], state->rest[pair.a])));
        state->pairs[count] = pair;
        count += pair.distance > 0.0f;
    }
    state->count = count;
}

/* Pairs of a node that is not apart with others that are not. */
static void self_nodes_find_common(const pli_body* body, const plii_link_graph* graph, plii_self_node_pairs* state,
                                   int node) {
    plii_node_pairs* near = &state->near;
    const float radius = state->thickness + 2.0f * state->reach;
    const int first = state->count;
    near->count = 0;
    if (!plii_spatial_hash_find(body->context, &state->hash, node, state->middle[node], radius, near) ||
        !self_nodes_reserve(body, state, near->count)) {
        state->is_truncated = true;
        return;
    }
    self_nodes_mark_linked(body, graph, state, node);
    for (int k = 0; k < near->count; ++k) {
        const plii_node_pair pair = near->pairs[k];
        if (state->is_apart[pair.other]) { continue; }
        self_nodes_keep(state, node, pair.other, pair.distance_squared, 0.5f);
    }
    self_nodes_set_distances(state, first);
}

static pli_vec3 self_nodes_position_at(const plii_self_node_pairs* state, int node, float share) {
    return pli_vec3_add(plii_xyz(state->searched[node]), pli_vec3_scale(plii_xyz(state->travel[node]), share));
}

/* Pairs of a node apart with all others but those apart that come later in their list, from `share` of the path on. */
static void self_nodes_find_apart(const pli_body* body, const plii_link_graph* graph, plii_self_node_pairs* state,
                                  int index, float share) {
    const int node = state->apart[index];
    const float moment = 0.5f * (1.0f + share), half = 0.5f * (1.0f - share);
    const pli_vec3 p = self_nodes_position_at(state, node, moment);
    /* The others went on from the middle, most of them with the drift. */
    const pli_vec3 centre = pli_vec3_sub(p, pli_vec3_scale(state->drift, moment - 0.5f));
    const float beside = pli_vec3_length(pli_vec3_sub(plii_xyz(state->travel[node]), state->drift));
    const float radius = state->thickness + state->travel[node].w + half * beside + state->reach;
    plii_node_pairs* near = &state->near;
    const int first = state->count;
    near->count = 0;
    if (!plii_spatial_hash_find_near(body->context, &state->hash, centre, radius, near) ||
        !self_nodes_reserve(body, state, near->count + index)) {
        state->is_truncated = true;
        return;
    }
    state->is_truncated = state->is_truncated || near->is_truncated;
    self_nodes_mark_linked(body, graph, state, node);
    for (int k = 0; k < near->count; ++k) {
        const int other = near->pairs[k].other;
        if (state->is_apart[other]) { continue; }
        const pli_vec3 to = pli_vec3_sub(self_nodes_position_at(state, other, moment), p);
        self_nodes_keep(state, node, other, pli_vec3_length_squared(to), half);
    }
    for (int k = 0; k < index; ++k) {
        const pli_vec3 to = pli_vec3_sub(self_nodes_position_at(state, state->apart[k], moment), p);
        self_nodes_keep(state, node, state->apart[k], pli_vec3_length_squared(to), half);
    }
    self_nodes_set_distances(state, first);
}

// ------------------------------------------------------------------------------------------------------ the search

/* Nodes that are searched one by one: so few that it does not matter. */
static int self_nodes_max_apart(int node_count) {
    const int most = PLII_SELF_NODES_APART + node_count / PLII_SELF_NODES_PER_APART;
    return most < 4096 ? most : 4096;
}

enum { SELF_NODES_BINS = 64 };

/* Of the reaches, the smallest bound that leaves few nodes beyond it; `longest` of all. */
static float self_nodes_common_reach(const plii_self_node_pairs* state, int node_count, float* longest) {
    float low = FLT_MAX, high = 0.0f;
    for (int i = 0; i < node_count; ++i) {
        const float reach = self_nodes_reach(state, i);
        low = reach < low ? reach : low;
        high = reach > high ? reach : high;
    }
    *longest = high;
    if (!(high > 1.01f * low) || !(high < FLT_MAX)) { return high; }
    int bins[SELF_NODES_BINS] = {0};
    const float size = (high - low) / SELF_NODES_BINS;
    for (int i = 0; i < node_count; ++i) {
        const float at = (self_nodes_reach(state, i) - low) / size; /* may be NaN */
        ++bins[at < (float)SELF_NODES_BINS ? (int)at : SELF_NODES_BINS - 1];
    }
    int beyond = 0, bin = SELF_NODES_BINS - 1;
    while (bin > 0 && beyond + bins[bin] <= self_nodes_max_apart(node_count) / 2) {
        beyond += bins[bin--];
    }
    return low + size * (float)(bin + 1);
}

static void self_nodes_scale_travel(plii_self_node_pairs* state, int node_count, float scale) {
    for (int i = 0; i < node_count; ++i) {
        plii_set_xyz(&state->travel[i], pli_vec3_scale(plii_xyz(state->travel[i]), scale));
    }
    state->drift = pli_vec3_scale(state->drift, scale);
    state->travel_time *= scale;
}

/* How long the search is good for, who is apart. */
static void self_nodes_choose_reach(plii_self_node_pairs* state, int node_count) {
    const float most = SELF_NODES_MAX_REACH * state->thickness,
                most_apart = SELF_NODES_MAX_REACH_APART * state->thickness;
    float longest = 0.0f;
    state->drift = self_nodes_mean_travel(state, node_count);
    state->reach = self_nodes_common_reach(state, node_count, &longest);
    const float scale = plii_min(1.0f, plii_min(most / state->reach, most_apart / longest));
    if (scale < 1.0f) {
        self_nodes_scale_travel(state, node_count, scale);
        state->reach = self_nodes_common_reach(state, node_count, &longest);
    }
    const int max_apart = self_nodes_max_apart(node_count);
    state->apart_count = 0;
    for (int i = 0; i < node_count; ++i) {
        state->is_apart[i] = self_nodes_reach(state, i) > state->reach && state->apart_count < max_apart;
        if (state->is_apart[i]) { state->apart[state->apart_count++] = i; }
    }
}

static bool self_nodes_build_hash(const pli_body* body, plii_self_node_pairs* state) {
    return plii_spatial_hash_build(body->context, &state->hash, body->node_count, state->middle,
                                   state->thickness + 2.0f * state->reach, 0.0f);
}

void plii_self_node_pairs_rebuild(pli_body* body, plii_self_node_pairs* state) {
    if (state->is_known && !self_nodes_build_hash(body, state)) { state->is_known = false; }
}

/* Of all nodes, along `travel`. */
static void self_nodes_search(const pli_body* body, const plii_link_graph* graph, plii_self_node_pairs* state) {
    const int node_count = body->node_count;
    self_nodes_choose_reach(state, node_count);
    for (int i = 0; i < node_count; ++i) {
        state->searched[i] = state->at[i];
        state->middle[i] = self_nodes_position_at(state, i, 0.5f);
        state->linked_to[i] = PLI_NULL_INDEX;
    }
    state->count = 0;
    state->searches += 1;
    state->is_known = false;
    state->near.is_truncated = false;
    if (!self_nodes_reserve(body, state, SELF_NODES_PAIRS_PER_NODE * node_count) ||
        !PLII_RESERVE(body->context, &state->near.pairs, &state->near.capacity, PLII_NODE_PAIRS_ROOM) ||
        !self_nodes_build_hash(body, state)) {
        state->is_truncated = true;
        return;
    }
    for (int i = 0; i < node_count; ++i) {
        if (!state->is_apart[i]) { self_nodes_find_common(body, graph, state, i); }
    }
    for (int i = 0; i < state->apart_count; ++i) {
        self_nodes_find_apart(body, graph, state, i, 0.0f);
    }
    state->is_truncated = state->is_truncated || state->near.is_truncated;
    state->is_known = !state->is_truncated;
}

bool plii_self_node_pairs_serve_on(const pli_body* body, plii_self_node_pairs* state, float thickness) {
    if (!state->is_known || state->thickness != thickness) { return false; }
    int leaving = state->apart_count;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 end =
            pli_vec3_add(plii_xyz(state->at[i]), pli_vec3_scale(plii_xyz(body->velocities[i]), body->step.dt));
        const float squared = pli_vec3_length_squared(pli_vec3_sub(end, self_nodes_position_at(state, i, 1.0f)));
        const float margin = state->travel[i].w;
        leaving += !(squared <= margin * margin);
    }
    if (leaving > self_nodes_max_apart(body->node_count) / 8 * 7) { return false; }
    state->searched_at = state->travel_time = 0.0f; /* nodes are at the ends of their paths */
    return true;
}

void plii_self_node_pairs_search_step(const pli_body* body, const plii_link_graph* graph, plii_self_node_pairs* state,
                                      pli_vec3 shift) {
    for (int i = 0; i < body->node_count; ++i) {
        plii_set_xyz(&state->searched[i], pli_vec3_add(plii_xyz(state->searched[i]), shift));
        const pli_vec3 motion = pli_vec3_scale(plii_xyz(body->velocities[i]), body->step.dt);
        self_nodes_set_travel(state, i, motion, 1.0f, SELF_NODES_MARGIN_DECAY);
    }
    state->searched_at = 0.0f;
    state->travel_time = body->step.dt;
    self_nodes_search(body, graph, state);
}

// ------------------------------------------------------------------------------------------------------ later

static int self_nodes_count_strayed(const pli_body* body, const plii_self_node_pairs* state, float share) {
    int strayed = 0;
    for (int i = 0; i < body->node_count; ++i) {
        strayed += self_nodes_has_strayed(state, i, share);
    }
    return strayed;
}

/* From the list of nodes apart; it then ends with those that strayed. Returns the index of the first of them. */
static int self_nodes_part_strayed(const pli_body* body, plii_self_node_pairs* state, float share) {
    int kept = 0;
    for (int k = 0; k < state->apart_count; ++k) {
        const int node = state->apart[k];
        if (!self_nodes_has_strayed(state, node, share)) { state->apart[kept++] = node; }
    }
    state->apart_count = kept;
    for (int i = 0; i < body->node_count; ++i) {
        if (self_nodes_has_strayed(state, i, share)) { state->apart[state->apart_count++] = i; }
    }
    int pairs = 0;
    for (int k = 0; k < state->count; ++k) {
        const plii_self_pair pair = state->pairs[k];
        if (self_nodes_has_strayed(state, pair.a, share) || self_nodes_has_strayed(state, pair.b, share)) { continue; }
        state->pairs[pairs++] = pair;
    }
    state->count = pairs;
    return kept;
}

/* A path that leads from here, as it would have begun at the search. */
static void self_nodes_set_path(plii_self_node_pairs* state, int node, pli_vec3 velocity, float share) {
    const float rest = (1.0f - share) * state->travel_time;
    self_nodes_set_travel(state, node, pli_vec3_scale(velocity, rest), share, 1.0f);
    pli_vec4* motion = &state->travel[node];
    plii_set_xyz(motion,
                 share < 1.0f ? pli_vec3_scale(plii_xyz(*motion), 1.0f / (1.0f - share)) : pli_vec3_make(0, 0, 0));
    const pli_vec3 begin = pli_vec3_sub(plii_xyz(state->at[node]), pli_vec3_scale(plii_xyz(*motion), share));
    plii_set_xyz(&state->searched[node], begin);
}

void plii_self_node_pairs_update(const pli_body* body, const plii_link_graph* graph, plii_self_node_pairs* state,
                                 const plii_self_nodes* nodes, float rate, float now, float left) {
    const float since = now - state->searched_at;
    const float share = since < state->travel_time ? since / state->travel_time : 1.0f;
    const int strayed = self_nodes_count_strayed(body, state, share);
    if (strayed == 0) { return; }
    if (strayed + state->apart_count > self_nodes_max_apart(body->node_count)) {
        for (int i = 0; i < body->node_count; ++i) {
            const pli_vec3 motion = pli_vec3_scale(plii_self_motion(nodes, i), left * rate);
            self_nodes_set_travel(state, i, motion, share, 1.0f);
        }
        state->searched_at = now;
        state->travel_time = left;
        self_nodes_search(body, graph, state);
        return;
    }
    const uint64_t shortages = plii_thread.shortages;
    const int first = self_nodes_part_strayed(body, state, share);
    for (int k = first; k < state->apart_count; ++k) {
        const int node = state->apart[k];
        state->is_apart[node] = true;
        self_nodes_set_path(state, node, pli_vec3_scale(plii_self_motion(nodes, node), rate), share);
    }
    for (int k = first; k < state->apart_count; ++k) {
        self_nodes_find_apart(body, graph, state, k, share);
    }
    /* What is missing must not be missing in the steps to come. */
    if (plii_thread.shortages != shortages) { state->is_known = false; }
}

// ------------------------------------------------------------------------------------------------------ memory

void plii_self_node_pairs_start(plii_self_node_pairs* state) {
    state->at = state->local;
    state->count = state->apart_count = 0;
    state->is_known = false;
}
