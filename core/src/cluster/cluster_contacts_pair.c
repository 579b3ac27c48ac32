/* What is known of pairs from step to step, and the contacts that they get. */

#include "cluster/cluster_contacts_pair.h"

/* A slot for a pair that is new; 0 when out of memory. */
static int cluster_contacts_alloc_manifold(pli_body* body, plii_cluster_contacts* state) {
    const int slot = state->free_manifold1;
    if (slot > 0) {
        state->free_manifold1 = state->manifolds[slot - 1].age;
        return slot;
    }
    if (!PLII_RESERVE(body->context, &state->manifolds, &state->manifold_capacity, state->manifold_count + 1)) {
        return 0;
    }
    return ++state->manifold_count;
}

static void cluster_contacts_free_manifold(plii_cluster_contacts* state, int slot) {
    state->manifolds[slot - 1].age = state->free_manifold1;
    state->free_manifold1 = slot;
}

/* The record of a pair, with the slot that it had; NULL when nothing is to be kept, or when out of memory. */
static plii_pair_record* cluster_contacts_recall(pli_body* body, plii_cluster_contacts* state, plii_pair_key key,
                                                 bool is_followed) {
    if (state->def.distance != NULL || plii_pair_cache_get(body->context, &state->memory, key) == NULL) { return NULL; }
    plii_pair_record* record = &state->memory.present[state->memory.present_count - 1];
    if (is_followed && record->previous_index != PLI_NULL_INDEX) {
        int* before = &state->memory.before[record->previous_index].slot;
        record->slot = *before;
        *before = 0;
    }
    return record;
}

/* Keeps the contacts [first, state->count) of a pair that has been measured. Pairs that do not touch hold no slot. */
static void cluster_contacts_keep(pli_body* body, plii_cluster_contacts* state, plii_pair_record* record, int first,
                                  const void* shape, float margin) {
    const int count = state->count - first;
    if (count == 0 || count > PLII_MANIFOLD_POINTS) {
        if (record->slot > 0) { cluster_contacts_free_manifold(state, record->slot); }
        record->slot = 0;
        return;
    }
    if (record->slot == 0) { record->slot = cluster_contacts_alloc_manifold(body, state); }
    if (record->slot == 0) { return; }
    plii_cluster_manifold_keep(body, state, first, shape, margin, &state->manifolds[record->slot - 1]);
}

pli_status plii_cluster_contacts_collide_pair(pli_body* body, plii_cluster_contacts* state,
                                              const pli_cluster_contact* info, const plii_contact_terms terms[2],
                                              plii_measure_pair_fn* measure) {
    const bool has_rigid = info->rigid != NULL;
    const pli_shape* shape = has_rigid ? info->rigid->shapes[info->shape] : NULL;
    /* Clusters of one body deform against each other too much for their contacts to be followed. */
    const bool is_followed =
        !plii_body_clusters(body)->def.reference_mode && !state->def.disable_contact_cache && info->other != body;
    const plii_pair_key key = {info->cluster, has_rigid ? info->shape : info->other_cluster,
                               has_rigid ? (const void*)info->rigid : (const void*)info->other, 0};
    plii_pair_record* record = cluster_contacts_recall(body, state, key, is_followed);
    if (is_followed && record != NULL && record->slot > 0 &&
        PLII_RESERVE(body->context, &state->contacts, &state->capacity, state->count + PLII_MANIFOLD_POINTS) &&
        plii_cluster_manifold_update(body, info, terms, shape, &state->manifolds[record->slot - 1], state)) {
        return PLI_OK;
    }
    plii_pair_context pair = {.body = body, .state = state};
    const int first = state->count;
    PLII_TRY(measure(&pair, *info, terms, record != NULL ? &record->cache : NULL));
    if (is_followed && record != NULL) { cluster_contacts_keep(body, state, record, first, shape, terms[0].margin); }
    return PLI_OK;
}

void plii_cluster_contacts_begin_step(pli_body* body, plii_cluster_contacts* state) {
    for (int i = 0; i < state->memory.before_count; ++i) {
        const int slot = state->memory.before[i].slot;
        if (slot > 0) { cluster_contacts_free_manifold(state, slot); }
    }
    /* Without memory pairs start anew; the contacts are the same up to rounding. */
    if (!plii_pair_cache_begin_step(body->context, &state->memory)) { plii_cluster_contacts_clear(state); }
}

void plii_cluster_contacts_clear(plii_cluster_contacts* state) {
    plii_pair_cache_clear(&state->memory);
    state->manifold_count = state->free_manifold1 = 0;
}

pli_status plii_cluster_contacts_add(plii_pair_context* pair, const pli_cluster_contact* info,
                                     const plii_contact_terms* terms) {
    pli_body* body = pair->body;
    plii_cluster_contacts* state = pair->state;
    const bool reference_mode = plii_cluster_contacts_are_as_reference(body, info);
    if (!PLII_RESERVE(body->context, &state->contacts, &state->capacity, state->count + 1)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    if (!pair->has_sides) {
        pair->sides[0] = plii_joint_end_of_cluster(body, info->cluster);
        pair->sides[1] = info->other != NULL ? plii_joint_end_of_cluster(info->other, info->other_cluster)
                                             : plii_joint_end_of_rigid(info->rigid);
        pair->has_sides = true;
    }
    plii_cluster_contact* contact = &state->contacts[state->count];
    if (plii_cluster_contact_make(info, pair->sides, terms, reference_mode, contact)) {
        contact->is_self = info->other == body;
        state->count += 1;
    }
    return PLI_OK;
}

pli_status plii_cluster_contacts_add_nodes(plii_pair_context* pair, pli_cluster_contact info,
                                           const plii_near_nodes* found, int first, const plii_contact_terms* terms) {
    for (int i = first; i < found->count; ++i) {
        const plii_near_node* node = &found->kept[i];
        info.witness = node->point;
        info.other_witness = pli_vec3_sub(node->point, pli_vec3_scale(node->normal, node->distance));
        info.normal = node->normal;
        info.distance = node->distance;
        PLII_TRY(plii_cluster_contacts_add(pair, &info, terms));
    }
    return PLI_OK;
}
