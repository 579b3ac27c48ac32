/* The link graph of a body: neighbours in compressed rows, connected parts by union-find. Linear in nodes and links. */

#include "body/link_graph.h"

static void link_graph_build(pli_body* body, void* state) {
    plii_link_graph* graph = state;
    plii_csr_half_links(body->node_count, body->link_count, body->links, sizeof *body->links, graph->begin,
                        graph->halves);
    plii_union_start(body->node_count, graph->components);
    plii_parts_join(graph->components, body->links, sizeof *body->links, 2, body->link_count);
    plii_union_flatten(body->node_count, graph->components);
}

const plii_feature_class plii_link_graph_class = {
    .name = "link graph",
    .state_size = sizeof(plii_link_graph),
    .arrays = PLII_ARRAYS({PLII_MEMBER(plii_link_graph, begin), PLII_PER_NODE, .more = 1, .snapshot = PLII_LEFT},
                          {PLII_MEMBER(plii_link_graph, halves), PLII_PER_LINK, .times = 2, .snapshot = PLII_LEFT},
                          PLII_LEFT_PER_NODE(plii_link_graph, components)),
    .build = link_graph_build,
};
