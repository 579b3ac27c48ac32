/* Open addressing with linear probing; a table of a power of two, at most two thirds full. */

#include "edge_set.h"

bool plii_edge_set_create(pli_context* context, size_t max_edges, plii_edge_set* set) {
    if (max_edges > SIZE_MAX / (4 * sizeof(uint64_t))) { return false; }
    size_t size = 16;
    while (size / 3 * 2 < max_edges) {
        size *= 2;
    }
    set->context = context;
    set->mask = size - 1;
    set->slots = plii_allocate(context, size * sizeof *set->slots);
    return set->slots != NULL;
}

void plii_edge_set_destroy(plii_edge_set* set) {
    plii_release(set->context, set->slots, (set->mask + 1) * sizeof *set->slots);
}

bool plii_edge_set_insert(plii_edge_set* set, int a, int b) {
    const uint64_t low = (uint64_t)(uint32_t)(a < b ? a : b), high = (uint64_t)(uint32_t)(a < b ? b : a);
    const uint64_t key = (low << 32 | high) + 1;
    uint64_t hash = key * UINT64_C(0x9e3779b97f4a7c15);
    hash ^= hash >> 32;
    for (size_t i = (size_t)hash & set->mask;; i = (i + 1) & set->mask) {
        if (set->slots[i] == key) { return false; }
        if (set->slots[i] == 0) {
            set->slots[i] = key;
            return true;
        }
    }
}
