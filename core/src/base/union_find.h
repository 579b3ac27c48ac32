#pragma once

/* Disjoint sets of indices, as a forest of parents. The root is the smallest index, whatever the order of joins. */

static inline void plii_union_start(int count, int* parents) {
    for (int i = 0; i < count; ++i) {
        parents[i] = i;
    }
}
static inline int plii_union_root(int* parents, int i) {
    while (parents[i] != i) {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    return i;
}
static inline void plii_union_join(int* parents, int i, int k) {
    const int a = plii_union_root(parents, i), b = plii_union_root(parents, k);
    parents[a > b ? a : b] = a < b ? a : b;
}
/* Every parent becomes the root. */
static inline void plii_union_flatten(int count, int* parents) {
    for (int i = 0; i < count; ++i) {
        parents[i] = plii_union_root(parents, i);
    }
}
