/* XPBD: volume inside the faces, C = volume - pressure ratio * rest volume; one constraint on all their nodes. */

#include "math/simd_float4.h"
#include "solver/xpbd/xpbd_impl.h"

typedef struct xpbd_volume_state {
    pli_xpbd_volume_def def;
    double rest_volume; /* m^3 */
    float multiplier;
    float gas; /* N m */
    bool is_closed;
    pli_vec4 spin;       /* see xpbd_volume_keep_spin */
    pli_vec4* gradients; /* [node_count] m^2, times six */
} xpbd_volume_state;

/* Nodes are taken relative to node 0 at the start of the substep, which keeps rounding small far from the
   origin; on a closed surface that changes nothing. There the sum of (b - a) x (c - a) over the faces around a node is
   six times its gradient too, so the cross product of a face serves all its nodes. Of a surface with holes, as after a
   cut, it is the volume of the tetrahedra between node 0, where it is now, and the faces: their gradients sum up to
   nothing, so that nothing is moved or turned as a whole. */

enum { XPBD_VOLUME_FACES = 16 }; /* whose volume is added up in single precision */

typedef struct xpbd_volume_nodes {
    const pli_vec4 *positions, *displacements;
    plii_float4 origin, apex; /* the second as a displacement */
} xpbd_volume_nodes;

PLII_SIMD_INLINE plii_float4 xpbd_volume_corner(const xpbd_volume_nodes* nodes, int node) {
    const plii_float4 displacement = plii_float4_from(&nodes->displacements[node]) - nodes->apex;
    return plii_float4_from(&nodes->positions[node]) - nodes->origin + displacement;
}
PLII_SIMD_INLINE void xpbd_volume_add(pli_vec4* sum, plii_float4 cross) {
    plii_float4_to(sum, plii_float4_from(sum) + plii_lanes_xyz(cross));
}

/* Returns the volume, m^3, and makes `gradients` six times what they are. */
PLII_SIMD_INLINE double xpbd_volume_gather(const pli_body* body, pli_vec4* restrict gradients,
                                           const plii_substep* substep, bool is_closed) {
    const int(*restrict faces)[3] = (const int(*)[3])body->topology->faces;
    const int count = body->topology->face_count;
    const plii_float4 first = plii_float4_from(&substep->displacements[0]);
    const xpbd_volume_nodes nodes = {body->positions, substep->displacements, plii_float4_from(&body->positions[0]),
                                     is_closed ? plii_float4_all(0.0f) : first};
    plii_float4 all = plii_float4_all(0.0f);
    memset(gradients, 0, (size_t)body->node_count * sizeof *gradients);
    double sum = 0.0;
    for (int begin = 0; begin < count; begin += XPBD_VOLUME_FACES) {
        const int end = count - begin < XPBD_VOLUME_FACES ? count : begin + XPBD_VOLUME_FACES;
        plii_float4 part = plii_float4_all(0.0f);
        for (int i = begin; i < end; ++i) {
            const int* n = faces[i];
            const plii_float4 a = xpbd_volume_corner(&nodes, n[0]), b = xpbd_volume_corner(&nodes, n[1]),
                              c = xpbd_volume_corner(&nodes, n[2]), cross = plii_lanes_cross(b - a, c - a);
            const plii_float4 by_a = is_closed ? cross : plii_lanes_cross(b, c);
            xpbd_volume_add(&gradients[n[0]], by_a);
            xpbd_volume_add(&gradients[n[1]], is_closed ? cross : plii_lanes_cross(c, a));
            xpbd_volume_add(&gradients[n[2]], is_closed ? cross : plii_lanes_cross(a, b));
            all += cross;
            part += a * plii_lanes_xyz(by_a);
        }
        sum += (double)plii_lanes_sum(part);
    }
    if (!is_closed) { xpbd_volume_add(&gradients[0], -all); }
    return sum / 6.0;
}

/* Sum of w |gradient|^2. */
static float xpbd_volume_weight(const pli_vec4* displacements, const pli_vec4* gradients, int count) {
    plii_float4 sum = plii_float4_all(0.0f);
    for (int i = 0; i < count; ++i) {
        const plii_float4 gradient = plii_float4_from(&gradients[i]);
        const plii_float4 inverse_mass = plii_lanes_all_w(plii_float4_from(&displacements[i]));
        sum += gradient * gradient * inverse_mass;
    }
    return plii_lanes_sum(sum) / 36.0f;
}

/* The gas wants compliance * coefficient / volume more than the constraint: by that C grows, and its gradient. */
static double xpbd_volume_add_gas(const pli_body* body, const xpbd_volume_state* state, const plii_substep* substep,
                                  double volume, double missing, float* weight) {
    const double least = 1e-3 * fabs(state->rest_volume), used = fmax(fabs(volume), least);
    const double more = (double)state->gas * (double)state->def.compliance / used;
    const double share = (double)(substep->dt * body->step.inverse_dt);
    const double alpha = (double)(state->def.compliance * substep->inverse_dt * substep->inverse_dt);
    const double most = (double)PLII_MAX_VOLUME_CHANGE * used * share * share * (1.0 + alpha / (double)*weight);
    *weight *= (float)(1.0 + fmax(more, 0.0) / used);
    return more > 0.0 ? fmax(missing - more, fmin(missing, -most)) : fmin(missing - more, fmax(missing, most));
}

/* A volume that the links do not allow is pushed out and drawn in again by each sweep. All keep the angular momentum
   about where nodes are then, which is not where they end up: a free body would turn faster and faster. So it is turned
   by what its angular momentum (about node 0, times the time of the substep) has changed from before this sweep to
   after the links. Where a node is pinned nothing is finite. */
static void xpbd_volume_keep_spin(pli_body* body, xpbd_volume_state* state, const plii_substep* substep,
                                  bool is_before_sweep) {
    if (state->def.pressure_ratio == 1.0f && state->gas == 0.0f) { return; }
    const xpbd_volume_nodes start = {body->positions, substep->start_displacements,
                                     plii_float4_from(&body->positions[0]), plii_float4_all(0.0f)};
    plii_float4 mass = start.apex, centre = mass, spin = mass, rows[3] = {mass, mass, mass};
    for (int i = 0; i < body->node_count; ++i) {
        const plii_float4 moved = plii_float4_from(&substep->displacements[i]), own = 1.0f / plii_lanes_all_w(moved);
        const plii_float4 arm = xpbd_volume_corner(&start, i), heavy = arm * own;
        mass += own;
        centre += heavy;
        spin += plii_lanes_cross(heavy, moved);
        rows[0] -= heavy * plii_lanes_all_x(arm);
        rows[1] -= heavy * plii_lanes_all_y(arm);
        rows[2] -= heavy * plii_lanes_all_z(arm);
    }
    const plii_float4 mean = centre / mass, missing = plii_float4_from(&state->spin) - spin;
    plii_float4_to(&state->spin, spin);
    if (is_before_sweep) { return; }
    const float all = -mass[0],
                size = -(rows[0][0] + rows[1][1] + rows[2][2]) * (1.0f + 1e-5f); /* as in a line it is 0 */
    const pli_mat3 diagonal = plii_mat3_diagonal(all, all, all);
    const pli_mat3 inertia =
        plii_mat3_add((pli_mat3){{plii_lanes_vec3(rows[0]), plii_lanes_vec3(rows[1]), plii_lanes_vec3(rows[2])}},
                      plii_point_response(size, &diagonal, plii_lanes_vec3(mean)));
    const pli_vec3 turn = pli_mat3_mul_vec3(plii_mat3_inverse(inertia), plii_lanes_vec3(missing));
    for (int i = 0; i < body->node_count && plii_vec3_is_finite(turn); ++i) {
        const plii_float4 arm = xpbd_volume_corner(&start, i) - mean;
        xpbd_volume_add(&substep->displacements[i], plii_lanes_cross(plii_lanes_from_vec3(&turn), arm));
    }
}

static void xpbd_volume_after_links(pli_body* body, void* data, const plii_substep* substep) {
    xpbd_volume_keep_spin(body, data, substep, false);
}

static void xpbd_volume_sweep(pli_body* body, void* data, const plii_substep* substep) {
    xpbd_volume_state* state = data;
    xpbd_volume_keep_spin(body, state, substep, true);
    pli_vec4* displacements = substep->displacements;
    const double volume = state->is_closed ? xpbd_volume_gather(body, state->gradients, substep, true)
                                           : xpbd_volume_gather(body, state->gradients, substep, false);
    float weight = xpbd_volume_weight(displacements, state->gradients, body->node_count);
    double missing = volume - (double)state->def.pressure_ratio * state->rest_volume;
    if (state->gas != 0.0f) { missing = xpbd_volume_add_gas(body, state, substep, volume, missing, &weight); }
    const float multiplier = substep->is_first_sweep ? 0.0f : state->multiplier;
    const float change =
        plii_xpbd_multiplier((float)missing, weight, state->def.compliance, 0.0f, 0.0f, multiplier, 0.0f, substep);
    state->multiplier = multiplier + change;
    const plii_float4 scale = plii_float4_all(change / 6.0f);
    for (int i = 0; i < body->node_count; ++i) {
        const plii_float4 displacement = plii_float4_from(&displacements[i]);
        const plii_float4 factor = plii_lanes_all_w(displacement) * scale;
        plii_float4_to(&displacements[i], displacement + plii_float4_from(&state->gradients[i]) * factor);
    }
}

/* The pressure of a gas inside acts with what holds the volume: as a force of its own, which the constraint takes back,
   it would push nodes to and fro by more than a step can integrate. */
static void xpbd_volume_ask_for_gas(pli_body* body, void* data) {
    xpbd_volume_state* state = data;
    state->gas = 0.0f;
    body->gas = &state->gas;
}

static void xpbd_volume_enable(pli_body* body, void* data) {
    ((xpbd_volume_state*)data)->rest_volume = (double)plii_body_volume(body);
}

static void xpbd_volume_build(pli_body* body, void* data) {
    ((xpbd_volume_state*)data)->is_closed = plii_topology_is_closed(body->topology);
}

enum { XPBD_VOLUME_GAS_ORDER = 15, XPBD_VOLUME_ORDER = 30 }; /* before pressure; after tetrahedra, before links */
const plii_feature_class plii_xpbd_volume_class = {
    .name = "XPBD volume",
    .state_size = sizeof(xpbd_volume_state),
    .settings = PLII_LIMITS_AT(offsetof(xpbd_volume_state, def),
                               PLII_FIELD(pli_xpbd_volume_def, compliance, 0, PLI_MAX_COEFFICIENT),
                               PLII_FIELD(pli_xpbd_volume_def, pressure_ratio, 0, PLI_MAX_FACTOR)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_SPAN(xpbd_volume_state, def, rest_volume, PLII_SAVED, "2fud"),
                                    PLII_STATE_OF(xpbd_volume_state, multiplier, PLII_SAVED, "f"),
                                    PLII_STATE_SPAN(xpbd_volume_state, gas, spin, PLII_LEFT, NULL)),
    .arrays = PLII_ARRAYS(PLII_LEFT_PER_NODE(xpbd_volume_state, gradients)),
    .enable = xpbd_volume_enable,
    .build = xpbd_volume_build,
    .stages[PLII_STAGE_FORCES] = {xpbd_volume_ask_for_gas, XPBD_VOLUME_GAS_ORDER},
    .substepped = PLII_SUBSTEPPED(.order = XPBD_VOLUME_ORDER, .is_of_xpbd = true, .sweep = xpbd_volume_sweep,
                                  .after_links = xpbd_volume_after_links),
};

PLII_DEFINE_DEFAULT(pli_xpbd_volume_def, .pressure_ratio = 1.0f)
pli_status pli_body_enable_xpbd_volume(pli_body* body, const pli_xpbd_volume_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_SETTINGS(body, pli_xpbd_volume_def, used, def, plii_xpbd_volume_class);
    PLII_TRY(plii_check_faces(body, "the volume is that inside the faces", __func__));
    return plii_xpbd_enable_kind(body, &plii_xpbd_volume_class, &used, sizeof used, __func__, NULL);
}
PLII_DEFINE_DISABLE(pli_body_disable_xpbd_volume, plii_check_body_idle, plii_xpbd_volume_class)
