/* Tethers: upper limits to the distances of each node from its origins, which are pinned or anchored to a rigid body
   that nothing moves: the nearest one, and some that are far from each other. After Kim, Chentanez, Mueller, "Long
   Range Attachments", with rigid bodies at the anchors of nodes: a light node cannot hold back a heavy body. Held from
   one side alone, neighbours whose nearest origins differ are drawn apart by what lies on them. */

#include "body/node_constraint.h"
#include "body/pipeline.h"
#include "body/substep_rigid.h"
#include "features/tether_measure.h"
#include "math/simd_float4.h"

/* m/s: what is too far away at the start comes back at this speed, lest it shoots past. */
#define TETHER_RECOVERY_SPEED 1.0f
/* s; in substeps it goes no faster than on a spring with a dashpot. Contacts of a pile push nodes beyond their tethers
   in each, and what took them back at once would make them go to and fro for ever. */
#define TETHER_RECOVERY_TIME 0.01f
/* Stiffness of a tether under solvers that have it as a spring, in that of a link. */
#define TETHER_FIRMNESS 100.0f
/* How far these may give, times the length, before nodes are held after the solution, as in a fast turn. */
#define TETHER_YIELD 1.015f
/* Room that a node has by sliding counts so many times: it is not what stops the rigid body, until little is left. */
#define TETHER_SLIDING 10.0f
#define TETHER_LEAST_SLIDING 0.02f /* m, what nodes under a load at rest have */

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
    bool is_loose; /* on a rigid body that moves */
} tether_origin;

enum { TETHER_LANDMARKS = 8 }; /* of a rectangle its corners and the middles of its sides */

typedef struct tether_state {
    pli_tethers_def def;
    int landmarks[TETHER_LANDMARKS]; /* origins, or PLI_NULL_INDEX */
    uint32_t link_revision;          /* another one: they are to be measured anew */
    bool are_loose;                  /* all origins: no nodes are held, but rigid bodies by that of the first origin */
    float spread;        /* from 1 on: how many times as far as the body is long landmarks are from each other */
    tether_load first;   /* at that origin */
    pli_tether* tethers; /* [node_count] to the nearest origin */
    /* [node_count] m, from each landmark to a node; infinite where it is none, or the nearest origin. */
    float (*far)[TETHER_LANDMARKS];
    plii_node_constraint* constraints;
    int constraint_count, constraint_capacity;
    tether_origin* origins;
    int origin_count, origin_capacity;
    tether_load* loads;
    int load_count, load_capacity;
} tether_state;

// ------------------------------------------------------------------------------------------------------- measuring

/* The origin farthest from all landmarks so far, the first one at the start; PLI_NULL_INDEX: there is no other one. */
static int tether_farthest_origin(const pli_body* body, const tether_state* state, int landmark_count) {
    int farthest = PLI_NULL_INDEX, origin_count = 0;
    float most = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        if (state->tethers[i].origin != i) { continue; }
        ++origin_count;
        float distance = INFINITY;
        for (int k = 0; k < landmark_count; ++k) {
            distance = plii_min(distance, state->far[i][k]);
        }
        if (distance > most) {
            most = distance;
            farthest = i;
        }
    }
    return origin_count > 1 ? farthest : PLI_NULL_INDEX;
}

static void tether_measure_far(tether_state* state, plii_tether_surface* surface, pli_tether* measured) {
    const pli_body* body = surface->body;
    for (int k = 0; k < TETHER_LANDMARKS; ++k) {
        const int landmark = tether_farthest_origin(body, state, k);
        if (landmark == PLI_NULL_INDEX) { break; }
        for (int i = 0; i < body->node_count; ++i) {
            measured[i] = i == landmark ? (pli_tether){i, 0.0f} : (pli_tether){PLI_NULL_INDEX, INFINITY};
        }
        plii_tether_measure(surface, measured);
        for (int i = 0; i < body->node_count; ++i) {
            state->far[i][k] = measured[i].length;
        }
        state->landmarks[k] = landmark;
    }
    for (int i = 0; i < body->node_count; ++i) {
        for (int k = 0; k < TETHER_LANDMARKS; ++k) {
            if (state->tethers[i].origin == state->landmarks[k]) { state->far[i][k] = INFINITY; }
        }
    }
}

/* Each node that is pinned or anchored. */
static void tether_mark_origins(const pli_body* body, tether_state* state) {
    state->are_loose = true;
    for (int i = 0; i < body->node_count; ++i) {
        const bool is_pinned = !(body->positions[i].w > 0.0f);
        state->are_loose = state->are_loose && !is_pinned;
        state->tethers[i] = (pli_tether){is_pinned ? i : PLI_NULL_INDEX, is_pinned ? 0.0f : INFINITY};
        for (int k = 0; k < TETHER_LANDMARKS; ++k) {
            state->far[i][k] = INFINITY;
        }
    }
    for (PLII_EACH(const tether_origin, origin, state->origins, state->origin_count)) {
        state->are_loose = state->are_loose && origin->is_loose;
    }
    for (PLII_EACH(const tether_origin, origin, state->origins, state->are_loose ? 1 : state->origin_count)) {
        if (origin->is_loose && !state->are_loose) { continue; }
        state->tethers[origin->node] = (pli_tether){origin->node, 0.0f};
    }
    for (int k = 0; k < TETHER_LANDMARKS; ++k) {
        state->landmarks[k] = PLI_NULL_INDEX;
    }
}

/* False when out of memory: then nothing is held until the next step, which tries again. */
static bool tether_measure(const pli_body* body, tether_state* state) {
    tether_mark_origins(body, state);
    plii_scratch scratch = {.context = body->context};
    plii_tether_surface surface = plii_tether_surface_create(body, &scratch);
    pli_tether* measured = PLII_TAKE(&scratch, pli_tether, body->node_count);
    if (!scratch.is_short) {
        plii_tether_measure(&surface, state->tethers);
        tether_measure_far(state, &surface, measured);
    }
    plii_scratch_free(&scratch);
    state->link_revision = scratch.is_short ? body->link_revision - 1 : body->link_revision;
    return !scratch.is_short;
}

/* Origins farther apart than the body reaches let it stretch as much, or nodes would be drawn to the other one. */
static float tether_spread(const tether_state* state, const pli_vec3 origins[TETHER_LANDMARKS]) {
    float spread = 1.0f;
    for (int a = 0; a < TETHER_LANDMARKS && state->landmarks[a] != PLI_NULL_INDEX; ++a) {
        for (int b = 0; b < a; ++b) {
            const float length = state->far[state->landmarks[a]][b],
                        distance = pli_vec3_length(pli_vec3_sub(origins[a], origins[b]));
            if (length > 0.0f && distance > length * spread) { spread = distance / length; }
        }
    }
    return spread;
}

/* NULL unless the node is held. */
static const pli_tether* tether_of(const pli_body* body, const tether_state* state, int node) {
    const pli_tether* tether = &state->tethers[node];
    const bool is_held = tether->origin != PLI_NULL_INDEX && tether->origin != node && body->positions[node].w > 0.0f;
    return is_held && !state->are_loose ? tether : NULL;
}

/* m, at the end of a step that started at that distance. */
static float tether_limit(float longest, float start, float dt) {
    return plii_max(longest, start - TETHER_RECOVERY_SPEED * dt);
}

/* From a length at rest to the longest distance. */
static float tether_factor(const tether_state* state) {
    return (1.0f + state->def.slack) * state->spread;
}
static float tether_longest(const tether_state* state, const pli_tether* tether) {
    return tether->length * tether_factor(state);
}

/* Bits of the landmarks that a node is too far from, which are looked at in fours. */
static int tether_too_far(const tether_state* state, const plii_vec3x4* landmarks, int node, pli_vec3 at,
                          float factor) {
    int bits = 0;
    for (int k = 0; k < TETHER_LANDMARKS && state->landmarks[k] != PLI_NULL_INDEX; k += 4) {
        const plii_float4 longest = plii_float4_load(&state->far[node][k]) * factor;
        const plii_vec3x4 apart = plii_vec3x4_sub(plii_vec3x4_all(at), landmarks[k / 4]);
        bits |= plii_lanes_bits(plii_vec3x4_dot(apart, apart) > longest * longest) << k;
    }
    return bits;
}

// -------------------------------------------------------------------------------------------------------- anchors

/* From `start` to `end` in this step. */
static bool tether_is_led(const pli_body* body, const plii_node_constraint* at) {
    return at->is_anchor && at->leads && body->positions[at->node].w > 0.0f;
}

/* Lists what holds nodes, and the origins in it. True when they are other nodes than before. */
static bool tether_gather_origins(pli_body* body, tether_state* state) {
    const int before = state->origin_count;
    bool has_changed = false;
    state->constraint_count = state->origin_count = 0;
    if (body->anchored != NULL) {
        state->constraint_count =
            plii_features_list_constraints(body, 1, &state->constraints, &state->constraint_capacity);
    }
    for (PLII_EACH(const plii_node_constraint, constraint, state->constraints, state->constraint_count)) {
        if (!constraint->is_anchor) { continue; }
        const bool is_loose = constraint->rigid->state.inverse_mass > 0.0f;
        const int place = state->origin_count;
        if (!PLII_RESERVE(body->context, &state->origins, &state->origin_capacity, place + 1)) { break; }
        tether_origin* origin = &state->origins[state->origin_count++];
        has_changed =
            has_changed || place >= before || origin->node != constraint->node || origin->is_loose != is_loose;
        *origin = (tether_origin){constraint->node, is_loose};
    }
    return has_changed || state->origin_count != before;
}

/* Where memory fails some are left out. */
static void tether_gather_loads(pli_body* body, tether_state* state) {
    state->load_count = 0;
    state->first = (tether_load){0};
    for (PLII_EACH(const plii_node_constraint, constraint, state->constraints, state->constraint_count)) {
        if (!constraint->is_anchor || !(constraint->rigid->state.inverse_mass > 0.0f) ||
            (!state->are_loose && !tether_of(body, state, constraint->node))) {
            continue;
        }
        if (!PLII_GROW(body->context, &state->loads, &state->load_capacity, state->load_count)) { return; }
        const pli_transform pose =
            body->solver_class->has_substeps ? constraint->rigid->path.begin : constraint->rigid->state.pose;
        tether_load load = {.node = constraint->node, .goal = pli_transform_point(pose, constraint->pivot)};
        const pli_vec3 offset = pli_mat3_mul_vec3(pose.rotation, constraint->pivot);
        load.pivot = (plii_substep_rigid_pivot){{constraint->rigid, offset}, offset};
        plii_rigid_touch(constraint->rigid);
        if (body->solver_class->has_substeps) { plii_substep_follow_rigid(body, constraint->rigid); }
        if (state->are_loose && state->first.pivot.point.rigid == NULL) {
            state->first = load;
        } else if (state->first.pivot.point.rigid != constraint->rigid) {
            state->loads[state->load_count++] = load;
        }
    }
}

/* Where they are; where there is none any place will do. Sets the spread. */
static void tether_find_landmarks(const pli_body* body, tether_state* state, const plii_substep* substep,
                                  pli_vec3 landmarks[TETHER_LANDMARKS]) {
    for (int k = 0; k < TETHER_LANDMARKS; ++k) {
        const int node = state->landmarks[k];
        landmarks[k] = node != PLI_NULL_INDEX ? plii_substep_position(body, substep, node) : pli_vec3_make(0, 0, 0);
    }
    state->spread = tether_spread(state, landmarks);
}

/* Origins as they are now, and the lengths from them, if anything has changed. False as tether_measure. */
static bool tether_follow_origins(pli_body* body, tether_state* state, bool is_new) {
    const bool has_changed = tether_gather_origins(body, state) || is_new;
    return (!has_changed && state->link_revision == body->link_revision) || tether_measure(body, state);
}

static void tether_begin(pli_body* body, void* data) {
    tether_state* state = data;
    (void)tether_follow_origins(body, state, false);
    pli_vec3 landmarks[TETHER_LANDMARKS];
    const plii_substep step = plii_substep_of_step(body, body->positions, body->previous);
    tether_find_landmarks(body, state, &step, landmarks);
    state->load_count = 0;
    if (!body->solver_class->solves_constraints) { tether_gather_loads(body, state); }
}

static void tether_hold(pli_body* body, int node, int origin, float longest, const plii_substep* substep) {
    const pli_vec3 start = plii_substep_position(body, substep, origin);
    const pli_vec3 apart = pli_vec3_sub(plii_substep_position(body, substep, node), start);
    const float distance = pli_vec3_length(apart);
    if (!(distance > longest) || !plii_is_finite(distance)) { return; }
    const bool is_whole = substep->is_absolute; /* the step */
    const pli_vec3 before = is_whole ? pli_vec3_sub(plii_xyz(body->previous[node]), plii_xyz(body->previous[origin]))
                                     : pli_vec3_sub(apart, pli_vec3_sub(plii_substep_motion(substep, node),
                                                                        plii_substep_motion(substep, origin)));
    const float was = pli_vec3_length(before), dt = substep->dt;
    const float slow = is_whole ? 0.0f : TETHER_RECOVERY_TIME / (dt + TETHER_RECOVERY_TIME);
    const float limit = plii_max(tether_limit(longest, was, dt), longest + (was - longest) * slow);
    if (!(distance > limit)) { return; }
    if (is_whole) {
        plii_set_xyz(&body->positions[node], pli_vec3_add(start, pli_vec3_scale(apart, limit / distance)));
    } else {
        plii_substep_move(substep, node, apart, (limit - distance) / (distance * substep->displacements[node].w));
    }
}

static void tether_hold_nodes(pli_body* body, tether_state* state, const plii_substep* substep) {
    pli_vec3 landmarks[TETHER_LANDMARKS];
    tether_find_landmarks(body, state, substep, landmarks);
    const plii_vec3x4 fours[] = {plii_vec3x4_from(landmarks), plii_vec3x4_from(landmarks + 4)};
    const float factor = tether_factor(state) * (body->solver_class->solves_constraints ? TETHER_YIELD : 1.0f);
    for (int i = 0; i < body->node_count && !state->are_loose; ++i) {
        const pli_tether* tether = tether_of(body, state, i);
        if (tether == NULL) { continue; }
        tether_hold(body, i, tether->origin, tether->length * factor, substep);
        const int too_far = tether_too_far(state, fours, i, plii_substep_position(body, substep, i), factor);
        for (int k = 0; k < TETHER_LANDMARKS && too_far != 0; ++k) {
            const float longest = state->far[i][k] * factor;
            if ((too_far >> k & 1) != 0) { tether_hold(body, i, state->landmarks[k], longest, substep); }
        }
    }
}

// ---------------------------------------------------------------------------------------- solving, whole steps

/* Inverse of the mass that both ends show along a unit vector, 1/kg. */
static float tether_weight(const tether_load* load, const tether_load* other, pli_vec3 unit) {
    const float weight = plii_substep_rigid_point_weight(&load->pivot.point, unit);
    return other != NULL ? weight + plii_substep_rigid_point_weight(&other->pivot.point, unit) : weight;
}

static pli_vec3 tether_pace(const pli_body* body, const tether_load* load) {
    return plii_rigid_pace_at(body, load->pivot.point.rigid, load->pivot.point.offset);
}
static void tether_push(const pli_body* body, const tether_load* load, pli_vec3 impulse) {
    plii_rigid_push_at(body, load->pivot.point.rigid, impulse, load->pivot.point.offset);
}

/* Rigid bodies stand at the end of this step already, their velocities are those of the next one. */
static void tether_apply_load(const pli_body* body, const tether_state* state, const tether_load* load) {
    const tether_load* other = state->are_loose ? &state->first : NULL;
    const pli_tether* tether = &state->tethers[load->node];
    const pli_vec3 end = other != NULL ? other->goal : plii_xyz(body->positions[tether->origin]);
    const pli_vec3 apart = pli_vec3_sub(load->goal, end);
    const float distance = pli_vec3_length(apart);
    if (!(distance > 0.0f)) { return; }
    const pli_vec3 unit = pli_vec3_scale(apart, 1.0f / distance);
    const pli_vec3 pace = other != NULL ? tether_pace(body, other) : plii_xyz(body->velocities[tether->origin]);
    const pli_vec3 relative = pli_vec3_sub(tether_pace(body, load), pace);
    const float longest = tether_longest(state, tether);
    const float allowed = (tether_limit(longest, distance, body->step.dt) - distance) * body->step.inverse_dt;
    const float excess = pli_vec3_dot(unit, relative) - allowed;
    const float weight = tether_weight(load, other, unit);
    if (!(excess > 0.0f) || !(weight > 0.0f) || !plii_is_finite(excess / weight)) { return; }
    tether_push(body, load, pli_vec3_scale(unit, -excess / weight));
    if (other != NULL) { tether_push(body, other, pli_vec3_scale(unit, excess / weight)); }
}

static void tether_solve(pli_body* body, void* data) {
    tether_state* state = data;
    const plii_substep step = plii_substep_of_step(body, body->positions, body->previous);
    for (PLII_EACH(const plii_node_constraint, at, state->constraints, state->constraint_count)) {
        if (!tether_is_led(body, at)) { continue; }
        plii_set_xyz(&body->positions[at->node], at->end); /* links have pulled at it */
    }
    tether_hold_nodes(body, state, &step);
    for (PLII_EACH(const tether_load, load, state->loads, state->load_count)) {
        tether_apply_load(body, state, load);
    }
}

/* Where an origin is at the end of the step. `hint`: where to begin among the anchored ones; becomes the next. */
static pli_vec3 tether_end_of_origin(const pli_body* body, const tether_state* state, int node, int* hint) {
    for (int i = 0; i < state->constraint_count; ++i) {
        const int place = (*hint + i) % state->constraint_count;
        const plii_node_constraint* at = &state->constraints[place];
        if (at->node != node || !tether_is_led(body, at)) { continue; }
        *hint = (place + 1) % state->constraint_count;
        return at->end;
    }
    return pli_vec3_add(plii_xyz(body->positions[node]),
                        pli_vec3_scale(plii_xyz(body->velocities[node]), body->step.dt));
}

/* What would get too far away is on a spring: held after the solution, no force would reach rigid bodies in it. */
static void tether_visit_spring(const pli_body* body, int node, int origin, pli_vec3 origin_end, float longest,
                                plii_spring_fn* visit, void* user) {
    const pli_vec3 start = plii_xyz(body->positions[node]);
    const pli_vec3 free = pli_vec3_scale(plii_xyz(body->velocities[node]), body->step.dt);
    const pli_vec3 apart = pli_vec3_sub(pli_vec3_add(start, free), origin_end);
    const float distance = pli_vec3_length(apart);
    if (!(distance > longest) || !plii_is_finite(distance)) { return; }
    const float before = pli_vec3_length(pli_vec3_sub(start, plii_xyz(body->positions[origin])));
    const float limit = tether_limit(longest, before, body->step.dt);
    if (!(distance > limit)) { return; }
    plii_node_spring spring = {.node = node, .hardness = TETHER_FIRMNESS};
    spring.along = pli_vec3_scale(apart, 1.0f / distance);
    spring.way = pli_vec3_add(free, pli_vec3_scale(spring.along, limit - distance));
    visit(&spring, user);
}

static void tether_visit_springs(pli_body* body, void* data, plii_spring_fn* visit, void* user) {
    tether_state* state = data;
    pli_vec3 landmarks[TETHER_LANDMARKS];
    int hint = 0;
    (void)tether_follow_origins(body, state, false);
    const plii_substep step = plii_substep_of_step(body, body->positions, body->previous);
    tether_find_landmarks(body, state, &step, landmarks);
    for (int k = 0; k < TETHER_LANDMARKS && state->landmarks[k] != PLI_NULL_INDEX; ++k) {
        landmarks[k] = tether_end_of_origin(body, state, state->landmarks[k], &hint);
    }
    for (int i = 0; i < body->node_count; ++i) {
        const pli_tether* tether = tether_of(body, state, i);
        if (tether == NULL) { continue; }
        const pli_vec3 origin = tether_end_of_origin(body, state, tether->origin, &hint);
        tether_visit_spring(body, i, tether->origin, origin, tether_longest(state, tether), visit, user);
        for (int k = 0; k < TETHER_LANDMARKS; ++k) {
            const float longest = state->far[i][k] * tether_factor(state);
            if (longest < INFINITY) {
                tether_visit_spring(body, i, state->landmarks[k], landmarks[k], longest, visit, user);
            }
        }
    }
}

// -------------------------------------------------------------------------------------------- solving, substeps

static pli_vec3 tether_load_position(const tether_load* load) {
    return pli_vec3_add(load->goal, plii_substep_rigid_pivot_moved(&load->pivot));
}

static void tether_restart(pli_body* body, void* data, const plii_substep* substep) {
    tether_state* state = data;
    const tether_load* other = state->are_loose ? &state->first : NULL;
    if (state->load_count > 0 && other != NULL) { plii_substep_rigid_pivot_turn(&state->first.pivot); }
    for (PLII_EACH(tether_load, load, state->loads, state->load_count)) {
        plii_substep_rigid_pivot_turn(&load->pivot);
        const pli_tether* tether = &state->tethers[load->node];
        const pli_vec3 end =
            other != NULL ? tether_load_position(other) : plii_substep_start(body, substep, tether->origin);
        const pli_vec3 apart = pli_vec3_sub(tether_load_position(load), end);
        const float distance = pli_vec3_length(apart);
        load->limit = tether_limit(tether_longest(state, tether), distance, substep->dt);
        if (distance < load->limit) {
            load->limit = distance + plii_substep_braked(load->limit - distance, substep);
            continue;
        }
        /* It comes back by a shift, which leaves no speed; two bodies share that by their masses. */
        const pli_vec3 back = pli_vec3_scale(apart, distance > 0.0f ? load->limit / distance - 1.0f : 0.0f);
        const float own = load->pivot.point.rigid->state.inverse_mass;
        const float share = other != NULL ? own / (own + other->pivot.point.rigid->state.inverse_mass) : 1.0f;
        plii_substep_rigid_point_shift(&load->pivot.point, pli_vec3_scale(back, share));
        if (other != NULL) { plii_substep_rigid_point_shift(&other->pivot.point, pli_vec3_scale(back, share - 1.0f)); }
    }
}

/* At the end of the substep. */
static pli_vec3 tether_load_end(const tether_load* load, const plii_substep* substep) {
    return pli_vec3_add(tether_load_position(load), plii_substep_rigid_point_motion(&load->pivot.point, substep));
}

static void tether_sweep(pli_body* body, void* data, const plii_substep* substep) {
    tether_state* state = data;
    const float share = (float)(substep->index + 1) * substep->dt * body->step.inverse_dt;
    for (PLII_EACH(const plii_node_constraint, at, state->constraints, state->constraint_count)) {
        if (!tether_is_led(body, at)) { continue; }
        /* To where it is at the end of the substep. */
        const pli_vec3 goal = pli_vec3_lerp(at->start, at->end, share);
        plii_set_xyz(&substep->displacements[at->node], pli_vec3_sub(goal, plii_xyz(body->positions[at->node])));
    }
    tether_hold_nodes(body, state, substep);
    const tether_load* other = state->are_loose ? &state->first : NULL;
    for (PLII_EACH(const tether_load, load, state->loads, state->load_count)) {
        const int origin = state->tethers[load->node].origin;
        const pli_vec3 end =
            other != NULL ? tether_load_end(other, substep) : plii_substep_position(body, substep, origin);
        const pli_vec3 apart = pli_vec3_sub(tether_load_end(load, substep), end);
        const float distance = pli_vec3_length(apart), excess = distance - load->limit;
        if (!(excess > 0.0f)) { continue; }
        const pli_vec3 unit = pli_vec3_scale(apart, 1.0f / distance);
        const float push = -excess / tether_weight(load, other, unit);
        if (!plii_is_finite(push)) { continue; }
        plii_substep_rigid_point_push(&load->pivot.point, pli_vec3_scale(unit, push), substep);
        if (other != NULL) { plii_substep_rigid_point_push(&other->pivot.point, pli_vec3_scale(unit, -push), substep); }
    }
}

/* Around the origins; a node stays within all of them. */
typedef struct tether_spheres {
    int count;
    pli_vec3 centers[1 + TETHER_LANDMARKS];
    float radii[1 + TETHER_LANDMARKS];
} tether_spheres;

static tether_spheres tether_spheres_of(const pli_body* body, const tether_state* state, const plii_substep* substep,
                                        const pli_tether* tether, int node) {
    tether_spheres spheres = {
        1, {plii_substep_position(body, substep, tether->origin)}, {tether_longest(state, tether)}};
    for (int k = 0; k < TETHER_LANDMARKS; ++k) {
        const float length = state->far[node][k];
        if (!(length < INFINITY)) { continue; }
        spheres.centers[spheres.count] = plii_substep_position(body, substep, state->landmarks[k]);
        spheres.radii[spheres.count++] = length * tether_factor(state);
    }
    return spheres;
}

static float tether_straight_room(const tether_spheres* spheres, pli_vec3 at, pli_vec3 direction) {
    float room = INFINITY;
    for (int k = 0; k < spheres->count; ++k) {
        room = plii_min(room, plii_sphere_room(pli_vec3_sub(at, spheres->centers[k]), spheres->radii[k], direction));
    }
    return room;
}

/* Into one sphere after the other. */
static pli_vec3 tether_drawn_in(const tether_spheres* spheres, pli_vec3 p) {
    for (int k = 0; k < spheres->count; ++k) {
        const pli_vec3 apart = pli_vec3_sub(p, spheres->centers[k]);
        const float radius = spheres->radii[k], squared = pli_vec3_length_squared(apart);
        if (!(squared > radius * radius)) { continue; }
        p = pli_vec3_add(spheres->centers[k], pli_vec3_scale(apart, radius / sqrtf(squared)));
    }
    return p;
}

/* How far along the direction a node gets that slides along the spheres: pushed and drawn in in turn, by secants. */
static float tether_sliding_room(const tether_spheres* spheres, pli_vec3 at, pli_vec3 direction, float wanted) {
    enum { PASSES = 6 };
    pli_vec3 place = at;
    float reached = 0.0f, stride = wanted;
    for (int pass = 0; pass < PASSES && reached < 0.99f * wanted; ++pass) {
        place = tether_drawn_in(spheres, pli_vec3_add(place, pli_vec3_scale(direction, stride)));
        const float before = reached;
        reached = pli_vec3_dot(pli_vec3_sub(place, at), direction);
        stride = (wanted - reached) * (stride / plii_max(reached - before, 0.1f * stride));
    }
    /* The last sphere may have drawn it out of another one. */
    const pli_vec3 way = pli_vec3_sub(place, at);
    const float length = pli_vec3_length(way);
    if (!(reached > 0.0f) || !(length > 0.0f)) { return 0.0f; }
    const float straight = tether_straight_room(spheres, at, pli_vec3_scale(way, 1.0f / length));
    return reached * plii_min(straight / length, 1.0f);
}

/* To the spheres. A curtain that hangs has no room straight on, and is no wall: its nodes go up. */
static float tether_room(const pli_body* body, const void* data, const plii_substep* substep, int node,
                         pli_vec3 direction, float wanted) {
    const tether_state* state = data;
    const pli_tether* tether = tether_of(body, state, node);
    if (tether == NULL) { return INFINITY; }
    const pli_vec3 at = plii_substep_position(body, substep, node);
    const tether_spheres spheres = tether_spheres_of(body, state, substep, tether, node);
    const float straight = tether_straight_room(&spheres, at, direction);
    if (!(straight < wanted)) { return straight; }
    /* Five times as far as would do: what the passes stop short of would brake in each substep. */
    const float enough = straight + TETHER_LEAST_SLIDING + 0.5f * (wanted - straight);
    const float gained = tether_sliding_room(&spheres, at, direction, enough) - straight - TETHER_LEAST_SLIDING;
    return straight + TETHER_SLIDING * plii_max(gained, 0.0f);
}

static bool tether_carry(const pli_body* body, const void* data, const plii_substep* substep, int node,
                         pli_vec3 direction, pli_vec3 own, pli_vec3* motion) {
    const pli_tether* tether = tether_of(body, data, node);
    if (tether != NULL) { *motion = plii_substep_motion(substep, tether->origin); }
    return tether != NULL;
}

// ------------------------------------------------------------------------------------------------------ the feature

static void tether_topology_commit(pli_body* body, void* data, const plii_topology_change* change) {
    tether_state* state = data;
    state->load_count = 0;
    (void)tether_measure(body, state);
}

/* After the links, which stretch them; contacts and anchors come later in substeps, before them in iterations. */
enum { TETHER_ORDER = PLII_ORDER_LINKS + 2, TETHER_SUBSTEP_ORDER = 45 };
const plii_feature_class plii_tether_class = {
    .name = "tethers",
    .state_size = sizeof(tether_state),
    .settings = PLII_LIMITS_AT(offsetof(tether_state, def), PLII_FIELD(pli_tethers_def, slack, 0, PLI_MAX_FACTOR)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_SPAN(tether_state, def, link_revision, PLII_SAVED, "fu8Nu"),
                                    PLII_STATE_OF(tether_state, are_loose, PLII_SAVED, "B"),
                                    PLII_STATE_SPAN(tether_state, spread, first, PLII_LEFT, NULL)),
    .stages =
        {[PLII_STAGE_PREPARE] = {tether_begin, TETHER_ORDER}, [PLII_STAGE_POSITION] = {tether_solve, TETHER_ORDER}},
    .substepped = PLII_SUBSTEPPED(.order = TETHER_SUBSTEP_ORDER, .begin = tether_begin, .restart = tether_restart,
                                  .sweep = tether_sweep, .room = tether_room, .carry = tether_carry),
    .arrays =
        PLII_ARRAYS({PLII_MEMBER(tether_state, tethers), PLII_PER_NODE, PLII_SAVED_AS("Nf")},
                    {PLII_MEMBER(tether_state, far), PLII_PER_NODE, PLII_SAVED_AS("8f")},
                    PLII_LEFT_COUNTED(tether_state, constraints, constraint_capacity, constraint_count),
                    {PLII_COUNTED_LIST(tether_state, origins, origin_capacity, origin_count), PLII_SAVED_AS("nB")},
                    PLII_LEFT_COUNTED(tether_state, loads, load_capacity, load_count)),
    .topology_commit = tether_topology_commit,
    .visit_springs = tether_visit_springs,
};

PLII_DEFINE_DEFAULT(pli_tethers_def, .slack = 0.01f)
pli_status pli_body_enable_tethers(pli_body* body, const pli_tethers_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_SETTINGS(body, pli_tethers_def, used, def, plii_tether_class);
    const bool is_new = plii_feature_state(body, &plii_tether_class) == NULL;
    PLII_TRY_ENABLE(body, tether_state, state, plii_tether_class);
    if (!tether_follow_origins(body, state, is_new)) {
        return PLII_FAIL_ENABLED(body, plii_tether_class, __func__, "no memory to measure the body");
    }
    state->def = used;
    return plii_body_changed(body, PLI_OK);
}
PLII_DEFINE_DISABLE(pli_body_disable_tethers, plii_check_body_idle, plii_tether_class)

pli_tether pli_body_get_tether(const pli_body* body, int node) {
    const pli_tether none = {PLI_NULL_INDEX, 0.0f};
    if (plii_check_node(body, node, __func__) != PLI_OK) { return none; }
    const tether_state* state = plii_feature_state(body, &plii_tether_class);
    if (state == NULL || state->are_loose || state->tethers[node].origin == PLI_NULL_INDEX) { return none; }
    return state->tethers[node];
}
