/* Blocks of memory that are freed together. */

#include "base/scratch.h"

void* plii_scratch_take(plii_scratch* scratch, size_t size) {
    void* memory = plii_allocate(scratch->context, size);
    if (memory == NULL) {
        scratch->is_short = scratch->is_short || size > 0;
        return NULL;
    }
    scratch->blocks[scratch->count].memory = memory;
    scratch->blocks[scratch->count++].size = size;
    return memory;
}

void plii_scratch_free(plii_scratch* scratch) {
    while (scratch->count > 0) {
        scratch->count -= 1;
        plii_release(scratch->context, scratch->blocks[scratch->count].memory, scratch->blocks[scratch->count].size);
    }
}
