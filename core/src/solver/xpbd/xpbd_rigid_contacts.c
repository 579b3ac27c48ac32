/* XPBD: contacts of nodes with rigid bodies. C = n . (node - motion of the surface) + offset >= 0, with Coulomb
   friction on the motion of the substep. Contacts are those that pli_body_enable_rigid_contacts found at the predicted
   positions; their planes move with the rigid body. */

#include "body/substep_rigid.h"
#include "body/world_state.h"
#include "pliant/contact.h"
#include "solver/xpbd/xpbd_contact.h"
#include "solver/xpbd/xpbd_impl.h"

typedef struct xpbd_rigid_contact {
    int node;
    pli_vec3 normal;
    float offset; /* of the plane that is kept free, at the start of the step */
    plii_substep_rigid_point point;
    float coefficient; /* of friction */
    bool is_fixed;     /* nothing changes the motion of the rigid body */
    /* For one substep. */
    pli_vec3 motion; /* of a fixed surface */
    float floor, weight, multiplier;
    pli_vec3 friction;
} xpbd_rigid_contact;

typedef struct xpbd_rigid_contacts_state {
    pli_xpbd_contacts_def def;
    pli_rigid_contact* found;
    int found_capacity;
    xpbd_rigid_contact* contacts;
    int count, capacity;
} xpbd_rigid_contacts_state;

static bool xpbd_rigid_contacts_reserve(pli_body* body, xpbd_rigid_contacts_state* state, int count) {
    return PLII_RESERVE(body->context, &state->found, &state->found_capacity, count) &&
           PLII_RESERVE(body->context, &state->contacts, &state->capacity, count);
}

/* Comes after the search, which was enabled before. */
static pli_status xpbd_rigid_contacts_collide(pli_body* body, void* data, pli_rigid* rigid) {
    const int count = pli_body_get_rigid_contacts(body, 0, NULL);
    (void)rigid;
    return xpbd_rigid_contacts_reserve(body, data, count) ? PLI_OK : PLI_ERROR_OUT_OF_MEMORY;
}

static void xpbd_rigid_contacts_make_room(pli_body* body, void* data) {
    if (body->world->rigid_count > 0) { (void)xpbd_rigid_contacts_reserve(body, data, plii_body_contact_room(body)); }
}

static bool xpbd_rigid_contacts_is_fixed(const pli_rigid* rigid) {
    const pli_mat3 inverse_inertia = rigid->state.inverse_inertia_world;
    float sum = rigid->state.inverse_mass;
    for (int k = 0; k < 3; ++k) {
        sum += fabsf(inverse_inertia.rows[k].x) + fabsf(inverse_inertia.rows[k].y) + fabsf(inverse_inertia.rows[k].z);
    }
    return sum == 0.0f;
}

static void xpbd_rigid_contacts_begin(pli_body* body, void* data) {
    xpbd_rigid_contacts_state* state = data;
    /* Fails only where the search was enabled after this; the contacts without room are left out then. */
    (void)xpbd_rigid_contacts_reserve(body, state, pli_body_get_rigid_contacts(body, 0, NULL));
    const int capacity = state->capacity < state->found_capacity ? state->capacity : state->found_capacity;
    const int found = pli_body_get_rigid_contacts(body, capacity, state->found);
    state->count = found < capacity ? found : capacity;
    for (int i = 0; i < state->count; ++i) {
        const pli_rigid_contact* from = &state->found[i];
        const pli_vec3 x = plii_xyz(body->positions[from->node]);
        xpbd_rigid_contact* contact = &state->contacts[i];
        *contact = (xpbd_rigid_contact){.node = from->node, .normal = from->normal};
        contact->offset = from->distance - pli_vec3_dot(from->normal, x);
        contact->coefficient = state->def.friction * from->rigid->friction;
        contact->is_fixed = xpbd_rigid_contacts_is_fixed(from->rigid);
        contact->point.rigid = from->rigid;
        contact->point.offset = pli_vec3_sub(x, from->rigid->state.pose.origin);
    }
}

/* Along a unit vector. */
static float xpbd_rigid_contacts_weight(const plii_substep* substep, const xpbd_rigid_contact* contact,
                                        pli_vec3 direction) {
    const float weight = substep->displacements[contact->node].w;
    return contact->is_fixed ? weight : weight + plii_substep_rigid_point_weight(&contact->point, direction);
}

static pli_vec3 xpbd_rigid_contacts_motion(const plii_substep* substep, const xpbd_rigid_contact* contact) {
    return contact->is_fixed ? contact->motion : plii_substep_rigid_point_motion(&contact->point, substep);
}

static void xpbd_rigid_contacts_restart(pli_body* body, void* data, const plii_substep* substep) {
    xpbd_rigid_contacts_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        xpbd_rigid_contact* contact = &state->contacts[i];
        plii_substep_rigid_point_restart(&contact->point, substep);
        const pli_vec3 before =
            pli_vec3_add(plii_xyz(body->positions[contact->node]), plii_xyz(substep->carried[contact->node]));
        const float gap = pli_vec3_dot(contact->normal, pli_vec3_sub(before, contact->point.moved)) + contact->offset;
        contact->floor =
            plii_xpbd_contact_recover(substep, contact->node, contact->normal, gap, 1.0f, state->def.recovery_speed);
        contact->motion = plii_substep_rigid_point_motion(&contact->point, substep);
        contact->weight = xpbd_rigid_contacts_weight(substep, contact, contact->normal);
        contact->multiplier = 0.0f;
        contact->friction = pli_vec3_make(0, 0, 0);
    }
}

static void xpbd_rigid_contacts_push(const plii_substep* substep, const xpbd_rigid_contact* contact, pli_vec3 push) {
    plii_substep_move(substep, contact->node, push, 1.0f);
    if (!contact->is_fixed) { plii_substep_rigid_point_push(&contact->point, pli_vec3_neg(push), substep); }
}

static void xpbd_rigid_contacts_press(pli_body* body, const plii_substep* substep,
                                      const xpbd_rigid_contacts_state* state, xpbd_rigid_contact* contact) {
    const pli_vec3 surface = pli_vec3_add(contact->point.moved, xpbd_rigid_contacts_motion(substep, contact));
    const pli_vec3 to_node = pli_vec3_sub(plii_substep_position(body, substep, contact->node), surface);
    const float gap = pli_vec3_dot(contact->normal, to_node) + contact->offset;
    if (contact->multiplier == 0.0f && !(gap < contact->floor)) { return; }
    const float change = plii_xpbd_multiplier(gap - contact->floor, contact->weight, state->def.compliance, 0.0f,
                                              contact->multiplier, 0.0f, substep);
    const float multiplier = plii_max(0.0f, contact->multiplier + change);
    if (multiplier == contact->multiplier) { return; }
    xpbd_rigid_contacts_push(substep, contact, pli_vec3_scale(contact->normal, multiplier - contact->multiplier));
    contact->multiplier = multiplier;
}

static void xpbd_rigid_contacts_rub(const plii_substep* substep, xpbd_rigid_contact* contact) {
    const pli_vec3 n = contact->normal;
    const pli_vec3 motion =
        pli_vec3_sub(plii_substep_motion(substep, contact->node), xpbd_rigid_contacts_motion(substep, contact));
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, pli_vec3_dot(motion, n)));
    const float length = pli_vec3_length(sliding);
    if (!(length > 0.0f) || !(contact->weight > 0.0f)) { return; }
    const float weight = xpbd_rigid_contacts_weight(substep, contact, pli_vec3_scale(sliding, 1.0f / length));
    const pli_vec3 friction =
        plii_xpbd_contact_friction(contact->friction, sliding, weight, contact->coefficient * contact->multiplier);
    if (!plii_vec3_is_finite(friction)) { return; }
    xpbd_rigid_contacts_push(substep, contact, pli_vec3_sub(friction, contact->friction));
    contact->friction = friction;
}

static void xpbd_rigid_contacts_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const xpbd_rigid_contacts_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        xpbd_rigid_contact* contact = &state->contacts[i];
        xpbd_rigid_contacts_press(body, substep, state, contact);
        const bool rubs = contact->multiplier > 0.0f || pli_vec3_length_squared(contact->friction) > 0.0f;
        if (rubs) { xpbd_rigid_contacts_rub(substep, contact); }
    }
}

static void xpbd_rigid_contacts_disable(pli_body* body, void* data) {
    const xpbd_rigid_contacts_state* state = data;
    plii_release(body->context, state->found, (size_t)state->found_capacity * sizeof *state->found);
    plii_release(body->context, state->contacts, (size_t)state->capacity * sizeof *state->contacts);
}

static size_t xpbd_rigid_contacts_bytes(const pli_body* body, const void* data) {
    const xpbd_rigid_contacts_state* state = data;
    (void)body;
    return (size_t)state->found_capacity * sizeof *state->found + (size_t)state->capacity * sizeof *state->contacts;
}

static void xpbd_rigid_contacts_topology_commit(pli_body* body, void* data, const plii_topology_change* change,
                                                void** blocks) {
    (void)body;
    (void)change;
    (void)blocks;
    ((xpbd_rigid_contacts_state*)data)->count = 0; /* made anew in each step */
}

static const plii_feature_class xpbd_rigid_contacts_class = {
    .name = "XPBD rigid contacts",
    .state_size = sizeof(xpbd_rigid_contacts_state),
    .disable = xpbd_rigid_contacts_disable,
    .reserve = xpbd_rigid_contacts_make_room,
    .collide_rigid = xpbd_rigid_contacts_collide,
    .bytes = xpbd_rigid_contacts_bytes,
    .topology_commit = xpbd_rigid_contacts_topology_commit,
};

static bool xpbd_rigid_contacts_is_idle(const pli_body* body, const void* data) {
    (void)body;
    return ((const xpbd_rigid_contacts_state*)data)->count == 0;
}

enum { XPBD_RIGID_CONTACTS_ORDER = 60 }; /* after all that holds the body together and self-collision of nodes */

static const plii_substep_class xpbd_rigid_contacts_kind = {
    .order = XPBD_RIGID_CONTACTS_ORDER,
    .klass = &xpbd_rigid_contacts_class,
    .begin = xpbd_rigid_contacts_begin,
    .restart = xpbd_rigid_contacts_restart,
    .sweep = xpbd_rigid_contacts_sweep,
    .is_idle = xpbd_rigid_contacts_is_idle,
};

pli_status pli_body_enable_xpbd_rigid_contacts(pli_body* body, const pli_xpbd_contacts_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    const pli_xpbd_contacts_def used = def != NULL ? *def : pli_xpbd_contacts_def_default();
    PLII_TRY(plii_xpbd_check_contacts_def(body, &used, __func__));
    void* state = NULL;
    PLII_TRY(plii_xpbd_enable_kind(body, &xpbd_rigid_contacts_kind, __func__, &state));
    ((xpbd_rigid_contacts_state*)state)->def = used;
    return PLI_OK;
}

pli_status pli_body_disable_xpbd_rigid_contacts(pli_body* body) {
    return plii_xpbd_disable_kind(body, &xpbd_rigid_contacts_kind, __func__);
}
