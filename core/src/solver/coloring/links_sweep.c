/* The kernel of an instruction set, and sweeps over the colours. */

#include "base/ranges.h"
#include "solver/coloring/links_kernel.h"

enum {
    LINKS_FEW = 16,     /* groups of a colour that are not shared */
    LINKS_GRAIN = 64,   /* groups, some 2 us: what a range costs where processors are far apart */
    LINKS_START_NS = 20 /* per group; no thread waits for another one before all are done */
};

/* Single links alone are not worth wider vectors: their bodies are small, or ropes. */
static const plii_links_kernel* links_kernel(const plii_links_task* task) {
    const pli_context* context = task->body->context;
#if PLIANT_SIMD_X86
    const bool has_quads = task->colors->row_count > task->colors->group_count;
    if (context->def.simd == PLI_SIMD_AVX512 && has_quads) { return &plii_links_kernel_avx512; }
#endif
    return PLII_KERNEL(context, &plii_links_kernel);
}

typedef struct links_part {
    const plii_links_kernel* kernel;
    const plii_links_task* task;
    const plii_link_cuts *cuts, *cuts_end; /* of the colour */
} links_part;

static void links_range(int begin, int end, void* data) {
    const links_part* part = data;
    for (const plii_link_cuts* cuts = part->cuts; cuts < part->cuts_end; ++cuts) {
        part->kernel->groups(part->task, cuts->groups[begin], cuts->groups[end]);
    }
}

void plii_links_sweep_colors(const plii_links_task* task) {
    const plii_link_colors* colors = task->colors;
    links_part part = {links_kernel(task), task, NULL, NULL};
    for (PLII_EACH(const plii_link_color, color, colors->colors, colors->color_count)) {
        if (colors->cut_count == 0 || color->group_count < LINKS_FEW) {
            part.kernel->groups(task, color->first_group, color->first_group + color->group_count);
            continue;
        }
        part.cuts = colors->cuts + color->first_cut;
        part.cuts_end = part.cuts + color->cut_count;
        /* Every colour is parted alike, down to an eighth. */
        const int grain = PLII_LINK_PARTS * LINKS_GRAIN / color->group_count, most = PLII_LINK_PARTS / 8;
        plii_parallel_for(task->body->context, links_range, &part, PLII_LINK_PARTS,
                          grain < 1      ? 1
                          : grain < most ? grain
                                         : most);
    }
}

static void links_start_range(int begin, int end, void* data) {
    const links_part* part = data;
    part->kernel->gather_vectors(part->task, begin, end);
}

void plii_links_start_colors(const plii_links_task* task) {
    links_part part = {links_kernel(task), task, NULL, NULL};
    plii_parallel_for(task->body->context, links_start_range, &part, task->colors->group_count,
                      plii_grain(LINKS_START_NS));
}
