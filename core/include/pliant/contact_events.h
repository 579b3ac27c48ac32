#ifndef PLIANT_CONTACT_EVENTS_H
#define PLIANT_CONTACT_EVENTS_H

/// What a body touches: after each step the contacts that have begun, go on and have ended, with what they pushed.

#include "body.h"
#include "rigid.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What has become of a contact in the last step.
typedef enum pli_contact_phase {
    PLI_CONTACT_BEGIN = 0,   ///< it was not there in the step before
    PLI_CONTACT_PERSIST = 1, ///< it was, and still is
    PLI_CONTACT_END = 2      ///< it was, and is no more; its values are those of the step before, the impulse is zero
} pli_contact_phase;

/// A contact of a body with a rigid body or with another soft body.
typedef struct pli_contact_event {
    pli_rigid* rigid; ///< the rigid body, or NULL: `other` is touched, or PLI_CONTACT_END and it is destroyed
    pli_body* other;  ///< the other soft body, or NULL: `rigid` is touched, or PLI_CONTACT_END and it is destroyed
    void* user_data;  ///< that of `rigid` or `other`, also when that is destroyed
    int shape;        ///< index in the rigid body's shapes, or PLI_NULL_INDEX
    int node;         ///< of this body, or PLI_NULL_INDEX: the contact is of a face, or of a link
    int face;         ///< of this body, or PLI_NULL_INDEX
    int link;         ///< of this body, which has no faces, or PLI_NULL_INDEX
    int other_node;   ///< of the other soft body, or PLI_NULL_INDEX
    int other_face;   ///< of the other soft body, or PLI_NULL_INDEX
    /// Number of contacts of nodes and faces that are summed: 1 with `each_element`, mostly.
    int contact_count;
    pli_vec3 point;   ///< m, world, on the surface touched, at the end of the step; mean by impulse
    pli_vec3 normal;  ///< unit, world, towards this body; mean by impulse
    pli_vec3 impulse; ///< N s, world: what this body got in the step, friction included; the other got the opposite
    bool is_sensor;   ///< touched by a sensor, which pushes nothing
} pli_contact_event;

/// What is told.
typedef struct pli_contact_events_def {
    /// Default false: one contact for each rigid or soft body that is touched, with sums and means, and with the shape,
    /// node and face that pushed hardest. True: one for each node and face.
    bool each_element;
    /// Default false. True: to this body all rigid bodies are sensors in addition to what contacts it has, so that a
    /// body without contacts tells what it meets.
    bool senses_all;
    uint32_t cookie; ///< set by the default function
} pli_contact_events_def;

/// Defaults of the fields.
PLI_API pli_contact_events_def pli_contact_events_def_default(void);

/// Tells of contacts that pli_body_enable_rigid_contacts, pli_body_enable_rigid_face_contacts and
/// pli_body_enable_soft_contacts make, and of nodes within the margin of sensors, with any solver; or changes how, and
/// what is touched begins anew. Contacts of clusters and of a body with itself are not among them.
/// A contact begins in the step in which it first pushes; it lasts while it pushes, or is not farther from the surface
/// than a quarter of the margin.
/// @param def NULL for the defaults; copied
/// @return PLI_ERROR_OUT_OF_MEMORY, PLI_ERROR_WRONG_STATE while stepping
/// Cost: about 500 B for each that is told; one visit of all contacts per step.
PLI_API pli_status pli_body_enable_contact_events(pli_body* body, const pli_contact_events_def* def);

/// Ends it. Nothing when not enabled.
/// @return PLI_ERROR_WRONG_STATE while stepping
PLI_API pli_status pli_body_disable_contact_events(pli_body* body);

/// The contacts of the last step, in the order in which they were found. A body that is frozen has none, and goes on
/// from those that it had when it steps again.
/// @param phase which
/// @param count their number; 0 when events are not enabled; may be NULL
/// @return [count], valid until the next step or until events are enabled or disabled; NULL with a count of 0
PLI_API const pli_contact_event* pli_body_get_contact_events(const pli_body* body, pli_contact_phase phase, int* count);

#ifdef __cplusplus
}
#endif
#endif
