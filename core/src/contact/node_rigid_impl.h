#pragma once

/* Contacts of nodes with rigid bodies: the feature is node_rigid_contacts.c, its substeps node_rigid_substep.c. */

#include "body/contact_report.h"
#include "contact/node_rigid_groups.h"
#include "contact/point_contacts.h"
#include "pliant/contact.h"

typedef struct plii_rigid_contact {
    pli_rigid* rigid;
    int node, shape;
    pli_vec4 normal; /* w, the offset: dot(normal, x) + w = distance to the surface that is kept free */
    float distance;
    bool is_fixed;  /* the rigid body takes no impulses */
    bool is_still;  /* nor does it move */
    float hardness; /* for solvers of whole steps. Bullet: c4 */
    union {
        struct {             /* as Bullet solves it */
            pli_mat3 matrix; /* from the change of displacement that is wanted to an impulse. Bullet: c0 */
            pli_vec3 arm;    /* from the rigid body's centre of mass to the node. Bullet: c1 */
            float slip;      /* share of the tangential displacement that stays. Bullet: c3 */
        };
        struct {
            bool goes_along; /* the node, with the rigid body in this step */
            pli_vec3 offset; /* m, from the rigid body's centre of mass: where the node is on it at the end, if so */
            float squeeze;   /* m, see node_rigid_squeeze.c */
            int before;      /* a contact of the same node with a body that takes no impulses, if it is one */
            int place;       /* in the lists of substeps, group by group or point by point; PLI_NULL_INDEX: no memory */
        };
    };
} plii_rigid_contact;

/* The contacts of a step as substeps solve them; empty while another solver steps the body. */
typedef struct plii_rigid_substeps {
    plii_rigid_groups groups;     /* with bodies that nothing moves */
    plii_point_contacts contacts; /* with others */
    bool has_fixed_nodes;         /* these may press nodes against bodies that nothing moves */
} plii_rigid_substeps;

typedef struct plii_rigid_contacts {
    pli_rigid_contacts_def def;
    plii_rigid_contact* contacts;
    int count, capacity;
    int linked;         /* contacts that `fixed_of_node` knows */
    int* fixed_of_node; /* [node_count] a contact with a body that takes no impulses: the last one while they are found,
                           in substeps the nearest. A hint, see plii_rigid_contacts_has_fixed */
    plii_contact_impulses impulses;
    plii_rigid_substeps substeps;
} plii_rigid_contacts;

extern const plii_substep_class plii_rigid_contacts_substepped;

/* Indices that are kept of contacts are hints: of a step before, or of before some were taken out or put in order. */
static inline bool plii_rigid_contacts_has_fixed(const plii_rigid_contacts* found, int index, int end, int node) {
    return index >= 0 && index < end && found->contacts[index].node == node && found->contacts[index].is_fixed;
}
/* Gives way to nodes that have no room between the surfaces found last and others. */
void plii_rigid_contacts_squeeze(const pli_body* body, plii_rigid_contacts* found);
/* Room for the contacts of a step. */
void plii_rigid_substeps_reserve(pli_body* body, plii_rigid_substeps* substeps, int count);
