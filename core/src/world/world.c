/* The world: lists of bodies and rigid proxies, the order of a step, and which pairs meet. */

#include "body/pipeline.h"
#include "shape/shape_impl.h"
#include "world/world_impl.h"

pli_status plii_check_world_idle(const pli_world* world, const char* function) {
    PLII_TRY(plii_check_world_change(world, function));
    if (!world->is_stepping) { return PLI_OK; }
    return plii_fail(world->context, PLI_ERROR_WRONG_STATE, function, "not allowed between predict and solve");
}
pli_status plii_refuse_entered(const pli_world* world, const char* function) {
    return plii_fail(world->context, PLI_ERROR_WRONG_STATE, function, "another thread steps the world");
}

/* PLI_OK, or the error of a call of a step that may not be made now. */
static pli_status world_enter(pli_world* world, const char* function) {
    PLII_TRY(plii_check_world_change(world, function));
    const bool is_entered = __atomic_exchange_n(&world->is_entered, true, __ATOMIC_ACQUIRE);
    return is_entered ? plii_refuse_entered(world, function) : PLI_OK;
}
static pli_status world_leave(pli_world* world, pli_status status) {
    __atomic_store_n(&world->is_entered, false, __ATOMIC_RELEASE);
    return status;
}

// ----------------------------------------------------------------------------------------------------- life

PLII_DEFINE_DEFAULT(pli_world_def, .gravity = {0, -10, 0}, .air_density = 1.2f, .max_force_displacement = 1000.0f,
                    .preallocates = true)

static const plii_field world_fields[] = {
    PLII_FIELD(pli_world_def, gravity, -PLI_MAX_ACCELERATION, PLI_MAX_ACCELERATION),
    PLII_FIELD(pli_world_def, air_density, 0, PLI_MAX_COEFFICIENT),
    PLII_FIELD(pli_world_def, max_force_displacement, PLII_ABOVE_0, PLI_MAX_COORDINATE),
};

pli_status pli_world_create(pli_context* context, const pli_world_def* def, pli_world** world) {
    PLII_TRY(plii_check_create(context, world, "world", __func__));
    const pli_world_def used = def != NULL ? *def : pli_world_def_default();
    PLII_TRY_DEF(context, pli_world_def, &used, world_fields, __func__);
    pli_world* made = plii_handle_create(context, PLII_HANDLE_WORLD, sizeof *made);
    if (made == NULL) { return PLII_FAIL(context, PLI_ERROR_OUT_OF_MEMORY, "no memory for the world"); }
    made->context = context;
    made->def = used;
    *world = made;
    return PLI_OK;
}

void pli_world_destroy(pli_world* world) {
    if (world == NULL || plii_check_world_change(world, __func__) != PLI_OK) { return; }
    pli_context* context = world->context;
    world->is_stepping = false;
    while (world->body_count > 0) {
        pli_body_destroy(world->bodies[world->body_count - 1]);
    }
    while (world->rigid_count > 0) {
        pli_rigid_destroy(world->rigids[world->rigid_count - 1]);
    }
    PLII_RELEASE(context, world->bodies, world->body_capacity);
    PLII_RELEASE(context, world->sweep, world->sweep_capacity);
    PLII_RELEASE(context, world->pairs, world->pair_capacity);
    PLII_RELEASE(context, world->pair_orders, world->pair_order_capacity);
    PLII_RELEASE(context, world->islands, world->island_capacity);
    PLII_RELEASE(context, world->group_roots, world->group_root_capacity);
    PLII_RELEASE(context, world->group_begin, world->group_begin_capacity);
    PLII_RELEASE(context, world->group_bodies, world->group_body_capacity);
    PLII_RELEASE(context, world->rigids, world->rigid_capacity);
    PLII_RELEASE(context, world->events, world->event_capacity);
    plii_handle_release(context, world, PLII_HANDLE_WORLD, sizeof *world);
}

PLII_DEFINE_GET(pli_context*, pli_world_get_context, world, world->context, NULL)
PLII_DEFINE_GET(void*, pli_world_get_user_data, world, world->def.user_data, NULL)
PLII_DEFINE_GET(pli_vec3, pli_world_get_gravity, world, world->def.gravity, pli_vec3_make(0, 0, 0))

pli_status pli_world_set_gravity(pli_world* world, pli_vec3 gravity) {
    PLII_TRY(plii_check_world_change(world, __func__));
    PLII_TRY(plii_check_vec3_within(world->context, gravity, PLI_MAX_ACCELERATION, "gravity", __func__));
    const bool is_same = memcmp(&world->def.gravity, &gravity, sizeof gravity) == 0;
    for (int i = 0; i < world->body_count && !is_same; ++i) {
        plii_body_note_change(world->bodies[i]);
    }
    world->def.gravity = gravity;
    return PLI_OK;
}
pli_status pli_world_set_profile(pli_world* world, pli_profile_fn* profile, void* user) {
    PLII_TRY(plii_check_world_idle(world, __func__));
    world->profile = profile;
    world->profile_user = user;
    return PLI_OK;
}

// ---------------------------------------------------------------------------------------------------- lists

/* The most in a step: a body freezes, loses anchors, wakes and falls asleep once; a rigid body is restored once. */
static bool world_reserve_events(pli_world* world, int body_count, int rigid_count) {
    return PLII_RESERVE(world->context, &world->events, &world->event_capacity, 4 * body_count + rigid_count);
}

pli_status plii_world_add_body(pli_world* world, pli_body* body) {
    const int count = world->body_count + 1;
    if (!PLII_RESERVE(world->context, &world->bodies, &world->body_capacity, count) ||
        !PLII_RESERVE(world->context, &world->sweep, &world->sweep_capacity, count) ||
        !PLII_RESERVE(world->context, &world->islands, &world->island_capacity, count) ||
        !plii_groups_reserve(world, count) || !world_reserve_events(world, count, world->rigid_count)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    world->needs_reserve = true;
    body->world_index = world->body_count;
    world->sweep[world->body_count] = body;
    world->bodies[world->body_count++] = body;
    world->revision += 1;
    return PLI_OK;
}

/* Those that name a body or a rigid body that is going. */
static void world_drop_events(pli_world* world, const void* gone) {
    PLII_REMOVE_IF(pli_event, event, world->events, world->event_count, event->body == gone || event->rigid == gone);
}

void plii_world_remove_body(pli_world* world, pli_body* body) {
    plii_features_notify(world, PLII_BODY_REMOVED, body);
    for (int i = body->world_index; i + 1 < world->body_count; ++i) {
        world->bodies[i] = world->bodies[i + 1];
        world->bodies[i]->world_index = i;
    }
    int kept = world->body_count; /* all, where a file is given up before the sweep was read */
    PLII_REMOVE_IF(pli_body*, at, world->sweep, kept, *at == body);
    world->body_count -= 1;
    world->revision += 1;
    world_drop_events(world, body);
}

pli_status plii_world_add_rigid(pli_world* world, pli_rigid* rigid) {
    if (!PLII_RESERVE(world->context, &world->rigids, &world->rigid_capacity, world->rigid_count + 1) ||
        !world_reserve_events(world, world->body_count, world->rigid_count + 1)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    world->needs_reserve = true;
    rigid->world_index = world->rigid_count;
    world->rigids[world->rigid_count++] = rigid;
    world->revision += 1;
    return PLI_OK;
}

void plii_world_remove_rigid(pli_world* world, pli_rigid* rigid) {
    plii_walk walk; /* some ask its shapes */
    plii_walk_begin(&walk, world->context, PLII_WALK_STEP);
    plii_features_notify(world, PLII_RIGID_REMOVED, rigid);
    plii_walk_end(&walk);
    for (int i = 0; i < world->body_count; ++i) {
        plii_body_stop_ignoring(world->bodies[i], rigid);
    }
    for (int i = rigid->world_index; i + 1 < world->rigid_count; ++i) {
        world->rigids[i] = world->rigids[i + 1];
        world->rigids[i]->world_index = i;
    }
    world->rigid_count -= 1;
    world->revision += 1;
    world_drop_events(world, rigid);
}

void plii_world_add_event(pli_world* world, pli_event event) {
    /* Room for the most that there can be was made when bodies were added. */
    if (world->event_count < world->event_capacity) { world->events[world->event_count++] = event; }
}

void plii_world_add_anchors_lost(pli_body* body) {
    pli_world* world = body->world;
    for (int i = 0; i < world->event_count; ++i) {
        if (world->events[i].kind == PLI_EVENT_ANCHORS_LOST && world->events[i].body == body) { return; }
    }
    body->is_woken = true;
    plii_world_add_event(world, (pli_event){.kind = PLI_EVENT_ANCHORS_LOST, .body = body, .node = PLI_NULL_INDEX});
}

PLII_DEFINE_GET(int, pli_world_body_count, world, world->body_count, 0)
pli_body* pli_world_get_body(const pli_world* world, int index) {
    if (plii_check_world(world, __func__) != PLI_OK || index < 0 || index >= world->body_count) { return NULL; }
    return world->bodies[index];
}
PLII_DEFINE_GET(int, pli_world_rigid_count, world, world->rigid_count, 0)
pli_rigid* pli_world_get_rigid(const pli_world* world, int index) {
    if (plii_check_world(world, __func__) != PLI_OK || index < 0 || index >= world->rigid_count) { return NULL; }
    return world->rigids[index];
}
const pli_event* pli_world_get_events(const pli_world* world, int* count) {
    const bool is_world = plii_check_world(world, __func__) == PLI_OK;
    if (count != NULL) { *count = is_world ? world->event_count : 0; }
    return is_world ? world->events : NULL;
}
PLII_DEFINE_GET(bool, pli_world_is_stepping, world, world->is_stepping, false)

// ------------------------------------------------------------------------------------------------- out of memory

/* A step in which memory runs out goes on, without what there is none for; its call tells, and the end of the step. */

uint64_t plii_world_begin_call(pli_world* world, plii_walk* walk) {
    plii_walk_begin(walk, world->context, PLII_WALK_STEP);
    plii_thread.pass = (plii_pass){PLI_NULL_INDEX, NULL};
    return PLII_LOAD(&world->context->shortage.count);
}

static pli_status world_fail_shortage(const pli_world* world, const plii_shortage* shortage, const char* function) {
    const plii_feature_class* feature = shortage->pass.feature;
    return plii_fail(world->context, PLI_ERROR_OUT_OF_MEMORY, function,
                     "no memory, %zu bytes, for %s of body %d; the step goes on without", shortage->size,
                     feature != NULL ? feature->name : "the solver", shortage->pass.body);
}

void plii_world_note_shortage(pli_world* world) {
    if (world->shortage.count == 0) { world->shortage = world->context->shortage; }
}

/* Notes what memory there was none for since `before`. */
pli_status plii_world_end_call(pli_world* world, const plii_walk* walk, uint64_t before, const char* function) {
    const plii_shortage* last = &world->context->shortage;
    plii_walk_end(walk);
    if (PLII_LOAD(&last->count) == before) { return PLI_OK; }
    plii_world_note_shortage(world);
    return function != NULL ? world_fail_shortage(world, last, function) : PLI_ERROR_OUT_OF_MEMORY;
}

// ----------------------------------------------------------------------------------------------------- step

/* Growth belongs here, where something was added, and not into the steps that meet it. */
static void world_reserve(pli_world* world) {
    const uint64_t before = world->context->shortage.count;
    world->most_nodes = world->most_faces = 0;
    for (PLII_EACH_BODY(body, world)) {
        if (body->node_count > world->most_nodes) { world->most_nodes = body->node_count; }
        if (body->topology->face_count > world->most_faces) { world->most_faces = body->topology->face_count; }
    }
    world->has_convex_shapes = world->has_other_shapes = false;
    for (PLII_EACH_RIGID(rigid, world)) {
        for (int k = 0; k < rigid->shape_count; ++k) {
            const bool is_convex = rigid->shapes[k]->def.support != NULL;
            *(is_convex ? &world->has_convex_shapes : &world->has_other_shapes) = true;
        }
    }
    for (PLII_EACH_BODY(body, world)) {
        for (PLII_EACH_FEATURE(feature, body)) {
            if (feature->klass->reserve == NULL) { continue; }
            plii_thread.pass = (plii_pass){body->world_index, feature->klass};
            feature->klass->reserve(body, feature->state);
        }
    }
    world->needs_reserve = world->context->shortage.count != before;
}

/* Bodies that froze on any thread, in their order. */
static void world_tell_frozen(pli_world* world) {
    if (!world->has_frozen) { return; }
    world->has_frozen = false;
    for (PLII_EACH_BODY(body, world)) {
        if (!body->was_frozen) { continue; }
        body->was_frozen = false;
        plii_world_add_event(world, (pli_event){.kind = PLI_EVENT_BODY_FROZEN, .body = body, .node = body->lost_node});
    }
}

void plii_world_note_frozen(pli_world* world) {
    PLII_STORE(&world->has_frozen, true);
    if (!PLII_LOAD(&world->is_entered)) { world_tell_frozen(world); } /* by a call between steps */
}

static void world_predict_body(pli_body* body) {
    plii_world_begin_body(body);
    const pli_world* world = body->world;
    const float dt = world->take_update_intervals != NULL ? body->interval.step : world->dt;
    /* What was added acts for a step of the world. A longer one of the body gets the same impulse. */
    for (int i = 0; dt != world->dt && body->forces != NULL && i < body->node_count; ++i) {
        body->forces[i] = pli_vec3_scale(body->forces[i], world->dt / dt);
    }
    body->solver_class->predict(body, dt);
    body->has_crosses = body->has_swept_contacts = false; /* nodes have moved */
}

static pli_status world_predict(pli_world* world, float dt, const char* function) {
    PLII_FAIL_IF(world->is_stepping, world->context, PLI_ERROR_WRONG_STATE, function,
                 "the step before has not been solved");
    PLII_TRY(plii_check_between(world->context, dt, PLI_MIN_TIME_STEP, PLI_MAX_TIME_STEP, "dt", function));
    world->shortage.count = 0;
    if (world->needs_reserve && world->def.preallocates) { world_reserve(world); }
    plii_walk walk;
    const uint64_t before = plii_world_begin_call(world, &walk);
    world->is_stepping = true;
    world->dt = dt;
    world->event_count = 0;
    if (world->take_update_intervals != NULL) { world->take_update_intervals(world, dt); }
    plii_islands_start(world);
    plii_groups_start(world);
    if (world->sleep != NULL) { world->sleep->begin_step(world, dt); }
    for (int i = 0; i < world->rigid_count; ++i) {
        plii_rigid_begin_step(world->rigids[i]);
    }
    plii_world_profile(world, "predict", NULL, true);
    if (!world->has_groups || !plii_groups_run_bodies(world, world_predict_body)) {
        /* From the last one, still in the caches from the step before, to the first one, which is solved first. */
        for (int i = world->body_count - 1; i >= 0; --i) {
            if (!plii_body_is_idle(world->bodies[i])) { world_predict_body(world->bodies[i]); }
        }
    }
    if (world->sleep != NULL) { world->sleep->wake_met(world, world_predict_body); }
    world_tell_frozen(world);
    plii_world_profile(world, "predict", NULL, false);
    (void)plii_world_end_call(world, &walk, before, NULL); /* the solve tells */
    return PLI_OK;
}

pli_status pli_world_predict(pli_world* world, float dt) {
    PLII_TRY(world_enter(world, __func__));
    return world_leave(world, world_predict(world, dt, __func__));
}

static void world_run_joint_stage(pli_world* world, plii_stage stage) {
    for (PLII_EACH_BODY(body, world)) {
        if (plii_body_is_idle(body)) { continue; }
        plii_world_begin_body(body);
        plii_run_stage(body, stage);
    }
}

/* Joints and cluster contacts couple bodies, so all bodies take part in each iteration (btSoftBody::solveClusters). */
static void world_solve_joints(pli_world* world) {
    int iterations = 0;
    for (PLII_EACH_BODY(body, world)) {
        if (!plii_body_is_idle(body) && body->joint_iterations > iterations) { iterations = body->joint_iterations; }
    }
    if (iterations == 0) { return; }
    world->joint_iterations = iterations;
    world_run_joint_stage(world, PLII_STAGE_JOINT_PREPARE);
    world_run_joint_stage(world, PLII_STAGE_JOINT_START);
    for (int i = 0; i < iterations; ++i) {
        world_run_joint_stage(world, PLII_STAGE_JOINT_SOLVE);
    }
    world_run_joint_stage(world, PLII_STAGE_JOINT_FINISH);
}

/* Soft contacts move the nodes of other bodies, so what follows from positions waits for all solves of the group. */
static void world_refresh_bodies(pli_body* const* bodies, int count) {
    for (int i = 0; i < count; ++i) {
        bodies[i]->is_solved = false;
        if (bodies[i]->is_frozen && bodies[i]->forces != NULL) { /* used up all the same, not saved up */
            memset(bodies[i]->forces, 0, (size_t)bodies[i]->node_count * sizeof *bodies[i]->forces);
        }
        if (plii_body_is_idle(bodies[i])) { continue; }
        plii_world_begin_body(bodies[i]);
        plii_body_refresh_in_step(bodies[i]);
    }
}

static void world_solve_group(pli_body* const* bodies, int count) {
    plii_islands_solve(bodies, count);
    world_refresh_bodies(bodies, count);
}

/* Rigid bodies that are too fast or not finite get back what they had, and those that something touched when a body was
   put back while it was solved, since its impulses are among theirs. */
static void world_end_trouble(pli_world* world, int events_before) {
    bool has_frozen = false;
    for (int i = events_before; i < world->event_count; ++i) {
        if (world->events[i].kind != PLI_EVENT_BODY_FROZEN) { continue; }
        has_frozen = true;
        plii_solver_set_start(world->events[i].body); /* bodies solved later may have moved it */
    }
    for (PLII_EACH_RIGID(rigid, world)) {
        if (!rigid->was_touched) { continue; }
        if (plii_rigid_is_slow(rigid) && !has_frozen) {
            plii_rigid_end_path(rigid, world->dt);
            continue;
        }
        const plii_twist velocity = plii_rigid_velocity(rigid);
        if (memcmp(&velocity, &rigid->start, sizeof velocity) == 0) { continue; }
        plii_rigid_set_velocity(rigid, rigid->start);
        rigid->path.has_begun = false;
        plii_world_add_event(world,
                             (pli_event){.kind = PLI_EVENT_RIGID_RESTORED, .rigid = rigid, .node = PLI_NULL_INDEX});
    }
}

static pli_status world_solve(pli_world* world, const char* function) {
    PLII_FAIL_IF(!world->is_stepping, world->context, PLI_ERROR_WRONG_STATE, function, "nothing was predicted");
    plii_walk walk;
    const uint64_t before = plii_world_begin_call(world, &walk);
    const int events_before = world->event_count;
    PLII_WORLD_RUN_PROFILED(world, "joints", NULL, world_solve_joints(world));
    plii_islands_find(world);
    if (plii_groups_find(world)) {
        plii_groups_run(world, world_solve_group);
    } else {
        PLII_WORLD_RUN_PROFILED(world, "solve", NULL, plii_islands_solve(world->bodies, world->body_count));
        PLII_WORLD_RUN_PROFILED(world, "refresh", NULL, world_refresh_bodies(world->bodies, world->body_count));
    }
    world_tell_frozen(world);
    world_end_trouble(world, events_before);
    if (world->sleep != NULL) { world->sleep->end_step(world, world->dt); }
    world->is_stepping = false;
    (void)plii_world_end_call(world, &walk, before, NULL);
    return world->shortage.count > 0 ? world_fail_shortage(world, &world->shortage, function) : PLI_OK;
}

pli_status pli_world_solve(pli_world* world) {
    PLII_TRY(world_enter(world, __func__));
    return world_leave(world, world_solve(world, __func__));
}

static pli_status world_step(pli_world* world, float dt, const char* function) {
    PLII_TRY(world_predict(world, dt, function));
    plii_walk walk;
    const uint64_t before = plii_world_begin_call(world, &walk);
    plii_world_collide_all(world);
    (void)plii_world_end_call(world, &walk, before, NULL);
    return world_solve(world, function);
}

pli_status pli_world_step(pli_world* world, float dt) {
    PLII_TRY(world_enter(world, __func__));
    return world_leave(world, world_step(world, dt, __func__));
}
