#pragma once

/* Pairs of a body's nodes that could touch before the next search. Each node has a path, along which it is expected to
   go on, and a margin for what constraints change; a pair that could touch on its paths, or within the margins, is
   kept. When nodes have left their paths by more than their margins, they are searched again; so no pair is missed, at
   any speed. A node that strayed gets a larger margin. Where few have strayed they are apart: searched one by one. */

#include "base/ranges.h"
#include "body/link_graph.h"
#include "geometry/spatial_hash.h"
#include "self_collision/self_collision_impl.h"

typedef struct plii_self_pair {
    int a, b;
    float distance; /* to keep: the thickness, or the distance at rest where that is smaller, m */
} plii_self_pair;

typedef struct plii_self_pair_list {
    plii_self_pair* items;
    int count, capacity;
} plii_self_pair_list;

/* What a search of single nodes works with. */
typedef struct plii_self_search {
    plii_node_pairs near;
    uint16_t* linked;    /* [node_count] `mark`: joined by a link to the node that was looked at last */
    int linked_capacity; /* of a part */
    uint16_t mark;
} plii_self_search;

/* A block of a search on several threads. */
typedef struct plii_self_search_part {
    plii_self_search search;
    plii_self_pair_list found;
    bool is_truncated;
} plii_self_search_part;
enum { PLII_SELF_SEARCH_PARTS = 16 };

typedef struct plii_self_node_pairs {
    pli_vec3* rest;     /* [node_count] positions, as all that follow, but for the last three */
    pli_vec4* local;    /* relative to an origin */
    pli_vec4* searched; /* at the last search */
    pli_vec4* travel;   /* expected from there in `travel_time`; w = margin, m */
    pli_vec3* middle;   /* half of the path */
    bool* is_apart;     /* searched alone since the last search of all */
    int* apart;         /* [apart_count] nodes */
    float thickness;
    int apart_count;
    float searched_at; /* s since the start of the step */
    float travel_time; /* s */
    pli_vec3 drift;    /* mean travel */
    float reach;       /* of all nodes, at most: margin + half of what they travel beside the drift */
    pli_vec4* at;      /* [node_count] now; w = inverse mass: `local`, or the solver's own */
    plii_spatial_hash hash;
    plii_self_search search;
    plii_self_search_part parts[PLII_SELF_SEARCH_PARTS]; /* where there are threads */
    plii_self_pair_list found;
    bool is_known;     /* there was a search, of these nodes */
    bool is_truncated; /* some are missing, for lack of memory or in a crowd */
    int searches;
} plii_self_node_pairs;

/* Room of `apart`, for so many nodes one, and some. */
enum { PLII_SELF_NODES_PER_APART = 32, PLII_SELF_NODES_APART = 64 };

/* The table of the last search, from `middle` and `reach`. */
void plii_self_node_pairs_rebuild(pli_body* body, plii_self_node_pairs* state);
/* With new arrays of nodes, which the caller declares. */
void plii_self_node_pairs_start(plii_self_node_pairs* state);
/* Takes positions over to `local`, relative to an origin. */
void plii_self_node_pairs_copy(const pli_body* body, plii_self_node_pairs* state, const plii_substep* substep,
                               const pli_vec3* origin);
/* More than folded cloth has, so that there is room before it folds. */
#define PLII_SELF_PAIRS_PER_NODE 6

/* All start from `at`. */

/* At the start of a step: whether what the last search found may serve for this step too, as with a body at rest, and
   prepares for it. Most nodes are expected to stay within their margins then. */
bool plii_self_node_pairs_serve_on(const pli_body* body, plii_self_node_pairs* state, float thickness);
/* At the start of a step: nodes go on with their velocities, and are as reliable as they were in the last step.
   `shift`: from the positions of the last step to those of this one, where both are relative to an origin. */
void plii_self_node_pairs_search_step(const pli_body* body, plii_self_node_pairs* state, pli_vec3 shift);
/* At the end of a substep: searches what has left its path, if anything has. Given an origin, positions are taken over
   before. */
void plii_self_node_pairs_update(const pli_body* body, plii_self_node_pairs* state, const plii_substep* substep,
                                 const pli_vec3* origin);
