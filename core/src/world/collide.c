/* Which pairs meet in a step. On several threads pairs of soft bodies go in waves: those of one wave write to
   no body in common, and each body gets its contacts in the order of one thread. */

#include "base/csr.h"
#include "base/ranges.h"
#include "body/pipeline.h"
#include "math/bounds.h"
#include "world/world_impl.h"

/* The pair's members are of these worlds. */
static pli_status world_check_pair(const pli_world* world, const pli_world* world_a, const pli_world* world_b,
                                   const char* function) {
    PLII_FAIL_IF(!world->is_stepping, world->context, PLI_ERROR_WRONG_STATE, function,
                 "only between predict and solve");
    PLII_FAIL_IF(world_a != world || world_b != world, world->context, PLI_ERROR_INVALID_VALUE, function,
                 "a member of the pair is of another world");
    return PLI_OK;
}

static bool world_meets_rigid(pli_body* body, const pli_rigid* rigid) {
    if (plii_body_is_stopped(body) || rigid->is_absent || plii_body_ignores_rigid(body, rigid)) { return false; }
    if (rigid->kind == PLI_RIGID_DYNAMIC) { body->interval.is_near = true; }
    return !body->interval.is_waiting;
}

/* The count of a feature's first list, of contacts. A pair that there was no memory for gets none, or it would tip. */
static int* world_contact_count(const plii_feature_class* klass, void* state) {
    return (int*)((char*)state + klass->arrays->count);
}

/* What a feature has no memory for is noted where it is asked for. */
static void world_run_collide_rigid(pli_world* world, pli_body* body, pli_rigid* rigid) {
    plii_world_begin_body(body);
    for (PLII_EACH_ENTRY(entry, body, PLII_COLLIDE_RIGID)) {
        const plii_feature_class* klass = entry->klass;
        if (rigid->is_sensor && !klass->meets_sensors) { continue; }
        plii_thread.pass.feature = klass;
        const uint64_t shortages = plii_thread.shortages;
        int *contacts = world_contact_count(klass, entry->state), before = *contacts;
        PLII_WORLD_RUN_PROFILED(world, "collide", klass->name, klass->collide_rigid(body, entry->state, rigid));
        if (plii_thread.shortages != shortages) { *contacts = before; }
    }
}

typedef struct world_pairs_task {
    pli_world* world;
    const pli_rigid_pair* pairs;
    int count;
} world_pairs_task;

/* Pairs of the bodies that begin in the part. */
static void world_collide_range(int begin, int end, void* data) {
    const world_pairs_task* task = data;
    const pli_rigid_pair* pairs = task->pairs;
    int i = begin;
    while (i > 0 && i < end && pairs[i].body == pairs[i - 1].body) {
        ++i;
    }
    if (i == end) { return; } /* a body that begins in an earlier part goes on behind this one */
    for (; i < task->count && (i < end || pairs[i].body == pairs[i - 1].body); ++i) {
        if (!world_meets_rigid(pairs[i].body, pairs[i].rigid)) { continue; }
        world_run_collide_rigid(task->world, pairs[i].body, pairs[i].rigid);
    }
}

static pli_status world_check_pairs(const pli_world* world, const pli_rigid_pair* pairs, int count,
                                    const char* function) {
    PLII_TRY(plii_check_world_change(world, function));
    if (count < 0) { return plii_fail(world->context, PLI_ERROR_INVALID_VALUE, function, "count = %d", count); }
    PLII_FAIL_IF(pairs == NULL && count > 0, world->context, PLI_ERROR_NULL_ARGUMENT, function, "pairs is null");
    for (int i = 0; i < count; ++i) {
        PLII_TRY(plii_check_handle(pairs[i].body, PLII_HANDLE_BODY, world->context, NULL, function));
        PLII_TRY(plii_check_handle(pairs[i].rigid, PLII_HANDLE_RIGID, world->context, NULL, function));
        PLII_TRY(world_check_pair(world, pairs[i].body->world, pairs[i].rigid->world, function));
    }
    return PLI_OK;
}

/* Of contacts with one rigid body, as so many nodes; of clusters, which act with joints, they take longer. */
static int64_t world_contact_nodes(const pli_body* body) {
    return body->solves_rigids ? body->node_count : 4 * (int64_t)body->node_count;
}

/* Joins what the pairs share. Returns how many pairs make a part for a thread; all of them where a body comes twice. */
static int world_join_pairs(pli_world* world, const pli_rigid_pair* pairs, int count) {
    if (!world->has_groups) { return count; }
    const uint32_t call = ++world->collide_call;
    int64_t nodes = 0;
    bool comes_twice = false;
    for (int i = 0; i < count; ++i) {
        pli_body* body = pairs[i].body;
        if (i == 0 || pairs[i - 1].body != body) {
            comes_twice = comes_twice || body->collide_call == call;
            body->collide_call = call;
        }
        if (!world_meets_rigid(body, pairs[i].rigid)) { continue; }
        if (body->solves_rigids) { plii_groups_join_rigid(world, body, pairs[i].rigid); }
        nodes += world_contact_nodes(body);
    }
    return comes_twice ? count : plii_groups_grain(world, count, nodes);
}

static pli_status world_collide_rigid_pairs(pli_world* world, const pli_rigid_pair* pairs, int count,
                                            const char* function) {
    PLII_TRY(world_check_pairs(world, pairs, count, function));
    plii_walk walk;
    const uint64_t before = plii_world_begin_call(world, &walk);
    for (int i = 0; i < count; ++i) {
        plii_rigid_place_shapes(pairs[i].rigid);
    }
    world_pairs_task task = {world, pairs, count};
    plii_parallel_for(world->context, world_collide_range, &task, count, world_join_pairs(world, pairs, count));
    return plii_world_end_call(world, &walk, before, function);
}

pli_status pli_world_collide_rigid(pli_world* world, pli_body* body, pli_rigid* rigid) {
    return world_collide_rigid_pairs(world, &(const pli_rigid_pair){body, rigid}, 1, __func__);
}
pli_status pli_world_collide_rigids(pli_world* world, const pli_rigid_pair* pairs, int count) {
    return world_collide_rigid_pairs(world, pairs, count, __func__);
}

/* Contacts that are to last for a step are looked for a margin further out, and where surfaces get to in it. */
static bool world_overlaps_rigid(pli_body* body, const pli_rigid* rigid) {
    const bool is_ahead = plii_follows_rigids(body);
    const bool is_swept = is_ahead || body->sweeping_features > 0 || body->solver_class->contact_reach > 0.0f;
    pli_bounds bounds = is_swept ? plii_rigid_swept_bounds(rigid, body->host_dt) : rigid->step_bounds;
    if (is_ahead) { bounds = plii_bounds_grow(bounds, body->collision_margin); }
    return plii_bounds_overlap(body->bounds, bounds) && world_meets_rigid(body, rigid);
}

static void world_collide_range_of_bodies(int begin, int end, void* data) {
    pli_world* world = data;
    for (int b = begin; b < end; ++b) {
        for (int r = 0; r < world->rigid_count && !plii_body_is_stopped(world->bodies[b]); ++r) {
            if (!world_overlaps_rigid(world->bodies[b], world->rigids[r])) { continue; }
            world_run_collide_rigid(world, world->bodies[b], world->rigids[r]);
        }
    }
}

/* Returns the nodes that meet something. */
static int64_t world_join_rigids(pli_world* world) {
    int64_t nodes = 0;
    for (PLII_EACH_BODY(body, world)) {
        for (int r = 0; r < world->rigid_count && !plii_body_is_idle(body); ++r) {
            if (!world_overlaps_rigid(body, world->rigids[r])) { continue; }
            if (body->solves_rigids) { plii_groups_join_rigid(world, body, world->rigids[r]); }
            nodes += world_contact_nodes(body);
        }
    }
    return nodes;
}

// --------------------------------------------------------------------------------------------------------- soft bodies

PLII_DEFINE_GET(bool, pli_body_collides_with_bodies, body, body->collides_with_bodies, false)

static bool world_meets_body(pli_body* body_a, pli_body* body_b) {
    if (plii_body_is_stopped(body_a) || plii_body_is_stopped(body_b) || !body_a->collides_with_bodies) { return false; }
    body_a->interval.is_near = body_b->interval.is_near = true;
    return !body_a->interval.is_waiting && !body_b->interval.is_waiting;
}

typedef enum pair_writes { PAIR_WRITES_NOTHING, PAIR_WRITES_FIRST, PAIR_WRITES_BOTH } pair_writes;

/* Makes what features read of both bodies; nothing: the two have none in common. */
static pair_writes world_prepare_pair(pli_world* world, const pli_body_pair* pair) {
    pair_writes writes = PAIR_WRITES_NOTHING;
    plii_world_begin_body(pair->body_a);
    for (PLII_EACH_FEATURE(feature, pair->body_a)) {
        const plii_feature_class* klass = feature->klass;
        void* other_state = klass->collide_body != NULL ? plii_feature_state(pair->body_b, klass) : NULL;
        if (other_state == NULL) { continue; }
        plii_thread.pass.feature = klass;
        if (!klass->acts_with_joints) { plii_groups_join_bodies(world, pair->body_a, pair->body_b); }
        if (klass->prepare_pair == NULL) {
            writes = PAIR_WRITES_BOTH;
            continue;
        }
        PLII_WORLD_RUN_PROFILED(world, "collide", klass->name,
                                klass->prepare_pair(pair->body_a, feature->state, pair->body_b, other_state));
        if (writes == PAIR_WRITES_NOTHING) { writes = PAIR_WRITES_FIRST; }
    }
    return writes;
}

static void world_run_collide_bodies(pli_world* world, const pli_body_pair* pair) {
    pli_body *body_a = pair->body_a, *body_b = pair->body_b;
    plii_world_begin_body(body_a);
    for (PLII_EACH_FEATURE(feature, body_a)) {
        if (feature->klass->collide_body == NULL) { continue; }
        void* other_state = plii_feature_state(body_b, feature->klass);
        if (other_state == NULL) { continue; }
        plii_thread.pass.feature = feature->klass;
        const uint64_t shortages = plii_thread.shortages;
        int *contacts = world_contact_count(feature->klass, feature->state), before = *contacts;
        const bool writes_both = feature->klass->prepare_pair == NULL; /* else another thread may write to it */
        int* other_contacts = writes_both ? world_contact_count(feature->klass, other_state) : contacts;
        const int other_before = *other_contacts;
        PLII_WORLD_RUN_PROFILED(world, "collide", feature->klass->name,
                                feature->klass->collide_body(body_a, feature->state, body_b, other_state));
        if (plii_thread.shortages == shortages) { continue; }
        *contacts = before;
        *other_contacts = other_before;
    }
}

static void world_collide_pair(pli_world* world, const pli_body_pair* pair) {
    if (!world_meets_body(pair->body_a, pair->body_b)) { return; }
    if (world_prepare_pair(world, pair) != PAIR_WRITES_NOTHING) { world_run_collide_bodies(world, pair); }
}

/* The last wave is of what comes after all others: its pairs go one after the other. */
enum { COLLIDE_WAVES = 64, COLLIDE_LAST_WAVE = COLLIDE_WAVES - 1 };
enum { COLLIDE_NODE_NS = 50 }; /* of a pair, per node of both */

typedef struct collide_waves {
    pli_world* world;
    const pli_body_pair* pairs;
    const int* order; /* of the pairs of the wave */
} collide_waves;

static void collide_wave_range(int begin, int end, void* data) {
    const collide_waves* waves = data;
    for (int i = begin; i < end; ++i) {
        world_run_collide_bodies(waves->world, &waves->pairs[waves->order[i]]);
    }
}

/* False: without memory, or not worth it; nothing was done. */
static bool world_collide_in_waves(pli_world* world, const pli_body_pair* pairs, int count) {
    pli_context* context = world->context;
    if (count > 0) { plii_world_begin_body(pairs[0].body_a); } /* who the lists are for */
    if (!world->has_groups || count < 2 || !plii_has_threads(context) ||
        !PLII_RESERVE(context, &world->pair_orders, &world->pair_order_capacity, 2 * count)) {
        return false;
    }
    int *order = world->pair_orders, *wave_of = world->pair_orders + count;
    int begin[COLLIDE_WAVES + 1] = {0};
    int64_t nodes = 0;
    for (int i = 0; i < count; ++i) {
        pairs[i].body_a->pair_wave = pairs[i].body_b->pair_wave = -1;
    }
    for (int i = 0; i < count; ++i) {
        pli_body *a = pairs[i].body_a, *b = pairs[i].body_b;
        wave_of[i] = PLI_NULL_INDEX;
        const pair_writes writes = world_meets_body(a, b) ? world_prepare_pair(world, &pairs[i]) : PAIR_WRITES_NOTHING;
        if (writes == PAIR_WRITES_NOTHING) { continue; }
        /* After all pairs before that write to one of its bodies. */
        const bool writes_both = writes == PAIR_WRITES_BOTH;
        const int before = writes_both && b->pair_wave > a->pair_wave ? b->pair_wave : a->pair_wave;
        a->pair_wave = wave_of[i] = before < COLLIDE_LAST_WAVE ? before + 1 : COLLIDE_LAST_WAVE;
        if (writes_both) { b->pair_wave = a->pair_wave; }
        ++begin[wave_of[i]];
        nodes += a->node_count + b->node_count;
    }
    plii_csr_sum(COLLIDE_WAVES, begin);
    const int met = begin[COLLIDE_WAVES];
    for (int i = count - 1; i >= 0; --i) {
        if (wave_of[i] != PLI_NULL_INDEX) { order[--begin[wave_of[i]]] = i; }
    }
    const int64_t each = met > 0 ? nodes / met * COLLIDE_NODE_NS : 1;
    const int grain = plii_grain(each < 1 ? 1 : each > PLII_PART_NANOSECONDS ? PLII_PART_NANOSECONDS : (int)each);
    for (int w = 0; w < COLLIDE_WAVES; ++w) {
        collide_waves waves = {world, pairs, &order[begin[w]]};
        const int size = begin[w + 1] - begin[w];
        plii_parallel_for(context, collide_wave_range, &waves, size, w < COLLIDE_LAST_WAVE ? grain : size);
    }
    return true;
}

static void world_collide_pairs(pli_world* world, const pli_body_pair* pairs, int count) {
    if (world_collide_in_waves(world, pairs, count)) { return; }
    for (int i = 0; i < count; ++i) {
        world_collide_pair(world, &pairs[i]);
    }
}

static pli_status world_collide_checked(pli_world* world, const pli_body_pair* pairs, int count, const char* function) {
    PLII_TRY(plii_check_world_change(world, function));
    if (count < 0) { return plii_fail(world->context, PLI_ERROR_INVALID_VALUE, function, "count = %d", count); }
    PLII_FAIL_IF(pairs == NULL && count > 0, world->context, PLI_ERROR_NULL_ARGUMENT, function, "pairs is null");
    for (PLII_EACH(const pli_body_pair, pair, pairs, count)) {
        const pli_body *a = pair->body_a, *b = pair->body_b;
        PLII_TRY(plii_check_handle(a, PLII_HANDLE_BODY, world->context, "the first body", function));
        PLII_TRY(plii_check_handle(b, PLII_HANDLE_BODY, world->context, "the second body", function));
        PLII_TRY(world_check_pair(world, a->world, b->world, function));
        PLII_FAIL_IF(a == b, world->context, PLI_ERROR_INVALID_VALUE, function, "a body cannot meet itself");
    }
    plii_walk walk;
    const uint64_t before = plii_world_begin_call(world, &walk);
    world_collide_pairs(world, pairs, count);
    return plii_world_end_call(world, &walk, before, function);
}

pli_status pli_world_collide_bodies(pli_world* world, pli_body* body_a, pli_body* body_b) {
    return world_collide_checked(world, &(const pli_body_pair){body_a, body_b}, 1, __func__);
}
pli_status pli_world_collide_body_pairs(pli_world* world, const pli_body_pair* pairs, int count) {
    return world_collide_checked(world, pairs, count, __func__);
}

/* Sweep along x. The list stays sorted from step to step, so insertion sort has little to do. */
static void world_sort_sweep(pli_world* world) {
    pli_body** sweep = world->sweep;
    for (int i = 1; i < world->body_count; ++i) {
        pli_body* moved = sweep[i];
        int k = i;
        for (; k > 0 && sweep[k - 1]->bounds.min.x > moved->bounds.min.x; --k) {
            sweep[k] = sweep[k - 1];
        }
        sweep[k] = moved;
    }
}

/* Those whose bounds overlap. */
static void world_collide_soft_pairs(pli_world* world) {
    pli_body* const* sweep = world->sweep;
    int count = 0;
    world_sort_sweep(world);
    for (int i = 0; i < world->body_count; ++i) {
        if (!sweep[i]->collides_with_bodies) { continue; }
        for (int k = i + 1; k < world->body_count && sweep[k]->bounds.min.x <= sweep[i]->bounds.max.x; ++k) {
            if (!plii_bounds_overlap(sweep[i]->bounds, sweep[k]->bounds)) { continue; }
            const bool in_order = sweep[i]->world_index < sweep[k]->world_index;
            const pli_body_pair pair = {in_order ? sweep[i] : sweep[k], in_order ? sweep[k] : sweep[i]};
            plii_world_begin_body(pair.body_a);
            if (PLII_RESERVE(world->context, &world->pairs, &world->pair_capacity, count + 1)) {
                world->pairs[count++] = pair;
            } else {
                world_collide_pair(world, &pair);
            }
        }
    }
    world_collide_pairs(world, world->pairs, count);
}

void plii_world_collide_all(pli_world* world) {
    for (int r = 0; r < world->rigid_count; ++r) {
        plii_rigid_place_shapes(world->rigids[r]);
        world->rigids[r]->step_bounds = world->rigids[r]->bounds;
    }
    const int count = world->body_count;
    const int grain = world->has_groups ? plii_groups_grain(world, count, world_join_rigids(world)) : count;
    plii_parallel_for(world->context, world_collide_range_of_bodies, world, count, grain);
    world_collide_soft_pairs(world);
}
