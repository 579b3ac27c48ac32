#pragma once

/* What a sweep (cut_swept.c) leaves to its blades (cut_swept_blade.c). */

#include "cut/topology_edit.h"

/* What a cut has not opened yet. */
typedef struct plii_swept_ends {
    int* tips; /* nodes of the cut that are not parted */
    int tip_count, tip_capacity;
    int (*edges)[2]; /* of the cut, between tips */
    int edge_count, edge_capacity;
} plii_swept_ends;

typedef struct plii_swept_work {
    plii_edit edit;
    plii_swept_ends ends; /* of the sweep so far */
    int parted;           /* links */
} plii_swept_work;

/* Cuts by one triangle. PLI_ERROR_OUT_OF_MEMORY has no message yet. */
pli_status plii_swept_cut(plii_swept_work* work, const pli_vec3 corners[3]);

/* Parts faces from each other along the edges in `cuts`: at each end of a cut edge the faces fall into groups that hang
   together over edges that are not cut, and each group but the first gets a node of its own. So surfaces stay manifold
   whatever is cut, and the end of a cut inside of a surface stays closed. Links along a cut edge are doubled;
   bending links of parted nodes go; other links without faces go with the group on the side of their other end, by the
   sign of `heights`.

   `heights` [height_count] of the nodes; later ones have 0.
   `is_parted` [edit->node_count at the call] becomes 1 for the nodes that were parted.
   `doubled` grows by the number of links between nodes below `height_count` that were doubled.
   False when out of memory. */
bool plii_cut_separate(plii_edit* edit, const plii_edge_map* cuts, const double* heights, int height_count,
                       uint8_t* is_parted, int* doubled);
