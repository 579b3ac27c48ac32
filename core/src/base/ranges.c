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

typedef struct sum_task {
    plii_block_sum_fn* sum;
    const void* task;
    double sums[PLII_MOST_BLOCKS];
} sum_task;

static void sum_block(int begin, int end, int block, void* data) {
    sum_task* all = data;
    all->sums[block] = all->sum(begin, end, all->task);
}

double plii_sum_blocks(pli_context* context, int item_count, int least, plii_block_sum_fn* sum, const void* task) {
    const plii_blocks blocks = plii_blocks_of(item_count, least, PLII_MOST_BLOCKS);
    sum_task all = {.sum = sum, .task = task};
    if (blocks.count <= 1) { return sum(0, item_count, task); }
    plii_run_blocks(context, blocks, item_count, sum_block, &all);
    double total = all.sums[0];
    for (int b = 1; b < blocks.count; ++b) {
        total += all.sums[b];
    }
    return total;
}
