/* Sleep: which bodies rest, what falls asleep together, and what wakes it. */

#include "base/union_find.h"
#include "body/pipeline.h"
#include "math/bounds.h"

typedef struct sleep_state {
    pli_sleep_def def;
    float time;       /* s, since `places` were taken */
    pli_vec3* places; /* [node_count] m */
} sleep_state;

PLII_DEFINE_DEFAULT(pli_sleep_def, .speed = 0.05f, .time = 0.5f)

static bool sleep_is_near(pli_vec3 a, pli_vec3 b, float reach) {
    const pli_vec3 d = pli_vec3_sub(a, b);
    return pli_vec3_dot(d, d) <= reach * reach;
}

// ------------------------------------------------------------------------------------------------------------- rest

static void sleep_take_places(pli_body* body, void* data) {
    sleep_state* state = data;
    plii_body_copy_positions(body, state->places);
    state->time = 0.0f;
}

static void sleep_refresh(pli_body* body, void* data) {
    sleep_state* state = data;
    const float reach = state->def.speed * state->def.time;
    int node = 0;
    while (node < body->node_count && sleep_is_near(plii_xyz(body->positions[node]), state->places[node], reach)) {
        ++node;
    }
    state->time += body->step.dt;
    if (node < body->node_count) { sleep_take_places(body, state); }
    body->is_resting = state->time >= state->def.time;
}

/* m, how far its shapes reach from the middle of them; of a body without shapes only the origin counts. */
static float sleep_radius(const pli_rigid* rigid, pli_bounds bounds) {
    return rigid->shape_count > 0 ? 0.5f * pli_vec3_length(pli_vec3_sub(bounds.max, bounds.min)) : 0.0f;
}

/* By the default settings, of its origin and of what its bounds reach. */
static void sleep_judge_rigid(pli_rigid* rigid, float dt) {
    const pli_sleep_def def = pli_sleep_def_default();
    const float reach = def.speed * def.time;
    const pli_transform *pose = &rigid->state.pose, *rest = &rigid->rest_pose;
    const float radius = sleep_radius(rigid, rigid->step_bounds);
    bool rests = sleep_is_near(pose->origin, rest->origin, reach);
    for (int i = 0; i < 3; ++i) {
        rests = rests && sleep_is_near(pli_vec3_scale(pose->rotation.rows[i], radius),
                                       pli_vec3_scale(rest->rotation.rows[i], radius), reach);
    }
    if (!rests) {
        rigid->rest_pose = *pose;
        rigid->rest_time = 0.0f;
    } else if (rigid->rest_time < def.time) {
        rigid->rest_time += dt;
    }
}

// --------------------------------------------------------------------------------------------------- who holds whom

typedef struct sleep_search {
    const pli_body* body;
    const pli_rigid* rigid;
    bool is_found;
} sleep_search;

static void sleep_note_joined(pli_body* body, pli_rigid* rigid, void* user) {
    sleep_search* search = user;
    search->is_found =
        search->is_found || (body != NULL && body == search->body) || (rigid != NULL && rigid == search->rigid);
}

/* By a joint or an anchor. */
static bool sleep_holds(const pli_body* body, const pli_body* other, const pli_rigid* rigid) {
    sleep_search search = {.body = other, .rigid = rigid};
    plii_features_visit_joined(body, sleep_note_joined, &search);
    return search.is_found;
}

/* Of the margin. What lies on a body is a margin away from it, but for rounding and what moves below `speed`. */
#define SLEEP_NEAR 0.1f

static pli_bounds sleep_bounds(const pli_body* body) {
    return plii_bounds_grow(body->bounds, SLEEP_NEAR * body->collision_margin);
}

static bool sleep_touches_rigid(const pli_body* body, const pli_rigid* rigid, pli_bounds bounds) {
    if (rigid->is_absent || rigid->is_sensor) { return false; }
    const bool overlaps = plii_bounds_overlap(sleep_bounds(body), bounds) && !plii_body_ignores_rigid(body, rigid);
    return overlaps || sleep_holds(body, NULL, rigid);
}

static bool sleep_touches_body(const pli_body* body, const pli_body* other) {
    const bool overlaps = body->collides_with_bodies && other->collides_with_bodies &&
                          plii_bounds_overlap(sleep_bounds(body), sleep_bounds(other));
    return overlaps || sleep_holds(body, other, NULL) || sleep_holds(other, body, NULL);
}

// ------------------------------------------------------------------------------------------------------------ waking

/* All that fell asleep with it; `run`, if there is one, is called for each body. */
static void sleep_wake_group(pli_world* world, uint32_t group, void (*run)(pli_body* body)) {
    for (PLII_EACH_RIGID(rigid, world)) {
        if (rigid->sleep_group != group) { continue; }
        rigid->sleep_group = 0;
        rigid->is_asleep = false;
        rigid->rest_time = 0.0f;
    }
    for (int i = world->body_count - 1; i >= 0; --i) {
        pli_body* body = world->bodies[i];
        if (body->sleep_group != group) { continue; }
        body->sleep_group = 0;
        body->is_asleep = body->is_woken = body->is_resting = false;
        sleep_state* state = plii_feature_state(body, &plii_sleep_class);
        if (state != NULL) { sleep_take_places(body, state); }
        if (run != NULL && !body->is_frozen) { run(body); }
    }
}

static void sleep_tell(pli_world* world) {
    for (PLII_EACH_BODY(body, world)) {
        if (body->is_asleep == body->was_asleep) { continue; }
        body->was_asleep = body->is_asleep;
        const pli_event_kind kind = body->is_asleep ? PLI_EVENT_BODY_ASLEEP : PLI_EVENT_BODY_AWAKE;
        plii_world_add_event(world, (pli_event){.kind = kind, .body = body, .node = PLI_NULL_INDEX});
    }
}

/* Below what rests; in the step in which its host puts it to sleep it may still do so. */
static bool sleep_rigid_is_slow(const pli_rigid* rigid) {
    const pli_sleep_def def = pli_sleep_def_default();
    const float radius = sleep_radius(rigid, plii_rigid_bounds(rigid));
    const float speed = pli_vec3_length(rigid->state.linear_velocity);
    return speed + radius * pli_vec3_length(rigid->state.angular_velocity) <= def.speed;
}

static void sleep_note_seen(pli_rigid* rigid) {
    rigid->has_changed = false;
    rigid->seen_version = rigid->pose_version;
}

/* A host that puts to sleep looks at rigid bodies itself, but for those that the core knows as anchors. */
static void sleep_wake_by_rigid(pli_world* world, const pli_rigid* rigid, float dt) {
    const bool has_changed = rigid->has_changed, has_moved = rigid->seen_version != rigid->pose_version;
    const bool is_by_host = world->def.host_puts_to_sleep;
    if (is_by_host && !has_changed && rigid->kind == PLI_RIGID_DYNAMIC && sleep_rigid_is_slow(rigid)) { return; }
    const bool is_still = rigid->kind == PLI_RIGID_STATIC || (plii_vec3_is_zero(rigid->state.linear_velocity) &&
                                                              plii_vec3_is_zero(rigid->state.angular_velocity));
    if (rigid->is_asleep || !(has_changed || has_moved || !(is_by_host || is_still))) { return; }
    const pli_bounds bounds = plii_rigid_swept_bounds(rigid, dt);
    for (PLII_EACH_BODY(body, world)) {
        if (!body->is_asleep) { continue; }
        const bool is_woken = is_by_host
                                  ? sleep_holds(body, NULL, rigid)
                                  : (has_changed && plii_bounds_overlap(sleep_bounds(body), rigid->step_bounds)) ||
                                        sleep_touches_rigid(body, rigid, rigid->step_bounds) ||
                                        sleep_touches_rigid(body, rigid, bounds);
        if (is_woken) { sleep_wake_group(world, body->sleep_group, NULL); }
    }
}

static void sleep_begin_step(pli_world* world, float dt) {
    bool is_any_asleep = false;
    for (PLII_EACH_BODY(body, world)) {
        is_any_asleep = is_any_asleep || body->is_asleep;
        if (body->is_asleep && body->is_woken) { sleep_wake_group(world, body->sleep_group, NULL); }
    }
    for (PLII_EACH_RIGID(rigid, world)) {
        if (rigid->sleep_group != 0 && !rigid->is_asleep) { sleep_wake_group(world, rigid->sleep_group, NULL); }
    }
    for (int i = 0; i < world->rigid_count; ++i) {
        if (is_any_asleep) { sleep_wake_by_rigid(world, world->rigids[i], dt); }
        sleep_note_seen(world->rigids[i]);
    }
    sleep_tell(world);
}

/* What wakes is predicted, and may wake more. */
static void sleep_wake_met(pli_world* world, void (*predict)(pli_body* body)) {
    for (bool has_woken = true; has_woken;) {
        has_woken = false;
        for (PLII_EACH_BODY(body, world)) {
            for (int k = 0; k < world->body_count && body->is_asleep; ++k) {
                const pli_body* other = world->bodies[k];
                if (plii_body_is_idle(other) || !sleep_touches_body(body, other)) { continue; }
                sleep_wake_group(world, body->sleep_group, predict);
                has_woken = true;
            }
        }
        for (PLII_EACH_RIGID(rigid, world)) {
            for (int k = 0; k < world->body_count && rigid->is_asleep; ++k) {
                const pli_body* other = world->bodies[k];
                if (plii_body_is_idle(other) || !sleep_touches_rigid(other, rigid, rigid->step_bounds)) { continue; }
                sleep_wake_group(world, rigid->sleep_group, predict);
                has_woken = true;
            }
        }
    }
    sleep_tell(world);
}

// ---------------------------------------------------------------------------------------------------- falling asleep

/* Bodies that touch the same dynamic rigid body make a set. */
static void sleep_join_by_rigids(pli_world* world, const pli_body* body, int* parents) {
    for (PLII_EACH_RIGID(rigid, world)) {
        if (rigid->kind != PLI_RIGID_DYNAMIC || !sleep_touches_rigid(body, rigid, rigid->step_bounds)) { continue; }
        if (rigid->first_body == PLI_NULL_INDEX) { rigid->first_body = body->world_index; }
        plii_union_join(parents, rigid->first_body, body->world_index);
    }
}

/* And bodies that touch each other. */
static void sleep_join_bodies(const pli_world* world, const pli_body* body, int* parents) {
    for (PLII_EACH_BODY(other, world)) {
        if (other == body || plii_body_is_idle(other) || !sleep_touches_body(body, other)) { continue; }
        plii_union_join(parents, body->world_index, other->world_index);
    }
}

/* Whoever does not rest keeps its set awake. */
static void sleep_judge_groups(pli_world* world, int* parents) {
    for (PLII_EACH_BODY(body, world)) {
        body->is_group_resting = true;
    }
    for (PLII_EACH_BODY(body, world)) {
        const bool rests = body->is_asleep || (body->is_resting && body->can_sleep && !body->is_frozen);
        if (!rests) { world->bodies[plii_union_root(parents, body->world_index)]->is_group_resting = false; }
    }
    for (PLII_EACH_RIGID(rigid, world)) {
        if (rigid->first_body == PLI_NULL_INDEX || rigid->rest_time >= pli_sleep_def_default().time) { continue; }
        world->bodies[plii_union_root(parents, rigid->first_body)]->is_group_resting = false;
    }
}

static void sleep_put_to_sleep(pli_world* world, int* parents) {
    for (PLII_EACH_BODY(body, world)) {
        const pli_body* root = world->bodies[plii_union_root(parents, body->world_index)];
        if (plii_body_is_idle(body) || !root->is_group_resting) { continue; }
        plii_body_fall_asleep(body, root == body ? plii_world_next_sleep_group(world) : root->sleep_group);
    }
    for (PLII_EACH_RIGID(rigid, world)) {
        sleep_note_seen(rigid);
        if (rigid->first_body == PLI_NULL_INDEX) { continue; }
        const pli_body* root = world->bodies[plii_union_root(parents, rigid->first_body)];
        if (!root->is_group_resting) { continue; }
        rigid->is_asleep = true;
        rigid->sleep_group = root->sleep_group;
        plii_rigid_set_velocity(rigid, (plii_twist){0});
        rigid->given = (plii_twist){0};
        rigid->pull = pli_vec3_make(0, 0, 0);
        rigid->path.has_begun = rigid->was_touched = false;
    }
}

static void sleep_end_step(pli_world* world, float dt) {
    if (world->def.host_puts_to_sleep) { return; }
    bool is_any_resting = false;
    for (PLII_EACH_BODY(body, world)) {
        is_any_resting = is_any_resting || (body->is_resting && body->can_sleep && !plii_body_is_idle(body));
    }
    for (PLII_EACH_RIGID(rigid, world)) {
        if (rigid->kind != PLI_RIGID_DYNAMIC && !is_any_resting) { continue; }
        rigid->step_bounds = plii_rigid_bounds(rigid);
        rigid->first_body = PLI_NULL_INDEX;
        if (rigid->kind == PLI_RIGID_DYNAMIC && !rigid->is_asleep) { sleep_judge_rigid(rigid, dt); }
    }
    if (!is_any_resting) { return; }
    int* parents = world->islands; /* of the step, which are done with */
    plii_union_start(world->body_count, parents);
    for (PLII_EACH_BODY(body, world)) {
        if (plii_body_is_idle(body)) { continue; }
        sleep_join_by_rigids(world, body, parents);
        if (body->is_resting) { sleep_join_bodies(world, body, parents); }
    }
    sleep_judge_groups(world, parents);
    sleep_put_to_sleep(world, parents);
    sleep_tell(world);
}

static const plii_world_sleep sleep_calls = {sleep_begin_step, sleep_wake_met, sleep_end_step};

static void sleep_enable(pli_body* body, void* data) {
    pli_world* world = body->world;
    for (int i = 0; i < world->rigid_count && world->sleep == NULL; ++i) {
        sleep_note_seen(world->rigids[i]);
    }
    world->sleep = &sleep_calls;
}

static void sleep_on_rigid_removed(pli_body* body, void* data, plii_notice notice, const void* about) {
    const pli_rigid* rigid = about;
    const bool is_under = plii_bounds_overlap(sleep_bounds(body), plii_rigid_bounds(rigid));
    if (is_under || (rigid->sleep_group != 0 && rigid->sleep_group == body->sleep_group)) { body->is_woken = true; }
}
static void sleep_on_body_removed(pli_body* body, void* data, plii_notice notice, const void* about) {
    if (body == about && body->sleep_group != 0) { sleep_wake_group(body->world, body->sleep_group, NULL); }
}

enum { SLEEP_ORDER = 60 }; /* last of what is made anew */
const plii_feature_class plii_sleep_class = {
    .name = "sleep",
    .state_size = sizeof(sleep_state),
    .settings = PLII_LIMITS_AT(offsetof(sleep_state, def), PLII_FIELD(pli_sleep_def, speed, 0, PLI_MAX_SPEED),
                               PLII_FIELD(pli_sleep_def, time, PLII_ABOVE_0, PLI_MAX_COEFFICIENT)),
    .arrays = PLII_ARRAYS({PLII_MEMBER(sleep_state, places), .length = PLII_PER_NODE, PLII_SAVED_AS("3f")}),
    .stages = {[PLII_STAGE_REFRESH] = {sleep_refresh, SLEEP_ORDER}},
    .enable = sleep_enable,
    .build = sleep_take_places,
    .lets_sleep = true,
    .on = {[PLII_RIGID_REMOVED] = sleep_on_rigid_removed, [PLII_BODY_REMOVED] = sleep_on_body_removed},
    .state_parts = PLII_STATE_PARTS(PLII_STATE_SPAN(sleep_state, def, time, PLII_SAVED, "2fuf")),
};

pli_status pli_body_enable_sleep(pli_body* body, const pli_sleep_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY_SETTINGS(body, pli_sleep_def, used, def, plii_sleep_class);
    sleep_state* state = NULL;
    PLII_TRY(plii_feature_enable_with(body, &plii_sleep_class, &used, sizeof used, (void**)&state));
    state->time = 0.0f;
    body->is_resting = false; /* as it was judged when it came to be there, without settings */
    return PLI_OK;
}
PLII_DEFINE_DISABLE(pli_body_disable_sleep, plii_check_body_idle, plii_sleep_class)
