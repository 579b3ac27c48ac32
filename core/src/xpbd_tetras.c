/* XPBD: volumes of tetrahedra, C = (x_b - x_a) . ((x_c - x_a) x (x_d - x_a)) / 6 - rest volume, in coloured order.
   The volume is signed, so an inverted tetrahedron turns back. */

#include "constraint_order.h"
#include "xpbd_impl.h"

typedef struct xpbd_tetra {
    int nodes[4];
    float rest_volume; /* m^3 */
    float multiplier;
} xpbd_tetra;

/* Cuts and refinement leave tetrahedra and the indices of their nodes as they are. */
typedef struct xpbd_tetras_state {
    float compliance;   /* m^5/N */
    xpbd_tetra* tetras; /* [tetra_count] in coloured order */
} xpbd_tetras_state;

static void xpbd_tetras_restart(pli_body* body, void* data, const plii_xpbd_substep* substep) {
    const xpbd_tetras_state* state = data;
    (void)substep;
    for (int i = 0; i < body->topology->tetra_count; ++i) {
        state->tetras[i].multiplier = 0.0f;
    }
}

static void xpbd_tetras_sweep(pli_body* body, void* data, const plii_xpbd_substep* substep) {
    const xpbd_tetras_state* state = data;
    for (int i = 0; i < body->topology->tetra_count; ++i) {
        xpbd_tetra* tetra = &state->tetras[i];
        const int* n = tetra->nodes;
        const pli_vec3 a = plii_xpbd_position(body, substep, n[0]);
        const pli_vec3 b = pli_vec3_sub(plii_xpbd_position(body, substep, n[1]), a);
        const pli_vec3 c = pli_vec3_sub(plii_xpbd_position(body, substep, n[2]), a);
        const pli_vec3 d = pli_vec3_sub(plii_xpbd_position(body, substep, n[3]), a);
        pli_vec3 gradients[4];
        gradients[1] = plii_vec3_divide(pli_vec3_cross(c, d), 6.0f);
        gradients[2] = plii_vec3_divide(pli_vec3_cross(d, b), 6.0f);
        gradients[3] = plii_vec3_divide(pli_vec3_cross(b, c), 6.0f);
        gradients[0] = pli_vec3_neg(pli_vec3_add(pli_vec3_add(gradients[1], gradients[2]), gradients[3]));
        float weight = 0.0f;
        for (int k = 0; k < 4; ++k) {
            weight += substep->displacements[n[k]].w * pli_vec3_length_squared(gradients[k]);
        }
        const float volume = pli_vec3_dot(b, gradients[1]);
        const float change = plii_xpbd_multiplier(volume - tetra->rest_volume, weight, state->compliance, 0.0f,
                                                  tetra->multiplier, 0.0f, substep);
        tetra->multiplier += change;
        for (int k = 0; k < 4; ++k) {
            plii_xpbd_move(substep, n[k], gradients[k], change);
        }
    }
}

// ------------------------------------------------------------------------------------------------------ the feature

static float xpbd_tetra_volume(const pli_body* body, const int* nodes) {
    const pli_vec3 a = plii_xyz(body->positions[nodes[0]]);
    const pli_vec3 b = pli_vec3_sub(plii_xyz(body->positions[nodes[1]]), a);
    const pli_vec3 c = pli_vec3_sub(plii_xyz(body->positions[nodes[2]]), a);
    const pli_vec3 d = pli_vec3_sub(plii_xyz(body->positions[nodes[3]]), a);
    return pli_vec3_dot(b, plii_vec3_divide(pli_vec3_cross(c, d), 6.0f));
}

static size_t xpbd_tetras_bytes(const pli_body* body, const void* data) {
    (void)data;
    return (size_t)body->topology->tetra_count * sizeof(xpbd_tetra);
}

static pli_status xpbd_tetras_enable(pli_body* body, void* data) {
    xpbd_tetras_state* state = data;
    pli_context* context = body->context;
    const plii_topology* topology = body->topology;
    const size_t count = (size_t)topology->tetra_count, nodes = (size_t)body->node_count;
    uint64_t* masks = plii_allocate(context, nodes * sizeof *masks);
    uint8_t* colors = plii_allocate(context, count * sizeof *colors);
    int* order = plii_allocate(context, count * sizeof *order);
    state->tetras = plii_allocate(context, xpbd_tetras_bytes(body, data));
    const bool is_complete = masks != NULL && colors != NULL && order != NULL && state->tetras != NULL;
    if (is_complete) {
        plii_constraint_order(topology->tetra_count, 4, topology->tetras[0], masks, colors, order);
        for (int i = 0; i < topology->tetra_count; ++i) {
            const int* n = topology->tetras[order[i]];
            state->tetras[i] = (xpbd_tetra){{n[0], n[1], n[2], n[3]}, xpbd_tetra_volume(body, n), 0.0f};
        }
    } else {
        plii_release(context, state->tetras, xpbd_tetras_bytes(body, data));
    }
    plii_release(context, masks, nodes * sizeof *masks);
    plii_release(context, colors, count * sizeof *colors);
    plii_release(context, order, count * sizeof *order);
    return is_complete ? PLI_OK : PLI_ERROR_OUT_OF_MEMORY;
}

static void xpbd_tetras_disable(pli_body* body, void* data) {
    plii_release(body->context, ((xpbd_tetras_state*)data)->tetras, xpbd_tetras_bytes(body, data));
}

static const plii_feature_class xpbd_tetras_class = {
    .name = "XPBD tetrahedra",
    .state_size = sizeof(xpbd_tetras_state),
    .enable = xpbd_tetras_enable,
    .disable = xpbd_tetras_disable,
    .bytes = xpbd_tetras_bytes,
};

static const plii_xpbd_kind xpbd_tetras_kind = {PLII_XPBD_ORDER_TETRAS, &xpbd_tetras_class, NULL,
                                                xpbd_tetras_restart,    xpbd_tetras_sweep,  NULL};

pli_status pli_body_enable_xpbd_tetras(pli_body* body, float compliance) {
    PLII_TRY(plii_check_body(body, __func__));
    PLII_TRY(plii_xpbd_check_value(body, compliance, "compliance", __func__));
    if (body->topology->tetra_count == 0) {
        return PLII_FAIL(body->context, PLI_ERROR_INVALID_MESH, "the body has no tetrahedra");
    }
    void* state = NULL;
    PLII_TRY(plii_xpbd_enable_kind(body, &xpbd_tetras_kind, __func__, &state));
    ((xpbd_tetras_state*)state)->compliance = compliance;
    return PLI_OK;
}

pli_status pli_body_disable_xpbd_tetras(pli_body* body) {
    return plii_xpbd_disable_kind(body, &xpbd_tetras_kind, __func__);
}
