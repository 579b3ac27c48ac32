/* Boxes that are kept from step to step: of nodes, with soft contacts of faces too. Bullet: m_ndbvt and m_fdbvt. */

#include "body/pipeline.h"
#include "contact/soft_contacts_impl.h"
#include "pliant/bullet_reference.h"

static void node_boxes_start(const pli_body* body, int first) {
    for (int i = first; i < body->node_count; ++i) {
        const pli_vec3 x = plii_xyz(body->positions[i]);
        body->node_boxes[i] = plii_bounds_grow((pli_bounds){x, x}, body->collision_margin);
    }
}

/* Where something is and gets to in three steps. */
static void box_update(const pli_body* body, pli_bounds* box, pli_bounds now, pli_vec3 velocity) {
    const float margin = body->collision_margin, ahead = body->step.dt * 3.0f;
    plii_fat_aabb_update(box, plii_bounds_grow(now, margin), pli_vec3_scale(velocity, ahead), margin * 0.25f);
}

static void node_boxes_update(pli_body* body, void* state) {
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 x = plii_xyz(body->positions[i]);
        box_update(body, &body->node_boxes[i], (pli_bounds){x, x}, plii_xyz(body->velocities[i]));
    }
}

static void node_boxes_enable(pli_body* body, void* state) {
    node_boxes_start(body, 0);
}
static void node_boxes_topology_commit(pli_body* body, void* state, const plii_topology_change* change) {
    node_boxes_start(body, change->old_node_count);
}

enum { BULLET_BOXES_ORDER = 30 }; /* after clusters, as in Bullet */
const plii_feature_class plii_node_boxes_class = {
    .name = "node boxes",
    .arrays = PLII_ARRAYS(
        {PLII_MEMBER(pli_body, node_boxes), PLII_PER_NODE, .is_in_body = true, .is_kept = true, PLII_SAVED_AS("6f")}),
    .stages = {[PLII_STAGE_UPDATE] = {node_boxes_update, BULLET_BOXES_ORDER}},
    .enable = node_boxes_enable,
    .topology_commit = node_boxes_topology_commit,
};

pli_status pli_body_enable_bullet_node_boxes(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    return plii_body_changed(body, plii_feature_enable(body, &plii_node_boxes_class, NULL));
}
PLII_DEFINE_DISABLE(pli_body_disable_bullet_node_boxes, plii_check_body_idle, plii_node_boxes_class)

// ---------------------------------------------------------------------------------------------------- of soft contacts

typedef struct bullet_boxes_state {
    bool has_started; /* false: boxes are taken from the start of the next step */
} bullet_boxes_state;

/* With soft contacts Bullet makes its trees anew, without margins. */
static void bullet_boxes_start(pli_body* body) {
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 x = plii_xyz(body->previous[i]);
        body->node_boxes[i] = (pli_bounds){x, x};
    }
    for (int i = 0; i < body->topology->face_count; ++i) {
        body->face_boxes[i] =
            plii_bounds_grow(plii_bounds_of_face(body->previous, body->topology->faces[i]), 100.0f * PLII_EPSILON);
    }
    node_boxes_update(body, NULL);
}

static void bullet_boxes_update(pli_body* body, void* data) {
    bullet_boxes_state* state = data;
    if (!state->has_started) { bullet_boxes_start(body); }
    state->has_started = true;
    for (int i = 0; i < body->topology->face_count; ++i) {
        const int* face = body->topology->faces[i];
        const pli_vec3 sum =
            pli_vec3_add(pli_vec3_add(plii_xyz(body->velocities[face[0]]), plii_xyz(body->velocities[face[1]])),
                         plii_xyz(body->velocities[face[2]]));
        box_update(body, &body->face_boxes[i], plii_bounds_of_face(body->positions, face), plii_vec3_divide(sum, 3.0f));
    }
}

static void bullet_boxes_build(pli_body* body, void* data) {
    ((bullet_boxes_state*)data)->has_started = false;
}

const plii_feature_class plii_bullet_boxes_class = {
    .name = "bullet boxes",
    .state_size = sizeof(bullet_boxes_state),
    .needs = PLII_NEEDS(&plii_node_boxes_class),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(bullet_boxes_state, has_started, PLII_SAVED, "B")),
    .arrays = PLII_ARRAYS({PLII_MEMBER(pli_body, face_boxes), PLII_PER_FACE, .is_in_body = true, PLII_SAVED_AS("6f")}),
    .stages = {[PLII_STAGE_UPDATE] = {bullet_boxes_update, BULLET_BOXES_ORDER}},
    .build = bullet_boxes_build,
};

static pli_status bullet_boxes_check(pli_context* context, const pli_bounds* boxes, int count, const char* what,
                                     const char* function) {
    PLII_FAIL_IF(boxes == NULL && count > 0, context, PLI_ERROR_NULL_ARGUMENT, function, "%s_boxes is null", what);
    for (int i = 0; i < count; ++i) {
        PLII_FAIL_IF(!plii_soft_contacts_box_is_finite(boxes[i]), context, PLI_ERROR_NOT_FINITE, function,
                     "the box of %s %d is not finite", what, i);
    }
    return PLI_OK;
}

pli_status pli_body_set_bullet_boxes(pli_body* body, const pli_bounds* node_boxes, const pli_bounds* face_boxes) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_FAIL_IF(body->node_boxes == NULL, body->context, PLI_ERROR_WRONG_STATE, __func__,
                 "neither soft contacts with bullet_boxes nor pli_body_enable_bullet_node_boxes are enabled");
    bullet_boxes_state* state = plii_feature_state(body, &plii_bullet_boxes_class);
    const int face_count = state != NULL ? body->topology->face_count : 0;
    PLII_TRY(bullet_boxes_check(body->context, node_boxes, body->node_count, "node", __func__));
    PLII_TRY(bullet_boxes_check(body->context, face_boxes, face_count, "face", __func__));
    memcpy(body->node_boxes, node_boxes, (size_t)body->node_count * sizeof *node_boxes);
    if (face_count > 0) { memcpy(body->face_boxes, face_boxes, (size_t)face_count * sizeof *face_boxes); }
    if (state != NULL) { state->has_started = true; }
    return plii_body_changed(body, PLI_OK);
}
