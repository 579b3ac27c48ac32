#pragma once

/* Contacts of nodes with faces of other bodies: feature soft_contacts.c, search ..._find.c, solve ..._couple.c. */

#include "body/contact_report.h"
#include "contact/contact_substep.h"
#include "geometry/bvh.h"
#include "math/bounds.h"
#include "pliant/contact.h"

/* Of the margins: nodes that are so much farther have contacts too, and are looked for in the next step. */
#define PLII_SOFT_CONTACTS_SLACK 0.25f

typedef struct plii_soft_contact {
    pli_body* face_body;
    int node, face;
    pli_vec3 weights;
    union {
        float distance; /* m, of the nearest point, 0 where the node crosses the face or is inside; until the first
                           sweep */
        pli_vec4 start; /* m, of the node from the point of the face, with shifts, when all bodies had that sweep */
    };
    pli_vec3 normal; /* from the face to the node */
    float margin, friction;
    bool is_bullet;  /* of Bullet's boxes: every face in reach, which is the margin */
    bool is_grouped; /* the first one of four that are solved at once */
    union {
        struct {
            float hardness, weight; /* 1/kg, of node and face together */
            float shift;            /* m, of the overlap, taken back in this step or substep */
            pli_vec3 friction_push; /* kg m, in it */
            float multiplier;       /* likewise; one record with friction_push, as the normal with the margin */
        };
        struct { /* of Bullet's, shares of the correction (cfm) */
            float node_share, face_share;
        };
    };
} plii_soft_contact;

typedef struct plii_soft_contacts_node {
    int node;
    float reach, margin; /* how far it looks for faces, how far it is held off them; m */
    float motion;        /* against any point of the other body in the step, at most; m */
} plii_soft_contacts_node;

typedef struct plii_soft_contacts_state {
    pli_soft_contacts_def def;
    plii_soft_contact* contacts;
    int count, capacity;
    /* Of contacts with bodies of which one records them, and of those before; and the bodies that this one met. */
    plii_contact_impulses impulses;
    int impulse_count;
    pli_body** met;
    int met_count, met_capacity;
    pli_vec3* predicted; /* [node_count] m */
    pli_vec3* shifts;    /* [node_count] of body->soft_shifts */
    float* missed;       /* [node_count] m, how far from there the nodes ended in the step before */
    bool is_sweeping;    /* without Bullet's boxes; the body counts it among its sweeping features */
    int sweeps;          /* over the contacts in this step */
    pli_vec3 parting;    /* m, by which the body moves at the end of it, out of others that it overlaps */
    /* For the search; kept by the first body of a pair. */
    plii_soft_contacts_node* nodes; /* near the other body */
    int node_count, node_capacity;
    int* faces; /* near them */
    int face_count, face_capacity;
    pli_bounds* boxes; /* of `faces`, and what finds them */
    int box_capacity;
    plii_bvh4 near;
    int* face_order; /* [order_count] own faces, neighbours in space one after the other; 0: not known */
    int order_count, order_capacity;
    int* hits; /* PLII_BVH4_ROOM of them */
    int hit_count, hit_capacity;
    int* groups; /* PLII_BVH4_GROUP_ROOM */
    int group_capacity;
} plii_soft_contacts_state;

static inline bool plii_soft_contacts_box_is_finite(pli_bounds box) {
    return plii_vec3_is_finite(box.min) && plii_vec3_is_finite(box.max);
}

/* Nodes of one body against faces of another. */
typedef struct plii_soft_contacts_pass {
    pli_body* node_body;
    plii_soft_contacts_state* node_state;
    pli_body* face_body;
    plii_soft_contacts_state* face_state;
    plii_soft_contacts_state* search;
    float margin;            /* sum of both */
    float fall;              /* m, by gravity in this step, from rest */
    pli_vec3 common_motion;  /* of the faces in this step; zero with Bullet's boxes, whose reach is that of the nodes */
    float other_motion;      /* m, of a node of the faces beside that, at most */
    pli_bounds other_bounds; /* of the faces, where the step leads */
    bool use_boxes;
    bool is_second;    /* the nodes are those of the second body */
    bool looks_inside; /* for nodes inside of the faces, which go out */
} plii_soft_contacts_pass;

/* Finds the contacts of two bodies, of the nodes of each with the faces of the other. */
void plii_soft_contacts_collide(pli_body* body, void* data, pli_body* other, void* other_data);
void plii_soft_contacts_reserve(pli_body* body, void* data);

/* Of the contacts of a node with all bodies together those with the nearest faces. */
void plii_soft_contacts_keep_nearest(const pli_body* body, plii_soft_contacts_state* state);
/* Of each other: one was put where it is lately, with both surfaces closed and none inside out. What is within the
   bounds of the other one, as in a balloon, may stay there. */
bool plii_soft_contacts_may_be_inside(const pli_body* body, const pli_body* other);
/* Such bodies, as a whole, without speed or strain. Contacts of the two: from `first` and `other_first` on. */
void plii_soft_contacts_part(pli_body* body, plii_soft_contacts_state* state, int first, pli_body* other,
                             plii_soft_contacts_state* other_state, int other_first);
void plii_soft_contacts_couple(pli_body* body, void* data);
void plii_soft_contacts_settle(pli_body* body, void* data);
