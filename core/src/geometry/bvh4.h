#pragma once

/* Boxes in their order, four at a time, for points that look for those near by: quick to build, and to ask where
   neighbours in the list are neighbours in space. */

#include "base/context.h"
#include "math/vec.h"

/* Four boxes by components; those beyond the last one are empty: NaN, which no search finds. */
typedef struct plii_box4 {
    float low[3][4], high[3][4];
} plii_box4;

#define PLII_BVH4_MAX_LEVELS 16

typedef struct plii_bvh4 {
    int level_count;                     /* 0: no boxes; the last level is one group */
    int begin[PLII_BVH4_MAX_LEVELS + 1]; /* of each level in `groups` */
    plii_box4* groups; /* box i of level 0 is in group i / 4; box i of a level above encloses group i below */
    int capacity;
} plii_bvh4;

/* Replaces what was held. Memory is kept from build to build. False when out of memory: there are no boxes then. */
bool plii_bvh4_build(pli_context* context, plii_bvh4* boxes, int count, const pli_bounds* bounds);
/* Room for that many; false when out of memory. */
bool plii_bvh4_reserve(pli_context* context, plii_bvh4* boxes, int count);
void plii_bvh4_free(pli_context* context, plii_bvh4* boxes);

/* Writes the boxes that touch `bounds`, ascending; returns their number, never more than there are boxes, also where
   numbers are infinite or NaN. `items` has room for all. */
int plii_bvh4_overlaps(const plii_bvh4* boxes, const pli_bounds* bounds, int* items);
/* The same for groups of level 0, for points that lie close together. */
int plii_bvh4_find_groups(const plii_bvh4* boxes, const pli_bounds* bounds, int* groups);
/* Writes the boxes of these groups within `radius` of a point, in the order of the groups; returns their number. */
int plii_bvh4_find(const plii_bvh4* boxes, const int* groups, int group_count, pli_vec3 point, float radius,
                   int* items);
