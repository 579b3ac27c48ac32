#pragma once

/* That cuts and tears leave meshes that are sound. */

#include "check.h"

#include <pliant/body.h>

#include <stdlib.h>

static inline int compare_pairs(const void* a, const void* b) {
    const int *x = a, *y = b;
    return x[0] != y[0] ? (x[0] < y[0] ? -1 : 1) : x[1] != y[1] ? (x[1] < y[1] ? -1 : 1) : 0;
}

/* Indices in range, no link or face with a node twice, no directed edge in two faces, and the faces round each node
   form one fan: as many boundary edges leave it as come in, at most one. */
static inline void check_manifold(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    const int edge_count = 3 * view.face_count;
    int(*edges)[2] = calloc((size_t)edge_count + 1, sizeof *edges);
    int* boundary = calloc((size_t)view.node_count, sizeof *boundary);
    assert_non_null(edges);
    assert_non_null(boundary);
    for (int i = 0; i < view.link_count; ++i) {
        const int* n = view.link_nodes + i * view.link_node_stride;
        assert_in_range(n[0], 0, view.node_count - 1);
        assert_in_range(n[1], 0, view.node_count - 1);
        assert_int_not_equal(n[0], n[1]);
    }
    for (int i = 0; i < edge_count; ++i) {
        edges[i][0] = view.face_nodes[i];
        edges[i][1] = view.face_nodes[i % 3 == 2 ? i - 2 : i + 1];
        assert_in_range(edges[i][0], 0, view.node_count - 1);
        assert_int_not_equal(edges[i][0], edges[i][1]);
    }
    qsort(edges, (size_t)edge_count, sizeof *edges, compare_pairs);
    for (int i = 0; i < edge_count; ++i) {
        if (i > 0) { assert_true(compare_pairs(edges[i - 1], edges[i]) < 0); }
        const int opposite[2] = {edges[i][1], edges[i][0]};
        if (bsearch(opposite, edges, (size_t)edge_count, sizeof *edges, compare_pairs) == NULL) {
            assert_int_equal(++boundary[edges[i][0]], 1);
        }
    }
    free(edges);
    free(boundary);
}
