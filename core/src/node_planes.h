#ifndef PLII_NODE_PLANES_H
#define PLII_NODE_PLANES_H

/* Nodes by component, in the place of as many records: what reads the nodes of a grid in order then needs no turning of
   records into components and back. Even nodes come first, then the odd ones: links of every second node, of which one
   of a grid's diagonals has some and a row all, are then links of nodes that follow each other. */

#include "body_impl.h"

#include <stdbool.h>

/* Bodies of fewer nodes have none. */
enum { PLII_PLANES_LEAST_NODES = 4096 };

/* Nodes of each of several threads. Each has its planes one after the other in a place of its own: a processor reads on
   behind the end of what it goes through, and would take from the other threads what they write. */
typedef struct plii_node_shares {
    int count;                     /* 0: no shares */
    int half;                      /* see plii_planes_half, of the longest share */
    int first[PLII_TEAM_MOST + 1]; /* nodes, multiples of PLII_NODE_SHARES_BLOCK; at the end the node count */
} plii_node_shares;

enum { PLII_NODE_SHARES_BLOCK = 8, PLII_PLANES_GAP = 512 /* numbers, after each share */ };

/* Shares for which a body has room. */
static inline int plii_node_shares_room(const pli_context* context, int node_count) {
    const int most = node_count / PLII_PLANES_LEAST_NODES;
    const int count = most < context->thread_count ? most : context->thread_count;
    return count > 1 ? count : 0;
}

/* Numbers by place. */
typedef struct plii_planes {
    float *x, *y, *z, *w;
    ptrdiff_t odd;                  /* place of node 1 */
    const plii_node_shares* shares; /* or NULL */
} plii_planes;

/* From the planes of one share to those of the next. */
static inline ptrdiff_t plii_node_shares_way(int half) {
    return 8 * (ptrdiff_t)half + PLII_PLANES_GAP;
}
static inline int plii_node_share_of(const plii_node_shares* shares, ptrdiff_t node) {
    int share = 0;
    while (share + 1 < shares->count && node >= shares->first[share + 1]) {
        ++share;
    }
    return share;
}
static inline ptrdiff_t plii_planes_place(const plii_planes* planes, ptrdiff_t node) {
    const ptrdiff_t in_half = (node & 1) * planes->odd;
    if (planes->shares == NULL) { return in_half + (node >> 1); }
    const int share = plii_node_share_of(planes->shares, node);
    return share * plii_node_shares_way(planes->shares->half) + in_half + ((node - planes->shares->first[share]) >> 1);
}

/* Place of node 1. Far enough from a multiple of 2 kB that the planes of even and odd nodes, of which a kernel reads
   eight and more at once, do not begin in the same set of the first cache. */
static inline int plii_planes_half(int node_count) {
    enum { BLOCK = 16, WAY = 512, LEAST_WAY = 80 };
    const int half = ((node_count + 1) / 2 + BLOCK - 1) / BLOCK * BLOCK;
    const int before = half % WAY, after = WAY - before;
    return before < LEAST_WAY ? half + LEAST_WAY - before : after < LEAST_WAY ? half + after + LEAST_WAY : half;
}
/* Records that planes take; with shares some more for gaps and for what a half has beyond its nodes. */
static inline int plii_planes_record_count(const pli_context* context, int node_count) {
    enum { FOR_SHARE = 512 };
    return node_count < PLII_PLANES_LEAST_NODES
               ? node_count
               : 2 * plii_planes_half(node_count) + FOR_SHARE * plii_node_shares_room(context, node_count);
}
/* Whether shares have room in those, and without the last plane in as many records as nodes. */
static inline bool plii_node_shares_fit(const pli_context* context, int node_count, const plii_node_shares* shares) {
    const ptrdiff_t all = shares->count * plii_node_shares_way(shares->half);
    return all <= 4 * (ptrdiff_t)plii_planes_record_count(context, node_count) &&
           all - 2 * (ptrdiff_t)shares->half - PLII_PLANES_GAP <= 4 * (ptrdiff_t)node_count;
}

/* Planes one after the other, in the place of plii_planes_record_count records; without the last one in fewer. */
static inline plii_planes plii_planes_at(void* storage, int node_count, const plii_node_shares* shares) {
    float* first = storage;
    const ptrdiff_t odd = shares != NULL ? shares->half : plii_planes_half(node_count);
    return (plii_planes){first, first + 2 * odd, first + 4 * odd, first + 6 * odd, odd, shares};
}

/* Nodes [begin, end). Without a plane of w it is left out, and is 0 in the records. */
void plii_planes_take(const plii_planes* planes, const pli_vec4* records, int begin, int end);
void plii_planes_give(const plii_planes* planes, pli_vec4* records, int begin, int end);

#endif
