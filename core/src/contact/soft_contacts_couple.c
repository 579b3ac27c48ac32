/* The solve of contacts of nodes with the faces of another soft body, C = n . (node - point of the face) - margins >= 0
   with Coulomb friction, by all solvers outside of reference mode. It runs after the sweeps of all bodies that are
   solved side by side, so that contacts have the last word, and moves both. A body with another solver or other
   substeps is solved before or after: it takes part by its velocities, as a rigid body does. */

#include "contact/soft_contacts_impl.h"

/* A body of contacts. Its nodes have moved by along * moves - before * starts in the step or substep; in a substep they
   are at positions + here * moves. Shifts took overlaps back: as if nodes had started so much farther. */
typedef struct couple_side {
    pli_body* body;
    const pli_vec4* positions;
    pli_vec4 *moves, *starts;
    pli_vec3* shifts; /* may be NULL */
    float here, along, before;
    float rate; /* of its time against that of the body that is solved: each has a step of its own */
    bool is_beside;
} couple_side;

static couple_side couple_side_of(pli_body* body, bool is_beside, const plii_substep* substep, float rate) {
    couple_side side = {.body = body,
                        .positions = body->positions,
                        .moves = body->positions,
                        .starts = body->previous,
                        .shifts = body->soft_shifts,
                        .along = 1.0f,
                        .before = 1.0f,
                        .rate = rate,
                        .is_beside = is_beside};
    if (substep->is_absolute) { return side; }
    if (body->substep != NULL) {
        side.moves = body->substep->displacements;
        side.starts = body->substep->start_displacements;
        side.here = 1.0f;
    } else { /* it is, or will be, at its positions at the end of the step */
        side.moves = body->velocities;
        side.here = -substep->remaining * rate;
        side.along = substep->dt * rate;
        side.before = 0.0f;
    }
    return side;
}

/* Contacts of one body with another one. */
typedef struct couple_pair {
    couple_side node, face;
    bool is_idle;         /* the one of the faces: it does not move */
    plii_substep substep; /* of the body that is solved, or its whole step */
} couple_pair;

static couple_pair couple_pair_of(pli_body* body, pli_body* other) {
    const plii_substep substep =
        body->substep != NULL ? *body->substep : plii_substep_of_step(body, body->positions, body->previous);
    const bool is_beside = body->island != NULL && other->island == body->island;
    const float rate = is_beside ? 1.0f : other->step.dt / body->step.dt;
    return (couple_pair){.node = couple_side_of(body, true, &substep, 1.0f),
                         .face = couple_side_of(other, is_beside, &substep, rate),
                         .is_idle = plii_body_is_idle(other),
                         .substep = substep};
}

/* `is_beside`: known to be, where factors are 1. */
typedef plii_float4 couple_quantity(const couple_side* side, int node, bool is_beside);

PLII_SIMD_INLINE plii_float4 couple_times(const pli_vec4* record, float factor, bool is_beside) {
    return is_beside ? plii_float4_from(record) : plii_float4_from(record) * factor;
}
PLII_SIMD_INLINE plii_float4 couple_place(const couple_side* side, int node, bool is_beside) {
    return plii_float4_from(&side->positions[node]) + couple_times(&side->moves[node], side->here, is_beside);
}
PLII_SIMD_INLINE plii_float4 couple_moved(const couple_side* side, int node, bool is_beside) {
    return couple_times(&side->moves[node], side->along, is_beside);
}
PLII_SIMD_INLINE plii_float4 couple_plain_start(const couple_side* side, int node, bool is_beside) {
    return couple_times(&side->starts[node], side->before, is_beside);
}
/* With shifts. */
PLII_SIMD_INLINE plii_float4 couple_start(const couple_side* side, int node, bool is_beside) {
    const plii_float4 start = couple_plain_start(side, node, is_beside);
    return side->shifts != NULL ? start + plii_lanes_from_vec3(&side->shifts[node]) : start;
}

/* Of the node against the point of the face; w: 0. By differences, which far from the origin are more exact. */
PLII_SIMD_INLINE plii_float4 couple_relative(const couple_pair* pair, const plii_soft_contact* contact,
                                             couple_quantity* of, bool is_beside) {
    const int* face = pair->face.body->topology->faces[contact->face];
    const plii_float4 node = of(&pair->node, contact->node, is_beside);
    return plii_lanes_xyz((node - of(&pair->face, face[0], is_beside)) * contact->weights.x +
                          (node - of(&pair->face, face[1], is_beside)) * contact->weights.y +
                          (node - of(&pair->face, face[2], is_beside)) * contact->weights.z);
}

/* Whole records: a load of one would wait for parts of it that are on their way to memory. */
PLII_SIMD_INLINE void couple_add(pli_vec4* to, plii_float4 by) {
    plii_float4_to(to, plii_float4_from(to) + by);
}

/* A body that is not solved side by side is where its velocity leads to. */
static void couple_accelerate(const couple_side* side, int node, plii_float4 by, const plii_substep* substep) {
    const float left = substep->dt + substep->remaining;
    couple_add(&side->body->velocities[node], by * (substep->inverse_dt / side->rate));
    couple_add(&side->body->positions[node], by * substep->inverse_dt * left);
}

typedef void couple_effect(const couple_side* side, int node, plii_float4 by, const plii_substep* substep,
                           bool is_beside);

PLII_SIMD_INLINE void couple_move(const couple_side* side, int node, plii_float4 by, const plii_substep* substep,
                                  bool is_beside) {
    if (is_beside || side->is_beside) {
        couple_add(&side->moves[node], by);
    } else {
        couple_accelerate(side, node, by, substep);
    }
}

/* The solve takes as much for the start of the node. */
PLII_SIMD_INLINE void couple_shift(const couple_side* side, int node, plii_float4 by, const plii_substep* substep,
                                   bool is_beside) {
    if (!(is_beside || side->is_beside) || side->shifts == NULL) { return; }
    plii_lanes_to_vec3(&side->shifts[node], plii_lanes_from_vec3(&side->shifts[node]) + by);
}

/* As if the node had started there, so that no velocity comes of it. */
PLII_SIMD_INLINE void couple_still(const couple_side* side, int node, plii_float4 by, const plii_substep* substep,
                                   bool is_beside) {
    if (!side->is_beside) { couple_accelerate(side, node, -by, substep); }
    couple_add(&side->starts[node], by);
}

/* `push` in kg m; w: 0 */
PLII_SIMD_INLINE void couple_push(const couple_pair* pair, const plii_soft_contact* contact, plii_float4 push,
                                  couple_effect effect, bool is_beside) {
    const couple_side *node = &pair->node, *others = &pair->face;
    const int* face = others->body->topology->faces[contact->face];
    effect(node, contact->node, push * node->positions[contact->node].w, &pair->substep, is_beside);
    if (pair->is_idle) { return; }
    const plii_float4 back = -push;
    effect(others, face[0], back * (others->positions[face[0]].w * contact->weights.x), &pair->substep, is_beside);
    effect(others, face[1], back * (others->positions[face[1]].w * contact->weights.y), &pair->substep, is_beside);
    effect(others, face[2], back * (others->positions[face[2]].w * contact->weights.z), &pair->substep, is_beside);
}

PLII_SIMD_INLINE void couple_record(const plii_soft_contacts_state* state, int index, plii_float4 push,
                                    const plii_substep* substep) {
    if (index >= state->impulse_count) { return; }
    plii_contact_impulses_push(&state->impulses, index, plii_lanes_vec3(push * substep->inverse_dt));
}

/* s; overlaps go as if a spring with a dashpot drew them out. A few sweeps leave nodes of a pile a little too deep in
   each step, and what drew them out at once would make them tremble for ever. */
#define SOFT_COUPLE_RECOVERY_TIME (1.0f / 15.0f)

/* Starts are known once all bodies had their first sweep; the implicit solver has two in a row of each. */
typedef enum couple_sweep { SOFT_COUPLE_FIRST, SOFT_COUPLE_NEXT, SOFT_COUPLE_LATER } couple_sweep;
/* Once for any number of contacts, or for one and for four, which are all of bodies beside each other. */
#if defined(__OPTIMIZE_SIZE__)
enum { SOFT_COUPLE_BESIDE = PLII_LANES + 1 };
#else
enum { SOFT_COUPLE_BESIDE = PLII_LANES };
#endif

/* What draws overlaps out, m, in the first sweep only, so that overlaps that contradict each other do not drive each
   other on from sweep to sweep. What a fast node keeps beyond the margins is none. */
PLII_SIMD_INLINE plii_float4 couple_recovery(const couple_pair* pair, const plii_soft_contacts_state* state,
                                             plii_float4 margin, plii_float4 gap, plii_float4 along) {
    const plii_float4 zero = plii_float4_all(0.0f);
    const plii_float4 beyond = margin - pair->node.body->collision_margin - pair->face.body->collision_margin;
    const plii_float4 depth = plii_lanes_max(zero, along - gap - plii_lanes_max(zero, beyond));
    const float share = pair->substep.dt / (pair->substep.dt + SOFT_COUPLE_RECOVERY_TIME);
    const float fastest = plii_contact_recovery_speed(state->def.recovery_speed) * pair->substep.dt;
    const plii_float4 most = plii_lanes_min(depth * share, plii_float4_all(fastest));
    return plii_lanes_min(plii_lanes_max(most - along, zero), most);
}

/* What contacts keep in records from sweep to sweep, by components: of one contact in its own, in the first lane; of
   four that are solved at once each has the component of its number. */
PLII_SIMD_SHARED void couple_load(plii_soft_contact* const* of, int count, size_t at, plii_float4 components[4]) {
    PLII_UNROLL(4)
    for (int k = 0; k < count; ++k) {
        memcpy(&components[k], (const char*)of[k] + at, sizeof components[k]);
    }
    if (count == 1) { plii_float4_transpose(components); }
}
PLII_SIMD_SHARED void couple_store(plii_soft_contact* const* of, int count, size_t at,
                                   const plii_float4 components[4]) {
    plii_float4 records[4] = {components[0], components[1], components[2], components[3]};
    if (count == 1) { plii_float4_transpose(records); }
    PLII_UNROLL(4)
    for (int k = 0; k < count; ++k) {
        memcpy((char*)of[k] + at, &records[k], sizeof records[k]);
    }
}

/* Of one contact, in the first lane, or of four that share no node. */
PLII_SIMD_SHARED void couple_solve(const couple_pair* pair, const plii_soft_contacts_state* state, const int* indices,
                                   int count, couple_sweep sweep) {
    const plii_float4 zero = plii_float4_all(0.0f);
    const bool is_first = sweep == SOFT_COUPLE_FIRST, is_substep = !pair->substep.is_absolute;
    const bool is_beside = count == SOFT_COUPLE_BESIDE;
    plii_soft_contact* of[PLII_LANES];
    plii_float4 places[4] = {zero}, motions[4] = {zero}, normals[4] = {zero}, sums[4] = {zero}, starts[4] = {zero};
    PLII_UNROLL(4)
    for (int k = 0; k < count; ++k) {
        plii_soft_contact* contact = of[k] = &state->contacts[indices[k]];
        if (sweep == SOFT_COUPLE_NEXT) { starts[k] = couple_relative(pair, contact, couple_start, is_beside); }
        places[k] = is_substep ? couple_relative(pair, contact, couple_place, is_beside)
                               : couple_relative(pair, contact, couple_moved, is_beside);
        normals[k] = plii_float4_load(&contact->normal.x);
        if (is_first) { contact->shift = 0.0f; }
    }
    if (sweep == SOFT_COUPLE_NEXT) {
        plii_float4_transpose(starts);
        couple_store(of, count, offsetof(plii_soft_contact, start), starts);
    }
    plii_float4_transpose(places);
    plii_float4_transpose(normals);
    couple_load(of, count, offsetof(plii_soft_contact, friction_push), sums);
    const plii_vec3x4 n = {normals[0], normals[1], normals[2]}, rubbed = {sums[0], sums[1], sums[2]};
    const plii_float4 margin = normals[3], pushed = sums[3];
    plii_float4 gap = plii_vec3x4_dot(n, (plii_vec3x4){places[0], places[1], places[2]}) - margin;
    const plii_mask4 is_active = (pushed != 0.0f) | ~(gap >= 0.0f);
    if (plii_lanes_bits(is_active) == 0) { return; }
    PLII_UNROLL(4)
    for (int k = 0; k < count; ++k) {
        if (is_substep) { motions[k] = couple_relative(pair, of[k], couple_moved, is_beside); }
        if (is_first) { starts[k] = couple_relative(pair, of[k], couple_start, is_beside); }
    }
    if (is_first) { plii_float4_transpose(starts); }
    if (sweep == SOFT_COUPLE_LATER) { couple_load(of, count, offsetof(plii_soft_contact, start), starts); }
    if (is_substep) { plii_float4_transpose(motions); }
    PLII_UNROLL(3)
    for (int k = 0; k < 3; ++k) {
        motions[k] = (is_substep ? motions[k] : places[k]) - starts[k];
    }
    const plii_vec3x4 motion = {motions[0], motions[1], motions[2]};
    const plii_float4 weight =
        plii_lanes_xyzw(of[0]->weight, of[1 % count]->weight, of[2 % count]->weight, of[3 % count]->weight);
    plii_float4 along = plii_vec3x4_dot(n, motion), shift = zero;
    const plii_vec3x4 sliding = plii_vec3x4_sub(motion, plii_vec3x4_scale(n, along));
    if (is_first) {
        shift = couple_recovery(pair, state, margin, gap, along);
        /* To what is not beside it is a motion. */
        if (!pair->face.is_beside) { along += shift * (1.0f - pair->node.positions[of[0]->node].w / weight); }
        gap += shift;
    }
    const float alpha = state->def.compliance * pair->substep.inverse_dt * pair->substep.inverse_dt;
    const plii_float4 wanted = (plii_lanes_min(gap - along, zero) - gap - alpha * pushed) / (weight + alpha);
    plii_float4 multiplier = plii_lanes_max(pushed + of[0]->hardness * wanted, zero);
    plii_vec3x4 friction = plii_vec3x4_sub(rubbed, plii_vec3x4_scale(sliding, 1.0f / weight));
    const plii_float4 limit = of[0]->friction * multiplier;
    const plii_float4 length = plii_float4_sqrt(plii_vec3x4_dot(friction, friction));
    friction = plii_vec3x4_scale(friction, plii_lanes_select(length > limit, limit / length, plii_float4_all(1.0f)));
    const plii_mask4 is_solved = is_active & plii_lanes_finite(length + multiplier);
    multiplier = plii_lanes_select(is_solved, multiplier, pushed);
    friction = plii_vec3x4_select(is_solved, friction, rubbed);
    shift = plii_lanes_where(is_solved, shift);
    const plii_float4 parted = is_first ? shift / weight : zero;
    const plii_vec3x4 push =
        plii_vec3x4_add(plii_vec3x4_scale(n, multiplier - pushed + parted), plii_vec3x4_sub(friction, rubbed));
    const plii_float4 next[4] = {friction.x, friction.y, friction.z, multiplier};
    couple_store(of, count, offsetof(plii_soft_contact, friction_push), next);
    plii_float4 pushes[4] = {push.x, push.y, push.z, zero};
    plii_float4_transpose(pushes);
    PLII_UNROLL(4)
    for (int k = 0; k < count; ++k) {
        couple_push(pair, of[k], pushes[k], couple_move, is_beside);
        couple_record(state, indices[k], pushes[k], &pair->substep);
        if (!is_first || !(shift[k] > 0.0f)) { continue; }
        of[k]->shift = shift[k];
        couple_push(pair, of[k], plii_lanes_from_vec3(&of[k]->normal) * parted[k], couple_shift, is_beside);
    }
}

/* What an overlap that went has parted leaves no speed: springs and links that pull nodes back would wind it up from
   step to step. What the shift only held up against loads is no motion, and leaves nothing to take. Returns what was
   taken, m. */
static float couple_settle(const couple_pair* pair, const plii_soft_contacts_state* state, int index) {
    plii_soft_contact* contact = &state->contacts[index];
    const float shift = contact->shift;
    if (!(shift > 0.0f)) { return 0.0f; }
    const plii_float4 n = plii_lanes_from_vec3(&contact->normal);
    const float along = plii_lanes_dot(n, couple_relative(pair, contact, couple_moved, false) -
                                              couple_relative(pair, contact, couple_plain_start, false));
    const float parted = plii_min(along, shift);
    if (!(parted > 0.0f)) { return 0.0f; }
    contact->shift -= parted;
    const plii_float4 push = n * (parted / contact->weight);
    couple_push(pair, contact, push, couple_still, false);
    couple_record(state, index, -push, &pair->substep);
    return parted;
}

/* No node is in two of them; the two bodies have nodes of their own. */
static bool couple_is_apart(const plii_soft_contacts_state* state, const int* indices) {
    plii_mask4 nodes[PLII_LANES], is_same = {0};
    for (int k = 0; k < PLII_LANES; ++k) {
        const plii_soft_contact* contact = &state->contacts[indices[k]];
        const int* face = contact->face_body->topology->faces[contact->face];
        nodes[k] = (plii_mask4){face[0], face[1], face[2], ~contact->node};
        for (int i = 0; i < k; ++i) {
            is_same |= (nodes[k] == nodes[i]) | (nodes[k] == PLII_SHUFFLE(nodes[i], nodes[i], 1, 2, 0, 3)) |
                       (nodes[k] == PLII_SHUFFLE(nodes[i], nodes[i], 2, 0, 1, 3));
        }
    }
    return plii_lanes_bits(is_same) == 0;
}

/* Contacts with one body come from four places in turn: those in a row move the same nodes. */
void plii_soft_contacts_couple(pli_body* body, void* data) {
    plii_soft_contacts_state* state = data;
    plii_soft_contact* contacts = state->contacts;
    const bool is_new = state->sweeps == 0;
    if (is_new) { plii_soft_contacts_keep_nearest(body, state); }
    couple_sweep sweep = state->sweeps > 2 ? SOFT_COUPLE_LATER : is_new ? SOFT_COUPLE_FIRST : SOFT_COUPLE_NEXT;
    if (body->substep != NULL) { sweep = body->substep->is_first_sweep ? SOFT_COUPLE_FIRST : SOFT_COUPLE_NEXT; }
    state->sweeps += 1;
    for (int first = 0, end; first < state->count; first = end) {
        pli_body* other = contacts[first].face_body;
        for (end = first; end < state->count && contacts[end].face_body == other;) {
            ++end;
        }
        if (contacts[first].is_bullet) { continue; }
        const couple_pair pair = couple_pair_of(body, other);
        const int part = (end - first + PLII_LANES - 1) / PLII_LANES;
        for (int k = first; k < first + part; ++k) {
            int indices[PLII_LANES], count = 0;
            for (int index = k; index < end; index += part) {
                indices[count++] = index;
            }
            if (is_new) {
                contacts[k].is_grouped = pair.face.is_beside && count == PLII_LANES && couple_is_apart(state, indices);
            }
            const bool is_grouped = contacts[k].is_grouped;
            if (is_grouped) { couple_solve(&pair, state, indices, PLII_LANES, sweep); }
            for (int i = 0; !is_grouped && i < count; ++i) {
                couple_solve(&pair, state, &indices[i], 1, sweep);
            }
        }
    }
}

/* Of the shifts of a body; in piles 0.002 are taken, of bodies that part half and more. */
#define SOFT_COUPLE_PARTING_SHARE 0.1f

void plii_soft_contacts_settle(pli_body* body, void* data) {
    plii_soft_contacts_state* state = data;
    couple_pair pair = {0};
    float taken = 0.0f, shifts = 0.0f;
    for (int i = 0; i < state->count; ++i) {
        pli_body* other = state->contacts[i].face_body;
        if (other != pair.face.body) { pair = couple_pair_of(body, other); }
        shifts += state->contacts[i].shift;
        taken += couple_settle(&pair, state, i);
        /* As all sums at the start of another substep. */
        plii_float4_store(&state->contacts[i].friction_push.x, plii_float4_all(0.0f));
    }
    body->is_parting = taken > SOFT_COUPLE_PARTING_SHARE * shifts;
    memset(state->shifts, 0, (size_t)body->node_count * sizeof *state->shifts);
}
