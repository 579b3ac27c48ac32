/* Memory of searches on several threads. */

#include "self_collision/self_node_pairs.h"

void plii_self_node_pairs_release(pli_context* context, plii_self_node_pairs* state) {
    for (int i = 0; i < PLII_SELF_SEARCH_PARTS; ++i) {
        plii_self_search_part* part = &state->parts[i];
        PLII_RELEASE(context, part->search.near.pairs, part->search.near.capacity);
        PLII_RELEASE(context, part->search.linked, state->part_node_count);
        PLII_RELEASE(context, part->found.items, part->found.capacity);
        *part = (plii_self_search_part){0};
    }
    state->part_node_count = 0;
}

size_t plii_self_node_pairs_bytes(const plii_self_node_pairs* state) {
    size_t bytes = 0;
    for (int i = 0; i < PLII_SELF_SEARCH_PARTS; ++i) {
        const plii_self_search_part* part = &state->parts[i];
        bytes += (size_t)part->search.near.capacity * sizeof *part->search.near.pairs +
                 (part->search.linked != NULL ? (size_t)state->part_node_count * sizeof *part->search.linked : 0) +
                 (size_t)part->found.capacity * sizeof *part->found.items;
    }
    return bytes;
}

bool plii_self_node_pairs_reserve(const pli_body* body, plii_self_node_pairs* state, plii_blocks blocks) {
    pli_context* context = body->context;
    if (state->part_node_count != body->node_count) { plii_self_node_pairs_release(context, state); }
    state->part_node_count = body->node_count;
    for (int b = 0; b < blocks.count; ++b) {
        plii_self_search_part* part = &state->parts[b];
        const bool is_marked = part->search.linked != NULL;
        if ((!is_marked && !PLII_ALLOCATE(context, &part->search.linked, body->node_count)) ||
            !PLII_RESERVE(context, &part->search.near.pairs, &part->search.near.capacity, PLII_NODE_PAIRS_ROOM) ||
            !PLII_RESERVE(context, &part->found.items, &part->found.capacity, PLII_SELF_PAIRS_PER_NODE * blocks.size)) {
            return false;
        }
    }
    return true;
}
