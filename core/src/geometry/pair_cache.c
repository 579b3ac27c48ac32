/* Two lists of records, one per step, and a table of the older one by hashes of keys. */

#include "geometry/pair_cache.h"

uint64_t plii_pair_key_hash(plii_pair_key key) {
    uint64_t hash = (uint64_t)(uintptr_t)key.other;
    hash = (hash ^ (uint64_t)(uint32_t)key.first ^ (uint64_t)(uint32_t)key.part << 32) * UINT64_C(0x9e3779b97f4a7c15);
    hash = (hash ^ (hash >> 29) ^ (uint64_t)(uint32_t)key.second) * UINT64_C(0xbf58476d1ce4e5b9);
    return (hash ^ (hash >> 32)) >> 1;
}

bool plii_pair_keys_equal(plii_pair_key a, plii_pair_key b) {
    return a.first == b.first && a.second == b.second && a.other == b.other && a.part == b.part;
}

bool plii_pair_cache_reserve(pli_context* context, plii_pair_cache* cache, int count) {
    cache->table.context = context;
    return PLII_RESERVE(context, &cache->present.items, &cache->present.capacity, count) &&
           PLII_RESERVE(context, &cache->before.items, &cache->before.capacity, count) &&
           plii_key_table_reserve(&cache->table, count);
}

bool plii_pair_cache_index_before(pli_context* context, plii_pair_cache* cache) {
    plii_key_table_clear(&cache->table);
    cache->table.context = context;
    if (!plii_key_table_reserve(&cache->table, cache->before.count)) {
        cache->before.count = 0;
        return false;
    }
    for (int i = 0; i < cache->before.count; ++i) {
        (void)plii_key_table_add(&cache->table, plii_pair_key_hash(cache->before.items[i].key), i);
    }
    return true;
}

void plii_match_capacity(pli_context* context, void** empty, int* capacity, int other, size_t element_size) {
    if (*capacity >= other) { return; }
    plii_release(context, *empty, (size_t)*capacity * element_size);
    *capacity = plii_allocate_array(context, empty, (size_t)other * element_size) ? other : 0;
}

bool plii_pair_cache_begin_step(pli_context* context, plii_pair_cache* cache) {
    plii_pair_records* next = &cache->present;
    PLII_SWAP(plii_pair_records, cache->present, cache->before);
    next->count = 0;
    plii_match_capacity(context, (void**)&next->items, &next->capacity, cache->before.capacity, sizeof *next->items);
    return plii_pair_cache_index_before(context, cache);
}

/* Among those of the last step, or PLI_NULL_INDEX. */
static int pair_find_before(const plii_pair_cache* cache, plii_pair_key key) {
    const int index = plii_key_table_find(&cache->table, plii_pair_key_hash(key));
    return index != PLI_NULL_INDEX && plii_pair_keys_equal(cache->before.items[index].key, key) ? index
                                                                                                : PLI_NULL_INDEX;
}
plii_convex_cache* plii_pair_cache_find(const plii_pair_cache* cache, plii_pair_key key) {
    const int index = pair_find_before(cache, key);
    return index != PLI_NULL_INDEX ? &cache->before.items[index].cache : NULL;
}
void plii_pair_cache_clear(plii_pair_cache* cache) {
    cache->present.count = cache->before.count = 0;
    plii_key_table_clear(&cache->table);
}
void plii_pair_cache_forget(pli_context* context, plii_pair_cache* cache, const void* other) {
    const int count = cache->before.count;
    PLII_REMOVE_IF(plii_pair_record, record, cache->before.items, cache->before.count, record->key.other == other);
    if (cache->before.count < count) { (void)plii_pair_cache_index_before(context, cache); }
}

plii_pair_record* plii_pair_cache_get(pli_context* context, plii_pair_cache* cache, plii_pair_key key) {
    plii_pair_records* present = &cache->present;
    const plii_pair_records* before = &cache->before;
    if (!PLII_GROW(context, &present->items, &present->capacity, present->count)) { return NULL; }
    plii_pair_record* record = &present->items[present->count++];
    /* Mostly the one after that of the pair before: steps ask in the same order. */
    const int next = present->count > 1 ? record[-1].previous_index + 1 : 0;
    const bool is_next = next < before->count && plii_pair_keys_equal(before->items[next].key, key);
    const int index = is_next ? next : pair_find_before(cache, key);
    record->key = key;
    record->slot = 0;
    record->previous_index = index;
    record->cache = index != PLI_NULL_INDEX ? before->items[index].cache : (plii_convex_cache){0};
    return record;
}

void plii_pair_cache_release(pli_context* context, plii_pair_cache* cache) {
    PLII_RELEASE(context, cache->present.items, cache->present.capacity);
    PLII_RELEASE(context, cache->before.items, cache->before.capacity);
    plii_key_table_free(&cache->table);
    *cache = (plii_pair_cache){0};
}

static bool pair_records_are_sound(const plii_pair_records* records) {
    for (PLII_EACH(const plii_pair_record, record, records->items, records->count)) {
        if (record->cache.count < 0 || record->cache.count > PLII_CONVEX_CACHE_POINTS) { return false; }
    }
    return true;
}

bool plii_pair_cache_is_sound(const plii_pair_cache* cache) {
    return pair_records_are_sound(&cache->present) && pair_records_are_sound(&cache->before);
}
