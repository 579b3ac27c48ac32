/* XPBD: volumes of tetrahedra, C = (x_b - x_a) . ((x_c - x_a) x (x_d - x_a)) / 6 - rest volume, four of a colour at a
   time. The volume is signed, so an inverted tetrahedron turns back. */

#include "math/simd_float4.h"
#include "solver/coloring/constraint_coloring.h"
#include "solver/xpbd/xpbd_impl.h"

enum { XPBD_TETRAS_GRAIN = 64 }; /* groups; some microseconds */
/* As rest volume of a lane without a tetrahedron: no change of its multiplier is finite. */
#define XPBD_NO_TETRA INFINITY

/* Tetrahedra that share no node. Lanes without one have the nodes of the last one and move nothing. */
typedef struct xpbd_tetra_group {
    int nodes[4][PLII_LANES];
    float rest_volumes[PLII_LANES]; /* m^3 */
    float multipliers[PLII_LANES];
} xpbd_tetra_group;

/* Cuts and refinement leave tetrahedra and the indices of their nodes as they are. */
typedef struct xpbd_tetras_state {
    float compliance; /* m^5/N */
    int group_count;
    xpbd_tetra_group* groups;                /* [group_count] by colour */
    int color_begin[PLII_CONSTRAINT_COLORS]; /* groups; those from the last begin on are solved one after the other */
} xpbd_tetras_state;

typedef struct xpbd_tetras_task {
    xpbd_tetra_group* groups;
    const pli_vec4* positions;
    pli_vec4* displacements;
    float alpha;
    bool reads_multipliers; /* else they are 0 */
} xpbd_tetras_task;

/* Of one node of each tetrahedron. */
typedef struct xpbd_tetra_corners {
    plii_vec3x4 positions;
    plii_float4 inverse_masses;
} xpbd_tetra_corners;

/* Relative to the first corners' positions: far from the origin sums of position and displacement are coarse. */
PLII_SIMD_INLINE xpbd_tetra_corners xpbd_tetras_load(const xpbd_tetras_task* task, const int* nodes,
                                                     const int* first_nodes) {
    plii_float4 moved[PLII_LANES], sums[PLII_LANES];
    PLII_UNROLL(4)
    for (int k = 0; k < PLII_LANES; ++k) {
        moved[k] = plii_float4_from(&task->displacements[nodes[k]]);
        sums[k] = moved[k];
        if (nodes == first_nodes) { continue; }
        sums[k] += plii_float4_from(&task->positions[nodes[k]]) - plii_float4_from(&task->positions[first_nodes[k]]);
    }
    plii_float4_transpose(sums);
    plii_float4_transpose(moved);
    return (xpbd_tetra_corners){{sums[0], sums[1], sums[2]}, moved[3]};
}

PLII_SIMD_INLINE void xpbd_tetras_move(const xpbd_tetras_task* task, const int* nodes, plii_vec3x4 gradient,
                                       plii_float4 scale) {
    const plii_vec3x4 move = plii_vec3x4_scale(gradient, scale);
    plii_float4 rows[PLII_LANES] = {move.x, move.y, move.z, plii_float4_all(0.0f)};
    plii_float4_transpose(rows);
    PLII_UNROLL(4)
    for (int k = 0; k < PLII_LANES; ++k) {
        pli_vec4* displacement = &task->displacements[nodes[k]];
        plii_float4_to(displacement, plii_float4_from(displacement) + rows[k]);
    }
}

PLII_SIMD_INLINE plii_float4 xpbd_tetras_weight(plii_float4 inverse_masses, plii_vec3x4 gradient) {
    return inverse_masses * plii_vec3x4_dot(gradient, gradient);
}

static void xpbd_tetras_solve(xpbd_tetra_group* group, const xpbd_tetras_task* task) {
    const int* first = group->nodes[0];
    const xpbd_tetra_corners a = xpbd_tetras_load(task, first, first);
    const xpbd_tetra_corners b = xpbd_tetras_load(task, group->nodes[1], first);
    const xpbd_tetra_corners c = xpbd_tetras_load(task, group->nodes[2], first);
    const xpbd_tetra_corners d = xpbd_tetras_load(task, group->nodes[3], first);
    const plii_vec3x4 ab = plii_vec3x4_sub(b.positions, a.positions);
    const plii_vec3x4 ac = plii_vec3x4_sub(c.positions, a.positions);
    const plii_vec3x4 ad = plii_vec3x4_sub(d.positions, a.positions);
    const plii_float4 sixth = plii_float4_all(1.0f / 6.0f), zero = plii_float4_all(0.0f);
    /* Six times the gradients. */
    const plii_vec3x4 by_b = plii_vec3x4_cross(ac, ad);
    const plii_vec3x4 by_c = plii_vec3x4_cross(ad, ab);
    const plii_vec3x4 by_d = plii_vec3x4_cross(ab, ac);
    const plii_vec3x4 by_a = plii_vec3x4_neg(plii_vec3x4_add(plii_vec3x4_add(by_b, by_c), by_d));
    plii_float4 weight = xpbd_tetras_weight(a.inverse_masses, by_a);
    weight += xpbd_tetras_weight(b.inverse_masses, by_b);
    weight += xpbd_tetras_weight(c.inverse_masses, by_c);
    weight += xpbd_tetras_weight(d.inverse_masses, by_d);
    weight *= plii_float4_all(1.0f / 36.0f);
    /* plii_xpbd_multiplier without damping */
    const plii_float4 multipliers = task->reads_multipliers ? plii_float4_load(group->multipliers) : zero;
    const plii_float4 excess = plii_vec3x4_dot(ab, by_b) * sixth - plii_float4_load(group->rest_volumes);
    plii_float4 change = (-excess - task->alpha * multipliers) / (weight + task->alpha);
    change = plii_lanes_select((weight > zero) & plii_lanes_finite(change), change, zero);
    plii_float4_store(group->multipliers, multipliers + change);
    change *= sixth;
    xpbd_tetras_move(task, group->nodes[0], by_a, a.inverse_masses * change);
    xpbd_tetras_move(task, group->nodes[1], by_b, b.inverse_masses * change);
    xpbd_tetras_move(task, group->nodes[2], by_c, c.inverse_masses * change);
    xpbd_tetras_move(task, group->nodes[3], by_d, d.inverse_masses * change);
}

static void xpbd_tetras_range(int begin, int end, void* data) {
    const xpbd_tetras_task* task = data;
    for (int i = begin; i < end; ++i) {
        xpbd_tetras_solve(&task->groups[i], task);
    }
}

static void xpbd_tetras_solve_all(pli_body* body, const xpbd_tetras_state* state, const plii_substep* substep) {
    xpbd_tetras_task task = {.positions = body->positions,
                             .displacements = substep->displacements,
                             .alpha = state->compliance * substep->inverse_dt * substep->inverse_dt,
                             .reads_multipliers = !substep->is_first_sweep};
    for (int c = 0; c + 1 < PLII_CONSTRAINT_COLORS; ++c) {
        task.groups = state->groups + state->color_begin[c];
        plii_parallel_for(body->context, xpbd_tetras_range, &task, state->color_begin[c + 1] - state->color_begin[c],
                          XPBD_TETRAS_GRAIN);
    }
    task.groups = state->groups;
    xpbd_tetras_range(state->color_begin[PLII_CONSTRAINT_COLORS - 1], state->group_count, &task);
}

/* After damped links, which would take what volumes have just corrected for motion: both would throw each other on. */
static void xpbd_tetras_sweep(pli_body* body, void* data, const plii_substep* substep) {
    if (!body->damps_links) { xpbd_tetras_solve_all(body, data, substep); }
}
static void xpbd_tetras_after_links(pli_body* body, void* data, const plii_substep* substep) {
    if (body->damps_links) { xpbd_tetras_solve_all(body, data, substep); }
}

static float xpbd_tetra_volume(const pli_body* body, const int* nodes) {
    const pli_vec3 a = plii_xyz(body->positions[nodes[0]]);
    const pli_vec3 b = pli_vec3_sub(plii_xyz(body->positions[nodes[1]]), a);
    const pli_vec3 c = pli_vec3_sub(plii_xyz(body->positions[nodes[2]]), a);
    const pli_vec3 d = pli_vec3_sub(plii_xyz(body->positions[nodes[3]]), a);
    return pli_vec3_dot(b, plii_vec3_divide(pli_vec3_cross(c, d), 6.0f));
}

/* Tetrahedra of the last colour may share nodes. */
static int xpbd_tetras_group_size(int color) {
    return color + 1 < PLII_CONSTRAINT_COLORS ? PLII_LANES : 1;
}

static void xpbd_tetras_count_groups(xpbd_tetras_state* state, int count, const uint8_t* colors) {
    int counts[PLII_CONSTRAINT_COLORS] = {0};
    for (int i = 0; i < count; ++i) {
        counts[colors[i]] += 1;
    }
    for (int c = 0; c < PLII_CONSTRAINT_COLORS; ++c) {
        const int size = xpbd_tetras_group_size(c);
        state->color_begin[c] = state->group_count;
        state->group_count += (counts[c] + size - 1) / size;
    }
}

static void xpbd_tetras_fill_groups(const pli_body* body, xpbd_tetras_state* state, const uint8_t* colors,
                                    const int* order) {
    const plii_topology* topology = body->topology;
    int first = 0;
    for (int g = 0; g < state->group_count; ++g) {
        const int color = colors[order[first]];
        int count = 1;
        while (count < xpbd_tetras_group_size(color) && first + count < topology->tetra_count &&
               colors[order[first + count]] == color) {
            ++count;
        }
        for (int lane = 0; lane < PLII_LANES; ++lane) {
            const int* nodes = topology->tetras[order[first + (lane < count ? lane : count - 1)]];
            for (int k = 0; k < 4; ++k) {
                state->groups[g].nodes[k][lane] = nodes[k];
            }
            state->groups[g].rest_volumes[lane] = lane < count ? xpbd_tetra_volume(body, nodes) : XPBD_NO_TETRA;
        }
        first += count;
    }
}

static void xpbd_tetras_enable(pli_body* body, void* data) {
    xpbd_tetras_state* state = data;
    const plii_topology* topology = body->topology;
    plii_scratch scratch = {.context = body->context};
    uint64_t* masks = PLII_TAKE(&scratch, uint64_t, body->node_count);
    uint8_t* colors = PLII_TAKE(&scratch, uint8_t, topology->tetra_count);
    int* order = PLII_TAKE(&scratch, int, topology->tetra_count);
    if (!scratch.is_short) {
        plii_constraint_order(topology->tetra_count, (const int(*)[4])topology->tetras, masks, colors, order);
        xpbd_tetras_count_groups(state, topology->tetra_count, colors);
        if (PLII_ALLOCATE(body->context, &state->groups, state->group_count)) {
            xpbd_tetras_fill_groups(body, state, colors, order);
        }
    }
    plii_scratch_free(&scratch);
}

enum { XPBD_TETRAS_ORDER = 20 }; /* before volume and links that are not damped */
const plii_feature_class plii_xpbd_tetras_class = {
    .name = "XPBD tetrahedra",
    .state_size = sizeof(xpbd_tetras_state),
    .settings = PLII_LIMITS_AT(0, PLII_FIELD(xpbd_tetras_state, compliance, 0, PLI_MAX_COEFFICIENT)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(xpbd_tetras_state, compliance, PLII_SAVED, "f"),
                                    PLII_STATE(xpbd_tetras_state, color_begin, PLII_LEFT)),
    .arrays =
        PLII_ARRAYS({PLII_LIST_OF(xpbd_tetras_state, groups, group_count), .is_kept = true, PLII_FILED_AS("16n8f")}),
    .enable = xpbd_tetras_enable,
    .substepped = PLII_SUBSTEPPED(.order = XPBD_TETRAS_ORDER, .is_of_xpbd = true, .sweep = xpbd_tetras_sweep,
                                  .after_links = xpbd_tetras_after_links),
};

pli_status pli_body_enable_xpbd_tetras(pli_body* body, float compliance) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(plii_check_limits(body->context, &compliance, &plii_xpbd_tetras_class.settings, __func__));
    PLII_FAIL_IF(body->topology->tetra_count == 0, body->context, PLI_ERROR_INVALID_MESH, __func__,
                 "the body has no tetrahedra");
    return plii_xpbd_enable_kind(body, &plii_xpbd_tetras_class, &compliance, sizeof compliance, __func__, NULL);
}
PLII_DEFINE_DISABLE(pli_body_disable_xpbd_tetras, plii_check_body_idle, plii_xpbd_tetras_class)
