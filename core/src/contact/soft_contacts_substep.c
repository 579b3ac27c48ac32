/* XPBD: contacts of nodes with faces of other soft bodies, C = n . (node - point of the face) - margins >= 0, with
   Coulomb friction. Contacts are those that pli_body_enable_soft_contacts found at the predicted positions. Bodies are
   solved one after the other, so the other body takes part by its velocities, as a rigid body does: one that is solved
   later starts with them, one that is done is moved along. */

#include "contact/contact_substep.h"
#include "pliant/contact.h"

typedef struct xpbd_soft_contact {
    int node;
    pli_body* body; /* of the face */
    int face[3];
    float weights[3];
    pli_vec3 normal;
    pli_vec3 point;    /* of the face, at the start of the step */
    pli_vec3 moved;    /* m, in the substeps before this one */
    float margin;      /* m */
    float face_weight; /* inverse of the mass that the face shows, 1/kg */
    /* For one substep. */
    float floor, multiplier;
    pli_vec3 friction;
} xpbd_soft_contact;

typedef struct xpbd_soft_contacts_state {
    pli_xpbd_contacts_def def;
    pli_soft_contact* found;
    int found_capacity;
    xpbd_soft_contact* contacts;
    int count, capacity;
} xpbd_soft_contacts_state;

static bool xpbd_soft_contacts_reserve(pli_body* body, xpbd_soft_contacts_state* state) {
    const int count = pli_body_get_soft_contacts(body, 0, NULL);
    return PLII_RESERVE(body->context, &state->found, &state->found_capacity, count) &&
           PLII_RESERVE(body->context, &state->contacts, &state->capacity, count);
}

/* Comes after the search, which was enabled before; for both bodies. */
static pli_status xpbd_soft_contacts_collide(pli_body* body, void* data, pli_body* other, void* other_data) {
    const bool has_room = xpbd_soft_contacts_reserve(body, data) && xpbd_soft_contacts_reserve(other, other_data);
    return has_room ? PLI_OK : PLI_ERROR_OUT_OF_MEMORY;
}

// --------------------------------------------------------------------------------------------------------- the face

static pli_vec3 xpbd_soft_contact_blend(const xpbd_soft_contact* contact, const pli_vec4* values) {
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    for (int k = 0; k < 3; ++k) {
        sum = pli_vec3_add(sum, pli_vec3_scale(plii_xyz(values[contact->face[k]]), contact->weights[k]));
    }
    return sum;
}

static bool xpbd_soft_contact_is_done(const pli_body* body, const pli_body* other) {
    return other->world_index < body->world_index;
}

static pli_vec3 xpbd_soft_contact_motion(const xpbd_soft_contact* contact, const plii_substep* substep) {
    return pli_vec3_scale(xpbd_soft_contact_blend(contact, contact->body->velocities), substep->dt);
}

static void xpbd_soft_contact_push(const pli_body* body, const xpbd_soft_contact* contact, pli_vec3 push,
                                   const plii_substep* substep) {
    plii_substep_move(substep, contact->node, push, 1.0f);
    pli_body* other = contact->body;
    if (other->is_frozen) { return; }
    /* What a substep changes goes on for the rest of the step; what is to be solved yet starts with it. */
    const float rest =
        xpbd_soft_contact_is_done(body, other) ? body->step.dt - (float)substep->index * substep->dt : body->step.dt;
    for (int k = 0; k < 3; ++k) {
        const int node = contact->face[k];
        const pli_vec3 change =
            pli_vec3_scale(push, -other->positions[node].w * contact->weights[k] * substep->inverse_dt);
        plii_set_xyz(&other->velocities[node], pli_vec3_add(plii_xyz(other->velocities[node]), change));
        plii_set_xyz(&other->positions[node],
                     pli_vec3_add(plii_xyz(other->positions[node]), pli_vec3_scale(change, rest)));
    }
}

// ---------------------------------------------------------------------------------------------------------- solving

static xpbd_soft_contact xpbd_soft_contact_make(const pli_body* body, const pli_soft_contact* from) {
    const pli_body* other = from->face_body;
    const int* face = other->topology->faces[from->face];
    xpbd_soft_contact contact = {.node = from->node,
                                 .body = from->face_body,
                                 .face = {face[0], face[1], face[2]},
                                 .weights = {from->weights[0], from->weights[1], from->weights[2]},
                                 .normal = from->normal,
                                 .margin = body->collision_margin + other->collision_margin};
    for (int k = 0; k < 3; ++k) {
        contact.face_weight +=
            other->is_frozen ? 0.0f : other->positions[face[k]].w * contact.weights[k] * contact.weights[k];
    }
    const pli_vec3 before = xpbd_soft_contact_blend(&contact, other->previous);
    contact.point = before;
    if (xpbd_soft_contact_is_done(body, other)) {
        const pli_vec3 velocity = xpbd_soft_contact_blend(&contact, other->velocities);
        contact.point =
            pli_vec3_sub(xpbd_soft_contact_blend(&contact, other->positions), pli_vec3_scale(velocity, body->step.dt));
    }
    /* A node that the prediction took through the face stays on its side. */
    if (pli_vec3_dot(pli_vec3_sub(plii_xyz(body->previous[from->node]), before), contact.normal) < 0.0f) {
        contact.normal = pli_vec3_neg(contact.normal);
    }
    return contact;
}

static void xpbd_soft_contacts_begin(pli_body* body, void* data) {
    xpbd_soft_contacts_state* state = data;
    /* Fails only where the search was enabled after this; the contacts without room are left out then. */
    (void)xpbd_soft_contacts_reserve(body, state);
    const int capacity = state->capacity < state->found_capacity ? state->capacity : state->found_capacity;
    const int found = pli_body_get_soft_contacts(body, capacity, state->found);
    state->count = found < capacity ? found : capacity;
    for (int i = 0; i < state->count; ++i) {
        state->contacts[i] = xpbd_soft_contact_make(body, &state->found[i]);
    }
}

static void xpbd_soft_contacts_restart(pli_body* body, void* data, const plii_substep* substep) {
    const xpbd_soft_contacts_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        xpbd_soft_contact* contact = &state->contacts[i];
        if (substep->index > 0) {
            contact->moved = pli_vec3_add(contact->moved, xpbd_soft_contact_motion(contact, substep));
        }
        const pli_vec3 node = pli_vec3_add(plii_xyz(body->positions[contact->node]),
                                           plii_xyz(substep->start_displacements[contact->node]));
        const pli_vec3 point = pli_vec3_add(contact->point, contact->moved);
        const float gap = pli_vec3_dot(contact->normal, pli_vec3_sub(node, point)) - contact->margin;
        const float mobility = substep->displacements[contact->node].w;
        contact->floor =
            plii_xpbd_contact_recover(substep, contact->node, contact->normal, gap,
                                      mobility / (mobility + contact->face_weight), state->def.recovery_speed);
        contact->multiplier = 0.0f;
        contact->friction = pli_vec3_make(0, 0, 0);
    }
}

static void xpbd_soft_contacts_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const xpbd_soft_contacts_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        xpbd_soft_contact* contact = &state->contacts[i];
        const pli_vec3 n = contact->normal;
        const float weight = substep->displacements[contact->node].w + contact->face_weight;
        const pli_vec3 point =
            pli_vec3_add(pli_vec3_add(contact->point, contact->moved), xpbd_soft_contact_motion(contact, substep));
        const float gap =
            pli_vec3_dot(n, pli_vec3_sub(plii_substep_position(body, substep, contact->node), point)) - contact->margin;
        const float change = plii_xpbd_multiplier(gap - contact->floor, weight, state->def.compliance, 0.0f,
                                                  contact->multiplier, 0.0f, substep);
        const float multiplier = plii_max(0.0f, contact->multiplier + change);
        xpbd_soft_contact_push(body, contact, pli_vec3_scale(n, multiplier - contact->multiplier), substep);
        contact->multiplier = multiplier;

        const pli_vec3 motion =
            pli_vec3_sub(plii_substep_motion(substep, contact->node), xpbd_soft_contact_motion(contact, substep));
        const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, pli_vec3_dot(motion, n)));
        if (!(weight > 0.0f)) { continue; }
        const pli_vec3 friction =
            plii_xpbd_contact_friction(contact->friction, sliding, weight, state->def.friction * contact->multiplier);
        if (!plii_vec3_is_finite(friction)) { continue; }
        xpbd_soft_contact_push(body, contact, pli_vec3_sub(friction, contact->friction), substep);
        contact->friction = friction;
    }
}

// ------------------------------------------------------------------------------------------------------ the feature

static void xpbd_soft_contacts_disable(pli_body* body, void* data) {
    const xpbd_soft_contacts_state* state = data;
    plii_release(body->context, state->found, (size_t)state->found_capacity * sizeof *state->found);
    plii_release(body->context, state->contacts, (size_t)state->capacity * sizeof *state->contacts);
}

static size_t xpbd_soft_contacts_bytes(const pli_body* body, const void* data) {
    const xpbd_soft_contacts_state* state = data;
    (void)body;
    return (size_t)state->found_capacity * sizeof *state->found + (size_t)state->capacity * sizeof *state->contacts;
}

static void xpbd_soft_contacts_topology_commit(pli_body* body, void* data, const plii_topology_change* change,
                                               void** blocks) {
    (void)body;
    (void)change;
    (void)blocks;
    ((xpbd_soft_contacts_state*)data)->count = 0; /* made anew in each step */
}

static const plii_feature_class xpbd_soft_contacts_class = {
    .name = "XPBD soft contacts",
    .state_size = sizeof(xpbd_soft_contacts_state),
    .disable = xpbd_soft_contacts_disable,
    .collide_body = xpbd_soft_contacts_collide,
    .bytes = xpbd_soft_contacts_bytes,
    .topology_commit = xpbd_soft_contacts_topology_commit,
};

static bool xpbd_soft_contacts_is_idle(const pli_body* body, const void* data) {
    (void)body;
    return ((const xpbd_soft_contacts_state*)data)->count == 0;
}

enum { XPBD_SOFT_CONTACTS_ORDER = 70 }; /* after rigid bodies */

static const plii_substep_class xpbd_soft_contacts_kind = {
    .order = XPBD_SOFT_CONTACTS_ORDER,
    .klass = &xpbd_soft_contacts_class,
    .begin = xpbd_soft_contacts_begin,
    .restart = xpbd_soft_contacts_restart,
    .sweep = xpbd_soft_contacts_sweep,
    .is_idle = xpbd_soft_contacts_is_idle,
};

pli_status pli_body_enable_xpbd_soft_contacts(pli_body* body, const pli_xpbd_contacts_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    const pli_xpbd_contacts_def used = def != NULL ? *def : pli_xpbd_contacts_def_default();
    PLII_TRY(plii_xpbd_check_contacts_def(body, &used, __func__));
    void* state = NULL;
    PLII_TRY(plii_xpbd_enable_kind(body, &xpbd_soft_contacts_kind, __func__, &state));
    ((xpbd_soft_contacts_state*)state)->def = used;
    return PLI_OK;
}

pli_status pli_body_disable_xpbd_soft_contacts(pli_body* body) {
    return plii_xpbd_disable_kind(body, &xpbd_soft_contacts_kind, __func__);
}
