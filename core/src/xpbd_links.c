/* XPBD: lengths of the links, C = |x_b - x_a| - rest length, in coloured order. */

#include "constraint_order.h"
#include "xpbd_impl.h"

typedef struct xpbd_link {
    int nodes[2];
    float rest_length; /* m */
    float compliance;  /* m/N */
    float damping;     /* N s/m */
    float multiplier;
} xpbd_link;

typedef struct xpbd_links_state {
    pli_xpbd_links_def def;
    int* order;       /* [link_count] */
    xpbd_link* links; /* [link_count] in that order */
} xpbd_links_state;

/* What making the order needs for a while. */
typedef struct xpbd_links_scratch {
    int (*nodes)[2];
    uint64_t* masks;
    uint8_t* colors;
} xpbd_links_scratch;

static size_t xpbd_links_size(int link_count) {
    return (size_t)link_count * sizeof(xpbd_link);
}
static size_t xpbd_links_order_size(int link_count) {
    return (size_t)link_count * sizeof(int);
}

// --------------------------------------------------------------------------------------------------------- solving

/* Rest lengths and materials may change between steps. */
static void xpbd_links_begin(pli_body* body, void* data) {
    const xpbd_links_state* state = data;
    for (int i = 0; i < body->link_count; ++i) {
        const int index = state->order[i];
        const plii_link* link = &body->links[index];
        const bool is_bending = body->link_tags != NULL && (body->link_tags[index] & PLII_LINK_TAG_BENDING) != 0;
        const float compliance = is_bending ? state->def.bending_compliance : state->def.compliance;
        const float material = plii_link_stiffness(body, index);
        state->links[i] = (xpbd_link){.nodes = {link->nodes[0], link->nodes[1]},
                                      .rest_length = sqrtf(link->rest_length_squared),
                                      .compliance = compliance / material,
                                      .damping = state->def.damping * material};
    }
}

static void xpbd_links_restart(pli_body* body, void* data, const plii_xpbd_substep* substep) {
    const xpbd_links_state* state = data;
    (void)substep;
    for (int i = 0; i < body->link_count; ++i) {
        state->links[i].multiplier = 0.0f;
    }
}

static void xpbd_links_sweep(pli_body* body, void* data, const plii_xpbd_substep* substep) {
    const xpbd_links_state* state = data;
    for (int i = 0; i < body->link_count; ++i) {
        xpbd_link* link = &state->links[i];
        const int a = link->nodes[0], b = link->nodes[1];
        const pli_vec3 before = pli_vec3_sub(plii_xyz(body->positions[b]), plii_xyz(body->positions[a]));
        const pli_vec3 moved = pli_vec3_sub(plii_xyz(substep->displacements[b]), plii_xyz(substep->displacements[a]));
        const pli_vec3 delta = pli_vec3_add(before, moved);
        const float length = pli_vec3_length(delta);
        if (!(length > 0.0f)) { continue; } /* no direction */
        const pli_vec3 n = pli_vec3_scale(delta, 1.0f / length);
        const pli_vec3 motion = pli_vec3_sub(plii_xpbd_motion(substep, b), plii_xpbd_motion(substep, a));
        const float weight = substep->displacements[a].w + substep->displacements[b].w;
        const float change = plii_xpbd_multiplier(length - link->rest_length, weight, link->compliance, link->damping,
                                                  link->multiplier, pli_vec3_dot(n, motion), substep);
        link->multiplier += change;
        plii_xpbd_move(substep, a, n, -change);
        plii_xpbd_move(substep, b, n, change);
    }
}

// ------------------------------------------------------------------------------------------------------ the feature

static void xpbd_links_make_order(const pli_body* body, const xpbd_links_state* state,
                                  const xpbd_links_scratch* scratch) {
    for (int i = 0; i < body->link_count; ++i) {
        scratch->nodes[i][0] = body->links[i].nodes[0];
        scratch->nodes[i][1] = body->links[i].nodes[1];
    }
    if (body->link_count > 0) {
        plii_constraint_order(body->link_count, 2, scratch->nodes[0], scratch->masks, scratch->colors, state->order);
    }
}

static void xpbd_links_release_scratch(pli_body* body, const xpbd_links_scratch* scratch) {
    plii_release(body->context, scratch->nodes, (size_t)body->link_count * sizeof *scratch->nodes);
    plii_release(body->context, scratch->masks, (size_t)body->node_count * sizeof *scratch->masks);
    plii_release(body->context, scratch->colors, (size_t)body->link_count * sizeof *scratch->colors);
}

static pli_status xpbd_links_enable(pli_body* body, void* data) {
    xpbd_links_state* state = data;
    pli_context* context = body->context;
    const size_t count = (size_t)body->link_count;
    const xpbd_links_scratch scratch = {
        plii_allocate(context, count * sizeof *scratch.nodes),
        plii_allocate(context, (size_t)body->node_count * sizeof *scratch.masks),
        plii_allocate(context, count * sizeof *scratch.colors),
    };
    state->order = plii_allocate(context, xpbd_links_order_size(body->link_count));
    state->links = plii_allocate(context, xpbd_links_size(body->link_count));
    const bool is_complete = count == 0 || (scratch.nodes != NULL && scratch.masks != NULL && scratch.colors != NULL &&
                                            state->order != NULL && state->links != NULL);
    if (is_complete) {
        xpbd_links_make_order(body, state, &scratch);
    } else {
        plii_release(context, state->order, xpbd_links_order_size(body->link_count));
        plii_release(context, state->links, xpbd_links_size(body->link_count));
    }
    xpbd_links_release_scratch(body, &scratch);
    return is_complete ? PLI_OK : PLI_ERROR_OUT_OF_MEMORY;
}

static void xpbd_links_disable(pli_body* body, void* data) {
    const xpbd_links_state* state = data;
    plii_release(body->context, state->order, xpbd_links_order_size(body->link_count));
    plii_release(body->context, state->links, xpbd_links_size(body->link_count));
}

static size_t xpbd_links_bytes(const pli_body* body, const void* data) {
    (void)data;
    return xpbd_links_order_size(body->link_count) + xpbd_links_size(body->link_count);
}

static int xpbd_links_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                      size_t* sizes) {
    const xpbd_links_scratch scratch = {0};
    (void)body;
    (void)data;
    sizes[0] = xpbd_links_order_size(change->link_count);
    sizes[1] = xpbd_links_size(change->link_count);
    sizes[2] = (size_t)change->link_count * sizeof *scratch.nodes;
    sizes[3] = (size_t)change->node_count * sizeof *scratch.masks;
    sizes[4] = (size_t)change->link_count * sizeof *scratch.colors;
    return 5;
}

static void xpbd_links_topology_commit(pli_body* body, void* data, const plii_topology_change* change, void** blocks) {
    xpbd_links_state* state = data;
    plii_release(body->context, state->order, xpbd_links_order_size(change->old_link_count));
    plii_release(body->context, state->links, xpbd_links_size(change->old_link_count));
    state->order = blocks[0];
    state->links = blocks[1];
    const xpbd_links_scratch scratch = {blocks[2], blocks[3], blocks[4]};
    xpbd_links_make_order(body, state, &scratch);
    xpbd_links_release_scratch(body, &scratch);
}

static const plii_feature_class xpbd_links_class = {
    .name = "XPBD links",
    .state_size = sizeof(xpbd_links_state),
    .enable = xpbd_links_enable,
    .disable = xpbd_links_disable,
    .bytes = xpbd_links_bytes,
    .topology_blocks = xpbd_links_topology_blocks,
    .topology_commit = xpbd_links_topology_commit,
};

static const plii_xpbd_kind xpbd_links_kind = {PLII_XPBD_ORDER_LINKS, &xpbd_links_class, xpbd_links_begin,
                                               xpbd_links_restart,    xpbd_links_sweep,  NULL};

pli_xpbd_links_def pli_xpbd_links_def_default(void) {
    return (pli_xpbd_links_def){.cookie = PLII_DEF_COOKIE};
}

pli_status pli_body_enable_xpbd_links(pli_body* body, const pli_xpbd_links_def* def) {
    PLII_TRY(plii_check_body(body, __func__));
    if (def == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "def is null"); }
    if (def->cookie != PLII_DEF_COOKIE) {
        return PLII_FAIL(body->context, PLI_ERROR_INVALID_DEF, "start from pli_xpbd_links_def_default()");
    }
    PLII_TRY(plii_xpbd_check_value(body, def->compliance, "compliance", __func__));
    PLII_TRY(plii_xpbd_check_value(body, def->bending_compliance, "bending_compliance", __func__));
    PLII_TRY(plii_xpbd_check_value(body, def->damping, "damping", __func__));
    void* state = NULL;
    PLII_TRY(plii_xpbd_enable_kind(body, &xpbd_links_kind, __func__, &state));
    ((xpbd_links_state*)state)->def = *def;
    return PLI_OK;
}

pli_status pli_body_disable_xpbd_links(pli_body* body) {
    return plii_xpbd_disable_kind(body, &xpbd_links_kind, __func__);
}
