/* XPBD: lengths of the links, C = |x_b - x_a| - rest length, colour by colour. */

#include "body/pipeline.h"
#include "math/definition.h"
#include "solver/coloring/links_kernel.h"
#include "solver/xpbd/xpbd_impl.h"

typedef struct xpbd_links_state {
    pli_xpbd_links_def def;
    const plii_link_colors* colors;
    const plii_links_kernel* kernel;
    plii_link_slots rest_lengths, multipliers;
    plii_link_slots vectors;      /* see plii_links_start */
    plii_link_softness* softness; /* [2 * material_count] */
    uint32_t link_revision;
    bool is_stale; /* the rest lengths are to be taken anew */
} xpbd_links_state;

// --------------------------------------------------------------------------------------------------------- solving

/* Rest lengths may change between steps. */
static void xpbd_links_begin(pli_body* body, void* data) {
    xpbd_links_state* state = data;
    if (body->link_count == 0 || (!state->is_stale && state->link_revision == body->link_revision)) { return; }
    plii_link_slots* rest = &state->rest_lengths;
    plii_link_colors_gather(state->colors, &body->links[0].rest_length_squared,
                            (int)(sizeof *body->links / sizeof(float)), PLII_LINKS_NO_LINK, rest->values);
    const int slot_count = plii_link_colors_slot_count(state->colors);
    for (int i = 0; i < slot_count; ++i) {
        if (rest->values[i] >= 0.0f) { rest->values[i] = sqrtf(rest->values[i]); }
    }
    state->link_revision = body->link_revision;
    state->is_stale = false;
}

/* So may materials. */
static void xpbd_links_restart(pli_body* body, void* data, const plii_substep* substep) {
    xpbd_links_state* state = data;
    for (int i = 0; i < 2 * body->material_count; ++i) {
        const float stiffness = body->materials[i / 2].linear_stiffness;
        const float compliance = (i % 2 != 0 ? state->def.bending_compliance : state->def.compliance) / stiffness;
        const float alpha = compliance * substep->inverse_dt * substep->inverse_dt;
        const float gamma = compliance * (state->def.damping * stiffness) * substep->inverse_dt;
        state->softness[i] = (plii_link_softness){.alpha = alpha, .gamma = gamma};
    }
    if (substep->has_new_positions) {
        const plii_links_start start = {body, state->colors, body->positions, state->vectors.values};
        plii_links_start_colors(body->context, state->kernel, &start);
    }
}

static void xpbd_links_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const xpbd_links_state* state = data;
    const plii_links_task task = {.body = body,
                                  .colors = state->colors,
                                  .softness = state->softness,
                                  .rest = state->rest_lengths.values,
                                  .moved = substep->displacements,
                                  .vectors = state->vectors.values,
                                  .start_displacements = substep->start_displacements,
                                  .multipliers = state->multipliers.values,
                                  .reads_multipliers = !substep->is_first_sweep,
                                  .writes_multipliers = !substep->is_last_sweep};
    plii_links_sweep_colors(body->context, state->kernel, &task);
}

// ------------------------------------------------------------------------------------------------------ the feature

static pli_status xpbd_links_enable(pli_body* body, void* data) {
    xpbd_links_state* state = data;
    state->colors = plii_feature_state(body, &plii_link_colors_class);
    state->kernel = plii_links_kernel_of(body->context->simd);
    state->is_stale = true;
    const bool is_complete = plii_link_slots_make(body, state->colors, 1, &state->rest_lengths) &&
                             plii_link_slots_make(body, state->colors, 1, &state->multipliers) &&
                             plii_link_slots_make(body, state->colors, 3, &state->vectors);
    return is_complete ? PLI_OK : PLI_ERROR_OUT_OF_MEMORY;
}

static const plii_feature_array xpbd_links_arrays[] = {
    {PLII_BLOCK_OF(xpbd_links_state, rest_lengths.values, rest_lengths.size)},
    {PLII_BLOCK_OF(xpbd_links_state, multipliers.values, multipliers.size)},
    {PLII_BLOCK_OF(xpbd_links_state, vectors.values, vectors.size)},
    {PLII_MEMBER(xpbd_links_state, softness), PLII_PER_MATERIAL, .times = 2},
    {0},
};
enum { XPBD_LINKS_ARRAYS = sizeof xpbd_links_arrays / sizeof *xpbd_links_arrays - 1 };

static int xpbd_links_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                      size_t* sizes) {
    (void)data;
    sizes[0] = sizes[1] = plii_link_slots_max_size(body, change->link_count, 1);
    sizes[2] = plii_link_slots_max_size(body, change->link_count, 3);
    return 3;
}

static void xpbd_links_topology_commit(pli_body* body, void* data, const plii_topology_change* change, void** blocks) {
    xpbd_links_state* state = data;
    plii_link_slots_replace(body, state->colors, change->link_count, 1, blocks[XPBD_LINKS_ARRAYS],
                            &state->rest_lengths);
    plii_link_slots_replace(body, state->colors, change->link_count, 1, blocks[XPBD_LINKS_ARRAYS + 1],
                            &state->multipliers);
    plii_link_slots_replace(body, state->colors, change->link_count, 3, blocks[XPBD_LINKS_ARRAYS + 2], &state->vectors);
    state->is_stale = true;
}

static const plii_feature_class* const xpbd_links_needs[] = {&plii_link_colors_class, NULL};

static const plii_feature_class xpbd_links_class = {
    .name = "XPBD links",
    .state_size = sizeof(xpbd_links_state),
    .needs = xpbd_links_needs,
    .arrays = xpbd_links_arrays,
    .enable = xpbd_links_enable,
    .topology_blocks = xpbd_links_topology_blocks,
    .topology_commit = xpbd_links_topology_commit,
};

enum { XPBD_LINKS_ORDER = 40 }; /* the last that holds the body together, before tethers and anchors */

static const plii_substep_class xpbd_links_kind = {
    .order = XPBD_LINKS_ORDER,
    .klass = &xpbd_links_class,
    .begin = xpbd_links_begin,
    .restart = xpbd_links_restart,
    .sweep = xpbd_links_sweep,
};

pli_xpbd_links_def pli_xpbd_links_def_default(void) {
    return (pli_xpbd_links_def){.cookie = PLII_DEF_COOKIE};
}

static const plii_field xpbd_links_fields[] = {
    PLII_FIELD(pli_xpbd_links_def, compliance, 0, PLI_MAX_COEFFICIENT),
    PLII_FIELD(pli_xpbd_links_def, bending_compliance, 0, PLI_MAX_COEFFICIENT),
    PLII_FIELD(pli_xpbd_links_def, damping, 0, PLI_MAX_COEFFICIENT),
};

pli_status pli_body_enable_xpbd_links(pli_body* body, const pli_xpbd_links_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    const pli_xpbd_links_def defaults = pli_xpbd_links_def_default();
    if (def == NULL) { def = &defaults; }
    PLII_TRY_DEF(body->context, pli_xpbd_links_def, def, xpbd_links_fields, __func__);
    void* state = NULL;
    PLII_TRY(plii_xpbd_enable_kind(body, &xpbd_links_kind, __func__, &state));
    ((xpbd_links_state*)state)->def = *def;
    return PLI_OK;
}

pli_status pli_body_disable_xpbd_links(pli_body* body) {
    return plii_xpbd_disable_kind(body, &xpbd_links_kind, __func__);
}
