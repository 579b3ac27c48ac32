#ifndef PLII_SUPPORT_POINTS_H
#define PLII_SUPPORT_POINTS_H

/* Farthest points of deforming sets of nodes. The coordinates of a set are packed when it is first asked in a step, and
   several are looked at at once. Large sets are not looked at whole: near nodes are grouped once, groups get bounds in
   each step, and a query only looks into groups whose bounds reach far enough, about the square root of the number of
   nodes. Sets of a few nodes are not kept here at all. */

#include "base/context.h"
#include "math/vec.h"

#define PLII_SUPPORT_LANES 8
/* Smaller sets are searched by whoever has them. */
#define PLII_SUPPORT_PACKED_MIN 12
/* Smaller sets are searched whole. */
#define PLII_SUPPORT_POINTS_MIN 192

/* PLII_SUPPORT_LANES points; places that are left over repeat the first of the set. */
typedef struct plii_support_block {
    float x[PLII_SUPPORT_LANES], y[PLII_SUPPORT_LANES], z[PLII_SUPPORT_LANES];
} plii_support_block;

typedef struct plii_support_points {
    int node_count;             /* 0 for a set that is too small */
    int* nodes;                 /* [node_count] group after group */
    plii_support_block* packed; /* their coordinates, of this step; NULL with groups */
    int count;                  /* groups; 0 for a set that is searched whole */
    int* begin;                 /* [count + 1] */
    pli_bounds* bounds;         /* [count], of this step */
    bool is_current;            /* what is of this step has been made */
} plii_support_points;

static inline size_t plii_support_block_count(const plii_support_points* groups) {
    return ((size_t)groups->node_count + PLII_SUPPORT_LANES - 1) / PLII_SUPPORT_LANES;
}

/* Groups `nodes` by where they are. False when out of memory. */
bool plii_support_points_create(pli_context* context, const pli_vec4* positions, const int* nodes, int node_stride,
                                int node_count, plii_support_points* groups);
void plii_support_points_update(const pli_vec4* positions, plii_support_points* groups);
/* The farthest node along `direction`. */
int plii_support_points_query(const pli_vec4* positions, const plii_support_points* groups, pli_vec3 direction);
/* How far a set with packed coordinates reaches along `direction`. */
float plii_support_points_reach(const plii_support_points* groups, pli_vec3 direction);
/* True when a line from `hub` to a node of a set with packed coordinates passes `point` within `distance`, so that the
   hull does where it holds the hub; false says nothing. The way from the nearest of these lines to `point` goes to
   `gap`; zero where nothing is packed. */
bool plii_support_points_has_near(const plii_support_points* groups, pli_vec3 hub, pli_vec3 point, float distance,
                                  pli_vec3* gap);
/* The nodes of a set with packed coordinates that lie less than `limit` above the plane through `foot`, in its order;
   fewer than PLII_SUPPORT_POINTS_MIN. */
int plii_support_points_find_below(const plii_support_points* groups, pli_vec3 foot, pli_vec3 normal, float limit,
                                   pli_vec3* points, float* heights);
void plii_support_points_release(pli_context* context, plii_support_points* groups);
size_t plii_support_points_bytes(const plii_support_points* groups);

#endif
