/* Levels of boxes by components, each box around four of the level below: distances of four are measured at once. */

#include "geometry/bvh4.h"

#include "geometry/bvh.h"
#include "math/simd_float4.h"

static void bvh4_set(plii_box4* group, int lane, pli_vec3 low, pli_vec3 high) {
    group->low[0][lane] = low.x;
    group->low[1][lane] = low.y;
    group->low[2][lane] = low.z;
    group->high[0][lane] = high.x;
    group->high[1][lane] = high.y;
    group->high[2][lane] = high.z;
}

/* What encloses the four boxes of a group, of which the first is not empty. */
static pli_bounds bvh4_join(const plii_box4* group) {
    pli_bounds all = {{group->low[0][0], group->low[1][0], group->low[2][0]},
                      {group->high[0][0], group->high[1][0], group->high[2][0]}};
    for (int k = 1; k < 4 && !isnan(group->low[0][k]); ++k) {
        const pli_vec3 low = pli_vec3_make(group->low[0][k], group->low[1][k], group->low[2][k]);
        const pli_vec3 high = pli_vec3_make(group->high[0][k], group->high[1][k], group->high[2][k]);
        all.min = plii_vec3_min(low, all.min);
        all.max = plii_vec3_max(high, all.max);
    }
    return all;
}

/* Empty boxes are nowhere: no comparison holds for NaN, however large the radius or the bounds that are looked for. */
static void bvh4_pad(plii_box4* groups, int count) {
    const pli_vec3 nowhere = pli_vec3_make(NAN, NAN, NAN);
    for (int i = count; i % 4 != 0; ++i) {
        bvh4_set(&groups[i / 4], i % 4, nowhere, nowhere);
    }
}

bool plii_bvh4_reserve(pli_context* context, plii_bvh4* boxes, int count) {
    if (count <= 0) { return true; }
    int begin[PLII_BVH4_MAX_LEVELS + 1];
    const int level_count = plii_bvh_lay_out((count + 3) / 4, begin);
    return PLII_RESERVE(context, &boxes->groups, &boxes->capacity, begin[level_count]);
}

bool plii_bvh4_build(pli_context* context, plii_bvh4* boxes, int count, const pli_bounds* bounds) {
    boxes->level_count = 0;
    if (count <= 0) { return true; }
    if (!plii_bvh4_reserve(context, boxes, count)) { return false; }
    const int level_count = plii_bvh_lay_out((count + 3) / 4, boxes->begin);
    for (int i = 0; i < count; ++i) {
        bvh4_set(&boxes->groups[i / 4], i % 4, bounds[i].min, bounds[i].max);
    }
    bvh4_pad(boxes->groups, count);
    for (int level = 1; level < level_count; ++level) {
        const plii_box4* below = boxes->groups + boxes->begin[level - 1];
        plii_box4* groups = boxes->groups + boxes->begin[level];
        const int below_count = boxes->begin[level] - boxes->begin[level - 1];
        for (int i = 0; i < below_count; ++i) {
            const pli_bounds all = bvh4_join(&below[i]);
            bvh4_set(&groups[i / 4], i % 4, all.min, all.max);
        }
        bvh4_pad(groups, below_count);
    }
    boxes->level_count = level_count;
    return true;
}

void plii_bvh4_free(pli_context* context, plii_bvh4* boxes) {
    PLII_RELEASE(context, boxes->groups, boxes->capacity);
    *boxes = (plii_bvh4){0};
}

/* What is looked for, in all lanes. */
typedef struct bvh4_query {
    plii_vec3x4 low, high;
    plii_float4 squared_radius;
} bvh4_query;

/* Bit k where box k touches what is looked for. */
typedef int bvh4_test(const bvh4_query* query, const plii_box4* group);

PLII_SIMD_INLINE plii_mask4 bvh4_overlaps_axis(plii_float4 low, plii_float4 high, const float* box_low,
                                               const float* box_high) {
    return (plii_float4_load(box_low) <= high) & (low <= plii_float4_load(box_high));
}

PLII_SIMD_INLINE int bvh4_overlaps(const bvh4_query* query, const plii_box4* group) {
    const plii_vec3x4 low = query->low, high = query->high;
    const plii_mask4 x = bvh4_overlaps_axis(low.x, high.x, group->low[0], group->high[0]);
    const plii_mask4 y = bvh4_overlaps_axis(low.y, high.y, group->low[1], group->high[1]);
    const plii_mask4 z = bvh4_overlaps_axis(low.z, high.z, group->low[2], group->high[2]);
    return plii_lanes_bits((x & y) & z);
}

/* Squares of how far a coordinate lies outside of four intervals; NaN where the interval or the coordinate is, as the
   maximum of two values is the second one then. */
PLII_SIMD_INLINE plii_float4 bvh4_outside(plii_float4 value, const float* low, const float* high) {
    const plii_float4 below = plii_float4_load(low) - value;
    const plii_float4 above = value - plii_float4_load(high);
    const plii_float4 outside = plii_lanes_max(plii_float4_all(0.0f), plii_lanes_max(below, above));
    return outside * outside;
}

/* Of a point: low is high. */
PLII_SIMD_INLINE int bvh4_is_near(const bvh4_query* query, const plii_box4* group) {
    const plii_float4 x = bvh4_outside(query->low.x, group->low[0], group->high[0]);
    const plii_float4 y = bvh4_outside(query->low.y, group->low[1], group->high[1]);
    const plii_float4 z = bvh4_outside(query->low.z, group->low[2], group->high[2]);
    const plii_float4 squared = x + y + z;
    return plii_lanes_bits(squared <= query->squared_radius);
}

static const uint8_t bvh4_first_bit[16] = {0, 0, 1, 0, 2, 0, 1, 0, 3, 0, 1, 0, 2, 0, 1, 0};

/* Boxes of the lowest level that counts, depth first: of the groups on the path down, what is left to be looked at. */
PLII_SIMD_INLINE int bvh4_walk(const plii_bvh4* boxes, bvh4_test* test, const bvh4_query* query, int lowest,
                               int* items) {
    int bits[PLII_BVH4_MAX_LEVELS], group[PLII_BVH4_MAX_LEVELS];
    int count = 0;
    const int top = boxes->level_count - 1;
    if (top < 0) { return 0; }
    group[top] = 0;
    bits[top] = test(query, &boxes->groups[boxes->begin[top]]);
    for (int level = top; level <= top;) {
        if (bits[level] == 0) {
            ++level;
            continue;
        }
        const int box = 4 * group[level] + bvh4_first_bit[bits[level]];
        bits[level] &= bits[level] - 1;
        if (level == lowest) {
            items[count++] = box;
        } else {
            --level;
            group[level] = box;
            bits[level] = test(query, &boxes->groups[boxes->begin[level] + box]);
        }
    }
    return count;
}

static bvh4_query bvh4_query_of_bounds(const pli_bounds* bounds) {
    return (bvh4_query){plii_vec3x4_all(bounds->min), plii_vec3x4_all(bounds->max), plii_float4_all(0.0f)};
}

int plii_bvh4_overlaps(const plii_bvh4* boxes, const pli_bounds* bounds, int* items) {
    const bvh4_query query = bvh4_query_of_bounds(bounds);
    return bvh4_walk(boxes, bvh4_overlaps, &query, 0, items);
}

int plii_bvh4_find_groups(const plii_bvh4* boxes, const pli_bounds* bounds, int* groups) {
    if (boxes->level_count == 1) { groups[0] = 0; }
    if (boxes->level_count <= 1) { return boxes->level_count; }
    const bvh4_query query = bvh4_query_of_bounds(bounds);
    return bvh4_walk(boxes, bvh4_overlaps, &query, 1, groups);
}

int plii_bvh4_find(const plii_bvh4* boxes, const int* groups, int group_count, pli_vec3 point, float radius,
                   int* items) {
    const bvh4_query query = {plii_vec3x4_all(point), plii_vec3x4_all(point), plii_float4_all(radius * radius)};
    int count = 0;
    for (int i = 0; i < group_count; ++i) {
        for (int bits = bvh4_is_near(&query, &boxes->groups[groups[i]]); bits != 0; bits &= bits - 1) {
            items[count++] = 4 * groups[i] + bvh4_first_bit[bits];
        }
    }
    return count;
}
