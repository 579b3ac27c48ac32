#ifndef PLII_EDGE_SET_H
#define PLII_EDGE_SET_H

/* A set of undirected edges by hashing, so that meshes are made in linear time. */

#include "base/context.h"

typedef struct plii_edge_set {
    pli_context* context;
    uint64_t* slots; /* [mask + 1] 0 = free */
    size_t mask;
} plii_edge_set;

/* False when out of memory; then nothing is kept. */
bool plii_edge_set_create(pli_context* context, size_t max_edges, plii_edge_set* set);
void plii_edge_set_destroy(plii_edge_set* set);
/* True when the edge was not there before. At most `max_edges` different edges, node indices >= 0. */
bool plii_edge_set_insert(plii_edge_set* set, int a, int b);
bool plii_edge_set_contains(const plii_edge_set* set, int a, int b);

#endif
