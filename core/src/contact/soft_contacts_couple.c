/* The solve of contacts of nodes with the faces of another soft body, C = n . (node - point of the face) - margins >= 0
   with Coulomb friction, by all solvers outside of reference mode. It runs after the sweeps of all bodies that are
   solved side by side, so that contacts have the last word, and moves both bodies where they are in the step or
   substep. Another body, with another solver or other substeps, is solved before or after: it takes part by its
   velocities, as a rigid body does. */

#include "contact/soft_contacts_impl.h"

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

/* Before the end of a step at which the body will be, or is already, at its positions. */
static pli_vec3 soft_couple_before(const pli_body* body, int node, float time) {
    return pli_vec3_sub(plii_xyz(body->positions[node]), pli_vec3_scale(plii_xyz(body->velocities[node]), time));
}

static pli_vec3 soft_couple_at(const pli_body* body, int node, soft_couple_time time) {
    if (time.substep == NULL) { return plii_xyz(body->positions[node]); }
    return body->substep != NULL ? plii_substep_position(body, body->substep, node)
                                 : soft_couple_before(body, node, time.substep->remaining);
}

static pli_vec3 soft_couple_start(const pli_body* body, int node, soft_couple_time time) {
    if (time.substep == NULL) { return plii_xyz(body->previous[node]); }
    return body->substep != NULL ? plii_substep_place(body, body->substep, body->substep->start_displacements, node)
                                 : soft_couple_before(body, node, time.substep->remaining + time.dt);
}

typedef pli_vec3 soft_couple_place(const pli_body* body, int node, soft_couple_time time);

/* From the point of the face to the node. */
static inline pli_vec3 soft_couple_apart(const pli_body* body, const plii_soft_contact* contact, soft_couple_time time,
                                         soft_couple_place* at) {
    const pli_body* other = contact->face_body;
    const int* face = other->topology->faces[contact->face];
    const pli_vec3 a = pli_vec3_scale(at(other, face[0], time), contact->weights.x);
    const pli_vec3 b = pli_vec3_scale(at(other, face[1], time), contact->weights.y);
    const pli_vec3 c = pli_vec3_scale(at(other, face[2], time), contact->weights.z);
    return pli_vec3_sub(at(body, contact->node, time), pli_vec3_add(pli_vec3_add(a, b), c));
}

static void soft_couple_add(pli_vec4* to, pli_vec3 by) {
    plii_set_xyz(to, pli_vec3_add(plii_xyz(*to), by));
}

static void soft_couple_move(pli_body* body, int node, pli_vec3 by) {
    soft_couple_add(body->substep != NULL ? &body->substep->displacements[node] : &body->positions[node], by);
}

/* As if the node had been there at the start, so that no velocity comes of it. */
static void soft_couple_shift(pli_body* body, int node, pli_vec3 by) {
    soft_couple_move(body, node, by);
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

/* `push` in kg m; of what overlapped before the start `is_shift`. */
static void soft_couple_push(pli_body* body, const plii_soft_contact* contact, pli_vec3 push, bool is_shift,
                             soft_couple_time time) {
    pli_body* other = contact->face_body;
    const int* face = other->topology->faces[contact->face];
    const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
    const pli_vec3 by = pli_vec3_scale(push, body->positions[contact->node].w);
    if (is_shift) {
        soft_couple_shift(body, contact->node, by);
    } else {
        soft_couple_move(body, contact->node, by);
    }
    if (plii_body_is_idle(other)) { return; }
    const bool is_beside = soft_couple_is_beside(body, other);
    for (int k = 0; k < 3; ++k) {
        const pli_vec3 back = pli_vec3_scale(push, -other->positions[face[k]].w * weights[k]);
        if (is_shift) {
            soft_couple_shift(other, face[k], back);
        } else if (is_beside) {
            soft_couple_move(other, face[k], back);
        } else {
            soft_couple_accelerate(other, face[k], back, time);
        }
    }
}

/* What overlaps at the start goes at the recovery speed, by a shift that leaves no speed: springs and links that pull
   nodes back would wind it up from step to step. What a fast node keeps beyond the margins is no overlap. Returns the
   shift, m. */
static float soft_couple_recover(pli_body* body, const plii_soft_contact* contact, float start_gap,
                                 float recovery_speed, soft_couple_time time) {
    const float beyond = contact->margin - body->collision_margin - contact->face_body->collision_margin;
    const float depth = -start_gap - plii_max(0.0f, beyond);
    if (!(depth > 0.0f)) { return 0.0f; }
    const float shift = plii_min(depth, plii_contact_recovery_speed(recovery_speed) * time.dt);
    soft_couple_push(body, contact, pli_vec3_scale(contact->normal, shift / contact->weight), true, time);
    return shift;
}

static void soft_couple_solve(pli_body* body, const plii_soft_contacts_state* state, int index, bool is_first,
                              soft_couple_time time) {
    plii_soft_contact* contact = &state->contacts[index];
    const pli_vec3 n = contact->normal;
    pli_vec3 apart = soft_couple_apart(body, contact, time, soft_couple_at);
    float gap = pli_vec3_dot(n, apart) - contact->margin;
    if (is_first) {
        contact->multiplier = 0.0f;
        contact->friction_push = pli_vec3_make(0, 0, 0);
    }
    if (gap >= 0.0f && contact->multiplier == 0.0f) { return; }
    pli_vec3 start = soft_couple_apart(body, contact, time, soft_couple_start);
    float start_gap = pli_vec3_dot(n, start) - contact->margin;
    if (is_first) {
        const float shift = soft_couple_recover(body, contact, start_gap, state->def.recovery_speed, time);
        const pli_vec3 by = pli_vec3_scale(n, shift);
        apart = pli_vec3_add(apart, by);
        start = pli_vec3_add(start, by);
        gap += shift;
        start_gap += shift;
    }
    const float alpha = state->def.compliance * time.inverse_dt * time.inverse_dt;
    const float wanted =
        plii_contact_multiplier(gap - plii_min(start_gap, 0.0f), contact->weight, alpha, contact->multiplier);
    const float multiplier = plii_max(0.0f, contact->multiplier + contact->hardness * wanted);
    const pli_vec3 motion = pli_vec3_sub(apart, start);
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, pli_vec3_dot(motion, n)));
    const pli_vec3 friction =
        plii_contact_friction(contact->friction_push, sliding, contact->weight, contact->friction * multiplier);
    const pli_vec3 push = pli_vec3_add(pli_vec3_scale(n, multiplier - contact->multiplier),
                                       pli_vec3_sub(friction, contact->friction_push));
    if (!plii_vec3_is_finite(push)) { return; }
    soft_couple_push(body, contact, push, false, time);
    contact->multiplier = multiplier;
    contact->friction_push = friction;
    if (index < state->impulse_count) {
        plii_contact_impulses_push(&state->impulses, index, pli_vec3_scale(push, time.inverse_dt));
    }
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
