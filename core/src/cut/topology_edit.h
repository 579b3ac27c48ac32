#pragma once

/* A change of a body's nodes, links and faces on a copy, which replaces the body's own at the end or not at all. What
   there is no memory for the scratch notes, and the edit fails at its end: until then it does no harm to go on. */

#include "base/edge_map.h"
#include "body/body_impl.h"

typedef struct plii_edit_node {
    pli_vec4 position, previous, velocity; /* as the body's */
    plii_node_origin origin;               /* of new nodes */
} plii_edit_node;

typedef struct plii_edit_link {
    int nodes[2];
    float rest_squared; /* m^2 */
    plii_link_tag tag;
} plii_edit_link;

typedef struct plii_edit_face {
    int nodes[3];
    uint16_t material;
    plii_face_origin origin;
} plii_edit_face;

typedef struct plii_edit {
    plii_walk walk;
    pli_body* body;
    pli_context* context;
    const char* function;        /* messages name it */
    plii_topology* old_topology; /* held until the end */
    int old_node_count, old_link_count;
    int node_count, link_count, face_count;
    int node_capacity, link_capacity, face_capacity;
    plii_edit_node* nodes;
    plii_edit_link* links;
    plii_edit_face* faces;
    bool takes_rest_shape; /* rest lengths and areas become the present ones */
    bool is_unchanged;     /* the body stays as it is */
    plii_scratch scratch;  /* until the end, or freed before */
    plii_edge spare;       /* in place of one that there is no memory for */
} plii_edit;

/* Room for one more in a list; false when out of memory. */
#define PLII_EDIT_GROW(edit, data, capacity, count)                                                                    \
    (PLII_GROW((edit)->context, data, capacity, count) || !((edit)->scratch.is_short = true))

/* A walk over an idle body, until plii_edit_end. Fails when out of memory: there is nothing to end then. */
pli_status plii_edit_open(pli_body* body, const char* function, plii_edit* edit);
/* With `status` PLI_OK replaces the nodes, links and faces of the body and lets all features follow; on failure all is
   as before. Returns what became of it; PLI_ERROR_OUT_OF_MEMORY gets its message here, other errors have theirs. */
pli_status plii_edit_end(plii_edit* edit, pli_status status);
/* Tetrahedra cannot be cut: PLI_OK, or the error of one that `is_met`; `how` as "the blade meets". */
typedef bool plii_edit_tetra_fn(const int nodes[4], const void* user);
pli_status plii_edit_check_tetras(const plii_edit* edit, plii_edit_tetra_fn* is_met, const void* user, const char* how);

static inline pli_vec3 plii_edit_position(const plii_edit* edit, int node) {
    return plii_xyz(edit->nodes[node].position);
}
static inline bool plii_edit_link_is_bending(const plii_edit_link* link) {
    return (link->tag & PLII_LINK_TAG_BENDING) != 0;
}

/* A node between two, which give it mass as in btSoftBody::refine. Node 0 when out of memory. */
int plii_edit_add_node(plii_edit* edit, int a, int b, float share);
/* A second node at the same point; both have half of the mass. */
int plii_edit_copy_node(plii_edit* edit, int node);
void plii_edit_add_link(plii_edit* edit, plii_edit_link link);
void plii_edit_add_face(plii_edit* edit, plii_edit_face face);
/* Of a map, as plii_edge_map_add, but never NULL. */
plii_edge* plii_edit_add_edge(plii_edit* edit, plii_edge_map* map, int a, int b);
/* Parts a link at `share` of its length from its end `from`: the half there ends at node `near`, the other at `far`. */
void plii_edit_split_link(plii_edit* edit, int link, int from, float share, int near, int far);
/* Removes the links that go; each swaps with the last one, as in btSoftBody. */
typedef bool plii_edit_link_fn(const plii_edit_link* link, void* user);
void plii_edit_remove_links(plii_edit* edit, plii_edit_link_fn* goes, void* user);

/* Squared distance, at rest, from a node to the point at `share` from b to c, by Stewart's theorem. Squared rest
   lengths are those of the links in the map; where there is none, of the present distance. */
float plii_edit_median_squared(const plii_edit* edit, const plii_edge_map* map, int node, int b, int c, float share);
/* Adds the edges of all faces that have an edge with a node on it, and takes the rest lengths of links along edges that
   are in the map, for those of new links. */
void plii_edit_learn(plii_edit* edit, plii_edge_map* map);

/* Parts the links and the faces whose edges have a node on them in the map, in the order of btSoftBody::refine; faces
   get links between their new nodes. */
void plii_edit_split(plii_edit* edit, plii_edge_map* map);

/* Parts faces from each other along the edges in `cuts`: at each end of a cut edge the faces fall into groups that hang
   together over edges that are not cut, and each group but the first gets a node of its own. So surfaces stay manifold
   whatever is cut, and the end of a cut inside of a surface stays closed. Links along a cut edge are doubled;
   bending links of parted nodes go; other links without faces go with the group on the side of their other end, by the
   sign of `heights`.

   `heights` [height_count] of the nodes; later ones have 0.
   `is_parted` [edit->node_count at the call] becomes 1 for the nodes that were parted.
   `doubled` grows by the number of links between nodes below `height_count` that were doubled. */
void plii_cut_separate(plii_edit* edit, const plii_edge_map* cuts, const double* heights, int height_count,
                       uint8_t* is_parted, int* doubled);
