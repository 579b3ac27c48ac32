#pragma once

/* Of the nodes of a cluster within the margin of the other side, a few that lie far from each other. Goes after
   "math/simd_float4.h". */

#include "cluster/cluster_contacts_impl.h"

typedef struct plii_near_node {
    pli_vec3 point, normal; /* world; the normal towards the cluster */
    float distance;
} plii_near_node;

typedef struct plii_near_nodes {
    plii_near_node kept[PLII_CLUSTER_CONTACTS_PER_PAIR]; /* the first is the deepest */
    plii_group_vec3 points;                              /* of these; infinitely far where there is none */
    int count;
} plii_near_nodes;

static inline void plii_near_nodes_start_empty(plii_near_nodes* nodes) {
    const pli_vec3 nowhere = pli_vec3_make(INFINITY, INFINITY, INFINITY);
    nodes->count = 0;
    for (int i = 0; i < PLII_CLUSTER_CONTACTS_PER_PAIR; ++i) {
        plii_group_vec3_set(&nodes->points, i, nowhere);
    }
}

static inline void plii_near_nodes_set(plii_near_nodes* nodes, int index, const plii_near_node* node) {
    nodes->kept[index] = *node;
    plii_group_vec3_set(&nodes->points, index, node->point);
}

/* Square of the distance from the nearest of those kept, but for one. */
static inline float plii_near_nodes_spread(const plii_near_nodes* nodes, pli_vec3 point, int except) {
    static const float excepted[PLII_CLUSTER_CONTACTS_PER_PAIR][PLII_CLUSTER_CONTACTS_PER_PAIR] = {
        {INFINITY, 0, 0, 0}, {0, INFINITY, 0, 0}, {0, 0, INFINITY, 0}, {0, 0, 0, INFINITY}};
    const plii_vec3x4 offsets = plii_vec3x4_sub(plii_group_vec3_load(&nodes->points), plii_vec3x4_all(point));
    return plii_lanes_least(plii_lanes_max(plii_vec3x4_dot(offsets, offsets), plii_float4_load(excepted[except])));
}

static inline void plii_near_nodes_add(plii_near_nodes* nodes, plii_near_node node) {
    if (nodes->count > 0 && node.distance < nodes->kept[0].distance) {
        const plii_near_node deepest = nodes->kept[0];
        plii_near_nodes_set(nodes, 0, &node);
        node = deepest;
    }
    if (nodes->count < PLII_CLUSTER_CONTACTS_PER_PAIR) {
        plii_near_nodes_set(nodes, nodes->count++, &node);
        return;
    }
    /* Other than the deepest, the one that lies closest to the rest. */
    int redundant = 1;
    float least = plii_near_nodes_spread(nodes, nodes->kept[1].point, 1);
    for (int i = 2; i < nodes->count; ++i) {
        const float spread = plii_near_nodes_spread(nodes, nodes->kept[i].point, i);
        redundant = spread < least ? i : redundant;
        least = plii_min(spread, least);
    }
    if (plii_near_nodes_spread(nodes, node.point, redundant) > least) { plii_near_nodes_set(nodes, redundant, &node); }
}

/* Unless it lies near the first. */
static inline void plii_near_nodes_add_beside(plii_near_nodes* nodes, plii_near_node node, float margin) {
    const float squared = pli_vec3_length_squared(pli_vec3_sub(node.point, nodes->kept[0].point));
    if (squared > margin * margin) { plii_near_nodes_add(nodes, node); }
}

/* The nearest points first, so that nodes at the same point are seen as such. */
static inline void plii_near_nodes_start(plii_near_nodes* nodes, const pli_cluster_contact* nearest) {
    plii_near_nodes_start_empty(nodes);
    plii_near_nodes_add(nodes, (plii_near_node){nearest->witness, nearest->normal, nearest->distance});
}
