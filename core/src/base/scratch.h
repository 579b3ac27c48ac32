#pragma once

/* Memory that a function needs for a while: several blocks that go together, and one answer to whether all are there.

       plii_scratch scratch = {.context = context};
       int* stamps = PLII_TAKE(&scratch, int, node_count);
       int* queue = PLII_TAKE(&scratch, int, node_count);
       if (!scratch.is_short) { ... }
       plii_scratch_free(&scratch); */

#include "base/context.h"

enum { PLII_SCRATCH_BLOCKS = 16 };

typedef struct plii_scratch {
    pli_context* context;
    bool is_short; /* of memory, for one block at least */
    int count;
    struct {
        void* memory;
        size_t size;
    } blocks[PLII_SCRATCH_BLOCKS];
} plii_scratch;

/* Zeroed; NULL when out of memory, which is kept in `is_short`, or when `size` is 0. At most PLII_SCRATCH_BLOCKS. */
void* plii_scratch_take(plii_scratch* scratch, size_t size);
#define PLII_TAKE(scratch, type, count) plii_scratch_take(scratch, (size_t)(count) * sizeof(type))
void plii_scratch_free(plii_scratch* scratch);
