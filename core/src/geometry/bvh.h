#pragma once

/* Bounding volume trees over boxes, built in linear time and without pointers: boxes are in groups of four, and box i
   of a level above is around group i of the level below. Four are tested at once. */

#include "base/context.h"
#include "math/simd_float4.h"

#define PLII_BVH_FAN 4
#define PLII_BVH_MAX_LEVELS 17
#define PLII_BVH_STACK (PLII_BVH_MAX_LEVELS * PLII_BVH_FAN) /* entries that a depth-first walk can have waiting */

/* Four boxes by components; those beyond the last one are empty: NaN, which no search finds. */
typedef struct plii_box4 {
    plii_vec3x4 low, high;
} plii_box4;

/* Boxes in their order: quick to ask where neighbours in the list are neighbours in space. */
typedef struct plii_bvh4 {
    int level_count;                    /* 0: no boxes; the last level is one group */
    int begin[PLII_BVH_MAX_LEVELS + 1]; /* of each level in `groups` */
    plii_box4* groups;
    int capacity;
} plii_bvh4;

/* Boxes along a Z-order curve. */
typedef struct plii_bvh {
    int count;  /* items */
    int* items; /* [count] the item of each box; as many more are scratch */
    plii_bvh4 boxes;
    uint32_t* keys; /* [2 * count] scratch: Z-order keys */
    int item_capacity, key_capacity;
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

/* Boxes in the order of `items`, NULL: as they come, in place of those before. Out of memory false, and no boxes. */
bool plii_bvh4_build(pli_context* context, plii_bvh4* boxes, int count, const pli_bounds* bounds, const int* items);
/* Room for that many; false when out of memory. */
bool plii_bvh4_reserve(pli_context* context, plii_bvh4* boxes, int count);
void plii_bvh4_free(pli_context* context, plii_bvh4* boxes);
/* Around all, of which there is one at least. */
pli_bounds plii_bvh4_bounds(const plii_bvh4* boxes);

/* Lists are written four places at a time, and need room for those of upper levels: of boxes, and of their groups. */
enum { PLII_BVH4_SPARE = 3 };
#define PLII_BVH4_ROOM(count) ((count) + (count) / 4 + 12)
#define PLII_BVH4_GROUP_ROOM(count) ((count) / 2 + 8)
/* Writes the boxes of level `lowest` that touch `bounds`, ascending, to `items`; returns their number. Those of level 1
   are groups of level 0, for points that lie close together. */
int plii_bvh4_overlaps(const plii_bvh4* boxes, const pli_bounds* bounds, int lowest, int* items);
/* Writes the boxes of these groups within `radius` of a point, in the order of the groups; returns their number. */
int plii_bvh4_find(const plii_bvh4* boxes, const int* groups, int group_count, pli_vec3 point, float radius,
                   int* items);

/* As plii_bvh4_build; the boxes must be finite. */
bool plii_bvh_build(pli_context* context, plii_bvh* tree, int count, const pli_bounds* bounds);
/* The same for boxes that a function tells. */
typedef pli_bounds plii_bvh_box_fn(int item, const void* user);
bool plii_bvh_build_from(pli_context* context, plii_bvh* tree, int count, plii_bvh_box_fn* box, const void* user);
void plii_bvh_free(pli_context* context, plii_bvh* tree);

/* Calls `visit` with each item whose box overlaps `box` (closed intervals), in no particular order. */
typedef void plii_bvh_visit_fn(int item, void* user);
void plii_bvh_overlaps(const plii_bvh* tree, pli_bounds box, plii_bvh_visit_fn* visit, void* user);

/* The item of the smallest squared distance below `max_squared`, or PLI_NULL_INDEX; equally near ones go by index in
   the tree. `measure` gives the squared distance of an item, or FLT_MAX to refuse it. */
typedef float plii_bvh_measure_fn(int item, pli_vec3 point, const void* user);
int plii_bvh_nearest(const plii_bvh* tree, pli_vec3 point, float max_squared, plii_bvh_measure_fn* measure,
                     const void* user);
