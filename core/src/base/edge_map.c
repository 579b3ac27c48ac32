/* Open addressing with linear probing, at most half full; the table doubles. */

#include "base/edge_map.h"

#include "base/csr.h"
#include "base/scratch.h"

#include <limits.h>

#define EDGE_MAP_MIN_SLOTS 64

static size_t edge_map_hash(int a, int b) {
    uint64_t hash = ((uint64_t)(uint32_t)a << 32 | (uint64_t)(uint32_t)b) * UINT64_C(0x9e3779b97f4a7c15);
    hash ^= hash >> 32;
    return (size_t)hash;
}

/* The slot of an edge with a < b, or the free one where it belongs. */
static size_t edge_map_probe(const plii_edge_map* map, int a, int b) {
    const size_t mask = map->slot_count - 1;
    size_t i = edge_map_hash(a, b) & mask;
    while (map->slots[i] != 0) {
        const plii_edge* edge = &map->edges[map->slots[i] - 1];
        if (edge->a == a && edge->b == b) { break; }
        i = (i + 1) & mask;
    }
    return i;
}

static bool edge_map_grow(plii_edge_map* map) {
    const size_t old_count = map->slot_count;
    const size_t slot_count = old_count == 0 ? EDGE_MAP_MIN_SLOTS : 2 * old_count;
    if (slot_count > SIZE_MAX / sizeof *map->slots) { return false; }
    int* slots = plii_allocate(map->context, slot_count * sizeof *slots);
    if (slots == NULL) { return false; }
    plii_release(map->context, map->slots, old_count * sizeof *map->slots);
    map->slots = slots;
    map->slot_count = slot_count;
    for (int i = 0; i < map->count; ++i) {
        map->slots[edge_map_probe(map, map->edges[i].a, map->edges[i].b)] = i + 1;
    }
    return true;
}

int plii_edge_map_add(plii_edge_map* map, int a, int b) {
    const int low = a < b ? a : b, high = a < b ? b : a;
    if ((size_t)map->count + 1 > map->slot_count / 2 && !edge_map_grow(map)) { return PLI_NULL_INDEX; }
    const size_t slot = edge_map_probe(map, low, high);
    if (map->slots[slot] != 0) { return map->slots[slot] - 1; }
    if (map->count == INT_MAX || !PLII_RESERVE(map->context, &map->edges, &map->capacity, map->count + 1)) {
        return PLI_NULL_INDEX;
    }
    map->edges[map->count] =
        (plii_edge){.a = low, .b = high, .node = PLI_NULL_INDEX, .rest_squared = -1.0f, .first = PLI_NULL_INDEX};
    map->slots[slot] = ++map->count;
    return map->count - 1;
}

int plii_edge_map_find(const plii_edge_map* map, int a, int b) {
    if (map->count == 0) { return PLI_NULL_INDEX; }
    return map->slots[edge_map_probe(map, a < b ? a : b, a < b ? b : a)] - 1;
}

bool plii_edge_map_order(const plii_edge_map* map, int node_count, int* order) {
    plii_scratch scratch = {.context = map->context};
    int* begin = PLII_TAKE(&scratch, int, (size_t)node_count + 1);
    int* keys = PLII_TAKE(&scratch, int, map->count);
    int* by_b = PLII_TAKE(&scratch, int, map->count);
    if (map->count > 0 && !scratch.is_short) {
        for (int i = 0; i < map->count; ++i) {
            keys[i] = map->edges[i].b;
        }
        plii_csr_sort(node_count, map->count, keys, begin, by_b);
        for (int i = 0; i < map->count; ++i) {
            keys[i] = map->edges[by_b[i]].a;
        }
        plii_csr_sort(node_count, map->count, keys, begin, order);
        for (int i = 0; i < map->count; ++i) {
            order[i] = by_b[order[i]];
        }
    }
    plii_scratch_free(&scratch);
    return !scratch.is_short;
}

void plii_edge_map_free(plii_edge_map* map) {
    PLII_RELEASE(map->context, map->edges, map->capacity);
    plii_release(map->context, map->slots, map->slot_count * sizeof *map->slots);
    *map = (plii_edge_map){.context = map->context};
}
