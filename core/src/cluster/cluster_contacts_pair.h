#ifndef PLII_CLUSTER_CONTACTS_PAIR_H
#define PLII_CLUSTER_CONTACTS_PAIR_H

/* A pair of a cluster and what it meets: what the step before knew of it, and its contacts as they are made. Goes after
   "math/simd_float4.h". */

#include "cluster/cluster_near_nodes.h"

/* Smaller clusters lie beside others that share the load: nearest points and nodes will do. */
#define PLII_CLUSTER_CONTACTS_MIN_NODES 8

static inline bool plii_cluster_contacts_are_as_reference(const pli_body* body, const pli_cluster_contact* info) {
    return plii_body_clusters(body)->def.reference_mode && info->other != body;
}

/* What is known of a pair; `record` is NULL when nothing is to be kept, or when out of memory. */
typedef struct plii_cached_pair {
    plii_pair_record* record;
    bool is_followed;
} plii_cached_pair;

static inline plii_convex_cache* plii_cached_pair_cache(plii_cached_pair pair) {
    return pair.record != NULL ? &pair.record->cache : NULL;
}

plii_cached_pair plii_cluster_contacts_recall(pli_body* body, plii_cluster_contacts* state, plii_pair_key key);
/* Adds the contacts of a pair that is followed as they are now, or returns false when they have to be measured. */
bool plii_cluster_contacts_reuse(pli_body* body, plii_cluster_contacts* state, plii_cached_pair pair,
                                 const pli_cluster_contact* info, const plii_contact_terms terms[2], const void* key);
/* Keeps the contacts [first, state->count) of a pair that has been measured. Pairs that do not touch hold no slot. */
void plii_cluster_contacts_keep(pli_body* body, plii_cluster_contacts* state, plii_cached_pair pair, int first,
                                const void* key, float margin);

/* A pair as its contacts are made. Its sides are taken for the first of them: most pairs have none. */
typedef struct plii_pair_context {
    pli_body* body;
    plii_cluster_contacts* state;
    plii_joint_end sides[2];
    bool has_sides;
} plii_pair_context;

static inline void plii_pair_context_start(plii_pair_context* pair, pli_body* body, plii_cluster_contacts* state) {
    pair->body = body;
    pair->state = state;
    pair->has_sides = false;
}

pli_status plii_cluster_contacts_add(plii_pair_context* pair, const pli_cluster_contact* info,
                                     const plii_contact_terms* terms);
/* Nodes from `first` on. */
pli_status plii_cluster_contacts_add_nodes(plii_pair_context* pair, pli_cluster_contact info,
                                           const plii_near_nodes* found, int first, const plii_contact_terms* terms);

#endif
