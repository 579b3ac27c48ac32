/* Clusters against clusters, of another body or their own. A pair has the contact of its nearest points (CollideCL_SS),
   not in reference mode up to three more at far nodes of each side, so that flat sides rest on each other. */

#include "cluster/cluster_contacts_pair.h"
#include "math/bounds.h"

bool plii_cluster_contacts_reserve_search(pli_body* body, plii_cluster_contacts* state) {
    const int count = body->clusters->count;
    return PLII_RESERVE(body->context, &state->boxes, &state->box_capacity, count) &&
           PLII_RESERVE(body->context, &state->candidates, &state->candidate_capacity, PLII_BVH4_ROOM(count)) &&
           plii_bvh4_reserve(body->context, &state->tree, count);
}

static bool cluster_contacts_update_tree(pli_body* body, plii_cluster_contacts* state) {
    if (state->has_tree) { return true; }
    const plii_clusters* clusters = body->clusters;
    if (!plii_cluster_contacts_reserve_search(body, state)) { return false; }
    for (int i = 0; i < clusters->count; ++i) {
        const plii_cluster* cluster = &clusters->items[i];
        const pli_bounds nothing = {body->bounds.min, body->bounds.min};
        state->boxes[i] = cluster->settings.collides ? cluster->bounds : nothing;
    }
    state->has_tree = plii_bvh4_build(body->context, &state->tree, clusters->count, state->boxes, NULL);
    return state->has_tree;
}

/* Nodes of cluster `info->cluster` over the other one, near the plane of the nearest points; normal: to `body`. */
static void cluster_contacts_find_nodes_over(pli_body* body, const pli_cluster_contact* info, plii_cluster_hull other,
                                             float margin, plii_near_nodes* found) {
    const plii_cluster* item = &body->clusters->items[info->cluster];
    plii_near_nodes candidates;
    plii_near_nodes_start(&candidates, info);
    for (int i = 0; i < item->member_count; ++i) {
        const pli_vec3 x = plii_xyz(body->positions[plii_cluster_members(body, item)[i].node]);
        const float above = pli_vec3_dot(pli_vec3_sub(x, info->other_witness), info->normal);
        if (!(above < margin)) { continue; }
        plii_near_nodes_add_beside(&candidates, (plii_near_node){x, info->normal, above}, margin);
    }
    for (PLII_EACH(const plii_near_node, node, &candidates.kept[1], candidates.count - 1)) {
        if (plii_cluster_hull_is_near(node->point, &other, margin)) {
            plii_near_nodes_add_beside(found, *node, margin);
        }
    }
}

static void cluster_contacts_measure_pair(plii_pair_context* pair, pli_cluster_contact info,
                                          const plii_contact_terms terms[2], plii_convex_cache* cache) {
    pli_body* body = pair->body;
    plii_cluster_contacts* state = pair->state;
    if (!plii_cluster_contacts_measure_cluster(body, state, cache, terms->margin, &info)) { return; }
    plii_cluster_contacts_add(pair, &info, terms);
    pli_body* other = info.other;
    const plii_cluster* cluster = &body->clusters->items[info.cluster];
    const plii_cluster* other_cluster = &other->clusters->items[info.other_cluster];
    const bool is_small = cluster->member_count < PLII_CLUSTER_CONTACTS_MIN_NODES ||
                          other_cluster->member_count < PLII_CLUSTER_CONTACTS_MIN_NODES;
    if (is_small || plii_cluster_contacts_are_as_reference(body, &info) || state->def.distance != NULL) { return; }

    const pli_vec3 origin = cluster->frame.origin;
    plii_near_nodes found;
    plii_near_nodes_start(&found, &info);
    cluster_contacts_find_nodes_over(body, &info, plii_cluster_hull_of(other, info.other_cluster, origin),
                                     terms->margin, &found);
    plii_cluster_contacts_add_nodes(pair, info, &found, 1, terms);
    /* The same seen from the other side. */
    const pli_cluster_contact reverse = {.cluster = info.other_cluster,
                                         .witness = info.other_witness,
                                         .other_witness = info.witness,
                                         .normal = pli_vec3_neg(info.normal),
                                         .distance = info.distance};
    plii_near_nodes found_other;
    plii_near_nodes_start(&found_other, &reverse);
    cluster_contacts_find_nodes_over(other, &reverse, plii_cluster_hull_of(body, info.cluster, origin), terms->margin,
                                     &found_other);
    for (PLII_EACH(const plii_near_node, node, &found_other.kept[1], found_other.count - 1)) {
        pli_cluster_contact turned = info;
        turned.other_witness = node->point;
        turned.distance = node->distance;
        turned.witness = pli_vec3_add(node->point, pli_vec3_scale(info.normal, node->distance));
        plii_cluster_contacts_add(pair, &turned, terms);
    }
}

/* False when out of memory. */
static bool cluster_contacts_index_neighbours(pli_body* body, plii_cluster_contacts* state) {
    if (state->neighbours.count > 0 || state->neighbour_pair_count == 0) { return true; }
    state->neighbours.context = body->context;
    if (!plii_key_table_reserve(&state->neighbours, state->neighbour_pair_count)) { return false; }
    for (int i = 0; i < state->neighbour_pair_count; ++i) {
        const int* pair = state->neighbour_pairs[i];
        (void)plii_key_table_add(&state->neighbours, plii_edge_key(pair[0], pair[1]), i);
    }
    return true;
}

/* Pairs that share a node, or are within reach when first looked at, never meet: cloth would push itself apart. */
static bool cluster_contacts_find_neighbours(pli_body* body, plii_cluster_contacts* state) {
    const plii_clusters* clusters = body->clusters;
    const float margin = 2.0f * body->collision_margin;
    plii_key_table_free(&state->neighbours);
    const int known = state->clusters_with_neighbours, known_pairs = state->neighbour_pair_count;
    for (int i = 0; i < clusters->count; ++i) {
        const pli_bounds near = plii_bounds_grow(state->boxes[i], margin);
        state->candidate_count = plii_bvh4_overlaps(&state->tree, &near, 0, state->candidates); /* ascending */
        for (int k = 0; k < state->candidate_count; ++k) {
            const int other = state->candidates[k];
            if (other <= i || other < known) { continue; }
            const pli_vec3 origin = clusters->items[i].frame.origin;
            const plii_cluster_hull hull_a = plii_cluster_hull_of(body, i, origin);
            const plii_cluster_hull hull_b = plii_cluster_hull_of(body, other, origin);
            const plii_convex a = plii_cluster_hull_convex(&hull_a), b = plii_cluster_hull_convex(&hull_b);
            if (!plii_cluster_contacts_are_near(&a, &b, margin)) { continue; }
            if (!PLII_GROW(body->context, &state->neighbour_pairs, &state->neighbour_pair_capacity,
                           state->neighbour_pair_count)) {
                state->neighbour_pair_count = known_pairs;
                return false;
            }
            int* pair = state->neighbour_pairs[state->neighbour_pair_count++];
            pair[0] = i;
            pair[1] = other;
        }
    }
    state->clusters_with_neighbours = clusters->count;
    return true;
}

/* Of clusters near each other; of one body each pair once, but for neighbours. */
static void cluster_contacts_collide(pli_body* body, plii_cluster_contacts* state, pli_body* other,
                                     const plii_cluster_contacts* other_state, float reach) {
    const plii_contact_terms both = {
        .margin = body->collision_margin + other->collision_margin,
        .friction = plii_min(state->def.friction, other_state->def.friction),
        .hardness = plii_max(state->def.soft_hardness, other_state->def.soft_hardness),
        .split = (state->def.soft_split + other_state->def.soft_split) / 2.0f,
        /* The longer step, lest the body that has it goes too far. */
        .inverse_dt = plii_min(body->step.inverse_dt, other->step.inverse_dt),
    };
    const plii_contact_terms terms[2] = {both, both};
    const plii_clusters *clusters = body->clusters, *other_clusters = other->clusters;
    for (int i = 0; i < clusters->count; ++i) {
        if (!clusters->items[i].settings.collides) { continue; }
        const pli_bounds near = plii_bounds_grow(clusters->items[i].bounds, reach);
        state->candidate_count = plii_bvh4_overlaps(&other_state->tree, &near, 0, state->candidates);
        for (int k = 0; k < state->candidate_count; ++k) {
            const int candidate = state->candidates[k];
            if (!other_clusters->items[candidate].settings.collides) { continue; }
            if (body == other &&
                (candidate <= i ||
                 plii_key_table_find(&state->neighbours, plii_edge_key(i, candidate)) != PLI_NULL_INDEX)) {
                continue;
            }
            const pli_cluster_contact pair = {.cluster = i, .other = other, .other_cluster = candidate};
            plii_cluster_contacts_collide_pair(body, state, &pair, terms, cluster_contacts_measure_pair);
        }
    }
}

/* Bullet's stored boxes are searched as they are; otherwise the boxes must cover the reach of a contact. */
static float cluster_contacts_reach(const pli_body* body, const pli_body* other) {
    return body->clusters->def.reference_mode ? 0.0f : body->collision_margin + other->collision_margin;
}

/* Where a search may find clusters, whose bounds are from before others moved nodes in UPDATE. */
static pli_bounds cluster_contacts_near(const pli_body* body, float reach) {
    const plii_clusters* clusters = body->clusters;
    pli_bounds near = body->bounds;
    for (PLII_EACH(const plii_cluster, cluster, clusters->items, clusters->count)) {
        if (cluster->settings.collides) { near = plii_bounds_join(near, cluster->bounds); }
    }
    return plii_bounds_grow(near, reach);
}

void plii_cluster_contacts_prepare_pair(pli_body* body, void* data, pli_body* other, void* other_data) {
    plii_cluster_contacts *state = data, *other_state = other_data;
    if (!state->def.with_bodies || !other_state->def.with_bodies) { return; }
    (void)PLII_RESERVE(body->context, &state->candidates, &state->candidate_capacity,
                       PLII_BVH4_ROOM(other->clusters->count));
    (void)cluster_contacts_update_tree(other, other_state);
    const float reach = cluster_contacts_reach(body, other);
    plii_clusters_update_frames(body, cluster_contacts_near(other, reach));
    plii_clusters_update_frames(other, cluster_contacts_near(body, reach));
}

void plii_cluster_contacts_collide_body(pli_body* body, void* data, pli_body* other, void* other_data) {
    plii_cluster_contacts *state = data, *other_state = other_data;
    if (!state->def.with_bodies || !other_state->def.with_bodies) { return; }
    const bool is_prepared =
        other_state->has_tree && state->candidate_capacity >= PLII_BVH4_ROOM(other->clusters->count);
    if (!is_prepared) { return; }
    cluster_contacts_collide(body, state, other, other_state, cluster_contacts_reach(body, other));
}

void plii_cluster_contacts_collide_self(pli_body* body, plii_cluster_contacts* state) {
    if (!cluster_contacts_update_tree(body, state) ||
        (state->clusters_with_neighbours < body->clusters->count && !cluster_contacts_find_neighbours(body, state)) ||
        !cluster_contacts_index_neighbours(body, state)) {
        return;
    }
    plii_clusters_update_frames(body, body->bounds);
    cluster_contacts_collide(body, state, body, state, 2.0f * body->collision_margin);
}
