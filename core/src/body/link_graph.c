/* The link graph of a body: neighbours in compressed rows, connected parts by union-find. Linear in nodes and links. */

#include "body/link_graph.h"

static size_t link_graph_begin_size(int node_count) {
    return ((size_t)node_count + 1) * sizeof(int);
}
static size_t link_graph_halves_size(int link_count) {
    return 2 * (size_t)link_count * sizeof(plii_half_link);
}
static size_t link_graph_components_size(int node_count) {
    return (size_t)node_count * sizeof(int);
}

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

static void link_graph_release(pli_body* body, plii_link_graph* graph, int node_count, int link_count) {
    plii_release(body->context, graph->begin, link_graph_begin_size(node_count));
    plii_release(body->context, graph->halves, link_graph_halves_size(link_count));
    plii_release(body->context, graph->components, link_graph_components_size(node_count));
    *graph = (plii_link_graph){0};
}

static pli_status link_graph_enable(pli_body* body, void* state) {
    plii_link_graph* graph = state;
    graph->begin = plii_allocate(body->context, link_graph_begin_size(body->node_count));
    graph->halves = plii_allocate(body->context, link_graph_halves_size(body->link_count));
    graph->components = plii_allocate(body->context, link_graph_components_size(body->node_count));
    if (graph->begin == NULL || (graph->halves == NULL && body->link_count > 0) || graph->components == NULL) {
        link_graph_release(body, graph, body->node_count, body->link_count);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    link_graph_fill(body, graph);
    return PLI_OK;
}

static void link_graph_disable(pli_body* body, void* state) {
    link_graph_release(body, state, body->node_count, body->link_count);
}

static size_t link_graph_bytes(const pli_body* body, const void* state) {
    (void)state;
    return link_graph_begin_size(body->node_count) + link_graph_halves_size(body->link_count) +
           link_graph_components_size(body->node_count);
}

static int link_graph_topology_blocks(const pli_body* body, const void* state, const plii_topology_change* change,
                                      size_t* sizes) {
    (void)body;
    (void)state;
    sizes[0] = link_graph_begin_size(change->node_count);
    sizes[1] = link_graph_halves_size(change->link_count);
    sizes[2] = link_graph_components_size(change->node_count);
    return 3;
}

static void link_graph_topology_commit(pli_body* body, void* state, const plii_topology_change* change, void** blocks) {
    plii_link_graph* graph = state;
    link_graph_release(body, graph, change->old_node_count, change->old_link_count);
    graph->begin = blocks[0];
    graph->halves = blocks[1];
    graph->components = blocks[2];
    link_graph_fill(body, graph);
}

const plii_feature_class plii_link_graph_class = {
    .name = "link graph",
    .state_size = sizeof(plii_link_graph),
    .enable = link_graph_enable,
    .disable = link_graph_disable,
    .bytes = link_graph_bytes,
    .topology_blocks = link_graph_topology_blocks,
    .topology_commit = link_graph_topology_commit,
};
