#pragma once

/* Service: the links around each node, and which nodes hang together. Made once per topology. */

#include "base/csr.h"
#include "body/body_impl.h"

typedef struct plii_link_graph {
    int* begin;             /* [node_count + 1] first half link of each node */
    plii_half_link* halves; /* [2 * link_count], those of a node in the order of links */
    int* components;        /* [node_count] smallest node that links lead to; one per connected part */
} plii_link_graph;

/* Its state is a plii_link_graph. */
extern const plii_feature_class plii_link_graph_class;
