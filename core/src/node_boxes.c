/* Boxes of nodes that are kept from step to step. Bullet: m_ndbvt of a btSoftBody without VF_SS. */

#include "node_boxes.h"

#include "fat_box.h"

#include <string.h>

typedef struct node_boxes_state {
    pli_bounds* boxes; /* [node_count] */
    int started;       /* how many have been taken yet */
} node_boxes_state;

static void node_boxes_start(const pli_body* body, node_boxes_state* state, const pli_vec4* positions) {
    for (int i = state->started; i < body->node_count; ++i) {
        const pli_vec3 x = plii_xyz(positions[i]);
        state->boxes[i] = plii_bounds_grow((pli_bounds){x, x}, body->collision_margin);
    }
    state->started = body->node_count;
}

static void node_boxes_update(pli_body* body, void* data, const plii_step* step) {
    node_boxes_state* state = data;
    node_boxes_start(body, state, body->previous);
    const float margin = body->collision_margin, ahead = step->dt * 3.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 x = plii_xyz(body->positions[i]);
        plii_fat_box_update(&state->boxes[i], plii_bounds_grow((pli_bounds){x, x}, margin),
                            pli_vec3_scale(plii_xyz(body->velocities[i]), ahead), margin * 0.25f);
    }
}

static void node_boxes_disable(pli_body* body, void* data) {
    node_boxes_state* state = data;
    plii_release(body->context, state->boxes, (size_t)body->node_count * sizeof *state->boxes);
}

static pli_status node_boxes_enable(pli_body* body, void* data) {
    node_boxes_state* state = data;
    state->boxes = plii_allocate(body->context, (size_t)body->node_count * sizeof *state->boxes);
    if (state->boxes == NULL) { return PLI_ERROR_OUT_OF_MEMORY; }
    node_boxes_start(body, state, body->positions);
    return PLI_OK;
}

static size_t node_boxes_bytes(const pli_body* body, const void* data) {
    (void)data;
    return (size_t)body->node_count * sizeof(pli_bounds);
}

static int node_boxes_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                      size_t* sizes) {
    (void)body;
    (void)data;
    sizes[0] = (size_t)change->node_count * sizeof(pli_bounds);
    return 1;
}

/* Those of new nodes start with the next step. */
static void node_boxes_topology_commit(pli_body* body, void* data, const plii_topology_change* change, void** blocks) {
    node_boxes_state* state = data;
    const size_t old_bytes = (size_t)change->old_node_count * sizeof *state->boxes;
    memcpy(blocks[0], state->boxes, old_bytes);
    plii_release(body->context, state->boxes, old_bytes);
    state->boxes = blocks[0];
}

const plii_feature_class plii_node_boxes_class = {
    .name = "node_boxes",
    .state_size = sizeof(node_boxes_state),
    .stages = {[PLII_STAGE_UPDATE] = {node_boxes_update, PLII_ORDER_BOXES}},
    .enable = node_boxes_enable,
    .disable = node_boxes_disable,
    .bytes = node_boxes_bytes,
    .topology_blocks = node_boxes_topology_blocks,
    .topology_commit = node_boxes_topology_commit,
};

const pli_bounds* plii_node_boxes(const pli_body* body) {
    const node_boxes_state* state = plii_feature_state(body, &plii_node_boxes_class);
    return state != NULL ? state->boxes : NULL;
}

bool plii_node_boxes_set(pli_body* body, const pli_bounds* boxes) {
    node_boxes_state* state = plii_feature_state(body, &plii_node_boxes_class);
    if (state == NULL) { return false; }
    memcpy(state->boxes, boxes, (size_t)body->node_count * sizeof *state->boxes);
    state->started = body->node_count;
    return true;
}
