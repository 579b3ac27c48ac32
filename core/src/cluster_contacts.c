/* Contacts of clusters: the convex hull of a cluster's nodes against rigid shapes and against other clusters, one
   contact per pair, solved together with the joints. Shapes that are not convex are met node by node, the deepest and
   up to three nodes far from it. Bullet: CollideCL_RS, CollideCL_SS, SolveContact and CJoint, in their order of
   operations, given the same witness points. */

#include "box_tree.h"
#include "contact_order.h"
#include "convex_penetration.h"
#include "edge_set.h"
#include "joint_side.h"
#include "pair_memory.h"
#include "shape_impl.h"
#include "support_groups.h"
#include "world_impl.h"

/* Contacts of one cluster with one shape that is not convex. */
#define CLUSTER_CONTACTS_PER_CONCAVE_SHAPE 4
#define CLUSTER_CONTACTS_BATCH 64

typedef struct cluster_contact {
    pli_cluster_contact info;
    plii_joint_side sides[2];
    pli_vec3 arms[2]; /* from each side's centre to its witness */
    pli_vec3 normal;
    float friction;   /* share of the sliding velocity removed; 1 when it sticks */
    float erp, split; /* Bullet: m_erp, m_split */
    pli_vec3 drift, split_drift;
    pli_mat3 impulse_matrix;
    bool is_self;
} cluster_contact;

typedef struct cluster_contacts_state {
    pli_cluster_contacts_def def;
    cluster_contact* contacts;
    int count, capacity;
    plii_pair_memory memory;
    bool has_groups;
    plii_support_groups* groups; /* [group_count] per cluster */
    int group_count;
    plii_box_tree tree; /* over the clusters' bounds */
    bool has_tree;      /* of this step */
    pli_bounds* boxes;
    int* candidates;
    int box_capacity, candidate_capacity, candidate_count;
    bool has_neighbours;
    plii_edge_set neighbours; /* pairs of clusters of this body that never meet */
} cluster_contacts_state;

// ------------------------------------------------------------------------------------------------- distance of cores

typedef struct cluster_hull {
    const pli_body* body;
    const plii_clusters* clusters;
    const plii_cluster* cluster;
    const plii_support_groups* groups;
    pli_vec3 origin; /* of the frame that both sides are given in */
} cluster_hull;

static pli_vec3 cluster_hull_support(const void* user, pli_vec3 direction) {
    const cluster_hull* hull = user;
    const pli_vec4* positions = hull->body->positions;
    if (hull->groups->count > 0) {
        const int node = plii_support_groups_query(positions, hull->groups, direction);
        return pli_vec3_sub(plii_xyz(positions[node]), hull->origin);
    }
    const plii_cluster_member* members = &hull->clusters->members[hull->cluster->first_member];
    float best = -INFINITY;
    int farthest = members[0].node;
    for (int i = 0; i < hull->cluster->member_count; ++i) {
        const float along = pli_vec3_dot(plii_xyz(positions[members[i].node]), direction);
        if (along > best) {
            best = along;
            farthest = members[i].node;
        }
    }
    return pli_vec3_sub(plii_xyz(positions[farthest]), hull->origin);
}

typedef struct rigid_hull {
    const pli_shape* shape;
    pli_transform pose; /* in the frame that both sides are given in */
} rigid_hull;

static pli_vec3 rigid_hull_support(const void* user, pli_vec3 direction) {
    const rigid_hull* hull = user;
    const pli_vec3 local = pli_mat3_transpose_mul_vec3(hull->pose.rotation, direction);
    return pli_transform_point(hull->pose, hull->shape->def.support(hull->shape->def.user, local));
}

static void cluster_contacts_drop_groups(pli_body* body, cluster_contacts_state* state) {
    for (int i = 0; i < state->group_count; ++i) {
        plii_support_groups_release(body->context, &state->groups[i]);
    }
    plii_release(body->context, state->groups, (size_t)state->group_count * sizeof *state->groups);
    state->groups = NULL;
    state->group_count = 0;
    state->has_groups = state->has_tree = false;
}

static void cluster_contacts_drop_neighbours(cluster_contacts_state* state) {
    if (state->has_neighbours) { plii_edge_set_destroy(&state->neighbours); }
    state->has_neighbours = false;
}

static bool cluster_contacts_update_groups(pli_body* body, cluster_contacts_state* state) {
    const plii_clusters* clusters = plii_body_clusters(body);
    if (state->has_groups && state->group_count == clusters->count) { return true; }
    /* Clusters were added, or memory ran out half way. */
    if (state->group_count != clusters->count) { cluster_contacts_drop_neighbours(state); }
    cluster_contacts_drop_groups(body, state);
    state->groups = plii_allocate(body->context, (size_t)clusters->count * sizeof *state->groups);
    if (state->groups == NULL && clusters->count > 0) { return false; }
    state->group_count = clusters->count;
    for (int i = 0; i < clusters->count; ++i) {
        const plii_cluster* cluster = &clusters->items[i];
        if (!cluster->settings.collides) { continue; }
        if (!plii_support_groups_create(body->context, body->positions, &clusters->members[cluster->first_member].node,
                                        (int)(sizeof(plii_cluster_member) / sizeof(int)), cluster->member_count,
                                        &state->groups[i])) {
            return false;
        }
    }
    state->has_groups = true;
    return true;
}

static cluster_hull cluster_contacts_hull(const pli_body* body, cluster_contacts_state* state, int cluster,
                                          pli_vec3 origin) {
    const plii_clusters* clusters = plii_body_clusters(body);
    plii_support_groups* groups = &state->groups[cluster];
    if (groups->count > 0 && !groups->has_bounds) { plii_support_groups_update(body->positions, groups); }
    return (cluster_hull){body, clusters, &clusters->items[cluster], groups, origin};
}

/* Fills witnesses, normal and distance; false when farther apart than `max_distance` or when there is no answer. */
static bool cluster_contacts_measure(pli_body* body, cluster_contacts_state* state, const plii_convex* a,
                                     const plii_convex* b, pli_vec3 origin, plii_pair_key key, float max_distance,
                                     pli_cluster_contact* info) {
    plii_convex_options options = plii_convex_options_default();
    options.max_distance = max_distance;
#if PLIANT_WITH_CCD
    options.penetration = state->def.accurate_penetration ? plii_penetration_epa : plii_penetration_mpr;
#endif
    plii_convex_result result;
    plii_convex_distance(a, b, &options, plii_pair_memory_get(body->context, &state->memory, key), &result);
    const bool is_known = result.relation == PLII_CONVEX_SEPARATED || result.relation == PLII_CONVEX_OVERLAPPING;
    if (!is_known || !(result.distance < max_distance)) { return false; }
    info->witness = pli_vec3_add(result.point_a, origin);
    info->other_witness = pli_vec3_add(result.point_b, origin);
    info->normal = result.normal;
    info->distance = result.distance;
    return true;
}

// -------------------------------------------------------------------------------------------------- making contacts

typedef struct contact_terms {
    float margin; /* of both sides, `radius` included */
    float radius; /* of the other side's shape round its core */
    float friction, hardness, split;
} contact_terms;

/* Distances may come from the user. */
static bool cluster_contact_is_usable(const pli_cluster_contact* info) {
    return plii_is_finite(info->distance) && plii_vec3_is_finite(info->witness) &&
           plii_vec3_is_finite(info->other_witness) && plii_vec3_is_finite(info->normal) &&
           pli_vec3_length_squared(info->normal) > FLT_MIN;
}

static pli_status cluster_contacts_add(pli_body* body, cluster_contacts_state* state, const pli_cluster_contact* info,
                                       plii_joint_side a, plii_joint_side b, const contact_terms* terms) {
    if (!(info->distance < terms->margin) || !cluster_contact_is_usable(info)) { return PLI_OK; }
    if (!PLII_RESERVE(body->context, &state->contacts, &state->capacity, state->count + 1)) {
        return PLII_FAIL(body->context, PLI_ERROR_OUT_OF_MEMORY, "no memory for %d contacts", state->count + 1);
    }
    const pli_vec3 normal = plii_vec3_divide(info->normal, pli_vec3_length(info->normal));
    pli_vec3 point_a = info->witness, point_b = info->other_witness;
    if (!plii_body_clusters(body)->def.as_bullet) {
        /* Bullet acts on the cores, at two points: friction between them would make angular momentum. */
        point_b = pli_vec3_add(point_b, pli_vec3_scale(normal, terms->radius));
        point_a = point_b = pli_vec3_lerp(point_a, point_b, 0.5f);
    }
    const pli_vec3 arm_a = pli_vec3_sub(point_a, a.frame.origin);
    const pli_vec3 arm_b = pli_vec3_sub(point_b, b.frame.origin);
    const pli_vec3 velocity =
        pli_vec3_sub(plii_joint_side_velocity_at(&a, arm_a), plii_joint_side_velocity_at(&b, arm_b));
    const float approach = pli_vec3_dot(velocity, normal);
    const pli_vec3 sliding = pli_vec3_sub(velocity, pli_vec3_scale(normal, approach));
    const float cone = approach * terms->friction * approach * terms->friction;
    state->contacts[state->count++] = (cluster_contact){
        .info = *info,
        .sides = {a, b},
        .arms = {arm_a, arm_b},
        .normal = normal,
        .friction = pli_vec3_length_squared(sliding) < cone ? 1.0f : terms->friction,
        .erp = terms->hardness,
        .split = terms->split,
        .drift = pli_vec3_scale(normal, info->distance - terms->margin),
        .impulse_matrix = plii_joint_impulse_matrix(&a, arm_a, &b, arm_b),
        .is_self = info->other == body,
    };
    return PLI_OK;
}

static contact_terms cluster_contacts_rigid_terms(const pli_body* body, const cluster_contacts_state* state,
                                                  const pli_rigid* rigid, float radius) {
    const bool is_dynamic = rigid->kind == PLI_RIGID_DYNAMIC;
    return (contact_terms){radius + body->collision_margin, radius, plii_min(state->def.friction, rigid->friction),
                           is_dynamic ? state->def.dynamic_hardness : state->def.static_hardness,
                           is_dynamic ? state->def.dynamic_split : state->def.static_split};
}

static pli_status cluster_contacts_meet_convex(pli_body* body, cluster_contacts_state* state, pli_rigid* rigid,
                                               int shape_index, int cluster) {
    const pli_shape* shape = rigid->shapes[shape_index];
    const contact_terms terms = cluster_contacts_rigid_terms(body, state, rigid, shape->def.radius);
    pli_cluster_contact info = {.cluster = cluster, .rigid = rigid, .shape = shape_index};
    bool is_near;
    if (state->def.distance != NULL) {
        is_near = state->def.distance(body, &info, state->def.distance_user);
    } else {
        const plii_cluster* item = &plii_body_clusters(body)->items[cluster];
        const pli_vec3 origin = item->frame.origin;
        const cluster_hull soft = cluster_contacts_hull(body, state, cluster, origin);
        rigid_hull hard = {shape, plii_rigid_shape_transform(rigid, shape_index)};
        hard.pose.origin = pli_vec3_sub(hard.pose.origin, origin);
        const plii_convex a = {cluster_hull_support, &soft, {0, 0, 0}, 0.0f};
        const plii_convex b = {rigid_hull_support, &hard, hard.pose.origin, shape->def.radius};
        const plii_pair_key key = {cluster, shape_index, rigid};
        is_near = cluster_contacts_measure(body, state, &a, &b, origin, key, terms.margin, &info);
    }
    if (!is_near) { return PLI_OK; }
    return cluster_contacts_add(body, state, &info, plii_joint_side_of_cluster(body, cluster),
                                plii_joint_side_of_rigid(rigid), &terms);
}

/* Nodes within the margin of a shape that is not convex, of which a few are kept that lie far from each other. */
typedef struct near_node {
    pli_vec3 point, normal; /* world */
    float distance;
} near_node;

typedef struct near_nodes {
    near_node kept[CLUSTER_CONTACTS_PER_CONCAVE_SHAPE]; /* the first is the deepest */
    int count;
} near_nodes;

static float near_nodes_spread(const near_nodes* nodes, pli_vec3 point, int except) {
    float least = INFINITY;
    for (int i = 0; i < nodes->count; ++i) {
        if (i == except) { continue; }
        least = plii_min(least, pli_vec3_length_squared(pli_vec3_sub(nodes->kept[i].point, point)));
    }
    return least;
}

static void near_nodes_add(near_nodes* nodes, near_node node) {
    if (nodes->count > 0 && node.distance < nodes->kept[0].distance) {
        const near_node deepest = nodes->kept[0];
        nodes->kept[0] = node;
        node = deepest;
    }
    if (nodes->count < CLUSTER_CONTACTS_PER_CONCAVE_SHAPE) {
        nodes->kept[nodes->count++] = node;
        return;
    }
    /* In place of the kept one, other than the deepest, that lies closest to the rest. */
    int crowded = 1;
    for (int i = 2; i < nodes->count; ++i) {
        if (near_nodes_spread(nodes, nodes->kept[i].point, i) <
            near_nodes_spread(nodes, nodes->kept[crowded].point, crowded)) {
            crowded = i;
        }
    }
    if (near_nodes_spread(nodes, node.point, crowded) > near_nodes_spread(nodes, nodes->kept[crowded].point, crowded)) {
        nodes->kept[crowded] = node;
    }
}

static pli_status cluster_contacts_meet_concave(pli_body* body, cluster_contacts_state* state, pli_rigid* rigid,
                                                int shape_index, int cluster) {
    const pli_shape* shape = rigid->shapes[shape_index];
    const pli_transform pose = plii_rigid_shape_transform(rigid, shape_index);
    const contact_terms terms = cluster_contacts_rigid_terms(body, state, rigid, 0.0f);
    const plii_clusters* clusters = plii_body_clusters(body);
    const plii_cluster* item = &clusters->items[cluster];
    near_nodes found = {.count = 0};
    for (int begin = 0; begin < item->member_count; begin += CLUSTER_CONTACTS_BATCH) {
        const int rest = item->member_count - begin;
        const int count = rest < CLUSTER_CONTACTS_BATCH ? rest : CLUSTER_CONTACTS_BATCH;
        pli_vec3 points[CLUSTER_CONTACTS_BATCH], normals[CLUSTER_CONTACTS_BATCH];
        float distances[CLUSTER_CONTACTS_BATCH];
        for (int i = 0; i < count; ++i) {
            points[i] = pli_transform_inverse_point(pose, plii_cluster_node(body, clusters, item, begin + i));
        }
        shape->def.distances(shape->def.user, count, points, terms.margin, distances, normals);
        for (int i = 0; i < count; ++i) {
            if (!(distances[i] < terms.margin) || !plii_vec3_is_finite(normals[i])) { continue; }
            near_nodes_add(&found, (near_node){plii_cluster_node(body, clusters, item, begin + i),
                                               pli_mat3_mul_vec3(pose.rotation, normals[i]), distances[i]});
        }
    }
    for (int i = 0; i < found.count; ++i) {
        const near_node* node = &found.kept[i];
        const pli_cluster_contact info = {.cluster = cluster,
                                          .rigid = rigid,
                                          .shape = shape_index,
                                          .witness = node->point,
                                          .other_witness =
                                              pli_vec3_sub(node->point, pli_vec3_scale(node->normal, node->distance)),
                                          .normal = node->normal,
                                          .distance = node->distance};
        PLII_TRY(cluster_contacts_add(body, state, &info, plii_joint_side_of_cluster(body, cluster),
                                      plii_joint_side_of_rigid(rigid), &terms));
    }
    return PLI_OK;
}

static pli_status cluster_contacts_meet_shape(pli_body* body, cluster_contacts_state* state, pli_rigid* rigid,
                                              int shape_index) {
    const pli_shape* shape = rigid->shapes[shape_index];
    const plii_clusters* clusters = plii_body_clusters(body);
    const bool is_convex = shape->def.support != NULL;
    const float margin = body->collision_margin;
    const pli_bounds near = plii_bounds_grow(
        plii_bounds_transform(shape->def.bounds(shape->def.user), plii_rigid_shape_transform(rigid, shape_index)),
        margin);
    for (int i = 0; i < clusters->count; ++i) {
        const plii_cluster* cluster = &clusters->items[i];
        if (!cluster->settings.collides || !plii_bounds_overlap(cluster->bounds, near)) { continue; }
        if (cluster->contains_pinned_node && rigid->kind != PLI_RIGID_DYNAMIC) { continue; }
        PLII_TRY((is_convex ? cluster_contacts_meet_convex : cluster_contacts_meet_concave)(body, state, rigid,
                                                                                            shape_index, i));
    }
    return PLI_OK;
}

static pli_status cluster_contacts_fail_memory(pli_body* body) {
    return plii_fail(body->context, PLI_ERROR_OUT_OF_MEMORY, "cluster contacts", "no memory to search pairs");
}

static pli_status cluster_contacts_collide_rigid(pli_body* body, void* data, pli_rigid* rigid) {
    cluster_contacts_state* state = data;
    if (!state->def.with_rigids) { return PLI_OK; }
    if (!cluster_contacts_update_groups(body, state)) { return cluster_contacts_fail_memory(body); }
    const int before = state->count;
    for (int i = 0; i < rigid->shape_count; ++i) {
        const pli_status status = cluster_contacts_meet_shape(body, state, rigid, i);
        if (status != PLI_OK) {
            state->count = before;
            return status;
        }
    }
    if (state->count > before) { rigid->was_touched = true; }
    return PLI_OK;
}

// --------------------------------------------------------------------------------------- clusters against clusters

static bool cluster_contacts_update_tree(pli_body* body, cluster_contacts_state* state) {
    if (state->has_tree) { return true; }
    const plii_clusters* clusters = plii_body_clusters(body);
    if (!PLII_RESERVE(body->context, &state->boxes, &state->box_capacity, clusters->count) ||
        !PLII_RESERVE(body->context, &state->candidates, &state->candidate_capacity, clusters->count)) {
        return false;
    }
    for (int i = 0; i < clusters->count; ++i) {
        const plii_cluster* cluster = &clusters->items[i];
        const pli_bounds centre = {cluster->frame.origin, cluster->frame.origin};
        state->boxes[i] = cluster->settings.collides ? cluster->bounds : centre;
    }
    state->has_tree = plii_box_tree_build(body->context, &state->tree, clusters->count, state->boxes);
    return state->has_tree;
}

static void cluster_contacts_visit(int item, void* user) {
    cluster_contacts_state* state = user;
    state->candidates[state->candidate_count++] = item;
}

/* Clusters of `state`'s body near a box, ascending. */
static void cluster_contacts_find(cluster_contacts_state* state, pli_bounds box) {
    state->candidate_count = 0;
    plii_box_tree_overlaps(&state->tree, box, cluster_contacts_visit, state);
    /* Few at a time: insertion sort. */
    for (int i = 1; i < state->candidate_count; ++i) {
        const int moved = state->candidates[i];
        int k = i;
        while (k > 0 && state->candidates[k - 1] > moved) {
            state->candidates[k] = state->candidates[k - 1];
            --k;
        }
        state->candidates[k] = moved;
    }
}

static pli_status cluster_contacts_meet_cluster(pli_body* body, cluster_contacts_state* state, int cluster,
                                                pli_body* other, cluster_contacts_state* other_state, int other_cluster,
                                                const contact_terms* terms) {
    pli_cluster_contact info = {.cluster = cluster, .other = other, .other_cluster = other_cluster};
    bool is_near;
    if (state->def.distance != NULL) {
        is_near = state->def.distance(body, &info, state->def.distance_user);
    } else {
        const pli_vec3 origin = plii_body_clusters(body)->items[cluster].frame.origin;
        const pli_vec3 other_origin = plii_body_clusters(other)->items[other_cluster].frame.origin;
        const cluster_hull hull_a = cluster_contacts_hull(body, state, cluster, origin);
        const cluster_hull hull_b = cluster_contacts_hull(other, other_state, other_cluster, origin);
        const plii_convex a = {cluster_hull_support, &hull_a, {0, 0, 0}, 0.0f};
        const plii_convex b = {cluster_hull_support, &hull_b, pli_vec3_sub(other_origin, origin), 0.0f};
        const plii_pair_key key = {cluster, other_cluster, other};
        is_near = cluster_contacts_measure(body, state, &a, &b, origin, key, terms->margin, &info);
    }
    if (!is_near) { return PLI_OK; }
    return cluster_contacts_add(body, state, &info, plii_joint_side_of_cluster(body, cluster),
                                plii_joint_side_of_cluster(other, other_cluster), terms);
}

static pli_status cluster_contacts_collide_body(pli_body* body, void* data, pli_body* other, void* other_data) {
    cluster_contacts_state *state = data, *other_state = other_data;
    if (!state->def.with_bodies || !other_state->def.with_bodies) { return PLI_OK; }
    if (!cluster_contacts_update_groups(body, state) || !cluster_contacts_update_groups(other, other_state) ||
        !cluster_contacts_update_tree(other, other_state)) {
        return cluster_contacts_fail_memory(body);
    }
    const plii_clusters* clusters = plii_body_clusters(body);
    const contact_terms terms = {
        .margin = body->collision_margin + other->collision_margin,
        .friction = plii_min(state->def.friction, other_state->def.friction),
        .hardness = plii_max(state->def.soft_hardness, other_state->def.soft_hardness),
        .split = (state->def.soft_split + other_state->def.soft_split) / 2.0f,
    };
    /* Bullet's stored boxes are searched as they are; otherwise the boxes must cover the reach of a contact. */
    const float reach = clusters->def.as_bullet ? 0.0f : terms.margin;
    const int before = state->count;
    for (int i = 0; i < clusters->count; ++i) {
        if (!clusters->items[i].settings.collides) { continue; }
        cluster_contacts_find(other_state, plii_bounds_grow(clusters->items[i].bounds, reach));
        for (int k = 0; k < other_state->candidate_count; ++k) {
            const int candidate = other_state->candidates[k];
            if (!plii_body_clusters(other)->items[candidate].settings.collides) { continue; }
            const pli_status status =
                cluster_contacts_meet_cluster(body, state, i, other, other_state, candidate, &terms);
            if (status != PLI_OK) {
                state->count = before;
                return status;
            }
        }
    }
    return PLI_OK;
}

// ------------------------------------------------------------------------------------------------------ own clusters

/* Pairs that share a node, or lie within reach of each other as the body is now, never meet: the cloth would push
   itself apart. */
static bool cluster_contacts_find_neighbours(pli_body* body, cluster_contacts_state* state) {
    const plii_clusters* clusters = plii_body_clusters(body);
    const float margin = 2.0f * body->collision_margin;
    if (!cluster_contacts_update_groups(body, state) || !cluster_contacts_update_tree(body, state)) { return false; }
    size_t pairs = 0;
    for (int i = 0; i < clusters->count; ++i) {
        cluster_contacts_find(state, plii_bounds_grow(state->boxes[i], margin));
        pairs += (size_t)state->candidate_count;
    }
    if (!plii_edge_set_create(body->context, pairs, &state->neighbours)) { return false; }
    state->has_neighbours = true;
    for (int i = 0; i < clusters->count; ++i) {
        cluster_contacts_find(state, plii_bounds_grow(state->boxes[i], margin));
        for (int k = 0; k < state->candidate_count; ++k) {
            const int other = state->candidates[k];
            if (other <= i) { continue; }
            const pli_vec3 origin = clusters->items[i].frame.origin;
            const cluster_hull hull_a = cluster_contacts_hull(body, state, i, origin);
            const cluster_hull hull_b = cluster_contacts_hull(body, state, other, origin);
            const plii_convex a = {cluster_hull_support, &hull_a, {0, 0, 0}, 0.0f};
            const plii_convex b = {cluster_hull_support, &hull_b,
                                   pli_vec3_sub(clusters->items[other].frame.origin, origin), 0.0f};
            plii_convex_options options = plii_convex_options_default();
            options.max_distance = margin;
            plii_convex_result result;
            plii_convex_distance(&a, &b, &options, NULL, &result);
            const bool is_apart = result.relation == PLII_CONVEX_BEYOND ||
                                  (result.relation == PLII_CONVEX_SEPARATED && result.distance >= margin);
            if (!is_apart) { plii_edge_set_insert(&state->neighbours, i, other); }
        }
    }
    return true;
}

static pli_status cluster_contacts_collide_self(pli_body* body, cluster_contacts_state* state) {
    if (!cluster_contacts_update_groups(body, state) || !cluster_contacts_update_tree(body, state) ||
        (!state->has_neighbours && !cluster_contacts_find_neighbours(body, state))) {
        return cluster_contacts_fail_memory(body);
    }
    const plii_clusters* clusters = plii_body_clusters(body);
    const contact_terms terms = {2.0f * body->collision_margin, 0.0f, state->def.friction, state->def.soft_hardness,
                                 state->def.soft_split};
    for (int i = 0; i < clusters->count; ++i) {
        if (!clusters->items[i].settings.collides) { continue; }
        cluster_contacts_find(state, plii_bounds_grow(clusters->items[i].bounds, terms.margin));
        for (int k = 0; k < state->candidate_count; ++k) {
            const int other = state->candidates[k];
            if (other <= i || !clusters->items[other].settings.collides ||
                plii_edge_set_contains(&state->neighbours, i, other)) {
                continue;
            }
            PLII_TRY(cluster_contacts_meet_cluster(body, state, i, body, state, other, &terms));
        }
    }
    return PLI_OK;
}

// ----------------------------------------------------------------------------------------------------------- solving

static void cluster_contacts_prepare(pli_body* body, void* data, const plii_step* step) {
    cluster_contacts_state* state = data;
    if (state->def.with_self) { cluster_contacts_collide_self(body, state); }
    const int iterations = body->world->joint_iterations;
    for (int i = 0; i < state->count; ++i) {
        cluster_contact* contact = &state->contacts[i];
        contact->drift = plii_vec3_divide(pli_vec3_scale(contact->drift, contact->erp), step->dt);
        if (contact->split > 0.0f) {
            contact->split_drift =
                pli_mat3_mul_vec3(contact->impulse_matrix, pli_vec3_scale(contact->drift, contact->split));
            contact->drift = pli_vec3_scale(contact->drift, 1.0f - contact->split);
        }
        contact->drift = plii_vec3_divide(contact->drift, (float)iterations);
    }
}

/* Impulses between clusters of one body: limited and scaled as the first cluster says. */
static pli_vec3 cluster_contact_limit_self(const cluster_contact* contact, pli_vec3 impulse) {
    if (contact->sides[0].cluster == NULL) { return impulse; }
    const pli_cluster_settings* settings = &contact->sides[0].cluster->settings;
    const float size = pli_vec3_length(impulse);
    const float limit = settings->max_self_impulse;
    const float scale = size > limit ? limit / size : 1.0f;
    return pli_vec3_scale(impulse, scale * settings->self_impulse_factor);
}

static void cluster_contacts_solve(pli_body* body, void* data, const plii_step* step) {
    (void)body;
    (void)step;
    cluster_contacts_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        cluster_contact* contact = &state->contacts[i];
        const pli_vec3 velocity = pli_vec3_sub(plii_joint_side_velocity_at(&contact->sides[0], contact->arms[0]),
                                               plii_joint_side_velocity_at(&contact->sides[1], contact->arms[1]));
        const float approach = pli_vec3_dot(velocity, contact->normal);
        pli_vec3 change = contact->drift;
        if (approach < 0.0f) {
            const pli_vec3 closing = pli_vec3_scale(contact->normal, approach);
            const pli_vec3 sliding = pli_vec3_sub(velocity, closing);
            change = pli_vec3_add(change, pli_vec3_add(closing, pli_vec3_scale(sliding, contact->friction)));
        }
        pli_vec3 impulse = pli_mat3_mul_vec3(contact->impulse_matrix, change);
        if (contact->is_self) { impulse = cluster_contact_limit_self(contact, impulse); }
        plii_joint_side_apply_impulse(&contact->sides[0], pli_vec3_neg(impulse), contact->arms[0]);
        plii_joint_side_apply_impulse(&contact->sides[1], impulse, contact->arms[1]);
    }
}

/* The first contact, then the others from the last one back: cleanupClusters removes contacts while it walks their list
   and fills each gap with the last one. */
static void cluster_contacts_finish(pli_body* body, void* data, const plii_step* step) {
    (void)body;
    (void)step;
    cluster_contacts_state* state = data;
    for (int i = 0; i < state->count; ++i) {
        cluster_contact* contact = &state->contacts[i == 0 ? 0 : state->count - i];
        if (!(contact->split > 0.0f)) { continue; }
        pli_vec3 drift = contact->split_drift;
        if (contact->is_self) { drift = cluster_contact_limit_self(contact, drift); }
        plii_joint_side_apply_drift(&contact->sides[0], pli_vec3_neg(drift), contact->arms[0]);
        plii_joint_side_apply_drift(&contact->sides[1], drift, contact->arms[1]);
    }
}

// ------------------------------------------------------------------------------------------------------ the feature

static void cluster_contacts_clear(pli_body* body, void* data, const plii_step* step) {
    (void)step;
    cluster_contacts_state* state = data;
    state->count = 0;
    state->has_tree = false;
    for (int i = 0; i < state->group_count; ++i) {
        state->groups[i].has_bounds = false;
    }
    /* Without memory pairs start anew; the contacts are the same up to rounding. */
    plii_pair_memory_turn(body->context, &state->memory);
}

static void cluster_contacts_forget_body(pli_body* body, void* data, const pli_body* other) {
    (void)other;
    (void)body;
    ((cluster_contacts_state*)data)->count = 0;
}

static void cluster_contacts_forget_clusters(pli_body* body, void* data, const pli_body* other) {
    cluster_contacts_state* state = data;
    state->count = 0;
    if (other != body) { return; }
    cluster_contacts_drop_groups(body, state);
    cluster_contacts_drop_neighbours(state);
}

static void cluster_contacts_forget_rigid(pli_body* body, void* data, const pli_rigid* rigid) {
    (void)body;
    (void)rigid;
    ((cluster_contacts_state*)data)->count = 0;
}

/* New members join clusters, which keep their places. */
static void cluster_contacts_topology_commit(pli_body* body, void* data, const plii_topology_change* change,
                                             void** blocks) {
    (void)change;
    (void)blocks;
    ((cluster_contacts_state*)data)->count = 0;
    cluster_contacts_drop_groups(body, data);
}

static void cluster_contacts_disable(pli_body* body, void* data) {
    cluster_contacts_state* state = data;
    pli_context* context = body->context;
    cluster_contacts_drop_groups(body, state);
    cluster_contacts_drop_neighbours(state);
    plii_release(context, state->contacts, (size_t)state->capacity * sizeof *state->contacts);
    plii_release(context, state->boxes, (size_t)state->box_capacity * sizeof *state->boxes);
    plii_release(context, state->candidates, (size_t)state->candidate_capacity * sizeof *state->candidates);
    plii_pair_memory_release(context, &state->memory);
    plii_box_tree_free(context, &state->tree);
}

static size_t cluster_contacts_bytes(const pli_body* body, const void* data) {
    (void)body;
    const cluster_contacts_state* state = data;
    size_t bytes = (size_t)state->capacity * sizeof *state->contacts +
                   (size_t)state->box_capacity * sizeof *state->boxes +
                   (size_t)state->candidate_capacity * sizeof *state->candidates +
                   (size_t)state->group_count * sizeof *state->groups + plii_pair_memory_bytes(&state->memory) +
                   plii_box_tree_bytes(&state->tree);
    for (int i = 0; i < state->group_count; ++i) {
        bytes += plii_support_groups_bytes(&state->groups[i]);
    }
    if (state->has_neighbours) { bytes += (state->neighbours.mask + 1) * sizeof *state->neighbours.slots; }
    return bytes;
}

static const plii_feature_class* const cluster_contacts_needs[] = {&plii_clusters_class, NULL};

static const plii_feature_class cluster_contacts_class = {
    .name = "cluster contacts",
    .state_size = sizeof(cluster_contacts_state),
    .needs = cluster_contacts_needs,
    .stages = {[PLII_STAGE_UPDATE] = {cluster_contacts_clear, PLII_ORDER_CLEAR_CONTACTS},
               [PLII_STAGE_JOINT_PREPARE] = {cluster_contacts_prepare, PLII_ORDER_CLUSTER_CONTACTS},
               [PLII_STAGE_JOINT_SOLVE] = {cluster_contacts_solve, PLII_ORDER_CLUSTER_CONTACTS},
               [PLII_STAGE_JOINT_FINISH] = {cluster_contacts_finish, PLII_ORDER_CLUSTER_CONTACTS}},
    .disable = cluster_contacts_disable,
    .collide_rigid = cluster_contacts_collide_rigid,
    .collide_body = cluster_contacts_collide_body,
    .forget_rigid = cluster_contacts_forget_rigid,
    .forget_body = cluster_contacts_forget_body,
    .forget_clusters = cluster_contacts_forget_clusters,
    .forget_topology = cluster_contacts_forget_body,
    .bytes = cluster_contacts_bytes,
    .topology_commit = cluster_contacts_topology_commit,
};

pli_cluster_contacts_def pli_cluster_contacts_def_default(void) {
    return (pli_cluster_contacts_def){
        .with_rigids = true,
        .with_bodies = true,
        .friction = 0.2f,
        .dynamic_hardness = 0.1f,
        .static_hardness = 1.0f,
        .soft_hardness = 0.5f,
        .dynamic_split = 0.5f,
        .static_split = 0.5f,
        .soft_split = 0.5f,
        .cookie = PLII_DEF_COOKIE,
    };
}

static pli_status cluster_contacts_check_def(pli_context* context, const pli_cluster_contacts_def* def,
                                             const char* function) {
    if (def == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "def is null"); }
    if (def->cookie != PLII_DEF_COOKIE) {
        return plii_fail(context, PLI_ERROR_INVALID_DEF, function, "start from pli_cluster_contacts_def_default()");
    }
    if (!(def->friction >= 0.0f) || !plii_is_finite(def->friction)) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "friction is %g, negative or not finite",
                         (double)def->friction);
    }
    const struct {
        const char* name;
        float value;
    } shares[] = {{"dynamic_hardness", def->dynamic_hardness}, {"static_hardness", def->static_hardness},
                  {"soft_hardness", def->soft_hardness},       {"dynamic_split", def->dynamic_split},
                  {"static_split", def->static_split},         {"soft_split", def->soft_split}};
    for (size_t i = 0; i < sizeof shares / sizeof shares[0]; ++i) {
        if (!(shares[i].value >= 0.0f && shares[i].value <= 1.0f)) {
            return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%s is %g, not in [0, 1]", shares[i].name,
                             (double)shares[i].value);
        }
    }
    return PLI_OK;
}

pli_status pli_body_enable_cluster_contacts(pli_body* body, const pli_cluster_contacts_def* def) {
    PLII_TRY(plii_check_body(body, __func__));
    PLII_TRY(cluster_contacts_check_def(body->context, def, __func__));
    if (body->world->is_stepping) {
        return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE, "not allowed between predict and solve");
    }
    const bool had_clusters = plii_body_clusters(body) != NULL;
    if (!had_clusters) { PLII_TRY(pli_body_enable_clusters(body, NULL)); }
    void* data = NULL;
    const pli_status status = plii_feature_enable(body, &cluster_contacts_class, &data);
    if (status == PLI_OK) {
        ((cluster_contacts_state*)data)->def = *def;
    } else if (!had_clusters) {
        pli_body_disable_clusters(body);
    }
    return status;
}

void pli_body_disable_cluster_contacts(pli_body* body) {
    if (plii_check_body(body, __func__) == PLI_OK) { plii_feature_disable(body, &cluster_contacts_class); }
}

int pli_body_get_cluster_contacts(const pli_body* body, int capacity, pli_cluster_contact* contacts) {
    if (plii_check_body(body, __func__) != PLI_OK) { return 0; }
    const cluster_contacts_state* state = plii_feature_state(body, &cluster_contacts_class);
    if (state == NULL) { return 0; }
    for (int i = 0; contacts != NULL && i < capacity && i < state->count; ++i) {
        contacts[i] = state->contacts[i].info;
    }
    return state->count;
}

pli_status pli_body_reorder_cluster_contacts(pli_body* body, const int* order, int count) {
    PLII_TRY(plii_check_body(body, __func__));
    cluster_contacts_state* state = plii_feature_state(body, &cluster_contacts_class);
    if (state == NULL) { return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE, "cluster contacts are not enabled"); }
    return plii_reorder_contacts(body, state->contacts, sizeof *state->contacts, state->count, order, count, __func__);
}
