/* The definition that contacts with rigid and with soft bodies share. */

#include "contact/contact_substep.h"
#include "math/range.h"

pli_xpbd_contacts_def pli_xpbd_contacts_def_default(void) {
    return (pli_xpbd_contacts_def){.friction = 0.5f, .recovery_speed = 1.0f, .cookie = PLII_DEF_COOKIE};
}

pli_status plii_xpbd_check_contacts_def(const pli_body* body, const pli_xpbd_contacts_def* def, const char* function) {
    if (def->cookie != PLII_DEF_COOKIE) {
        return plii_fail(body->context, PLI_ERROR_INVALID_DEF, function, "start from pli_xpbd_contacts_def_default()");
    }
    PLII_TRY(plii_xpbd_check_value(body, def->compliance, PLI_MAX_COEFFICIENT, "compliance", function));
    PLII_TRY(plii_xpbd_check_value(body, def->friction, PLI_MAX_FACTOR, "friction", function));
    return plii_xpbd_check_value(body, def->recovery_speed, PLI_MAX_SPEED, "recovery_speed", function);
}
