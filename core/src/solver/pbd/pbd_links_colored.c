/* Links on positions, colour by colour, with SIMD and threads. The correction of a link is that of
   btSoftBody::PSolve_Links, with the inverse of the mass term taken ahead. */

#include "body/pipeline.h"
#include "solver/coloring/links_kernel.h"

enum {
    COLORED_LINKS_FEWEST = 2 * PLII_LINK_LANES,
    COLORED_LINKS_LEAST = 3 /* links per row on the average; a row of fewer costs more than they do one by one */
};

typedef struct colored_links_state {
    const plii_link_colors* colors;
    float *rest_squared, *weights; /* by slot: see plii_links_task */
    int rest_capacity, weight_capacity;
} colored_links_state;

static void colored_links_sweep(pli_body* body, void* data) {
    const colored_links_state* state = data;
    const plii_links_task task = {.body = body,
                                  .colors = state->colors,
                                  .rest = state->rest_squared,
                                  .weights = state->weights,
                                  .moved = body->positions};
    plii_links_sweep_colors(&task);
}

/* False when out of memory. A body of few links, whose colours would not fill the lanes, or of some that all meet stays
   with the ordered sweep: along a chain that comes further per sweep than colours do. */
static bool colored_links_choose_sweep(pli_body* body, colored_links_state* state) {
    state->colors = plii_link_colors_of(body);
    const int slot_count = state->colors != NULL ? plii_link_colors_slot_count(state->colors) : 0;
    const bool is_ready = state->colors != NULL &&
                          PLII_RESERVE(body->context, &state->rest_squared, &state->rest_capacity, slot_count) &&
                          PLII_RESERVE(body->context, &state->weights, &state->weight_capacity, slot_count);
    const bool is_worthwhile = is_ready && body->link_count >= COLORED_LINKS_FEWEST &&
                               body->link_count >= COLORED_LINKS_LEAST * (int64_t)state->colors->linked_row_count;
    body->sweep_links = is_worthwhile ? colored_links_sweep : plii_links_sweep;
    body->sweep_links_state = is_worthwhile ? state : NULL;
    return is_ready;
}

/* Lanes without a link and links of pinned nodes have no weight. Rest lengths above 0 keep the kernel's divisors so. */
static void colored_links_prepare(pli_body* body, void* data) {
    const colored_links_state* state = data;
    if (body->sweep_revision == body->link_revision) { return; }
    if (!colored_links_choose_sweep(body, data)) { return; } /* without memory links keep their order in this step */
    const int slot_count = body->sweep_links == colored_links_sweep ? plii_link_colors_slot_count(state->colors) : 0;
    for (int i = 0; i < slot_count; ++i) {
        const int link = plii_link_colors_link(state->colors, i);
        const float mass_term = link != PLI_NULL_INDEX ? plii_link_mass_term(body, link) : 0.0f;
        state->rest_squared[i] = link != PLI_NULL_INDEX ? fmaxf(body->links[link].rest_length_squared, FLT_MIN) : 1.0f;
        state->weights[i] = mass_term > 0.0f ? 1.0f / mass_term : 0.0f;
    }
    body->sweep_revision = body->link_revision;
}

static void colored_links_enable(pli_body* body, void* data) {
    body->sweep_revision = body->link_revision - 1;
    (void)colored_links_choose_sweep(body, data);
}

static void colored_links_disable(pli_body* body, void* state) {
    body->sweep_links = plii_links_sweep;
    body->sweep_links_state = NULL;
}

const plii_feature_class plii_colored_links_class = {
    .name = "colored links",
    .state_size = sizeof(colored_links_state),
    .state_parts = PLII_STATE_PARTS(PLII_STATE(colored_links_state, colors, PLII_LEFT)),
    .needs = PLII_NEEDS(&plii_link_colors_class),
    .arrays = PLII_ARRAYS(
        {PLII_LIST_OF(colored_links_state, rest_squared, rest_capacity), .is_kept = true, .snapshot = PLII_LEFT},
        {PLII_LIST_OF(colored_links_state, weights, weight_capacity), .is_kept = true, .snapshot = PLII_LEFT}),
    .stages[PLII_STAGE_PREPARE] = {colored_links_prepare, PLII_ORDER_LINKS},
    .enable = colored_links_enable,
    .disable = colored_links_disable,
};

static pli_status colored_links_check(const pli_body* body, const char* function) {
    PLII_TRY(plii_check_body_idle(body, function));
    return plii_solver_check_change(body, &plii_position_solver, function);
}
pli_status pli_body_enable_colored_links(pli_body* body) {
    PLII_TRY(colored_links_check(body, __func__));
    return plii_body_changed(body, plii_feature_enable(body, &plii_colored_links_class, NULL));
}
PLII_DEFINE_DISABLE(pli_body_disable_colored_links, colored_links_check, plii_colored_links_class)
