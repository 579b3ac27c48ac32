#pragma once

/* A pair of a cluster and what it meets: what the step before knew of it, and its contacts as they are made. */

#include "cluster/cluster_near_nodes.h"

/* Smaller clusters lie beside others that share the load: nearest points and nodes will do. */
#define PLII_CLUSTER_CONTACTS_MIN_NODES 8

static inline bool plii_cluster_contacts_are_as_reference(const pli_body* body, const pli_cluster_contact* info) {
    return plii_body_clusters(body)->def.reference_mode && info->other != body;
}

/* A pair as its contacts are made. Its sides are looked up for the first of them: most pairs have none. */
typedef struct plii_pair_context {
    pli_body* body;
    plii_cluster_contacts *state, *other_state; /* the second of a pair of clusters */
    plii_joint_end sides[2];
    bool has_sides;
} plii_pair_context;

/* Measures the pair that `info` names, with what its cache knows, which may be NULL, and adds its contacts. terms[0] is
   that of the nearest points, terms[1] that of nodes and corners. */
typedef pli_status plii_measure_pair_fn(plii_pair_context* pair, pli_cluster_contact info,
                                        const plii_contact_terms terms[2], plii_convex_cache* cache);
/* Adds the contacts of a pair: of one that is followed as they are now, unless they have to be measured. */
pli_status plii_cluster_contacts_collide_pair(pli_body* body, plii_cluster_contacts* state,
                                              plii_cluster_contacts* other_state, const pli_cluster_contact* info,
                                              const plii_contact_terms terms[2], plii_measure_pair_fn* measure);

pli_status plii_cluster_contacts_add(plii_pair_context* pair, const pli_cluster_contact* info,
                                     const plii_contact_terms* terms);
/* Nodes from `first` on. */
pli_status plii_cluster_contacts_add_nodes(plii_pair_context* pair, pli_cluster_contact info,
                                           const plii_near_nodes* found, int first, const plii_contact_terms* terms);
