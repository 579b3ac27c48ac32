/* The link graph of a body: neighbours in compressed rows, connected parts by union-find. Linear in nodes and links. */

#include "body/link_graph.h"

static void link_graph_fill_rows(const pli_body* body, plii_link_graph* graph) {
    int* begin = graph->begin;
    for (int i = 0; i < body->link_count; ++i) {
        ++begin[body->links[i].nodes[0]];
        ++begin[body->links[i].nodes[1]];
    }
    int sum = 0;
    for (int i = 0; i < body->node_count; ++i) {
        sum += begin[i];
        begin[i] = sum;
    }
    begin[body->node_count] = sum;
    /* Backwards, so that each row ends up in the order of links. */
    for (int i = body->link_count - 1; i >= 0; --i) {
        const int a = body->links[i].nodes[0], b = body->links[i].nodes[1];
        graph->halves[--begin[a]] = (plii_half_link){b, i};
        graph->halves[--begin[b]] = (plii_half_link){a, i};
    }
}

static int link_graph_root(int* parents, int node) {
    while (parents[node] != node) {
        parents[node] = parents[parents[node]];
        node = parents[node];
    }
    return node;
}

static void link_graph_fill_components(const pli_body* body, int* components) {
    for (int i = 0; i < body->node_count; ++i) {
        components[i] = i;
    }
    for (int i = 0; i < body->link_count; ++i) {
        const int a = link_graph_root(components, body->links[i].nodes[0]);
        const int b = link_graph_root(components, body->links[i].nodes[1]);
        components[a > b ? a : b] = a < b ? a : b;
    }
    for (int i = 0; i < body->node_count; ++i) {
        components[i] = link_graph_root(components, i);
    }
}

static void link_graph_fill(const pli_body* body, plii_link_graph* graph) {
    link_graph_fill_rows(body, graph);
    link_graph_fill_components(body, graph->components);
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
