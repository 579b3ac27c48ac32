/* Links on positions, colour by colour, with SIMD and threads. The arithmetic of a link is that of
   btSoftBody::PSolve_Links, but for the mass term, which is multiplied by the inverse of the stiffness. */

#include "link_shares.h"
#include "links_kernel.h"
#include "simd.h"

#include <limits.h>

enum {
    COLORED_LINKS_SHARED = 32768,   /* links */
    COLORED_LINKS_GRAIN = 256,      /* groups of links, some 2 us: what a range costs where processors are far apart */
    COLORED_LINKS_QUADS_GRAIN = 64, /* groups of quads */
    COLORED_LINKS_FEWEST = 2 * PLII_LINK_LANES,
    COLORED_LINKS_LEAST = 3, /* links per row on the average; a row of fewer costs more than they do one by one */
    COLORED_LINKS_BANDS_NODES = 32768, /* a smaller body stays in the second cache */
    COLORED_LINKS_BAND = 8192,         /* nodes at least */
    COLORED_LINKS_CACHE = 3 << 19,     /* bytes of nodes and rest lengths in the bands of sweeps at once */
    COLORED_LINKS_WIDEST_SKEW = 32768, /* nodes */
    COLORED_LINKS_TURN_GRAIN = 4096    /* nodes */
};

typedef struct colored_links_state {
    const plii_link_colors* colors;
    const plii_links_kernel* kernel;
    plii_links_runs_fn* in_planes;
    plii_link_slots rest_squared; /* m^2 */
    uint32_t link_revision;
    bool is_stale;
    float* inverse_stiffnesses; /* [material_count] */
    int band_count;             /* 0: colour by colour over the whole body */
    int band_size;              /* nodes */
    int sweeps_at_once;         /* over bands */
    int* cuts;                  /* [band_count][color_count of runs] groups of a colour up to the end of a band */
    size_t cuts_size;           /* bytes */
} colored_links_state;

static const plii_links_kernel* colored_links_kernel(pli_simd simd) {
    switch (simd) {
#if PLIANT_SIMD_X86
    case PLI_SIMD_AVX512:
        return &plii_links_kernel_avx512;
    case PLI_SIMD_AVX2:
        return &plii_links_kernel_avx2;
    case PLI_SIMD_SSE2:
        return &plii_links_kernel_sse2;
#endif
#if PLIANT_SIMD_NEON
    case PLI_SIMD_NEON:
        return &plii_links_kernel_neon;
#endif
    default:
        return &plii_links_kernel_portable;
    }
}

static plii_links_runs_fn* colored_links_in_planes(pli_simd simd) {
#if PLIANT_SIMD_X86
    if (simd == PLI_SIMD_AVX512) { return plii_links_in_planes_avx512; }
#endif
    return colored_links_kernel(simd)->in_planes;
}

static void colored_links_refresh(pli_body* body, colored_links_state* state) {
    for (int i = 0; i < body->material_count; ++i) {
        state->inverse_stiffnesses[i] = 1.0f / body->materials[i].linear_stiffness;
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

typedef struct colored_links_part {
    const colored_links_state* state;
    plii_links_runs_fn* solve_runs;
    plii_links_task task;
    int color;       /* of runs */
    int first_group; /* of a colour of quads */
} colored_links_part;

static void colored_links_runs_range(int begin, int end, void* data) {
    const colored_links_part* part = data;
    part->solve_runs(&part->task, part->color, begin, end);
}
static void colored_links_quads_range(int begin, int end, void* data) {
    const colored_links_part* part = data;
    part->state->kernel->groups(&part->task, part->first_group + begin, part->first_group + end);
}

static void colored_links_sweep_runs(colored_links_part* part) {
    const plii_link_runs* runs = &part->state->colors->runs;
    for (int c = 0; c < runs->color_count; ++c) {
        const int count = runs->colors[c + 1].first_group - runs->colors[c].first_group;
        part->color = c;
        plii_parallel_for(part->task.body->context, colored_links_runs_range, part, count,
                          plii_link_colors_grain(part->task.body, count, COLORED_LINKS_GRAIN, COLORED_LINKS_SHARED));
    }
}
static void colored_links_sweep_band(const colored_links_part* part, int band) {
    const colored_links_state* state = part->state;
    const int color_count = state->colors->runs.color_count;
    const int* cuts = state->cuts + (ptrdiff_t)band * color_count;
    for (int c = 0; c < color_count; ++c) {
        const int before = band > 0 ? cuts[c - color_count] : 0;
        if (before < cuts[c]) { part->solve_runs(&part->task, c, before, cuts[c]); }
    }
}
/* Some sweeps at once, each one band behind the one before. */
static void colored_links_sweep_bands(const colored_links_part* part, int count) {
    const colored_links_state* state = part->state;
    for (int left = count, own = 0; left > 0; left -= own) {
        own = left < state->sweeps_at_once ? left : state->sweeps_at_once;
        for (int time = 0; time < state->band_count + own - 1; ++time) {
            const int first = time < state->band_count ? 0 : time - state->band_count + 1;
            for (int sweep = first; sweep < own && sweep <= time; ++sweep) {
                colored_links_sweep_band(part, time - sweep);
            }
        }
    }
}
static void colored_links_sweep_quads(colored_links_part* part) {
    const plii_link_colors* colors = part->state->colors;
    for (int c = 0; c < colors->color_count; ++c) {
        const int count = colors->colors[c].group_count;
        part->first_group = colors->colors[c].first_group;
        plii_parallel_for(
            part->task.body->context, colored_links_quads_range, part, count,
            plii_link_colors_grain(part->task.body, count, COLORED_LINKS_QUADS_GRAIN, COLORED_LINKS_SHARED));
    }
}

static bool colored_links_has_bands(const colored_links_part* part) {
    return part->state->band_count > 0 && !plii_has_threads(part->task.body->context);
}

static void colored_links_sweep(pli_body* body, void* data) {
    const colored_links_state* state = data;
    const plii_link_colors* colors = state->colors;
    colored_links_part part = {.state = state,
                               .solve_runs = state->kernel->runs,
                               .task = {.body = body,
                                        .colors = colors,
                                        .rest_squared = state->rest_squared.values,
                                        .inverse_stiffnesses = state->inverse_stiffnesses}};
    const bool has_bands = colored_links_has_bands(&part);
    const bool is_small = body->link_count < COLORED_LINKS_SHARED;
    if (!has_bands && (is_small || !plii_has_threads(body->context))) {
        state->kernel->sweep(&part.task);
        return;
    }
    if (has_bands) {
        colored_links_sweep_bands(&part, 1);
    } else {
        colored_links_sweep_runs(&part);
    }
    colored_links_sweep_quads(&part);
    if (colors->serial_count > 0) { state->kernel->serial(&part.task); }
}

/* In planes, where nodes of runs follow each other without being turned. Their place is that of the velocities, which
   follow from the positions afterwards. */

typedef struct colored_links_turn {
    pli_body* body;
    const plii_planes* planes;
} colored_links_turn;

static void colored_links_take(int begin, int end, void* data) {
    const colored_links_turn* turn = data;
    plii_planes_take(turn->planes, turn->body->positions, begin, end);
}
static void colored_links_give(int begin, int end, void* data) {
    const colored_links_turn* turn = data;
    plii_planes_give(turn->planes, turn->body->positions, begin, end);
}

/* By threads that each have some rows. */
typedef struct colored_links_together {
    const colored_links_part* part;
    colored_links_turn* turn;
    int sweep_count;
} colored_links_together;

static void colored_links_share(const void* data, int color, int begin, int end) {
    const colored_links_part* part = data;
    part->solve_runs(&part->task, color, begin, end);
}
static void colored_links_member(plii_team* team, int member, void* data) {
    const colored_links_together* together = data;
    plii_link_shares shares;
    plii_link_shares_find(together->part->state->colors, team, member, &shares);
    plii_link_shares_turn(&shares, colored_links_take, together->turn);
    for (int i = 0; i < together->sweep_count; ++i) {
        plii_link_shares_sweep(&shares, colored_links_share, together->part);
    }
    plii_team_meet(team, member, shares.member_count, ++shares.steps);
    colored_links_give(shares.first_node, shares.end_node, together->turn);
}
static bool colored_links_sweep_together(const colored_links_part* whole, int count) {
    pli_body* body = whole->task.body;
    const plii_node_shares* shares = &whole->state->colors->shares;
    colored_links_part part = *whole;
    part.task.planes = plii_planes_at(body->velocities, body->node_count, shares);
    colored_links_turn turn = {body, &part.task.planes};
    colored_links_together together = {&part, &turn, count};
    return plii_team_run(body->context, shares->count, colored_links_member, &together);
}

static bool colored_links_iterate_runs(pli_body* body, void* data) {
    const colored_links_state* state = data;
    const int count = body->solver.position_iterations;
    if (!plii_solver_has_only_links(body)) { return false; }
    const plii_planes planes = plii_planes_at(body->velocities, body->node_count, NULL);
    colored_links_turn turn = {body, &planes};
    colored_links_part part = {
        .state = state,
        .solve_runs = state->in_planes,
        .task = {body, state->colors, state->rest_squared.values, state->inverse_stiffnesses, planes}};
    if (colored_links_sweep_together(&part, count)) { return true; }
    plii_parallel_for(body->context, colored_links_take, &turn, body->node_count, COLORED_LINKS_TURN_GRAIN);
    if (colored_links_has_bands(&part)) {
        colored_links_sweep_bands(&part, count);
    } else {
        for (int i = 0; i < count; ++i) {
            colored_links_sweep_runs(&part);
        }
    }
    plii_parallel_for(body->context, colored_links_give, &turn, body->node_count, COLORED_LINKS_TURN_GRAIN);
    return true;
}

static void colored_links_prepare(pli_body* body, void* state, const plii_step* step) {
    (void)step;
    if (body->sweep_links == colored_links_sweep) { colored_links_refresh(body, state); }
}

// ------------------------------------------------------------------------------------------------------------ bands

/* A grid that is larger than the second cache would be read once per colour. Instead each colour of runs goes as far as
   the nodes of a band, less than the colour before by the widest group, so that no group comes before one of an earlier
   colour that shares a node with it: the bits are those of colour after colour. A band is as wide as all colours are
   behind, so sweeps may follow each other one band behind, as many as have their bands in the cache. */

typedef struct colored_links_extent {
    int low, high; /* nodes */
} colored_links_extent;

static colored_links_extent colored_links_run_extent(const plii_link_run* run, int group) {
    const int low = plii_link_run_node(run, group);
    const int way = plii_link_run_way(run->offset, run->step, PLII_LINK_LANES - 1);
    return (colored_links_extent){low, low + way + run->offset};
}

/* Widest group, and how much further the end of a row, which comes with it, may go; INT_MAX when the groups of some
   colour are not in the order of their last nodes. */
static int colored_links_reach(const plii_link_runs* runs) {
    int reach = 0;
    for (int c = 0; c < runs->color_count; ++c) {
        const plii_link_run_color* color = &runs->colors[c];
        int last = -1;
        for (const plii_link_run* run = runs->runs + color[0].first_run; run < runs->runs + color[1].first_run; ++run) {
            for (int g = 0; g < run->group_count; ++g) {
                const colored_links_extent extent = colored_links_run_extent(run, g);
                if (extent.high < last) { return INT_MAX; }
                last = extent.high;
                reach = extent.high - extent.low > reach ? extent.high - extent.low : reach;
            }
        }
    }
    return reach + 1 + 2 * PLII_LINK_LANES;
}

/* Of one colour, in all bands. */
static void colored_links_cut_color(colored_links_state* state, int color, int reach) {
    const plii_link_runs* runs = &state->colors->runs;
    const plii_link_run_color* own = &runs->colors[color];
    int cut = 0, run = own->first_run, group = 0;
    for (int b = 0; b < state->band_count; ++b) {
        const int end = state->band_size * (b + 1) - color * reach;
        while (run < own[1].first_run && colored_links_run_extent(&runs->runs[run], group).high < end) {
            ++cut;
            if (++group == runs->runs[run].group_count) {
                ++run;
                group = 0;
            }
        }
        state->cuts[(ptrdiff_t)b * runs->color_count + color] = cut;
    }
}

/* Leaves a body without bands that is small, whose groups are too wide, or for which there is no memory. */
static void colored_links_make_bands(const pli_body* body, colored_links_state* state) {
    const plii_link_runs* runs = &state->colors->runs;
    if (body->node_count < COLORED_LINKS_BANDS_NODES || runs->color_count == 0) { return; }
    const int reach = colored_links_reach(runs);
    if ((int64_t)reach * runs->color_count > COLORED_LINKS_WIDEST_SKEW) { return; }
    const int skew = reach * runs->color_count;
    const int band_size = skew > COLORED_LINKS_BAND ? skew : COLORED_LINKS_BAND;
    const int band_count = (body->node_count + skew) / band_size + 1;
    state->cuts_size = (size_t)band_count * (size_t)runs->color_count * sizeof *state->cuts;
    state->cuts = plii_allocate(body->context, state->cuts_size);
    if (state->cuts == NULL) { return; }
    state->band_count = band_count;
    state->band_size = band_size;
    const int64_t body_bytes =
        (int64_t)body->node_count * (int)sizeof(pli_vec4) + (int64_t)body->link_count * (int)sizeof(float);
    const int64_t band_bytes = body_bytes * band_size / body->node_count;
    state->sweeps_at_once = (int)(COLORED_LINKS_CACHE / band_bytes);
    if (state->sweeps_at_once < 1) { state->sweeps_at_once = 1; }
    for (int c = 0; c < runs->color_count; ++c) {
        colored_links_cut_color(state, c, reach);
    }
}

static void colored_links_release_bands(const pli_body* body, colored_links_state* state) {
    plii_release(body->context, state->cuts, state->cuts_size);
    state->cuts = NULL;
    state->band_count = 0;
}

// ------------------------------------------------------------------------------------------------------ the feature

static size_t colored_links_stiffness_size(const pli_body* body) {
    return (size_t)body->material_count * sizeof(float);
}
/* A body of few links, whose colours would not fill the lanes, or of some that all meet stays with the ordered sweep:
   along a chain that comes further per sweep than colours do. */
static void colored_links_choose_sweep(pli_body* body, colored_links_state* state) {
    const plii_link_colors* colors = state->colors;
    const int64_t row_count = (int64_t)colors->runs.group_count + colors->row_count + colors->serial_count;
    const bool is_worthwhile =
        body->link_count >= COLORED_LINKS_FEWEST && body->link_count >= COLORED_LINKS_LEAST * row_count;
    body->sweep_links = is_worthwhile ? colored_links_sweep : plii_links_sweep;
    body->iterate_links = NULL;
    if (is_worthwhile && plii_link_colors_have_only_runs(colors)) { body->iterate_links = colored_links_iterate_runs; }
    body->sweep_links_state = state;
    state->is_stale = true;
}

static void colored_links_release(const pli_body* body, colored_links_state* state) {
    colored_links_release_bands(body, state);
    plii_link_slots_release(body, &state->rest_squared);
    plii_release(body->context, state->inverse_stiffnesses, colored_links_stiffness_size(body));
}

static pli_status colored_links_enable(pli_body* body, void* data) {
    colored_links_state* state = data;
    state->colors = plii_feature_state(body, &plii_link_colors_class);
    state->kernel = colored_links_kernel(body->context->simd);
    state->in_planes = colored_links_in_planes(body->context->simd);
    state->inverse_stiffnesses = plii_allocate(body->context, colored_links_stiffness_size(body));
    if (!plii_link_slots_make(body, state->colors, &state->rest_squared) || state->inverse_stiffnesses == NULL) {
        colored_links_release(body, state);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    colored_links_make_bands(body, state);
    colored_links_choose_sweep(body, state);
    return PLI_OK;
}

static void colored_links_disable(pli_body* body, void* data) {
    colored_links_release(body, data);
    body->sweep_links = plii_links_sweep;
    body->iterate_links = NULL;
    body->sweep_links_state = NULL;
}

static size_t colored_links_bytes(const pli_body* body, const void* data) {
    const colored_links_state* state = data;
    const size_t cuts_size = state->cuts != NULL ? state->cuts_size : 0;
    return state->rest_squared.size + colored_links_stiffness_size(body) + cuts_size;
}

static int colored_links_topology_blocks(const pli_body* body, const void* data, const plii_topology_change* change,
                                         size_t* sizes) {
    (void)data;
    sizes[0] = plii_link_slots_max_size(body, change->link_count);
    return 1;
}

static void colored_links_topology_commit(pli_body* body, void* data, const plii_topology_change* change,
                                          void** blocks) {
    colored_links_state* state = data;
    plii_link_slots_replace(body, state->colors, change->link_count, blocks[0], &state->rest_squared);
    colored_links_release_bands(body, state); /* the colours are others now */
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
