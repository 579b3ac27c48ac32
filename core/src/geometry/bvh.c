/* Levels of boxes by components. The order along the curve is that of Morton codes of the box centres. */

#include "geometry/bvh.h"

#include "base/csr.h"
#include "math/bounds.h"

static void bvh4_put(plii_vec3x4* corners, int lane, pli_vec3 corner) {
    corners->x[lane] = corner.x;
    corners->y[lane] = corner.y;
    corners->z[lane] = corner.z;
}
static void bvh4_set(plii_box4* group, int lane, pli_bounds box) {
    bvh4_put(&group->low, lane, box.min);
    bvh4_put(&group->high, lane, box.max);
}

/* What encloses the four boxes of a group, of which the first is not empty. */
static pli_bounds bvh4_join(const plii_box4* group) {
    const plii_vec3x4 *low = &group->low, *high = &group->high;
    pli_bounds all = {{low->x[0], low->y[0], low->z[0]}, {high->x[0], high->y[0], high->z[0]}};
    for (int k = 1; k < 4 && !isnan(low->x[k]); ++k) {
        all.min = plii_vec3_min(pli_vec3_make(low->x[k], low->y[k], low->z[k]), all.min);
        all.max = plii_vec3_max(pli_vec3_make(high->x[k], high->y[k], high->z[k]), all.max);
    }
    return all;
}

/* Empty boxes are nowhere: no comparison holds for NaN, however large the radius or the bounds that are looked for. */
static void bvh4_pad(plii_box4* groups, int count) {
    const pli_bounds nowhere = {{NAN, NAN, NAN}, {NAN, NAN, NAN}};
    for (int i = count; i % 4 != 0; ++i) {
        bvh4_set(&groups[i / 4], i % 4, nowhere);
    }
}

pli_bounds plii_bvh4_bounds(const plii_bvh4* boxes) {
    return bvh4_join(&boxes->groups[boxes->begin[boxes->level_count - 1]]);
}

bool plii_bvh4_reserve(pli_context* context, plii_bvh4* boxes, int count) {
    if (count <= 0) { return true; }
    int begin[PLII_BVH_MAX_LEVELS + 1];
    const int level_count = plii_bvh_lay_out((count + 3) / 4, begin);
    return PLII_RESERVE(context, &boxes->groups, &boxes->capacity, begin[level_count]);
}

bool plii_bvh4_build(pli_context* context, plii_bvh4* boxes, int count, const pli_bounds* bounds, const int* items) {
    boxes->level_count = 0;
    if (count <= 0) { return true; }
    if (!plii_bvh4_reserve(context, boxes, count)) { return false; }
    const int level_count = plii_bvh_lay_out((count + 3) / 4, boxes->begin);
    for (int i = 0; i < count; ++i) {
        bvh4_set(&boxes->groups[i / 4], i % 4, bounds[items != NULL ? items[i] : i]);
    }
    bvh4_pad(boxes->groups, count);
    for (int level = 1; level < level_count; ++level) {
        const plii_box4* below = boxes->groups + boxes->begin[level - 1];
        plii_box4* groups = boxes->groups + boxes->begin[level];
        const int below_count = boxes->begin[level] - boxes->begin[level - 1];
        for (int i = 0; i < below_count; ++i) {
            bvh4_set(&groups[i / 4], i % 4, bvh4_join(&below[i]));
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

/* Bit k where box k touches the one between `low` and `high`. */
PLII_SIMD_INLINE int bvh4_overlaps(plii_vec3x4 low, plii_vec3x4 high, const plii_box4* group) {
    const plii_mask4 x = (group->low.x <= high.x) & (low.x <= group->high.x);
    const plii_mask4 y = (group->low.y <= high.y) & (low.y <= group->high.y);
    const plii_mask4 z = (group->low.z <= high.z) & (low.z <= group->high.z);
    return plii_lanes_bits((x & y) & z);
}

/* Squares of how far a coordinate lies outside of four intervals; NaN where one is: then maxima are second values. */
PLII_SIMD_INLINE plii_float4 bvh4_outside(plii_float4 value, plii_float4 low, plii_float4 high) {
    const plii_float4 outside = plii_lanes_max(plii_float4_all(0.0f), plii_lanes_max(low - value, value - high));
    return outside * outside;
}
PLII_SIMD_INLINE plii_float4 bvh4_squared_distances(plii_vec3x4 point, const plii_box4* group) {
    return bvh4_outside(point.x, group->low.x, group->high.x) + bvh4_outside(point.y, group->low.y, group->high.y) +
           bvh4_outside(point.z, group->low.z, group->high.z);
}

/* Appends those of four boxes from `first` on whose bits are set, and writes all four places: nobody could predict
   branches for each. */
PLII_SIMD_INLINE int bvh4_append_set(int* items, int count, int first, int bits) {
    static const plii_mask4 set[16] = {{0}, {0},    {1},    {0, 1},    {2},    {0, 2},    {1, 2},    {0, 1, 2},
                                       {3}, {0, 3}, {1, 3}, {0, 1, 3}, {2, 3}, {0, 2, 3}, {1, 2, 3}, {0, 1, 2, 3}};
    const plii_mask4 boxes = set[bits] + first;
    memcpy(&items[count], &boxes, sizeof boxes);
    return count + (int)(UINT64_C(0x4332322132212110) >> 4 * bits & 7u);
}

/* Level by level, with the lists of two levels in turn, so that what is tested does not wait for the tests before. */
int plii_bvh4_overlaps(const plii_bvh4* boxes, const pli_bounds* bounds, int lowest, int* items) {
    const plii_vec3x4 low = plii_vec3x4_all(bounds->min), high = plii_vec3x4_all(bounds->max);
    const int top = boxes->level_count - 1;
    if (top < 0) { return 0; }
    int* lists[2] = {items, items + (lowest == 0 ? 4 : 1) * boxes->begin[1] + PLII_BVH4_SPARE};
    int count = 1;
    lists[(top - lowest + 1) & 1][0] = 0;
    for (int level = top; level >= lowest && count > 0; --level) {
        const plii_box4* groups = boxes->groups + boxes->begin[level];
        const int* from = lists[(level - lowest + 1) & 1];
        const int from_count = count;
        count = 0;
        for (int i = 0; i < from_count; ++i) {
            const int bits = bvh4_overlaps(low, high, &groups[from[i]]);
            count = bvh4_append_set(lists[(level - lowest) & 1], count, 4 * from[i], bits);
        }
    }
    return count;
}

int plii_bvh4_find(const plii_bvh4* boxes, const int* groups, int group_count, pli_vec3 point, float radius,
                   int* items) {
    const plii_vec3x4 p = plii_vec3x4_all(point);
    int count = 0;
    for (int i = 0; i < group_count; ++i) {
        const plii_float4 squared = bvh4_squared_distances(p, &boxes->groups[groups[i]]);
        count = bvh4_append_set(items, count, 4 * groups[i], plii_lanes_bits(squared <= radius * radius));
    }
    return count;
}

/* The ten low bits of a number, two zero bits put between each. */
static uint32_t bvh_spread(uint32_t v) {
    v = (v | v << 16) & 0x030000ffu;
    v = (v | v << 8) & 0x0300f00fu;
    v = (v | v << 4) & 0x030c30c3u;
    return (v | v << 2) & 0x09249249u;
}

static uint32_t bvh_cell(float value, float low, float scale) {
    const float cell = (value - low) * scale;
    return cell >= 1023.0f ? 1023u : cell >= 0.0f ? (uint32_t)cell : 0u; /* also for NaN */
}

/* By eight bits of the keys; equals stay in their order. */
static void bvh_sort_by(int shift, int count, const uint32_t* keys, const int* items, uint32_t* sorted_keys,
                        int* sorted_items) {
    int begin[257] = {0};
    for (int i = 0; i < count; ++i) {
        ++begin[keys[i] >> shift & 255u];
    }
    plii_csr_sum(256, begin);
    for (int i = count - 1; i >= 0; --i) {
        const int at = --begin[keys[i] >> shift & 255u];
        sorted_keys[at] = keys[i];
        sorted_items[at] = items[i];
    }
}

/* Sorts items by key, least significant bits first, there and back. */
static void bvh_sort(plii_bvh* tree, int count) {
    uint32_t* other_keys = tree->keys + count;
    int* other_items = tree->items + count;
    for (int shift = 0; shift < 32; shift += 16) {
        bvh_sort_by(shift, count, tree->keys, tree->items, other_keys, other_items);
        bvh_sort_by(shift + 8, count, other_keys, other_items, tree->keys, tree->items);
    }
}

bool plii_bvh_build(pli_context* context, plii_bvh* tree, int count, const pli_bounds* bounds) {
    tree->count = 0;
    tree->boxes.level_count = 0;
    if (count <= 0) { return true; }
    if (!PLII_RESERVE(context, &tree->items, &tree->item_capacity, 2 * count) ||
        !PLII_RESERVE(context, &tree->keys, &tree->key_capacity, 2 * count)) {
        return false;
    }
    pli_bounds all = bounds[0];
    for (int i = 1; i < count; ++i) {
        all = plii_bounds_join(all, bounds[i]);
    }
    const pli_vec3 low = pli_vec3_scale(all.min, 2.0f);
    const pli_vec3 size = pli_vec3_sub(pli_vec3_scale(all.max, 2.0f), low);
    const float largest = plii_max(size.x, plii_max(size.y, size.z));
    const float scale = largest > 0.0f ? 1024.0f / largest : 0.0f;
    for (int i = 0; i < count; ++i) {
        const pli_vec3 centre = pli_vec3_add(bounds[i].min, bounds[i].max); /* twice the centre */
        tree->items[i] = i;
        tree->keys[i] = bvh_spread(bvh_cell(centre.x, low.x, scale)) |
                        bvh_spread(bvh_cell(centre.y, low.y, scale)) << 1 |
                        bvh_spread(bvh_cell(centre.z, low.z, scale)) << 2;
    }
    bvh_sort(tree, count);
    tree->count = plii_bvh4_build(context, &tree->boxes, count, bounds, tree->items) ? count : 0;
    return tree->count > 0;
}

bool plii_bvh_build_from(pli_context* context, plii_bvh* tree, int count, plii_bvh_box_fn* box, const void* user) {
    pli_bounds* boxes = NULL;
    if (!PLII_ALLOCATE(context, &boxes, count)) { return false; }
    for (int i = 0; i < count; ++i) {
        boxes[i] = box(i, user);
    }
    const bool is_built = plii_bvh_build(context, tree, count, boxes);
    PLII_RELEASE(context, boxes, count);
    return is_built;
}

void plii_bvh_free(pli_context* context, plii_bvh* tree) {
    plii_bvh4_free(context, &tree->boxes);
    PLII_RELEASE(context, tree->items, tree->item_capacity);
    PLII_RELEASE(context, tree->keys, tree->key_capacity);
    *tree = (plii_bvh){.count = 0};
}

typedef struct bvh_search {
    const plii_bvh* tree;
    plii_vec3x4 low, high;
    plii_bvh_visit_fn* visit;
    void* user;
} bvh_search;

/* Depth first, backwards. */
static void bvh_search_group(const bvh_search* search, int level, int group) {
    const plii_bvh4* boxes = &search->tree->boxes;
    int bits = bvh4_overlaps(search->low, search->high, &boxes->groups[boxes->begin[level] + group]);
    while (bits != 0) {
        const int lane = 31 - __builtin_clz((unsigned)bits), found = 4 * group + lane;
        bits ^= 1 << lane;
        if (level == 0) {
            search->visit(search->tree->items[found], search->user);
        } else {
            bvh_search_group(search, level - 1, found);
        }
    }
}
void plii_bvh_overlaps(const plii_bvh* tree, pli_bounds box, plii_bvh_visit_fn* visit, void* user) {
    const bvh_search search = {tree, plii_vec3x4_all(box.min), plii_vec3x4_all(box.max), visit, user};
    if (tree->boxes.level_count > 0) { bvh_search_group(&search, tree->boxes.level_count - 1, 0); }
}

/* A box, or a group of boxes below it. */
typedef struct bvh_entry {
    int level, index;
    float squared; /* distance */
} bvh_entry;

/* Boxes of a group go on the stack with the nearest on top. */
static int bvh_push_group(const plii_bvh4* boxes, bvh_entry from, plii_vec3x4 point, float nearest_squared,
                          bvh_entry* stack, int depth) {
    const int level = from.level - 1, bottom = depth;
    float distances[4];
    plii_float4_store(distances, bvh4_squared_distances(point, &boxes->groups[boxes->begin[level] + from.index]));
    for (int k = 0; k < 4; ++k) {
        if (!(distances[k] < nearest_squared)) { continue; }
        int at = depth++;
        for (; at > bottom && stack[at - 1].squared < distances[k]; --at) {
            stack[at] = stack[at - 1];
        }
        stack[at] = (bvh_entry){level, 4 * from.index + k, distances[k]};
    }
    return depth;
}

int plii_bvh_nearest(const plii_bvh* tree, pli_vec3 point, float max_squared, plii_bvh_measure_fn* measure,
                     const void* user) {
    const plii_vec3x4 p = plii_vec3x4_all(point);
    bvh_entry stack[PLII_BVH_STACK];
    int depth = 0, nearest = PLI_NULL_INDEX;
    float nearest_squared = max_squared;
    if (tree->boxes.level_count > 0) { stack[depth++] = (bvh_entry){tree->boxes.level_count, 0, 0.0f}; }
    while (depth > 0) {
        const bvh_entry entry = stack[--depth];
        if (!(entry.squared < nearest_squared)) { continue; }
        if (entry.level > 0) {
            depth = bvh_push_group(&tree->boxes, entry, p, nearest_squared, stack, depth);
            continue;
        }
        const int item = tree->items[entry.index];
        const float squared = measure(item, point, user);
        if (squared < nearest_squared) {
            nearest = item;
            nearest_squared = squared;
        }
    }
    return nearest;
}
