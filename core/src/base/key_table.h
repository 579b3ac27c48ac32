#pragma once

/* Indices by 64-bit keys: open addressing with linear probing, half of the slots stay free. */

#include "base/context.h"

typedef struct plii_key_slot {
    uint64_t key1; /* key + 1; 0: free */
    int index;
} plii_key_slot;

typedef struct plii_key_table {
    pli_context* context;
    plii_key_slot* slots;
    int count, capacity; /* keys; slots: 0 or a power of two */
} plii_key_table;

/* An edge without a direction, between nodes >= 0. */
static inline uint64_t plii_edge_key(int a, int b) {
    const uint64_t low = (uint64_t)(a < b ? a : b), high = (uint64_t)(a < b ? b : a);
    return low << 32 | high;
}

/* The slot of a key, or the free one where it belongs. There must be slots. */
static inline plii_key_slot* plii_key_table_probe(const plii_key_table* table, uint64_t key) {
    uint64_t hash = (key + 1) * UINT64_C(0x9e3779b97f4a7c15);
    hash ^= hash >> 32;
    size_t i = (size_t)hash & (size_t)(table->capacity - 1);
    while (table->slots[i].key1 != 0 && table->slots[i].key1 != key + 1) {
        i = (i + 1) & (size_t)(table->capacity - 1);
    }
    return &table->slots[i];
}

/* The index of a key, or PLI_NULL_INDEX. Keys are not UINT64_MAX. */
static inline int plii_key_table_find(const plii_key_table* table, uint64_t key) {
    if (table->count == 0) { return PLI_NULL_INDEX; }
    const plii_key_slot* slot = plii_key_table_probe(table, key);
    return slot->key1 != 0 ? slot->index : PLI_NULL_INDEX;
}

/* The table starts as {.context = ...}. Room for so many keys; false when out of memory. */
bool plii_key_table_reserve(plii_key_table* table, int count);
/* Adds a key that is not there yet. Returns its index, `index` or the one that it has; out of memory PLI_NULL_INDEX. */
int plii_key_table_add(plii_key_table* table, uint64_t key, int index);
/* Slots stay. */
void plii_key_table_clear(plii_key_table* table);
void plii_key_table_free(plii_key_table* table);
static inline size_t plii_key_table_bytes(const plii_key_table* table) {
    return (size_t)table->capacity * sizeof *table->slots;
}
