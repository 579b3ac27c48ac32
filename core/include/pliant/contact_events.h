#ifndef PLIANT_CONTACT_EVENTS_H
#define PLIANT_CONTACT_EVENTS_H

/// What a body touches: after each step the contacts that have begun, go on or have ended, with their impulses.

#include "body.h"
#include "rigid.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What happened to a contact in the last step.
typedef enum pli_contact_phase {
    PLI_CONTACT_BEGIN = 0,   ///< it began; it was not there in the step before
    PLI_CONTACT_PERSIST = 1, ///< it goes on
    PLI_CONTACT_END = 2      ///< it ended; its values are those of the step before, the impulse is zero
} pli_contact_phase;

/// A contact of a body with a rigid body or with another soft body.
typedef struct pli_contact_event {
    pli_rigid* rigid; ///< the rigid body; NULL if `other` is touched, or at PLI_CONTACT_END if it was destroyed
    pli_body* other;  ///< the other soft body; NULL if `rigid` is touched, or at PLI_CONTACT_END if it was destroyed
    void* user_data;  ///< that of `rigid` or `other`, also when it was destroyed
    int shape;        ///< index in the rigid body's shapes, or PLI_NULL_INDEX
    int node;         ///< of this body, or PLI_NULL_INDEX: the contact is of a face, or of a link
    int face;         ///< of this body, or PLI_NULL_INDEX
    int link;         ///< of this body, which has no faces, or PLI_NULL_INDEX
    int other_node;   ///< of the other soft body, or PLI_NULL_INDEX
    int other_face;   ///< of the other soft body, or PLI_NULL_INDEX
    /// Number of contacts of nodes and faces that are summed; with `each_element` mostly 1.
    int contact_count;
    pli_vec3 point;   ///< m, world, on the surface touched, at the end of the step; mean weighted by impulse
    pli_vec3 normal;  ///< unit, world, towards this body; mean weighted by impulse
    pli_vec3 impulse; ///< N s, world: what this body got in the step, friction included; the other got the opposite
    bool is_sensor;   ///< `rigid` is a sensor, which pushes nothing
} pli_contact_event;

/// What is reported.
typedef struct pli_contact_events_def {
    /// Default false: one event for each rigid or soft body that is touched, with sums and means, and with the shape,
    /// node and face that pushed hardest. True: one for each node and face.
    bool each_element;
    /// Default false. True: all rigid bodies act as sensors for this body, in addition to its contacts, so that a body
    /// without contacts reports what it meets.
    bool senses_all;
    uint32_t cookie; ///< set by the default function
} pli_contact_events_def;

/// Defaults of the fields.
PLI_API pli_contact_events_def pli_contact_events_def_default(void);

/// Reports the contacts of pli_body_enable_rigid_contacts, pli_body_enable_rigid_face_contacts and
/// pli_body_enable_soft_contacts, and nodes within the margin of sensors, with any solver. It does not report contacts
/// of clusters and of a body with itself. Called again, it changes the settings, and all contacts begin anew.
///
/// A contact begins in the step in which it first pushes. It lasts while it pushes, or while it is no farther from the
/// surface than a quarter of the margin.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_OUT_OF_MEMORY, PLI_ERROR_WRONG_STATE while stepping
/// Cost: about 500 B per event; one pass over all contacts per step.
PLI_API pli_status pli_body_enable_contact_events(pli_body* body, const pli_contact_events_def* def);

/// Ends contact events. Does nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_contact_events(pli_body* body);

/// The contacts of the last step in one phase, in the order in which they were found. A frozen body has none; when it
/// steps again it continues from those that it had before.
/// @param phase which contacts
/// @param count receives their number, 0 when events are not enabled; may be NULL
/// @return [count], valid until the next step or until events are enabled or disabled; NULL with a count of 0
PLI_API const pli_contact_event* pli_body_get_contact_events(const pli_body* body, pli_contact_phase phase, int* count);

#ifdef __cplusplus
}
#endif
#endif
