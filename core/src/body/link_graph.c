/* The link graph of a body: neighbours in compressed rows, connected parts by union-find. Linear in nodes and links. */

#include "body/link_graph.h"

#include "base/csr.h"
#include "base/union_find.h"

static void link_graph_fill_rows(const pli_body* body, plii_link_graph* graph) {
    int* begin = graph->begin;
    for (int i = 0; i < body->link_count; ++i) {
        ++begin[body->links[i].nodes[0]];
        ++begin[body->links[i].nodes[1]];
    }
    (void)plii_csr_sum(body->node_count, begin);
    for (int i = body->link_count - 1; i >= 0; --i) {
        const int a = body->links[i].nodes[0], b = body->links[i].nodes[1];
        graph->halves[--begin[a]] = (plii_half_link){b, i};
        graph->halves[--begin[b]] = (plii_half_link){a, i};
    }
}

static void link_graph_fill(const pli_body* body, plii_link_graph* graph) {
    link_graph_fill_rows(body, graph);
    plii_union_start(body->node_count, graph->components);
    for (int i = 0; i < body->link_count; ++i) {
        plii_union_join(graph->components, body->links[i].nodes[0], body->links[i].nodes[1]);
    }
    plii_union_flatten(body->node_count, graph->components);
}

static pli_status link_graph_enable(pli_body* body, void* state) {
    link_graph_fill(body, state);
    return PLI_OK;
}

static void link_graph_topology_commit(pli_body* body, void* state, const plii_topology_change* change, void** blocks) {
    (void)change;
    (void)blocks;
    link_graph_fill(body, state);
}

static const plii_feature_array link_graph_arrays[] = {
    {PLII_MEMBER(plii_link_graph, begin), PLII_PER_NODE, .more = 1},
    {PLII_MEMBER(plii_link_graph, halves), PLII_PER_LINK, .times = 2},
    {PLII_MEMBER(plii_link_graph, components), PLII_PER_NODE},
    {0},
};

const plii_feature_class plii_link_graph_class = {
    .name = "link graph",
    .state_size = sizeof(plii_link_graph),
    .arrays = link_graph_arrays,
    .enable = link_graph_enable,
    .topology_commit = link_graph_topology_commit,
};
