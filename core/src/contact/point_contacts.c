#include "contact/point_contacts.h"
#include "contact/contact_substep.h"

enum { POINT_CONTACTS_HOLD_PASSES = 10 };

plii_point_contact* plii_point_contacts_add(pli_body* body, plii_point_contacts* contacts) {
    if (!PLII_GROW(body->context, &contacts->items, &contacts->capacity, contacts->count)) { return NULL; }
    return &contacts->items[contacts->count++];
}

void plii_point_contact_prepare(pli_body* body, plii_point_contact* contact) {
    const plii_substep_rigid_point* surface = &contact->surface;
    plii_substep_follow_rigid(body, surface->rigid);
    contact->turn = pli_vec3_cross(surface->offset, contact->normal);
    contact->spin = plii_rigid_spin_of(surface->rigid, contact->normal, surface->offset);
    contact->point_weight =
        plii_point_weight(body->positions, contact->node_count, contact->nodes, contact->weights, 0.0f);
    contact->surface_weight =
        plii_rigid_linear_response(surface->rigid, contact->normal) + pli_vec3_dot(contact->turn, contact->spin);
}

static inline float point_height(const pli_body* body, const plii_substep* substep, const pli_vec4* displacements,
                                 const plii_point_contact* contact) {
    float sum = contact->offset;
    for (int k = 0; k < contact->node_count; ++k) {
        const pli_vec3 x = plii_substep_place(body, substep, displacements, contact->nodes[k]);
        sum += contact->weights[k] * pli_vec3_dot(contact->normal, x);
    }
    return sum;
}

static inline pli_vec3 point_motion(const plii_substep* substep, const plii_point_contact* contact) {
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    for (int k = 0; k < contact->node_count; ++k) {
        sum = pli_vec3_add(sum, pli_vec3_scale(plii_substep_motion(substep, contact->nodes[k]), contact->weights[k]));
    }
    return sum;
}

static pli_vec3 point_carried(const pli_body* body, const plii_substep* substep, const plii_point_contact* contact) {
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    for (int k = 0; k < contact->node_count; ++k) {
        const pli_vec3 motion = plii_substep_carried(body, substep, contact->nodes[k], contact->normal);
        sum = pli_vec3_add(sum, pli_vec3_scale(motion, contact->weights[k]));
    }
    return sum;
}

/* How far a motion of the rigid body brings the surface along the normal, m. */
static float point_raise(const plii_point_contact* contact, plii_twist motion) {
    return pli_vec3_dot(contact->normal, motion.linear) + pli_vec3_dot(contact->turn, motion.angular);
}
static float point_raised(const plii_point_contact* contact) { /* in the substeps before this one */
    return point_raise(contact, contact->surface.rigid->path.moved);
}
static inline float point_raise_of_substep(const plii_point_contact* contact, const plii_substep* substep) {
    return point_raise(contact, plii_substep_rigid_velocity(contact->surface.rigid)) * substep->host_dt;
}
/* kg m along the normal, against the surface. */
static inline void point_press_surface(const plii_point_contact* contact, float push, const plii_substep* substep) {
    /* Bodies on other threads may press on one that takes no impulses. */
    if (contact->surface.rigid->state.inverse_mass == 0.0f) { return; }
    plii_rigid_apply_along(contact->surface.rigid, contact->normal, contact->spin, -push * substep->inverse_host_dt);
    contact->surface.rigid->path.is_pushed = true;
}

/* How far it can go away from the rigid body: as far as its nodes can, each on its own. */
static float point_room(const pli_body* body, const plii_substep* substep, const plii_point_contact* contact,
                        float wanted) {
    float room = 0.0f;
    for (int k = 0; k < contact->node_count; ++k) {
        const int node = contact->nodes[k];
        if (!(contact->weights[k] > 0.0f) || !(substep->displacements[node].w > 0.0f)) { continue; }
        room += contact->weights[k] * plii_substep_room(body, substep, node, contact->normal, wanted);
    }
    return room;
}

/* A penetration from before goes by a shift of the nodes, lest it turns into speed; no farther for pinned ones. */
static void point_recover(const pli_body* body, const plii_substep* substep, plii_point_contact* contact, float gap,
                          float most) {
    contact->floor = plii_min(gap, 0.0f);
    if (!(gap < 0.0f) || !(contact->point_weight > 0.0f)) { return; }
    const float shift = plii_min(plii_min(-gap, most), point_room(body, substep, contact, 0.0f));
    if (!(shift > 0.0f)) { return; }
    const float unpinned =
        plii_point_weight_unpinned(body->positions, contact->node_count, contact->nodes, contact->weights);
    for (int k = 0; k < contact->node_count; ++k) {
        const int node = contact->nodes[k];
        const float share = contact->weights[k] * substep->displacements[node].w / unpinned;
        plii_substep_shift(substep, node, pli_vec3_scale(contact->normal, share * shift));
    }
    contact->floor = gap + shift * (contact->point_weight / unpinned);
}

void plii_point_contacts_restart(pli_body* body, plii_point_contacts* contacts, const plii_substep* substep,
                                 float recovery_speed) {
    for (PLII_EACH(plii_point_contact, contact, contacts->items, contacts->count)) {
        if (substep->limits->count > 0) { contact->carried = point_carried(body, substep, contact); }
        const float gap = point_height(body, substep, substep->start_displacements, contact) - point_raised(contact);
        point_recover(body, substep, contact, gap, recovery_speed * substep->dt);
        contact->push = contact->held_push = 0.0f;
        contact->friction = contact->held_friction = pli_vec3_make(0, 0, 0);
    }
}

/* Seen from what holds the point, which may come towards the rigid body and takes that with it. */
static float point_allowance(const pli_body* body, const plii_substep* substep, const plii_point_contact* contact) {
    const float carried = pli_vec3_dot(contact->normal, contact->carried);
    const float gap = point_height(body, substep, substep->displacements, contact) - point_raised(contact) - carried;
    const float free = plii_max(gap, 0.0f), approach = point_raise_of_substep(contact, substep) - carried - free;
    const float wanted = approach > 0.0f ? plii_substep_unbraked(approach, substep) : 0.0f, deep = free - gap;
    const float room = plii_max(point_room(body, substep, contact, wanted + deep) - deep, 0.0f);
    return carried + free + plii_substep_braked(room, substep);
}

/* The rigid body stops there, and is not thrown back. */
static bool point_hold(const plii_substep* substep, plii_point_contact* contact) {
    const float approach = point_raise_of_substep(contact, substep) - contact->allowance;
    const float push = plii_max(contact->held_push + approach / contact->surface_weight, 0.0f);
    if (push == contact->held_push || !plii_is_finite(push)) { return false; }
    point_press_surface(contact, push - contact->held_push, substep);
    contact->held_push = push;
    return true;
}

static void point_hold_across(const plii_substep* substep, plii_point_contact* contact) {
    if (!(contact->held_push > 0.0f) && plii_vec3_is_zero(contact->held_friction)) { return; }
    const pli_vec3 n = contact->normal, motion = plii_substep_rigid_point_motion(&contact->surface, substep);
    const pli_vec3 apart = pli_vec3_sub(contact->carried, motion);
    const pli_vec3 sliding = pli_vec3_sub(apart, pli_vec3_scale(n, pli_vec3_dot(apart, n)));
    const float squared = pli_vec3_length_squared(sliding);
    if (!(squared > 0.0f)) { return; }
    const float mass = squared / plii_substep_rigid_point_weight(&contact->surface, sliding);
    const pli_vec3 friction =
        plii_contact_friction(contact->held_friction, sliding, mass, contact->coefficient * contact->held_push);
    if (!plii_vec3_is_finite(friction)) { return; }
    plii_substep_rigid_point_push(&contact->surface, pli_vec3_sub(contact->held_friction, friction), substep);
    contact->held_friction = friction;
}

/* These act on a few rigid bodies alone, so that passes are cheap. */
static void point_contacts_hold(const pli_body* body, plii_point_contacts* contacts, const plii_substep* substep) {
    if (substep->limits->count == 0) { return; }
    for (int i = 0; i < contacts->count; ++i) {
        contacts->items[i].allowance = point_allowance(body, substep, &contacts->items[i]);
    }
    for (int pass = 0; pass < POINT_CONTACTS_HOLD_PASSES; ++pass) {
        bool has_held = false;
        for (PLII_EACH(plii_point_contact, contact, contacts->items, contacts->count)) {
            if (contact->surface_weight > 0.0f && contact->allowance < INFINITY) {
                has_held = point_hold(substep, contact) || has_held;
            }
        }
        if (!has_held) { break; }
        for (int i = 0; i < contacts->count; ++i) {
            point_hold_across(substep, &contacts->items[i]);
        }
    }
}

static inline void point_push(const plii_substep* substep, const plii_point_contact* contact, pli_vec3 push) {
    for (int k = 0; k < contact->node_count; ++k) {
        plii_substep_move(substep, contact->nodes[k], push, contact->weights[k]);
    }
}

static void point_press(const pli_body* body, const plii_substep* substep, float alpha, plii_point_contact* contact) {
    const float error = point_height(body, substep, substep->displacements, contact) - point_raised(contact) -
                        point_raise_of_substep(contact, substep) - contact->floor;
    const float before = contact->push;
    if (before == 0.0f && !(error < 0.0f)) { return; }
    const float weight = contact->point_weight + contact->surface_weight;
    const float change = (-error - alpha * before) / (weight + alpha);
    contact->push = plii_max(before + (weight > 0.0f && plii_is_finite(change) ? change : 0.0f), 0.0f);
    const float push = contact->push - before;
    point_push(substep, contact, pli_vec3_scale(contact->normal, push));
    point_press_surface(contact, push, substep);
}

static void point_rub(const plii_substep* substep, plii_point_contact* contact) {
    const pli_vec3 n = contact->normal, before = contact->friction;
    const pli_vec3 motion =
        pli_vec3_sub(point_motion(substep, contact), plii_substep_rigid_point_motion(&contact->surface, substep));
    const pli_vec3 sliding = pli_vec3_sub(motion, pli_vec3_scale(n, pli_vec3_dot(motion, n)));
    const float squared = pli_vec3_length_squared(sliding);
    if (!(squared > 0.0f) || !(contact->point_weight + contact->surface_weight > 0.0f)) { return; }
    const float response = plii_substep_rigid_point_weight(&contact->surface, sliding);
    const float mass = squared / (contact->point_weight * squared + response);
    const pli_vec3 friction = plii_contact_friction(before, sliding, mass, contact->coefficient * contact->push);
    if (!plii_vec3_is_finite(friction)) { return; }
    const pli_vec3 push = pli_vec3_sub(friction, before);
    point_push(substep, contact, push);
    plii_substep_rigid_point_push(&contact->surface, pli_vec3_neg(push), substep);
    contact->friction = friction;
}

void plii_point_contacts_sweep(pli_body* body, plii_point_contacts* contacts, const plii_substep* substep,
                               float compliance) {
    const float alpha = compliance * substep->inverse_dt * substep->inverse_dt;
    point_contacts_hold(body, contacts, substep);
    for (PLII_EACH(plii_point_contact, contact, contacts->items, contacts->count)) {
        point_press(body, substep, alpha, contact);
        if (contact->push > 0.0f || !plii_vec3_is_zero(contact->friction)) { point_rub(substep, contact); }
    }
}
