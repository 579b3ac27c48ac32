#include "base/ranges.h"

typedef struct blocks_task {
    plii_blocks blocks;
    int item_count;
    plii_block_fn* run;
    void* task;
} blocks_task;

static void blocks_range(int begin, int end, void* data) {
    const blocks_task* all = data;
    for (int b = begin; b < end; ++b) {
        const int first = b * all->blocks.size, left = all->item_count - first;
        all->run(first, first + (left < all->blocks.size ? left : all->blocks.size), b, all->task);
    }
}

void plii_run_blocks(pli_context* context, plii_blocks blocks, int item_count, plii_block_fn* run, void* task) {
    blocks_task all = {blocks, item_count, run, task};
    plii_parallel_for(context, blocks_range, &all, blocks.count, 1);
}

typedef struct values_task {
    plii_block_value_fn* value;
    const void* task;
    double values[PLII_MOST_BLOCKS];
} values_task;

static void values_block(int begin, int end, int block, void* data) {
    values_task* all = data;
    all->values[block] = all->value(begin, end, all->task);
}

double plii_sum_blocks(pli_context* context, int item_count, int least, plii_block_value_fn* value, const void* task) {
    const plii_blocks blocks = plii_blocks_of(item_count, least, PLII_MOST_BLOCKS);
    values_task all = {.value = value, .task = task};
    if (blocks.count <= 1) { return value(0, item_count, task); }
    plii_run_blocks(context, blocks, item_count, values_block, &all);
    double sum = all.values[0];
    for (int b = 1; b < blocks.count; ++b) {
        sum += all.values[b];
    }
    return sum;
}
