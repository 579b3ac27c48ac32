/* The solve of contacts of nodes with the faces of another soft body, C = n . (node - point of the face) - margins >= 0
   with Coulomb friction, by all solvers outside of reference mode. It runs after the sweeps of all bodies that are
   solved side by side, so that contacts have the last word, and moves both bodies where they are in the step or
   substep. Another body, with another solver or other substeps, is solved before or after: it takes part by its
   velocities, as a rigid body does. */

#include "contact/soft_contacts_impl.h"
#include "math/simd_float4.h"

#include <string.h>

/* The substep of the body that is solved, or NULL: a whole step. */
typedef struct soft_couple_time {
    const plii_substep* substep;
    float dt, inverse_dt;
} soft_couple_time;

static soft_couple_time soft_couple_now(const pli_body* body) {
    const plii_substep* substep = body->substep;
    return substep != NULL ? (soft_couple_time){substep, substep->dt, substep->inverse_dt}
                           : (soft_couple_time){NULL, body->step.dt, body->step.inverse_dt};
}

PLII_SIMD_INLINE plii_float4 soft_couple_position(const pli_body* body, int node, soft_couple_time time) {
    return plii_float4_from(&body->positions[node]);
}

/* Where a node is, from its position. A body that is not in the substep is, or will be, at its position at the end of
   the step. */
PLII_SIMD_INLINE plii_float4 soft_couple_displacement(const pli_body* body, int node, soft_couple_time time) {
    return body->substep != NULL
               ? plii_float4_from(&body->substep->displacements[node])
               : plii_float4_from(&body->velocities[node]) * plii_float4_all(-time.substep->remaining);
}

/* In the step or substep. */
PLII_SIMD_INLINE plii_float4 soft_couple_motion(const pli_body* body, int node, soft_couple_time time) {
    if (time.substep == NULL) {
        return plii_float4_from(&body->positions[node]) - plii_float4_from(&body->previous[node]);
    }
    if (body->substep == NULL) { return plii_float4_from(&body->velocities[node]) * plii_float4_all(time.dt); }
    return plii_float4_from(&body->substep->displacements[node]) -
           plii_float4_from(&body->substep->start_displacements[node]);
}

/* But for what took overlaps back: as if the node had started so much farther. */
PLII_SIMD_INLINE plii_float4 soft_couple_solved_motion(const pli_body* body, int node, soft_couple_time time) {
    const plii_float4 motion = soft_couple_motion(body, node, time);
    return body->soft_shifts != NULL ? motion - plii_lanes_from_vec3(&body->soft_shifts[node]) : motion;
}

typedef plii_float4 soft_couple_quantity(const pli_body* body, int node, soft_couple_time time);

/* Of the node against the point of the face. By differences, which far from the origin are more exact than what they
   are of. */
PLII_SIMD_INLINE plii_float4 soft_couple_relative(const pli_body* body, const plii_soft_contact* contact,
                                                  soft_couple_time time, soft_couple_quantity* of) {
    const pli_body* other = contact->face_body;
    const int* face = other->topology->faces[contact->face];
    const plii_float4 node = of(body, contact->node, time);
    return (node - of(other, face[0], time)) * plii_float4_all(contact->weights.x) +
           (node - of(other, face[1], time)) * plii_float4_all(contact->weights.y) +
           (node - of(other, face[2], time)) * plii_float4_all(contact->weights.z);
}

PLII_SIMD_INLINE pli_vec3 soft_couple_vec3(plii_float4 lanes) {
    pli_vec3 v;
    plii_lanes_to_vec3(&v, lanes);
    return v;
}

static void soft_couple_add(pli_vec4* to, pli_vec3 by) {
    plii_set_xyz(to, pli_vec3_add(plii_xyz(*to), by));
}

static void soft_couple_move(pli_body* body, int node, pli_vec3 by) {
    soft_couple_add(body->substep != NULL ? &body->substep->displacements[node] : &body->positions[node], by);
}

/* As if the node had started there, so that no velocity comes of it. */
static void soft_couple_move_start(pli_body* body, int node, pli_vec3 by) {
    soft_couple_add(body->substep != NULL ? &body->substep->start_displacements[node] : &body->previous[node], by);
}

static bool soft_couple_is_beside(const pli_body* body, const pli_body* other) {
    return body->island != NULL && other->island == body->island;
}

/* A body that is not solved side by side is where its velocity leads to. */
static void soft_couple_accelerate(pli_body* body, int node, pli_vec3 by, soft_couple_time time) {
    const pli_vec3 change = pli_vec3_scale(by, time.inverse_dt);
    const float left = time.dt + (time.substep != NULL ? time.substep->remaining : 0.0f);
    soft_couple_add(&body->velocities[node], change);
    soft_couple_add(&body->positions[node], pli_vec3_scale(change, left));
}

/* What a push does to nodes. */
typedef enum soft_couple_effect {
    SOFT_COUPLE_MOVE,
    SOFT_COUPLE_SHIFT, /* moves them, and what the solve takes for their start */
    SOFT_COUPLE_STILL  /* takes as much of their motion for none */
} soft_couple_effect;

PLII_SIMD_INLINE void soft_couple_affect(pli_body* body, int node, pli_vec3 by, soft_couple_effect effect,
                                         bool is_beside, soft_couple_time time) {
    if (effect == SOFT_COUPLE_STILL) {
        if (!is_beside) { soft_couple_accelerate(body, node, pli_vec3_neg(by), time); }
        soft_couple_move_start(body, node, by);
    } else if (!is_beside) {
        soft_couple_accelerate(body, node, by, time);
    } else {
        soft_couple_move(body, node, by);
        if (effect == SOFT_COUPLE_SHIFT && body->soft_shifts != NULL) {
            body->soft_shifts[node] = pli_vec3_add(body->soft_shifts[node], by);
        }
    }
}

/* `push` in kg m */
PLII_SIMD_INLINE void soft_couple_push(pli_body* body, const plii_soft_contact* contact, pli_vec3 push,
                                       soft_couple_effect effect, soft_couple_time time) {
    pli_body* other = contact->face_body;
    const int* face = other->topology->faces[contact->face];
    const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
    const float node_weight = body->positions[contact->node].w;
    soft_couple_affect(body, contact->node, pli_vec3_scale(push, node_weight), effect, true, time);
    if (plii_body_is_idle(other)) { return; }
    const bool is_beside = soft_couple_is_beside(body, other);
    for (int k = 0; k < 3; ++k) {
        const pli_vec3 back = pli_vec3_scale(push, -other->positions[face[k]].w * weights[k]);
        soft_couple_affect(other, face[k], back, effect, is_beside, time);
    }
}

static void soft_couple_record(const plii_soft_contacts_state* state, int index, pli_vec3 push, soft_couple_time time) {
    if (index < state->impulse_count) {
        plii_contact_impulses_push(&state->impulses, index, pli_vec3_scale(push, time.inverse_dt));
    }
}

/* s; overlaps go as if a spring with a dashpot drew them out. A few sweeps leave nodes of a pile a little too deep in
   each step, and what drew them out at once would make them tremble for ever. */
#define SOFT_COUPLE_RECOVERY_TIME (1.0f / 15.0f)

/* How much of an overlap at the start goes in the step or substep at most, m. What a fast node keeps beyond the margins
   is no overlap. */
static float soft_couple_recovery(const pli_body* body, const plii_soft_contact* contact, float start_gap,
                                  float recovery_speed, soft_couple_time time) {
    const float beyond = contact->margin - body->collision_margin - contact->face_body->collision_margin;
    const float depth = plii_max(0.0f, -start_gap - plii_max(0.0f, beyond));
    const float share = time.dt / (time.dt + SOFT_COUPLE_RECOVERY_TIME);
    return plii_min(depth * share, plii_contact_recovery_speed(recovery_speed) * time.dt);
}

/* Once before the sweeps, so that overlaps that contradict each other do not drive each other on from sweep to sweep.
   Returns whether there is a shift. */
static bool soft_couple_recover(pli_body* body, const plii_soft_contacts_state* state, int index, float gap,
                                float start_gap, soft_couple_time time) {
    plii_soft_contact* contact = &state->contacts[index];
    const float most = soft_couple_recovery(body, contact, start_gap, state->def.recovery_speed, time);
    contact->shift = plii_clamp(start_gap + most - gap, 0.0f, most);
    const pli_vec3 push = pli_vec3_scale(contact->normal, contact->shift / contact->weight);
    if (!plii_vec3_is_finite(push)) { contact->shift = 0.0f; }
    if (!(contact->shift > 0.0f)) { return false; }
    soft_couple_push(body, contact, push, SOFT_COUPLE_SHIFT, time);
    soft_couple_record(state, index, push, time);
    return true;
}

/* From the point of the face to the node. */
PLII_SIMD_INLINE pli_vec3 soft_couple_apart(const pli_body* body, const plii_soft_contact* contact,
                                            soft_couple_time time) {
    const plii_float4 apart = soft_couple_relative(body, contact, time, soft_couple_position);
    if (time.substep == NULL) { return soft_couple_vec3(apart); }
    return soft_couple_vec3(apart + soft_couple_relative(body, contact, time, soft_couple_displacement));
}

static pli_vec3 soft_couple_relative_motion(const pli_body* body, const plii_soft_contact* contact,
                                            soft_couple_time time) {
    return soft_couple_vec3(soft_couple_relative(body, contact, time, soft_couple_solved_motion));
}

static void soft_couple_solve(pli_body* body, const plii_soft_contacts_state* state, int index, bool is_first,
                              soft_couple_time time) {
    plii_soft_contact* contact = &state->contacts[index];
    const pli_vec3 n = contact->normal;
    float gap = pli_vec3_dot(n, soft_couple_apart(body, contact, time)) - contact->margin;
    if (is_first) {
        contact->multiplier = contact->shift = 0.0f;
        contact->friction_push = pli_vec3_make(0, 0, 0);
    }
    if (gap >= 0.0f && contact->multiplier == 0.0f) { return; }
    pli_vec3 motion = soft_couple_relative_motion(body, contact, time);
    if (is_first && soft_couple_recover(body, state, index, gap, gap - pli_vec3_dot(n, motion), time)) {
        gap += contact->shift;
        motion = soft_couple_relative_motion(body, contact, time);
    }
    const float along = pli_vec3_dot(n, motion);
    const float alpha = state->def.compliance * time.inverse_dt * time.inverse_dt;
    const float wanted =
        plii_contact_multiplier(gap - plii_min(gap - along, 0.0f), contact->weight, alpha, contact->multiplier);
    const float multiplier = plii_max(0.0f, contact->multiplier + contact->hardness * wanted);
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, along));
    const pli_vec3 friction =
        plii_contact_friction(contact->friction_push, sliding, contact->weight, contact->friction * multiplier);
    const pli_vec3 push = pli_vec3_add(pli_vec3_scale(n, multiplier - contact->multiplier),
                                       pli_vec3_sub(friction, contact->friction_push));
    if (!plii_vec3_is_finite(push)) { return; }
    soft_couple_push(body, contact, push, SOFT_COUPLE_MOVE, time);
    contact->multiplier = multiplier;
    contact->friction_push = friction;
    soft_couple_record(state, index, push, time);
}

void plii_soft_contacts_couple(pli_body* body, void* data) {
    plii_soft_contacts_state* state = data;
    const bool is_first = body->substep != NULL ? body->substep->is_first_sweep : !state->has_coupled;
    const soft_couple_time time = soft_couple_now(body);
    state->has_coupled = true;
    for (int i = 0; i < state->count; ++i) {
        if (!state->contacts[i].is_bullet) { soft_couple_solve(body, state, i, is_first, time); }
    }
}

/* What an overlap that went has parted leaves no speed: springs and links that pull nodes back would wind it up from
   step to step. What the shift only held up against loads is no motion, and leaves nothing to take. */
static void soft_couple_settle(pli_body* body, const plii_soft_contacts_state* state, int index,
                               soft_couple_time time) {
    const plii_soft_contact* contact = &state->contacts[index];
    if (!(contact->shift > 0.0f)) { return; }
    const pli_vec3 n = contact->normal;
    const float along =
        pli_vec3_dot(n, soft_couple_vec3(soft_couple_relative(body, contact, time, soft_couple_motion)));
    const float parted = plii_min(along, contact->shift);
    if (!(parted > 0.0f)) { return; }
    const pli_vec3 push = pli_vec3_scale(n, parted / contact->weight);
    soft_couple_push(body, contact, push, SOFT_COUPLE_STILL, time);
    soft_couple_record(state, index, pli_vec3_neg(push), time);
}

void plii_soft_contacts_settle(pli_body* body, void* data) {
    plii_soft_contacts_state* state = data;
    const soft_couple_time time = soft_couple_now(body);
    for (int i = 0; i < state->count; ++i) {
        if (!state->contacts[i].is_bullet) { soft_couple_settle(body, state, i, time); }
    }
    memset(state->shifts, 0, (size_t)body->node_count * sizeof *state->shifts);
}
