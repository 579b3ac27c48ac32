/* What is known of pairs from step to step, and the contacts that they get. Contacts of clusters with each other or
   with rigid bodies are followed instead of measured anew: while the sides hardly move against each other, their points
   move with the frames, to first order as the nearest points do. As btPersistentManifold, but all or none. */

#include "cluster/cluster_contacts_pair.h"

// ------------------------------------------------------------------------------------------------------ one contact

/* As Bullet (SolveContact, CJoint, in their order of operations) every iteration adds a share of the correction and of
   the sliding velocity; contacts that are not in reference mode are solved as rows (cluster_contact_batches.c). */

/* Share of the margin that contacts may be too deep, so that bodies at rest keep them. */
#define CLUSTER_CONTACT_SLOP 0.05f

/* Distances may come from the user. */
static bool cluster_contact_is_usable(const pli_cluster_contact* info) {
    const float far = 4.0f * PLI_MAX_COORDINATE;
    return plii_is_within(info->distance, far) && plii_vec3_is_within(info->witness, far) &&
           plii_vec3_is_within(info->other_witness, far) && plii_vec3_is_within(info->normal, far) &&
           pli_vec3_length_squared(info->normal) > FLT_MIN;
}

static pli_vec3 cluster_contact_velocity(const plii_cluster_contact* contact) {
    return pli_vec3_sub(plii_joint_velocity_at(&contact->targets[0], contact->arms[0]),
                        plii_joint_velocity_at(&contact->targets[1], contact->arms[1]));
}

static void cluster_contact_set_as_reference(plii_cluster_contact* contact, const plii_joint_end sides[2],
                                             const plii_contact_terms* terms) {
    contact->reference_mode = true;
    contact->arms[0] = pli_vec3_sub(contact->info.witness, sides[0].frame.origin);
    contact->arms[1] = pli_vec3_sub(contact->info.other_witness, sides[1].frame.origin);
    const pli_vec3 velocity = cluster_contact_velocity(contact);
    const float approach = pli_vec3_dot(velocity, contact->normal);
    const pli_vec3 sliding = pli_vec3_sub(velocity, pli_vec3_scale(contact->normal, approach));
    const float cone = approach * terms->friction * approach * terms->friction;
    contact->as.reference = (plii_cluster_contact_as_reference){
        .friction = pli_vec3_length_squared(sliding) < cone ? 1.0f : terms->friction,
        .drift = pli_vec3_scale(contact->normal, contact->info.distance - terms->margin),
        .erp = terms->hardness,
        .split = terms->split,
        .impulse_matrix = plii_joint_impulse_matrix(&sides[0], contact->arms[0], &sides[1], contact->arms[1])};
}

/* One that is not in reference mode; `normal` is a unit vector. */
static void cluster_contact_set(plii_cluster_contact* contact, const pli_cluster_contact* info, pli_vec3 normal,
                                const plii_joint_target targets[2], pli_vec3 centre, pli_vec3 other_centre,
                                const plii_contact_terms* terms) {
    contact->info = *info;
    contact->targets[0] = targets[0];
    contact->targets[1] = targets[1];
    contact->normal = normal;
    contact->is_self = contact->reference_mode = false;
    /* Bullet acts on the cores, at two points: friction between them would make angular momentum. */
    const pli_vec3 surface = pli_vec3_add(info->other_witness, pli_vec3_scale(normal, terms->radius));
    const pli_vec3 point = pli_vec3_lerp(info->witness, surface, 0.5f);
    contact->arms[0] = pli_vec3_sub(point, centre);
    contact->arms[1] = pli_vec3_sub(point, other_centre);
    const float depth = terms->margin - info->distance - CLUSTER_CONTACT_SLOP * (terms->margin - terms->radius);
    const pli_vec3 turning = pli_vec3_cross(terms->velocity.angular, contact->arms[1]);
    contact->other_speed = pli_vec3_dot(pli_vec3_add(terms->velocity.linear, turning), normal);
    contact->as.terms = (pli_vec4){depth * terms->inverse_dt, terms->hardness, terms->split, terms->friction};
}

void plii_cluster_contact_prepare(plii_cluster_contact* contact, float dt, int iterations) {
    plii_cluster_contact_as_reference* state = &contact->as.reference;
    state->drift = plii_vec3_divide(pli_vec3_scale(state->drift, state->erp), dt);
    if (state->split > 0.0f) {
        state->split_drift = pli_mat3_mul_vec3(state->impulse_matrix, pli_vec3_scale(state->drift, state->split));
        state->drift = pli_vec3_scale(state->drift, 1.0f - state->split);
    }
    state->drift = plii_vec3_divide(state->drift, (float)iterations);
}

void plii_cluster_contact_solve(plii_cluster_contact* contact) {
    const pli_vec3 velocity = cluster_contact_velocity(contact);
    const float approach = pli_vec3_dot(velocity, contact->normal);
    pli_vec3 change = contact->as.reference.drift;
    if (approach < 0.0f) {
        const pli_vec3 closing = pli_vec3_scale(contact->normal, approach);
        const pli_vec3 sliding = pli_vec3_sub(velocity, closing);
        change = pli_vec3_add(change, pli_vec3_add(closing, pli_vec3_scale(sliding, contact->as.reference.friction)));
    }
    const pli_vec3 impulse = pli_mat3_mul_vec3(contact->as.reference.impulse_matrix, change);
    plii_joint_apply(&contact->targets[0], pli_vec3_neg(impulse), contact->arms[0], false);
    plii_joint_apply(&contact->targets[1], impulse, contact->arms[1], false);
}

void plii_cluster_contact_finish(plii_cluster_contact* contact) {
    if (!(contact->as.reference.split > 0.0f)) { return; }
    const pli_vec3 drift = contact->as.reference.split_drift;
    plii_joint_apply(&contact->targets[0], pli_vec3_neg(drift), contact->arms[0], true);
    plii_joint_apply(&contact->targets[1], drift, contact->arms[1], true);
}

// ------------------------------------------------------------------------------------------------- what is followed

/* How long and how far a pair is followed. */
typedef struct manifold_limits {
    int age;                 /* steps */
    float aside, approach;   /* of the margin: how far a point may move along the other side, and along the normal */
    float relative_rotation; /* square of the angle that the sides may turn against each other, rad^2 */
} manifold_limits;

/* Against rigid bodies, the first, less: what lies on plates came to rest later with the limits of two clusters. */
static const manifold_limits manifold_limits_by_kind[2] = {{12, 0.3f, 0.42f, 0.0025f}, {20, 0.5f, 0.42f, 0.006f}};
#define MANIFOLD_TILT 0.15f /* of the margin: how far that may move the ends of a cluster on what stays where it is */

static pli_mat3 manifold_rotation(pli_transform a, pli_transform b) {
    return pli_mat3_mul(pli_mat3_transpose(b.rotation), a.rotation);
}

/* Keeps contacts [first, count), up to PLII_MANIFOLD_POINTS; beside frames they depend on `key` and `margin`. */
static void manifold_keep(const pli_body* body, const plii_cluster_contacts* state, int first, const void* key,
                          float margin, plii_manifold* manifold) {
    *manifold = (plii_manifold){.key = key, .margin = margin};
    const pli_cluster_contact* pair = &state->contacts[first].info;
    const pli_transform a = body->clusters->items[pair->cluster].frame;
    const pli_transform b =
        pair->other != NULL ? pair->other->clusters->items[pair->other_cluster].frame : state->rigid_pose;
    for (int i = first; i < state->count; ++i) {
        const pli_cluster_contact* info = &state->contacts[i].info;
        manifold->points[manifold->count++] = (plii_manifold_point){
            pli_transform_inverse_point(a, info->witness), pli_transform_inverse_point(b, info->other_witness),
            pli_mat3_transpose_mul_vec3(b.rotation, state->contacts[i].normal), info->distance};
    }
    manifold->relative_rotation = manifold_rotation(a, b);
    /* Not all pairs of a pile are measured in the same step. */
    manifold->age = (pair->cluster + pair->other_cluster) % (manifold_limits_by_kind[pair->other != NULL].age / 2);
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

/* Adds the contacts of the pair that `info` names as they are now, or returns false when they have to be measured. The
   first has terms[0], the others terms[1]. There must be room for PLII_MANIFOLD_POINTS. */
static bool manifold_update(const pli_body* body, const pli_cluster_contact* info, const plii_contact_terms terms[2],
                            const void* key, const plii_manifold* manifold, plii_cluster_contacts* state) {
    const manifold_limits* limits = &manifold_limits_by_kind[info->other != NULL];
    if (manifold->age >= limits->age || manifold->key != key || manifold->margin != terms[0].margin) { return false; }
    plii_cluster* cluster = &body->clusters->items[info->cluster];
    plii_cluster* other = info->other != NULL ? &info->other->clusters->items[info->other_cluster] : NULL;
    /* A frozen body takes no impulses. */
    const plii_joint_target targets[2] = {
        {.cluster = plii_body_is_idle(body) ? NULL : cluster},
        {.cluster = other == NULL || plii_body_is_idle(info->other) ? NULL : other, .rigid = info->rigid}};
    const pli_transform a = cluster->frame, b = other != NULL ? other->frame : state->rigid_pose;
    const pli_vec3 size = pli_vec3_sub(cluster->bounds.max, cluster->bounds.min);
    const float tilt = MANIFOLD_TILT * body->collision_margin, least = tilt * tilt / pli_vec3_length_squared(size);
    /* A ball rolls on to nodes without contacts, and a body of one cluster tips over to them. */
    const bool is_whole = cluster->member_count == body->node_count;
    const bool may_roll = is_whole || (info->rigid != NULL && info->rigid->kind != PLI_RIGID_DYNAMIC);
    const float rotation_limit = may_roll ? plii_min(limits->relative_rotation, least) : limits->relative_rotation;
    if (manifold_has_rotated(manifold, manifold_rotation(a, b), rotation_limit)) { return false; }
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
        cluster_contact_set(&state->contacts[state->count++], &now[i], now[i].normal, targets, a.origin, b.origin,
                            used);
    }
    return true;
}

/* That of the last step; NULL: the pair had none. */
static const plii_manifold* manifold_before(const plii_cluster_contacts* state, const plii_pair_record* record) {
    const int index = record->previous_index;
    const int slot = index != PLI_NULL_INDEX ? state->memory.before.items[index].slot : 0;
    return slot > 0 ? &state->manifolds_before.items[slot - 1] : NULL;
}

/* For the pair of a record; NULL when out of memory. */
static plii_manifold* manifold_add(pli_body* body, plii_cluster_contacts* state, plii_pair_record* record) {
    plii_manifolds* all = &state->manifolds;
    if (!PLII_GROW(body->context, &all->items, &all->capacity, all->count)) { return NULL; }
    record->slot = all->count + 1;
    return &all->items[all->count++];
}

void plii_cluster_contacts_collide_pair(pli_body* body, plii_cluster_contacts* state, const pli_cluster_contact* info,
                                        const plii_contact_terms terms[2], plii_measure_pair_fn* measure) {
    const bool has_rigid = info->rigid != NULL;
    const pli_shape* shape = has_rigid ? info->rigid->shapes[info->shape] : NULL;
    /* Clusters of one body deform against each other too much for their contacts to be followed. */
    const bool is_followed =
        !body->clusters->def.reference_mode && !state->def.disable_contact_cache && info->other != body;
    const plii_pair_key key = {info->cluster, has_rigid ? info->shape : info->other_cluster,
                               has_rigid ? (const void*)info->rigid : (const void*)info->other, 0};
    plii_pair_record* record =
        state->def.distance == NULL ? plii_pair_cache_get(body->context, &state->memory, key) : NULL;
    const plii_manifold* before = is_followed && record != NULL ? manifold_before(state, record) : NULL;
    const int first = state->count;
    if (before != NULL &&
        PLII_RESERVE(body->context, &state->contacts, &state->capacity, first + PLII_MANIFOLD_POINTS) &&
        manifold_update(body, info, terms, shape, before, state)) {
        plii_manifold* manifold = manifold_add(body, state, record);
        if (manifold == NULL) { return; } /* measured anew in the next step */
        *manifold = *before;
        manifold->age += 1;
        return;
    }
    plii_pair_context pair = plii_pair_context_of(body, state);
    measure(&pair, *info, terms, record != NULL ? &record->cache : NULL);
    const int count = state->count - first;
    if (!is_followed || record == NULL || count == 0 || count > PLII_MANIFOLD_POINTS) { return; }
    plii_manifold* manifold = manifold_add(body, state, record);
    if (manifold != NULL) { manifold_keep(body, state, first, shape, terms[0].margin, manifold); }
}

void plii_cluster_contacts_begin_step(pli_body* body, void* data) {
    plii_cluster_contacts* state = data;
    state->count = 0;
    state->has_tree = false;
    plii_manifolds* next = &state->manifolds;
    PLII_SWAP(plii_manifolds, state->manifolds, state->manifolds_before);
    next->count = 0;
    plii_match_capacity(body->context, (void**)&next->items, &next->capacity, state->manifolds_before.capacity,
                        sizeof *next->items);
    /* Without memory pairs start anew; the contacts are the same up to rounding. */
    if (!plii_pair_cache_begin_step(body->context, &state->memory)) { plii_cluster_contacts_clear(body, state); }
}

void plii_cluster_contacts_clear(pli_body* body, void* data) {
    plii_cluster_contacts* state = data;
    state->count = 0;
    plii_pair_cache_clear(&state->memory);
    state->manifolds.count = state->manifolds_before.count = 0;
}

void plii_cluster_contacts_add(plii_pair_context* pair, const pli_cluster_contact* info,
                               const plii_contact_terms* terms) {
    pli_body* body = pair->body;
    plii_cluster_contacts* state = pair->state;
    plii_joint_end* sides = pair->sides;
    if (!PLII_GROW(body->context, &state->contacts, &state->capacity, state->count)) { return; }
    if (!pair->has_sides) {
        sides[0] = plii_joint_end_of_cluster(body, info->cluster);
        sides[1] = info->other != NULL ? plii_joint_end_of_cluster(info->other, info->other_cluster)
                                       : plii_joint_end_of_rigid(info->rigid);
        if (info->rigid != NULL) { sides[1].frame = state->rigid_pose; }
        pair->has_sides = true;
    }
    if (!(info->distance < terms->margin) || !cluster_contact_is_usable(info)) { return; }
    const pli_vec3 normal = plii_vec3_divide(info->normal, pli_vec3_length(info->normal));
    const plii_joint_target targets[2] = {sides[0].target, sides[1].target};
    plii_cluster_contact* contact = &state->contacts[state->count++];
    cluster_contact_set(contact, info, normal, targets, sides[0].frame.origin, sides[1].frame.origin, terms);
    contact->is_self = info->other == body;
    if (plii_cluster_contacts_are_as_reference(body, info)) { cluster_contact_set_as_reference(contact, sides, terms); }
}

void plii_cluster_contacts_add_nodes(plii_pair_context* pair, pli_cluster_contact info, const plii_near_nodes* found,
                                     int first, const plii_contact_terms* terms) {
    for (PLII_EACH(const plii_near_node, node, &found->kept[first], found->count - first)) {
        info.witness = node->point;
        info.other_witness = pli_vec3_sub(node->point, pli_vec3_scale(node->normal, node->distance));
        info.normal = node->normal;
        info.distance = node->distance;
        plii_cluster_contacts_add(pair, &info, terms);
    }
}
