/* Which clusters meet what. A pair has the contact of its nearest points, which is all there is in
   reference mode (CollideCL_RS, CollideCL_SS); otherwise up to three more at nodes far from it, so that flat sides
   rest on each other. Shapes that are not convex are met node by node. */

#include "math/lanes.h"

#include "body/pipeline.h"
#include "cluster/cluster_contacts_impl.h"
#include "math/bounds.h"

#include "body/world_impl.h"
#include "shape/shape_impl.h"

#define CLUSTER_CONTACTS_PER_PAIR 4
#define CLUSTER_CONTACTS_BATCH 64
#define CLUSTER_CONTACTS_FEW 64 /* clusters, whose boxes are looked at one by one */
/* Smaller clusters lie beside others that share the load: nearest points and nodes will do. */
#define CLUSTER_CONTACTS_MIN_NODES 8
#define CLUSTER_CONTACTS_APPROACHES 6 /* steps towards a point, before GJK is asked */
#define CLUSTER_CONTACTS_TILT 0.1f    /* of the directions in which corners are looked for */

static bool cluster_contacts_are_as_reference(const pli_body* body, const pli_cluster_contact* info) {
    return plii_body_clusters(body)->def.reference_mode && info->other != body;
}

/* A pair as its contacts are made. Its sides are taken for the first of them: most pairs have none. */
typedef struct met_pair {
    pli_body* body;
    plii_cluster_contacts* state;
    plii_joint_side sides[2];
    bool has_sides;
} met_pair;

static void met_pair_start(met_pair* pair, pli_body* body, plii_cluster_contacts* state) {
    pair->body = body;
    pair->state = state;
    pair->has_sides = false;
}

static pli_status cluster_contacts_add(met_pair* pair, const pli_cluster_contact* info,
                                       const plii_contact_terms* terms) {
    pli_body* body = pair->body;
    plii_cluster_contacts* state = pair->state;
    const bool reference_mode = cluster_contacts_are_as_reference(body, info);
    if (!PLII_RESERVE(body->context, &state->contacts, &state->capacity, state->count + 1)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    if (!pair->has_sides) {
        pair->sides[0] = plii_joint_side_of_cluster(body, info->cluster);
        pair->sides[1] = info->other != NULL ? plii_joint_side_of_cluster(info->other, info->other_cluster)
                                             : plii_joint_side_of_rigid(info->rigid);
        pair->has_sides = true;
    }
    plii_cluster_contact* contact = &state->contacts[state->count];
    if (plii_cluster_contact_make(info, pair->sides, terms, reference_mode, contact)) {
        contact->is_self = info->other == body;
        state->count += 1;
    }
    return PLI_OK;
}

/* Clusters of one body deform against each other too much for their contacts to be followed. */
static bool cluster_contacts_are_followed(const pli_body* body, const plii_cluster_contacts* state, plii_pair_key key) {
    return !state->clusters->def.reference_mode && !state->def.disable_contact_cache && key.other != body;
}

/* What is known of a pair; `record` is NULL when nothing is to be kept, or when out of memory. */
typedef struct known_pair {
    plii_pair_record* record;
    bool is_followed;
} known_pair;

static plii_convex_cache* known_pair_cache(known_pair pair) {
    return pair.record != NULL ? &pair.record->cache : NULL;
}

/* A slot for a pair that is new; 0 when out of memory. */
static int cluster_contacts_take_manifold(pli_body* body, plii_cluster_contacts* state) {
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

static void cluster_contacts_give_manifold(plii_cluster_contacts* state, int slot) {
    state->manifolds[slot - 1].age = state->free_manifold1;
    state->free_manifold1 = slot;
}

static known_pair cluster_contacts_recall(pli_body* body, plii_cluster_contacts* state, plii_pair_key key) {
    if (state->def.distance != NULL || plii_pair_memory_get(body->context, &state->memory, key) == NULL) {
        return (known_pair){NULL, false};
    }
    plii_pair_record* record = &state->memory.present[state->memory.present_count - 1];
    const bool is_followed = cluster_contacts_are_followed(body, state, key);
    if (is_followed && record->place_before != PLI_NULL_INDEX) {
        int* before = &state->memory.before[record->place_before].slot;
        record->slot = *before;
        *before = 0;
    }
    return (known_pair){record, is_followed};
}

/* Adds the contacts of a pair that is followed as they are now, or returns false when they have to be measured. */
static bool cluster_contacts_follow(pli_body* body, plii_cluster_contacts* state, known_pair pair,
                                    const pli_cluster_contact* info, const plii_contact_terms terms[2],
                                    const void* key) {
    if (!pair.is_followed || pair.record->slot == 0 ||
        !PLII_RESERVE(body->context, &state->contacts, &state->capacity, state->count + PLII_MANIFOLD_POINTS)) {
        return false;
    }
    return plii_cluster_manifold_follow(body, info, terms, key, &state->manifolds[pair.record->slot - 1], state);
}

/* Keeps the contacts [first, state->count) of a pair that has been measured. Pairs that do not touch hold no slot. */
static void cluster_contacts_keep(pli_body* body, plii_cluster_contacts* state, known_pair pair, int first,
                                  const void* key, float margin) {
    if (!pair.is_followed) { return; }
    plii_pair_record* record = pair.record;
    const int count = state->count - first;
    if (count == 0 || count > PLII_MANIFOLD_POINTS) {
        if (record->slot > 0) { cluster_contacts_give_manifold(state, record->slot); }
        record->slot = 0;
        return;
    }
    if (record->slot == 0) { record->slot = cluster_contacts_take_manifold(body, state); }
    if (record->slot == 0) { return; }
    plii_cluster_manifold_keep(body, state, first, key, margin, &state->manifolds[record->slot - 1]);
}

void plii_cluster_contacts_turn(pli_body* body, plii_cluster_contacts* state) {
    for (int i = 0; i < state->memory.before_count; ++i) {
        const int slot = state->memory.before[i].slot;
        if (slot > 0) { cluster_contacts_give_manifold(state, slot); }
    }
    /* Without memory pairs start anew; the contacts are the same up to rounding. */
    if (!plii_pair_memory_turn(body->context, &state->memory)) { plii_cluster_contacts_forget(state); }
}

void plii_cluster_contacts_forget(plii_cluster_contacts* state) {
    plii_pair_memory_forget(&state->memory);
    state->manifold_count = state->free_manifold1 = 0;
}

// ----------------------------------------------------------------------------------------------------- several points

/* Nodes within the margin of the other side, of which a few are kept that lie far from each other. */
typedef struct near_node {
    pli_vec3 point, normal; /* world; the normal towards the cluster */
    float distance;
} near_node;

typedef struct near_nodes {
    near_node kept[CLUSTER_CONTACTS_PER_PAIR]; /* the first is the deepest */
    plii_group_vec3 points;                    /* of these; infinitely far where there is none */
    int count;
    int crowded; /* of as many as can be kept, other than the deepest, the one that lies closest to the rest; 0: not
                    known */
    float crowded_spread;
} near_nodes;

static void near_nodes_start_empty(near_nodes* nodes) {
    const pli_vec3 nowhere = pli_vec3_make(INFINITY, INFINITY, INFINITY);
    nodes->count = nodes->crowded = 0;
    for (int i = 0; i < CLUSTER_CONTACTS_PER_PAIR; ++i) {
        plii_group_vec3_set(&nodes->points, i, nowhere);
    }
}

static void near_nodes_set(near_nodes* nodes, int place, const near_node* node) {
    nodes->kept[place] = *node;
    plii_group_vec3_set(&nodes->points, place, node->point);
    nodes->crowded = 0;
}

/* Square of the distance from the nearest of those kept, but for one. */
static float near_nodes_spread(const near_nodes* nodes, pli_vec3 point, int except) {
    static const float excepted[CLUSTER_CONTACTS_PER_PAIR][CLUSTER_CONTACTS_PER_PAIR] = {
        {INFINITY, 0, 0, 0}, {0, INFINITY, 0, 0}, {0, 0, INFINITY, 0}, {0, 0, 0, INFINITY}};
    const plii_vec3x4 points = {plii_float4_load(nodes->points.x), plii_float4_load(nodes->points.y),
                                plii_float4_load(nodes->points.z)};
    const plii_vec3x4 ways = plii_vec3x4_sub(points, plii_vec3x4_all(point));
    plii_float4 least = plii_lanes_max(plii_vec3x4_dot(ways, ways), plii_float4_load(excepted[except]));
    least = plii_lanes_min(least, plii_lanes_all_w(least));
    return plii_lanes_first(plii_lanes_min(plii_lanes_min(least, plii_lanes_all_y(least)), plii_lanes_all_z(least)));
}

static void near_nodes_find_crowded(near_nodes* nodes) {
    nodes->crowded = 1;
    nodes->crowded_spread = near_nodes_spread(nodes, nodes->kept[1].point, 1);
    for (int i = 2; i < nodes->count; ++i) {
        const float spread = near_nodes_spread(nodes, nodes->kept[i].point, i);
        if (spread < nodes->crowded_spread) {
            nodes->crowded = i;
            nodes->crowded_spread = spread;
        }
    }
}

static void near_nodes_add(near_nodes* nodes, near_node node) {
    if (nodes->count > 0 && node.distance < nodes->kept[0].distance) {
        const near_node deepest = nodes->kept[0];
        near_nodes_set(nodes, 0, &node);
        node = deepest;
    }
    if (nodes->count < CLUSTER_CONTACTS_PER_PAIR) {
        near_nodes_set(nodes, nodes->count++, &node);
        return;
    }
    if (nodes->crowded == 0) { near_nodes_find_crowded(nodes); }
    if (near_nodes_spread(nodes, node.point, nodes->crowded) > nodes->crowded_spread) {
        near_nodes_set(nodes, nodes->crowded, &node);
    }
}

/* Unless it lies near the first. */
static void near_nodes_add_beside(near_nodes* nodes, near_node node, float margin) {
    const float squared = pli_vec3_length_squared(pli_vec3_sub(node.point, nodes->kept[0].point));
    if (squared > margin * margin) { near_nodes_add(nodes, node); }
}

/* The nearest points first, so that nodes at the same place are seen as such. */
static void near_nodes_start(near_nodes* nodes, const pli_cluster_contact* nearest) {
    near_nodes_start_empty(nodes);
    near_nodes_add(nodes, (near_node){nearest->witness, nearest->normal, nearest->distance});
}

static pli_status near_nodes_add_contacts(met_pair* pair, pli_cluster_contact info, const near_nodes* found, int first,
                                          const plii_contact_terms* terms) {
    for (int i = first; i < found->count; ++i) {
        const near_node* node = &found->kept[i];
        info.witness = node->point;
        info.other_witness = pli_vec3_sub(node->point, pli_vec3_scale(node->normal, node->distance));
        info.normal = node->normal;
        info.distance = node->distance;
        PLII_TRY(cluster_contacts_add(pair, &info, terms));
    }
    return PLI_OK;
}

static pli_vec3 cluster_contacts_point_support(const void* user, pli_vec3 direction) {
    (void)direction;
    return *(const pli_vec3*)user;
}

/* The hull ends before the point along a direction; of any length. */
static bool cluster_contacts_ends_before(const plii_cluster_hull* hull, pli_vec3 point, pli_vec3 direction,
                                         float margin) {
    const float end = plii_cluster_hull_reach(hull, direction);
    return pli_vec3_dot(point, direction) - end > margin * pli_vec3_length(direction);
}

typedef enum near_answer { NEAR_YES, NEAR_NO, NEAR_UNKNOWN } near_answer;

/* Goes towards the point from a point of the hull, which lies `gap` before it (Gilbert, "An iterative procedure for
   computing the minimum of a quadratic form on a convex set", 1966). In the frame of the hull. */
static near_answer cluster_contacts_approach(pli_vec3 point, const plii_cluster_hull* hull, const plii_convex* convex,
                                             pli_vec3 gap, float margin) {
    for (int i = 0; i < CLUSTER_CONTACTS_APPROACHES; ++i) {
        const pli_vec3 end = convex->support(hull, gap);
        const float squared = pli_vec3_length_squared(gap);
        if (pli_vec3_dot(pli_vec3_sub(point, end), gap) > margin * sqrtf(squared)) { return NEAR_NO; }
        const pli_vec3 way = pli_vec3_sub(end, pli_vec3_sub(point, gap));
        const float along = pli_vec3_dot(gap, way), length_squared = pli_vec3_length_squared(way);
        if (!(along > 0.0f)) { return NEAR_UNKNOWN; }
        gap = pli_vec3_sub(gap, pli_vec3_scale(way, along < length_squared ? along / length_squared : 1.0f));
        if (pli_vec3_length_squared(gap) < margin * margin) { return NEAR_YES; }
    }
    return NEAR_UNKNOWN;
}

/* `hub` is a point of the hull, or near it. What is easy to see first. */
static bool cluster_contacts_is_near_hull(pli_vec3 point, const plii_cluster_hull* hull, pli_vec3 hub, float margin) {
    if (!plii_bounds_overlap(plii_bounds_grow(hull->cluster->bounds, margin), (pli_bounds){point, point})) {
        return false;
    }
    pli_vec3 gap;
    if (plii_support_groups_has_near(hull->groups, hub, point, margin, &gap)) { return true; }
    point = pli_vec3_sub(point, hull->origin);
    const plii_convex a = {.support = cluster_contacts_point_support, .user = &point, .centre = point};
    const plii_convex b = plii_cluster_hull_convex(hull);
    if (cluster_contacts_ends_before(hull, point, pli_vec3_sub(point, b.centre), margin)) { return false; }
    const near_answer answer = cluster_contacts_approach(point, hull, &b, gap, margin);
    return answer != NEAR_UNKNOWN ? answer == NEAR_YES : plii_cluster_contacts_are_near(&a, &b, margin);
}

// ------------------------------------------------------------------------------------------------------- rigid bodies

static plii_contact_terms cluster_contacts_rigid_terms(const pli_body* body, const plii_cluster_contacts* state,
                                                       const pli_rigid* rigid, float radius) {
    const bool is_dynamic = rigid->kind == PLI_RIGID_DYNAMIC;
    return (plii_contact_terms){radius + body->collision_margin, radius, plii_min(state->def.friction, rigid->friction),
                                is_dynamic ? state->def.dynamic_hardness : state->def.static_hardness,
                                is_dynamic ? state->def.dynamic_split : state->def.static_split};
}

static void cluster_contacts_add_near_nodes(const pli_body* body, const pli_cluster_contact* info,
                                            const plii_measured_nodes* nodes, near_nodes* found) {
    const pli_mat3 rotation = plii_rigid_shape_transform(info->rigid, info->shape).rotation;
    const plii_clusters* clusters = plii_body_clusters(body);
    const plii_cluster* item = &clusters->items[info->cluster];
    const float margin = body->collision_margin;
    for (int i = 0; i < nodes->count; ++i) {
        if (!(nodes->distances[i] < margin) || !plii_vec3_is_finite(nodes->normals[i])) { continue; }
        const near_node node = {plii_cluster_node(body, clusters, item, nodes->first + i),
                                pli_mat3_mul_vec3(rotation, nodes->normals[i]), nodes->distances[i]};
        near_nodes_add_beside(found, node, margin);
    }
}

/* Adds the nodes of the cluster that lie within the margin of the shape's surface, but for those near the first. What
   was measured of them is in `nodes`. */
static void cluster_contacts_find_near_nodes(const pli_body* body, const pli_cluster_contact* info,
                                             plii_measured_nodes* nodes, near_nodes* found) {
    const int count = plii_body_clusters(body)->items[info->cluster].member_count;
    for (int first = 0; first < count; first += nodes->count) {
        if (nodes->count == 0 || first > 0) { plii_cluster_contacts_measure_nodes(body, info, first, nodes); }
        cluster_contacts_add_near_nodes(body, info, nodes, found);
    }
}

/* Corners of the shape's core that lie over the cluster, near the plane of the nearest points: its farthest points in
   directions a little off the normal. */
static void cluster_contacts_find_near_corners(const pli_cluster_contact* info, plii_cluster_hull hull, float radius,
                                               float margin, near_nodes* found) {
    const pli_vec3 n = info->normal;
    const pli_vec3 across = fabsf(n.x) > 0.6f ? pli_vec3_make(0, 1, 0) : pli_vec3_make(1, 0, 0);
    const pli_vec3 u = plii_vec3_safe_normalize(pli_vec3_cross(n, across)), v = pli_vec3_cross(n, u);
    for (int i = 0; i < 4; ++i) {
        const pli_vec3 tilt =
            pli_vec3_scale(i % 2 == 0 ? u : v, i < 2 ? CLUSTER_CONTACTS_TILT : -CLUSTER_CONTACTS_TILT);
        const pli_vec3 corner =
            plii_cluster_contacts_rigid_point(info, plii_vec3_safe_normalize(pli_vec3_add(n, tilt)));
        const float above = pli_vec3_dot(pli_vec3_sub(info->witness, corner), n);
        if (!(above < margin + radius) ||
            !cluster_contacts_is_near_hull(corner, &hull, info->witness, margin + radius)) {
            continue;
        }
        const near_node node = {pli_vec3_add(corner, pli_vec3_scale(n, above)), n, above - radius};
        near_nodes_add_beside(found, node, margin);
    }
}

/* terms[0] is that of the nearest points, terms[1] that of nodes and corners. */
static pli_status cluster_contacts_measure_convex(met_pair* pair, pli_cluster_contact info,
                                                  const plii_contact_terms terms[2], plii_convex_cache* cache) {
    pli_body* body = pair->body;
    plii_cluster_contacts* state = pair->state;
    const pli_shape* shape = info.rigid->shapes[info.shape];
    plii_measured_nodes nodes;
    nodes.count = 0;
    if (!plii_cluster_contacts_measure_rigid(body, state, cache, terms[0].margin, &info, &nodes)) { return PLI_OK; }
    PLII_TRY(cluster_contacts_add(pair, &info, terms));
    if (cluster_contacts_are_as_reference(body, &info) || state->def.distance != NULL) { return PLI_OK; }
    near_nodes found;
    near_nodes_start(&found, &info);
    cluster_contacts_find_near_nodes(body, &info, &nodes, &found);
    const plii_cluster* cluster = &plii_body_clusters(body)->items[info.cluster];
    if (cluster->member_count >= CLUSTER_CONTACTS_MIN_NODES) {
        const plii_cluster_hull hull = plii_cluster_contacts_hull(body, state, info.cluster, cluster->frame.origin);
        cluster_contacts_find_near_corners(&info, hull, shape->def.radius, body->collision_margin, &found);
    }
    return near_nodes_add_contacts(pair, info, &found, 1, &terms[1]);
}

static pli_status cluster_contacts_meet_convex(pli_body* body, plii_cluster_contacts* state,
                                               const pli_cluster_contact* pair) {
    const pli_shape* shape = pair->rigid->shapes[pair->shape];
    const plii_contact_terms terms[2] = {cluster_contacts_rigid_terms(body, state, pair->rigid, shape->def.radius),
                                         cluster_contacts_rigid_terms(body, state, pair->rigid, 0.0f)};
    const known_pair known =
        cluster_contacts_recall(body, state, (plii_pair_key){pair->cluster, pair->shape, pair->rigid, 0});
    if (cluster_contacts_follow(body, state, known, pair, terms, shape)) { return PLI_OK; }
    met_pair met;
    met_pair_start(&met, body, state);
    const int first = state->count;
    PLII_TRY(cluster_contacts_measure_convex(&met, *pair, terms, known_pair_cache(known)));
    cluster_contacts_keep(body, state, known, first, shape, terms[0].margin);
    return PLI_OK;
}

/* Clusters share nodes, so all nodes near a shape are measured first, each once. `near` shrinks to the nodes that are
   within the margin. */
static pli_status cluster_contacts_measure_nodes(pli_body* body, plii_cluster_contacts* state, const pli_rigid* rigid,
                                                 int shape_index, pli_bounds* near) {
    if (!PLII_RESERVE(body->context, &state->surface, &state->surface_capacity, body->node_count)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    const pli_shape* shape = rigid->shapes[shape_index];
    const pli_transform pose = plii_rigid_shape_transform(rigid, shape_index);
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
            state->surface[nodes[i]] = (plii_near_surface){distances[i], normal};
            const pli_vec3 x = plii_xyz(body->positions[nodes[i]]);
            found = (pli_bounds){plii_vec3_min(found.min, x), plii_vec3_max(found.max, x)};
        }
    }
    *near = found;
    return PLI_OK;
}

static pli_status cluster_contacts_meet_concave(pli_body* body, plii_cluster_contacts* state,
                                                const pli_cluster_contact* pair) {
    const plii_clusters* clusters = plii_body_clusters(body);
    const plii_cluster* cluster = &clusters->items[pair->cluster];
    near_nodes found;
    near_nodes_start_empty(&found);
    for (int i = 0; i < cluster->member_count; ++i) {
        const int node = clusters->members[cluster->first_member + i].node;
        const plii_near_surface* surface = &state->surface[node];
        if (!(surface->distance < body->collision_margin)) { continue; }
        near_nodes_add(&found, (near_node){plii_xyz(body->positions[node]), surface->normal, surface->distance});
    }
    const plii_contact_terms terms = cluster_contacts_rigid_terms(body, state, pair->rigid, 0.0f);
    met_pair met;
    met_pair_start(&met, body, state);
    return near_nodes_add_contacts(&met, *pair, &found, 0, &terms);
}

/* Where clusters are met. Bullet adds the margin of a shape to bounds that have it already. */
static pli_bounds cluster_contacts_near(const pli_body* body, bool reference_mode, const pli_rigid* rigid,
                                        int shape_index) {
    const pli_shape* shape = rigid->shapes[shape_index];
    const pli_bounds local = reference_mode ? plii_shape_source_bounds(shape) : shape->def.bounds(shape->def.user);
    const float margin = reference_mode ? shape->def.radius + body->collision_margin : body->collision_margin;
    return plii_bounds_grow(plii_bounds_transform(local, plii_rigid_shape_transform(rigid, shape_index)), margin);
}

static pli_status cluster_contacts_meet_shape(pli_body* body, plii_cluster_contacts* state, pli_rigid* rigid,
                                              int shape_index) {
    const pli_shape* shape = rigid->shapes[shape_index];
    plii_clusters* clusters = plii_body_clusters(body);
    const bool is_convex = shape->def.support != NULL;
    const bool reference_mode = clusters->def.reference_mode;
    pli_bounds near = cluster_contacts_near(body, reference_mode, rigid, shape_index);
    if (!reference_mode && !plii_bounds_overlap(near, body->bounds)) { return PLI_OK; }
    if (!is_convex) { PLII_TRY(cluster_contacts_measure_nodes(body, state, rigid, shape_index, &near)); }
    if (!reference_mode && !plii_bounds_overlap(near, body->bounds)) { return PLI_OK; }
    plii_clusters_take_frames(body, clusters, near);
    for (int i = 0; i < clusters->count; ++i) {
        const plii_cluster* cluster = &clusters->items[i];
        if (!cluster->settings.collides || !plii_bounds_overlap(cluster->bounds, near)) { continue; }
        if (cluster->contains_pinned_node && rigid->kind != PLI_RIGID_DYNAMIC) { continue; }
        const pli_cluster_contact pair = {.cluster = i, .rigid = rigid, .shape = shape_index};
        PLII_TRY((is_convex ? cluster_contacts_meet_convex : cluster_contacts_meet_concave)(body, state, &pair));
    }
    return PLI_OK;
}

pli_status plii_cluster_contacts_collide_rigid(pli_body* body, void* data, pli_rigid* rigid) {
    plii_cluster_contacts* state = data;
    if (!state->def.with_rigids) { return PLI_OK; }
    if (!plii_cluster_contacts_update_groups(body, state)) { return PLI_ERROR_OUT_OF_MEMORY; }
    const int before = state->count;
    for (int i = 0; i < rigid->shape_count; ++i) {
        const pli_status status = cluster_contacts_meet_shape(body, state, rigid, i);
        if (status != PLI_OK) {
            state->count = before;
            return status;
        }
    }
    if (state->count > before) { plii_rigid_touch(rigid); }
    return PLI_OK;
}

// ------------------------------------------------------------------------------------------- clusters against clusters

static bool cluster_contacts_reserve_search(pli_body* body, plii_cluster_contacts* state) {
    const int count = plii_body_clusters(body)->count;
    return PLII_RESERVE(body->context, &state->boxes, &state->box_capacity, count) &&
           PLII_RESERVE(body->context, &state->candidates, &state->candidate_capacity, count) &&
           (count <= CLUSTER_CONTACTS_FEW ? plii_near_boxes_reserve(body->context, &state->near_boxes, count)
                                          : plii_box_tree_reserve(body->context, &state->tree, count));
}

static bool cluster_contacts_update_tree(pli_body* body, plii_cluster_contacts* state) {
    if (state->has_tree) { return true; }
    const plii_clusters* clusters = plii_body_clusters(body);
    if (!cluster_contacts_reserve_search(body, state)) { return false; }
    for (int i = 0; i < clusters->count; ++i) {
        const plii_cluster* cluster = &clusters->items[i];
        const pli_bounds nothing = {body->bounds.min, body->bounds.min};
        state->boxes[i] = cluster->settings.collides ? cluster->bounds : nothing;
    }
    state->has_tree = clusters->count <= CLUSTER_CONTACTS_FEW
                          ? plii_near_boxes_build(body->context, &state->near_boxes, clusters->count, state->boxes)
                          : plii_box_tree_build(body->context, &state->tree, clusters->count, state->boxes);
    return state->has_tree;
}

static void cluster_contacts_visit(int item, void* user) {
    plii_cluster_contacts* state = user;
    state->candidates[state->candidate_count++] = item;
}

/* Clusters of a body near a box, ascending. */
static void cluster_contacts_find(const plii_clusters* clusters, plii_cluster_contacts* state, pli_bounds box) {
    if (clusters->count <= CLUSTER_CONTACTS_FEW) {
        state->candidate_count = plii_near_boxes_overlaps(&state->near_boxes, &box, state->candidates);
        return;
    }
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

/* Nodes of cluster `info->cluster` of `body` that lie over the other cluster, near the plane of the nearest points; the
   normal of `info` points to `body`. */
static void cluster_contacts_find_nodes_over(pli_body* body, const plii_cluster_contacts* state,
                                             const pli_cluster_contact* info, plii_cluster_hull other, float margin,
                                             near_nodes* found) {
    const plii_clusters* clusters = plii_body_clusters(body);
    const plii_cluster* item = &clusters->items[info->cluster];
    near_nodes candidates;
    near_nodes_start(&candidates, info);
    const plii_support_groups* own = &state->hulls[info->cluster];
    if (own->packed != NULL) {
        pli_vec3 points[PLII_SUPPORT_GROUPS_MIN];
        float heights[PLII_SUPPORT_GROUPS_MIN];
        const int count =
            plii_support_groups_find_below(own, info->other_witness, info->normal, margin, points, heights);
        for (int i = 0; i < count; ++i) {
            near_nodes_add_beside(&candidates, (near_node){points[i], info->normal, heights[i]}, margin);
        }
    } else {
        for (int i = 0; i < item->member_count; ++i) {
            const pli_vec3 x = plii_cluster_node(body, clusters, item, i);
            const float above = pli_vec3_dot(pli_vec3_sub(x, info->other_witness), info->normal);
            if (above < margin) { near_nodes_add_beside(&candidates, (near_node){x, info->normal, above}, margin); }
        }
    }
    for (int i = 1; i < candidates.count; ++i) {
        const near_node* node = &candidates.kept[i];
        if (cluster_contacts_is_near_hull(node->point, &other, info->other_witness, margin)) {
            near_nodes_add_beside(found, *node, margin);
        }
    }
}

static pli_status cluster_contacts_measure_pair(met_pair* pair, plii_cluster_contacts* other_state,
                                                pli_cluster_contact info, const plii_contact_terms* terms,
                                                plii_convex_cache* cache) {
    pli_body* body = pair->body;
    plii_cluster_contacts* state = pair->state;
    if (!plii_cluster_contacts_measure_cluster(body, state, other_state, cache, terms->margin, &info)) {
        return PLI_OK;
    }
    PLII_TRY(cluster_contacts_add(pair, &info, terms));
    pli_body* other = info.other;
    const plii_cluster* cluster = &plii_body_clusters(body)->items[info.cluster];
    const plii_cluster* other_cluster = &plii_body_clusters(other)->items[info.other_cluster];
    const bool is_small =
        cluster->member_count < CLUSTER_CONTACTS_MIN_NODES || other_cluster->member_count < CLUSTER_CONTACTS_MIN_NODES;
    if (is_small || cluster_contacts_are_as_reference(body, &info) || state->def.distance != NULL) { return PLI_OK; }

    const pli_vec3 origin = cluster->frame.origin;
    near_nodes found;
    near_nodes_start(&found, &info);
    cluster_contacts_find_nodes_over(body, state, &info,
                                     plii_cluster_contacts_hull(other, other_state, info.other_cluster, origin),
                                     terms->margin, &found);
    PLII_TRY(near_nodes_add_contacts(pair, info, &found, 1, terms));
    /* The same seen from the other side. */
    const pli_cluster_contact reverse = {.cluster = info.other_cluster,
                                         .witness = info.other_witness,
                                         .other_witness = info.witness,
                                         .normal = pli_vec3_neg(info.normal),
                                         .distance = info.distance};
    near_nodes found_other;
    near_nodes_start(&found_other, &reverse);
    cluster_contacts_find_nodes_over(other, other_state, &reverse,
                                     plii_cluster_contacts_hull(body, state, info.cluster, origin), terms->margin,
                                     &found_other);
    for (int i = 1; i < found_other.count; ++i) {
        const near_node* node = &found_other.kept[i];
        pli_cluster_contact turned = info;
        turned.other_witness = node->point;
        turned.distance = node->distance;
        turned.witness = pli_vec3_add(node->point, pli_vec3_scale(info.normal, node->distance));
        PLII_TRY(cluster_contacts_add(pair, &turned, terms));
    }
    return PLI_OK;
}

static pli_status cluster_contacts_meet_cluster(pli_body* body, plii_cluster_contacts* state,
                                                plii_cluster_contacts* other_state, const pli_cluster_contact* pair,
                                                const plii_contact_terms* terms) {
    const known_pair known =
        cluster_contacts_recall(body, state, (plii_pair_key){pair->cluster, pair->other_cluster, pair->other, 0});
    if (cluster_contacts_follow(body, state, known, pair, (const plii_contact_terms[2]){*terms, *terms}, NULL)) {
        return PLI_OK;
    }
    met_pair met;
    met_pair_start(&met, body, state);
    const int first = state->count;
    PLII_TRY(cluster_contacts_measure_pair(&met, other_state, *pair, terms, known_pair_cache(known)));
    cluster_contacts_keep(body, state, known, first, NULL, terms->margin);
    return PLI_OK;
}

pli_status plii_cluster_contacts_collide_body(pli_body* body, void* data, pli_body* other, void* other_data) {
    plii_cluster_contacts *state = data, *other_state = other_data;
    if (!state->def.with_bodies || !other_state->def.with_bodies) { return PLI_OK; }
    if (!plii_cluster_contacts_update_groups(body, state) || !plii_cluster_contacts_update_groups(other, other_state) ||
        !cluster_contacts_update_tree(other, other_state)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    plii_clusters *clusters = state->clusters, *other_clusters = other_state->clusters;
    const plii_contact_terms terms = {
        .margin = body->collision_margin + other->collision_margin,
        .friction = plii_min(state->def.friction, other_state->def.friction),
        .hardness = plii_max(state->def.soft_hardness, other_state->def.soft_hardness),
        .split = (state->def.soft_split + other_state->def.soft_split) / 2.0f,
    };
    /* Bullet's stored boxes are searched as they are; otherwise the boxes must cover the reach of a contact. */
    const float reach = clusters->def.reference_mode ? 0.0f : terms.margin;
    const int before = state->count;
    plii_clusters_take_frames(body, clusters, plii_bounds_grow(other->bounds, reach));
    plii_clusters_take_frames(other, other_clusters, plii_bounds_grow(body->bounds, reach));
    for (int i = 0; i < clusters->count; ++i) {
        if (!clusters->items[i].settings.collides) { continue; }
        cluster_contacts_find(other_clusters, other_state, plii_bounds_grow(clusters->items[i].bounds, reach));
        for (int k = 0; k < other_state->candidate_count; ++k) {
            const int candidate = other_state->candidates[k];
            if (!other_clusters->items[candidate].settings.collides) { continue; }
            const pli_cluster_contact pair = {.cluster = i, .other = other, .other_cluster = candidate};
            const pli_status status = cluster_contacts_meet_cluster(body, state, other_state, &pair, &terms);
            if (status != PLI_OK) {
                state->count = before;
                return status;
            }
        }
    }
    return PLI_OK;
}

// ------------------------------------------------------------------------------------------------------ own clusters

void plii_cluster_contacts_drop_neighbours(plii_cluster_contacts* state) {
    if (state->has_neighbours) { plii_edge_set_destroy(&state->neighbours); }
    state->has_neighbours = false;
}

/* Pairs that share a node, or lie within reach of each other as the body is now, never meet: the cloth would push
   itself apart. */
static bool cluster_contacts_find_neighbours(pli_body* body, plii_cluster_contacts* state) {
    const plii_clusters* clusters = plii_body_clusters(body);
    const float margin = 2.0f * body->collision_margin;
    if (!plii_cluster_contacts_update_groups(body, state) || !cluster_contacts_update_tree(body, state)) {
        return false;
    }
    size_t pairs = 0;
    for (int i = 0; i < clusters->count; ++i) {
        cluster_contacts_find(clusters, state, plii_bounds_grow(state->boxes[i], margin));
        pairs += (size_t)state->candidate_count;
    }
    if (!plii_edge_set_create(body->context, pairs, &state->neighbours)) { return false; }
    state->has_neighbours = true;
    for (int i = 0; i < clusters->count; ++i) {
        cluster_contacts_find(clusters, state, plii_bounds_grow(state->boxes[i], margin));
        for (int k = 0; k < state->candidate_count; ++k) {
            const int other = state->candidates[k];
            if (other <= i) { continue; }
            const pli_vec3 origin = clusters->items[i].frame.origin;
            const plii_cluster_hull hull_a = plii_cluster_contacts_hull(body, state, i, origin);
            const plii_cluster_hull hull_b = plii_cluster_contacts_hull(body, state, other, origin);
            const plii_convex a = plii_cluster_hull_convex(&hull_a), b = plii_cluster_hull_convex(&hull_b);
            if (plii_cluster_contacts_are_near(&a, &b, margin)) { plii_edge_set_insert(&state->neighbours, i, other); }
        }
    }
    return true;
}

pli_status plii_cluster_contacts_collide_self(pli_body* body, plii_cluster_contacts* state) {
    if (!plii_cluster_contacts_update_groups(body, state) || !cluster_contacts_update_tree(body, state) ||
        (!state->has_neighbours && !cluster_contacts_find_neighbours(body, state))) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    plii_clusters* clusters = plii_body_clusters(body);
    plii_clusters_take_frames(body, clusters, body->bounds);
    const plii_contact_terms terms = {2.0f * body->collision_margin, 0.0f, state->def.friction,
                                      state->def.soft_hardness, state->def.soft_split};
    for (int i = 0; i < clusters->count; ++i) {
        if (!clusters->items[i].settings.collides) { continue; }
        cluster_contacts_find(clusters, state, plii_bounds_grow(clusters->items[i].bounds, terms.margin));
        for (int k = 0; k < state->candidate_count; ++k) {
            const int other = state->candidates[k];
            if (other <= i || !clusters->items[other].settings.collides ||
                plii_edge_set_contains(&state->neighbours, i, other)) {
                continue;
            }
            const pli_cluster_contact pair = {.cluster = i, .other = body, .other_cluster = other};
            PLII_TRY(cluster_contacts_meet_cluster(body, state, state, &pair, &terms));
        }
    }
    return PLI_OK;
}

// --------------------------------------------------------------------------------------------------------------- room

/* Of large bodies most clusters are far from others. */
#define CLUSTER_CONTACTS_MAX_ROOM 1024 /* nodes */
/* Clusters of a pile of tori, the most that was measured, meet 10 others, with 14 contacts. */
#define CLUSTER_CONTACTS_PER_CLUSTER 12
/* With rigid bodies, where a body of few clusters lies in a heap of them. */
#define CLUSTER_CONTACTS_MORE_PAIRS 16

static int cluster_contacts_least(int a, int b) {
    return a < b ? a : b;
}

static void cluster_contacts_reserve(pli_body* body, plii_cluster_contacts* state, int contacts, int pairs) {
    pli_context* context = body->context;
    const plii_clusters* clusters = plii_body_clusters(body);
    (void)PLII_RESERVE(context, &state->contacts, &state->capacity, contacts);
    if (state->def.distance != NULL || pairs == 0) { return; }
    (void)plii_pair_memory_reserve(context, &state->memory, pairs);
    if (clusters->def.reference_mode || state->def.disable_contact_cache) { return; }
    (void)PLII_RESERVE(context, &state->manifolds, &state->manifold_capacity, pairs);
}

void plii_cluster_contacts_make_room(pli_body* body, void* data) {
    plii_cluster_contacts* state = data;
    const pli_world* world = body->world;
    const int clusters = plii_body_clusters(body)->count;
    const int nodes = cluster_contacts_least(body->node_count, CLUSTER_CONTACTS_MAX_ROOM);
    int contacts = 0, pairs = 0;
    if (state->def.with_rigids && world->rigid_count > 0) {
        contacts += cluster_contacts_least(CLUSTER_CONTACTS_PER_PAIR * clusters, nodes + nodes / 2);
        if (world->has_convex_shapes) {
            pairs += cluster_contacts_least(clusters + clusters / 2, CLUSTER_CONTACTS_MAX_ROOM) +
                     CLUSTER_CONTACTS_MORE_PAIRS;
        }
        if (world->has_other_shapes) {
            (void)PLII_RESERVE(body->context, &state->surface, &state->surface_capacity, body->node_count);
        }
    }
    if (state->def.with_self ||
        (state->def.with_bodies && plii_feature_is_shared(body, &plii_cluster_contacts_class))) {
        const int met = cluster_contacts_least(CLUSTER_CONTACTS_PER_CLUSTER * clusters, nodes);
        contacts += met;
        pairs += met;
        (void)cluster_contacts_reserve_search(body, state);
    }
    cluster_contacts_reserve(body, state, contacts, pairs);
}
