#pragma once

/* What is known of undirected edges, by hashing, so that a change of topology takes linear time. */

#include "base/key_table.h"

typedef struct plii_edge {
    int a, b;           /* nodes, a < b */
    int node;           /* that parts the edge, or PLI_NULL_INDEX */
    float share;        /* where it does, from a to b */
    float rest_squared; /* m^2, negative: unknown */
    unsigned flags;     /* for the user of the map */
    int first;          /* for the user of the map, starts as PLI_NULL_INDEX */
} plii_edge;

typedef struct plii_edge_map {
    plii_key_table table;
    plii_edge* edges; /* [count] in the order of adding */
    int count, capacity;
} plii_edge_map;

/* The map starts as {.table.context = ...}. An edge, until another is added; NULL when out of memory. */
plii_edge* plii_edge_map_add(plii_edge_map* map, int a, int b);
/* NULL when the edge is not there. */
static inline plii_edge* plii_edge_map_find(const plii_edge_map* map, int a, int b) {
    const int index = plii_key_table_find(&map->table, plii_edge_key(a, b));
    return index != PLI_NULL_INDEX ? &map->edges[index] : NULL;
}
/* The node that parts an edge, or PLI_NULL_INDEX. */
static inline int plii_edge_map_node(const plii_edge_map* map, int a, int b) {
    const plii_edge* edge = plii_edge_map_find(map, a, b);
    return edge != NULL ? edge->node : PLI_NULL_INDEX;
}
/* [count] indices of all edges ordered by a, then b; NULL when out of memory, or when there are no edges. */
const int* plii_edge_map_order(const plii_edge_map* map, int node_count, plii_scratch* scratch);
void plii_edge_map_free(plii_edge_map* map);
