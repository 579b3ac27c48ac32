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
    /* Where they may press nodes against bodies that nothing moves. */
    bool has_fixed_nodes;
    int* fixed_of_node; /* [node_count] index + 1 of a contact */
} plii_rigid_substeps;

typedef struct plii_rigid_contacts {
    pli_rigid_contacts_def def;
    plii_rigid_contact* contacts;
    int count, capacity;
    int linked;        /* contacts that `last_of_node` knows */
    int* last_of_node; /* [node_count] index of a contact */
    plii_contact_impulses impulses;
    plii_rigid_substeps substeps;
} plii_rigid_contacts;

extern const plii_substep_class plii_rigid_contacts_substepped;

/* Gives way to nodes that have no room between the surfaces found last and others. */
void plii_rigid_contacts_squeeze(const pli_body* body, plii_rigid_contacts* found);
/* Room for the contacts of a step. */
void plii_rigid_substeps_reserve(pli_body* body, plii_rigid_substeps* substeps, int count);
