/* Two lists of records, one per step, and a hash table over the older one. */

#include "geometry/pair_cache.h"

#include <string.h>

#define PAIR_LOOK_AHEAD 3

static size_t pair_hash(plii_pair_key key) {
    uint64_t hash = (uint64_t)(uintptr_t)key.other;
    hash = (hash ^ (uint64_t)(uint32_t)key.first ^ (uint64_t)(uint32_t)key.part << 32) * UINT64_C(0x9e3779b97f4a7c15);
    hash = (hash ^ (hash >> 29) ^ (uint64_t)(uint32_t)key.second) * UINT64_C(0xbf58476d1ce4e5b9);
    return (size_t)(hash ^ (hash >> 32));
}

static bool pair_keys_equal(plii_pair_key a, plii_pair_key b) {
    return a.first == b.first && a.second == b.second && a.other == b.other && a.part == b.part;
}

/* Half of the table stays free. */
static int pair_table_size(int count) {
    int size = 16;
    while (size / 2 < count) {
        size *= 2;
    }
    return size;
}

bool plii_pair_cache_reserve(pli_context* context, plii_pair_cache* memory, int count) {
    return PLII_RESERVE(context, &memory->present, &memory->present_capacity, count) &&
           PLII_RESERVE(context, &memory->before, &memory->before_capacity, count) &&
           PLII_RESERVE(context, &memory->table, &memory->table_capacity, pair_table_size(count));
}

bool plii_pair_cache_begin_step(pli_context* context, plii_pair_cache* memory) {
    plii_pair_record* records = memory->before;
    const int capacity = memory->before_capacity;
    memory->before = memory->present;
    memory->before_capacity = memory->present_capacity;
    memory->before_count = memory->present_count;
    memory->present = records;
    memory->present_capacity = capacity;
    memory->present_count = memory->next = 0;

    /* Both have the same size, so that a step like the last one needs nothing. Doubling would have each overtake the
       other. */
    if (memory->present_capacity < memory->before_capacity) {
        plii_release(context, memory->present, (size_t)memory->present_capacity * sizeof *memory->present);
        memory->present = plii_allocate(context, (size_t)memory->before_capacity * sizeof *memory->present);
        memory->present_capacity = memory->present != NULL ? memory->before_capacity : 0;
    }
    const int size = pair_table_size(memory->before_count);
    if (!PLII_RESERVE(context, &memory->table, &memory->table_capacity, size)) {
        memory->before_count = memory->table_size = 0;
        return false;
    }
    memory->table_size = size;
    memset(memory->table, 0, (size_t)size * sizeof *memory->table);
    const size_t mask = (size_t)size - 1;
    for (int i = 0; i < memory->before_count; ++i) {
        size_t slot = pair_hash(memory->before[i].key) & mask;
        while (memory->table[slot] != 0) {
            slot = (slot + 1) & mask;
        }
        memory->table[slot] = i + 1;
    }
    return true;
}

/* Among those of the last step, or PLI_NULL_INDEX. */
static int pair_place(const plii_pair_cache* memory, plii_pair_key key) {
    const size_t mask = (size_t)memory->table_size - 1;
    for (size_t slot = pair_hash(key) & mask; memory->before_count > 0 && memory->table[slot] != 0;
         slot = (slot + 1) & mask) {
        const int place = memory->table[slot] - 1;
        if (pair_keys_equal(memory->before[place].key, key)) { return place; }
    }
    return PLI_NULL_INDEX;
}

const plii_convex_cache* plii_pair_cache_find(const plii_pair_cache* memory, plii_pair_key key) {
    const int place = pair_place(memory, key);
    return place != PLI_NULL_INDEX ? &memory->before[place].cache : NULL;
}

/* Pairs mostly come in the order of the last step, some of which do not come any more. */
static int pair_next_place(plii_pair_cache* memory, plii_pair_key key) {
    for (int place = memory->next; place < memory->before_count && place < memory->next + PAIR_LOOK_AHEAD; ++place) {
        if (pair_keys_equal(memory->before[place].key, key)) {
            memory->next = place + 1;
            return place;
        }
    }
    const int place = pair_place(memory, key);
    if (place != PLI_NULL_INDEX) { memory->next = place + 1; }
    return place;
}

void plii_pair_cache_forget(plii_pair_cache* memory) {
    memory->present_count = memory->before_count = 0;
}

plii_convex_cache* plii_pair_cache_get(pli_context* context, plii_pair_cache* memory, plii_pair_key key) {
    if (!PLII_RESERVE(context, &memory->present, &memory->present_capacity, memory->present_count + 1)) { return NULL; }
    plii_pair_record* record = &memory->present[memory->present_count++];
    *record = (plii_pair_record){.key = key, .previous_index = pair_next_place(memory, key)};
    if (record->previous_index != PLI_NULL_INDEX) { record->cache = memory->before[record->previous_index].cache; }
    return &record->cache;
}

void plii_pair_cache_release(pli_context* context, plii_pair_cache* memory) {
    plii_release(context, memory->present, (size_t)memory->present_capacity * sizeof *memory->present);
    plii_release(context, memory->before, (size_t)memory->before_capacity * sizeof *memory->before);
    plii_release(context, memory->table, (size_t)memory->table_capacity * sizeof *memory->table);
    *memory = (plii_pair_cache){0};
}

size_t plii_pair_cache_bytes(const plii_pair_cache* memory) {
    return (size_t)memory->present_capacity * sizeof *memory->present +
           (size_t)memory->before_capacity * sizeof *memory->before +
           (size_t)memory->table_capacity * sizeof *memory->table;
}
