/* Contacts of clusters with rigid bodies and clusters, solved with the joints. Bullet: CollideCL_RS, CollideCL_SS. */

#include "body/contact_report.h"
#include "body/pipeline.h"
#include "cluster/cluster_contacts_impl.h"
#include "pliant/bullet_reference.h"

static plii_cluster_contacts* cluster_contacts_of(const pli_body* body) {
    return plii_body_is_idle(body) ? NULL : plii_feature_state(body, &plii_cluster_contacts_class);
}

/* Of the bodies that take part. */
static bool cluster_contacts_is_last(const pli_body* body) {
    const pli_world* world = body->world;
    for (int i = body->world_index + 1; i < world->body_count; ++i) {
        if (cluster_contacts_of(world->bodies[i]) != NULL) { return false; }
    }
    return true;
}

static bool cluster_contacts_share_sides(const plii_cluster_contact* a, const plii_cluster_contact* b) {
    return a->reference_mode == b->reference_mode && a->targets[0].cluster == b->targets[0].cluster &&
           a->targets[1].cluster == b->targets[1].cluster && a->targets[1].rigid == b->targets[1].rigid;
}

static bool cluster_contacts_batch(pli_context* context, plii_contact_batches* batches,
                                   const plii_cluster_contacts* state) {
    int next = 0;
    for (int i = 0; i < state->count; i = next) {
        const plii_cluster_contact* first = &state->contacts[i];
        next = i + 1;
        while (next < state->count && cluster_contacts_share_sides(first, &state->contacts[next])) {
            ++next;
        }
        if (!first->reference_mode && !plii_contact_batches_add(context, batches, first, next - i)) { return false; }
    }
    return true;
}

/* Pairs of different bodies are solved side by side, so the last body has the contacts of all. */
static void cluster_contacts_lead(pli_body* body, plii_cluster_contacts* state) {
    const pli_world* world = body->world;
    if (!plii_contact_batches_start(body->context, &state->batches, world->rigid_count)) { return; }
    bool has_memory = true;
    int capacity = 0;
    for (int i = 0; has_memory && i < world->body_count; ++i) {
        const plii_cluster_contacts* other = cluster_contacts_of(world->bodies[i]);
        if (other == NULL) { continue; }
        capacity += other->capacity;
        has_memory = cluster_contacts_batch(body->context, &state->batches, other);
    }
    for (int i = 0; state->batches.keeps_momentum && i < world->body_count; ++i) {
        plii_clusters* clusters = world->bodies[i]->clusters;
        if (clusters != NULL) { plii_clusters_split_masses(clusters); }
    }
    /* In the first step, so that the others need nothing. Without memory they ask again. */
    plii_contact_batches_reserve(body->context, &state->batches, capacity);
    plii_contact_batches_prepare(body->context, &state->batches);
}

static void cluster_contacts_prepare(pli_body* body, void* data) {
    plii_cluster_contacts* state = data;
    if (state->def.with_self) { plii_cluster_contacts_collide_self(body, state); }
    const bool has_own = body->clusters->def.reference_mode;
    for (int i = 0; has_own && i < state->count; ++i) {
        if (!state->contacts[i].reference_mode) { continue; }
        plii_cluster_contact_prepare(&state->contacts[i], body->step.dt, body->world->joint_iterations);
    }
    state->leads = cluster_contacts_is_last(body);
    if (state->leads) { cluster_contacts_lead(body, state); }
}

static void cluster_contacts_solve(pli_body* body, void* data) {
    plii_cluster_contacts* state = data;
    const bool has_own = body->clusters->def.reference_mode;
    for (int i = 0; has_own && i < state->count; ++i) {
        if (state->contacts[i].reference_mode) { plii_cluster_contact_solve(&state->contacts[i]); }
    }
    if (state->leads) { plii_contact_batches_solve(&state->batches); }
}

/* The first contact, then from the last one back: cleanupClusters fills each gap with the last one. */
static void cluster_contacts_finish(pli_body* body, void* data) {
    plii_cluster_contacts* state = data;
    const bool has_own = body->clusters->def.reference_mode;
    for (int i = 0; has_own && i < state->count; ++i) {
        plii_cluster_contact* contact = &state->contacts[i == 0 ? 0 : state->count - i];
        if (contact->reference_mode) { plii_cluster_contact_finish(contact); }
    }
    if (state->leads) { plii_contact_batches_finish(&state->batches); }
}

/* All contacts end. */
static void cluster_contacts_on_change(pli_body* body, void* data, plii_notice notice, const void* about) {
    plii_cluster_contacts* state = data;
    plii_cluster_contacts_clear(body, state);
    if (about != body) { return; }
    plii_key_table_free(&state->neighbours);
    state->neighbour_pair_count = state->clusters_with_neighbours = 0;
}

static void cluster_contacts_measure_anew(const plii_pair_records* records, const plii_manifolds* manifolds,
                                          const pli_rigid* rigid, bool are_others) {
    for (PLII_EACH(plii_pair_record, record, records->items, records->count)) {
        if (record->key.other != rigid) { continue; }
        if (record->slot > 0) { manifolds->items[record->slot - 1].key = NULL; }
        if (are_others) { record->cache = (plii_convex_cache){.count = 0}; }
    }
}
static void cluster_contacts_on_shapes(pli_body* body, void* data, plii_notice notice, const void* rigid) {
    plii_cluster_contacts* state = data;
    if (body->clusters->def.reference_mode) { return; } /* which follows no pairs */
    const bool are_others = notice == PLII_SHAPES_REPLACED;
    cluster_contacts_measure_anew(&state->memory.present, &state->manifolds, rigid, are_others);
    cluster_contacts_measure_anew(&state->memory.before, &state->manifolds_before, rigid, are_others);
}

/* Of large bodies most clusters are far from others. */
#define CLUSTER_CONTACTS_MAX_ROOM 1024 /* nodes */
/* Clusters of a pile of tori, the most that was measured, meet 10 others, with 14 contacts. */
#define CLUSTER_CONTACTS_PER_CLUSTER 12
/* With rigid bodies, where a body of few clusters lies in a heap of them. */
#define CLUSTER_CONTACTS_MORE_PAIRS 16

static int cluster_contacts_least(int a, int b) {
    return a < b ? a : b;
}

static void cluster_contacts_reserve(pli_body* body, void* data) {
    plii_cluster_contacts* state = data;
    pli_context* context = body->context;
    const pli_world* world = body->world;
    const int clusters = body->clusters->count;
    const int nodes = cluster_contacts_least(body->node_count, CLUSTER_CONTACTS_MAX_ROOM);
    int contacts = 0, pairs = 0;
    if (state->def.with_rigids && world->rigid_count > 0) {
        contacts += cluster_contacts_least(PLII_CLUSTER_CONTACTS_PER_PAIR * clusters, nodes + nodes / 2);
        if (world->has_convex_shapes) {
            pairs += cluster_contacts_least(clusters + clusters / 2, CLUSTER_CONTACTS_MAX_ROOM) +
                     CLUSTER_CONTACTS_MORE_PAIRS;
        }
        if (world->has_other_shapes) {
            (void)PLII_RESERVE(context, &state->surface, &state->surface_capacity, body->node_count);
        }
    }
    for (PLII_EACH_BODY(other, world)) {
        const plii_clusters* others = state->def.with_bodies ? other->clusters : NULL;
        if (others == NULL) { continue; }
        (void)PLII_RESERVE(context, &state->candidates, &state->candidate_capacity, PLII_BVH4_ROOM(others->count));
    }
    if (state->def.with_self ||
        (state->def.with_bodies && plii_feature_is_shared(body, &plii_cluster_contacts_class))) {
        const int touched = cluster_contacts_least(CLUSTER_CONTACTS_PER_CLUSTER * clusters, nodes);
        contacts += touched;
        pairs += touched;
        (void)plii_cluster_contacts_reserve_search(body, state);
    }
    (void)PLII_RESERVE(context, &state->contacts, &state->capacity, contacts);
    if (state->def.distance != NULL || pairs == 0) { return; }
    (void)plii_pair_cache_reserve(context, &state->memory, pairs);
    if (body->clusters->def.reference_mode || state->def.disable_contact_cache) { return; }
    (void)PLII_RESERVE(context, &state->manifolds.items, &state->manifolds.capacity, pairs);
    (void)PLII_RESERVE(context, &state->manifolds_before.items, &state->manifolds_before.capacity, pairs);
}

/* After joints. */
enum { CLUSTER_CONTACTS_CLEAR_ORDER = 5, CLUSTER_CONTACTS_ORDER = 20 };

static void cluster_contacts_on_restored(pli_body* body, void* data) {
    plii_key_table_clear(&((plii_cluster_contacts*)data)->neighbours);
}

static bool cluster_contacts_is_sound(const pli_body* body, const void* data) {
    const plii_cluster_contacts* state = data;
    for (int i = 0; i < state->neighbour_pair_count; ++i) {
        const int* pair = state->neighbour_pairs[i];
        if (pair[0] < 0 || pair[0] >= pair[1] || pair[1] >= body->clusters->count) { return false; }
    }
    for (PLII_EACH(const plii_manifold, manifold, state->manifolds.items, state->manifolds.count)) {
        if (manifold->count < 0 || manifold->count > PLII_MANIFOLD_POINTS) { return false; }
    }
    for (PLII_EACH(const plii_pair_record, record, state->memory.present.items, state->memory.present.count)) {
        if (record->slot < 0 || record->slot > state->manifolds.count) { return false; }
    }
    return plii_pair_cache_is_sound(&state->memory);
}

static void cluster_contacts_keep_callbacks(void* data, const void* before) {
    plii_cluster_contacts* state = data;
    const plii_cluster_contacts* old = before;
    state->def.distance = old->def.distance;
    state->def.distance_user = old->def.distance_user;
}

const plii_feature_class plii_cluster_contacts_class = {
    .name = "cluster contacts",
    .state_size = sizeof(plii_cluster_contacts),
    .settings = PLII_LIMITS_AT(offsetof(plii_cluster_contacts, def),
                               PLII_FIELD(pli_cluster_contacts_def, friction, 0, PLI_MAX_FACTOR),
                               PLII_FIELD(pli_cluster_contacts_def, dynamic_hardness, 0, 1),
                               PLII_FIELD(pli_cluster_contacts_def, static_hardness, 0, 1),
                               PLII_FIELD(pli_cluster_contacts_def, soft_hardness, 0, 1),
                               PLII_FIELD(pli_cluster_contacts_def, dynamic_split, 0, 1),
                               PLII_FIELD(pli_cluster_contacts_def, static_split, 0, 1),
                               PLII_FIELD(pli_cluster_contacts_def, soft_split, 0, 1)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(plii_cluster_contacts, def, PLII_SAVED, "3B7f2B2Xu"),
                                    PLII_STATE_SPAN(plii_cluster_contacts, leads, batches, PLII_LEFT, NULL),
                                    PLII_STATE(plii_cluster_contacts, memory.table, PLII_LEFT),
                                    PLII_STATE_SPAN(plii_cluster_contacts, tree, has_tree, PLII_LEFT, NULL),
                                    PLII_STATE(plii_cluster_contacts, candidate_count, PLII_LEFT),
                                    PLII_STATE_OF(plii_cluster_contacts, clusters_with_neighbours, PLII_SAVED, "i"),
                                    PLII_STATE(plii_cluster_contacts, neighbours, PLII_LEFT)),
    .on_restored = cluster_contacts_on_restored,
    .is_sound = cluster_contacts_is_sound,
    .keep_callbacks = cluster_contacts_keep_callbacks,
    .needs = PLII_NEEDS(&plii_clusters_class),
    .stages = {[PLII_STAGE_UPDATE] = {plii_cluster_contacts_begin_step, CLUSTER_CONTACTS_CLEAR_ORDER},
               [PLII_STAGE_JOINT_PREPARE] = {cluster_contacts_prepare, CLUSTER_CONTACTS_ORDER},
               [PLII_STAGE_JOINT_SOLVE] = {cluster_contacts_solve, CLUSTER_CONTACTS_ORDER},
               [PLII_STAGE_JOINT_FINISH] = {cluster_contacts_finish, CLUSTER_CONTACTS_ORDER}},
    .arrays = PLII_ARRAYS(
        PLII_LEFT_COUNTED(plii_cluster_contacts, contacts, capacity, count),
        PLII_LEFT_LIST(plii_cluster_contacts, boxes, box_capacity),
        PLII_LEFT_LIST(plii_cluster_contacts, candidates, candidate_capacity),
        PLII_LEFT_LIST(plii_cluster_contacts, surface, surface_capacity),
        {PLII_COUNTED_LIST(plii_cluster_contacts, manifolds.items, manifolds.capacity, manifolds.count),
         PLII_SAVED_AS("2i9fOf70f")},
        PLII_LEFT_COUNTED(plii_cluster_contacts, manifolds_before.items, manifolds_before.capacity,
                          manifolds_before.count),
        PLII_LEFT_LIST(plii_cluster_contacts, batches.items, batches.capacity),
        PLII_LEFT_LIST(plii_cluster_contacts, batches.blocks, batches.block_capacity),
        PLII_LEFT_LIST(plii_cluster_contacts, batches.rigids, batches.rigid_capacity),
        PLII_LEFT_LIST(plii_cluster_contacts, tree.groups, tree.capacity),
        {PLII_COUNTED_LIST(plii_cluster_contacts, neighbour_pairs, neighbour_pair_capacity, neighbour_pair_count),
         PLII_SAVED_AS("2i")},
        {PLII_KEY_TABLE_OF(plii_cluster_contacts, neighbours)},
        PLII_PAIR_CACHE_LISTS(plii_cluster_contacts, memory, PLII_SAVED, PLII_LEFT)),
    .collide_rigid = plii_cluster_contacts_collide_rigid,
    .prepare_pair = plii_cluster_contacts_prepare_pair,
    .collide_body = plii_cluster_contacts_collide_body,
    .acts_with_joints = true,
    .on = {[PLII_BODY_REMOVED] = cluster_contacts_on_change,
           [PLII_RIGID_REMOVED] = cluster_contacts_on_change,
           [PLII_CLUSTERS_REMOVED] = cluster_contacts_on_change,
           [PLII_TOPOLOGY_CHANGED] = cluster_contacts_on_change,
           [PLII_SHAPES_MOVED] = cluster_contacts_on_shapes,
           [PLII_SHAPES_REPLACED] = cluster_contacts_on_shapes},
    .reserve = cluster_contacts_reserve,
    .build = plii_cluster_contacts_clear, /* new members lie between those of a cluster, which keeps its index */
};

PLII_DEFINE_DEFAULT(pli_cluster_contacts_def, .with_rigids = true, .with_bodies = true, .friction = 0.2f,
                    .dynamic_hardness = 0.1f, .static_hardness = 1.0f, .soft_hardness = 0.5f, .dynamic_split = 0.5f,
                    .static_split = 0.5f, .soft_split = 0.5f)

pli_status pli_body_enable_cluster_contacts(pli_body* body, const pli_cluster_contacts_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_SETTINGS(body, pli_cluster_contacts_def, used, def, plii_cluster_contacts_class);
    PLII_TRY(plii_feature_enable(body, &plii_clusters_class, NULL)); /* they stay when the contacts go */
    const pli_status status = plii_feature_enable_with(body, &plii_cluster_contacts_class, &used, sizeof used, NULL);
    if (status != PLI_OK) { plii_feature_undo(body, &plii_clusters_class); }
    return status;
}
PLII_DEFINE_DISABLE(pli_body_disable_cluster_contacts, plii_check_body_change, plii_cluster_contacts_class)

PLII_DEFINE_CONTACTS_GET(pli_body_get_cluster_contacts, pli_cluster_contact, plii_cluster_contacts,
                         plii_cluster_contact, plii_cluster_contacts_class, contact->info)

pli_status pli_body_reorder_cluster_contacts(pli_body* body, const int* order, int count) {
    return plii_reorder_contacts(body, &plii_cluster_contacts_class, order, count, __func__);
}
