/* Tethers: an upper limit to the distance of each node from its origin, the node that is nearest along the links of
   those that are pinned or anchored to a rigid body that nothing moves. After Kim, Chentanez, Mueller, "Long Range
   Attachments", with one tether per node, and with rigid bodies at the anchors of nodes: a light node cannot hold back
   a heavy body. */

#include "pliant/tether.h"
#include "body/all_features.h"
#include "body/body_impl.h"
#include "body/node_constraint.h"
#include "body/pipeline.h"
#include "body/substep_rigid.h"
#include "body/world_state.h"
#include "math/definition.h"

/* m/s: what is too far away at the start comes back at this speed, lest it shoots past. */
#define TETHER_RECOVERY_SPEED 1.0f

/* A rigid body at the end of a tether. */
typedef struct tether_load {
    int node;
    pli_vec3 goal; /* at the start of the step */
    plii_substep_rigid_pivot pivot;
    float limit; /* m, in this substep */
} tether_load;

/* An anchored node that tethers start from. */
typedef struct tether_origin {
    int node;
    bool is_led; /* from `start` to `end` in this step */
    pli_vec3 start, end;
} tether_origin;

typedef struct tether_state {
    pli_tethers_def def;
    pli_tether* tethers; /* [node_count] */
    uint32_t link_revision;
    plii_node_constraint* constraints;
    int constraint_count, constraint_capacity;
    tether_origin* origins;
    int origin_count, origin_capacity;
    tether_load* loads;
    int load_count, load_capacity;
} tether_state;

// ------------------------------------------------------------------------------------------------------- measuring

static bool tether_shorten(pli_tether* far, const pli_tether* near, float length) {
    if (near->origin == PLI_NULL_INDEX || !(near->length + length < far->length)) { return false; }
    *far = (pli_tether){near->origin, near->length + length};
    return true;
}

/* Relaxes all links, forth and back by turns, until nothing changes: a few times for the orders that generators make.
 */
static void tether_measure(const pli_body* body, tether_state* state) {
    pli_tether* tethers = state->tethers;
    for (int i = 0; i < body->node_count; ++i) {
        const bool is_pinned = !(body->positions[i].w > 0.0f);
        tethers[i] = (pli_tether){is_pinned ? i : PLI_NULL_INDEX, is_pinned ? 0.0f : INFINITY};
    }
    for (int i = 0; i < state->origin_count; ++i) {
        const int node = state->origins[i].node;
        tethers[node] = (pli_tether){node, 0.0f};
    }
    bool has_changed = true;
    for (int pass = 0; has_changed && pass <= body->node_count; ++pass) {
        has_changed = false;
        for (int k = 0; k < body->link_count; ++k) {
            const int index = pass % 2 == 0 ? k : body->link_count - 1 - k;
            if (body->link_tags != NULL && (body->link_tags[index] & PLII_LINK_TAG_BENDING) != 0) { continue; }
            const plii_link* link = &body->links[index];
            pli_tether *a = &tethers[link->nodes[0]], *b = &tethers[link->nodes[1]];
            const float length = sqrtf(link->rest_length_squared);
            const bool is_shorter = tether_shorten(a, b, length) || tether_shorten(b, a, length);
            has_changed = has_changed || is_shorter;
        }
    }
    state->link_revision = body->link_revision;
}

/* NULL unless the node is held. */
static const pli_tether* tether_of(const pli_body* body, const tether_state* state, int node) {
    const pli_tether* tether = &state->tethers[node];
    const bool is_held = tether->origin != PLI_NULL_INDEX && tether->origin != node && body->positions[node].w > 0.0f;
    return is_held ? tether : NULL;
}

/* m, at the end of a step that started at that distance. */
static float tether_limit(const tether_state* state, const pli_tether* tether, float start, float dt) {
    return plii_max(tether->length * (1.0f + state->def.slack), start - TETHER_RECOVERY_SPEED * dt);
}

// -------------------------------------------------------------------------------------------------------- anchors

static void tether_list_constraints(pli_body* body, tether_state* state) {
    state->constraint_count = 0;
    if (body->anchored == NULL) { return; }
    for (int i = 0; i < body->pipeline.feature_count; ++i) {
        const plii_feature* feature = &body->pipeline.features[i];
        if (feature->klass->list_constraints == NULL) { continue; }
        const int found = feature->klass->list_constraints(body, feature->state, 0, NULL),
                  count = state->constraint_count;
        if (found == 0) { continue; }
        if (!PLII_RESERVE(body->context, &state->constraints, &state->constraint_capacity, count + found)) { return; }
        feature->klass->list_constraints(body, feature->state, found, state->constraints + count);
        state->constraint_count += found;
    }
}

/* True when they are other nodes than before. */
static bool tether_gather_origins(pli_body* body, tether_state* state) {
    const int before = state->origin_count;
    bool has_changed = false;
    state->origin_count = 0;
    for (int i = 0; i < state->constraint_count; ++i) {
        const plii_node_constraint* constraint = &state->constraints[i];
        if (!constraint->is_anchor || constraint->rigid->state.inverse_mass > 0.0f) { continue; }
        const int place = state->origin_count;
        if (!PLII_RESERVE(body->context, &state->origins, &state->origin_capacity, place + 1)) { break; }
        tether_origin* origin = &state->origins[state->origin_count++];
        has_changed = has_changed || place >= before || origin->node != constraint->node;
        *origin = (tether_origin){constraint->node, constraint->leads && body->positions[constraint->node].w > 0.0f,
                                  constraint->start, constraint->end};
    }
    return has_changed || state->origin_count != before;
}

/* Where memory fails some are left out. */
static void tether_gather_loads(pli_body* body, tether_state* state) {
    state->load_count = 0;
    for (int i = 0; i < state->constraint_count; ++i) {
        const plii_node_constraint* constraint = &state->constraints[i];
        if (!constraint->is_anchor || !(constraint->rigid->state.inverse_mass > 0.0f) ||
            !tether_of(body, state, constraint->node)) {
            continue;
        }
        if (!PLII_RESERVE(body->context, &state->loads, &state->load_capacity, state->load_count + 1)) { return; }
        const pli_transform pose =
            body->solver_class->has_substeps ? constraint->rigid->path.begin : constraint->rigid->state.pose;
        tether_load* load = &state->loads[state->load_count++];
        *load = (tether_load){.node = constraint->node, .goal = pli_transform_point(pose, constraint->pivot)};
        const pli_vec3 offset = pli_mat3_mul_vec3(pose.rotation, constraint->pivot);
        load->pivot = (plii_substep_rigid_pivot){{constraint->rigid, offset}, offset};
        plii_rigid_touch(constraint->rigid);
        if (body->solver_class->has_substeps) { plii_substep_follow_rigid(body, constraint->rigid); }
    }
}

static void tether_begin(pli_body* body, void* data) {
    tether_state* state = data;
    tether_list_constraints(body, state);
    const bool has_changed = tether_gather_origins(body, state);
    if (has_changed || state->link_revision != body->link_revision) { tether_measure(body, state); }
    tether_gather_loads(body, state);
}

// ---------------------------------------------------------------------------------------- solving, whole steps

/* The rigid body stands at the end of this step already, its velocity is that of the next one. */
static void tether_apply_load(const pli_body* body, const tether_state* state, const tether_load* load) {
    const pli_tether* tether = &state->tethers[load->node];
    const pli_vec3 apart = pli_vec3_sub(load->goal, plii_xyz(body->positions[tether->origin]));
    const float distance = pli_vec3_length(apart);
    if (!(distance > 0.0f)) { return; }
    const pli_vec3 unit = pli_vec3_scale(apart, 1.0f / distance);
    const pli_vec3 relative = pli_vec3_sub(plii_rigid_velocity_at(load->pivot.point.rigid, load->pivot.point.offset),
                                           plii_xyz(body->velocities[tether->origin]));
    const float allowed = (tether_limit(state, tether, distance, body->step.dt) - distance) * body->step.inverse_dt;
    const float excess = pli_vec3_dot(unit, relative) - allowed;
    const float weight = plii_substep_rigid_point_weight(&load->pivot.point, unit);
    if (!(excess > 0.0f) || !(weight > 0.0f) || !plii_is_finite(excess / weight)) { return; }
    plii_rigid_apply_impulse(load->pivot.point.rigid, pli_vec3_scale(unit, -excess / weight), load->pivot.point.offset);
}

static void tether_solve(pli_body* body, void* data) {
    const tether_state* state = data;
    /* Where a solver holds nodes, rigid bodies are in its system, which takes the nodes between for free: were they
       held after it, no force would reach the rigid bodies. */
    if (body->solver_class->solves_constraints && state->load_count > 0) { return; }
    for (int i = 0; i < state->origin_count; ++i) {
        const tether_origin* origin = &state->origins[i];
        if (origin->is_led) { plii_set_xyz(&body->positions[origin->node], origin->end); } /* links have pulled at it */
    }
    for (int i = 0; i < body->node_count; ++i) {
        const pli_tether* tether = tether_of(body, state, i);
        if (tether == NULL) { continue; }
        const pli_vec3 origin = plii_xyz(body->positions[tether->origin]);
        const pli_vec3 apart = pli_vec3_sub(plii_xyz(body->positions[i]), origin);
        const float distance = pli_vec3_length(apart);
        if (!(distance > tether->length * (1.0f + state->def.slack)) || !plii_is_finite(distance)) { continue; }
        const pli_vec3 before = pli_vec3_sub(plii_xyz(body->previous[i]), plii_xyz(body->previous[tether->origin]));
        const float limit = tether_limit(state, tether, pli_vec3_length(before), body->step.dt);
        if (!(distance > limit)) { continue; }
        plii_set_xyz(&body->positions[i], pli_vec3_add(origin, pli_vec3_scale(apart, limit / distance)));
    }
    for (int i = 0; i < state->load_count; ++i) {
        tether_apply_load(body, state, &state->loads[i]);
    }
}

// -------------------------------------------------------------------------------------------- solving, substeps

static pli_vec3 tether_load_position(const tether_load* load) {
    return pli_vec3_add(load->goal, plii_substep_rigid_pivot_moved(&load->pivot));
}

static void tether_restart(pli_body* body, void* data, const plii_substep* substep) {
    const tether_state* state = data;
    for (int i = 0; i < state->load_count; ++i) {
        tether_load* load = &state->loads[i];
        plii_substep_rigid_pivot_turn(&load->pivot);
        const pli_tether* tether = &state->tethers[load->node];
        const int origin = tether->origin;
        const pli_vec3 start = plii_substep_place(body, substep, substep->start_displacements, origin);
        const pli_vec3 apart = pli_vec3_sub(tether_load_position(load), start);
        const float distance = pli_vec3_length(apart);
        load->limit = tether_limit(state, tether, distance, substep->dt);
        if (distance < load->limit) {
            load->limit = distance + plii_substep_braked(load->limit - distance, substep);
        } else { /* comes back by a shift, which leaves no speed */
            const pli_vec3 back = pli_vec3_scale(apart, distance > 0.0f ? load->limit / distance - 1.0f : 0.0f);
            plii_substep_rigid_point_shift(&load->pivot.point, back);
        }
    }
}

static void tether_sweep_node(pli_body* body, const tether_state* state, const pli_tether* tether, int node,
                              const plii_substep* substep) {
    const int origin = tether->origin;
    const pli_vec3 apart =
        pli_vec3_sub(plii_substep_position(body, substep, node), plii_substep_position(body, substep, origin));
    const float distance = pli_vec3_length(apart);
    if (!(distance > tether->length * (1.0f + state->def.slack)) || !plii_is_finite(distance)) { return; }
    const pli_vec3 before =
        pli_vec3_sub(apart, pli_vec3_sub(plii_substep_motion(substep, node), plii_substep_motion(substep, origin)));
    const float limit = tether_limit(state, tether, pli_vec3_length(before), substep->dt);
    if (!(distance > limit)) { return; }
    const float way = (limit - distance) / (distance * substep->displacements[node].w);
    plii_substep_move(substep, node, apart, way);
}

/* To where it is at the end of the substep. */
static void tether_lead_origin(const pli_body* body, const tether_origin* origin, const plii_substep* substep) {
    const float share = (float)(substep->index + 1) * substep->dt * body->step.inverse_dt;
    const pli_vec3 goal = pli_vec3_add(origin->start, pli_vec3_scale(pli_vec3_sub(origin->end, origin->start), share));
    plii_set_xyz(&substep->displacements[origin->node], pli_vec3_sub(goal, plii_xyz(body->positions[origin->node])));
}

static void tether_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const tether_state* state = data;
    for (int i = 0; i < state->origin_count; ++i) {
        if (state->origins[i].is_led) { tether_lead_origin(body, &state->origins[i], substep); }
    }
    for (int i = 0; i < body->node_count; ++i) {
        const pli_tether* tether = tether_of(body, state, i);
        if (tether != NULL) { tether_sweep_node(body, state, tether, i, substep); }
    }
    for (int i = 0; i < state->load_count; ++i) {
        const tether_load* load = &state->loads[i];
        const pli_vec3 place =
            pli_vec3_add(tether_load_position(load), plii_substep_rigid_point_motion(&load->pivot.point, substep));
        const int origin = state->tethers[load->node].origin;
        const pli_vec3 apart = pli_vec3_sub(place, plii_substep_position(body, substep, origin));
        const float distance = pli_vec3_length(apart), excess = distance - load->limit;
        if (!(excess > 0.0f)) { continue; }
        const pli_vec3 unit = pli_vec3_scale(apart, 1.0f / distance);
        const float push = -excess / plii_substep_rigid_point_weight(&load->pivot.point, unit);
        if (!plii_is_finite(push)) { continue; }
        plii_substep_rigid_point_push(&load->pivot.point, pli_vec3_scale(unit, push), substep);
    }
}

/* To the sphere around the pinned node. */
static float tether_room(const pli_body* body, const void* data, const plii_substep* substep, int node,
                         pli_vec3 direction) {
    const tether_state* state = data;
    const pli_tether* tether = tether_of(body, state, node);
    if (tether == NULL) { return INFINITY; }
    const pli_vec3 apart =
        pli_vec3_sub(plii_substep_position(body, substep, node), plii_substep_position(body, substep, tether->origin));
    return plii_sphere_room(apart, tether->length * (1.0f + state->def.slack), direction);
}

// ------------------------------------------------------------------------------------------------------ the feature

static void tether_topology_commit(pli_body* body, void* data, const plii_topology_change* change) {
    tether_state* state = data;
    state->load_count = 0;
    tether_measure(body, state);
}

/* Not in Bullet. After the links, which stretch them; contacts and anchors come after them in substeps and before them
   in iterations. */
enum { TETHER_ORDER = PLII_ORDER_LINKS + 2, TETHER_SUBSTEP_ORDER = 45 };

static const plii_field tether_fields[] = {PLII_FIELD(pli_tethers_def, slack, 0, PLI_MAX_FACTOR)};

const plii_feature_class plii_tether_class = {
    .name = "tethers",
    .state_size = sizeof(tether_state),
    .settings = PLII_LIMITS(tether_state, def, tether_fields),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(tether_state, def, PLII_SAVED, "fu"),
                                    PLII_STATE(tether_state, link_revision, PLII_LEFT)),
    .stages =
        {[PLII_STAGE_PREPARE] = {tether_begin, TETHER_ORDER}, [PLII_STAGE_POSITION] = {tether_solve, TETHER_ORDER}},
    .substepped =
        &(const plii_substep_class){
            .order = TETHER_SUBSTEP_ORDER,
            .klass = &plii_tether_class,
            .begin = tether_begin,
            .restart = tether_restart,
            .sweep = tether_sweep,
            .room = tether_room,
        },
    .arrays = PLII_ARRAYS({PLII_MEMBER(tether_state, tethers), PLII_PER_NODE, PLII_SAVED_AS("Nf")},
                          {PLII_LIST_OF(tether_state, constraints, constraint_capacity),
                           PLII_COUNTED_BY(tether_state, constraint_count), .snapshot = PLII_LEFT},
                          {PLII_LIST_OF(tether_state, origins, origin_capacity),
                           PLII_COUNTED_BY(tether_state, origin_count), PLII_SAVED_AS("nB6f")},
                          {PLII_LIST_OF(tether_state, loads, load_capacity), PLII_COUNTED_BY(tether_state, load_count),
                           .snapshot = PLII_LEFT}),
    .topology_commit = tether_topology_commit,
};

pli_tethers_def pli_tethers_def_default(void) {
    return (pli_tethers_def){.slack = 0.01f, .cookie = PLII_DEF_COOKIE};
}

pli_status pli_body_enable_tethers(pli_body* body, const pli_tethers_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    const pli_tethers_def used = def != NULL ? *def : pli_tethers_def_default();
    PLII_TRY_DEF(body->context, pli_tethers_def, &used, tether_fields, __func__);
    tether_state* state = NULL;
    PLII_TRY(plii_feature_enable(body, &plii_tether_class, (void**)&state));
    state->def = used;
    tether_list_constraints(body, state);
    (void)tether_gather_origins(body, state);
    tether_measure(body, state);
    return PLI_OK;
}

pli_status pli_body_disable_tethers(pli_body* body) {
    return plii_feature_disable_if(plii_check_body_idle(body, __func__), body, &plii_tether_class);
}

pli_tether pli_body_get_tether(const pli_body* body, int node) {
    const pli_tether none = {PLI_NULL_INDEX, 0.0f};
    if (plii_check_node(body, node, __func__) != PLI_OK) { return none; }
    const tether_state* state = plii_feature_state(body, &plii_tether_class);
    if (state == NULL || state->tethers[node].origin == PLI_NULL_INDEX) { return none; }
    return state->tethers[node];
}
