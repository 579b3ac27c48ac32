/* Bounding volume tree over boxes; the order along the curve is that of Morton codes of the box centres. */

#include "geometry/bvh.h"

#include "math/bounds.h"

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

static pli_bounds bvh_join(pli_bounds a, pli_bounds b) {
    return (pli_bounds){plii_vec3_min(a.min, b.min), plii_vec3_max(a.max, b.max)};
}

/* Sorts items by key, eight bits at a time, least significant first. */
static void bvh_sort(plii_bvh* tree, int count) {
    uint32_t* keys = tree->keys;
    uint32_t* other_keys = tree->keys + count;
    int* items = tree->items;
    int* other_items = tree->sorting;
    for (int shift = 0; shift < 32; shift += 8) {
        int begin[257] = {0};
        for (int i = 0; i < count; ++i) {
            ++begin[(keys[i] >> shift & 255u) + 1];
        }
        for (int digit = 0; digit < 256; ++digit) {
            begin[digit + 1] += begin[digit];
        }
        for (int i = 0; i < count; ++i) {
            const int at = begin[keys[i] >> shift & 255u]++;
            other_keys[at] = keys[i];
            other_items[at] = items[i];
        }
        uint32_t* swap_keys = keys;
        keys = other_keys;
        other_keys = swap_keys;
        int* swap_items = items;
        items = other_items;
        other_items = swap_items;
    }
    /* After an even number of passes the result is back where it began. */
}

bool plii_bvh_reserve(pli_context* context, plii_bvh* tree, int count) {
    if (count <= 0) { return true; }
    int begin[PLII_BVH_MAX_LEVELS + 1];
    const int level_count = plii_bvh_lay_out(count, begin);
    return PLII_RESERVE(context, &tree->items, &tree->item_capacity, count) &&
           PLII_RESERVE(context, &tree->sorting, &tree->sorting_capacity, count) &&
           PLII_RESERVE(context, &tree->keys, &tree->key_capacity, 2 * count) &&
           PLII_RESERVE(context, &tree->boxes, &tree->box_capacity, begin[level_count]);
}

bool plii_bvh_build(pli_context* context, plii_bvh* tree, int count, const pli_bounds* boxes) {
    tree->count = 0;
    tree->level_count = 0;
    if (count <= 0) { return true; }
    if (!plii_bvh_reserve(context, tree, count)) { return false; }
    const int level_count = plii_bvh_lay_out(count, tree->begin);

    pli_bounds all = boxes[0];
    for (int i = 1; i < count; ++i) {
        all = bvh_join(all, boxes[i]);
    }
    const pli_vec3 low = pli_vec3_scale(all.min, 2.0f);
    const pli_vec3 size = pli_vec3_sub(pli_vec3_scale(all.max, 2.0f), low);
    const float largest = plii_max(size.x, plii_max(size.y, size.z));
    const float scale = largest > 0.0f ? 1024.0f / largest : 0.0f;
    for (int i = 0; i < count; ++i) {
        const pli_vec3 centre = pli_vec3_add(boxes[i].min, boxes[i].max); /* twice the centre */
        tree->items[i] = i;
        tree->keys[i] = bvh_spread(bvh_cell(centre.x, low.x, scale)) |
                        bvh_spread(bvh_cell(centre.y, low.y, scale)) << 1 |
                        bvh_spread(bvh_cell(centre.z, low.z, scale)) << 2;
    }
    bvh_sort(tree, count);
    for (int i = 0; i < count; ++i) {
        tree->boxes[i] = boxes[tree->items[i]];
    }

    for (int level = 1; level < level_count; ++level) {
        const pli_bounds* below = tree->boxes + tree->begin[level - 1];
        const int below_count = tree->begin[level] - tree->begin[level - 1];
        pli_bounds* parents = tree->boxes + tree->begin[level];
        for (int i = 0; i < below_count; ++i) {
            const int parent = i / PLII_BVH_FAN;
            parents[parent] = i % PLII_BVH_FAN == 0 ? below[i] : bvh_join(parents[parent], below[i]);
        }
    }
    tree->count = count;
    tree->level_count = level_count;
    return true;
}

void plii_bvh_free(pli_context* context, plii_bvh* tree) {
    PLII_RELEASE(context, tree->items, tree->item_capacity);
    PLII_RELEASE(context, tree->boxes, tree->box_capacity);
    PLII_RELEASE(context, tree->keys, tree->key_capacity);
    PLII_RELEASE(context, tree->sorting, tree->sorting_capacity);
    *tree = (plii_bvh){.count = 0};
}

typedef struct bvh_entry {
    int level, index;
    float squared; /* distance of the box; only for the nearest item */
} bvh_entry;

static int bvh_width(const plii_bvh* tree, int level) {
    return tree->begin[level + 1] - tree->begin[level];
}

void plii_bvh_overlaps(const plii_bvh* tree, pli_bounds box, plii_bvh_visit_fn* visit, void* user) {
    bvh_entry stack[PLII_BVH_STACK];
    int depth = 0;
    const int top = tree->level_count - 1;
    if (top < 0 || !plii_bounds_overlap(tree->boxes[tree->begin[top]], box)) { return; }
    stack[depth++] = (bvh_entry){.level = top, .index = 0};
    while (depth > 0) {
        const bvh_entry entry = stack[--depth]; /* overlaps */
        if (entry.level == 0) {
            visit(tree->items[entry.index], user);
            continue;
        }
        const int first = entry.index * PLII_BVH_FAN;
        const int width = bvh_width(tree, entry.level - 1);
        const pli_bounds* boxes = tree->boxes + tree->begin[entry.level - 1];
        for (int child = first; child < first + PLII_BVH_FAN && child < width; ++child) {
            if (!plii_bounds_overlap(boxes[child], box)) { continue; }
            stack[depth++] = (bvh_entry){.level = entry.level - 1, .index = child};
        }
    }
}

static float bvh_squared_distance(pli_bounds box, pli_vec3 p) {
    const pli_vec3 inside = plii_vec3_min(plii_vec3_max(p, box.min), box.max);
    return pli_vec3_length_squared(pli_vec3_sub(p, inside));
}

int plii_bvh_nearest(const plii_bvh* tree, pli_vec3 point, float max_squared, plii_bvh_measure_fn* measure,
                     const void* user) {
    bvh_entry stack[PLII_BVH_STACK];
    int depth = 0;
    int nearest = PLI_NULL_INDEX;
    float nearest_squared = max_squared;
    if (tree->level_count > 0) { stack[depth++] = (bvh_entry){tree->level_count - 1, 0, 0.0f}; }
    while (depth > 0) {
        const bvh_entry entry = stack[--depth];
        if (!(entry.squared < nearest_squared)) { continue; }
        if (entry.level == 0) {
            const int item = tree->items[entry.index];
            const float squared = measure(item, point, user);
            if (squared < nearest_squared) {
                nearest = item;
                nearest_squared = squared;
            }
            continue;
        }
        /* Children go on the stack with the nearest on top. */
        const int bottom = depth;
        const int first = entry.index * PLII_BVH_FAN;
        const int width = bvh_width(tree, entry.level - 1);
        for (int child = first; child < first + PLII_BVH_FAN && child < width; ++child) {
            const float squared = bvh_squared_distance(tree->boxes[tree->begin[entry.level - 1] + child], point);
            if (!(squared < nearest_squared)) { continue; }
            int at = depth++;
            for (; at > bottom && stack[at - 1].squared < squared; --at) {
                stack[at] = stack[at - 1];
            }
            stack[at] = (bvh_entry){entry.level - 1, child, squared};
        }
    }
    return nearest;
}
