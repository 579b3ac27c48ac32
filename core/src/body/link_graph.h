#pragma once

/* The service "link graph", links around nodes, made once per topology; and which nodes hang together. */

#include "base/csr.h"
#include "base/union_find.h"
#include "body/body_impl.h"

typedef struct plii_link_graph {
    int* begin;             /* [node_count + 1] first half link of each node */
    plii_half_link* halves; /* [2 * link_count], those of a node in the order of links */
    int* components;        /* [node_count] smallest node that links lead to; one per connected part */
} plii_link_graph;

static inline void plii_parts_join(int* parts, const void* elements, size_t size, int node_count, int count) {
    for (int i = 0; i < count; ++i) {
        const int* nodes = (const int*)((const char*)elements + (size_t)i * size);
        for (int k = 1; k < node_count; ++k) {
            plii_union_join(parts, nodes[0], nodes[k]);
        }
    }
}

/* The smallest node of the part of each: what links, faces and tetrahedra join. */
static inline void plii_body_find_parts(const pli_body* body, int* parts) {
    const plii_topology* topology = body->topology;
    plii_union_start(body->node_count, parts);
    plii_parts_join(parts, body->links, sizeof *body->links, 2, body->link_count);
    plii_parts_join(parts, topology->faces, sizeof *topology->faces, 3, topology->face_count);
    plii_parts_join(parts, topology->tetras, sizeof *topology->tetras, 4, topology->tetra_count);
    plii_union_flatten(body->node_count, parts);
}
