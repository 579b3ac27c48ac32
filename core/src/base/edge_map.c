/* Edges in a list, found by a table. */

#include "base/edge_map.h"

#include "base/csr.h"

plii_edge* plii_edge_map_add(plii_edge_map* map, int a, int b) {
    if (!PLII_GROW(map->table.context, &map->edges, &map->capacity, map->count)) { return NULL; }
    const int index = plii_key_table_add(&map->table, plii_edge_key(a, b), map->count);
    if (index == PLI_NULL_INDEX) { return NULL; }
    if (index == map->count) {
        map->edges[map->count++] = (plii_edge){.a = a < b ? a : b,
                                               .b = a < b ? b : a,
                                               .node = PLI_NULL_INDEX,
                                               .rest_squared = -1.0f,
                                               .first = PLI_NULL_INDEX};
    }
    return &map->edges[index];
}

const int* plii_edge_map_order(const plii_edge_map* map, int node_count, plii_scratch* scratch) {
    int* begin = PLII_TAKE(scratch, int, (size_t)node_count + 1);
    int* keys = PLII_TAKE(scratch, int, map->count);
    int* by_b = PLII_TAKE(scratch, int, map->count);
    int* order = PLII_TAKE(scratch, int, map->count);
    if (scratch->is_short || map->count == 0) { return NULL; }
    for (int i = 0; i < map->count; ++i) {
        keys[i] = map->edges[i].b;
    }
    plii_csr_sort(node_count, map->count, keys, begin, by_b);
    for (int i = 0; i < map->count; ++i) {
        keys[i] = map->edges[by_b[i]].a;
    }
    plii_csr_sort(node_count, map->count, keys, begin, order);
    for (int i = 0; i < map->count; ++i) {
        order[i] = by_b[order[i]];
    }
    return order;
}

void plii_edge_map_free(plii_edge_map* map) {
    PLII_RELEASE(map->table.context, map->edges, map->capacity);
    plii_key_table_free(&map->table);
    *map = (plii_edge_map){.table.context = map->table.context};
}
