/* Contacts of a pair of clusters, or of a cluster and a rigid body, that are followed from step to step instead of
   measured anew: while the sides hardly move against each other, their points move with the frames, to first order as
   the nearest points do. As btPersistentManifold keeps contacts, but all or none. */

#include "math/simd_float4.h"

#include "cluster/cluster_contacts_impl.h"

/* How long and how far a pair is followed. */
typedef struct manifold_limits {
    int age;                 /* steps */
    float aside, approach;   /* of the margin: how far a point may move along the other side, and along the normal */
    float relative_rotation; /* square of the angle that the sides may turn against each other, rad^2 */
} manifold_limits;

/* Against rigid bodies less: bodies that lie on plates came to rest later with the limits of two clusters. */
static const manifold_limits manifold_rigid_limits = {12, 0.3f, 0.42f, 0.0025f};
static const manifold_limits manifold_soft_limits = {20, 0.5f, 0.42f, 0.006f};

static const manifold_limits* manifold_limits_of(const pli_cluster_contact* info) {
    return info->other != NULL ? &manifold_soft_limits : &manifold_rigid_limits;
}

static pli_mat3 manifold_rotation(pli_transform a, pli_transform b) {
    return pli_mat3_mul(pli_mat3_transpose(b.rotation), a.rotation);
}

void plii_cluster_manifold_keep(const pli_body* body, const plii_cluster_contacts* state, int first, const void* key,
                                float margin, plii_manifold* manifold) {
    manifold->count = 0;
    const pli_cluster_contact* pair = &state->contacts[first].info;
    const pli_transform a = plii_body_clusters(body)->items[pair->cluster].frame;
    const pli_transform b = pair->other != NULL ? plii_body_clusters(pair->other)->items[pair->other_cluster].frame
                                                : pair->rigid->state.pose;
    for (int i = first; i < state->count; ++i) {
        const pli_cluster_contact* info = &state->contacts[i].info;
        plii_manifold_points* points = &manifold->points[manifold->count / PLII_LANES];
        const int lane = manifold->count++ % PLII_LANES;
        plii_group_vec3_set(&points->on_a, lane, pli_transform_inverse_point(a, info->witness));
        plii_group_vec3_set(&points->on_b, lane, pli_transform_inverse_point(b, info->other_witness));
        plii_group_vec3_set(&points->normals, lane, pli_mat3_transpose_mul_vec3(b.rotation, state->contacts[i].normal));
        points->distances[lane] = info->distance;
    }
    manifold->relative_rotation = manifold_rotation(a, b);
    manifold->key = key;
    manifold->margin = margin;
    /* Not all pairs of a pile are measured in the same step. */
    manifold->age = (pair->cluster + pair->other_cluster) % (manifold_limits_of(pair)->age / 2);
}

static bool manifold_has_rotated(const plii_manifold* manifold, pli_mat3 relative_rotation, float limit) {
    float trace = 0.0f; /* 1 + 2 cos(angle) */
    for (int i = 0; i < 3; ++i) {
        trace += pli_vec3_dot(manifold->relative_rotation.rows[i], relative_rotation.rows[i]);
    }
    return !(trace > 3.0f - limit);
}

/* Where the points of a pair are now. */
typedef struct manifold_points {
    pli_vec3 witnesses[2 * PLII_LANES], other_witnesses[2 * PLII_LANES], normals[2 * PLII_LANES];
    float distances[2 * PLII_LANES];
} manifold_points;

static plii_vec3x4 manifold_rotate_all(const pli_mat3* rotation, plii_vec3x4 v) {
    return (plii_vec3x4){plii_vec3x4_dot(plii_vec3x4_all(rotation->rows[0]), v),
                         plii_vec3x4_dot(plii_vec3x4_all(rotation->rows[1]), v),
                         plii_vec3x4_dot(plii_vec3x4_all(rotation->rows[2]), v)};
}
static plii_vec3x4 manifold_transform_all(const pli_transform* frame, plii_vec3x4 v) {
    return plii_vec3x4_add(manifold_rotate_all(&frame->rotation, v), plii_vec3x4_all(frame->origin));
}

/* Four points; returns the bits of those that have moved too far. */
static int manifold_move(const plii_manifold_points* points, const pli_transform* a, const pli_transform* b,
                         float aside_limit, float approach_limit, int first, manifold_points* now) {
    const plii_vec3x4 witness = manifold_transform_all(a, plii_group_vec3_load(&points->on_a));
    const plii_vec3x4 other = manifold_transform_all(b, plii_group_vec3_load(&points->on_b));
    const plii_vec3x4 normal = manifold_rotate_all(&b->rotation, plii_group_vec3_load(&points->normals));
    const plii_vec3x4 gap = plii_vec3x4_sub(witness, other);
    const plii_float4 distance = plii_vec3x4_dot(gap, normal);
    const plii_vec3x4 aside = plii_vec3x4_sub(gap, plii_vec3x4_scale(normal, distance));
    const plii_float4 moved = plii_float4_sub(distance, plii_float4_load(points->distances));
    plii_vec3x4_to(&now->witnesses[first], witness);
    plii_vec3x4_to(&now->other_witnesses[first], other);
    plii_vec3x4_to(&now->normals[first], normal);
    plii_float4_store(&now->distances[first], distance);
    const plii_mask4 stays = plii_lanes_both(
        plii_lanes_less(plii_vec3x4_dot(aside, aside), plii_float4_all(aside_limit * aside_limit)),
        plii_lanes_less(plii_float4_mul(moved, moved), plii_float4_all(approach_limit * approach_limit)));
    return ~plii_lanes_bits(stays);
}

bool plii_cluster_manifold_update(const pli_body* body, const pli_cluster_contact* info,
                                  const plii_contact_terms terms[2], const void* key, plii_manifold* manifold,
                                  plii_cluster_contacts* state) {
    const manifold_limits* limits = manifold_limits_of(info);
    if (++manifold->age > limits->age || manifold->key != key || manifold->margin != terms[0].margin) { return false; }
    plii_cluster* cluster = &state->clusters->items[info->cluster];
    plii_cluster* other = info->other != NULL ? &plii_body_clusters(info->other)->items[info->other_cluster] : NULL;
    /* A frozen body takes no impulses. */
    const plii_joint_target targets[2] = {
        {.cluster = body->is_frozen ? NULL : cluster},
        {.cluster = other == NULL || info->other->is_frozen ? NULL : other, .rigid = info->rigid}};
    const pli_transform a = cluster->frame, b = other != NULL ? other->frame : info->rigid->state.pose;
    if (manifold_has_rotated(manifold, manifold_rotation(a, b), limits->relative_rotation)) { return false; }
    const float aside_limit = limits->aside * body->collision_margin;
    const float approach_limit = limits->approach * body->collision_margin;
    manifold_points now;
    for (int first = 0; first < manifold->count; first += PLII_LANES) {
        const int left = manifold->count - first;
        const int used = left < PLII_LANES ? (1 << left) - 1 : (1 << PLII_LANES) - 1;
        if ((manifold_move(&manifold->points[first / PLII_LANES], &a, &b, aside_limit, approach_limit, first, &now) &
             used) != 0) {
            return false;
        }
    }
    pli_cluster_contact moved = *info;
    for (int i = 0; i < manifold->count; ++i) {
        const plii_contact_terms* used = &terms[i > 0 ? 1 : 0];
        if (!(now.distances[i] < used->margin)) { continue; }
        moved.witness = now.witnesses[i];
        moved.other_witness = now.other_witnesses[i];
        moved.normal = now.normals[i];
        moved.distance = now.distances[i];
        plii_cluster_contact_set(&state->contacts[state->count++], &moved, moved.normal, targets, a.origin, b.origin,
                                 used);
    }
    return true;
}
