#pragma once

/* A pair of a cluster and what it meets: what the step before knew of it, and its contacts as they are made. */

#include "cluster/cluster_contacts_impl.h"

/* Of the nodes of a cluster within the margin of the other side, a few that lie far from each other. */

typedef struct plii_near_node {
    pli_vec3 point, normal; /* world; the normal towards the cluster */
    float distance;
} plii_near_node;

typedef struct plii_near_nodes {
    plii_near_node kept[PLII_CLUSTER_CONTACTS_PER_PAIR]; /* the first is the deepest */
    int count;
} plii_near_nodes;

/* Square of the distance from the nearest of those kept, which are all, but for one. */
static inline float plii_near_nodes_spread(const plii_near_nodes* nodes, pli_vec3 point, int except) {
    float least = INFINITY;
    for (int i = 0; i < PLII_CLUSTER_CONTACTS_PER_PAIR; ++i) {
        const float squared = pli_vec3_length_squared(pli_vec3_sub(nodes->kept[i].point, point));
        if (i != except) { least = plii_min(least, squared); }
    }
    return least;
}

static inline void plii_near_nodes_add(plii_near_nodes* nodes, plii_near_node node) {
    if (nodes->count > 0 && node.distance < nodes->kept[0].distance) {
        PLII_SWAP(plii_near_node, nodes->kept[0], node);
    }
    if (nodes->count < PLII_CLUSTER_CONTACTS_PER_PAIR) {
        nodes->kept[nodes->count++] = node;
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
    if (plii_near_nodes_spread(nodes, node.point, redundant) > least) { nodes->kept[redundant] = node; }
}

/* Unless it lies near the first. */
static inline void plii_near_nodes_add_beside(plii_near_nodes* nodes, plii_near_node node, float margin) {
    const float squared = pli_vec3_length_squared(pli_vec3_sub(node.point, nodes->kept[0].point));
    if (squared > margin * margin) { plii_near_nodes_add(nodes, node); }
}

/* The nearest points first, so that nodes at the same point are seen as such. */
static inline void plii_near_nodes_start(plii_near_nodes* nodes, const pli_cluster_contact* nearest) {
    nodes->count = 0;
    plii_near_nodes_add(nodes, (plii_near_node){nearest->witness, nearest->normal, nearest->distance});
}

/* Smaller clusters lie beside others that share the load: nearest points and nodes will do. */
#define PLII_CLUSTER_CONTACTS_MIN_NODES 8

static inline bool plii_cluster_contacts_are_as_reference(const pli_body* body, const pli_cluster_contact* info) {
    return body->clusters->def.reference_mode && info->other != body;
}

/* A pair as its contacts are made. Its sides are looked up for the first of them: most pairs have none. */
typedef struct plii_pair_context {
    pli_body* body;
    plii_cluster_contacts* state;
    plii_joint_end sides[2];
    bool has_sides;
} plii_pair_context;

static inline plii_pair_context plii_pair_context_of(pli_body* body, plii_cluster_contacts* state) {
    plii_pair_context pair; /* most pairs find nothing and have no sides: these are not set to zero */
    pair.body = body;
    pair.state = state;
    pair.has_sides = false;
    return pair;
}

/* Measures the pair that `info` names, with what its cache knows, which may be NULL, and adds its contacts. terms[0] is
   that of the nearest points, terms[1] that of nodes and corners. */
typedef void plii_measure_pair_fn(plii_pair_context* pair, pli_cluster_contact info, const plii_contact_terms terms[2],
                                  plii_convex_cache* cache);
/* Adds the contacts of a pair: of one that is followed as they are now, unless they have to be measured. */
void plii_cluster_contacts_collide_pair(pli_body* body, plii_cluster_contacts* state, const pli_cluster_contact* info,
                                        const plii_contact_terms terms[2], plii_measure_pair_fn* measure);

void plii_cluster_contacts_add(plii_pair_context* pair, const pli_cluster_contact* info,
                               const plii_contact_terms* terms);
/* Nodes from `first` on. */
void plii_cluster_contacts_add_nodes(plii_pair_context* pair, pli_cluster_contact info, const plii_near_nodes* found,
                                     int first, const plii_contact_terms* terms);
