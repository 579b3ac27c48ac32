/* Contacts of a pair of clusters, or of a cluster and a rigid body, that are followed from step to step instead of
   measured anew: while the sides hardly move against each other, their points move with the frames, to first order as
   the nearest points do. As btPersistentManifold keeps contacts, but all or none. */

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
        manifold->points[manifold->count++] = (plii_manifold_point){
            pli_transform_inverse_point(a, info->witness), pli_transform_inverse_point(b, info->other_witness),
            pli_mat3_transpose_mul_vec3(b.rotation, state->contacts[i].normal), info->distance};
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

/* Where a point is now; false when it has moved too far. */
static bool manifold_move(const plii_manifold_point* point, pli_transform a, pli_transform b, float aside_limit,
                          float approach_limit, pli_cluster_contact* now) {
    now->witness = pli_transform_point(a, point->on_a);
    now->other_witness = pli_transform_point(b, point->on_b);
    now->normal = pli_mat3_mul_vec3(b.rotation, point->normal);
    const pli_vec3 gap = pli_vec3_sub(now->witness, now->other_witness);
    now->distance = pli_vec3_dot(gap, now->normal);
    const pli_vec3 aside = pli_vec3_sub(gap, pli_vec3_scale(now->normal, now->distance));
    return pli_vec3_length_squared(aside) < aside_limit * aside_limit &&
           fabsf(now->distance - point->distance) < approach_limit;
}

bool plii_cluster_manifold_update(const pli_body* body, const pli_cluster_contact* info,
                                  const plii_contact_terms terms[2], const void* key, plii_manifold* manifold,
                                  plii_cluster_contacts* state) {
    const manifold_limits* limits = manifold_limits_of(info);
    if (++manifold->age > limits->age || manifold->key != key || manifold->margin != terms[0].margin) { return false; }
    plii_cluster* cluster = &plii_body_clusters(body)->items[info->cluster];
    plii_cluster* other = info->other != NULL ? &plii_body_clusters(info->other)->items[info->other_cluster] : NULL;
    /* A frozen body takes no impulses. */
    const plii_joint_target targets[2] = {
        {.cluster = plii_body_is_idle(body) ? NULL : cluster},
        {.cluster = other == NULL || plii_body_is_idle(info->other) ? NULL : other, .rigid = info->rigid}};
    const pli_transform a = cluster->frame, b = other != NULL ? other->frame : info->rigid->state.pose;
    if (manifold_has_rotated(manifold, manifold_rotation(a, b), limits->relative_rotation)) { return false; }
    const float aside_limit = limits->aside * body->collision_margin;
    const float approach_limit = limits->approach * body->collision_margin;
    pli_cluster_contact now[PLII_MANIFOLD_POINTS];
    for (int i = 0; i < manifold->count; ++i) {
        now[i] = *info;
        if (!manifold_move(&manifold->points[i], a, b, aside_limit, approach_limit, &now[i])) { return false; }
    }
    for (int i = 0; i < manifold->count; ++i) {
        const plii_contact_terms* used = &terms[i > 0 ? 1 : 0];
        if (!(now[i].distance < used->margin)) { continue; }
        plii_cluster_contact_set(&state->contacts[state->count++], &now[i], now[i].normal, targets, a.origin, b.origin,
                                 used);
    }
    return true;
}
