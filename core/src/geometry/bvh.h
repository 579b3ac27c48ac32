#pragma once

/* A bounding volume tree over boxes, built in linear time and without pointers: the boxes are sorted along a Z-order
   curve, and box i of one level encloses boxes 4i .. 4i + 3 of the level below. */

#include "base/context.h"
#include "math/vec.h"

#define PLII_BVH_FAN 4
/* 4^15 items and the root. */
#define PLII_BVH_MAX_LEVELS 17
/* Entries that a depth-first walk can have waiting. */
#define PLII_BVH_STACK (PLII_BVH_MAX_LEVELS * PLII_BVH_FAN)

typedef struct plii_bvh {
    int count;                          /* items */
    int level_count;                    /* 0 for an empty tree; the last level has one box */
    int begin[PLII_BVH_MAX_LEVELS + 1]; /* of each level in `boxes`; level 0 are the items' own */
    int* items;                         /* [count] the item of each box of level 0 */
    pli_bounds* boxes;
    uint32_t* keys; /* [2 * count] scratch: Z-order keys */
    int* sorting;   /* [count] scratch */
    int item_capacity, box_capacity, key_capacity, sorting_capacity;
} plii_bvh;

/* Levels over `width` boxes of the lowest one, up to a single one: fills `begin`, where each level begins, and after
   the last one the number of all boxes; returns how many levels. */
static inline int plii_bvh_lay_out(int width, int* begin) {
    int box_count = 0, level_count = 0;
    for (;; width = (width + PLII_BVH_FAN - 1) / PLII_BVH_FAN) {
        begin[level_count++] = box_count;
        box_count += width;
        if (width == 1) { break; }
    }
    begin[level_count] = box_count;
    return level_count;
}

/* Replaces what the tree held; the boxes must be finite. Memory is kept from build to build.
   False when out of memory: the tree is then empty. */
bool plii_bvh_build(pli_context* context, plii_bvh* tree, int count, const pli_bounds* boxes);
/* Room for that many; false when out of memory. */
bool plii_bvh_reserve(pli_context* context, plii_bvh* tree, int count);
void plii_bvh_free(pli_context* context, plii_bvh* tree);

/* Calls `visit` with each item whose box overlaps `box` (closed intervals), in no particular order. */
typedef void plii_bvh_visit_fn(int item, void* user);
void plii_bvh_overlaps(const plii_bvh* tree, pli_bounds box, plii_bvh_visit_fn* visit, void* user);

/* Looks for the nearest item. `measure` gives the squared distance of an item, or FLT_MAX to refuse it.
   Returns the item with the smallest squared distance below `max_squared`, or PLI_NULL_INDEX; equally near items go by
   index in the tree. */
typedef float plii_bvh_measure_fn(int item, pli_vec3 point, const void* user);
int plii_bvh_nearest(const plii_bvh* tree, pli_vec3 point, float max_squared, plii_bvh_measure_fn* measure,
                     const void* user);
