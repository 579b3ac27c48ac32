/* The kernel of an instruction set, and sweeps over the colours. */

#include "base/ranges.h"
#include "solver/coloring/links_kernel.h"

enum {
    LINKS_SHARED = 16384, /* links; a body of fewer is done before threads have met after every colour */
    LINKS_GRAIN = 64,     /* groups, some 2 us: what a range costs where processors are far apart */
    LINKS_START_NS = 20   /* per group; no thread waits for another one before all are done */
};

typedef struct links_part {
    const plii_links_kernel* kernel;
    const plii_links_task* task;
    int first_group; /* of the colour */
} links_part;

static links_part links_part_of(const plii_links_task* task) {
    return (links_part){PLII_KERNEL(task->body->context, &plii_links_kernel), task, 0};
}

static void links_range(int begin, int end, void* data) {
    const links_part* part = data;
    part->kernel->groups(part->task, part->first_group + begin, part->first_group + end);
}

/* Every colour is parted alike, down to an eighth. */
static int links_grain(const plii_links_task* task, int group_count) {
    const int eighth = group_count / 8 + 1;
    if (task->body->link_count < LINKS_SHARED) { return group_count; }
    return eighth < LINKS_GRAIN ? eighth : LINKS_GRAIN;
}

void plii_links_sweep_colors(const plii_links_task* task) {
    const plii_link_colors* colors = task->colors;
    links_part part = links_part_of(task);
    for (PLII_EACH(const plii_link_color, color, colors->colors, colors->color_count)) {
        part.first_group = color->first_group;
        plii_parallel_for(task->body->context, links_range, &part, color->group_count,
                          links_grain(task, color->group_count));
    }
}

static void links_start_range(int begin, int end, void* data) {
    const links_part* part = data;
    part->kernel->gather_vectors(part->task, begin, end);
}

void plii_links_start_colors(const plii_links_task* task) {
    links_part part = links_part_of(task);
    plii_parallel_for(task->body->context, links_start_range, &part, task->colors->group_count,
                      plii_grain(LINKS_START_NS));
}
