#ifndef PLII_XPBD_CONTACT_H
#define PLII_XPBD_CONTACT_H

/* What contacts with rigid and with soft bodies have in common. */

#include "solver/xpbd/xpbd_impl.h"

/* PLI_OK, or the error of a wrong definition. */
pli_status plii_xpbd_check_contacts_def(const pli_body* body, const pli_xpbd_contacts_def* def, const char* function);

/* Before the sweeps of a substep: a penetration that is there already goes at `recovery_speed`, by a shift of the
   node's `share`, lest it turns into speed, which would keep cloth on a body in motion for good. Returns the lowest gap
   that the sweeps allow. */
static inline float plii_xpbd_contact_recover(const plii_substep* substep, int node, pli_vec3 normal, float gap,
                                              float share, float recovery_speed) {
    if (!(gap < 0.0f) || !(substep->displacements[node].w > 0.0f)) { return plii_min(gap, 0.0f); }
    const float shift = share * plii_min(-gap, recovery_speed * substep->dt);
    plii_substep_shift(substep, node, pli_vec3_scale(normal, shift));
    return gap + shift;
}

/* The new sum of friction of a contact: what would stop the sliding, but not above Coulomb's limit. */
static inline pli_vec3 plii_xpbd_contact_friction(pli_vec3 friction, pli_vec3 sliding, float weight, float limit) {
    const pli_vec3 wanted = pli_vec3_sub(friction, pli_vec3_scale(sliding, 1.0f / weight));
    const float length = pli_vec3_length(wanted);
    return length > limit ? pli_vec3_scale(wanted, limit / length) : wanted;
}

#endif
