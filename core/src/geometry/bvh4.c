/* Levels of boxes by components, each box around four of the level below: distances of four are measured at once. */

#include "math/simd_float4.h"

#include "geometry/bvh4.h"

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

/* Fills `begin`, where each level begins, and after the last one the number of all groups; returns how many levels. */
static int bvh4_lay_out(int count, int* begin) {
    int level_count = 0, total = 0;
    for (int width = (count + 3) / 4;; width = (width + 3) / 4) {
        begin[level_count++] = total;
        total += width;
        if (width == 1) { break; }
    }
    begin[level_count] = total;
    return level_count;
}

bool plii_bvh4_reserve(pli_context* context, plii_bvh4* boxes, int count) {
    if (count <= 0) { return true; }
    int begin[PLII_BVH4_MAX_LEVELS + 1];
    const int level_count = bvh4_lay_out(count, begin);
    return PLII_RESERVE(context, &boxes->groups, &boxes->capacity, begin[level_count]);
}

bool plii_bvh4_build(pli_context* context, plii_bvh4* boxes, int count, const pli_bounds* bounds) {
    boxes->level_count = 0;
    if (count <= 0) { return true; }
    if (!plii_bvh4_reserve(context, boxes, count)) { return false; }
    const int level_count = bvh4_lay_out(count, boxes->begin);
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

size_t plii_bvh4_bytes(const plii_bvh4* boxes) {
    return (size_t)boxes->capacity * sizeof *boxes->groups;
}

typedef struct near_search {
    plii_float4 x, y, z; /* of the point, in all lanes */
    plii_float4 squared_radius;
} near_search;

/* Squares of how far a coordinate lies outside of four intervals; NaN where the interval or the coordinate is, as the
   maximum of two values is the second one then. */
PLII_SIMD_INLINE plii_float4 bvh4_outside(plii_float4 value, const float* low, const float* high) {
    const plii_float4 below = plii_float4_sub(plii_float4_load(low), value);
    const plii_float4 above = plii_float4_sub(value, plii_float4_load(high));
    const plii_float4 outside = plii_lanes_max(plii_float4_all(0.0f), plii_lanes_max(below, above));
    return plii_float4_mul(outside, outside);
}

/* Bit k where box k is near. */
PLII_SIMD_INLINE int bvh4_test(const near_search* search, const plii_box4* group) {
    const plii_float4 x = bvh4_outside(search->x, group->low[0], group->high[0]);
    const plii_float4 y = bvh4_outside(search->y, group->low[1], group->high[1]);
    const plii_float4 z = bvh4_outside(search->z, group->low[2], group->high[2]);
    const plii_float4 squared = plii_float4_add(plii_float4_add(x, y), z);
    return plii_lanes_bits(plii_lanes_less_equal(squared, search->squared_radius));
}

/* The lowest bit that is set, of four. */
static const uint8_t bvh4_first[16] = {0, 0, 1, 0, 2, 0, 1, 0, 3, 0, 1, 0, 2, 0, 1, 0};

/* Bit k where box k of a group touches the box between `low` and `high`. */
PLII_SIMD_INLINE int bvh4_overlap(const plii_box4* group, plii_vec3x4 low, plii_vec3x4 high) {
    const plii_mask4 x = plii_lanes_both(plii_lanes_less_equal(plii_float4_load(group->low[0]), high.x),
                                         plii_lanes_less_equal(low.x, plii_float4_load(group->high[0])));
    const plii_mask4 y = plii_lanes_both(plii_lanes_less_equal(plii_float4_load(group->low[1]), high.y),
                                         plii_lanes_less_equal(low.y, plii_float4_load(group->high[1])));
    const plii_mask4 z = plii_lanes_both(plii_lanes_less_equal(plii_float4_load(group->low[2]), high.z),
                                         plii_lanes_less_equal(low.z, plii_float4_load(group->high[2])));
    return plii_lanes_bits(plii_lanes_both(plii_lanes_both(x, y), z));
}

int plii_bvh4_overlaps(const plii_bvh4* boxes, const pli_bounds* bounds, int* items) {
    const plii_vec3x4 low = plii_vec3x4_all(bounds->min), high = plii_vec3x4_all(bounds->max);
    const int end = boxes->level_count > 0 ? boxes->begin[1] : 0;
    int count = 0;
    for (int i = 0; i < end; ++i) {
        for (int bits = bvh4_overlap(&boxes->groups[i], low, high); bits != 0; bits &= bits - 1) {
            items[count++] = 4 * i + bvh4_first[bits];
        }
    }
    return count;
}

bool plii_bvh4_touches(const plii_bvh4* boxes, const pli_bounds* bounds) {
    const plii_vec3x4 low = plii_vec3x4_all(bounds->min), high = plii_vec3x4_all(bounds->max);
    int bits[PLII_BVH4_MAX_LEVELS], group[PLII_BVH4_MAX_LEVELS];
    const int top = boxes->level_count - 1;
    if (top < 0) { return false; }
    group[top] = 0;
    bits[top] = bvh4_overlap(&boxes->groups[boxes->begin[top]], low, high);
    for (int level = top; level <= top;) {
        if (bits[level] == 0) {
            ++level;
            continue;
        }
        if (level == 0) { return true; }
        const int box = 4 * group[level] + bvh4_first[bits[level]];
        bits[level] &= bits[level] - 1;
        --level;
        group[level] = box;
        bits[level] = bvh4_overlap(&boxes->groups[boxes->begin[level] + box], low, high);
    }
    return false;
}

int plii_bvh4_find(const plii_bvh4* boxes, pli_vec3 point, float radius, int* items) {
    const near_search search = {plii_float4_all(point.x), plii_float4_all(point.y), plii_float4_all(point.z),
                                plii_float4_all(radius * radius)};
    /* Depth first: of the groups on the way down, what is left to be looked at. */
    int bits[PLII_BVH4_MAX_LEVELS], group[PLII_BVH4_MAX_LEVELS];
    int count = 0;
    const int top = boxes->level_count - 1;
    if (top < 0) { return 0; }
    group[top] = 0;
    bits[top] = bvh4_test(&search, &boxes->groups[boxes->begin[top]]);
    for (int level = top; level <= top;) {
        if (bits[level] == 0) {
            ++level;
            continue;
        }
        const int box = 4 * group[level] + bvh4_first[bits[level]];
        bits[level] &= bits[level] - 1;
        if (level == 0) {
            items[count++] = box;
        } else {
            --level;
            group[level] = box;
            bits[level] = bvh4_test(&search, &boxes->groups[boxes->begin[level] + box]);
        }
    }
    return count;
}
