#ifndef PLII_EDGE_MAP_H
#define PLII_EDGE_MAP_H

/* What is known of undirected edges, by hashing, so that a change of topology takes linear time. */

#include "base/context.h"

typedef struct plii_edge {
    int a, b;           /* nodes, a < b */
    int node;           /* that parts the edge, or PLI_NULL_INDEX */
    float share;        /* where it does, from a to b */
    float rest_squared; /* m^2, negative: unknown */
    unsigned flags;     /* for the user of the map */
    int first;          /* for the user of the map, starts as PLI_NULL_INDEX */
} plii_edge;

typedef struct plii_edge_map {
    pli_context* context;
    plii_edge* edges; /* [count] in the order of adding */
    int count, capacity;
    int* slots; /* [slot_count] place in `edges` plus 1, 0 = free; the count is a power of two */
    size_t slot_count;
} plii_edge_map;

/* The map starts as {.context = ...}. Place of an edge, added when it is new; PLI_NULL_INDEX when out of memory. */
int plii_edge_map_add(plii_edge_map* map, int a, int b);
/* PLI_NULL_INDEX when the edge is not there. */
int plii_edge_map_find(const plii_edge_map* map, int a, int b);
/* Places of all edges ordered by a, then b. `order` has room for map->count, node indices are below `node_count`.
   False when out of memory. */
bool plii_edge_map_order(const plii_edge_map* map, int node_count, int* order);
void plii_edge_map_free(plii_edge_map* map);

#endif
