#pragma once

/* Sets of up to six links that have four nodes between them, which who solves them reads and writes once. */

#include "base/csr.h"
#include "body/body_impl.h"

enum { PLII_LINK_LANES = 8, PLII_LINK_PAIRS = 6 };

/* Pairs of the four nodes. The first two, the next two and the last two have no node in common. */
static const uint8_t plii_link_pair_nodes[PLII_LINK_PAIRS][2] = {{0, 1}, {2, 3}, {0, 2}, {1, 3}, {0, 3}, {1, 2}};

/* Pairs that have links, bit by bit: of a single link, whose other two nodes are the first one again; of three links in
   a row; of two triangles, as most quads of a triangle mesh; of the cell of a grid with both diagonals. */
enum { PLII_LINK_SINGLE = 1, PLII_LINK_PATH = 7, PLII_LINK_TWO_TRIANGLES = 31, PLII_LINK_ALL_PAIRS = 63 };

typedef struct plii_link_quad {
    int nodes[4];   /* one that no link has is the first one again */
    int first_link; /* into the links of the quads: one for each pair that has one, in the order of pairs */
    uint8_t pairs;  /* bit k: pair k has a link */
} plii_link_quad;

typedef struct plii_link_quads {
    int quad_count, in_quads, single_count;
    plii_link_quad* quads;  /* [link_count / 3] */
    int* links;             /* [link_count] in_quads links of quads, then single_count others by their smaller node */
    plii_half_link* halves; /* [2 * link_count] by node; what finding needs for a while, as all below */
    int* begin;             /* [node_count + 1] of the links of a node */
    int* open;              /* [node_count] those before are used */
    uint8_t* marks;         /* [node_count] zero */
    uint8_t* is_used;       /* [link_count] zero */
} plii_link_quads;

/* Fills in what `quads` has room for. Without `is_wanted` all links are single. */
void plii_link_quads_find(const pli_body* body, bool is_wanted, plii_link_quads* quads);
