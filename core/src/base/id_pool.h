#pragma once

/* Ids of things in growing arrays: a slot with a generation that is raised when the thing goes, so that an old id is
   told from a new one. Public ids are { slot + 1, generation }; all zero is none. */

#include "base/context.h"

typedef struct plii_id_slot {
    uint32_t generation;
    int item;      /* PLI_NULL_INDEX when free */
    int next_free; /* PLI_NULL_INDEX at the end */
} plii_id_slot;

typedef struct plii_id_pool {
    plii_id_slot* slots;
    int count, capacity;
    int first_free1; /* slot + 1; 0: none */
} plii_id_pool;

/* Room for so many more; false when out of memory. */
bool plii_id_pool_reserve(pli_context* context, plii_id_pool* pool, int more);
/* A slot for `item`; plii_id_pool_reserve must have succeeded. */
int plii_id_pool_alloc(plii_id_pool* pool, int item);
/* Ids of the slot become stale. */
void plii_id_pool_free(plii_id_pool* pool, int slot);
/* Takes out the items with a slot in the pool of which `goes` is true; the others keep their order. */
#define PLII_ID_POOL_REMOVE_IF(pool, type, at, items, count, goes)                                                     \
    do {                                                                                                               \
        int plii_kept = 0;                                                                                             \
        for (PLII_EACH(const type, at, items, count)) {                                                                \
            if (goes) {                                                                                                \
                plii_id_pool_free(pool, at->slot);                                                                     \
                continue;                                                                                              \
            }                                                                                                          \
            (pool)->slots[at->slot].item = plii_kept;                                                                  \
            (items)[plii_kept++] = *at;                                                                                \
        }                                                                                                              \
        (count) = plii_kept;                                                                                           \
    } while (0)
/* Of one that was read: whether free slots are a list, and others name items below `item_count`. */
bool plii_id_pool_is_sound(const plii_id_pool* pool, int item_count);
/* Whether `item` has the slot. */
static inline bool plii_id_pool_has(const plii_id_pool* pool, int slot, int item) {
    return slot >= 0 && slot < pool->count && pool->slots[slot].item == item;
}
/* The item of a public id, or PLI_NULL_INDEX when it is stale. */
int plii_id_pool_find(const plii_id_pool* pool, int32_t index1, uint32_t generation);
