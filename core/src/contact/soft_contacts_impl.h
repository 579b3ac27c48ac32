#ifndef PLII_SOFT_CONTACTS_IMPL_H
#define PLII_SOFT_CONTACTS_IMPL_H

/* Contacts of nodes with the faces of other soft bodies: state shared by the feature (soft_contacts.c), the search
   (soft_contacts_find.c), the solve (soft_contacts_solve.c), and both in reference mode (soft_contacts_reference.c). */

#include "body/substep.h"
#include "contact/soft_surface.h"
#include "geometry/bvh.h"
#include "pliant/contact.h"

/* That a node has at most, with all other bodies together; not in reference mode. */
enum { PLII_SOFT_CONTACTS_PER_NODE = 4 };

typedef struct plii_soft_contact {
    pli_body* face_body;
    int node, face;
    int corners[3];          /* nodes of the face */
    int next;                /* of the same node, or PLI_NULL_INDEX */
    pli_vec4 normal;         /* from the face to where the node belongs */
    pli_vec4 weights;        /* of the corners; w = 0 */
    pli_vec4 inverse_masses; /* of the corners by their weights; w = that of the node, 1/kg */
    float weight;            /* of both sides, 1/kg */
    float margin, friction;
    float gap;   /* m, at the start of the step or substep; while contacts are looked for the predicted one */
    float floor; /* m, the gap that the solve keeps */
    float push;  /* kg m, along the normal, so far */
    pli_vec4 friction_push;
    bool is_behind;    /* the node belongs on the side of the face from which its nodes go round clockwise */
    bool has_side;     /* false: beyond a rim, where there is none */
    bool is_inherited; /* the bodies overlapped here when they met: they are parted as a whole */
    bool is_reference;
    /* In reference mode; of the correction. Bullet: cfm */
    float node_share, face_share;
} plii_soft_contact;

/* What is kept of a contact until the next step. */
typedef struct plii_soft_side {
    const pli_body* body; /* of the face */
    int node, face;
    int next;
    bool is_behind;
    bool is_inherited;
    pli_vec3 normal;
} plii_soft_side;

typedef struct plii_soft_contacts_node {
    int node;
    float reach; /* how far it looks for faces; m */
} plii_soft_contacts_node;

typedef struct plii_soft_contacts_state {
    pli_soft_contacts_def def;
    plii_soft_contact* contacts;
    int count, capacity;
    int* first_contacts; /* [node_count] in `contacts`, or PLI_NULL_INDEX */
    plii_soft_side* sides;
    int side_count, side_capacity;
    int* first_sides;      /* [node_count] */
    bool has_new_contacts; /* not solved yet */
    int step_count;
    pli_vec3 shift; /* m, of the body, that is to come */
    plii_soft_surface surface;
    /* Bullet's boxes, or NULL. */
    pli_bounds* node_boxes; /* [node_count] */
    pli_bounds* face_boxes; /* [face_count] */
    bool has_boxes;         /* false: to be taken from the start of the next step */
    /* For the search with Bullet's boxes; kept by the first body of a pair. */
    plii_soft_contacts_node* nodes; /* near the other body */
    int node_count, node_capacity;
    int* faces; /* near them */
    int face_count, face_capacity;
    pli_bounds* boxes; /* of `faces`, and what finds them */
    int box_capacity;
    plii_bvh tree;
    int* hits; /* as many as there are boxes */
    int hit_count, hit_capacity;
} plii_soft_contacts_state;

extern const plii_feature_class plii_soft_contacts_class;
extern const plii_feature_class plii_soft_reference_class; /* solves contacts of reference mode */
extern const plii_substep_class plii_soft_contacts_substepped;

static inline pli_vec3 plii_soft_contacts_position(const pli_body* body, int node) {
    return plii_xyz(body->positions[node]);
}

static inline pli_vec3 plii_soft_contacts_blend(const pli_vec4* values, const int* face, pli_vec3 weights) {
    return pli_vec3_add(pli_vec3_add(pli_vec3_scale(plii_xyz(values[face[0]]), weights.x),
                                     pli_vec3_scale(plii_xyz(values[face[1]]), weights.y)),
                        pli_vec3_scale(plii_xyz(values[face[2]]), weights.z));
}

static inline bool plii_soft_contacts_box_is_finite(pli_bounds box) {
    return plii_vec3_is_finite(box.min) && plii_vec3_is_finite(box.max);
}

/* Finds the contacts of two bodies, of the nodes of each with the faces of the other. */
pli_status plii_soft_contacts_collide(pli_body* body, void* data, pli_body* other, void* other_data);
/* At the start of a step, while contacts are still those of the step before: bodies that overlapped when they met are
   moved apart as a whole, which neither stretches them nor gives them speed. */
void plii_soft_contacts_part(pli_body* body, plii_soft_contacts_state* state);
/* Then contacts become sides that the search remembers. */
void plii_soft_contacts_remember(const pli_body* body, plii_soft_contacts_state* state);
/* Contacts and sides by node again, after some were moved or dropped. */
void plii_soft_contacts_chain(const pli_body* body, plii_soft_contacts_state* state);

void plii_soft_contacts_solve(pli_body* body, void* data, const plii_step* step);

bool plii_soft_reference_reserve(pli_context* context, plii_soft_contacts_state* search, int nodes, int faces);
pli_status plii_soft_reference_collide(pli_body* body, plii_soft_contacts_state* state, pli_body* other,
                                       plii_soft_contacts_state* other_state);

#endif
