/* Contacts of nodes with faces of other soft bodies as inequalities on positions, C = n . (node - point of the face) -
   margins >= 0, with Coulomb friction; in iterations and in substeps alike. Bodies with contacts are solved in turn, so
   a contact moves the nodes of both sides as by one impulse, from which all velocities follow. */

#include "math/simd_float4.h"

#include "body/pipeline.h"
#include "contact/contact_substep.h"
#include "contact/soft_contacts_impl.h"

/* An overlap goes at this rate, 1/s, of which so much of the margins counts: faster, bodies whose layers have got into
   each other are heated up by it. */
#define SOFT_CONTACTS_RECOVERY 30.0f
#define SOFT_CONTACTS_RECOVERY_DEPTH 0.05f

// ------------------------------------------------------------------------------------------------- both sides of a
// pair

/* Where the nodes of a body are, and were at the start of the interval that it is solved in: the step or a substep. */
typedef struct soft_motion {
    pli_vec4 *now, *start;
    const pli_vec4* base; /* what both are relative to, or NULL */
    float ratio;          /* the shorter interval of the pair to this one */
    float fraction;       /* of this interval, that had passed when the shorter one began */
} soft_motion;

typedef struct soft_pair {
    const pli_body* face_body; /* NULL: none yet */
    soft_motion node, face;
} soft_pair;

static soft_motion soft_motion_of(const pli_body* body, const pli_body* other) {
    const plii_substep *substep = body->substep, *others = other->substep;
    const float parts = substep != NULL ? (float)substep->count : 1.0f;
    const float other_parts = others != NULL ? (float)others->count : 1.0f;
    soft_motion motion = {
        .now = substep != NULL ? substep->displacements : body->positions,
        .start = substep != NULL ? substep->start_displacements : body->previous,
        .base = substep != NULL ? body->positions : NULL,
        .ratio = 1.0f,
    };
    if (parts < other_parts) {
        const float time = substep != NULL ? (float)substep->index / parts : 0.0f;
        motion.ratio = parts / other_parts;
        motion.fraction = ((float)others->index / other_parts - time) * parts;
    }
    return motion;
}

static void soft_pair_set(soft_pair* pair, const pli_body* body, const pli_body* face_body) {
    if (pair->face_body == face_body) { return; }
    *pair = (soft_pair){face_body, soft_motion_of(body, face_body), soft_motion_of(face_body, body)};
}

PLII_SIMD_INLINE plii_float4 soft_motion_moved(const soft_motion* motion, int node) {
    return plii_float4_sub(plii_float4_from(&motion->now[node]), plii_float4_from(&motion->start[node]));
}

/* m, when the shorter interval began */
PLII_SIMD_INLINE plii_float4 soft_motion_begin(const soft_motion* motion, int node) {
    const plii_float4 start = plii_float4_from(&motion->start[node]);
    if (motion->base != NULL) { return plii_float4_add(plii_float4_from(&motion->base[node]), start); }
    const plii_float4 moved = plii_float4_sub(plii_float4_from(&motion->now[node]), start);
    return plii_float4_add(start, plii_float4_mul(moved, plii_float4_all(motion->fraction)));
}

/* `push` has no w, which stays. */
PLII_SIMD_INLINE void soft_motion_push(const soft_motion* motion, int node, plii_float4 push, float inverse_mass) {
    const plii_float4 way = plii_float4_mul(push, plii_float4_all(inverse_mass / motion->ratio));
    plii_float4_to(&motion->now[node], plii_float4_add(plii_float4_from(&motion->now[node]), way));
}

// ------------------------------------------------------------------------------------------------------------ a
// contact

static void soft_contact_start(plii_soft_contact* contact, const soft_pair* pair, float dt, float most) {
    const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
    plii_float4 apart = soft_motion_begin(&pair->node, contact->node);
    for (int k = 0; k < 3; ++k) {
        apart = plii_float4_sub(
            apart, plii_float4_mul(soft_motion_begin(&pair->face, contact->corners[k]), plii_float4_all(weights[k])));
    }
    const float gap = plii_lanes_dot(apart, plii_float4_from(&contact->normal)) - contact->margin;
    const float depth = plii_min(-gap, SOFT_CONTACTS_RECOVERY_DEPTH * contact->margin);
    contact->gap = gap;
    if (contact->is_inherited) { most = 0.0f; }
    contact->floor = gap < 0.0f ? gap + plii_min(most, depth * SOFT_CONTACTS_RECOVERY * dt) : 0.0f;
    contact->push = 0.0f;
    contact->friction_push = (pli_vec4){0};
}

/* `share`: of the error that goes; `alpha`: compliance / dt^2. */
static void soft_contact_solve(plii_soft_contact* contact, const soft_pair* pair, float share, float alpha) {
    const float weights[3] = {contact->weights.x, contact->weights.y, contact->weights.z};
    plii_float4 point =
        plii_float4_mul(soft_motion_moved(&pair->face, contact->corners[0]), plii_float4_all(weights[0]));
    for (int k = 1; k < 3; ++k) {
        point = plii_float4_add(
            point, plii_float4_mul(soft_motion_moved(&pair->face, contact->corners[k]), plii_float4_all(weights[k])));
    }
    const plii_float4 motion = plii_float4_sub(
        plii_float4_mul(soft_motion_moved(&pair->node, contact->node), plii_float4_all(pair->node.ratio)),
        plii_float4_mul(point, plii_float4_all(pair->face.ratio)));
    const plii_float4 n = plii_float4_from(&contact->normal);
    const float along_normal = plii_lanes_dot(motion, n), weight = contact->weight;
    const float error = contact->gap + along_normal - contact->floor;
    if (error >= 0.0f && contact->push == 0.0f) { return; }
    const float change = share * plii_contact_multiplier(error, weight, alpha, contact->push);
    const float push = plii_max(0.0f, contact->push + change);
    plii_float4 total = plii_float4_mul(n, plii_float4_all(push - contact->push));
    contact->push = push;

    pli_vec3 sliding;
    plii_lanes_to_vec3(&sliding, plii_float4_sub(motion, plii_float4_mul(n, plii_float4_all(along_normal))));
    const pli_vec3 friction =
        plii_contact_friction(plii_xyz(contact->friction_push), sliding, weight, contact->friction * push);
    if (plii_vec3_is_finite(friction)) {
        const plii_float4 before = plii_float4_from(&contact->friction_push);
        const plii_float4 after = plii_lanes_xyzw(friction.x, friction.y, friction.z, 0.0f);
        plii_float4_to(&contact->friction_push, after);
        total = plii_float4_add(total, plii_float4_sub(after, before));
    }
    soft_motion_push(&pair->node, contact->node, total, contact->inverse_masses.w);
    soft_motion_push(&pair->face, contact->corners[0], total, -contact->inverse_masses.x);
    soft_motion_push(&pair->face, contact->corners[1], total, -contact->inverse_masses.y);
    soft_motion_push(&pair->face, contact->corners[2], total, -contact->inverse_masses.z);
}

static void soft_contacts_sweep(pli_body* body, plii_soft_contacts_state* state, float dt, float share, float alpha) {
    const bool are_new = state->has_new_contacts;
    const float most = plii_contact_recovery_speed(state->def.recovery_speed) * dt;
    soft_pair pair = {0};
    state->has_new_contacts = false;
    for (int i = 0; i < state->count; ++i) {
        plii_soft_contact* contact = &state->contacts[i];
        if (contact->is_reference) { continue; }
        soft_pair_set(&pair, body, contact->face_body);
        /* What is solved in shorter intervals has gone on since the last iteration. */
        if (are_new || pair.node.ratio < 1.0f) { soft_contact_start(contact, &pair, dt, most); }
        soft_contact_solve(contact, &pair, share, alpha);
    }
}

void plii_soft_contacts_solve(pli_body* body, void* data, const plii_step* step) {
    plii_soft_contacts_state* state = data;
    soft_contacts_sweep(body, state, step->dt, state->def.hardness, 0.0f);
}

// -------------------------------------------------------------------------------------------------------- as a whole

/* Share of an overlap that goes per step. */
#define SOFT_CONTACTS_PARTED 0.1f

/* Where the last step left a node. Bodies are predicted from the last one to the first. */
static const pli_vec4* soft_contacts_left(const pli_body* body, const pli_body* other) {
    return other->world_index >= body->world_index ? other->previous : other->positions;
}

/* What the other body is to be moved by comes when its turn does. */
static void soft_contact_part(const pli_body* body, plii_soft_contacts_state* state, const plii_soft_contact* contact,
                              float most) {
    pli_body* other = contact->face_body;
    plii_soft_contacts_state* other_state = plii_feature_state(other, &plii_soft_contacts_class);
    if (other_state == NULL || other->is_frozen) { return; }
    const pli_vec3 n = plii_xyz(contact->normal);
    const pli_vec3 point =
        plii_soft_contacts_blend(soft_contacts_left(body, other), contact->corners, plii_xyz(contact->weights));
    const float distance = pli_vec3_dot(n, pli_vec3_sub(plii_xyz(body->previous[contact->node]), point));
    const float wanted = plii_min((contact->margin - distance) * SOFT_CONTACTS_PARTED, most);
    const float missing = wanted - pli_vec3_dot(n, pli_vec3_sub(state->shift, other_state->shift));
    const float share = state->surface.inverse_mass, other_share = other_state->surface.inverse_mass;
    if (!(missing > 0.0f) || !(share + other_share > 0.0f)) { return; }
    const pli_vec3 push = pli_vec3_scale(n, missing / (share + other_share));
    state->shift = pli_vec3_add(state->shift, pli_vec3_scale(push, share));
    other_state->shift = pli_vec3_sub(other_state->shift, pli_vec3_scale(push, other_share));
}

void plii_soft_contacts_part(pli_body* body, plii_soft_contacts_state* state) {
    const float most = plii_contact_recovery_speed(state->def.recovery_speed) * body->step.dt;
    for (int i = 0; i < state->count; ++i) {
        if (state->contacts[i].is_inherited) { soft_contact_part(body, state, &state->contacts[i], most); }
    }
    const pli_vec3 shift = state->shift;
    state->shift = pli_vec3_make(0, 0, 0);
    if (plii_vec3_is_zero(shift) || !plii_vec3_is_finite(shift)) { return; }
    for (int i = 0; i < body->node_count; ++i) {
        plii_set_xyz(&body->positions[i], pli_vec3_add(plii_xyz(body->positions[i]), shift));
        plii_set_xyz(&body->previous[i], pli_vec3_add(plii_xyz(body->previous[i]), shift));
    }
}

// ------------------------------------------------------------------------------------------------------------ substeps

static void soft_substep_restart(pli_body* body, void* data, const plii_substep* substep) {
    (void)body;
    (void)substep;
    ((plii_soft_contacts_state*)data)->has_new_contacts = true;
}

static void soft_substep_sweep(pli_body* body, void* data, const plii_substep* substep) {
    plii_soft_contacts_state* state = data;
    const float alpha = state->def.compliance * substep->inverse_dt * substep->inverse_dt;
    soft_contacts_sweep(body, state, substep->dt, 1.0f, alpha);
}

static bool soft_substep_is_idle(const pli_body* body, const void* data) {
    (void)body;
    return ((const plii_soft_contacts_state*)data)->count == 0;
}

enum { SOFT_SUBSTEP_ORDER = 70 }; /* after rigid bodies */

const plii_substep_class plii_soft_contacts_substepped = {
    .order = SOFT_SUBSTEP_ORDER,
    .klass = &plii_soft_contacts_class,
    .restart = soft_substep_restart,
    .sweep = soft_substep_sweep,
    .is_idle = soft_substep_is_idle,
};
