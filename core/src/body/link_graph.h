#pragma once

/* The state of the service "link graph": links around nodes, and which nodes hang together. Made once per topology. */

#include "base/csr.h"
#include "body/body_impl.h"

typedef struct plii_link_graph {
    int* begin;             /* [node_count + 1] first half link of each node */
    plii_half_link* halves; /* [2 * link_count], those of a node in the order of links */
    int* components;        /* [node_count] smallest node that links lead to; one per connected part */
} plii_link_graph;
