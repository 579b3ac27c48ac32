/* Self-collision of nodes: pairs from a dense hash, once per step; distances at rest count as the thickness where they
   are smaller; a speed limit; friction towards the mean motion of a pair. Mueller, "Ten Minute Physics" 15.

   Pairs are kept that could touch if nodes went on as they do, with a margin for what constraints change. When a node
   has since left its way by more than its margin the search is repeated; so no pair is missed, with a speed limit or
   without. Nodes that stray get larger margins. */

#include "link_graph.h"
#include "node_hash.h"
#include "self_collision_impl.h"

/* Of the thickness: how far a node may stray from its way before the search is repeated. */
#define SELF_NODES_MIN_MARGIN 0.25f
#define SELF_NODES_MAX_MARGIN 0.5f
/* The same where a step solves once. */
#define SELF_NODES_MAX_STEP_MARGIN 1.0f
/* What becomes of a margin that was not needed, in a step. */
#define SELF_NODES_MARGIN_DECAY 0.9f
/* Of the thickness: how far nodes may go against each other, in the time that one search is good for. */
#define SELF_NODES_MAX_TRAVEL 1.0f

typedef struct self_nodes_state {
    pli_self_collision_def def;
    pli_vec3* rest;     /* [node_count] positions, as all that follow */
    pli_vec3 origin;    /* of the positions below, which are small that way, and precise */
    pli_vec4* at;       /* now; w = inverse mass */
    pli_vec4* searched; /* at the last search */
    pli_vec4* travel;   /* expected from there to the end of the step; w = margin, m */
    pli_vec3* middle;   /* half way */
    float searched_at;  /* s since the start of the step */
    float travel_time;  /* s, that the travel takes */
    plii_node_hash hash;
    plii_node_pairs pairs; /* second field of each: the distance to keep, m */
    int (*touching)[2];    /* pairs that the last sweep parted */
    int touching_count, touching_capacity;
    pli_self_collision_report report;
} self_nodes_state;

// ------------------------------------------------------------------------------------------------------ the search

/* Largest difference of two of the vectors, in a bound. */
typedef struct self_nodes_spread {
    float low[4], high[4];
} self_nodes_spread;

static self_nodes_spread self_nodes_no_spread(void) {
    return (self_nodes_spread){{FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX, -FLT_MAX}};
}

static void self_nodes_widen(self_nodes_spread* spread, pli_vec4 v) {
    const float values[4] = {v.x, v.y, v.z, 0.0f};
    for (int k = 0; k < 4; ++k) {
        spread->low[k] = values[k] < spread->low[k] ? values[k] : spread->low[k];
        spread->high[k] = values[k] > spread->high[k] ? values[k] : spread->high[k];
    }
}

static float self_nodes_extent(const self_nodes_spread* spread) {
    float squared = 0.0f;
    for (int k = 0; k < 3; ++k) {
        const float size = spread->high[k] - spread->low[k];
        squared += size * size;
    }
    return sqrtf(squared);
}

/* Takes positions over, relative to the origin. */
static void self_nodes_take_positions(const pli_body* body, self_nodes_state* state, const plii_self_nodes* nodes) {
    const pli_vec3 o = state->origin;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec4 offset = nodes->offsets[i];
        const pli_vec4 base = nodes->bases != NULL ? nodes->bases[i] : (pli_vec4){0};
        state->at[i] =
            (pli_vec4){(base.x - o.x) + offset.x, (base.y - o.y) + offset.y, (base.z - o.z) + offset.z, offset.w};
    }
}

/* How far a node is off its way, squared; share: of the travel since the search. */
static float self_nodes_stray_squared(const self_nodes_state* state, int node, float share) {
    const pli_vec4 at = state->at[node], from = state->searched[node], way = state->travel[node];
    const float x = at.x - from.x - share * way.x, y = at.y - from.y - share * way.y, z = at.z - from.z - share * way.z;
    return x * x + y * y + z * z;
}

static bool self_nodes_are_on_their_way(const pli_body* body, const self_nodes_state* state, float share) {
    int strayed = 0;
    for (int i = 0; i < body->node_count; ++i) {
        const float margin = state->travel[i].w;
        strayed += self_nodes_stray_squared(state, i, share) > margin * margin;
    }
    return strayed == 0;
}

/* A node that strayed is expected to do so again; one that strays by as much as it goes has no way. */
static void self_nodes_set_travel(self_nodes_state* state, int node, pli_vec3 way, float share, float decay) {
    const float thickness = state->def.thickness;
    const float stray = 1.5f * sqrtf(self_nodes_stray_squared(state, node, share));
    const float margin = plii_clamp(plii_max(stray, decay * state->travel[node].w), SELF_NODES_MIN_MARGIN * thickness,
                                    SELF_NODES_MAX_MARGIN * thickness);
    const bool is_lost = stray > pli_vec3_length(way);
    state->travel[node] = is_lost ? (pli_vec4){0, 0, 0, margin} : (pli_vec4){way.x, way.y, way.z, margin};
}

/* By a link that keeps their distance; one that only resists bending does not. */
static bool self_nodes_are_linked(const pli_body* body, const plii_link_graph* graph, int a, int b) {
    for (int k = graph->begin[a]; k < graph->begin[a + 1]; ++k) {
        if (graph->halves[k].neighbour != b) { continue; }
        if (body->link_tags == NULL || (body->link_tags[graph->halves[k].link] & PLII_LINK_TAG_BENDING) == 0) {
            return true;
        }
    }
    return false;
}

/* Replaces distances by the ones to keep. Drops what cannot touch before the next search, being further apart half way
   than the pair can come nearer in either half, and what links keep apart already. */
static void self_nodes_take_targets(const pli_body* body, self_nodes_state* state) {
    const plii_link_graph* graph = plii_feature_state(body, &plii_link_graph_class);
    plii_node_pairs* pairs = &state->pairs;
    const float thickness = state->def.thickness;
    int kept = 0, begin = 0;
    for (int i = 0; i < pairs->row_count; ++i) {
        const int end = pairs->begin[i + 1];
        const pli_vec3 rest = state->rest[i];
        const pli_vec4 way = state->travel[i];
        for (int k = begin; k < end; ++k) {
            const plii_node_pair pair = pairs->pairs[k];
            const pli_vec4 other_way = state->travel[pair.other];
            const float x = other_way.x - way.x, y = other_way.y - way.y, z = other_way.z - way.z;
            const float margins = way.w + other_way.w;
            const float most = thickness + margins + 0.5f * (fabsf(x) + fabsf(y) + fabsf(z)); /* most end here */
            if (!(pair.distance_squared < most * most)) { continue; }
            const pli_vec3 apart = pli_vec3_sub(state->rest[pair.other], rest);
            const float target = plii_min(thickness, pli_vec3_length(apart));
            const float limit = target + margins + 0.5f * sqrtf(x * x + y * y + z * z);
            if (!(pair.distance_squared < limit * limit) || !(target > 0.0f)) { continue; }
            if (!self_nodes_are_linked(body, graph, i, pair.other)) {
                pairs->pairs[kept++] = (plii_node_pair){pair.other, target};
            }
        }
        begin = end;
        pairs->begin[i + 1] = kept;
    }
    pairs->count = kept;
}

/* Searches from the positions taken over last, along `travel`. */
static void self_nodes_search(pli_body* body, self_nodes_state* state) {
    pli_context* context = body->context;
    self_nodes_spread spread = self_nodes_no_spread();
    float margin = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        self_nodes_widen(&spread, state->travel[i]);
        margin = plii_max(margin, state->travel[i].w);
    }
    /* Beyond what a search is good for nodes are off their way, and it is repeated. */
    const float extent = self_nodes_extent(&spread), longest = SELF_NODES_MAX_TRAVEL * state->def.thickness;
    const float scale = extent > longest ? longest / extent : 1.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec4 at = state->at[i];
        const pli_vec3 way = pli_vec3_scale(plii_xyz(state->travel[i]), scale);
        state->searched[i] = at;
        plii_set_xyz(&state->travel[i], way);
        state->middle[i] = pli_vec3_add(plii_xyz(at), pli_vec3_scale(way, 0.5f));
    }
    state->travel_time *= scale;
    const float radius = state->def.thickness + 2.0f * margin + 0.5f * plii_min(extent, longest);
    const bool has_memory =
        plii_node_hash_build(context, &state->hash, body->node_count, state->middle, radius, 0.0f) &&
        plii_node_hash_find(context, &state->hash, state->middle, radius, &state->pairs);
    if (!has_memory) { state->pairs.count = state->pairs.row_count = 0; }
    self_nodes_take_targets(body, state);
    const bool has_room = !body->solver_class->has_substeps ||
                          PLII_RESERVE(context, &state->touching, &state->touching_capacity, state->pairs.count);
    state->report.pairs = state->pairs.count;
    state->report.searches += 1;
    state->report.is_cut_short = state->report.is_cut_short || !has_memory || !has_room || state->pairs.is_cut_short;
}

static void self_nodes_start_report(const pli_body* body, self_nodes_state* state, const plii_self_nodes* nodes) {
    const int limited = state->report.limited_nodes; /* by the UPDATE stage of this step */
    state->report = (pli_self_collision_report){.limited_nodes = body->solver_class->has_substeps ? 0 : limited};
    state->origin = body->node_count > 0 ? plii_self_position(nodes, 0) : pli_vec3_make(0, 0, 0);
    if (!plii_vec3_is_finite(state->origin)) { state->origin = pli_vec3_make(0, 0, 0); }
}

/* At predicted positions: from there constraints move nodes by about what the prediction did. */
static void self_nodes_begin(pli_body* body, self_nodes_state* state, const plii_self_nodes* nodes) {
    const float thickness = state->def.thickness;
    self_nodes_spread spread = self_nodes_no_spread();
    self_nodes_start_report(body, state, nodes);
    self_nodes_take_positions(body, state, nodes);
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 moved = plii_self_motion(nodes, i);
        self_nodes_widen(&spread, (pli_vec4){moved.x, moved.y, moved.z, 0.0f});
    }
    const float margin = plii_clamp(0.5f * self_nodes_extent(&spread) + SELF_NODES_MIN_MARGIN * thickness,
                                    SELF_NODES_MIN_MARGIN * thickness, SELF_NODES_MAX_STEP_MARGIN * thickness);
    for (int i = 0; i < body->node_count; ++i) {
        state->travel[i] = (pli_vec4){0, 0, 0, margin};
    }
    self_nodes_search(body, state);
}

/* At the start of a step with substeps. */
static void self_nodes_begin_substeps(pli_body* body, void* data) {
    self_nodes_state* state = data;
    const plii_self_nodes nodes = {NULL, body->previous, body->previous};
    const pli_vec3 origin = state->origin;
    self_nodes_start_report(body, state, &nodes);
    self_nodes_take_positions(body, state, &nodes);
    const pli_vec3 shift = pli_vec3_sub(origin, state->origin); /* of what is known from the step before */
    for (int i = 0; i < body->node_count; ++i) {
        plii_set_xyz(&state->searched[i], pli_vec3_add(plii_xyz(state->searched[i]), shift));
        const pli_vec3 way = pli_vec3_scale(plii_xyz(body->velocities[i]), body->step.dt);
        self_nodes_set_travel(state, i, way, 1.0f, SELF_NODES_MARGIN_DECAY);
    }
    state->searched_at = 0.0f;
    state->travel_time = body->step.dt;
    self_nodes_search(body, state);
}

// ------------------------------------------------------------------------------------------------------ the solve

/* Scale of a motion that is too long, else 1. */
static float self_nodes_limit_scale(const self_nodes_state* state, pli_vec3 motion) {
    const float limit = state->def.speed_limit_ratio * state->def.thickness;
    const float squared = pli_vec3_length_squared(motion);
    return squared > limit * limit ? limit / sqrtf(squared) : 1.0f;
}

static void self_nodes_limit(const pli_body* body, self_nodes_state* state, const plii_self_nodes* nodes) {
    if (!(state->def.speed_limit_ratio > 0.0f)) { return; }
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 motion = plii_self_motion(nodes, i);
        const float scale = self_nodes_limit_scale(state, motion);
        if (scale < 1.0f && nodes->offsets[i].w > 0.0f) {
            plii_set_xyz(&nodes->offsets[i], pli_vec3_add(plii_xyz(nodes->starts[i]), pli_vec3_scale(motion, scale)));
            state->report.limited_nodes += 1;
        }
    }
}

static void self_nodes_move(const plii_self_nodes* nodes, pli_vec4* at, int node, pli_vec3 move) {
    pli_vec4* offset = &nodes->offsets[node];
    plii_set_xyz(offset, pli_vec3_add(plii_xyz(*offset), move));
    plii_set_xyz(&at[node], pli_vec3_add(plii_xyz(at[node]), move));
}

/* Of a pair that is too near. True when one of them can move. */
static bool self_nodes_part(const plii_self_nodes* nodes, pli_vec4* at, int a, int b, float target, float friction) {
    const float weight = at[a].w + at[b].w;
    if (!(weight > 0.0f)) { return false; }
    const pli_vec3 apart = pli_vec3_sub(plii_xyz(at[b]), plii_xyz(at[a]));
    const float distance = pli_vec3_length(apart), share_a = at[a].w / weight, share_b = 1.0f - share_a;
    const pli_vec3 n = distance > 1e-6f * target ? plii_vec3_divide(apart, distance) : plii_self_direction(a, b);
    const pli_vec3 push = pli_vec3_scale(n, target - distance);
    self_nodes_move(nodes, at, a, pli_vec3_scale(push, -share_a));
    self_nodes_move(nodes, at, b, pli_vec3_scale(push, share_b));
    if (friction > 0.0f) {
        const pli_vec3 motion = pli_vec3_sub(plii_self_motion(nodes, b), plii_self_motion(nodes, a));
        self_nodes_move(nodes, at, a, pli_vec3_scale(motion, friction * share_a));
        self_nodes_move(nodes, at, b, pli_vec3_scale(motion, -friction * share_b));
    }
    return true;
}

static void self_nodes_part_all(self_nodes_state* state, const plii_self_nodes* nodes, float friction) {
    const plii_node_pairs* pairs = &state->pairs;
    pli_vec4* at = state->at;
    int touching = 0;
    for (int i = 0; i < pairs->row_count; ++i) {
        for (int k = pairs->begin[i]; k < pairs->begin[i + 1]; ++k) {
            const int other = pairs->pairs[k].other;
            const float target = pairs->pairs[k].distance_squared;
            const float x = at[other].x - at[i].x, y = at[other].y - at[i].y, z = at[other].z - at[i].z;
            if (!(x * x + y * y + z * z < target * target)) { continue; }
            if (!self_nodes_part(nodes, at, i, other, target, friction)) { continue; }
            if (touching < state->touching_capacity) {
                state->touching[touching][0] = i;
                state->touching[touching][1] = other;
            }
            ++touching;
        }
    }
    state->touching_count = touching < state->touching_capacity ? touching : state->touching_capacity;
    state->report.contacts = touching;
}

static void self_nodes_solve(pli_body* body, self_nodes_state* state, const plii_self_nodes* nodes) {
    self_nodes_take_positions(body, state, nodes);
    if (!self_nodes_are_on_their_way(body, state, 0.0f)) { self_nodes_search(body, state); }
    self_nodes_part_all(state, nodes, state->def.friction);
}

static void self_nodes_restart(pli_body* body, void* data, const plii_xpbd_substep* substep) {
    const plii_self_nodes nodes = plii_self_nodes_of_substep(body, substep);
    self_nodes_limit(body, data, &nodes);
}

/* Friction is left to the velocities: moved sideways, nodes would get into others. */
static void self_nodes_sweep(pli_body* body, void* data, const plii_xpbd_substep* substep) {
    self_nodes_state* state = data;
    const plii_self_nodes nodes = plii_self_nodes_of_substep(body, substep);
    const float done = (float)(substep->index + 1) * substep->dt, left = body->step.dt - done;
    const float since = done - state->searched_at;
    const float share = since < state->travel_time ? since / state->travel_time : 1.0f;
    self_nodes_take_positions(body, state, &nodes);
    if (!self_nodes_are_on_their_way(body, state, share)) {
        for (int i = 0; i < body->node_count; ++i) {
            const pli_vec3 way = pli_vec3_scale(plii_self_motion(&nodes, i), left * substep->inverse_dt);
            self_nodes_set_travel(state, i, way, share, 1.0f);
        }
        state->searched_at = done;
        state->travel_time = left;
        self_nodes_search(body, state);
    }
    self_nodes_part_all(state, &nodes, 0.0f);
}

/* Pairs that were parted lose the speed that came of it, and `friction` of the rest of their relative velocity. */
static void self_nodes_finish(pli_body* body, void* data, const plii_xpbd_substep* substep) {
    const self_nodes_state* state = data;
    pli_vec4* v = body->velocities;
    (void)substep;
    for (int i = 0; i < state->touching_count; ++i) {
        const int a = state->touching[i][0], b = state->touching[i][1];
        const pli_vec3 apart = pli_vec3_sub(plii_xyz(state->at[b]), plii_xyz(state->at[a]));
        const pli_vec3 relative = pli_vec3_sub(plii_xyz(v[b]), plii_xyz(v[a]));
        const float squared = pli_vec3_length_squared(apart);
        if (!(squared > 0.0f)) { continue; }
        const pli_vec3 along = pli_vec3_scale(apart, pli_vec3_dot(relative, apart) / squared);
        const float lost = pli_vec3_dot(along, apart) > 0.0f ? 1.0f : 0.0f;
        const pli_vec3 change = pli_vec3_add(pli_vec3_scale(along, lost),
                                             pli_vec3_scale(pli_vec3_sub(relative, along), state->def.friction));
        const float share_a = state->at[a].w / (state->at[a].w + state->at[b].w);
        plii_set_xyz(&v[a], pli_vec3_add(plii_xyz(v[a]), pli_vec3_scale(change, share_a)));
        plii_set_xyz(&v[b], pli_vec3_sub(plii_xyz(v[b]), pli_vec3_scale(change, 1.0f - share_a)));
    }
}

// ------------------------------------------------------------------------------------------------------ the feature

static void self_nodes_run_update(pli_body* body, void* data, const plii_step* step) {
    self_nodes_state* state = data;
    (void)step;
    if (body->solver_class->has_substeps) { return; }
    state->report.limited_nodes = 0;
    if (!(state->def.speed_limit_ratio > 0.0f)) { return; }
    const plii_self_nodes nodes = plii_self_nodes_of_body(body);
    for (int i = 0; i < body->node_count; ++i) {
        const float scale = self_nodes_limit_scale(state, plii_self_motion(&nodes, i));
        if (scale < 1.0f) { plii_set_xyz(&body->velocities[i], pli_vec3_scale(plii_xyz(body->velocities[i]), scale)); }
    }
    self_nodes_limit(body, state, &nodes);
}

static void self_nodes_run_prepare(pli_body* body, void* data, const plii_step* step) {
    const plii_self_nodes nodes = plii_self_nodes_of_body(body);
    (void)step;
    self_nodes_begin(body, data, &nodes);
}

static void self_nodes_run_position(pli_body* body, void* data, const plii_step* step) {
    const plii_self_nodes nodes = plii_self_nodes_of_body(body);
    (void)step;
    self_nodes_solve(body, data, &nodes);
}

enum { SELF_NODES_BLOCKS = 5 };

static void self_nodes_sizes(int node_count, size_t sizes[SELF_NODES_BLOCKS]) {
    sizes[0] = sizes[1] = (size_t)node_count * sizeof(pli_vec3);
    sizes[2] = sizes[3] = sizes[4] = (size_t)node_count * sizeof(pli_vec4);
}

static void self_nodes_take_blocks(self_nodes_state* state, void* blocks[SELF_NODES_BLOCKS]) {
    state->rest = blocks[0];
    state->middle = blocks[1];
    state->at = blocks[2];
    state->searched = blocks[3];
    state->travel = blocks[4];
}

static void self_nodes_release_blocks(pli_body* body, const self_nodes_state* state, int node_count) {
    size_t sizes[SELF_NODES_BLOCKS];
    void* const blocks[SELF_NODES_BLOCKS] = {state->rest, state->middle, state->at, state->searched, state->travel};
    self_nodes_sizes(node_count, sizes);
    for (int i = 0; i < SELF_NODES_BLOCKS; ++i) {
        plii_release(body->context, blocks[i], sizes[i]);
    }
}

static pli_status self_nodes_enable(pli_body* body, void* data) {
    self_nodes_state* state = data;
    size_t sizes[SELF_NODES_BLOCKS];
    void* blocks[SELF_NODES_BLOCKS];
    bool is_complete = true;
    self_nodes_sizes(body->node_count, sizes);
    for (int i = 0; i < SELF_NODES_BLOCKS; ++i) {
        blocks[i] = plii_allocate(body->context, sizes[i]);
        is_complete = is_complete && blocks[i] != NULL;
    }
    self_nodes_take_blocks(state, blocks);
    if (!is_complete) {
        self_nodes_release_blocks(body, state, body->node_count);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    for (int i = 0; i < body->node_count; ++i) {
        state->rest[i] = plii_xyz(body->positions[i]);
    }
    return PLI_OK;
}

static void self_nodes_disable(pli_body* body, void* data) {
    self_nodes_state* state = data;
    self_nodes_release_blocks(body, state, body->node_count);
    plii_release(body->context, state->touching, (size_t)state->touching_capacity * sizeof *state->touching);
    plii_node_hash_free(body->context, &state->hash);
    plii_node_pairs_free(body->context, &state->pairs);
}

static size_t self_nodes_bytes(const pli_body* body, const void* data) {
    const self_nodes_state* state = data;
    size_t sizes[SELF_NODES_BLOCKS];
    size_t bytes = (size_t)state->touching_capacity * sizeof *state->touching + plii_node_hash_bytes(&state->hash) +
                   plii_node_pairs_bytes(&state->pairs);
    self_nodes_sizes(body->node_count, sizes);
    for (int i = 0; i < SELF_NODES_BLOCKS; ++i) {
        bytes += sizes[i];
    }
    return bytes;
}

static int self_nodes_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                      size_t* sizes) {
    (void)body;
    (void)data;
    self_nodes_sizes(change->node_count, sizes);
    return SELF_NODES_BLOCKS;
}

static void self_nodes_topology_commit(pli_body* body, void* data, const plii_topology_change* change, void** blocks) {
    self_nodes_state* state = data;
    plii_self_carry_rest(body, change, state->rest, blocks[0]);
    self_nodes_release_blocks(body, state, change->old_node_count);
    self_nodes_take_blocks(state, blocks);
    state->report = (pli_self_collision_report){0};
    state->touching_count = 0;
}

static const plii_feature_class self_nodes_class;
static const plii_xpbd_kind self_nodes_kind = {PLII_XPBD_ORDER_SELF_COLLISION,
                                               &self_nodes_class,
                                               self_nodes_begin_substeps,
                                               self_nodes_restart,
                                               self_nodes_sweep,
                                               self_nodes_finish};
static const plii_feature_class* const self_nodes_needs[] = {&plii_link_graph_class, NULL};
static const plii_feature_class self_nodes_class = {
    .name = "self-collision of nodes",
    .state_size = sizeof(self_nodes_state),
    .needs = self_nodes_needs,
    .stages = {[PLII_STAGE_UPDATE] = {self_nodes_run_update, PLII_ORDER_SPEED_LIMIT},
               [PLII_STAGE_PREPARE] = {self_nodes_run_prepare, PLII_ORDER_SELF_COLLISION},
               [PLII_STAGE_POSITION] = {self_nodes_run_position, PLII_ORDER_SELF_COLLISION}},
    .substepped = &self_nodes_kind,
    .enable = self_nodes_enable,
    .disable = self_nodes_disable,
    .bytes = self_nodes_bytes,
    .topology_blocks = self_nodes_topology_blocks,
    .topology_commit = self_nodes_topology_commit,
};

// --------------------------------------------------------------------------------------------------------- settings

pli_self_collision_def pli_self_collision_def_default(void) {
    return (pli_self_collision_def){
        .thickness = 0.01f, .friction = 0.1f, .speed_limit_ratio = 0.2f, .cookie = PLII_DEF_COOKIE};
}

static pli_status self_nodes_check(const pli_body* body, const pli_self_collision_def* def, const char* function) {
    if (def == NULL) { return plii_fail(body->context, PLI_ERROR_NULL_ARGUMENT, function, "def is null"); }
    if (def->cookie != PLII_DEF_COOKIE) {
        return plii_fail(body->context, PLI_ERROR_INVALID_DEF, function, "start from pli_self_collision_def_default()");
    }
    PLII_TRY(plii_self_check_value(body, def->thickness, 0.0f, 1e9f, true, "thickness", function));
    PLII_TRY(plii_self_check_value(body, def->friction, 0.0f, 1.0f, false, "friction", function));
    return plii_self_check_value(body, def->speed_limit_ratio, 0.0f, 1e9f, false, "speed_limit_ratio", function);
}

pli_status pli_body_enable_self_collision(pli_body* body, const pli_self_collision_def* def) {
    PLII_TRY(plii_check_body(body, __func__));
    PLII_TRY(self_nodes_check(body, def, __func__));
    PLII_TRY(plii_self_check_change(body, __func__));
    void* data = NULL;
    PLII_TRY(plii_feature_enable(body, &self_nodes_class, &data));
    self_nodes_state* state = data;
    state->def = *def;
    return PLI_OK;
}

pli_status pli_body_disable_self_collision(pli_body* body) {
    PLII_TRY(plii_check_body(body, __func__));
    PLII_TRY(plii_self_check_change(body, __func__));
    plii_feature_disable(body, &self_nodes_class);
    return PLI_OK;
}

pli_self_collision_report pli_body_get_self_collision_report(const pli_body* body) {
    const self_nodes_state* state =
        plii_check_body(body, __func__) == PLI_OK ? plii_feature_state(body, &self_nodes_class) : NULL;
    return state != NULL ? state->report : (pli_self_collision_report){0};
}
