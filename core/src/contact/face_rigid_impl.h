#pragma once

/* Contacts of faces with rigid shapes: the feature is face_rigid_contacts.c, their making face_rigid_detect.c. */

#include "body/node_constraint.h"
#include "body/world_state.h"
#include "contact/face_sweep.h"
#include "contact/node_rigid_impl.h"
#include "geometry/pair_cache.h"

typedef struct plii_rigid_face_contact {
    pli_rigid* rigid;
    int candidate;      /* while the step lasts */
    int shape, element; /* index in the rigid body's shapes; face, or link */
    int nodes[3];
    pli_vec3 weights;
    pli_vec3 normal;     /* out of the rigid body */
    pli_vec3 start;      /* of the step: the witness point of the face */
    pli_vec3 core_point; /* nearest point of the core, in the frame of the rigid body */
    bool is_triangle;    /* of a shape that is not convex */
    pli_vec3 triangle[3];
    float excess;   /* m, see plii_face_sweep_excess */
    float target;   /* of the gap at the end of the step; m, <= 0 */
    float given_up; /* of the gap: what no contact can bring back; m, <= 0 */
    float distance;
    float slip; /* share of the tangential displacement that stays */
    float push; /* impulse along the normal in this step; N s */
    /* For the end of the step as far as it is known; see plii_rigid_faces_prepare_contact. */
    pli_mat3 impulse_matrix;
    float normal_response; /* change of the gap per impulse along the normal; m/(N s) */
    pli_vec3 arm;          /* from the rigid body's centre of mass to the margin around it, at the start of the step */
    pli_vec3 base;         /* base + velocity at the arm * dt = that point of the surface at the end of the step */
} plii_rigid_face_contact;

/* A rigid shape that was met in this step. The host may change the shapes of the rigid body before the solve. */
typedef struct plii_rigid_faces_candidate {
    pli_rigid* rigid;
    int shape_index;
    pli_shape* shape; /* retained until the end of the step */
    pli_transform shape_pose;
    pli_transform begin;          /* pose of the rigid body at the start of the step */
    pli_bounds bounds;            /* of the shape on its way */
    int nodes_begin, nodes_count; /* contacts of nodes with it, by node */
} plii_rigid_faces_candidate;

typedef struct plii_rigid_faces {
    pli_rigid_face_contacts_def def;
    plii_rigid_face_contact* contacts;
    int count, capacity;
    plii_contact_impulses impulses;
    plii_rigid_faces_candidate* candidates;
    int candidate_count, candidate_capacity;
    plii_pair_cache memory; /* sides of pairs at the end of the last step, and where they touched */
    plii_point_contacts substeps;
} plii_rigid_faces;

/* One rigid shape and the elements of the body, at one moment of the solve. */
typedef struct plii_rigid_faces_pass {
    pli_body* body;
    plii_rigid_faces* state;
    const plii_rigid_faces_candidate* candidate;
    bool has_links;    /* elements are links */
    pli_transform end; /* pose of the rigid body */
    plii_face_core core;
    float radius;
    const plii_shape_triangle* triangle; /* the piece that the core is; NULL when the shape is convex */
    pli_bounds bounds;                   /* of the shape on its way */
    bool is_at_end;                      /* nodes are where the step has brought them */
    int element;                         /* that is visited, and its nodes */
    int nodes[3];
} plii_rigid_faces_pass;

plii_rigid_faces_pass plii_rigid_faces_make_pass(pli_body* body, plii_rigid_faces* state, int candidate_index);

/* What is done with elements whose ways come within `reach` of the shape, or of a triangle that it consists of. */
typedef void plii_rigid_faces_visit_fn(const plii_rigid_faces_pass* pass, const plii_face_sweep* sweep);
void plii_rigid_faces_visit(plii_rigid_faces_pass* pass, float reach, plii_rigid_faces_visit_fn* visit);

/* With a rigid body that may be met in this step. */
void plii_rigid_faces_collide(pli_body* body, void* data, pli_rigid* rigid);
/* Contacts that the motion before the solve did not foresee. Returns how many there are. */
int plii_rigid_faces_review(pli_body* body, plii_rigid_faces* state);

/* Whether a node of a face has no room between the shape and another one, see node_rigid_squeeze.c. */
bool plii_rigid_faces_is_squeezed(const pli_body* body, const plii_rigid_faces_candidate* candidate, const int* nodes);
plii_pair_key plii_rigid_faces_key(const plii_rigid_faces_pass* pass);

/* By the solver itself, which leaves only what its contacts do not know. */
static inline bool plii_rigid_faces_are_solved(const pli_body* body) {
    return body->solver_class->solves_constraints || plii_follows_rigids(body);
}

/* Lever, base and response of a contact, with the rigid body at `end` at the end of the step. */
void plii_rigid_faces_prepare_contact(const pli_body* body, const plii_rigid_faces_candidate* candidate,
                                      pli_transform end, plii_rigid_face_contact* contact);

void plii_rigid_faces_drop_candidates(plii_rigid_faces* state, int count);
pli_vec3 plii_rigid_faces_point(const pli_vec4* positions, const plii_rigid_face_contact* contact);
