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
} plii_link_color;

typedef struct plii_link_colors {
    bool is_current; /* links are still those that were coloured */
    int color_count, group_count, row_count, scaled_index_count;
    plii_link_color* colors;                     /* [color_count] */
    plii_link_group* groups;                     /* [group_count] */
    uint32_t (*scaled_indices)[PLII_LINK_LANES]; /* [scaled_index_count] of a node in all lanes */
    int (*row_links)[PLII_LINK_LANES];           /* [row_count] or PLI_NULL_INDEX */
    int color_capacity, group_capacity, scaled_index_capacity, row_capacity;
} plii_link_colors;

/* Its state is a plii_link_colors. */
extern const plii_feature_class plii_link_colors_class;

/* Made anew after a change of topology; NULL when out of memory. */
const plii_link_colors* plii_link_colors_of(pli_body* body);

static inline int plii_link_colors_slot_count(const plii_link_colors* colors) {
    return PLII_LINK_LANES * colors->row_count;
}

/* PLI_NULL_INDEX for a lane without one. */
static inline int plii_link_colors_link(const plii_link_colors* colors, int slot) {
    return colors->row_links[slot / PLII_LINK_LANES][plii_simd_record(slot % PLII_LINK_LANES)];
}
