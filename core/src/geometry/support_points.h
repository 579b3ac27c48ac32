#pragma once

/* Farthest points of deforming sets of nodes. The coordinates of a set are packed when it is first asked in a step, and
   several are looked at at once. Sets of a few nodes are not kept here at all. */

#include "base/context.h"
#include "math/vec.h"

#define PLII_SUPPORT_LANES 8
/* Smaller sets are searched by whoever has them. */
#define PLII_SUPPORT_POINTS_MIN 12

/* PLII_SUPPORT_LANES points; lanes that are left over repeat the first of the set. */
typedef struct plii_support_block {
    float x[PLII_SUPPORT_LANES], y[PLII_SUPPORT_LANES], z[PLII_SUPPORT_LANES];
} plii_support_block;

typedef struct plii_support_points {
    int node_count;             /* 0 for a set that is too small */
    int* nodes;                 /* [node_count] */
    plii_support_block* packed; /* their coordinates, of this step */
    bool is_current;            /* they have been packed */
} plii_support_points;

static inline size_t plii_support_block_count(const plii_support_points* set) {
    return ((size_t)set->node_count + PLII_SUPPORT_LANES - 1) / PLII_SUPPORT_LANES;
}

/* False when out of memory. */
bool plii_support_points_create(pli_context* context, const int* nodes, int node_stride, int node_count,
                                plii_support_points* set);
void plii_support_points_update(const pli_vec4* positions, plii_support_points* set);

// Of sets that are kept and current.

/* The farthest node along `direction`. */
int plii_support_points_query(const plii_support_points* set, pli_vec3 direction);
/* How far the set reaches along `direction`. */
float plii_support_points_reach(const plii_support_points* set, pli_vec3 direction);
void plii_support_points_release(pli_context* context, plii_support_points* set);
size_t plii_support_points_bytes(const plii_support_points* set);
