/* Self-collision of nodes: pairs from a dense hash, once per step; distances at rest count as the thickness where they
   are smaller; a speed limit; friction towards the mean motion of a pair. Mueller, "Ten Minute Physics" 15. */

#include "self_node_pairs.h"

/* Of the thickness: margins of nodes where a step solves once. */
#define SELF_NODES_MIN_STEP_MARGIN 0.25f
#define SELF_NODES_MAX_STEP_MARGIN 1.0f

typedef struct self_nodes_state {
    pli_self_collision_def def;
    pli_vec3 origin; /* of the positions of pairs, which are small that way, and precise */
    plii_self_node_pairs pairs;
    int (*touching)[2]; /* pairs that the last sweep parted */
    int touching_count, touching_capacity;
    pli_self_collision_report report;
} self_nodes_state;

// ------------------------------------------------------------------------------------------------------ the search

/* Takes positions over, relative to the origin. */
static void self_nodes_take_positions(const pli_body* body, self_nodes_state* state, const plii_self_nodes* nodes) {
    const pli_vec3 o = state->origin;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec4 offset = nodes->offsets[i];
        const pli_vec4 base = nodes->bases != NULL ? nodes->bases[i] : (pli_vec4){0};
        state->pairs.at[i] =
            (pli_vec4){(base.x - o.x) + offset.x, (base.y - o.y) + offset.y, (base.z - o.z) + offset.z, offset.w};
    }
}

static const plii_link_graph* self_nodes_graph(const pli_body* body) {
    return plii_feature_state(body, &plii_link_graph_class);
}

static void self_nodes_start_report(const pli_body* body, self_nodes_state* state) {
    const int limited = state->report.limited_nodes; /* by the UPDATE stage of this step */
    state->report = (pli_self_collision_report){.limited_nodes = body->solver_class->has_substeps ? 0 : limited};
    state->pairs.is_cut_short = false;
    state->pairs.searches = 0;
}

static void self_nodes_start_search(const pli_body* body, self_nodes_state* state, const plii_self_nodes* nodes) {
    state->pairs.thickness = state->def.thickness;
    state->origin = body->node_count > 0 ? plii_self_position(nodes, 0) : pli_vec3_make(0, 0, 0);
    if (!plii_vec3_is_finite(state->origin)) { state->origin = pli_vec3_make(0, 0, 0); }
    self_nodes_take_positions(body, state, nodes);
}

/* After searches: what they found. */
static void self_nodes_report(pli_body* body, self_nodes_state* state) {
    const plii_self_node_pairs* pairs = &state->pairs;
    const bool has_room = !body->solver_class->has_substeps ||
                          PLII_RESERVE(body->context, &state->touching, &state->touching_capacity, pairs->count);
    state->report.pairs = pairs->count;
    state->report.searches = pairs->searches;
    state->report.is_cut_short = state->report.is_cut_short || pairs->is_cut_short || !has_room;
}

/* At predicted positions: from there constraints move nodes by about what the prediction did. */
static void self_nodes_begin(pli_body* body, self_nodes_state* state, const plii_self_nodes* nodes) {
    const float thickness = state->def.thickness;
    pli_vec3 low = pli_vec3_make(FLT_MAX, FLT_MAX, FLT_MAX), high = pli_vec3_make(-FLT_MAX, -FLT_MAX, -FLT_MAX);
    self_nodes_start_report(body, state);
    self_nodes_start_search(body, state, nodes);
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 moved = plii_self_motion(nodes, i);
        low = plii_vec3_min(moved, low);
        high = plii_vec3_max(moved, high);
    }
    const float extent = pli_vec3_length(pli_vec3_sub(high, low));
    const float margin = plii_clamp(0.5f * extent + SELF_NODES_MIN_STEP_MARGIN * thickness,
                                    SELF_NODES_MIN_STEP_MARGIN * thickness, SELF_NODES_MAX_STEP_MARGIN * thickness);
    plii_self_node_pairs_search_still(body, self_nodes_graph(body), &state->pairs, margin);
    self_nodes_report(body, state);
}

/* At the start of a step with substeps. */
static void self_nodes_begin_substeps(pli_body* body, void* data) {
    self_nodes_state* state = data;
    const plii_self_nodes nodes = {NULL, body->previous, body->previous};
    const pli_vec3 origin = state->origin;
    self_nodes_start_report(body, state);
    self_nodes_take_positions(body, state, &nodes);
    if (!plii_self_node_pairs_serve_on(body, &state->pairs, state->def.thickness)) {
        self_nodes_start_search(body, state, &nodes);
        plii_self_node_pairs_search_step(body, self_nodes_graph(body), &state->pairs,
                                         pli_vec3_sub(origin, state->origin));
    }
    self_nodes_report(body, state);
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
    const plii_self_node_pairs* pairs = &state->pairs;
    pli_vec4* at = pairs->at;
    int touching = 0;
    for (int k = 0; k < pairs->count; ++k) {
        const plii_self_pair pair = pairs->pairs[k];
        const pli_vec4 a = at[pair.a], b = at[pair.b];
        const float x = b.x - a.x, y = b.y - a.y, z = b.z - a.z;
        if (!(x * x + y * y + z * z < pair.distance * pair.distance)) { continue; }
        if (!self_nodes_part(nodes, at, pair.a, pair.b, pair.distance, friction)) { continue; }
        if (touching < state->touching_capacity) {
            state->touching[touching][0] = pair.a;
            state->touching[touching][1] = pair.b;
        }
        ++touching;
    }
    state->touching_count = touching < state->touching_capacity ? touching : state->touching_capacity;
    state->report.contacts = touching;
}

static void self_nodes_solve(pli_body* body, self_nodes_state* state, const plii_self_nodes* nodes) {
    self_nodes_take_positions(body, state, nodes);
    plii_self_node_pairs_follow_still(body, self_nodes_graph(body), &state->pairs);
    self_nodes_report(body, state);
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
    const float done = (float)(substep->index + 1) * substep->dt;
    self_nodes_take_positions(body, state, &nodes);
    plii_self_node_pairs_follow(body, self_nodes_graph(body), &state->pairs, &nodes, substep->inverse_dt, done,
                                body->step.dt - done);
    self_nodes_report(body, state);
    self_nodes_part_all(state, &nodes, 0.0f);
}

/* Pairs that were parted lose the speed that came of it, and `friction` of the rest of their relative velocity. */
static void self_nodes_finish(pli_body* body, void* data, const plii_xpbd_substep* substep) {
    const self_nodes_state* state = data;
    pli_vec4* v = body->velocities;
    (void)substep;
    for (int i = 0; i < state->touching_count; ++i) {
        const int a = state->touching[i][0], b = state->touching[i][1];
        const pli_vec3 apart = pli_vec3_sub(plii_xyz(state->pairs.at[b]), plii_xyz(state->pairs.at[a]));
        const pli_vec3 relative = pli_vec3_sub(plii_xyz(v[b]), plii_xyz(v[a]));
        const float squared = pli_vec3_length_squared(apart);
        if (!(squared > 0.0f)) { continue; }
        const pli_vec3 along = pli_vec3_scale(apart, pli_vec3_dot(relative, apart) / squared);
        const float lost = pli_vec3_dot(along, apart) > 0.0f ? 1.0f : 0.0f;
        const pli_vec3 change = pli_vec3_add(pli_vec3_scale(along, lost),
                                             pli_vec3_scale(pli_vec3_sub(relative, along), state->def.friction));
        const float share_a = state->pairs.at[a].w / (state->pairs.at[a].w + state->pairs.at[b].w);
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

static pli_status self_nodes_enable(pli_body* body, void* data) {
    self_nodes_state* state = data;
    size_t sizes[PLII_SELF_NODE_BLOCKS];
    void* blocks[PLII_SELF_NODE_BLOCKS];
    bool is_complete = true;
    plii_self_node_sizes(body->node_count, sizes);
    for (int i = 0; i < PLII_SELF_NODE_BLOCKS; ++i) {
        blocks[i] = plii_allocate(body->context, sizes[i]);
        is_complete = is_complete && blocks[i] != NULL;
    }
    plii_self_node_take_blocks(&state->pairs, blocks);
    if (!is_complete) {
        plii_self_node_release_blocks(body->context, &state->pairs, body->node_count);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    for (int i = 0; i < body->node_count; ++i) {
        state->pairs.rest[i] = plii_xyz(body->positions[i]);
    }
    return PLI_OK;
}

static void self_nodes_disable(pli_body* body, void* data) {
    self_nodes_state* state = data;
    plii_self_node_release_blocks(body->context, &state->pairs, body->node_count);
    plii_release(body->context, state->touching, (size_t)state->touching_capacity * sizeof *state->touching);
    plii_self_node_pairs_release(body->context, &state->pairs);
}

static size_t self_nodes_bytes(const pli_body* body, const void* data) {
    const self_nodes_state* state = data;
    return (size_t)state->touching_capacity * sizeof *state->touching +
           plii_self_node_pairs_bytes(&state->pairs, body->node_count);
}

static int self_nodes_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                      size_t* sizes) {
    (void)body;
    (void)data;
    plii_self_node_sizes(change->node_count, sizes);
    return PLII_SELF_NODE_BLOCKS;
}

static void self_nodes_topology_commit(pli_body* body, void* data, const plii_topology_change* change, void** blocks) {
    self_nodes_state* state = data;
    plii_self_carry_rest(body, change, state->pairs.rest, blocks[0]);
    plii_self_node_release_blocks(body->context, &state->pairs, change->old_node_count);
    plii_self_node_take_blocks(&state->pairs, blocks);
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
