/* Clusters of a body: adding and removing them, their settings, and what a user sees of them. */

#include "body/pipeline.h"
#include "cluster/cluster_impl.h"

PLII_DEFINE_DEFAULT(pli_clusters_def, .iterations = 4)
pli_status pli_body_enable_clusters(pli_body* body, const pli_clusters_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_SETTINGS(body, pli_clusters_def, used, def, plii_clusters_class);
    PLII_TRY_ENABLE(body, plii_clusters, clusters, plii_clusters_class);
    const bool has_other_masses = used.reference_mode != clusters->def.reference_mode;
    clusters->def = used;
    body->joint_iterations = used.iterations;
    if (has_other_masses) { plii_clusters_settle(body, clusters, 0); }
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_disable_clusters(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    if (body->clusters == NULL) { return PLI_OK; }
    PLII_TRY(pli_body_remove_clusters(body));
    plii_feature_disable(body, &plii_clusters_class);
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_remove_clusters(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    plii_clusters* clusters = body->clusters;
    if (clusters == NULL) { return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE, "clusters are not enabled"); }
    plii_features_notify(body->world, PLII_CLUSTERS_REMOVED, body); /* what holds to them goes with them */
    plii_clusters_release(body, clusters);
    body->pipeline.revision += 1;
    return plii_body_changed(body, PLI_OK);
}

pli_status plii_clusters_append(pli_body* body, plii_clusters* clusters, const int* nodes, int node_count) {
    pli_context* context = body->context;
    if (node_count > INT32_MAX - clusters->member_count ||
        !PLII_GROW(context, &clusters->items, &clusters->capacity, clusters->count) ||
        !PLII_RESERVE(context, &clusters->members, &clusters->member_capacity, clusters->member_count + node_count)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    body->world->needs_reserve = true;
    clusters->items[clusters->count++] =
        (plii_cluster){.settings = {.collides = true, .max_self_impulse = 100.0f, .self_impulse_factor = 1.0f},
                       .first_member = clusters->member_count,
                       .member_count = node_count};
    for (int i = 0; i < node_count; ++i) {
        clusters->members[clusters->member_count++] = (plii_cluster_member){.node = nodes[i]};
    }
    return PLI_OK;
}

static pli_status cluster_check_nodes(pli_body* body, const int* nodes, int node_count, const char* function) {
    pli_context* context = body->context;
    if (nodes == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "nodes is null"); }
    PLII_FAIL_IF(node_count < 1 || node_count > body->node_count, context, PLI_ERROR_INVALID_VALUE, function,
                 "%d nodes, the body has %d", node_count, body->node_count);
    uint8_t* is_named = plii_allocate(context, (size_t)body->node_count);
    if (is_named == NULL) { return plii_fail(context, PLI_ERROR_OUT_OF_MEMORY, function, "no memory for the check"); }
    pli_status status = PLI_OK;
    for (int i = 0; i < node_count && status == PLI_OK; ++i) {
        status = plii_check_node(body, nodes[i], function);
        if (status == PLI_OK && is_named[nodes[i]]++ != 0) {
            status = plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "node %d is named twice", nodes[i]);
        }
    }
    plii_release(context, is_named, (size_t)body->node_count);
    return status;
}

pli_status pli_body_add_cluster(pli_body* body, const int* nodes, int node_count, int* cluster) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(cluster_check_nodes(body, nodes, node_count, __func__));
    PLII_TRY_ENABLE(body, plii_clusters, clusters, plii_clusters_class);
    if (plii_clusters_append(body, clusters, nodes, node_count) != PLI_OK) {
        return PLII_FAIL_ENABLED(body, plii_clusters_class, __func__, "no memory for a cluster of %d nodes",
                                 node_count);
    }
    body->pipeline.revision += 1;
    plii_clusters_settle(body, clusters, clusters->count - 1);
    if (cluster != NULL) { *cluster = clusters->count - 1; }
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_reset_clusters(pli_body* body) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    plii_clusters* clusters = body->clusters;
    if (clusters == NULL) { return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE, "clusters are not enabled"); }
    plii_clusters_settle(body, clusters, 0);
    return plii_body_changed(body, PLI_OK);
}

pli_status plii_check_cluster(const pli_body* body, int cluster, const char* function) {
    PLII_TRY(plii_check_body(body, function));
    const plii_clusters* clusters = body->clusters;
    const int count = clusters != NULL ? clusters->count : 0;
    return plii_check_index(body->context, cluster, count, "cluster", "body", function);
}
PLII_DEFINE_STATE_GET(int, pli_body_cluster_count, plii_clusters, plii_clusters_class, state->count, 0)

pli_status pli_body_get_cluster_settings(const pli_body* body, int cluster, pli_cluster_settings* settings) {
    PLII_TRY(plii_check_cluster(body, cluster, __func__));
    if (settings == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "settings is null"); }
    *settings = body->clusters->items[cluster].settings;
    return PLI_OK;
}

const plii_field plii_cluster_settings_fields[] = {
    PLII_FIELD(pli_cluster_settings, matching, 0, 1),
    PLII_FIELD(pli_cluster_settings, node_damping, 0, 1),
    PLII_FIELD(pli_cluster_settings, linear_damping, 0, 1),
    PLII_FIELD(pli_cluster_settings, angular_damping, 0, 1),
    PLII_FIELD(pli_cluster_settings, max_self_impulse, 0, PLI_MAX_FORCE),
    PLII_FIELD(pli_cluster_settings, self_impulse_factor, 0, 1),
};

pli_status pli_body_set_cluster_settings(pli_body* body, int cluster, const pli_cluster_settings* settings) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(plii_check_cluster(body, cluster, __func__));
    if (settings == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "settings is null"); }
    PLII_TRY(PLII_CHECK_FIELDS(body->context, settings, plii_cluster_settings_fields, __func__));
    body->clusters->items[cluster].settings = *settings;
    return plii_body_changed(body, PLI_OK);
}

/* Members are records; the public view wants plain indices, which stand first in them. */
pli_status pli_body_get_cluster(const pli_body* body, int cluster, pli_cluster_view* view) {
    PLII_TRY(plii_check_cluster(body, cluster, __func__));
    if (view == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "view is null"); }
    /* Asking must not change the next step. */
    plii_cluster copy = body->clusters->items[cluster];
    plii_cluster_update_frame(body, &copy);
    const plii_cluster* item = &copy;
    *view = (pli_cluster_view){
        .node_count = item->member_count,
        .nodes = &plii_cluster_members(body, item)->node,
        .node_stride = (int)(sizeof(plii_cluster_member) / sizeof(int)),
        .frame = item->frame,
        .inverse_mass = item->inverse_mass,
        .inverse_inertia_world = item->inverse_inertia,
        .linear_velocity = plii_xyz(item->linear_velocity),
        .angular_velocity = plii_xyz(item->angular_velocity),
        .contains_pinned_node = item->contains_pinned_node,
    };
    return PLI_OK;
}
