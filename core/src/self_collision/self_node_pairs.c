/* Pairs of nodes that could touch before the next search; see the header. Two nodes that go straight, i and j, come
   nearer than `distance` in the time around a moment u only if at u they are nearer than
   distance + margin_i + margin_j + (what they travel against each other between u and either end). */

#include "self_collision/self_node_pairs.h"
#include "body/pipeline.h"
#include "math/simd_float4.h"

/* Of the thickness: how far a node may stray from its path before it is searched again. */
#define SELF_NODES_MIN_MARGIN 0.2f
#define SELF_NODES_MAX_MARGIN 0.5f
/* What becomes of a margin that was not needed, in a step. */
#define SELF_NODES_MARGIN_DECAY 0.9f
/* Of the thickness: the longest reach. For faster nodes a search is good for a shorter time. */
#define SELF_NODES_MAX_REACH 0.75f

/* How far a node is off its path, squared; share: of the travel since the search. */
PLII_SIMD_INLINE float self_nodes_stray_squared(const plii_self_node_pairs* state, int node, float share) {
    const plii_float4 at = plii_float4_from(&state->at[node]), from = plii_float4_from(&state->searched[node]);
    const plii_float4 motion = share * plii_float4_from(&state->travel[node]);
    const plii_float4 stray = at - from - motion;
    return plii_lanes_dot(stray, stray);
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

// ------------------------------------------------------------------------------------------------------ pairs

/* Who looks for the pairs of single nodes, and where they go. */
typedef struct self_nodes_finder {
    const pli_body* body;
    const plii_link_graph* graph;
    const plii_self_node_pairs* state;
    plii_self_search* search;
    plii_self_pair_list* found;
} self_nodes_finder;

/* A mark that no node has. */
static void self_nodes_renew_mark(const pli_body* body, plii_self_search* search) {
    if (++search->mark != 0) { return; }
    memset(search->linked, 0, (size_t)body->node_count * sizeof *search->linked);
    search->mark = 1;
}

/* Links that only resist bending do not keep a distance. */
static void self_nodes_mark_linked(const self_nodes_finder* finder, int node) {
    const pli_body* body = finder->body;
    const plii_link_graph* graph = finder->graph;
    plii_self_search* search = finder->search;
    self_nodes_renew_mark(body, search);
    for (int k = graph->begin[node]; k < graph->begin[node + 1]; ++k) {
        const plii_half_link half = graph->halves[k];
        if (!plii_link_is_bending(body, half.link)) { search->linked[half.neighbour] = search->mark; }
    }
}

static bool self_nodes_reserve(pli_context* context, plii_self_pair_list* found, int more) {
    return PLII_RESERVE_MORE(context, &found->items, &found->capacity, found->count, more);
}

/* Keeps a pair that can touch, where links of `a` are marked; `half` of the travel is on either side of a moment when
   they are so far apart. There is room; it is written in any case, as branches that are hard to predict cost more. */
static void self_nodes_keep(const self_nodes_finder* finder, int a, int b, float distance_squared, float half) {
    const plii_self_node_pairs* state = finder->state;
    plii_self_pair_list* found = finder->found;
    const plii_float4 motion = plii_float4_from(&state->travel[a]), other_travel = plii_float4_from(&state->travel[b]);
    const plii_float4 against = other_travel - motion;
    const float limit =
        state->thickness + (state->travel[a].w + state->travel[b].w) + half * sqrtf(plii_lanes_dot(against, against));
    found->items[found->count] = (plii_self_pair){a, b, state->thickness};
    found->count += (finder->search->linked[b] != finder->search->mark) & (distance_squared < limit * limit);
}

/* Of pairs from `first` on: the distance to keep. Those that coincide at rest are dropped. */
static void self_nodes_set_distances(const self_nodes_finder* finder, int first) {
    const plii_self_node_pairs* state = finder->state;
    plii_self_pair_list* found = finder->found;
    int count = first;
    for (int k = first; k < found->count; ++k) {
        plii_self_pair pair = found->items[k];
        pair.distance =
            plii_min(state->thickness, pli_vec3_length(pli_vec3_sub(state->rest[pair.b], state->rest[pair.a])));
        found->items[count] = pair;
        count += pair.distance > 0.0f;
    }
    found->count = count;
}

/* Pairs of a node in a search of all. */
static void self_nodes_find_common(self_nodes_finder* finder, int node) {
    const plii_self_node_pairs* state = finder->state;
    pli_context* context = finder->body->context;
    plii_node_pairs* near = &finder->search->near;
    const float radius = state->thickness + 2.0f * state->reach;
    const int first = finder->found->count;
    near->count = 0;
    plii_spatial_hash_find(context, &state->hash, node, state->middle[node], radius, near);
    if (!self_nodes_reserve(context, finder->found, near->count)) {
        near->is_truncated = true;
        return;
    }
    self_nodes_mark_linked(finder, node);
    for (int k = 0; k < near->count; ++k) {
        self_nodes_keep(finder, node, near->pairs[k].other, near->pairs[k].distance_squared, 0.5f);
    }
    self_nodes_set_distances(finder, first);
}

static pli_vec3 self_nodes_position_at(const plii_self_node_pairs* state, int node, float share) {
    return pli_vec3_add(plii_xyz(state->searched[node]), pli_vec3_scale(plii_xyz(state->travel[node]), share));
}

/* Pairs of a node apart with all others but those apart that come later in their list, from `share` of the path on. */
static void self_nodes_find_apart(self_nodes_finder* finder, int index, float share) {
    const plii_self_node_pairs* state = finder->state;
    pli_context* context = finder->body->context;
    const int node = state->apart[index];
    const float moment = 0.5f * (1.0f + share), half = 0.5f * (1.0f - share);
    const pli_vec3 p = self_nodes_position_at(state, node, moment);
    /* The others went on from the middle, most of them with the drift. */
    const pli_vec3 centre = pli_vec3_sub(p, pli_vec3_scale(state->drift, moment - 0.5f));
    const float beside = pli_vec3_length(pli_vec3_sub(plii_xyz(state->travel[node]), state->drift));
    const float radius = state->thickness + state->travel[node].w + half * beside + state->reach;
    plii_node_pairs* near = &finder->search->near;
    const int first = finder->found->count;
    near->count = 0;
    if (!plii_spatial_hash_find_near(context, &state->hash, centre, radius, near) ||
        !self_nodes_reserve(context, finder->found, near->count + index)) {
        near->is_truncated = true;
        return;
    }
    self_nodes_mark_linked(finder, node);
    for (int k = 0; k < near->count; ++k) {
        const int other = near->pairs[k].other;
        if (state->is_apart[other]) { continue; }
        const pli_vec3 to = pli_vec3_sub(self_nodes_position_at(state, other, moment), p);
        self_nodes_keep(finder, node, other, pli_vec3_length_squared(to), half);
    }
    for (int k = 0; k < index; ++k) {
        const pli_vec3 to = pli_vec3_sub(self_nodes_position_at(state, state->apart[k], moment), p);
        self_nodes_keep(finder, node, state->apart[k], pli_vec3_length_squared(to), half);
    }
    self_nodes_set_distances(finder, first);
}

// ---------------------------------------------------------------------------------------------------------- in blocks

/* Of a pass over all nodes, or in a search over them as the hash has them or over nodes apart from `first` on. */
typedef struct self_nodes_pass {
    const pli_body* body;
    plii_self_node_pairs* state;
    float share; /* of the travel since the search */
    bool is_apart;
    int first;
    const plii_substep* substep; /* in which nodes move; NULL: by their velocities */
    const pli_vec3* origin;      /* of positions that are taken over, or NULL */
    pli_vec3 shift;
    float scale, decay; /* of motions; of margins */
} self_nodes_pass;

/* True when some are missing. */
static bool self_nodes_find_some(const self_nodes_pass* pass, int begin, int end, plii_self_search* search,
                                 plii_self_pair_list* found) {
    const plii_link_graph* graph = plii_feature_state(pass->body, &plii_link_graph_class);
    self_nodes_finder finder = {pass->body, graph, pass->state, search, found};
    search->near.is_truncated = false;
    for (int i = begin; i < end; ++i) {
        if (pass->is_apart) {
            self_nodes_find_apart(&finder, pass->first + i, pass->share);
        } else {
            self_nodes_find_common(&finder, pass->state->hash.nodes[i]);
        }
    }
    return search->near.is_truncated;
}

static void self_nodes_find_block(int begin, int end, int block, void* data) {
    const self_nodes_pass* pass = data;
    plii_self_search_part* part = &pass->state->parts[block];
    part->found.count = 0;
    part->is_truncated = self_nodes_find_some(pass, begin, end, &part->search, &part->found);
}

/* For a search in so many blocks; false without memory. */
static bool self_nodes_reserve_parts(const pli_body* body, plii_self_node_pairs* state, plii_blocks blocks) {
    pli_context* context = body->context;
    for (PLII_EACH(plii_self_search_part, part, state->parts, blocks.count)) {
        plii_self_search* search = &part->search;
        if (!PLII_RESERVE(context, &search->linked, &search->linked_capacity, body->node_count) ||
            !PLII_RESERVE(context, &search->near.pairs, &search->near.capacity, PLII_NODE_PAIRS_ROOM) ||
            !PLII_RESERVE(context, &part->found.items, &part->found.capacity, PLII_SELF_PAIRS_PER_NODE * blocks.size)) {
            return false;
        }
    }
    return true;
}

enum { SELF_NODES_COMMON_NS = 300, SELF_NODES_APART_NS = 1500 }; /* per node */
/* Adds the pairs of so many nodes, in their order, whatever the threads. */
static void self_nodes_find(self_nodes_pass* pass, int count) {
    const pli_body* body = pass->body;
    plii_self_node_pairs* state = pass->state;
    const int grain = plii_grain(pass->is_apart ? SELF_NODES_APART_NS : SELF_NODES_COMMON_NS);
    const plii_blocks blocks = plii_blocks_of(count, grain, PLII_SELF_SEARCH_PARTS);
    if (blocks.count <= 1 || !plii_has_threads(body->context) || !self_nodes_reserve_parts(body, state, blocks)) {
        state->is_truncated =
            self_nodes_find_some(pass, 0, count, &state->search, &state->found) || state->is_truncated;
        return;
    }
    plii_run_blocks(body->context, blocks, count, self_nodes_find_block, pass);
    for (PLII_EACH(const plii_self_search_part, part, state->parts, blocks.count)) {
        const int more = part->found.count;
        const bool has_memory = self_nodes_reserve(body->context, &state->found, more);
        state->is_truncated = state->is_truncated || part->is_truncated || !has_memory;
        if (!has_memory || more == 0) { continue; }
        memcpy(&state->found.items[state->found.count], part->found.items, (size_t)more * sizeof *part->found.items);
        state->found.count += more;
    }
}

// ------------------------------------------------------------------------------------------------------ the search

/* Nodes that are searched one by one: so few that it does not matter. */
static int self_nodes_max_apart(int node_count) {
    const int most = PLII_SELF_NODES_APART + node_count / PLII_SELF_NODES_PER_APART;
    return most < 4096 ? most : 4096;
}

enum { SELF_NODES_PATH_NS = 5, SELF_NODES_COPY_NS = 3 }; /* per node */
/* Margin and travel beside the drift, to either side of the middle. */
static float self_nodes_longest_reach(const pli_body* body, const plii_self_node_pairs* state) {
    float longest = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec4 motion = state->travel[i];
        const float beside = pli_vec3_length(pli_vec3_sub(plii_xyz(motion), state->drift));
        longest = plii_max(longest, motion.w + 0.5f * beside);
    }
    return longest;
}

/* How long the search is good for. */
static void self_nodes_choose_reach(const pli_body* body, plii_self_node_pairs* state) {
    const float most = SELF_NODES_MAX_REACH * state->thickness;
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < body->node_count; ++i) {
        sum = pli_vec3_add(sum, plii_xyz(state->travel[i]));
    }
    state->drift = pli_vec3_scale(sum, 1.0f / (float)body->node_count);
    state->reach = self_nodes_longest_reach(body, state);
    if (!(state->reach > most)) { return; }
    const float scale = most / state->reach;
    for (int i = 0; i < body->node_count; ++i) {
        plii_set_xyz(&state->travel[i], pli_vec3_scale(plii_xyz(state->travel[i]), scale));
    }
    state->drift = pli_vec3_scale(state->drift, scale);
    state->travel_time *= scale;
    state->reach = self_nodes_longest_reach(body, state);
}

static bool self_nodes_build_hash(const pli_body* body, plii_self_node_pairs* state) {
    return plii_spatial_hash_build(body->context, &state->hash, body->node_count, state->middle,
                                   state->thickness + 2.0f * state->reach, 0.0f);
}

void plii_self_node_pairs_rebuild(pli_body* body, plii_self_node_pairs* state) {
    if (state->is_known && !self_nodes_build_hash(body, state)) { state->is_known = false; }
}

/* Of all nodes, along `travel`. */
static void self_nodes_search(const pli_body* body, plii_self_node_pairs* state) {
    const int node_count = body->node_count;
    pli_context* context = body->context;
    plii_node_pairs* near = &state->search.near;
    self_nodes_choose_reach(body, state);
    memset(state->is_apart, 0, (size_t)node_count * sizeof *state->is_apart);
    state->apart_count = 0;
    for (int i = 0; i < node_count; ++i) {
        state->searched[i] = state->at[i];
        state->middle[i] = self_nodes_position_at(state, i, 0.5f);
    }
    state->found.count = 0;
    state->searches += 1;
    state->is_known = false;
    if (!self_nodes_reserve(context, &state->found, PLII_SELF_PAIRS_PER_NODE * node_count) ||
        !PLII_RESERVE(context, &near->pairs, &near->capacity, PLII_NODE_PAIRS_ROOM) ||
        !self_nodes_build_hash(body, state)) {
        state->is_truncated = true;
        return;
    }
    self_nodes_pass pass = {.body = body, .state = state};
    self_nodes_find(&pass, node_count);
    state->is_known = !state->is_truncated;
}

static double self_nodes_leaving_block(int begin, int end, const void* data) {
    const self_nodes_pass* pass = data;
    const pli_body* body = pass->body;
    const plii_self_node_pairs* state = pass->state;
    int leaving = 0;
    for (int i = begin; i < end; ++i) {
        const pli_vec3 to =
            pli_vec3_add(plii_xyz(state->at[i]), pli_vec3_scale(plii_xyz(body->velocities[i]), body->step.dt));
        const float squared = pli_vec3_length_squared(pli_vec3_sub(to, self_nodes_position_at(state, i, 1.0f)));
        const float margin = state->travel[i].w;
        leaving += !(squared <= margin * margin);
    }
    return leaving;
}

static void self_nodes_copy_range(int begin, int end, void* data) {
    const self_nodes_pass* pass = data;
    const plii_substep* substep = pass->substep;
    const pli_vec4* bases = substep->is_absolute ? NULL : pass->body->positions;
    const plii_float4 origin = plii_lanes_from_vec3(pass->origin);
    for (int i = begin; i < end; ++i) {
        const plii_float4 base = bases != NULL ? plii_lanes_xyz(plii_float4_from(&bases[i])) : plii_float4_all(0.0f);
        plii_float4_to(&pass->state->local[i], base - origin + plii_float4_from(&substep->displacements[i]));
    }
}

void plii_self_node_pairs_copy(const pli_body* body, plii_self_node_pairs* state, const plii_substep* substep,
                               const pli_vec3* origin) {
    self_nodes_pass pass = {.body = body, .state = state, .substep = substep, .origin = origin};
    state->at = state->local;
    plii_parallel_for(body->context, self_nodes_copy_range, &pass, body->node_count, plii_grain(SELF_NODES_COPY_NS));
}

/* Those that strayed are marked. */
static double self_nodes_strayed_block(int begin, int end, const void* data) {
    const self_nodes_pass* pass = data;
    int strayed = 0;
    if (pass->origin != NULL) { self_nodes_copy_range(begin, end, (void*)data); }
    for (int i = begin; i < end; ++i) {
        const float margin = pass->state->travel[i].w;
        if (!(self_nodes_stray_squared(pass->state, i, pass->share) > margin * margin)) { continue; }
        pass->state->search.linked[i] = pass->state->search.mark;
        strayed += 1;
    }
    return strayed;
}

static int self_nodes_count(const self_nodes_pass* pass, plii_block_value_fn* value) {
    const pli_body* body = pass->body;
    return (int)plii_sum_blocks(body->context, body->node_count, plii_grain(SELF_NODES_PATH_NS), value, pass);
}

bool plii_self_node_pairs_serve_on(const pli_body* body, plii_self_node_pairs* state, float thickness) {
    if (!state->is_known || state->thickness != thickness) { return false; }
    const self_nodes_pass pass = {.body = body, .state = state};
    const int leaving = state->apart_count + self_nodes_count(&pass, self_nodes_leaving_block);
    if (leaving > self_nodes_max_apart(body->node_count) / 8 * 7) { return false; }
    state->searched_at = state->travel_time = 0.0f; /* nodes are at the ends of their paths */
    return true;
}

static void self_nodes_travel_range(int begin, int end, void* data) {
    const self_nodes_pass* pass = data;
    for (int i = begin; i < end; ++i) {
        const pli_vec3 motion =
            pass->substep != NULL ? plii_substep_motion(pass->substep, i) : plii_xyz(pass->body->velocities[i]);
        plii_add_xyz(&pass->state->searched[i], pass->shift);
        self_nodes_set_travel(pass->state, i, pli_vec3_scale(motion, pass->scale), pass->share, pass->decay);
    }
}

/* Of all nodes, which go on for `time`, from `now` on. */
static void self_nodes_search_all(self_nodes_pass* pass, float now, float time) {
    const pli_body* body = pass->body;
    plii_parallel_for(body->context, self_nodes_travel_range, pass, body->node_count, plii_grain(SELF_NODES_PATH_NS));
    pass->state->searched_at = now;
    pass->state->travel_time = time;
    self_nodes_search(body, pass->state);
}

void plii_self_node_pairs_search_step(const pli_body* body, plii_self_node_pairs* state, pli_vec3 shift) {
    const float dt = body->step.dt;
    self_nodes_pass pass = {body, state, 1.0f, .shift = shift, .scale = dt, .decay = SELF_NODES_MARGIN_DECAY};
    self_nodes_search_all(&pass, 0.0f, dt);
}

// ------------------------------------------------------------------------------------------------------ later

/* Keeps pairs of nodes that have no mark; without branches, which would be hard to predict. */
static void self_nodes_drop_marked(plii_self_node_pairs* state) {
    const plii_self_search* search = &state->search;
    plii_self_pair_list* found = &state->found;
    int count = 0;
    for (int k = 0; k < found->count; ++k) {
        const plii_self_pair pair = found->items[k];
        found->items[count] = pair;
        count += (search->linked[pair.a] != search->mark) & (search->linked[pair.b] != search->mark);
    }
    found->count = count;
}

/* The list of nodes apart then ends with those that strayed. Returns the index of the first of them. */
static int self_nodes_part_strayed(const pli_body* body, plii_self_node_pairs* state) {
    const plii_self_search* search = &state->search;
    PLII_REMOVE_IF(int, node, state->apart, state->apart_count, search->linked[*node] == search->mark);
    const int first = state->apart_count;
    for (int i = 0; i < body->node_count; ++i) {
        if (search->linked[i] == search->mark) { state->apart[state->apart_count++] = i; }
    }
    self_nodes_drop_marked(state);
    return first;
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

void plii_self_node_pairs_update(const pli_body* body, plii_self_node_pairs* state, const plii_substep* substep,
                                 const pli_vec3* origin) {
    const float rate = substep->inverse_dt, now = (float)(substep->index + 1) * substep->dt, left = body->step.dt - now;
    const float since = now - state->searched_at;
    const float share = since < state->travel_time ? since / state->travel_time : 1.0f;
    self_nodes_pass pass = {body, state, share, false, 0, substep, origin, {0, 0, 0}, left * rate, 1.0f};
    self_nodes_renew_mark(body, &state->search);
    const int strayed = self_nodes_count(&pass, self_nodes_strayed_block);
    if (strayed == 0) { return; }
    if (strayed + state->apart_count > self_nodes_max_apart(body->node_count)) {
        self_nodes_search_all(&pass, now, left);
        return;
    }
    const uint64_t shortages = plii_thread.shortages;
    const int first = self_nodes_part_strayed(body, state);
    for (int k = first; k < state->apart_count; ++k) {
        const int node = state->apart[k];
        state->is_apart[node] = true;
        self_nodes_set_path(state, node, pli_vec3_scale(plii_substep_motion(substep, node), rate), share);
    }
    pass.is_apart = true;
    pass.first = first;
    self_nodes_find(&pass, state->apart_count - first);
    /* What is missing must not be missing in the steps to come. */
    if (plii_thread.shortages != shortages) { state->is_known = false; }
}

void plii_self_node_pairs_start(plii_self_node_pairs* state) {
    state->at = state->local;
    state->found.count = state->apart_count = 0;
    state->is_known = false;
}
