/* Links on positions, colour by colour, with SIMD and threads. The arithmetic of a link is that of
   btSoftBody::PSolve_Links, but for the mass term, which is multiplied by the inverse of the stiffness. */

#include "body/pipeline.h"
#include "math/simd_float8.h"
#include "solver/coloring/links_kernel.h"

enum {
    COLORED_LINKS_FEWEST = 2 * PLII_LINK_LANES,
    COLORED_LINKS_LEAST = 3 /* links per row on the average; a row of fewer costs more than they do one by one */
};

typedef struct colored_links_state {
    const plii_link_colors* colors;
    const plii_links_kernel* kernel;
    plii_link_slots rest_squared; /* m^2 */
    uint32_t link_revision;
    bool is_stale;
    plii_link_softness* softness; /* [2 * material_count] */
} colored_links_state;

static void colored_links_refresh(pli_body* body, colored_links_state* state) {
    for (int i = 0; i < 2 * body->material_count; ++i) {
        state->softness[i].inverse_stiffness = 1.0f / body->materials[i / 2].linear_stiffness;
    }
    if (!state->is_stale && state->link_revision == body->link_revision) { return; }
    if (body->link_count > 0) {
        plii_link_colors_gather(state->colors, &body->links[0].rest_length_squared,
                                (int)(sizeof *body->links / sizeof(float)), PLII_LINKS_NO_LINK,
                                state->rest_squared.values);
    }
    state->link_revision = body->link_revision;
    state->is_stale = false;
}

static void colored_links_sweep(pli_body* body, void* data) {
    const colored_links_state* state = data;
    const plii_links_task task = {.body = body,
                                  .colors = state->colors,
                                  .softness = state->softness,
                                  .rest = state->rest_squared.values,
                                  .moved = body->positions};
    plii_links_sweep_colors(body->context, state->kernel, &task);
}

static void colored_links_prepare(pli_body* body, void* state, const plii_step* step) {
    (void)step;
    if (body->sweep_links == colored_links_sweep) { colored_links_refresh(body, state); }
}

// ------------------------------------------------------------------------------------------------------ the feature

static size_t colored_links_softness_size(const pli_body* body) {
    return 2 * (size_t)body->material_count * sizeof(plii_link_softness);
}
/* A body of few links, whose colours would not fill the lanes, or of some that all meet stays with the ordered sweep:
   along a chain that comes further per sweep than colours do. */
static void colored_links_choose_sweep(pli_body* body, colored_links_state* state) {
    const plii_link_colors* colors = state->colors;
    const int64_t row_count = (int64_t)colors->row_count + colors->serial_count;
    const bool is_worthwhile =
        body->link_count >= COLORED_LINKS_FEWEST && body->link_count >= COLORED_LINKS_LEAST * row_count;
    body->sweep_links = is_worthwhile ? colored_links_sweep : plii_links_sweep;
    body->sweep_links_state = state;
    state->is_stale = true;
}

static void colored_links_release(const pli_body* body, colored_links_state* state) {
    plii_link_slots_release(body, &state->rest_squared);
    plii_release(body->context, state->softness, colored_links_softness_size(body));
}

static pli_status colored_links_enable(pli_body* body, void* data) {
    colored_links_state* state = data;
    state->colors = plii_feature_state(body, &plii_link_colors_class);
    state->kernel = plii_links_kernel_of(body->context->simd);
    state->softness = plii_allocate(body->context, colored_links_softness_size(body));
    if (!plii_link_slots_make(body, state->colors, 1, &state->rest_squared) || state->softness == NULL) {
        colored_links_release(body, state);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    colored_links_choose_sweep(body, state);
    return PLI_OK;
}

static void colored_links_disable(pli_body* body, void* data) {
    colored_links_release(body, data);
    body->sweep_links = plii_links_sweep;
    body->sweep_links_state = NULL;
}

static size_t colored_links_bytes(const pli_body* body, const void* data) {
    const colored_links_state* state = data;
    return state->rest_squared.size + colored_links_softness_size(body);
}

static int colored_links_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                         size_t* sizes) {
    (void)data;
    sizes[0] = plii_link_slots_max_size(body, change->link_count, 1);
    return 1;
}

static void colored_links_topology_commit(pli_body* body, void* data, const plii_topology_change* change,
                                          void** blocks) {
    colored_links_state* state = data;
    plii_link_slots_replace(body, state->colors, change->link_count, 1, blocks[0], &state->rest_squared);
    colored_links_choose_sweep(body, state);
}

static const plii_feature_class* const colored_links_needs[] = {&plii_link_colors_class, NULL};

static const plii_feature_class colored_links_class = {
    .name = "colored links",
    .state_size = sizeof(colored_links_state),
    .needs = colored_links_needs,
    .stages[PLII_STAGE_PREPARE] = {colored_links_prepare, PLII_ORDER_LINKS},
    .enable = colored_links_enable,
    .disable = colored_links_disable,
    .bytes = colored_links_bytes,
    .topology_blocks = colored_links_topology_blocks,
    .topology_commit = colored_links_topology_commit,
};

pli_status pli_body_enable_colored_links(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(plii_solver_check_change(body, &plii_position_solver, __func__));
    return plii_feature_enable(body, &colored_links_class, NULL);
}

pli_status pli_body_disable_colored_links(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(plii_solver_check_change(body, &plii_position_solver, __func__));
    plii_feature_disable(body, &colored_links_class);
    return PLI_OK;
}
