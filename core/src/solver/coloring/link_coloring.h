#ifndef PLII_LINK_COLORING_H
#define PLII_LINK_COLORING_H

/* Service: the links of a body in an order fit for SIMD and threads. Links of one colour share no node, but for those
   of one quad (link_quads.h), so quads of one colour may be solved in any order or at once, eight in a group; the links
   of a quad are solved in the order of its pairs of nodes. Single links are quads of two nodes. What the last colours
   cannot take (nodes of very many links) stays in a serial list.

   Numbers of a link are in its slot: rows of eight for one pair of nodes of a group, then the
   serial list. Within a row slots follow the lanes of simd_float8.h. Lanes without a quad come first and have the nodes
   of quads of the group, so kernels may store nodes as they were, in the order of the lanes; nodes without a link are
   like the first one, so kernels store the first nodes last. */

#include "solver/coloring/link_quads.h"

typedef struct plii_link_group {
    int first_row;          /* one row for each of `pairs` */
    int first_scaled_index; /* of four, of single links of two */
    plii_link_tag tag;      /* of all links */
    uint8_t pairs;          /* bit k: some lane has a link there */
} plii_link_group;

typedef struct plii_link_color {
    int first_group, group_count;
} plii_link_color;

typedef struct plii_link_colors {
    int color_count, group_count, row_count, scaled_index_count, serial_count;
    plii_link_color* colors;                     /* [color_count] */
    plii_link_group* groups;                     /* [group_count] */
    uint32_t (*scaled_indices)[PLII_LINK_LANES]; /* [scaled_index_count] of a node in all lanes */
    int (*row_links)[PLII_LINK_LANES];           /* [row_count] or PLI_NULL_INDEX */
    int* serial_links;                           /* [serial_count] */
    char* storage;
    size_t storage_size;
} plii_link_colors;

/* Its state is a plii_link_colors. */
extern const plii_feature_class plii_link_colors_class;

static inline int plii_link_colors_first_serial_slot(const plii_link_colors* colors) {
    return PLII_LINK_LANES * colors->row_count;
}
static inline int plii_link_colors_slot_count(const plii_link_colors* colors) {
    return plii_link_colors_first_serial_slot(colors) + colors->serial_count;
}

/* Of each slot the value of its link: values[stride * link], or `filler` for lanes without a link. */
void plii_link_colors_gather(const plii_link_colors* colors, const float* values, int stride, float filler,
                             float* slots);

/* `width` numbers for each slot. */
typedef struct plii_link_slots {
    float* values;
    size_t size; /* bytes */
} plii_link_slots;

bool plii_link_slots_make(const pli_body* body, const plii_link_colors* colors, int width, plii_link_slots* slots);
void plii_link_slots_release(const pli_body* body, plii_link_slots* slots);
/* What to ask for when the topology changes, and afterwards, when the colours are new: takes over the block, or one
   that just holds the slots where there is memory for it. The values are lost. */
size_t plii_link_slots_max_size(const pli_body* body, int link_count, int width);
void plii_link_slots_replace(const pli_body* body, const plii_link_colors* colors, int link_count, int width,
                             void* block, plii_link_slots* slots);

#endif
