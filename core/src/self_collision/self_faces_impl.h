#pragma once

/* Self-collision of faces: the feature and its solve are self_faces.c, the search is self_faces_find.c. */

#include "base/ranges.h"
#include "geometry/bvh.h"
#include "self_collision/self_collision_impl.h"

typedef struct plii_self_faces_pair {
    int nodes[4];   /* node and face, or edge and edge */
    bool is_edges;  /* first side: 2 nodes instead of 1 */
    float target;   /* m, distance to keep; < 0: not known yet */
    float distance; /* m, at the start */
    float weights[4];
    pli_vec3 normal; /* unit, from the second side to the first */
    float middle;    /* along the normal, from the start of the first node */
} plii_self_faces_pair;

/* What a block of a search has found: an item with another that is near. */
typedef struct plii_self_faces_hit {
    int item, other;
    float distance; /* m, of their boxes */
} plii_self_faces_hit;
typedef struct plii_self_faces_hits {
    plii_self_faces_hit* items;
    int count, capacity;
    bool is_truncated; /* for lack of memory */
} plii_self_faces_hits;

typedef struct plii_self_faces_state {
    pli_self_faces_def def;
    float reach;            /* m, of the last search; 0: none */
    float moved;            /* m that a node has moved since then at most, beside what all have in common */
    float mean_edge_length; /* m, at rest */
    float travel;           /* m that a node may move in this step, likewise, */
    float motion;           /* in this step or substep */
    int edge_count;
    plii_bvh tree;
    plii_self_faces_hits hits[PLII_MOST_BLOCKS]; /* of the last search, by block; the first for all without threads */
    pli_vec3* rest;                              /* [node_count] */
    pli_vec4* starts;                            /* [node_count] at the start of the step */
    pli_vec3* last;                              /* [node_count] where `moved` has counted to */
    int* firsts;         /* [3 * face_count] first nodes of the edges of all faces, while these are looked for, */
    int *rows, *corners; /* [node_count + 1], [3 * face_count] and these by them */
    int (*edges)[2];     /* [3 * face_count], of which edge_count are in use */
    pli_bounds* boxes;
    plii_self_faces_pair* pairs;
    float* due;  /* [pair_count] value of `moved` up to which a pair cannot come together */
    int* active; /* pairs to be solved in this step or substep */
    int box_capacity, pair_count, pair_capacity, due_capacity, active_count, active_capacity;
    pli_self_faces_report report;
} plii_self_faces_state;

/* How far nodes may go beside their common motion that have these motions before constraints: with some `room` for
   those, `most` at most; pinned nodes, which nothing stops, set their own. */
float plii_self_faces_bound(const pli_body* body, const plii_substep* substep, float room, float most);

/* Edges of all faces, each once. */
void plii_self_faces_find_edges(const pli_body* body, plii_self_faces_state* state);
/* At the start of a step: pairs that could come together in it. `data`: the state. */
void plii_self_faces_begin(pli_body* body, void* data);
/* Collects the pairs that could come together when no node moves by more than `motion` beside the common motion. */
void plii_self_faces_restart(pli_body* body, plii_self_faces_state* state, const plii_substep* substep, float motion);
