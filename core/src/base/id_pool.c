/* Slots with generations; freed slots are used again, last freed first. */

#include "base/id_pool.h"

bool plii_id_pool_reserve(pli_context* context, plii_id_pool* pool, int more) {
    const int new_slots = pool->first_free1 != 0 ? more - 1 : more;
    return PLII_RESERVE(context, &pool->slots, &pool->capacity, pool->count + new_slots);
}

int plii_id_pool_alloc(plii_id_pool* pool, int item) {
    int slot = pool->first_free1 - 1;
    if (slot >= 0) {
        pool->first_free1 = pool->slots[slot].next_free + 1;
    } else {
        slot = pool->count++;
        pool->slots[slot].generation = 1;
    }
    pool->slots[slot].item = item;
    return slot;
}

void plii_id_pool_free(plii_id_pool* pool, int slot) {
    pool->slots[slot].generation += 1;
    pool->slots[slot].item = PLI_NULL_INDEX;
    pool->slots[slot].next_free = pool->first_free1 - 1;
    pool->first_free1 = slot + 1;
}

int plii_id_pool_find(const plii_id_pool* pool, int32_t index1, uint32_t generation) {
    if (index1 < 1 || index1 > pool->count) { return PLI_NULL_INDEX; }
    const plii_id_slot* slot = &pool->slots[index1 - 1];
    return slot->generation == generation ? slot->item : PLI_NULL_INDEX;
}

bool plii_id_pool_is_sound(const plii_id_pool* pool, int item_count) {
    int used = 0, listed = 0;
    if (pool->first_free1 < 0) { return false; }
    for (PLII_EACH(const plii_id_slot, at, pool->slots, pool->count)) {
        if (at->item < PLI_NULL_INDEX || at->item >= item_count) { return false; }
        used += at->item != PLI_NULL_INDEX;
    }
    int slot = pool->first_free1 - 1;
    for (; plii_id_pool_has(pool, slot, PLI_NULL_INDEX) && listed < pool->count; ++listed) {
        slot = pool->slots[slot].next_free;
    }
    return slot == PLI_NULL_INDEX && used == item_count && listed + used == pool->count;
}
