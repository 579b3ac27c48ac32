#pragma once

/* Contacts of points of a soft body, nodes or points of faces, with rigid bodies in substeps, one after the other: C =
   n . (point - motion of the surface) + offset >= 0, with Coulomb friction on the motion of the substep. A node is
   light, and pushes a heavy body back by little in a sweep. What it hangs from, or lies on, does not move at all: a
   rigid body that presses the node against that is held by it directly. Room is how far the node can still go. */

#include "body/substep_rigid.h"

typedef struct plii_point_contact {
    pli_vec3 normal; /* out of the rigid body */
    float offset;    /* of the plane that is kept free, at the start of the step; m */
    plii_substep_rigid_point surface;
    int node_count, nodes[3];
    float weights[3];
    float coefficient; /* of friction */
    /* For one step. */
    pli_vec3 turn, spin; /* m, of the normal at the surface; spin per impulse along the normal, 1/(kg m) */
    float point_weight, surface_weight; /* inverse masses along the normal, 1/kg */
    /* For one substep. */
    float floor;           /* m, lowest gap that the sweeps allow */
    float allowance;       /* m, that the surface may come nearer to what holds the point */
    pli_vec3 carried;      /* m, of what holds the point, as a cloth that is pulled over the ground */
    float push, held_push; /* kg m along the normal: between point and surface, and of what holds the point */
    pli_vec3 friction, held_friction;
} plii_point_contact;

typedef struct plii_point_contacts {
    plii_point_contact* items;
    int count, capacity;
} plii_point_contacts;

/* What it has pushed its point by in a substep, N s, with what has held the point in its place. */
static inline pli_vec3 plii_point_contact_impulse(const plii_point_contact* contact, const plii_substep* substep) {
    const pli_vec3 along = pli_vec3_scale(contact->normal, contact->push + contact->held_push);
    const pli_vec3 across = pli_vec3_add(contact->friction, contact->held_friction);
    return pli_vec3_scale(pli_vec3_add(along, across), substep->inverse_dt);
}
/* One more, to be filled in down to the coefficient and then prepared for the step; NULL without memory. */
plii_point_contact* plii_point_contacts_add(pli_body* body, plii_point_contacts* contacts);
void plii_point_contact_prepare(pli_body* body, plii_point_contact* contact);
/* Hooks of substeps. `recovery_speed`: m/s, `compliance`: m/N */
void plii_point_contacts_restart(pli_body* body, plii_point_contacts* contacts, const plii_substep* substep,
                                 float recovery_speed);
void plii_point_contacts_sweep(pli_body* body, plii_point_contacts* contacts, const plii_substep* substep,
                               float compliance);
