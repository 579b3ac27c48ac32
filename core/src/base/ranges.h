#pragma once

/* Ranges over the nodes, faces, links or pairs of one large body. Bits do not depend on how they are parted: a part
   writes what belongs to its items; sums and lists are made in blocks, which depend on the number of items alone. */

#include "base/context.h"

/* What a part is to take at least, that it is worth a thread: to hand one over takes a microsecond or two. */
enum { PLII_PART_NANOSECONDS = 8000 };

/* Of items that take so long each: how many make a part. */
static inline int plii_grain(int nanoseconds) {
    return nanoseconds < PLII_PART_NANOSECONDS ? PLII_PART_NANOSECONDS / nanoseconds : 1;
}

enum { PLII_MOST_BLOCKS = 64 };

typedef struct plii_blocks {
    int size, count;
} plii_blocks;

/* Of at least `least` items each, at most `most` of them; one block where there are fewer. */
static inline plii_blocks plii_blocks_of(int item_count, int least, int most) {
    const int even = (item_count + most - 1) / most, size = even > least ? even : least;
    return (plii_blocks){size, item_count > 0 ? (item_count - 1) / size + 1 : 0};
}

typedef void plii_block_fn(int begin, int end, int block, void* task);
void plii_run_blocks(pli_context* context, plii_blocks blocks, int item_count, plii_block_fn* run, void* task);

/* Sums of blocks, added in their order, where there is one, that sum. */
typedef double plii_block_value_fn(int begin, int end, const void* task);
double plii_sum_blocks(pli_context* context, int item_count, int least, plii_block_value_fn* value, const void* task);
