/* Counting the parts of a body: disjoint sets of nodes that links, faces and tetrahedra join. */

#include "base/union_find.h"
#include "body/body_impl.h"
#include "pliant/cut.h"

static void parts_join(int* parents, const int* nodes, int count) {
    for (int k = 1; k < count; ++k) {
        plii_union_join(parents, nodes[0], nodes[k]);
    }
}

pli_status pli_body_count_parts(const pli_body* body, int* count) {
    PLII_TRY(plii_check_body(body, __func__));
    if (count == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "count is null"); }
    const plii_topology* topology = body->topology;
    int* parents = NULL;
    PLII_FAIL_IF(!PLII_ALLOCATE(body->context, &parents, body->node_count), body->context, PLI_ERROR_OUT_OF_MEMORY,
                 __func__, "no memory to count the parts of %d nodes", body->node_count);
    plii_union_start(body->node_count, parents);
    for (int i = 0; i < body->link_count; ++i) {
        parts_join(parents, body->links[i].nodes, 2);
    }
    for (int i = 0; i < topology->face_count; ++i) {
        parts_join(parents, topology->faces[i], 3);
    }
    for (int i = 0; i < topology->tetra_count; ++i) {
        parts_join(parents, topology->tetras[i], 4);
    }
    plii_union_flatten(body->node_count, parents);
    /* The second node of a part counts it; a loose node is alone. */
    int parts = 0;
    for (int i = 0; i < body->node_count; ++i) {
        const int root = parents[i];
        if (root != i && root != PLI_NULL_INDEX && parents[root] == root) {
            ++parts;
            parents[root] = PLI_NULL_INDEX;
        }
    }
    PLII_RELEASE(body->context, parents, body->node_count);
    *count = parts;
    return PLI_OK;
}
