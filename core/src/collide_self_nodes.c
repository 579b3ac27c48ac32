/* Self-collision of nodes: pairs from a dense hash, once per step; distances at rest count as the thickness where they
   are smaller; a speed limit; friction towards the mean motion of a pair. Mueller, "Ten Minute Physics" 15.

   The search reaches further than the thickness. When nodes of the body have since moved so differently that a pair
   could have come near unseen, it is repeated; so no pair is missed, with a speed limit or without. */

#include "node_hash.h"
#include "self_collision_impl.h"

/* Of the thickness: how far nodes may move against each other before the search is repeated. */
#define SELF_NODES_MIN_REACH 0.25f
#define SELF_NODES_MAX_REACH 1.0f

typedef struct self_nodes_state {
    pli_self_collision_def def;
    float reach;        /* m */
    pli_vec3* rest;     /* [node_count] positions */
    pli_vec3* searched; /* [node_count] positions at the last search */
    plii_node_hash hash;
    plii_node_pairs pairs; /* second field of each: the distance to keep, m */
    pli_self_collision_report report;
} self_nodes_state;

// ------------------------------------------------------------------------------------------------------ the search

/* How far a pair may have moved towards each other: the extent of all moves. */
static float self_nodes_spread(pli_vec3 low, pli_vec3 high) {
    return sqrtf(pli_vec3_length_squared(pli_vec3_sub(high, low)));
}

static float self_nodes_spread_since_search(const pli_body* body, const self_nodes_state* state,
                                            const plii_self_nodes* nodes) {
    pli_vec3 low = pli_vec3_make(FLT_MAX, FLT_MAX, FLT_MAX), high = pli_vec3_make(-FLT_MAX, -FLT_MAX, -FLT_MAX);
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 moved = pli_vec3_sub(plii_self_position(nodes, i), state->searched[i]);
        low = plii_vec3_min(moved, low);
        high = plii_vec3_max(moved, high);
    }
    return self_nodes_spread(low, high);
}

static float self_nodes_spread_of_prediction(const pli_body* body) {
    pli_vec3 low = pli_vec3_make(FLT_MAX, FLT_MAX, FLT_MAX), high = pli_vec3_make(-FLT_MAX, -FLT_MAX, -FLT_MAX);
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 moved = pli_vec3_sub(plii_xyz(body->positions[i]), plii_xyz(body->previous[i]));
        low = plii_vec3_min(moved, low);
        high = plii_vec3_max(moved, high);
    }
    return self_nodes_spread(low, high);
}

/* Replaces distances by the ones to keep, and drops what cannot touch before the next search. */
static void self_nodes_take_targets(self_nodes_state* state) {
    plii_node_pairs* pairs = &state->pairs;
    const float thickness = state->def.thickness, reach = 2.0f * state->reach;
    int kept = 0, begin = 0;
    for (int i = 0; i < pairs->row_count; ++i) {
        const int end = pairs->begin[i + 1];
        for (int k = begin; k < end; ++k) {
            const plii_node_pair pair = pairs->pairs[k];
            const pli_vec3 apart = pli_vec3_sub(state->rest[pair.other], state->rest[i]);
            const float target = plii_min(thickness, sqrtf(pli_vec3_length_squared(apart)));
            const float limit = target + reach;
            if (pair.distance_squared < limit * limit && target > 0.0f) {
                pairs->pairs[kept++] = (plii_node_pair){pair.other, target};
            }
        }
        begin = end;
        pairs->begin[i + 1] = kept;
    }
    pairs->count = kept;
}

static void self_nodes_search(pli_body* body, self_nodes_state* state, const plii_self_nodes* nodes) {
    const float radius = state->def.thickness + 2.0f * state->reach;
    for (int i = 0; i < body->node_count; ++i) {
        state->searched[i] = plii_self_position(nodes, i);
    }
    const bool has_memory =
        plii_node_hash_build(body->context, &state->hash, body->node_count, state->searched, radius, 0.0f) &&
        plii_node_hash_find(body->context, &state->hash, state->searched, radius, &state->pairs);
    if (!has_memory) { state->pairs.count = state->pairs.row_count = 0; }
    self_nodes_take_targets(state);
    state->report.pairs = state->pairs.count;
    state->report.searches += 1;
    state->report.is_cut_short = state->report.is_cut_short || !has_memory || state->pairs.is_cut_short;
}

static void self_nodes_begin(pli_body* body, self_nodes_state* state, const plii_self_nodes* nodes) {
    const float thickness = state->def.thickness;
    const int limited = state->report.limited_nodes; /* by the UPDATE stage of this step */
    state->report = (pli_self_collision_report){.limited_nodes = body->solver_class->has_substeps ? 0 : limited};
    state->reach = plii_clamp(0.5f * self_nodes_spread_of_prediction(body) + SELF_NODES_MIN_REACH * thickness,
                              SELF_NODES_MIN_REACH * thickness, SELF_NODES_MAX_REACH * thickness);
    self_nodes_search(body, state, nodes);
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

static void self_nodes_rub(const plii_self_nodes* nodes, int a, int b, float share_a, float share_b) {
    const pli_vec3 motion = pli_vec3_sub(plii_self_motion(nodes, b), plii_self_motion(nodes, a));
    plii_self_move(nodes, a, motion, share_a);
    plii_self_move(nodes, b, motion, -share_b);
}

/* True when the pair was too near. */
static bool self_nodes_part(const plii_self_nodes* nodes, int a, int b, float target, float friction) {
    const pli_vec3 apart = plii_self_difference(nodes, a, b);
    const float squared = pli_vec3_length_squared(apart);
    if (!(squared < target * target)) { return false; }
    const float weight_a = nodes->offsets[a].w, weight = weight_a + nodes->offsets[b].w;
    if (!(weight > 0.0f)) { return false; }
    const float distance = sqrtf(squared), share_a = weight_a / weight;
    const pli_vec3 n = distance > 1e-6f * target ? plii_vec3_divide(apart, distance) : plii_self_direction(a, b);
    plii_self_move(nodes, a, n, (distance - target) * share_a);
    plii_self_move(nodes, b, n, (target - distance) * (1.0f - share_a));
    if (friction > 0.0f) { self_nodes_rub(nodes, a, b, friction * share_a, friction * (1.0f - share_a)); }
    return true;
}

static void self_nodes_solve(pli_body* body, self_nodes_state* state, const plii_self_nodes* nodes) {
    if (self_nodes_spread_since_search(body, state, nodes) > 2.0f * state->reach) {
        self_nodes_search(body, state, nodes);
    }
    const plii_node_pairs* pairs = &state->pairs;
    const float friction = state->def.friction;
    int contacts = 0;
    for (int i = 0; i < pairs->row_count; ++i) {
        for (int k = pairs->begin[i]; k < pairs->begin[i + 1]; ++k) {
            contacts += self_nodes_part(nodes, i, pairs->pairs[k].other, pairs->pairs[k].distance_squared, friction);
        }
    }
    state->report.contacts = contacts;
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

static void self_nodes_begin_substeps(pli_body* body, void* data) {
    const plii_self_nodes nodes = {NULL, body->previous, body->previous};
    self_nodes_begin(body, data, &nodes);
}

static void self_nodes_restart(pli_body* body, void* data, const plii_xpbd_substep* substep) {
    const plii_self_nodes nodes = plii_self_nodes_of_substep(body, substep);
    self_nodes_limit(body, data, &nodes);
}

static void self_nodes_sweep(pli_body* body, void* data, const plii_xpbd_substep* substep) {
    const plii_self_nodes nodes = plii_self_nodes_of_substep(body, substep);
    self_nodes_solve(body, data, &nodes);
}

static size_t self_nodes_vectors_size(int node_count) {
    return (size_t)node_count * sizeof(pli_vec3);
}

static pli_status self_nodes_enable(pli_body* body, void* data) {
    self_nodes_state* state = data;
    state->rest = plii_allocate(body->context, self_nodes_vectors_size(body->node_count));
    state->searched = plii_allocate(body->context, self_nodes_vectors_size(body->node_count));
    if (state->rest == NULL || state->searched == NULL) {
        plii_release(body->context, state->rest, self_nodes_vectors_size(body->node_count));
        plii_release(body->context, state->searched, self_nodes_vectors_size(body->node_count));
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    for (int i = 0; i < body->node_count; ++i) {
        state->rest[i] = plii_xyz(body->positions[i]);
    }
    return PLI_OK;
}

static void self_nodes_disable(pli_body* body, void* data) {
    self_nodes_state* state = data;
    plii_release(body->context, state->rest, self_nodes_vectors_size(body->node_count));
    plii_release(body->context, state->searched, self_nodes_vectors_size(body->node_count));
    plii_node_hash_free(body->context, &state->hash);
    plii_node_pairs_free(body->context, &state->pairs);
}

static size_t self_nodes_bytes(const pli_body* body, const void* data) {
    const self_nodes_state* state = data;
    return 2 * self_nodes_vectors_size(body->node_count) + plii_node_hash_bytes(&state->hash) +
           plii_node_pairs_bytes(&state->pairs);
}

static int self_nodes_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                      size_t* sizes) {
    (void)body;
    (void)data;
    sizes[0] = sizes[1] = self_nodes_vectors_size(change->node_count);
    return 2;
}

static void self_nodes_topology_commit(pli_body* body, void* data, const plii_topology_change* change, void** blocks) {
    self_nodes_state* state = data;
    plii_self_carry_rest(body, change, state->rest, blocks[0]);
    plii_release(body->context, state->rest, self_nodes_vectors_size(change->old_node_count));
    plii_release(body->context, state->searched, self_nodes_vectors_size(change->old_node_count));
    state->rest = blocks[0];
    state->searched = blocks[1];
    state->report = (pli_self_collision_report){0};
}

static const plii_feature_class self_nodes_class;
static const plii_xpbd_kind self_nodes_kind = {PLII_XPBD_ORDER_SELF_COLLISION, &self_nodes_class,
                                               self_nodes_begin_substeps, self_nodes_restart, self_nodes_sweep};
static const plii_feature_class self_nodes_class = {
    .name = "self-collision of nodes",
    .state_size = sizeof(self_nodes_state),
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
