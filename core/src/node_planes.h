#ifndef PLII_NODE_PLANES_H
#define PLII_NODE_PLANES_H

/* Nodes by component, in the place of as many records: what reads the nodes of a grid in order then needs no turning of
   records into components and back. */

#include "body_impl.h"

/* Numbers by node. */
typedef struct plii_planes {
    float *x, *y, *z, *w;
} plii_planes;

/* Planes of `length` numbers one after the other. */
static inline plii_planes plii_planes_at(void* storage, int length) {
    float* first = storage;
    return (plii_planes){first, first + length, first + 2 * (ptrdiff_t)length, first + 3 * (ptrdiff_t)length};
}

/* Nodes [begin, end). Without a plane of w it is left out, and is 0 in the records. */
void plii_planes_take(const plii_planes* planes, const pli_vec4* records, int begin, int end);
void plii_planes_give(const plii_planes* planes, pli_vec4* records, int begin, int end);

#endif
