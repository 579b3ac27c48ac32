/* Open addressing with linear probing; a table of a power of two, at most two thirds full. */

#include "base/edge_set.h"

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

static uint64_t edge_key(int a, int b) {
    const uint64_t low = (uint64_t)(uint32_t)(a < b ? a : b), high = (uint64_t)(uint32_t)(a < b ? b : a);
    return (low << 32 | high) + 1;
}

/* The slot that holds the edge, or the free one where it belongs. */
static size_t edge_slot(const plii_edge_set* set, uint64_t key) {
    uint64_t hash = key * UINT64_C(0x9e3779b97f4a7c15);
    hash ^= hash >> 32;
    size_t slot = (size_t)hash & set->mask;
    while (set->slots[slot] != key && set->slots[slot] != 0) {
        slot = (slot + 1) & set->mask;
    }
    return slot;
}

bool plii_edge_set_insert(plii_edge_set* set, int a, int b) {
    const uint64_t key = edge_key(a, b);
    const size_t slot = edge_slot(set, key);
    if (set->slots[slot] == key) { return false; }
    set->slots[slot] = key;
    return true;
}

bool plii_edge_set_contains(const plii_edge_set* set, int a, int b) {
    const uint64_t key = edge_key(a, b);
    return set->slots[edge_slot(set, key)] == key;
}
