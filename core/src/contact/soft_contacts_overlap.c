/* Closed bodies that are inside of each other where they were put into the world. */

#include "contact/soft_contacts_impl.h"

bool plii_soft_contacts_may_be_inside(const pli_body* body, const pli_body* other) {
    if (body->overlap_steps + other->overlap_steps == 0 || !plii_topology_is_closed(body->topology) ||
        !plii_topology_is_closed(other->topology) || !(plii_body_volume(body) > 0.0f) ||
        !(plii_body_volume(other) > 0.0f)) {
        return false;
    }
    const pli_bounds a = plii_body_bounds_of(body, body->previous), b = plii_body_bounds_of(other, other->previous);
    return !plii_bounds_contain(a, b) && !plii_bounds_contain(b, a);
}

/* m: an overlap goes as if it were this deep, at 4 cm/s; what parts bodies fast would stretch links, and throw them. */
#define SOFT_CONTACTS_PARTING 0.0035f

/* Seen from the sides between which they pass, nodes look outside in between. */
enum { SOFT_CONTACTS_OVERLAP_STEPS = 30 };
void plii_soft_contacts_part_slowly(pli_body* body, const plii_soft_contacts_state* state, int first) {
    if (body->overlap_steps > 0) { body->overlap_steps = SOFT_CONTACTS_OVERLAP_STEPS; }
    for (PLII_EACH(plii_soft_contact, contact, state->contacts + first, state->count - first)) {
        const pli_body* other = contact->face_body;
        const int* face = other->topology->faces[contact->face];
        const pli_vec3 apart = pli_vec3_sub(plii_xyz(body->previous[contact->node]),
                                            plii_contact_blend(other->previous, face, contact->weights));
        contact->margin = plii_min(contact->margin, pli_vec3_dot(contact->normal, apart) + SOFT_CONTACTS_PARTING);
    }
}
