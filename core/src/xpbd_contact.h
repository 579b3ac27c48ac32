#ifndef PLII_XPBD_CONTACT_H
#define PLII_XPBD_CONTACT_H

/* What contacts with rigid and with soft bodies have in common. */

#include "xpbd_impl.h"

/* PLI_OK, or the error of a wrong definition. */
pli_status plii_xpbd_check_contacts_def(const pli_body* body, const pli_xpbd_contacts_def* def, const char* function);

/* The lowest gap that a substep has to reach: a penetration that was there before goes at `recovery_speed` only, so
   that it does not turn into speed. */
static inline float plii_xpbd_contact_floor(float gap_before, float recovery_speed, float dt) {
    const float reached = gap_before + recovery_speed * dt;
    return reached < 0.0f ? reached : 0.0f;
}

/* The new sum of friction of a contact: what would stop the sliding, but not above Coulomb's limit. */
static inline pli_vec3 plii_xpbd_contact_friction(pli_vec3 friction, pli_vec3 sliding, float weight, float limit) {
    const pli_vec3 wanted = pli_vec3_sub(friction, pli_vec3_scale(sliding, 1.0f / weight));
    const float length = pli_vec3_length(wanted);
    return length > limit ? pli_vec3_scale(wanted, limit / length) : wanted;
}

#endif
