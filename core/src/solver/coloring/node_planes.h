#ifndef PLII_NODE_PLANES_H
#define PLII_NODE_PLANES_H

/* Nodes by component, in the place of as many records: what reads the nodes of a grid in order then needs no turning of
   records into components and back. Even nodes come first, then the odd ones: links of every second node, of which one
   of a grid's diagonals has some and a row all, are then links of nodes that follow each other. */

#include "body/body_impl.h"

#include <stdbool.h>

/* Bodies of fewer nodes have none. */
enum { PLII_PLANES_LEAST_NODES = 4096 };

/* Numbers by place. */
typedef struct plii_planes {
    float *x, *y, *z, *w;
    ptrdiff_t odd; /* place of node 1 */
} plii_planes;

static inline ptrdiff_t plii_planes_place(const plii_planes* planes, ptrdiff_t node) {
    return (node & 1) * planes->odd + (node >> 1);
}

/* Place of node 1. Far enough from a multiple of 2 kB that the planes of even and odd nodes, of which a kernel reads
   eight and more at once, do not begin in the same set of the first cache. */
static inline int plii_planes_half(int node_count) {
    enum { BLOCK = 16, WAY = 512, LEAST_WAY = 80 };
    const int half = ((node_count + 1) / 2 + BLOCK - 1) / BLOCK * BLOCK;
    const int before = half % WAY, after = WAY - before;
    return before < LEAST_WAY ? half + LEAST_WAY - before : after < LEAST_WAY ? half + after + LEAST_WAY : half;
}
/* Records that planes take. */
static inline int plii_planes_record_count(int node_count) {
    return node_count < PLII_PLANES_LEAST_NODES ? node_count : 2 * plii_planes_half(node_count);
}

/* Planes one after the other, in the place of plii_planes_record_count records; without the last one in fewer. */
static inline plii_planes plii_planes_at(void* storage, int node_count) {
    float* first = storage;
    const ptrdiff_t odd = plii_planes_half(node_count);
    return (plii_planes){first, first + 2 * odd, first + 4 * odd, first + 6 * odd, odd};
}

/* Nodes [begin, end). Without a plane of w it is left out, and is 0 in the records. */
void plii_planes_take(const plii_planes* planes, const pli_vec4* records, int begin, int end);
void plii_planes_give(const plii_planes* planes, pli_vec4* records, int begin, int end);

#endif
