/* Which pairs of soft bodies meet in a step. On several threads pairs go in waves: those of one wave have no body in
   common, and each body gets its contacts in the order of one thread. */

#include "base/csr.h"
#include "base/ranges.h"
#include "body/pipeline.h"
#include "math/bounds.h"
#include "world/world_impl.h"

PLII_DEFINE_GET(bool, pli_body_collides_with_bodies, body, body->collides_with_bodies, false)

static bool world_meets_body(pli_body* body_a, pli_body* body_b) {
    if (plii_body_is_stopped(body_a) || plii_body_is_stopped(body_b) || !body_a->collides_with_bodies) { return false; }
    body_a->interval.is_near = body_b->interval.is_near = true;
    return !body_a->interval.is_waiting && !body_b->interval.is_waiting;
}

/* False: the two have nothing in common. */
static bool world_join_pair(pli_world* world, const pli_body_pair* pair) {
    for (PLII_EACH_FEATURE(feature, pair->body_a)) {
        const plii_feature_class* klass = feature->klass;
        if (klass->collide_body == NULL || !plii_feature_is_enabled(pair->body_b, klass)) { continue; }
        plii_groups_join_bodies(world, pair->body_a, pair->body_b);
        return true;
    }
    return false;
}

static void world_run_collide_bodies(pli_world* world, const pli_body_pair* pair) {
    pli_body *body_a = pair->body_a, *body_b = pair->body_b;
    plii_world_begin_body(body_a);
    for (PLII_EACH_FEATURE(feature, body_a)) {
        if (feature->klass->collide_body == NULL) { continue; }
        void* other_state = plii_feature_state(body_b, feature->klass);
        if (other_state == NULL) { continue; }
        plii_thread.pass.feature = feature->klass;
        plii_world_profile(world, "collide", feature->klass->name, true);
        (void)feature->klass->collide_body(body_a, feature->state, body_b, other_state);
        plii_world_profile(world, "collide", feature->klass->name, false);
    }
}

static void world_collide_pair(pli_world* world, const pli_body_pair* pair) {
    if (!world_meets_body(pair->body_a, pair->body_b) || !world_join_pair(world, pair)) { return; }
    world_run_collide_bodies(world, pair);
}

/* The last wave is of what comes after all others: its pairs go one after the other. */
enum { COLLIDE_WAVES = 64, COLLIDE_LAST_WAVE = COLLIDE_WAVES - 1 };
enum { COLLIDE_NODE_NS = 50 }; /* of a pair, per node of both */

/* After all pairs before that have one of its bodies. */
static int collide_choose_wave(pli_body* a, pli_body* b) {
    const int before = a->pair_wave > b->pair_wave ? a->pair_wave : b->pair_wave;
    a->pair_wave = b->pair_wave = before < COLLIDE_LAST_WAVE ? before + 1 : COLLIDE_LAST_WAVE;
    return a->pair_wave;
}

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
        if (!world_meets_body(a, b) || !world_join_pair(world, &pairs[i])) { continue; }
        wave_of[i] = collide_choose_wave(a, b);
        ++begin[wave_of[i]];
        nodes += a->node_count + b->node_count;
    }
    const int met = plii_csr_sum(COLLIDE_WAVES, begin);
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

static pli_status world_check_body_pair(const pli_world* world, const pli_body_pair* pair, const char* function) {
    const pli_body *a = pair->body_a, *b = pair->body_b;
    PLII_TRY(plii_check_handle(a, PLII_HANDLE_BODY, world->context, "the first body", function));
    PLII_TRY(plii_check_handle(b, PLII_HANDLE_BODY, world->context, "the second body", function));
    PLII_TRY(plii_check_pair(world, a->world, b->world, function));
    if (a == b) { return plii_fail(world->context, PLI_ERROR_INVALID_VALUE, function, "a body cannot meet itself"); }
    return PLI_OK;
}

static pli_status world_collide_checked(pli_world* world, const pli_body_pair* pairs, int count, const char* function) {
    for (int i = 0; i < count; ++i) {
        PLII_TRY(world_check_body_pair(world, &pairs[i], function));
    }
    plii_walk walk;
    const uint64_t before = plii_world_begin_call(world, &walk);
    world_collide_pairs(world, pairs, count);
    return plii_world_end_call(world, &walk, before, function);
}

pli_status pli_world_collide_bodies(pli_world* world, pli_body* body_a, pli_body* body_b) {
    PLII_TRY(plii_check_world_change(world, __func__));
    return world_collide_checked(world, &(const pli_body_pair){body_a, body_b}, 1, __func__);
}

pli_status pli_world_collide_body_pairs(pli_world* world, const pli_body_pair* pairs, int count) {
    PLII_TRY(plii_check_world_change(world, __func__));
    if (count < 0) { return PLII_FAIL(world->context, PLI_ERROR_INVALID_VALUE, "count = %d", count); }
    if (pairs == NULL && count > 0) { return PLII_FAIL(world->context, PLI_ERROR_NULL_ARGUMENT, "pairs is null"); }
    return world_collide_checked(world, pairs, count, __func__);
}

/* Sweep along x. The list stays sorted from step to step, so insertion sort has little to do. */
static void world_sort_sweep(pli_world* world) {
    pli_body** sweep = world->sweep;
    for (int i = 1; i < world->body_count; ++i) {
        pli_body* moved = sweep[i];
        int k = i;
        while (k > 0 && sweep[k - 1]->bounds.min.x > moved->bounds.min.x) {
            sweep[k] = sweep[k - 1];
            --k;
        }
        sweep[k] = moved;
    }
}

void plii_world_collide_soft_pairs(pli_world* world) {
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
