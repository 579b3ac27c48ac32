#ifndef PLII_SUPPORT_GROUPS_H
#define PLII_SUPPORT_GROUPS_H

/* Farthest points of large, deforming sets of nodes without looking at every node: near nodes are grouped once, groups
   get bounds when the set is first asked in a step, and a query only looks into groups whose bounds reach far enough.
   About the square root of the number of nodes per query. */

#include "context.h"
#include "vec.h"

/* Sets up to this size are searched one by one. */
#define PLII_SUPPORT_GROUPS_MIN 48

typedef struct plii_support_groups {
    int count; /* groups; 0 for a small set */
    int node_count;
    int* nodes;         /* [node_count] group after group */
    int* begin;         /* [count + 1] */
    pli_bounds* bounds; /* [count] */
    bool has_bounds;    /* of this step */
} plii_support_groups;

/* Groups `nodes` by where they are. False when out of memory. */
bool plii_support_groups_create(pli_context* context, const pli_vec4* positions, const int* nodes, int node_stride,
                                int node_count, plii_support_groups* groups);
void plii_support_groups_update(const pli_vec4* positions, plii_support_groups* groups);
/* The farthest node along `direction`. */
int plii_support_groups_query(const pli_vec4* positions, const plii_support_groups* groups, pli_vec3 direction);
void plii_support_groups_release(pli_context* context, plii_support_groups* groups);
size_t plii_support_groups_bytes(const plii_support_groups* groups);

#endif
