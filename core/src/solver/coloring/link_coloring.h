#pragma once

/* Service: the links of a body in an order fit for SIMD and threads. Links of one colour share no node, but for those
   of one quad (link_quads.h), so quads of one colour may be solved in any order or at once, eight in a group; the links
   of a quad are solved in the order of its pairs of nodes. Single links are quads of two nodes. At nodes of very
   many links, where no colour is left, each quad gets one of its own.

   Numbers of a link are in its slot: rows of eight for one pair of nodes of a group, which follow the lanes of
   simd_float8.h. Lanes without a quad come first and have the nodes of others, so kernels may store nodes as they were,
   in the order of the lanes; nodes without a link are like the first one, which kernels store last. */

#include "math/simd_float8.h"
#include "solver/coloring/link_quads.h"

typedef struct plii_link_group {
    int first_row;          /* one row for each of `pairs` */
    int first_scaled_index; /* of four, of single links of two */
    uint8_t pairs;          /* bit k: some lane has a link there */
} plii_link_group;

typedef struct plii_link_color {
    int first_group, group_count;
    int first_cut, cut_count;
} plii_link_color;

/* Groups of one kind go along the nodes, one kind after the other. So a part that is to find its nodes in the cache of
   its thread, in all colours, has some of each kind. */
enum { PLII_LINK_PARTS = 64 };

/* Of groups of a colour, along the nodes once: where each part begins. */
typedef struct plii_link_cuts {
    int groups[PLII_LINK_PARTS + 1];
} plii_link_cuts;

typedef struct plii_link_colors {
    bool is_current; /* links are still those that were coloured */
    int color_count, group_count, row_count, scaled_index_count, cut_count;
    int linked_row_count;                        /* with links, so the same for all instruction sets */
    plii_link_color* colors;                     /* [color_count] */
    plii_link_group* groups;                     /* [group_count] */
    uint32_t (*scaled_indices)[PLII_LINK_LANES]; /* [scaled_index_count] of a node in all lanes */
    int (*row_links)[PLII_LINK_LANES];           /* [row_count] or PLI_NULL_INDEX */
    plii_link_cuts* cuts;                        /* [cut_count] where threads share a body of many links */
    int color_capacity, group_capacity, scaled_index_capacity, row_capacity, cut_capacity;
} plii_link_colors;

/* A body of fewer links is done before threads have met after every colour. */
enum { PLII_LINKS_SHARED = 16384 };

/* Made anew after a change of topology; NULL when out of memory. */
const plii_link_colors* plii_link_colors_of(pli_body* body);

static inline int plii_link_colors_slot_count(const plii_link_colors* colors) {
    return PLII_LINK_LANES * colors->row_count;
}

/* PLI_NULL_INDEX for a lane without one. */
static inline int plii_link_colors_link(const plii_link_colors* colors, int slot) {
    return colors->row_links[slot / PLII_LINK_LANES][plii_simd_record(slot % PLII_LINK_LANES)];
}
