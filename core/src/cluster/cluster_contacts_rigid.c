/* Clusters against rigid bodies. A pair has the contact of its nearest points, which is all there is in reference mode
   (CollideCL_RS); otherwise up to three more at nodes and corners far from it, so that flat sides rest on each other.
   Shapes that are not convex are met node by node. */

#include "cluster/cluster_contacts_pair.h"
#include "math/bounds.h"
#include "shape/shape_impl.h"

#define CLUSTER_CONTACTS_BATCH 64
#define CLUSTER_CONTACTS_TILT 0.1f /* of the directions in which corners are looked for */

static plii_contact_terms cluster_contacts_rigid_terms(const pli_body* body, const plii_cluster_contacts* state,
                                                       const pli_rigid* rigid, float radius) {
    const bool is_dynamic = rigid->kind == PLI_RIGID_DYNAMIC;
    return (plii_contact_terms){radius + body->collision_margin,
                                radius,
                                plii_min(state->def.friction, rigid->friction),
                                is_dynamic ? state->def.dynamic_hardness : state->def.static_hardness,
                                is_dynamic ? state->def.dynamic_split : state->def.static_split,
                                body->step.inverse_dt,
                                state->rigid_velocity};
}

/* Adds nodes within the margin of the shape's surface, but for those near the first; `nodes`: what was measured. */
static void cluster_contacts_find_near_nodes(const pli_body* body, const plii_cluster_contacts* state,
                                             const pli_cluster_contact* info, plii_measured_nodes* nodes,
                                             plii_near_nodes* found) {
    const plii_cluster* item = &body->clusters->items[info->cluster];
    const plii_cluster_member* members = plii_cluster_members(body, item);
    const float margin = body->collision_margin;
    for (int first = 0; first < item->member_count; first += nodes->count) {
        if (nodes->count == 0 || first > 0) { plii_cluster_contacts_measure_nodes(body, state, info, first, nodes); }
        for (int i = 0; i < nodes->count; ++i) {
            if (!(nodes->distances[i] < margin) || !plii_vec3_is_finite(nodes->normals[i])) { continue; }
            const plii_near_node node = {plii_xyz(body->positions[members[first + i].node]),
                                         pli_mat3_mul_vec3(state->shape_pose.rotation, nodes->normals[i]),
                                         nodes->distances[i]};
            plii_near_nodes_add_beside(found, node, margin);
        }
    }
}

/* Corners of the core over the cluster, near the plane of nearest points: farthest a little off the normal. */
static void cluster_contacts_find_near_corners(const pli_shape* shape, pli_transform pose,
                                               const pli_cluster_contact* info, plii_cluster_hull hull, float margin,
                                               plii_near_nodes* found) {
    const float radius = shape->def.radius;
    const pli_vec3 n = info->normal;
    const pli_vec3 u = plii_vec3_perpendicular(n), v = pli_vec3_cross(n, u);
    for (int i = 0; i < 4; ++i) {
        const pli_vec3 tilt =
            pli_vec3_scale(i % 2 == 0 ? u : v, i < 2 ? CLUSTER_CONTACTS_TILT : -CLUSTER_CONTACTS_TILT);
        const pli_vec3 corner =
            plii_cluster_contacts_rigid_point(shape, pose, plii_vec3_safe_normalize(pli_vec3_add(n, tilt)));
        const float above = pli_vec3_dot(pli_vec3_sub(info->witness, corner), n);
        if (!(above < margin + radius) || !plii_cluster_hull_is_near(corner, &hull, margin + radius)) { continue; }
        const plii_near_node node = {pli_vec3_add(corner, pli_vec3_scale(n, above)), n, above - radius};
        plii_near_nodes_add_beside(found, node, margin);
    }
}

static void cluster_contacts_measure_convex(plii_pair_context* pair, pli_cluster_contact info,
                                            const plii_contact_terms terms[2], plii_convex_cache* cache) {
    pli_body* body = pair->body;
    plii_cluster_contacts* state = pair->state;
    const pli_shape* shape = info.rigid->shapes[info.shape];
    plii_measured_nodes nodes;
    nodes.count = 0;
    if (!plii_cluster_contacts_measure_rigid(body, state, cache, terms[0].margin, &info, &nodes)) { return; }
    plii_cluster_contacts_add(pair, &info, terms);
    if (plii_cluster_contacts_are_as_reference(body, &info) || state->def.distance != NULL) { return; }
    plii_near_nodes found;
    plii_near_nodes_start(&found, &info);
    cluster_contacts_find_near_nodes(body, state, &info, &nodes, &found);
    const plii_cluster* cluster = &body->clusters->items[info.cluster];
    if (cluster->member_count >= PLII_CLUSTER_CONTACTS_MIN_NODES) {
        const plii_cluster_hull hull = plii_cluster_hull_of(body, info.cluster, cluster->frame.origin);
        cluster_contacts_find_near_corners(shape, state->shape_pose, &info, hull, body->collision_margin, &found);
    }
    plii_cluster_contacts_add_nodes(pair, info, &found, 1, &terms[1]);
}

static void cluster_contacts_collide_convex(pli_body* body, plii_cluster_contacts* state,
                                            const pli_cluster_contact* pair) {
    const pli_shape* shape = pair->rigid->shapes[pair->shape];
    const plii_contact_terms terms[2] = {cluster_contacts_rigid_terms(body, state, pair->rigid, shape->def.radius),
                                         cluster_contacts_rigid_terms(body, state, pair->rigid, 0.0f)};
    plii_cluster_contacts_collide_pair(body, state, pair, terms, cluster_contacts_measure_convex);
}

/* Clusters share nodes: those near a shape are measured first, once. `near` shrinks to those within the margin. False
   when out of memory. */
static bool cluster_contacts_measure_nodes(pli_body* body, plii_cluster_contacts* state, const pli_shape* shape,
                                           pli_bounds* near) {
    if (!PLII_RESERVE(body->context, &state->surface, &state->surface_capacity, body->node_count)) { return false; }
    const pli_transform pose = state->shape_pose;
    const float margin = body->collision_margin;
    pli_bounds found = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    int node = 0;
    while (node < body->node_count) {
        int nodes[CLUSTER_CONTACTS_BATCH], count = 0;
        pli_vec3 points[CLUSTER_CONTACTS_BATCH], normals[CLUSTER_CONTACTS_BATCH];
        float distances[CLUSTER_CONTACTS_BATCH];
        for (; node < body->node_count && count < CLUSTER_CONTACTS_BATCH; ++node) {
            const pli_vec3 x = plii_xyz(body->positions[node]);
            state->surface[node].distance = INFINITY;
            if (!plii_bounds_overlap(*near, (pli_bounds){x, x})) { continue; }
            nodes[count] = node;
            points[count++] = pli_transform_inverse_point(pose, x);
        }
        if (count == 0) { continue; }
        shape->def.distances(shape->def.user, count, points, margin, distances, normals);
        for (int i = 0; i < count; ++i) {
            if (!(distances[i] < margin) || !plii_vec3_is_finite(normals[i])) { continue; }
            const pli_vec3 normal = pli_mat3_mul_vec3(pose.rotation, normals[i]);
            state->surface[nodes[i]] = (plii_nearest_surface_point){distances[i], normal};
            found = plii_bounds_add(found, plii_xyz(body->positions[nodes[i]]));
        }
    }
    *near = found;
    return true;
}

static void cluster_contacts_collide_concave(pli_body* body, plii_cluster_contacts* state,
                                             const pli_cluster_contact* pair) {
    const plii_cluster* cluster = &body->clusters->items[pair->cluster];
    plii_near_nodes found;
    found.count = 0;
    for (int i = 0; i < cluster->member_count; ++i) {
        const int node = plii_cluster_members(body, cluster)[i].node;
        const plii_nearest_surface_point* surface = &state->surface[node];
        if (!(surface->distance < body->collision_margin)) { continue; }
        plii_near_nodes_add(&found,
                            (plii_near_node){plii_xyz(body->positions[node]), surface->normal, surface->distance});
    }
    const plii_contact_terms terms = cluster_contacts_rigid_terms(body, state, pair->rigid, 0.0f);
    plii_pair_context touched = plii_pair_context_of(body, state);
    plii_cluster_contacts_add_nodes(&touched, *pair, &found, 0, &terms);
}

static void cluster_contacts_collide_shape(pli_body* body, plii_cluster_contacts* state, pli_rigid* rigid,
                                           int shape_index) {
    const pli_shape* shape = rigid->shapes[shape_index];
    plii_clusters* clusters = body->clusters;
    const bool is_convex = shape->def.support != NULL;
    const bool reference_mode = clusters->def.reference_mode;
    state->shape_pose = pli_transform_mul(state->rigid_pose, rigid->shape_poses[shape_index]);
    /* Bullet adds the margin of a shape to bounds that have it already. */
    const pli_bounds local = reference_mode ? plii_shape_source_bounds(shape) : shape->def.bounds(shape->def.user);
    const float margin = reference_mode ? shape->def.radius + body->collision_margin : body->collision_margin;
    pli_bounds near = plii_bounds_grow(plii_bounds_transform(local, state->shape_pose), margin);
    if (!reference_mode && !plii_bounds_overlap(near, body->bounds)) { return; }
    if (!is_convex && !cluster_contacts_measure_nodes(body, state, shape, &near)) { return; }
    plii_clusters_update_frames(body, near);
    for (int i = 0; i < clusters->count; ++i) {
        const plii_cluster* cluster = &clusters->items[i];
        if (!cluster->settings.collides || !plii_bounds_overlap(cluster->bounds, near)) { continue; }
        if (cluster->contains_pinned_node && rigid->kind != PLI_RIGID_DYNAMIC) { continue; }
        const pli_cluster_contact pair = {.cluster = i, .rigid = rigid, .shape = shape_index};
        (is_convex ? cluster_contacts_collide_convex : cluster_contacts_collide_concave)(body, state, &pair);
    }
}

void plii_cluster_contacts_collide_rigid(pli_body* body, void* data, pli_rigid* rigid) {
    plii_cluster_contacts* state = data;
    if (!state->def.with_rigids) { return; }
    const int before = state->count;
    state->rigid_pose = rigid->state.pose;
    state->rigid_velocity = (plii_twist){0};
    const bool as_reference = body->clusters->def.reference_mode || state->def.disable_contact_cache;
    if (rigid->kind != PLI_RIGID_STATIC && !as_reference && state->def.distance == NULL) {
        plii_rigid_begin_path(rigid);
        state->rigid_velocity = plii_rigid_end_velocity(rigid, body->step.dt);
        state->rigid_pose = plii_rigid_end_pose(rigid, body->step.dt);
    }
    for (int i = 0; i < rigid->shape_count; ++i) {
        cluster_contacts_collide_shape(body, state, rigid, i);
    }
    if (state->count > before) { plii_rigid_touch(rigid); }
}
