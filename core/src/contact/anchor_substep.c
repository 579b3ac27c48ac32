/* XPBD: anchors, C = node - point of the rigid body as one constraint of three rows. */

#include "body/substep_rigid.h"
#include "contact/anchor_impl.h"
#include "math/range.h"
#include "solver/xpbd/xpbd_impl.h"

typedef struct xpbd_anchor {
    int node;
    pli_vec3 goal; /* at the start of the step */
    plii_substep_rigid_point point;
    pli_mat3 inverse; /* of the sum of both inverse masses and the compliance */
    pli_vec3 multiplier;
} xpbd_anchor;

typedef struct xpbd_anchors_state {
    float compliance; /* m/N */
    xpbd_anchor* anchors;
    int count, capacity;
} xpbd_anchors_state;

static bool xpbd_anchors_reserve(pli_body* body, xpbd_anchors_state* state) {
    return PLII_RESERVE(body->context, &state->anchors, &state->capacity, pli_body_anchor_count(body));
}

static void xpbd_anchors_begin(pli_body* body, void* data) {
    xpbd_anchors_state* state = data;
    state->count = 0;
    if (!xpbd_anchors_reserve(body, state)) { return; }
    for (int i = 0; i < pli_body_anchor_count(body); ++i) {
        const plii_anchor_data place = plii_anchor_get_data(body, i);
        if (place.rigid->is_absent) { continue; }
        const pli_transform pose = place.rigid->state.pose;
        xpbd_anchor* anchor = &state->anchors[state->count++];
        *anchor = (xpbd_anchor){.node = place.node, .goal = pli_transform_point(pose, place.pivot)};
        anchor->point.rigid = place.rigid;
        anchor->point.offset = pli_mat3_mul_vec3(pose.rotation, place.pivot);
        plii_rigid_touch(place.rigid);
    }
}

static void xpbd_anchors_restart(pli_body* body, void* data, const plii_substep* substep) {
    const xpbd_anchors_state* state = data;
    const float alpha = state->compliance * substep->inverse_dt * substep->inverse_dt;
    (void)body;
    for (int i = 0; i < state->count; ++i) {
        xpbd_anchor* anchor = &state->anchors[i];
        const pli_rigid* rigid = anchor->point.rigid;
        plii_substep_rigid_point_restart(&anchor->point, substep);
        anchor->multiplier = pli_vec3_make(0, 0, 0);
        anchor->inverse =
            plii_effective_mass(1.0f, substep->displacements[anchor->node].w + alpha, rigid->state.inverse_mass,
                                rigid->state.inverse_inertia_world, anchor->point.offset);
    }
}

static void xpbd_anchors_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const xpbd_anchors_state* state = data;
    const float alpha = state->compliance * substep->inverse_dt * substep->inverse_dt;
    for (int i = 0; i < state->count; ++i) {
        xpbd_anchor* anchor = &state->anchors[i];
        const pli_vec3 goal = pli_vec3_add(pli_vec3_add(anchor->goal, anchor->point.moved),
                                           plii_substep_rigid_point_motion(&anchor->point, substep));
        const pli_vec3 error = pli_vec3_add(pli_vec3_sub(plii_substep_position(body, substep, anchor->node), goal),
                                            pli_vec3_scale(anchor->multiplier, alpha));
        const pli_vec3 change = pli_vec3_neg(pli_mat3_mul_vec3(anchor->inverse, error));
        if (!plii_vec3_is_finite(change)) { continue; } /* neither side can move */
        anchor->multiplier = pli_vec3_add(anchor->multiplier, change);
        plii_substep_move(substep, anchor->node, change, 1.0f);
        plii_substep_rigid_point_push(&anchor->point, pli_vec3_neg(change), substep);
    }
}

static pli_status xpbd_anchors_enable(pli_body* body, void* data) {
    return xpbd_anchors_reserve(body, data) ? PLI_OK : PLI_ERROR_OUT_OF_MEMORY;
}

static size_t xpbd_anchors_bytes(const pli_body* body, const void* data) {
    (void)body;
    return (size_t)((const xpbd_anchors_state*)data)->capacity * sizeof(xpbd_anchor);
}

static void xpbd_anchors_disable(pli_body* body, void* data) {
    plii_release(body->context, ((xpbd_anchors_state*)data)->anchors, xpbd_anchors_bytes(body, data));
}

static void xpbd_anchors_topology_commit(pli_body* body, void* data, const plii_topology_change* change,
                                         void** blocks) {
    (void)body;
    (void)change;
    (void)blocks;
    ((xpbd_anchors_state*)data)->count = 0; /* made anew in each step */
}

static const plii_feature_class xpbd_anchors_class = {
    .name = "XPBD anchors",
    .state_size = sizeof(xpbd_anchors_state),
    .enable = xpbd_anchors_enable,
    .disable = xpbd_anchors_disable,
    .bytes = xpbd_anchors_bytes,
    .topology_commit = xpbd_anchors_topology_commit,
};

static bool xpbd_anchors_is_idle(const pli_body* body, const void* data) {
    (void)body;
    return ((const xpbd_anchors_state*)data)->count == 0;
}

enum { XPBD_ANCHORS_ORDER = 50 }; /* they take their nodes along after links and tethers */

static const plii_substep_class xpbd_anchors_kind = {
    .order = XPBD_ANCHORS_ORDER,
    .klass = &xpbd_anchors_class,
    .begin = xpbd_anchors_begin,
    .restart = xpbd_anchors_restart,
    .sweep = xpbd_anchors_sweep,
    .is_idle = xpbd_anchors_is_idle,
};

pli_status pli_body_enable_xpbd_anchors(pli_body* body, float compliance) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(plii_xpbd_check_value(body, compliance, PLI_MAX_COEFFICIENT, "compliance", __func__));
    void* state = NULL;
    PLII_TRY(plii_xpbd_enable_kind(body, &xpbd_anchors_kind, __func__, &state));
    ((xpbd_anchors_state*)state)->compliance = compliance;
    return PLI_OK;
}

pli_status pli_body_disable_xpbd_anchors(pli_body* body) {
    return plii_xpbd_disable_kind(body, &xpbd_anchors_kind, __func__);
}
