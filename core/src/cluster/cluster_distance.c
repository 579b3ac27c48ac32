/* Distances of clusters from rigid shapes and from each other, by the user's function or by that of the core. */

#include "cluster/cluster_contacts_impl.h"
#include "geometry/convex_distance.h"
#include "math/bounds.h"
#include "shape/shape_impl.h"

/* Of the distance: contacts need no more, and round shapes take twice as many steps to the usual one. */
#define CLUSTER_CONTACTS_GAP 1e-4
#define CLUSTER_CONTACTS_NODE_GAP 1e-3f /* of the margin: how exact the answer of the deepest node must be */
#define CLUSTER_CONTACTS_SAME_AXIS 0.9f /* cosine of how far the direction out of an overlap may turn */
#define CLUSTER_CONTACTS_UNIT 1e-3f     /* of a squared length: what counts as a unit vector */

/* How far four members reach along a direction, from `first` on; the first of all where there are no more. */
PLII_SIMD_INLINE plii_float4 cluster_hull_along(const plii_cluster_hull* hull, int first, plii_vec3x4 direction) {
    const pli_vec4* positions = hull->body->positions;
    const plii_cluster_member* members = hull->members;
    const int left = hull->cluster->member_count - first;
    const plii_vec3x4 four = plii_vec3x4_of(plii_float4_from(&positions[members[first].node]),
                                            plii_float4_from(&positions[members[left > 1 ? first + 1 : 0].node]),
                                            plii_float4_from(&positions[members[left > 2 ? first + 2 : 0].node]),
                                            plii_float4_from(&positions[members[left > 3 ? first + 3 : 0].node]));
    return plii_vec3x4_dot(four, direction);
}

/* The first of the farthest members: each lane keeps the first of its farthest. Indices are counted in floats, and
   nothing branches: which lane has the farthest node is anybody's guess. */
static pli_vec3 cluster_hull_support(const void* user, pli_vec3 direction) {
    const plii_cluster_hull* hull = user;
    const plii_vec3x4 along = plii_vec3x4_all(direction);
    plii_float4 index = plii_lanes_xyzw(0, 1, 2, 3), best = plii_float4_all(-INFINITY), found = index;
    for (int first = 0; first < hull->cluster->member_count; first += PLII_LANES) {
        const plii_float4 reach = cluster_hull_along(hull, first, along);
        found = plii_lanes_select(best < reach, index, found);
        best = plii_lanes_max(reach, best);
        index += (float)PLII_LANES;
    }
    const plii_float4 farthest = plii_float4_all(plii_lanes_largest(best));
    const int member = (int)plii_lanes_least(plii_lanes_select(best < farthest, plii_float4_all(INFINITY), found));
    return pli_vec3_sub(plii_xyz(hull->body->positions[hull->members[member].node]), hull->origin);
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

plii_cluster_hull plii_cluster_hull_of(const pli_body* body, int cluster, pli_vec3 origin) {
    const plii_cluster* item = &body->clusters->items[cluster];
    return (plii_cluster_hull){body, item, plii_cluster_members(body, item), origin};
}

/* How far the hull, from its origin, lies beyond the core along a direction out of this. */
static float cluster_hull_gap(const plii_cluster_hull* soft, const rigid_hull* hard, pli_vec3 direction) {
    const pli_vec3 inwards = pli_vec3_neg(direction);
    const plii_vec3x4 along = plii_vec3x4_all(inwards);
    plii_float4 best = plii_float4_all(-INFINITY);
    for (int first = 0; first < soft->cluster->member_count; first += PLII_LANES) {
        best = plii_lanes_max(cluster_hull_along(soft, first, along), best);
    }
    const float reach = plii_lanes_largest(best) - pli_vec3_dot(soft->origin, inwards);
    return -reach - pli_vec3_dot(rigid_hull_support(hard, direction), direction);
}

plii_convex plii_cluster_hull_convex(const plii_cluster_hull* hull) {
    return (plii_convex){.support = cluster_hull_support,
                         .user = hull,
                         .centre = pli_vec3_sub(hull->cluster->frame.origin, hull->origin)};
}

static bool cluster_contacts_measure(const plii_cluster_contacts* state, const plii_convex* a, const plii_convex* b,
                                     pli_vec3 origin, plii_convex_cache* cache, float max_distance,
                                     pli_cluster_contact* info) {
    plii_convex_options options = {.max_distance = max_distance};
    if (!state->def.disable_contact_cache) {
        options.gap = CLUSTER_CONTACTS_GAP;
        options.uses_cached_axis = true;
    }
#if PLIANT_WITH_CCD
    options.penetration = state->def.accurate_penetration ? plii_penetration_epa : NULL;
#endif
    plii_convex_result result;
    plii_convex_distance(a, b, &options, cache, &result);
    const bool is_known = result.relation == PLII_CONVEX_SEPARATED || result.relation == PLII_CONVEX_OVERLAPPING;
    if (!is_known || !(result.distance < max_distance)) { return false; }
    info->witness = pli_vec3_add(result.point_a, origin);
    info->other_witness = pli_vec3_add(result.point_b, origin);
    info->normal = result.normal;
    info->distance = result.distance;
    return true;
}

bool plii_cluster_contacts_are_near(const plii_convex* a, const plii_convex* b, float margin) {
    const plii_gjk_query query = {.a = a,
                                  .b = b,
                                  .max_distance = (double)margin,
                                  .enough = (double)margin,
                                  .max_support_calls = PLII_CONVEX_MAX_SUPPORT_CALLS};
    plii_gjk_result result;
    plii_gjk_run(&query, NULL, &result);
    return result.relation == PLII_CONVEX_OVERLAPPING ||
           (result.relation == PLII_CONVEX_SEPARATED && result.distance < (double)margin);
}

static pli_vec3 cluster_point_support(const void* user, pli_vec3 direction) {
    return *(const pli_vec3*)user;
}

bool plii_cluster_hull_is_near(pli_vec3 point, const plii_cluster_hull* hull, float margin) {
    if (!plii_bounds_overlap(plii_bounds_grow(hull->cluster->bounds, margin), (pli_bounds){point, point})) {
        return false;
    }
    point = pli_vec3_sub(point, hull->origin);
    const plii_convex a = {.support = cluster_point_support, .user = &point, .centre = point};
    const plii_convex b = plii_cluster_hull_convex(hull);
    return plii_cluster_contacts_are_near(&a, &b, margin);
}

pli_vec3 plii_cluster_contacts_rigid_point(const pli_shape* shape, pli_transform pose, pli_vec3 direction) {
    return rigid_hull_support(&(const rigid_hull){shape, pose}, direction);
}

void plii_cluster_contacts_measure_nodes(const pli_body* body, const plii_cluster_contacts* state,
                                         const pli_cluster_contact* info, int first, plii_measured_nodes* nodes) {
    const pli_shape* shape = info->rigid->shapes[info->shape];
    const plii_cluster* cluster = &body->clusters->items[info->cluster];
    const int rest = cluster->member_count - first;
    const int count = rest < PLII_MEASURED_NODES ? rest : PLII_MEASURED_NODES;
    pli_vec3 points[PLII_MEASURED_NODES];
    const plii_cluster_member* members = plii_cluster_members(body, cluster) + first;
    for (int i = 0; i < count; ++i) {
        points[i] = pli_transform_inverse_point(state->shape_pose, plii_xyz(body->positions[members[i].node]));
    }
    shape->def.distances(shape->def.user, count, points, body->collision_margin, nodes->distances, nodes->normals);
    nodes->count = count;
}

/* Whether two sides are near enough. */
typedef enum near_answer { NEAR_YES, NEAR_NO, NEAR_UNKNOWN } near_answer;

/* Where core and hull end along the normal of the hull's deepest node, no more apart than that node is, it is the
   nearest point: no point of the hull is nearer along any other direction. Both are given from the hull's origin. */
static near_answer cluster_contacts_measure_deepest(const pli_body* body, const plii_cluster_contacts* state,
                                                    const plii_cluster_hull* soft, const rigid_hull* hard,
                                                    float max_distance, plii_convex_cache* cache,
                                                    pli_cluster_contact* info, plii_measured_nodes* nodes) {
    if (soft->cluster->member_count > PLII_MEASURED_NODES) { return NEAR_UNKNOWN; }
    plii_cluster_contacts_measure_nodes(body, state, info, 0, nodes);
    int deepest = 0;
    for (int i = 1; i < nodes->count; ++i) {
        if (nodes->distances[i] < nodes->distances[deepest]) { deepest = i; }
    }
    const pli_vec3 n = pli_mat3_mul_vec3(hard->pose.rotation, nodes->normals[deepest]);
    if (!(fabsf(pli_vec3_length_squared(n) - 1.0f) < CLUSTER_CONTACTS_UNIT)) { return NEAR_UNKNOWN; }
    const float gap = cluster_hull_gap(soft, hard, n);
    if (gap > max_distance) {
        if (cache != NULL) {
            cache->directions[0] = n;
            cache->count = 1;
        }
        return NEAR_NO;
    }
    const float distance = nodes->distances[deepest] + hard->shape->def.radius;
    if (!(distance < max_distance && distance - gap <= CLUSTER_CONTACTS_NODE_GAP * body->collision_margin)) {
        return NEAR_UNKNOWN;
    }
    /* Out where it came in, though the other side may have become nearer. */
    if (distance < 0.0f && cache != NULL && cache->has_normal &&
        !(pli_vec3_dot(n, cache->normal) > CLUSTER_CONTACTS_SAME_AXIS)) {
        return NEAR_UNKNOWN;
    }
    info->witness = plii_xyz(body->positions[soft->members[deepest].node]);
    info->other_witness = pli_vec3_sub(info->witness, pli_vec3_scale(n, distance));
    info->normal = n;
    info->distance = distance;
    if (cache != NULL) {
        cache->normal = n;
        cache->has_normal = true;
    }
    return NEAR_YES;
}

bool plii_cluster_contacts_measure_rigid(pli_body* body, plii_cluster_contacts* state, plii_convex_cache* cache,
                                         float max_distance, pli_cluster_contact* info, plii_measured_nodes* nodes) {
    if (state->def.distance != NULL) { return state->def.distance(body, info, state->def.distance_user); }
    const pli_shape* shape = info->rigid->shapes[info->shape];
    const pli_vec3 origin = body->clusters->items[info->cluster].frame.origin;
    const plii_cluster_hull soft = plii_cluster_hull_of(body, info->cluster, origin);
    rigid_hull hard = {shape, state->shape_pose};
    hard.pose.origin = pli_vec3_sub(hard.pose.origin, origin);
    /* Most pairs that are too far apart were so before, in a direction that still may show it. */
    const bool is_known = !state->def.disable_contact_cache && cache != NULL && cache->count == 1;
    if (is_known && cluster_hull_gap(&soft, &hard, cache->directions[0]) > max_distance) { return false; }
    if (!state->def.disable_contact_cache && !body->clusters->def.reference_mode) {
        const near_answer answer =
            cluster_contacts_measure_deepest(body, state, &soft, &hard, max_distance, cache, info, nodes);
        if (answer != NEAR_UNKNOWN) { return answer == NEAR_YES; }
    }
    const plii_convex a = plii_cluster_hull_convex(&soft);
    const plii_convex b = {.support = rigid_hull_support, .user = &hard, .centre = hard.pose.origin};
    return cluster_contacts_measure(state, &a, &b, origin, cache, max_distance, info);
}

bool plii_cluster_contacts_measure_cluster(pli_body* body, plii_cluster_contacts* state, plii_convex_cache* cache,
                                           float max_distance, pli_cluster_contact* info) {
    if (state->def.distance != NULL) { return state->def.distance(body, info, state->def.distance_user); }
    const pli_vec3 origin = body->clusters->items[info->cluster].frame.origin;
    const plii_cluster_hull hull_a = plii_cluster_hull_of(body, info->cluster, origin);
    const plii_cluster_hull hull_b = plii_cluster_hull_of(info->other, info->other_cluster, origin);
    const plii_convex a = plii_cluster_hull_convex(&hull_a), b = plii_cluster_hull_convex(&hull_b);
    return cluster_contacts_measure(state, &a, &b, origin, cache, max_distance, info);
}
