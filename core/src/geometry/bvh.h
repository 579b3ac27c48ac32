#ifndef PLII_BVH_H
#define PLII_BVH_H

/* A bounding volume tree over boxes, built in linear time and without pointers: the boxes are sorted along a Z-order
   curve, and box i of one level encloses boxes 4i .. 4i + 3 of the level below. */

#include "base/context.h"
#include "math/vec.h"

#define PLII_BOX_TREE_FAN 4
/* 4^15 items and the root. */
#define PLII_BOX_TREE_MAX_LEVELS 17
/* Entries that a depth-first walk can have waiting. */
#define PLII_BOX_TREE_STACK (PLII_BOX_TREE_MAX_LEVELS * PLII_BOX_TREE_FAN)

typedef struct plii_box_tree {
    int count;                               /* items */
    int level_count;                         /* 0 for an empty tree; the last level has one box */
    int begin[PLII_BOX_TREE_MAX_LEVELS + 1]; /* of each level in `boxes`; level 0 are the items' own */
    int* items;                              /* [count] the item of each box of level 0 */
    pli_bounds* boxes;
    uint32_t* keys; /* [2 * count] scratch: Z-order keys */
    int* sorting;   /* [count] scratch */
    int item_capacity, box_capacity, key_capacity, sorting_capacity;
} plii_box_tree;

/* Replaces what the tree held; the boxes must be finite. Memory is kept from build to build.
   False when out of memory: the tree is then empty. */
bool plii_box_tree_build(pli_context* context, plii_box_tree* tree, int count, const pli_bounds* boxes);
/* Room for that many; false when out of memory. */
bool plii_box_tree_reserve(pli_context* context, plii_box_tree* tree, int count);
void plii_box_tree_free(pli_context* context, plii_box_tree* tree);
size_t plii_box_tree_bytes(const plii_box_tree* tree);

/* Calls `visit` with each item whose box overlaps `box` (closed intervals), in no particular order. */
typedef void plii_box_tree_visit_fn(int item, void* user);
void plii_box_tree_overlaps(const plii_box_tree* tree, pli_bounds box, plii_box_tree_visit_fn* visit, void* user);

/* Looks for the nearest item. `measure` gives the squared distance of an item, or FLT_MAX to refuse it.
   Returns the item with the smallest squared distance below `max_squared`, or PLI_NULL_INDEX; equally near items go by
   place in the tree. */
typedef float plii_box_tree_measure_fn(int item, pli_vec3 point, const void* user);
int plii_box_tree_nearest(const plii_box_tree* tree, pli_vec3 point, float max_squared,
                          plii_box_tree_measure_fn* measure, const void* user);

#endif
