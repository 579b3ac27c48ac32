#pragma once

/* Lists of items by key, compressed: those of key k are items[begin[k]] to items[begin[k + 1] - 1]. To make them, count
   the items of each key in `begin` [key_count + 1], which starts as zeros, sum up, and put the items in place from the
   last one to the first; then each list is in the order of items:

       ++begin[key];
       plii_csr_sum(key_count, begin);
       items[--begin[key]] = item; */

#include <string.h>

/* Turns counts into where each list ends. */
static inline void plii_csr_sum(int key_count, int* begin) {
    int sum = 0;
    for (int k = 0; k < key_count; ++k) {
        sum += begin[k];
        begin[k] = sum;
    }
    begin[key_count] = sum;
}

/* A link as one of its nodes sees it. */
typedef struct plii_half_link {
    int neighbour, link;
} plii_half_link;

/* The half links [2 * link_count] of each node; links are structs that begin with their nodes. `begin` is zeroed. */
static inline void plii_csr_half_links(int node_count, int link_count, const void* links, size_t link_size, int* begin,
                                       plii_half_link* halves) {
    for (int i = 0; i < link_count; ++i) {
        const int* nodes = (const int*)((const char*)links + (size_t)i * link_size);
        ++begin[nodes[0]];
        ++begin[nodes[1]];
    }
    plii_csr_sum(node_count, begin);
    for (int i = link_count - 1; i >= 0; --i) {
        const int* nodes = (const int*)((const char*)links + (size_t)i * link_size);
        halves[--begin[nodes[0]]] = (plii_half_link){nodes[1], i};
        halves[--begin[nodes[1]]] = (plii_half_link){nodes[0], i};
    }
}

/* Indices of keys [item_count] by key. `begin` need not be zero. */
static inline void plii_csr_sort(int key_count, int item_count, const int* keys, int* begin, int* items) {
    memset(begin, 0, ((size_t)key_count + 1) * sizeof *begin);
    for (int i = 0; i < item_count; ++i) {
        ++begin[keys[i]];
    }
    plii_csr_sum(key_count, begin);
    for (int i = item_count - 1; i >= 0; --i) {
        items[--begin[keys[i]]] = i;
    }
}

/* Corners [3 * face_count] by the smaller node of the edge from each to the next one of its face; `keys`: as many. */
static inline void plii_csr_sort_edges(int node_count, int face_count, const int (*faces)[3], int* keys, int* begin,
                                       int* corners) {
    for (int c = 0; c < 3 * face_count; ++c) {
        const int a = faces[c / 3][c % 3], b = faces[c / 3][(c + 1) % 3];
        keys[c] = a < b ? a : b;
    }
    plii_csr_sort(node_count, 3 * face_count, keys, begin, corners);
}

/* Of items of `size` bytes ordered by an unsigned at `offset`: the first not below `key`; PLI_NULL_INDEX is last. */
static inline int plii_csr_first(const void* items, size_t size, size_t offset, int count, int key) {
    int begin = 0, end = count;
    while (begin < end) {
        const int middle = begin + (end - begin) / 2;
        if (*(const unsigned*)((const char*)items + (size_t)middle * size + offset) < (unsigned)key) {
            begin = middle + 1;
        } else {
            end = middle;
        }
    }
    return begin;
}
