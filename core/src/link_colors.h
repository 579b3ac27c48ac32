#ifndef PLII_LINK_COLORS_H
#define PLII_LINK_COLORS_H

/* Service: the links of a body in an order fit for SIMD and threads. Links of one colour share no node, so they may be
   solved in any order or at once. A colour holds groups of eight links of one tag (material, bending), of two kinds:

   - runs: links whose nodes advance by a constant stride, as in the rows, columns and diagonals of a grid. They need no
     indices, and most of them read their nodes in the order of memory;
   - blocks: any links, by index.

   What the last colours cannot take (nodes of very many links) stays in a serial list.

   Each link has a place for numbers of its own, its slot: those of runs first, then of blocks, then of the serial list.
   Within a group slots follow the lanes of simd.h. A block that is not full has lanes without a link. These come first
   and have the nodes of links of the block, so kernels may store nodes as they were, in the order of the links. */

#include "body_impl.h"

enum { PLII_LINK_GROUP = 8 };

typedef struct plii_link_run {
    int node, stride;      /* the first link's smaller node; from link to link */
    int offset;            /* to the other node */
    int link, link_stride; /* index of the first link; from link to link, 0: `link` is an index into run_links */
    int first_group, group_count;
    plii_link_tag tag;
} plii_link_run;

typedef struct plii_link_color {
    int first_run, first_block; /* to those of the next colour */
    int first_group;            /* of its runs */
} plii_link_color;

typedef struct plii_link_colors {
    int color_count, run_count, run_link_count, block_count, serial_count;
    int run_group_count;
    plii_link_color* colors;        /* [color_count + 1] */
    plii_link_run* runs;            /* [run_count] */
    int* run_links;                 /* [run_link_count] of runs whose links have no stride */
    uint32_t (*block_places)[2][8]; /* [block_count] places (simd.h) of the first nodes, of the others */
    int (*block_links)[8];          /* [block_count] or PLI_NULL_INDEX */
    plii_link_tag* block_tags;      /* [block_count] */
    int* serial_links;              /* [serial_count] */
    void* storage;
    size_t storage_size;
} plii_link_colors;

/* Its state is a plii_link_colors. */
extern const plii_feature_class plii_link_colors_class;

static inline plii_link_tag plii_link_colors_tag(const pli_body* body, int link) {
    return body->link_tags != NULL ? body->link_tags[link] : (plii_link_tag)0;
}
static inline int plii_link_colors_slot_count(const plii_link_colors* colors) {
    return PLII_LINK_GROUP * (colors->run_group_count + colors->block_count) + colors->serial_count;
}
/* Groups of a colour, those of runs first. */
static inline int plii_link_colors_group_count(const plii_link_colors* colors, int color) {
    const plii_link_color* own = &colors->colors[color];
    return own[1].first_group - own[0].first_group + own[1].first_block - own[0].first_block;
}

typedef struct plii_link_part {
    int begin, end; /* nothing when end <= begin */
} plii_link_part;

/* Of groups [begin, end) of a colour: those of a run, counted from its first one, and the blocks. */
static inline plii_link_part plii_link_run_part(const plii_link_run* run, const plii_link_color* color, int begin,
                                                int end) {
    const int before = run->first_group - color->first_group;
    return (plii_link_part){begin > before ? begin - before : 0,
                            end - before < run->group_count ? end - before : run->group_count};
}
static inline plii_link_part plii_link_block_part(const plii_link_color* color, int begin, int end) {
    const int in_runs = color[1].first_group - color[0].first_group;
    return (plii_link_part){color->first_block + (begin > in_runs ? begin - in_runs : 0),
                            color->first_block + (end > in_runs ? end - in_runs : 0)};
}

/* Share [begin, end) of the groups of a colour: as much of its runs as of its blocks, so that a thread meets the nodes
   of one part of the body. Both as groups of the colour. */
static inline plii_link_part plii_link_run_share(const plii_link_color* color, int begin, int end) {
    const int64_t in_runs = color[1].first_group - color[0].first_group;
    const int64_t count = in_runs + color[1].first_block - color[0].first_block;
    return (plii_link_part){(int)(begin * in_runs / count), (int)(end * in_runs / count)};
}
static inline plii_link_part plii_link_block_share(const plii_link_color* color, int begin, int end) {
    const int64_t in_runs = color[1].first_group - color[0].first_group;
    const int64_t in_blocks = color[1].first_block - color[0].first_block, count = in_runs + in_blocks;
    return (plii_link_part){(int)(in_runs + begin * in_blocks / count), (int)(in_runs + end * in_blocks / count)};
}

/* Of each slot the value of its link: values[stride * link], or `filler` for lanes without a link. */
void plii_link_colors_gather(const plii_link_colors* colors, const float* values, int stride, float filler,
                             float* slots);

/* A number for each slot. */
typedef struct plii_link_slots {
    float* values;
    size_t size; /* bytes */
} plii_link_slots;

bool plii_link_slots_make(const pli_body* body, const plii_link_colors* colors, plii_link_slots* slots);
void plii_link_slots_release(const pli_body* body, plii_link_slots* slots);
/* What to ask for when the topology changes, and afterwards, when the colours are new: takes over the block, or one
   that just holds the slots where there is memory for it. The values are lost. */
size_t plii_link_slots_max_size(const pli_body* body, int link_count);
void plii_link_slots_replace(const pli_body* body, const plii_link_colors* colors, int link_count, void* block,
                             plii_link_slots* slots);

#endif
