/* Which pairs with rigid bodies meet in a step. */

#include "math/bounds.h"
#include "world/world_impl.h"

pli_status plii_check_pair(const pli_world* world, const pli_world* world_a, const pli_world* world_b,
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

/* What a feature has no memory for is noted where it is asked for. */
static void world_run_collide_feature(pli_world* world, pli_body* body, const plii_feature* feature, pli_rigid* rigid) {
    const plii_feature_class* klass = feature->klass;
    plii_thread.pass.feature = klass;
    plii_world_profile(world, "collide", klass->name, true);
    (void)klass->collide_rigid(body, feature->state, rigid);
    plii_world_profile(world, "collide", klass->name, false);
}

static void world_run_collide_rigid(pli_world* world, pli_body* body, pli_rigid* rigid) {
    const plii_feature* last = NULL;
    plii_world_begin_body(body);
    for (PLII_EACH_FEATURE(feature, body)) {
        const plii_feature_class* klass = feature->klass;
        if (klass->collide_rigid == NULL || (rigid->is_sensor && !klass->meets_sensors)) { continue; }
        if (klass->collides_last) {
            last = feature;
        } else {
            world_run_collide_feature(world, body, feature, rigid);
        }
    }
    if (last != NULL) { world_run_collide_feature(world, body, last, rigid); }
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
    if (count < 0) { return plii_fail(world->context, PLI_ERROR_INVALID_VALUE, function, "count = %d", count); }
    PLII_FAIL_IF(pairs == NULL && count > 0, world->context, PLI_ERROR_NULL_ARGUMENT, function, "pairs is null");
    for (int i = 0; i < count; ++i) {
        PLII_TRY(plii_check_handle(pairs[i].body, PLII_HANDLE_BODY, world->context, NULL, function));
        PLII_TRY(plii_check_handle(pairs[i].rigid, PLII_HANDLE_RIGID, world->context, NULL, function));
        PLII_TRY(plii_check_pair(world, pairs[i].body->world, pairs[i].rigid->world, function));
    }
    return PLI_OK;
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
        plii_groups_join_rigid(world, body, pairs[i].rigid);
        nodes += body->node_count;
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
    PLII_TRY(plii_check_world_change(world, __func__));
    return world_collide_rigid_pairs(world, &(const pli_rigid_pair){body, rigid}, 1, __func__);
}

pli_status pli_world_collide_rigids(pli_world* world, const pli_rigid_pair* pairs, int count) {
    PLII_TRY(plii_check_world_change(world, __func__));
    return world_collide_rigid_pairs(world, pairs, count, __func__);
}

/* Contacts that are to last for a step are looked for a margin further out, and where surfaces get to in it. */
static bool world_overlaps_rigid(pli_body* body, const pli_rigid* rigid) {
    const bool is_ahead = plii_follows_rigids(body);
    const bool is_swept = is_ahead || body->sweeping_features > 0 || body->solver_class->contact_reach > 0.0f;
    pli_bounds bounds = is_swept ? plii_rigid_swept_bounds(rigid, body->step.dt) : rigid->step_bounds;
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
            plii_groups_join_rigid(world, body, world->rigids[r]);
            nodes += body->node_count;
        }
    }
    return nodes;
}

void plii_world_collide_all(pli_world* world) {
    for (int r = 0; r < world->rigid_count; ++r) {
        plii_rigid_place_shapes(world->rigids[r]);
        world->rigids[r]->step_bounds = world->rigids[r]->bounds;
    }
    const int count = world->body_count;
    const int grain = world->has_groups ? plii_groups_grain(world, count, world_join_rigids(world)) : count;
    plii_parallel_for(world->context, world_collide_range_of_bodies, world, count, grain);
    plii_world_collide_soft_pairs(world);
}
