#ifndef PLII_SOFT_SURFACE_H
#define PLII_SOFT_SURFACE_H

/* The faces of a body as contacts of other bodies see them: how they hang together, and where they are. */

#include "body/body_impl.h"
#include "geometry/bvh4.h"

typedef struct plii_soft_surface {
    /* How faces hang together; good for as long as the body has these faces, however it bends. */
    int* order;          /* [face_count] neighbours in space one after the other */
    int (*neighbors)[3]; /* [face_count] the face beyond the edge from node k on, or PLI_NULL_INDEX */
    int face_count, order_capacity, neighbor_capacity; /* 0: not known */
    bool has_loose_nodes;                              /* that no face has */
    bool is_whole;                                     /* one piece, in which neighbours go round the same way */
    bool is_closed;                                    /* and without a rim */
    bool is_inward; /* closed, and its faces go round clockwise as seen from outside */
    /* Where they are in this step. */
    bool is_placed;
    float inverse_mass; /* 1/kg, of the body as a whole; 0 where a node is pinned or anchored */
    pli_vec3 motion;    /* m, mean of the nodes in this step */
    pli_bounds* boxes;
    int box_capacity;
    plii_bvh4 tree; /* over the faces in `order` */
    int* hits;
    int hit_capacity;
    uint8_t*
        near_nodes; /* [node_count] of the pair that is being searched: 1 where a node can be near the other body */
    int near_capacity;
} plii_soft_surface;

static inline pli_bounds plii_soft_surface_face_bounds(const pli_vec4* positions, const int* face) {
    const pli_vec3 a = plii_xyz(positions[face[0]]), b = plii_xyz(positions[face[1]]), c = plii_xyz(positions[face[2]]);
    const pli_bounds bounds = {plii_vec3_min(a, plii_vec3_min(b, c)), plii_vec3_max(a, plii_vec3_max(b, c))};
    return bounds;
}

/* Takes what does not change from step to step, unless it is known, and makes room. False when out of memory. */
bool plii_soft_surface_reserve(const pli_body* body, plii_soft_surface* surface);
/* Fills `near_nodes`: nodes of faces that come within `reach` of the faces of another body, and nodes without faces. */
void plii_soft_surface_find_near(const pli_body* body, plii_soft_surface* surface, const plii_soft_surface* other,
                                 float reach);
/* The predicted positions, once per step. False when out of memory. */
bool plii_soft_surface_place(const pli_body* body, plii_soft_surface* surface);

#endif
