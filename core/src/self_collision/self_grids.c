/* Self-collision of nodes by two grids, the second shifted by half a cell (Kang, "Efficient Methods for Cloth Animation
   and Collision Handling"): nodes in one cell are compared after each step. Pairs across walls of both are not seen. */

#include "body/link_graph.h"
#include "body/pipeline.h"
#include "geometry/spatial_hash.h"
#include "self_collision/self_collision_impl.h"

typedef struct self_grids_state {
    pli_self_grids_def def;
    pli_vec3* positions; /* [node_count] where pairs were looked for */
    plii_spatial_hash hash;
    plii_node_pairs pairs;
    pli_self_grids_report report;
} self_grids_state;

static bool self_grids_are_linked(const plii_link_graph* graph, int a, int b) {
    for (int k = graph->begin[a]; k < graph->begin[a + 1]; ++k) {
        if (graph->halves[k].neighbour == b) { return true; }
    }
    return false;
}

/* Both ends move away from the common centre of mass, and lose what brings them nearer to it. */
static void self_grids_part(pli_body* body, const self_grids_state* state, int a, int b) {
    pli_vec4 *x = body->positions, *v = body->velocities;
    const float weight = x[a].w + x[b].w, distance = state->def.distance;
    const pli_vec3 apart = pli_vec3_sub(plii_xyz(x[b]), plii_xyz(x[a]));
    const float squared = pli_vec3_length_squared(apart);
    if (!(squared < distance * distance) || !(weight > 0.0f)) { return; }
    const float length = sqrtf(squared), share_a = x[a].w / weight, share_b = 1.0f - share_a;
    const pli_vec3 n = length > 1e-6f * distance ? plii_vec3_divide(apart, length) : plii_self_direction(a, b);
    const float move = length - 2.0f * state->def.separation * distance;
    plii_add_xyz(&x[a], pli_vec3_scale(n, move * share_a));
    plii_add_xyz(&x[b], pli_vec3_scale(n, -move * share_b));
    const float approach = pli_vec3_dot(pli_vec3_sub(plii_xyz(v[b]), plii_xyz(v[a])), n);
    if (approach < 0.0f) {
        plii_add_xyz(&v[a], pli_vec3_scale(n, approach * share_a));
        plii_add_xyz(&v[b], pli_vec3_scale(n, -approach * share_b));
    }
}

/* `seen`: the grid before, whose pairs are done, or NULL. */
static void self_grids_part_near(pli_body* body, self_grids_state* state, int node, const plii_spatial_hash* seen) {
    const plii_link_graph* graph = plii_feature_state(body, &plii_link_graph_class);
    plii_node_pairs* pairs = &state->pairs;
    pairs->count = 0;
    plii_spatial_hash_find_in_cell(body->context, &state->hash, node, state->positions[node], state->def.distance,
                                   pairs);
    for (int k = 0; k < pairs->count; ++k) {
        const int other = pairs->pairs[k].other;
        if (self_grids_are_linked(graph, node, other)) { continue; }
        if (seen != NULL && plii_spatial_hash_same_cell(seen, state->positions[node], state->positions[other])) {
            continue;
        }
        state->report.pairs += 1;
        self_grids_part(body, state, node, other);
    }
}

/* False when there was no memory for the grid. */
static bool self_grids_solve(pli_body* body, self_grids_state* state, float shift, const plii_spatial_hash* seen) {
    const bool is_built = plii_spatial_hash_build(body->context, &state->hash, body->node_count, state->positions,
                                                  state->def.distance, shift);
    state->pairs.is_truncated = !is_built;
    for (int i = 0; i < state->hash.count; ++i) {
        self_grids_part_near(body, state, i, seen);
    }
    state->report.is_truncated = state->report.is_truncated || state->pairs.is_truncated;
    return is_built;
}

static void self_grids_run(pli_body* body, void* data) {
    self_grids_state* state = data;
    plii_body_copy_positions(body, state->positions);
    state->report = (pli_self_grids_report){0};
    if (!self_grids_solve(body, state, 0.0f, NULL)) { return; }
    const plii_spatial_hash first = state->hash; /* its geometry; the tables are built anew */
    (void)self_grids_solve(body, state, 0.5f * first.cell_size, &first);
}

/* Not in Bullet. After clusters and contacts have finished, before self-collision of faces. */
enum { SELF_GRIDS_ORDER = 50 };
const plii_feature_class plii_self_grids_class = {
    .name = "self-collision by two grids",
    .state_size = sizeof(self_grids_state),
    .settings = PLII_LIMITS_AT(offsetof(self_grids_state, def),
                               PLII_FIELD(pli_self_grids_def, distance, PLII_ABOVE_0, PLI_MAX_COORDINATE),
                               PLII_FIELD(pli_self_grids_def, separation, PLII_ABOVE_0, 1)),
    .state_parts = PLII_STATE_PARTS(
        PLII_STATE_OF(self_grids_state, def, PLII_SAVED, "2fu"), PLII_STATE(self_grids_state, hash, PLII_LEFT),
        PLII_STATE(self_grids_state, pairs, PLII_LEFT), PLII_STATE_OF(self_grids_state, report, PLII_SAVED, "iB")),
    .needs = PLII_NEEDS(&plii_link_graph_class),
    .stages = {[PLII_STAGE_FINISH] = {self_grids_run, SELF_GRIDS_ORDER}},
    .arrays = PLII_ARRAYS(PLII_LEFT_PER_NODE(self_grids_state, positions),
                          PLII_SPATIAL_HASH_LISTS(self_grids_state, hash, pairs)),
};

PLII_DEFINE_DEFAULT(pli_self_grids_def, .distance = 0.01f, .separation = 0.5f)
PLII_DEFINE_ENABLE(pli_body_enable_self_grids, plii_check_body_idle, pli_self_grids_def, plii_self_grids_class)
PLII_DEFINE_DISABLE(pli_body_disable_self_grids, plii_check_body_idle, plii_self_grids_class)
PLII_DEFINE_STATE_GET(pli_self_grids_report, pli_body_get_self_grids_report, self_grids_state, plii_self_grids_class,
                      state->report, (pli_self_grids_report){0})
