#pragma once

/* Pairs of points that are near each other, in linear time: points are counted into the cells of an unbounded grid and
   laid out densely. The table of cells is the grid itself where that is small enough, so that neighbours are near in
   memory too; otherwise columns are hashed to it. Cells that differ in the last axis only lie side by side in the
   table, so the 27 cells around a point are 9 runs, and each pair is met from one of its ends: 5 runs. */

#include "base/context.h"
#include "math/vec.h"

typedef struct plii_spatial_hash_cell {
    int x, y, z;
} plii_spatial_hash_cell;

/* With the node or point that was searched around. */
typedef struct plii_node_pair {
    int other;
    float distance_squared;
} plii_node_pair;

typedef struct plii_spatial_hash {
    int count;
    pli_vec3 origin;
    float cell_size, inverse_cell_size;
    unsigned mask;                 /* table size - 1; a power of two minus 1 */
    unsigned strides[2];           /* of the first two axes in the table; 0 where columns are hashed */
    int* starts;                   /* [mask + 2] first entry of each bucket */
    plii_spatial_hash_cell* cells; /* [count] by node */
    /* By bucket, then by node; with room to read four from any entry. */
    int* nodes;        /* [count] */
    uint64_t* columns; /* [count] of the cell, where columns are hashed: others in a run of the table are not near */
    float* components; /* [3 * stride] of positions: x of all, y of all, z of all */
    int stride;
    int start_capacity, cell_capacity, node_capacity, column_capacity, component_capacity;
} plii_spatial_hash;

/* Of one node in one search: a body that has collapsed to a point must not ask for the square of its nodes. */
#define PLII_NODE_PAIRS_MAX_ROW 512
#define PLII_NODE_PAIRS_ROOM (PLII_NODE_PAIRS_MAX_ROW + 4) /* that a search of one node wants */

typedef struct plii_node_pairs {
    plii_node_pair* pairs;
    int count, capacity;
    bool is_truncated; /* some are missing */
} plii_node_pairs;

/* Whoever has a hash or pairs frees their arrays. Sorts points into cells of at least `cell_size` > 0 m; `shift` m
   moves the grid along all axes. Positions that are not finite do no harm. False when out of memory. */
bool plii_spatial_hash_build(pli_context* context, plii_spatial_hash* hash, int count, const pli_vec3* positions,
                             float cell_size, float shift);
/* Appends nodes nearer to node `node`, at `position`, than `radius`, at most the cell size: each pair is met from one
   of its ends only. The order depends on positions only. */
void plii_spatial_hash_find(pli_context* context, const plii_spatial_hash* hash, int node, pli_vec3 position,
                            float radius, plii_node_pairs* pairs);
/* Only those in the same cell. */
void plii_spatial_hash_find_in_cell(pli_context* context, const plii_spatial_hash* hash, int node, pli_vec3 position,
                                    float radius, plii_node_pairs* pairs);
/* Appends the nodes nearer to a point than `radius`. False with a radius above 16 cells. */
bool plii_spatial_hash_find_near(pli_context* context, const plii_spatial_hash* hash, pli_vec3 point, float radius,
                                 plii_node_pairs* pairs);
bool plii_spatial_hash_same_cell(const plii_spatial_hash* hash, pli_vec3 a, pli_vec3 b);
