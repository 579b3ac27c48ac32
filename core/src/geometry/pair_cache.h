#pragma once

/* What pairs of convex sets remember from step to step, by key; only of those that were asked for in the last step. */

#include "base/key_table.h"
#include "geometry/gjk.h"

typedef struct plii_pair_key {
    int first, second;
    const void* other; /* identity of what `second` counts in */
    int part;          /* of `second` */
} plii_pair_key;

/* For a plii_key_table. Of keys with the same hash, which hardly happens, only the first is found. */
uint64_t plii_pair_key_hash(plii_pair_key key);
bool plii_pair_keys_equal(plii_pair_key a, plii_pair_key b);

typedef struct plii_pair_record {
    plii_pair_key key;
    plii_convex_cache cache;
    int slot;           /* of whoever asks; 0 in a new record, not carried over */
    int previous_index; /* in the step of the record: among those of the one before, or PLI_NULL_INDEX */
} plii_pair_record;

/* Those of a step, in the order of asking. */
typedef struct plii_pair_records {
    plii_pair_record* items;
    int count, capacity;
} plii_pair_records;

typedef struct plii_pair_cache {
    plii_pair_records present, before; /* of this step, and of the last one */
    plii_key_table table;              /* of `before` */
} plii_pair_cache;

/* Of two lists that change places from step to step, gives the empty one as much room as the other one has: a step like
   the last one needs nothing then, and a snapshot fits both. No more: doubled, each would overtake the other. */
void plii_match_capacity(pli_context* context, void** empty, int* capacity, int other, size_t element_size);

/* Room for that many pairs in a step; false when out of memory. */
bool plii_pair_cache_reserve(pli_context* context, plii_pair_cache* cache, int count);
/* Starts a step: what was present becomes what was before. False when out of memory; nothing is remembered then. */
bool plii_pair_cache_begin_step(pli_context* context, plii_pair_cache* cache);
/* The record of a pair, with its cache as of the last step; valid until the next call. NULL: no memory. */
plii_pair_record* plii_pair_cache_get(pli_context* context, plii_pair_cache* cache, plii_pair_key key);
/* What a pair held in the last step; NULL when it was not asked for. Does not count as asking. */
plii_convex_cache* plii_pair_cache_find(const plii_pair_cache* cache, plii_pair_key key);
/* Somebody goes away or changes: all pairs start anew, or those with that `other` in their keys. */
void plii_pair_cache_clear(plii_pair_cache* cache);
/* Before pairs are asked for in a step. */
void plii_pair_cache_forget(pli_context* context, plii_pair_cache* cache, const void* other);
/* What was before was replaced. False when out of memory, which cannot be where as many were; nothing is remembered. */
bool plii_pair_cache_index_before(pli_context* context, plii_pair_cache* cache);
/* Of one that was read: directions are no more than there is room for. */
bool plii_pair_cache_is_sound(const plii_pair_cache* cache);
void plii_pair_cache_release(pli_context* context, plii_pair_cache* cache);
