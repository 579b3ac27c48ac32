/* XPBD: lengths of the links, C = |x_b - x_a| - rest length, colour by colour. */

#include "solver/coloring/links_kernel.h"
#include "solver/xpbd/xpbd_impl.h"

typedef struct xpbd_links_state {
    pli_xpbd_links_def def;
    float* numbers; /* arrays of the task, one after the other */
    int capacity;
    bool was_closed;        /* the halves of a ball would get energy as the ball would */
    float softening;        /* see plii_links_task */
    uint32_t link_revision; /* of the numbers of links */
    plii_links_task task;   /* without colors where there was no memory for them */
} xpbd_links_state;

enum { XPBD_LINKS_LARGE_SURFACE = 80 }; /* nodes */
#define XPBD_LINKS_FEW_BRACES 0.07f     /* of the edges */
#define XPBD_LINKS_SOME_BRACES 0.3f
#define XPBD_LINKS_UNEQUAL 10.0f     /* ratio of the masses at the ends */
#define XPBD_LINKS_MANY_UNEQUAL 0.1f /* of the links */

/* Errors that the colours push on around a body would grow from sweep to sweep, unless each link leaves half of its
   own: on a surface that has as many links as its faces have edges, of two faces each, which keeps its shape by them
   alone. What hangs from it changes nothing about that, nor do a few links through the inside of a large one. With some
   more a third is enough to leave, as it is where the masses of neighbours differ much. */
static float xpbd_links_softening(const pli_body* body) {
    int64_t links = 0, unequal = 0;
    for (int i = 0; i < body->link_count; ++i) {
        const int* nodes = body->links[i].nodes;
        const float a = body->positions[nodes[0]].w, b = body->positions[nodes[1]].w;
        links += !plii_link_is_bending(body, i);
        unequal += a > 0.0f && b > 0.0f && (a > XPBD_LINKS_UNEQUAL * b || b > XPBD_LINKS_UNEQUAL * a);
    }
    const int64_t faces = body->topology->face_count, more = 2 * links - 3 * faces; /* twice as many as edges */
    if (faces > 0 && more == 0) { return 1.0f; }
    /* A node that is not of the surface, of a sphere's, takes three links to be held. */
    const int64_t others = body->node_count - (faces / 2 + 2), braces = more - 6 * (others > 0 ? others : 0);
    const float share = (float)braces / (float)(3 * faces);
    if (faces > 0 && more > 0 && share <= XPBD_LINKS_SOME_BRACES && body->node_count >= XPBD_LINKS_LARGE_SURFACE &&
        plii_topology_is_closed(body->topology)) {
        return share <= XPBD_LINKS_FEW_BRACES ? 1.0f : 0.5f;
    }
    return (float)unequal > XPBD_LINKS_MANY_UNEQUAL * (float)body->link_count ? 0.5f : 0.0f;
}

/* Links may change between steps. */
static void xpbd_links_begin(pli_body* body, void* data) {
    xpbd_links_state* state = data;
    const pli_xpbd_links_def* def = &state->def;
    const plii_link_colors* colors = plii_link_colors_of(body);
    const ptrdiff_t count = colors != NULL ? plii_link_colors_slot_count(colors) : 0;
    const bool is_soft = def->compliance > 0.0f || def->bending_compliance > 0.0f;
    const bool is_damped = is_soft && def->damping > 0.0f;
    const int needed = (5 + is_soft + is_damped) * (int)count;
    if (state->capacity < needed) { /* as much as is needed, and filled anew */
        PLII_RELEASE(body->context, state->numbers, state->capacity);
        state->capacity = PLII_ALLOCATE(body->context, &state->numbers, needed) ? needed : 0;
        state->link_revision = body->link_revision - 1;
    }
    state->task = (plii_links_task){.body = body, .colors = state->capacity >= needed ? colors : NULL};
    if (state->task.colors == NULL || count == 0) { return; }
    body->damps_links = is_damped;
    float* rest_lengths = state->numbers;
    float* compliances = is_soft ? rest_lengths + 5 * count : NULL;
    float* dampings = is_damped ? rest_lengths + 6 * count : NULL;
    state->task.rest = rest_lengths;
    state->task.multipliers = rest_lengths + count;
    state->task.vectors = rest_lengths + 2 * count;
    state->task.compliances = compliances;
    state->task.dampings = dampings;
    if (state->link_revision == body->link_revision) { return; }
    for (int i = 0; i < count; ++i) {
        const int link = plii_link_colors_link(colors, i);
        const bool is_link = link != PLI_NULL_INDEX;
        rest_lengths[i] = is_link ? sqrtf(body->links[link].rest_length_squared) : PLII_LINKS_NO_LINK;
        if (!is_soft) { continue; }
        const float compliance =
            is_link && plii_link_is_bending(body, link) ? def->bending_compliance : def->compliance;
        compliances[i] = is_link ? compliance / plii_link_stiffness(body, link) : 0.0f;
        if (is_damped) { dampings[i] = compliance * def->damping; }
    }
    state->softening = state->was_closed ? 1.0f : xpbd_links_softening(body);
    state->was_closed = state->softening == 1.0f;
    state->link_revision = body->link_revision;
}

static bool xpbd_links_is_idle(const void* state) {
    return ((const xpbd_links_state*)state)->task.colors == NULL;
}

static void xpbd_links_restart(pli_body* body, void* data, const plii_substep* substep) {
    if (substep->has_new_positions) { plii_links_start_colors(&((const xpbd_links_state*)data)->task); }
}

static void xpbd_links_sweep(pli_body* body, void* data, const plii_substep* substep) {
    xpbd_links_state* state = data;
    state->task.softening = plii_xpbd_softening(state->softening, substep);
    state->task.inverse_dt = substep->inverse_dt;
    state->task.moved = substep->displacements;
    state->task.start_displacements = substep->start_displacements;
    state->task.reads_multipliers = !substep->is_first_sweep;
    state->task.writes_multipliers = !substep->is_last_sweep;
    plii_links_sweep_colors(&state->task);
}

/* Compliances are those of the definition that was restored. */
static void xpbd_links_on_restored(pli_body* body, void* data) {
    ((xpbd_links_state*)data)->link_revision = body->link_revision - 1;
}
static void xpbd_links_enable(pli_body* body, void* data) {
    xpbd_links_on_restored(body, data);
    xpbd_links_begin(body, data);
}

enum { XPBD_LINKS_ORDER = 40 }; /* the last that holds the body together, before tethers and anchors */
const plii_feature_class plii_xpbd_links_class = {
    .name = "XPBD links",
    .state_size = sizeof(xpbd_links_state),
    .settings = PLII_LIMITS_AT(offsetof(xpbd_links_state, def),
                               PLII_FIELD(pli_xpbd_links_def, compliance, 0, PLI_MAX_COEFFICIENT),
                               PLII_FIELD(pli_xpbd_links_def, bending_compliance, 0, PLI_MAX_COEFFICIENT),
                               PLII_FIELD(pli_xpbd_links_def, damping, 0, PLI_MAX_COEFFICIENT)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(xpbd_links_state, def, PLII_SAVED, "3fu"),
                                    PLII_STATE_OF(xpbd_links_state, was_closed, PLII_SAVED, "B"),
                                    PLII_STATE_SPAN(xpbd_links_state, softening, task, PLII_LEFT, NULL)),
    .needs = PLII_NEEDS(&plii_link_colors_class),
    .arrays = PLII_ARRAYS({PLII_LIST_OF(xpbd_links_state, numbers, capacity), .is_kept = true, .snapshot = PLII_LEFT}),
    .enable = xpbd_links_enable,
    .on_restored = xpbd_links_on_restored,
    .substepped =
        PLII_SUBSTEPPED(.order = XPBD_LINKS_ORDER, .is_of_xpbd = true, .begin = xpbd_links_begin,
                        .is_idle = xpbd_links_is_idle, .restart = xpbd_links_restart, .sweep = xpbd_links_sweep),
};

PLII_DEFINE_DEFAULT(pli_xpbd_links_def, 0)
pli_status pli_body_enable_xpbd_links(pli_body* body, const pli_xpbd_links_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_SETTINGS(body, pli_xpbd_links_def, used, def, plii_xpbd_links_class);
    xpbd_links_state* state = NULL;
    PLII_TRY(plii_xpbd_enable_kind(body, &plii_xpbd_links_class, &used, sizeof used, __func__, (void**)&state));
    xpbd_links_enable(body, state); /* takes memory now; where there is none the step tells */
    return PLI_OK;
}
PLII_DEFINE_DISABLE(pli_body_disable_xpbd_links, plii_check_body_idle, plii_xpbd_links_class)
