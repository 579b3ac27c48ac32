/* Boxes of nodes that are kept from step to step. Bullet: m_ndbvt of a btSoftBody without VF_SS. */

#include "body/pipeline.h"
#include "math/bounds.h"
#include "pliant/bullet_reference.h"

static void node_boxes_start(const pli_body* body, pli_bounds* boxes, int first) {
    for (int i = first; i < body->node_count; ++i) {
        const pli_vec3 x = plii_xyz(body->positions[i]);
        boxes[i] = plii_bounds_grow((pli_bounds){x, x}, body->collision_margin);
    }
}

static void node_boxes_update(pli_body* body, void* state) {
    const float margin = body->collision_margin, ahead = body->step.dt * 3.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 x = plii_xyz(body->positions[i]);
        plii_fat_aabb_update(&body->node_boxes[i], plii_bounds_grow((pli_bounds){x, x}, margin),
                             pli_vec3_scale(plii_xyz(body->velocities[i]), ahead), margin * 0.25f);
    }
}

static pli_status node_boxes_enable(pli_body* body, void* state) {
    node_boxes_start(body, body->node_boxes, 0);
    return PLI_OK;
}
static void node_boxes_topology_commit(pli_body* body, void* state, const plii_topology_change* change) {
    node_boxes_start(body, body->node_boxes, change->old_node_count);
}

enum { NODE_BOXES_ORDER = 30 }; /* after clusters, as in Bullet */
const plii_feature_class plii_node_boxes_class = {
    .name = "node boxes",
    .arrays = PLII_ARRAYS(
        {PLII_MEMBER(pli_body, node_boxes), PLII_PER_NODE, .is_in_body = true, .is_kept = true, PLII_SAVED_AS("6f")}),
    .stages = {[PLII_STAGE_UPDATE] = {node_boxes_update, NODE_BOXES_ORDER}},
    .enable = node_boxes_enable,
    .topology_commit = node_boxes_topology_commit,
};

pli_status pli_body_enable_bullet_node_boxes(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    return plii_body_changed(body, plii_feature_enable(body, &plii_node_boxes_class, NULL));
}
PLII_DEFINE_DISABLE(pli_body_disable_bullet_node_boxes, plii_check_body_idle, plii_node_boxes_class)
