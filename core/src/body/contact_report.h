#pragma once

/* What a contact of a body has done in a step, for features that tell of it. Features that make contacts note what
   these push while `records_contacts` is set in the body, and are visited when all bodies are solved. */

#include "body/body_impl.h"

typedef struct plii_contact_report {
    pli_rigid* rigid;                             /* or NULL */
    int shape;                                    /* of the rigid body, or PLI_NULL_INDEX */
    pli_body* other;                              /* or NULL */
    int node, face, link, other_node, other_face; /* or PLI_NULL_INDEX */
    pli_vec3 point;                               /* m, at the end of the step */
    pli_vec3 normal;                              /* unit, towards the body */
    pli_vec3 impulse;                             /* N s, on the body */
    float gap;                                    /* m, to the surface that is kept free, at the end of the step */
    int node_count, nodes[3];                     /* that touch a rigid body; else 0 */
    float weights[3];
    bool is_sensor;
} plii_contact_report;

/* With nothing but what is touched. */
static inline plii_contact_report plii_contact_report_make(pli_rigid* rigid, pli_body* other) {
    return (plii_contact_report){.rigid = rigid,
                                 .shape = PLI_NULL_INDEX,
                                 .other = other,
                                 .node = PLI_NULL_INDEX,
                                 .face = PLI_NULL_INDEX,
                                 .link = PLI_NULL_INDEX,
                                 .other_node = PLI_NULL_INDEX,
                                 .other_face = PLI_NULL_INDEX};
}

/* What each contact of a feature has pushed the body by in this step, N s. Not there unless it is recorded. */
typedef struct plii_contact_impulses {
    pli_vec3* items;
    int capacity;
} plii_contact_impulses;

#define PLII_CONTACT_IMPULSES_OF(type, member) PLII_LIST_OF(type, member.items, member.capacity), .snapshot = PLII_LEFT

/* A contact is added to a feature's list. False without memory. */
static inline bool plii_contact_impulses_add(const pli_body* body, plii_contact_impulses* impulses, int index) {
    if (!PLII_RESERVE(body->context, &impulses->items, &impulses->capacity, index + 1)) { return false; }
    impulses->items[index] = pli_vec3_make(0, 0, 0);
    return true;
}
static inline pli_vec3 plii_contact_impulses_get(const pli_body* body, const plii_contact_impulses* from, int index) {
    return body->records_contacts ? from->items[index] : pli_vec3_make(0, 0, 0);
}
static inline void plii_contact_impulses_push(const plii_contact_impulses* impulses, int index, pli_vec3 impulse) {
    impulses->items[index] = pli_vec3_add(impulses->items[index], impulse);
}

/* The call of a user for the contacts of a feature: what it sees of each `contact`. */
#define PLII_DEFINE_CONTACTS_GET(function, type, state_type, contact_type, klass, ...)                                 \
    int function(const pli_body* body, int capacity, type* contacts) {                                                 \
        const state_type* state = plii_feature_state_for(body, &(klass), __func__);                                    \
        for (int i = 0; state != NULL && contacts != NULL && i < capacity && i < state->count; ++i) {                  \
            const contact_type* contact = &state->contacts[i];                                                         \
            contacts[i] = __VA_ARGS__;                                                                                 \
        }                                                                                                              \
        return state != NULL ? state->count : 0;                                                                       \
    }

/* An order of contacts that the caller gives, for comparisons with other engines: contact `order[i]` of the first array
   of a feature comes to place i. Fails, and changes nothing, when the feature is not enabled, the world not between
   predict and solve, or `order` does not name each once. */
pli_status plii_reorder_contacts(pli_body* body, const plii_feature_class* klass, const int* order, int count,
                                 const char* function);
