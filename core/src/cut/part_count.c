/* Counting the parts of a body. */

#include "body/link_graph.h"
#include "pliant/cut.h"

pli_status pli_body_count_parts(const pli_body* body, int* count) {
    PLII_TRY(plii_check_body(body, __func__));
    if (count == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "count is null"); }
    int* parents = NULL;
    PLII_FAIL_IF(!PLII_ALLOCATE(body->context, &parents, body->node_count), body->context, PLI_ERROR_OUT_OF_MEMORY,
                 __func__, "no memory to count the parts of %d nodes", body->node_count);
    plii_body_find_parts(body, parents);
    /* The second node of a part counts it; a loose node is alone. */
    int parts = 0;
    for (int i = 0; i < body->node_count; ++i) {
        const int root = parents[i];
        if (root != i && parents[root] == root) {
            ++parts;
            parents[root] = PLI_NULL_INDEX;
        }
    }
    PLII_RELEASE(body->context, parents, body->node_count);
    *count = parts;
    return PLI_OK;
}
