/* Pinned nodes that are led: each goes to its target within one step, in a straight line at one speed, so that what
   looks at positions, motions or velocities sees the same. Afterwards it stays. */

#include "body/pipeline.h"

typedef struct node_motion {
    int node;
    pli_vec3 target, velocity; /* of the step in progress or the last one */
} node_motion;

typedef struct node_motion_state {
    node_motion* motions; /* first those that have ended with the last step; of one node the last counts */
    int ended_count, count, capacity;
} node_motion_state;

static void node_motion_start(pli_body* body, void* data) {
    node_motion_state* state = data;
    for (PLII_EACH(const node_motion, motion, state->motions, state->ended_count)) {
        pli_vec4* velocity = &body->velocities[motion->node];
        const bool is_pinned = !(body->positions[motion->node].w > 0.0f);
        /* One that somebody else has given since stays. */
        if (is_pinned && plii_vec3_compare(plii_xyz(*velocity), motion->velocity) == 0) { *velocity = (pli_vec4){0}; }
    }
    int kept = 0;
    for (int i = state->ended_count; i < state->count; ++i) {
        node_motion motion = state->motions[i];
        if (body->positions[motion.node].w > 0.0f) { continue; } /* no longer pinned */
        const pli_vec3 way = pli_vec3_sub(motion.target, plii_xyz(body->positions[motion.node]));
        motion.velocity = pli_vec3_scale(way, body->step.inverse_dt);
        plii_set_xyz(&body->velocities[motion.node], motion.velocity);
        state->motions[kept++] = motion;
    }
    state->count = kept;
    state->ended_count = 0;
}

static void node_motion_finish(pli_body* body, void* data) {
    node_motion_state* state = data;
    for (PLII_EACH(const node_motion, motion, state->motions, state->count)) {
        plii_set_xyz(&body->positions[motion->node], motion->target); /* but for rounding it is there */
        plii_set_xyz(&body->velocities[motion->node], motion->velocity);
    }
    state->ended_count = state->count;
}

/* Before what looks at velocities, and before anchors have the last word. */
enum { NODE_MOTION_START_ORDER = 0, NODE_MOTION_FINISH_ORDER = 190 };

static bool node_motion_is_sound(const pli_body* body, const void* data) {
    const node_motion_state* state = data;
    return state->ended_count >= 0 && state->ended_count <= state->count;
}

const plii_feature_class plii_node_motion_class = {
    .name = "node motions",
    .is_made_by_calls = true,
    .state_size = sizeof(node_motion_state),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(node_motion_state, ended_count, PLII_SAVED, "i")),
    .is_sound = node_motion_is_sound,
    .stages = {[PLII_STAGE_FORCES] = {node_motion_start, NODE_MOTION_START_ORDER},
               [PLII_STAGE_FINISH] = {node_motion_finish, NODE_MOTION_FINISH_ORDER}},
    .arrays = PLII_ARRAYS(
        {PLII_COUNTED_LIST(node_motion_state, motions, capacity, count), .is_kept = true, PLII_SAVED_AS("n6f")}),
};

pli_status pli_body_move_node(pli_body* body, int node, pli_vec3 position) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(plii_check_node(body, node, __func__));
    PLII_TRY(plii_check_vec3_within(body->context, position, PLI_MAX_COORDINATE, "position", __func__));
    PLII_FAIL_IF(body->positions[node].w > 0.0f, body->context, PLI_ERROR_INVALID_VALUE, __func__,
                 "node %d is not pinned", node);
    PLII_TRY_ENABLE(body, node_motion_state, state, plii_node_motion_class);
    const node_motion motion = {.node = node, .target = position};
    /* So long that it has some node twice, as that of a body that is called for but not stepped. */
    const bool is_long = state->count - state->ended_count >= body->node_count;
    for (int i = state->count - 1; is_long && i >= state->ended_count; --i) {
        if (state->motions[i].node != node) { continue; }
        state->motions[i] = motion;
        return plii_body_changed(body, PLI_OK);
    }
    if (!PLII_GROW(body->context, &state->motions, &state->capacity, state->count)) {
        return PLII_FAIL_ENABLED(body, plii_node_motion_class, __func__, "no memory for the motion of a node");
    }
    state->motions[state->count++] = motion;
    return plii_body_changed(body, PLI_OK);
}
