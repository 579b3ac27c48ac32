/* Contacts of nodes with faces of other soft bodies in substeps, C = n . (node - point of the face) - margins >= 0,
   with Coulomb friction. They were found at the predicted positions. Bodies are solved one after the other, so the
   other body takes part by its velocities, as a rigid body does: one that is solved later starts with them, one that is
   done is moved along. */

#include "contact/contact_substep.h"
#include "contact/soft_contacts_impl.h"

struct plii_soft_substep_contact {
    int node;
    pli_body* body; /* of the face */
    int face[3];
    float weights[3];
    pli_vec3 normal;
    pli_vec3 point;    /* of the face, at the start of the step */
    pli_vec3 moved;    /* m, in the substeps before this one */
    float margin;      /* m */
    float coefficient; /* of friction */
    float face_weight; /* inverse of the mass that the face shows, 1/kg */
    /* For one substep. */
    float floor, multiplier;
    pli_vec3 friction;
};

bool plii_soft_substeps_reserve(pli_body* body, plii_soft_substeps* substeps, int count) {
    return PLII_RESERVE(body->context, &substeps->contacts, &substeps->capacity, count);
}

size_t plii_soft_substeps_bytes(const plii_soft_substeps* substeps) {
    return (size_t)substeps->capacity * sizeof *substeps->contacts;
}

void plii_soft_substeps_release(pli_body* body, void* data) {
    plii_soft_substeps* substeps = &((plii_soft_contacts_state*)data)->substeps;
    plii_release(body->context, substeps->contacts, plii_soft_substeps_bytes(substeps));
    *substeps = (plii_soft_substeps){0};
}

// --------------------------------------------------------------------------------------------------------- the face

static pli_vec3 soft_substep_blend(const plii_soft_substep_contact* contact, const pli_vec4* values) {
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    for (int k = 0; k < 3; ++k) {
        sum = pli_vec3_add(sum, pli_vec3_scale(plii_xyz(values[contact->face[k]]), contact->weights[k]));
    }
    return sum;
}

static pli_vec3 soft_substep_motion(const plii_soft_substep_contact* contact, const plii_substep* substep) {
    return pli_vec3_scale(soft_substep_blend(contact, contact->body->velocities), substep->dt);
}

static void soft_substep_push(const pli_body* body, const plii_soft_substep_contact* contact, pli_vec3 push,
                              const plii_substep* substep) {
    plii_substep_move(substep, contact->node, push, 1.0f);
    pli_body* other = contact->body;
    if (plii_body_is_idle(other)) { return; }
    /* One that is done takes the change along into the next step, in which what holds it together acts on it; moved at
       once it would be stretched, and come back with speed. */
    for (int k = 0; k < 3; ++k) {
        const int node = contact->face[k];
        const pli_vec3 change =
            pli_vec3_scale(push, -other->positions[node].w * contact->weights[k] * substep->inverse_dt);
        plii_set_xyz(&other->velocities[node], pli_vec3_add(plii_xyz(other->velocities[node]), change));
        if (other->is_solved) { continue; }
        plii_set_xyz(&other->positions[node],
                     pli_vec3_add(plii_xyz(other->positions[node]), pli_vec3_scale(change, body->step.dt)));
    }
}

// ---------------------------------------------------------------------------------------------------------- solving

static plii_soft_substep_contact soft_substep_make(const pli_body* body, const plii_soft_contact* from) {
    const pli_body* other = from->face_body;
    const int* face = other->topology->faces[from->face];
    plii_soft_substep_contact contact = {.node = from->node,
                                         .body = from->face_body,
                                         .face = {face[0], face[1], face[2]},
                                         .weights = {from->weights.x, from->weights.y, from->weights.z},
                                         .normal = from->normal,
                                         .margin = from->margin,
                                         .coefficient = from->friction};
    for (int k = 0; k < 3; ++k) {
        contact.face_weight +=
            plii_body_is_idle(other) ? 0.0f : other->positions[face[k]].w * contact.weights[k] * contact.weights[k];
    }
    const pli_vec3 before = soft_substep_blend(&contact, other->previous);
    contact.point = before;
    if (other->is_solved) {
        const pli_vec3 velocity = soft_substep_blend(&contact, other->velocities);
        contact.point =
            pli_vec3_sub(soft_substep_blend(&contact, other->positions), pli_vec3_scale(velocity, body->step.dt));
    }
    return contact;
}

static void soft_substep_begin(pli_body* body, void* data) {
    const plii_soft_contacts_state* found = data;
    plii_soft_substeps* state = &((plii_soft_contacts_state*)data)->substeps;
    const bool has_room = plii_soft_substeps_reserve(body, state, found->count);
    state->count = has_room ? found->count : state->capacity; /* those without room are left out in this step */
    for (int i = 0; i < state->count; ++i) {
        state->contacts[i] = soft_substep_make(body, &found->contacts[i]);
    }
}

static void soft_substep_restart(pli_body* body, void* data, const plii_substep* substep) {
    const plii_soft_contacts_state* found = data;
    const plii_soft_substeps* state = &found->substeps;
    const float recovery_speed = plii_contact_recovery_speed(found->def.recovery_speed);
    for (int i = 0; i < state->count; ++i) {
        plii_soft_substep_contact* contact = &state->contacts[i];
        if (substep->index > 0) {
            contact->moved = pli_vec3_add(contact->moved, soft_substep_motion(contact, substep));
        }
        const pli_vec3 node = pli_vec3_add(plii_xyz(body->positions[contact->node]),
                                           plii_xyz(substep->start_displacements[contact->node]));
        const pli_vec3 point = pli_vec3_add(contact->point, contact->moved);
        const float gap = pli_vec3_dot(contact->normal, pli_vec3_sub(node, point)) - contact->margin;
        const float mobility = substep->displacements[contact->node].w;
        /* What a node that is fast keeps beyond the margins is no overlap. */
        const float beyond = contact->margin - body->collision_margin - contact->body->collision_margin;
        const float above = gap + plii_max(0.0f, beyond), share = mobility / (mobility + contact->face_weight);
        const float left = plii_contact_recover(substep, contact->node, contact->normal, above, share, recovery_speed);
        const float parted = left - plii_min(above, 0.0f);
        contact->floor = plii_min(gap + parted, 0.0f);
        contact->multiplier = 0.0f;
        contact->friction = pli_vec3_make(0, 0, 0);
    }
}

static void soft_substep_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const plii_soft_contacts_state* found = data;
    const plii_soft_substeps* state = &found->substeps;
    const float alpha = found->def.compliance * substep->inverse_dt * substep->inverse_dt;
    for (int i = 0; i < state->count; ++i) {
        plii_soft_substep_contact* contact = &state->contacts[i];
        const pli_vec3 n = contact->normal;
        const float weight = substep->displacements[contact->node].w + contact->face_weight;
        const pli_vec3 point =
            pli_vec3_add(pli_vec3_add(contact->point, contact->moved), soft_substep_motion(contact, substep));
        const float gap =
            pli_vec3_dot(n, pli_vec3_sub(plii_substep_position(body, substep, contact->node), point)) - contact->margin;
        const float change = plii_contact_multiplier(gap - contact->floor, weight, alpha, contact->multiplier);
        const float multiplier = plii_max(0.0f, contact->multiplier + change);
        soft_substep_push(body, contact, pli_vec3_scale(n, multiplier - contact->multiplier), substep);
        contact->multiplier = multiplier;

        const pli_vec3 motion =
            pli_vec3_sub(plii_substep_motion(substep, contact->node), soft_substep_motion(contact, substep));
        const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, pli_vec3_dot(motion, n)));
        if (!(weight > 0.0f)) { continue; }
        const pli_vec3 friction =
            plii_contact_friction(contact->friction, sliding, weight, contact->coefficient * contact->multiplier);
        if (!plii_vec3_is_finite(friction)) { continue; }
        soft_substep_push(body, contact, pli_vec3_sub(friction, contact->friction), substep);
        contact->friction = friction;
    }
    for (int i = 0; substep->is_last_sweep && i < state->count && i < found->impulse_count; ++i) {
        const plii_soft_substep_contact* contact = &state->contacts[i];
        const pli_vec3 push = pli_vec3_add(pli_vec3_scale(contact->normal, contact->multiplier), contact->friction);
        plii_contact_impulses_push(&found->impulses, i, pli_vec3_scale(push, substep->inverse_dt));
    }
}

// ------------------------------------------------------------------------------------------------- taking part

static bool soft_substep_is_idle(const pli_body* body, const void* data) {
    (void)body;
    return ((const plii_soft_contacts_state*)data)->substeps.count == 0;
}

enum { SOFT_SUBSTEP_ORDER = 70 }; /* after rigid bodies */

const plii_substep_class plii_soft_contacts_substepped = {
    .order = SOFT_SUBSTEP_ORDER,
    .klass = &plii_soft_contacts_class,
    .begin = soft_substep_begin,
    .restart = soft_substep_restart,
    .sweep = soft_substep_sweep,
    .is_idle = soft_substep_is_idle,
    .leave = plii_soft_substeps_release,
};
