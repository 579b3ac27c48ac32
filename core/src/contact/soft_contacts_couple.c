/* The solve of contacts of nodes with the faces of another soft body, C = n . (node - point of the face) - margins >= 0
   with Coulomb friction, by all solvers outside of reference mode. It runs after the sweeps of all bodies that are
   solved side by side, so that contacts have the last word, and moves both. A body with another solver or other
   substeps is solved before or after: it takes part by its velocities, as a rigid body does. */

#include "contact/soft_contacts_impl.h"

/* The substep of the body that is solved, or NULL: a whole step. */
typedef struct couple_time {
    const plii_substep* substep;
    float dt, inverse_dt;
} couple_time;

/* A body of contacts. Its nodes are at positions + here * moves, and have moved by along * moves - before * starts in
   the step or substep. Shifts took overlaps back: as if nodes had started so much farther. */
typedef struct couple_side {
    pli_body* body;
    const pli_vec4* positions;
    pli_vec4 *moves, *starts;
    pli_vec3* shifts; /* may be NULL */
    float here, along, before;
    float rate; /* of its time against that of the body that is solved: each has a step of its own */
    bool is_beside;
} couple_side;

static couple_side couple_side_of(pli_body* body, bool is_beside, couple_time time, float rate) {
    couple_side side = {.body = body,
                        .positions = body->positions,
                        .moves = body->positions,
                        .starts = body->previous,
                        .shifts = body->soft_shifts,
                        .here = 0.0f,
                        .along = 1.0f,
                        .before = 1.0f,
                        .rate = rate,
                        .is_beside = is_beside};
    if (time.substep == NULL) { return side; }
    if (body->substep != NULL) {
        side.moves = body->substep->displacements;
        side.starts = body->substep->start_displacements;
        side.here = 1.0f;
    } else { /* it is, or will be, at its positions at the end of the step */
        side.moves = body->velocities;
        side.here = -time.substep->remaining * rate;
        side.along = time.dt * rate;
        side.before = 0.0f;
    }
    return side;
}

/* Contacts of one body with another one. */
typedef struct couple_pair {
    couple_side node, face;
    bool is_idle; /* the one of the faces: it does not move */
    couple_time time;
} couple_pair;

static couple_pair couple_pair_of(pli_body* body, pli_body* other, couple_time time) {
    const bool is_beside = body->island != NULL && other->island == body->island;
    const float rate = is_beside ? 1.0f : other->step.dt / body->step.dt;
    return (couple_pair){.node = couple_side_of(body, true, time, 1.0f),
                         .face = couple_side_of(other, is_beside, time, rate),
                         .is_idle = plii_body_is_idle(other),
                         .time = time};
}

typedef plii_float4 couple_quantity(const couple_side* side, int node);

PLII_SIMD_INLINE plii_float4 couple_place(const couple_side* side, int node) {
    return plii_float4_from(&side->positions[node]) + plii_float4_from(&side->moves[node]) * side->here;
}
PLII_SIMD_INLINE plii_float4 couple_motion(const couple_side* side, int node) {
    return plii_float4_from(&side->moves[node]) * side->along - plii_float4_from(&side->starts[node]) * side->before;
}

/* But for shifts. */
PLII_SIMD_INLINE plii_float4 couple_solved_motion(const couple_side* side, int node) {
    const plii_float4 motion = couple_motion(side, node);
    return side->shifts != NULL ? motion - plii_lanes_from_vec3(&side->shifts[node]) : motion;
}

/* Of the node against the point of the face; w: 0. By differences, which far from the origin are more exact. */
PLII_SIMD_INLINE plii_float4 couple_relative(const couple_pair* pair, const plii_soft_contact* contact,
                                             couple_quantity* of) {
    const int* face = pair->face.body->topology->faces[contact->face];
    const plii_float4 node = of(&pair->node, contact->node);
    return plii_lanes_xyz((node - of(&pair->face, face[0])) * contact->weights.x +
                          (node - of(&pair->face, face[1])) * contact->weights.y +
                          (node - of(&pair->face, face[2])) * contact->weights.z);
}

/* Whole records: a load of one would wait for parts of it that are on their way to memory. */
PLII_SIMD_INLINE void couple_add(pli_vec4* to, plii_float4 by) {
    plii_float4_to(to, plii_float4_from(to) + by);
}

/* A body that is not solved side by side is where its velocity leads to. */
static void couple_accelerate(const couple_side* side, int node, plii_float4 by, couple_time time) {
    const float left = time.dt + (time.substep != NULL ? time.substep->remaining : 0.0f);
    couple_add(&side->body->velocities[node], by * (time.inverse_dt / side->rate));
    couple_add(&side->body->positions[node], by * time.inverse_dt * left);
}

typedef void couple_effect(const couple_side* side, int node, plii_float4 by, couple_time time);

PLII_SIMD_INLINE void couple_move(const couple_side* side, int node, plii_float4 by, couple_time time) {
    if (side->is_beside) {
        couple_add(&side->moves[node], by);
    } else {
        couple_accelerate(side, node, by, time);
    }
}

/* The solve takes as much for the start of the node. */
PLII_SIMD_INLINE void couple_shift(const couple_side* side, int node, plii_float4 by, couple_time time) {
    if (!side->is_beside || side->shifts == NULL) { return; }
    plii_lanes_to_vec3(&side->shifts[node], plii_lanes_from_vec3(&side->shifts[node]) + by);
}

/* As if the node had started there, so that no velocity comes of it. */
PLII_SIMD_INLINE void couple_still(const couple_side* side, int node, plii_float4 by, couple_time time) {
    if (!side->is_beside) { couple_accelerate(side, node, -by, time); }
    couple_add(&side->starts[node], by);
}

/* `push` in kg m; w: 0 */
PLII_SIMD_INLINE void couple_push(const couple_pair* pair, const plii_soft_contact* contact, plii_float4 push,
                                  couple_effect effect) {
    const couple_side *node = &pair->node, *others = &pair->face;
    const int* face = others->body->topology->faces[contact->face];
    effect(node, contact->node, push * node->positions[contact->node].w, pair->time);
    if (pair->is_idle) { return; }
    const plii_float4 back = -push;
    effect(others, face[0], back * (others->positions[face[0]].w * contact->weights.x), pair->time);
    effect(others, face[1], back * (others->positions[face[1]].w * contact->weights.y), pair->time);
    effect(others, face[2], back * (others->positions[face[2]].w * contact->weights.z), pair->time);
}

static void couple_record(const plii_soft_contacts_state* state, int index, plii_float4 push, couple_time time) {
    if (index >= state->impulse_count) { return; }
    plii_contact_impulses_push(&state->impulses, index, plii_lanes_vec3(push * time.inverse_dt));
}

/* s; overlaps go as if a spring with a dashpot drew them out. A few sweeps leave nodes of a pile a little too deep in
   each step, and what drew them out at once would make them tremble for ever. */
#define SOFT_COUPLE_RECOVERY_TIME (1.0f / 15.0f)

/* m, of an overlap at the start that goes in the step at most. What a fast node keeps beyond the margins is none. */
static float couple_recovery(const pli_body* body, const plii_soft_contact* contact, float start_gap,
                             float recovery_speed, couple_time time) {
    const float beyond = contact->margin - body->collision_margin - contact->face_body->collision_margin;
    const float depth = plii_max(0.0f, -start_gap - plii_max(0.0f, beyond));
    const float share = time.dt / (time.dt + SOFT_COUPLE_RECOVERY_TIME);
    return plii_min(depth * share, plii_contact_recovery_speed(recovery_speed) * time.dt);
}

/* What draws an overlap out, in the first sweep only, so that overlaps that contradict each other do not drive each
   other on from sweep to sweep; kg m. To a body that is not beside it is a motion, which counts in `along`. */
static plii_float4 couple_recover(const couple_pair* pair, const plii_soft_contacts_state* state,
                                  plii_soft_contact* contact, float gap, float* along) {
    const float most = couple_recovery(pair->node.body, contact, gap - *along, state->def.recovery_speed, pair->time);
    const float node_weight = pair->node.positions[contact->node].w;
    contact->shift = plii_clamp(most - *along, 0.0f, most);
    if (!pair->face.is_beside) { *along += contact->shift * (1.0f - node_weight / contact->weight); }
    return plii_lanes_from_vec3(&contact->normal) * (contact->shift / contact->weight);
}

static void couple_solve(const couple_pair* pair, const plii_soft_contacts_state* state, int index, bool is_first) {
    plii_soft_contact* contact = &state->contacts[index];
    const plii_float4 n = plii_lanes_from_vec3(&contact->normal);
    float gap = plii_lanes_dot(n, couple_relative(pair, contact, couple_place)) - contact->margin;
    if (is_first) {
        contact->multiplier = contact->shift = 0.0f;
        contact->friction_push = pli_vec3_make(0, 0, 0);
    }
    if (gap >= 0.0f && contact->multiplier == 0.0f) { return; }
    const plii_float4 motion = couple_relative(pair, contact, couple_solved_motion);
    float along = plii_lanes_dot(n, motion);
    const plii_float4 sliding = motion - n * along;
    plii_float4 shift = plii_float4_all(0.0f);
    if (is_first) {
        shift = couple_recover(pair, state, contact, gap, &along);
        gap += contact->shift;
    }
    const float alpha = state->def.compliance * pair->time.inverse_dt * pair->time.inverse_dt;
    const float wanted =
        plii_contact_multiplier(gap - plii_min(gap - along, 0.0f), contact->weight, alpha, contact->multiplier);
    const float multiplier = plii_max(0.0f, contact->multiplier + contact->hardness * wanted);
    const pli_vec3 friction = plii_contact_friction(contact->friction_push, plii_lanes_vec3(sliding),
                                                    1.0f / contact->weight, contact->friction * multiplier);
    const plii_float4 push = n * (multiplier - contact->multiplier) +
                             (plii_lanes_from_vec3(&friction) - plii_lanes_from_vec3(&contact->friction_push)) + shift;
    if (!plii_lanes_xyz_finite(push)) {
        if (is_first) { contact->shift = 0.0f; }
        return;
    }
    couple_push(pair, contact, push, couple_move);
    if (is_first && contact->shift > 0.0f) { couple_push(pair, contact, shift, couple_shift); }
    contact->multiplier = multiplier;
    contact->friction_push = friction;
    couple_record(state, index, push, pair->time);
}

/* What an overlap that went has parted leaves no speed: springs and links that pull nodes back would wind it up from
   step to step. What the shift only held up against loads is no motion, and leaves nothing to take. */
static void couple_settle(const couple_pair* pair, const plii_soft_contacts_state* state, int index) {
    const plii_soft_contact* contact = &state->contacts[index];
    if (!(contact->shift > 0.0f)) { return; }
    const plii_float4 n = plii_lanes_from_vec3(&contact->normal);
    const float along = plii_lanes_dot(n, couple_relative(pair, contact, couple_motion));
    const float parted = plii_min(along, contact->shift);
    if (!(parted > 0.0f)) { return; }
    const plii_float4 push = n * (parted / contact->weight);
    couple_push(pair, contact, push, couple_still);
    couple_record(state, index, -push, pair->time);
}

typedef enum couple_pass { SOFT_COUPLE_FIRST, SOFT_COUPLE_NEXT, SOFT_COUPLE_SETTLE } couple_pass;

/* Contacts with one body come from the first one on and from the middle on in turn: those in a row move the same nodes,
   and each would wait for what the one before it writes. */
static void couple_run(pli_body* body, const plii_soft_contacts_state* state, couple_pass pass) {
    const plii_soft_contact* contacts = state->contacts;
    const plii_substep* substep = body->substep;
    const couple_time time = substep != NULL ? (couple_time){substep, substep->dt, substep->inverse_dt}
                                             : (couple_time){NULL, body->step.dt, body->step.inverse_dt};
    for (int first = 0, end; first < state->count; first = end) {
        pli_body* other = contacts[first].face_body;
        for (end = first; end < state->count && contacts[end].face_body == other;) {
            ++end;
        }
        if (contacts[first].is_bullet) { continue; }
        const couple_pair pair = couple_pair_of(body, other, time);
        const int half = (end - first + 1) / 2;
        for (int k = 0; k < end - first; ++k) {
            const int index = first + k / 2 + k % 2 * half;
            if (pass == SOFT_COUPLE_SETTLE) {
                couple_settle(&pair, state, index);
            } else {
                couple_solve(&pair, state, index, pass == SOFT_COUPLE_FIRST);
            }
        }
    }
}

void plii_soft_contacts_couple(pli_body* body, void* data) {
    plii_soft_contacts_state* state = data;
    const bool is_first = body->substep != NULL ? body->substep->is_first_sweep : !state->has_coupled;
    state->has_coupled = true;
    couple_run(body, state, is_first ? SOFT_COUPLE_FIRST : SOFT_COUPLE_NEXT);
}

void plii_soft_contacts_settle(pli_body* body, void* data) {
    plii_soft_contacts_state* state = data;
    couple_run(body, state, SOFT_COUPLE_SETTLE);
    memset(state->shifts, 0, (size_t)body->node_count * sizeof *state->shifts);
}
