/* Contacts of a pair of clusters, or of a cluster and a rigid body, that are followed from step to step instead of
   measured anew: while the sides hardly move against each other, their points move with the frames, to first order as
   the nearest points do. As btPersistentManifold keeps contacts, but all or none. */

#include "cluster_contacts_impl.h"

/* How long and how far a pair is followed. */
typedef struct manifold_limits {
    int age;               /* steps */
    float aside, approach; /* of the margin: how far a point may move along the other side, and along the normal */
    float turn;            /* square of the angle that the sides may turn against each other, rad^2 */
} manifold_limits;

/* Against rigid bodies less: bodies that lie on plates came to rest later with the limits of two clusters. */
static const manifold_limits manifold_rigid_limits = {12, 0.3f, 0.42f, 0.0025f};
static const manifold_limits manifold_soft_limits = {20, 0.5f, 0.42f, 0.006f};

static const manifold_limits* manifold_limits_of(const pli_cluster_contact* info) {
    return info->other != NULL ? &manifold_soft_limits : &manifold_rigid_limits;
}

static pli_transform manifold_other_frame(const pli_cluster_contact* info) {
    return info->other != NULL ? plii_body_clusters(info->other)->items[info->other_cluster].frame
                               : info->rigid->state.pose;
}

static pli_mat3 manifold_turn(pli_transform a, pli_transform b) {
    return pli_mat3_mul(pli_mat3_transpose(b.rotation), a.rotation);
}

void plii_cluster_manifold_keep(const pli_body* body, const plii_cluster_contacts* state, int first, const void* key,
                                float margin, plii_manifold* manifold) {
    manifold->count = 0;
    const pli_cluster_contact* pair = &state->contacts[first].info;
    const pli_transform a = plii_body_clusters(body)->items[pair->cluster].frame, b = manifold_other_frame(pair);
    for (int i = first; i < state->count; ++i) {
        const pli_cluster_contact* info = &state->contacts[i].info;
        manifold->points[manifold->count++] = (plii_manifold_point){
            .on_a = pli_transform_inverse_point(a, info->witness),
            .on_b = pli_transform_inverse_point(b, info->other_witness),
            .normal = pli_mat3_transpose_mul_vec3(b.rotation, state->contacts[i].normal),
            .distance = info->distance,
        };
    }
    manifold->turn = manifold_turn(a, b);
    manifold->key = key;
    manifold->margin = margin;
    /* Not all pairs of a pile are measured in the same step. */
    manifold->age = (pair->cluster + pair->other_cluster) % (manifold_limits_of(pair)->age / 2);
}

static bool manifold_has_turned(const plii_manifold* manifold, pli_mat3 turn, float limit) {
    float trace = 0.0f; /* 1 + 2 cos(angle) */
    for (int i = 0; i < 3; ++i) {
        trace += pli_vec3_dot(manifold->turn.rows[i], turn.rows[i]);
    }
    return !(trace > 3.0f - limit);
}

int plii_cluster_manifold_follow(const pli_body* body, const pli_cluster_contact* info, const void* key, float margin,
                                 plii_manifold* manifold, pli_cluster_contact* contacts) {
    const manifold_limits* limits = manifold_limits_of(info);
    if (++manifold->age > limits->age || manifold->key != key || manifold->margin != margin) { return 0; }
    const pli_transform a = plii_body_clusters(body)->items[info->cluster].frame, b = manifold_other_frame(info);
    if (manifold_has_turned(manifold, manifold_turn(a, b), limits->turn)) { return 0; }
    const float aside_limit = limits->aside * body->collision_margin;
    const float approach_limit = limits->approach * body->collision_margin;
    for (int i = 0; i < manifold->count; ++i) {
        const plii_manifold_point* point = &manifold->points[i];
        pli_cluster_contact* contact = &contacts[i];
        *contact = *info;
        contact->witness = pli_transform_point(a, point->on_a);
        contact->other_witness = pli_transform_point(b, point->on_b);
        contact->normal = pli_mat3_mul_vec3(b.rotation, point->normal);
        const pli_vec3 gap = pli_vec3_sub(contact->witness, contact->other_witness);
        contact->distance = pli_vec3_dot(gap, contact->normal);
        const pli_vec3 aside = pli_vec3_sub(gap, pli_vec3_scale(contact->normal, contact->distance));
        const float moved = fabsf(contact->distance - point->distance);
        if (!(pli_vec3_length_squared(aside) < aside_limit * aside_limit && moved < approach_limit)) { return 0; }
    }
    return manifold->count;
}
