/* XPBD: volume inside the faces, C = volume - pressure ratio * rest volume; one constraint on all nodes of the surface.
   The gradient of a node is a sixth of the sum of the cross products of the faces around it. */

#include "xpbd_impl.h"

typedef struct xpbd_volume_state {
    float compliance;     /* m^5/N */
    float pressure_ratio; /* wanted volume over the one at rest */
    double rest_volume;   /* m^3 */
    float multiplier;
    pli_vec3* gradients; /* [node_count] m^2 */
} xpbd_volume_state;

static void xpbd_volume_restart(pli_body* body, void* data, const plii_xpbd_substep* substep) {
    (void)body;
    (void)substep;
    ((xpbd_volume_state*)data)->multiplier = 0.0f;
}

static void xpbd_volume_add(pli_vec3* gradient, pli_vec3 u, pli_vec3 v) {
    *gradient = pli_vec3_add(*gradient, plii_vec3_divide(pli_vec3_cross(u, v), 6.0f));
}

/* Relative to node 0, which keeps the cross products small far from the origin; on a closed surface that changes
   nothing. */
static double xpbd_volume_gather(const pli_body* body, xpbd_volume_state* state, const plii_xpbd_substep* substep) {
    const plii_topology* topology = body->topology;
    const pli_vec3 origin = plii_xpbd_position(body, substep, 0);
    double volume = 0.0;
    for (int i = 0; i < body->node_count; ++i) {
        state->gradients[i] = pli_vec3_make(0, 0, 0);
    }
    for (int i = 0; i < topology->face_count; ++i) {
        const int* n = topology->faces[i];
        const pli_vec3 a = pli_vec3_sub(plii_xpbd_position(body, substep, n[0]), origin);
        const pli_vec3 b = pli_vec3_sub(plii_xpbd_position(body, substep, n[1]), origin);
        const pli_vec3 c = pli_vec3_sub(plii_xpbd_position(body, substep, n[2]), origin);
        xpbd_volume_add(&state->gradients[n[0]], b, c);
        xpbd_volume_add(&state->gradients[n[1]], c, a);
        xpbd_volume_add(&state->gradients[n[2]], a, b);
        volume += (double)pli_vec3_dot(a, pli_vec3_cross(b, c)) / 6.0;
    }
    return volume;
}

static void xpbd_volume_sweep(pli_body* body, void* data, const plii_xpbd_substep* substep) {
    xpbd_volume_state* state = data;
    const double volume = xpbd_volume_gather(body, state, substep);
    float weight = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        weight += substep->displacements[i].w * pli_vec3_length_squared(state->gradients[i]);
    }
    const double missing = volume - (double)state->pressure_ratio * state->rest_volume;
    const float change =
        plii_xpbd_multiplier((float)missing, weight, state->compliance, 0.0f, state->multiplier, 0.0f, substep);
    state->multiplier += change;
    for (int i = 0; i < body->node_count; ++i) {
        plii_xpbd_move(substep, i, state->gradients[i], change);
    }
}

// ------------------------------------------------------------------------------------------------------ the feature

static size_t xpbd_volume_bytes(const pli_body* body, const void* data) {
    (void)data;
    return (size_t)body->node_count * sizeof(pli_vec3);
}

static pli_status xpbd_volume_enable(pli_body* body, void* data) {
    xpbd_volume_state* state = data;
    state->gradients = plii_allocate(body->context, xpbd_volume_bytes(body, data));
    if (state->gradients == NULL) { return PLI_ERROR_OUT_OF_MEMORY; }
    state->rest_volume = (double)plii_body_volume(body);
    return PLI_OK;
}

static void xpbd_volume_disable(pli_body* body, void* data) {
    plii_release(body->context, ((xpbd_volume_state*)data)->gradients, xpbd_volume_bytes(body, data));
}

static int xpbd_volume_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                       size_t* sizes) {
    (void)body;
    (void)data;
    sizes[0] = (size_t)change->node_count * sizeof(pli_vec3);
    return 1;
}

static void xpbd_volume_topology_commit(pli_body* body, void* data, const plii_topology_change* change, void** blocks) {
    xpbd_volume_state* state = data;
    plii_release(body->context, state->gradients, (size_t)change->old_node_count * sizeof *state->gradients);
    state->gradients = blocks[0];
}

static const plii_feature_class xpbd_volume_class = {
    .name = "XPBD volume",
    .state_size = sizeof(xpbd_volume_state),
    .enable = xpbd_volume_enable,
    .disable = xpbd_volume_disable,
    .bytes = xpbd_volume_bytes,
    .topology_blocks = xpbd_volume_topology_blocks,
    .topology_commit = xpbd_volume_topology_commit,
};

static const plii_xpbd_kind xpbd_volume_kind = {
    .order = PLII_XPBD_ORDER_VOLUME,
    .klass = &xpbd_volume_class,
    .restart = xpbd_volume_restart,
    .sweep = xpbd_volume_sweep,
};

pli_status pli_body_enable_xpbd_volume(pli_body* body, float compliance, float pressure_ratio) {
    PLII_TRY(plii_check_body(body, __func__));
    PLII_TRY(plii_xpbd_check_value(body, compliance, "compliance", __func__));
    PLII_TRY(plii_xpbd_check_value(body, pressure_ratio, "pressure_ratio", __func__));
    if (body->topology->face_count == 0) {
        return PLII_FAIL(body->context, PLI_ERROR_INVALID_MESH, "the body has no faces");
    }
    void* data = NULL;
    PLII_TRY(plii_xpbd_enable_kind(body, &xpbd_volume_kind, __func__, &data));
    xpbd_volume_state* state = data;
    state->compliance = compliance;
    state->pressure_ratio = pressure_ratio;
    return PLI_OK;
}

pli_status pli_body_disable_xpbd_volume(pli_body* body) {
    return plii_xpbd_disable_kind(body, &xpbd_volume_kind, __func__);
}
