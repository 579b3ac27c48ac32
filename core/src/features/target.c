/* Targets: balls around points that the game moves, which nodes do not leave, and spheres behind these points that they
   do not enter. Nodes at their targets are pinned and led, so that every solver knows how heavy they are. */

#include "pliant/target.h"
#include "body/pipeline.h"
#include "body/substep.h"

/* Where a target is. */
typedef struct target_pose {
    pli_vec3 position, normal; /* the normal is unit where there is a backstop */
} target_pose;

typedef struct target_item {
    pli_target limits;
    bool is_held;         /* pinned, at the target */
    float inverse_mass;   /* of a held node when it is let go, 1/kg */
    int parents[2];       /* items; those of the definition have none */
    float share;          /* between the parents, of what a cut has added */
    target_pose from, to; /* at the start and the end of the step */
} target_item;

typedef struct target_state {
    target_item* items;
    int count, capacity;
    int given;   /* items of the definition, which come first */
    int* places; /* [node_count] 1 + item, 0: none */
    bool has_limits;
} target_state;

// ---------------------------------------------------------------------------------------------- where nodes may be

static target_pose target_between(const target_pose* a, const target_pose* b, float share) {
    target_pose pose = {pli_vec3_lerp(a->position, b->position, share), pli_vec3_lerp(a->normal, b->normal, share)};
    const float length = pli_vec3_length(pose.normal);
    /* Opposite normals have no direction between them. */
    pose.normal = length > 1e-3f ? pli_vec3_scale(pose.normal, 1.0f / length) : b->normal;
    return pose;
}

/* In the plane of the normal and the node: out of the sphere, but not out of the ball. In double precision, as radii
   may be those of a plane. `along` the normal and `across` it, from the target. */
static void target_leave_backstop(const pli_target* limits, double* along, double* across) {
    const double radius = (double)limits->backstop_radius, most = (double)limits->max_distance;
    const double height = (double)limits->backstop_distance + radius, up = *along + height;
    const double distance = sqrt(up * up + *across * *across);
    if (!(distance < radius)) { return; }
    const double scale = distance > 0.0 ? radius / distance : 0.0;
    *along = (distance > 0.0 ? up * scale : radius) - height;
    *across *= scale;
    if (!(*along * *along + *across * *across > most * most)) { return; }
    /* The circle where both meet; `most` is above 0 and the target outside of the sphere or near to its surface. */
    const double behind = -(double)limits->backstop_distance * (height + radius) - most * most;
    *along = fmax(fmin(behind / (2.0 * height), most), -most);
    *across = sqrt(fmax(most * most - *along * *along, 0.0));
}

/* The nearest place for a node, more or less. */
static pli_vec3 target_allowed(const pli_target* limits, const target_pose* pose, pli_vec3 x) {
    pli_vec3 apart = pli_vec3_sub(x, pose->position);
    const float squared = pli_vec3_length_squared(apart), most = limits->max_distance;
    const bool is_beyond = squared > most * most && plii_is_finite(squared);
    if (is_beyond) { apart = pli_vec3_scale(apart, most / sqrtf(squared)); }
    const pli_vec3 inside = is_beyond ? pli_vec3_add(pose->position, apart) : x;
    if (!(limits->backstop_radius > 0.0f) || !(most > 0.0f)) { return inside; }
    const float along = pli_vec3_dot(apart, pose->normal);
    const pli_vec3 side = pli_vec3_sub(apart, pli_vec3_scale(pose->normal, along));
    const float across = pli_vec3_length(side);
    double new_along = (double)along, new_across = (double)across;
    target_leave_backstop(limits, &new_along, &new_across);
    if (new_along == (double)along && new_across == (double)across) { return inside; }
    const pli_vec3 unit = across > 0.0f ? pli_vec3_scale(side, 1.0f / across) : plii_vec3_perpendicular(pose->normal);
    return pli_vec3_add(pose->position, pli_vec3_add(pli_vec3_scale(pose->normal, (float)new_along),
                                                     pli_vec3_scale(unit, (float)new_across)));
}

/* Pinned by the caller, or by this feature: it is not limited. */
static bool target_is_free(const pli_body* body, const target_item* item) {
    return body->positions[item->limits.node].w > 0.0f;
}

// ---------------------------------------------------------------------------------------------------------- the step

static void target_start(pli_body* body, void* data) {
    const target_state* state = data;
    for (PLII_EACH(const target_item, item, state->items, state->count)) {
        const int node = item->limits.node;
        if (!item->is_held || target_is_free(body, item)) { continue; }
        const pli_vec3 way = pli_vec3_sub(item->to.position, plii_xyz(body->positions[node]));
        plii_set_xyz(&body->velocities[node], pli_vec3_scale(way, body->step.inverse_dt));
    }
}

static void target_solve(pli_body* body, void* data) {
    const target_state* state = data;
    for (PLII_EACH(const target_item, item, state->items, state->count)) {
        if (!target_is_free(body, item)) { continue; }
        pli_vec4* position = &body->positions[item->limits.node];
        plii_set_xyz(position, target_allowed(&item->limits, &item->to, plii_xyz(*position)));
    }
}

static void target_finish(pli_body* body, void* data) {
    target_state* state = data;
    for (PLII_EACH(target_item, item, state->items, state->count)) {
        const int node = item->limits.node;
        if (item->is_held && !target_is_free(body, item)) {
            const pli_vec3 way = pli_vec3_sub(item->to.position, plii_xyz(body->previous[node]));
            plii_set_xyz(&body->positions[node], item->to.position); /* but for rounding it is there */
            plii_set_xyz(&body->velocities[node], pli_vec3_scale(way, body->step.inverse_dt));
        }
        item->from = item->to;
    }
}

static void target_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const target_state* state = data;
    const float share = (float)(substep->index + 1) * substep->dt * body->step.inverse_dt;
    for (PLII_EACH(const target_item, item, state->items, state->count)) {
        const int node = item->limits.node;
        if (!target_is_free(body, item)) { continue; }
        const target_pose pose = target_between(&item->from, &item->to, plii_min(share, 1.0f));
        const pli_vec3 place = plii_substep_position(body, substep, node);
        const pli_vec3 move = pli_vec3_sub(target_allowed(&item->limits, &pose, place), place);
        plii_add_xyz(&substep->displacements[node], move);
    }
}

static bool target_is_idle(const void* data) {
    return !((const target_state*)data)->has_limits;
}

/* To the ball around the target. */
static float target_room(const pli_body* body, const void* data, const plii_substep* substep, int node,
                         pli_vec3 direction, float wanted) {
    const target_state* state = data;
    if (state->places[node] == 0 || !(body->positions[node].w > 0.0f)) { return INFINITY; }
    const target_item* item = &state->items[state->places[node] - 1];
    const pli_vec3 apart = pli_vec3_sub(plii_substep_position(body, substep, node), item->to.position);
    return plii_sphere_room(apart, item->limits.max_distance, direction);
}

// --------------------------------------------------------------------------------------------------------- the list

/* A mass that the caller has given to a node meanwhile stays. */
static void target_let_go_all(pli_body* body, void* data) {
    target_state* state = data;
    for (PLII_EACH(const target_item, item, state->items, state->count)) {
        const int node = item->limits.node;
        state->places[node] = 0;
        if (!item->is_held || target_is_free(body, item)) { continue; }
        body->positions[node].w = item->inverse_mass;
        body->velocities[node] = (pli_vec4){0};
        body->link_revision += 1;
    }
    state->count = state->given = 0;
}

/* Puts the node of each where it may be. */
static void target_place_nodes(pli_body* body, target_state* state) {
    for (PLII_EACH(target_item, item, state->items, state->count)) {
        const int node = item->limits.node;
        item->from = item->to;
        if (!item->is_held && !target_is_free(body, item)) { continue; }
        const pli_vec3 place = target_allowed(&item->limits, &item->to, plii_xyz(body->positions[node]));
        if (item->is_held && !target_is_free(body, item)) { body->velocities[node] = (pli_vec4){0}; }
        plii_set_xyz(&body->positions[node], place);
        plii_set_xyz(&body->previous[node], place);
    }
    plii_body_refresh(body);
}

static void target_find_limits(target_state* state) {
    state->has_limits = false;
    for (int i = 0; i < state->count; ++i) {
        state->has_limits = state->has_limits || !state->items[i].is_held;
    }
}

/* Arrays of the given ones, NULL: they stay. What cuts have added goes between its parents, which come before it. */
static void target_set_poses(pli_body* body, target_state* state, const pli_vec3* positions, const pli_vec3* normals) {
    bool has_moved = false;
    for (int i = 0; i < state->count; ++i) {
        target_item* item = &state->items[i];
        const target_pose before = item->to;
        if (i >= state->given) {
            item->to =
                target_between(&state->items[item->parents[0]].to, &state->items[item->parents[1]].to, item->share);
            continue;
        }
        if (positions != NULL) { item->to.position = positions[i]; }
        if (normals != NULL) {
            const float length = pli_vec3_length(normals[i]);
            item->to.normal = pli_vec3_scale(normals[i], length > 0.0f ? 1.0f / length : 0.0f);
        }
        has_moved = has_moved || memcmp(&before, &item->to, sizeof before) != 0;
    }
    if (has_moved) { plii_body_note_change(body); }
}

static bool target_topology_reserve(const pli_body* body, void* data, const plii_topology_change* change) {
    target_state* state = data;
    const int most = state->count + (change->node_count - change->old_node_count);
    return PLII_RESERVE(body->context, &state->items, &state->capacity, most);
}

/* Of a held node between two: as heavy as the point between them, which give it that as they do when they are free. */
static float target_split_mass(target_item* first, target_item* second, float share) {
    const float a = 1.0f / first->inverse_mass, b = 1.0f / second->inverse_mass, between = plii_lerp(a, b, share);
    const float scale = (a + b) / (a + b + between);
    first->inverse_mass /= scale;
    second->inverse_mass /= scale;
    return between * scale;
}

static void target_add_between(pli_body* body, target_state* state, int node, const plii_node_origin* origin) {
    const int a = state->places[origin->a] - 1, b = state->places[origin->b] - 1;
    if (a < 0 || b < 0) { return; }
    target_item *first = &state->items[a], *second = &state->items[b];
    if (origin->a == origin->b) { first->inverse_mass *= 2.0f; } /* a copy: each has half of the mass */
    const float share = origin->share;
    const pli_target *low = &first->limits, *high = &second->limits;
    target_item* item = &state->items[state->count];
    *item = (target_item){
        .limits = {.node = node,
                   .max_distance = plii_lerp(low->max_distance, high->max_distance, share),
                   .backstop_distance = plii_lerp(low->backstop_distance, high->backstop_distance, share),
                   .backstop_radius = plii_lerp(low->backstop_radius, high->backstop_radius, share)},
        .is_held = first->is_held && second->is_held && !(body->positions[node].w > 0.0f),
        .inverse_mass = plii_lerp(first->inverse_mass, second->inverse_mass, share),
        .parents = {a, b},
        .share = share,
        .from = target_between(&first->from, &second->from, share),
        .to = target_between(&first->to, &second->to, share),
    };
    if (item->is_held && a != b) { item->inverse_mass = 1.0f / target_split_mass(first, second, share); }
    state->places[node] = ++state->count;
}

static void target_topology_commit(pli_body* body, void* data, const plii_topology_change* change) {
    target_state* state = data;
    for (int i = change->old_node_count; i < change->node_count; ++i) {
        target_add_between(body, state, i, &change->node_origins[i - change->old_node_count]);
    }
    target_find_limits(state);
}

// -------------------------------------------------------------------------------------------------------- the feature

/* Before what looks at velocities; after links, self-collision and sweeps over contacts, lest they pull nodes away
   again; before anchors have the last word. Self-collision of faces comes later, as nothing else parts them again. */
enum { TARGET_START_ORDER = 0, TARGET_ORDER = 310, TARGET_SUBSTEP_ORDER = 900, TARGET_FINISH_ORDER = 190 };

static bool target_is_sound(const pli_body* body, const void* data) {
    const target_state* state = data;
    if (state->given < 0 || state->given > state->count) { return false; }
    for (int i = state->given; i < state->count; ++i) {
        const int* parents = state->items[i].parents;
        if (parents[0] < 0 || parents[0] >= i || parents[1] < 0 || parents[1] >= i) { return false; }
    }
    for (int i = 0; i < body->node_count; ++i) {
        if (state->places[i] < 0 || state->places[i] > state->count) { return false; }
    }
    return true;
}

const plii_feature_class plii_target_class = {
    .name = "targets",
    .state_size = sizeof(target_state),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(target_state, given, PLII_SAVED, "i"),
                                    PLII_STATE_OF(target_state, has_limits, PLII_SAVED, "B")),
    .is_sound = target_is_sound,
    .arrays = PLII_ARRAYS(
        {PLII_COUNTED_LIST(target_state, items, capacity, count), .is_kept = true, PLII_SAVED_AS("n3fBf2if12f"),
         .settings =
             PLII_LIMITS_AT(offsetof(target_item, limits), PLII_FIELD(pli_target, max_distance, 0, PLI_MAX_COORDINATE),
                            PLII_FIELD(pli_target, backstop_distance, -PLI_MAX_COORDINATE, PLI_MAX_COORDINATE),
                            PLII_FIELD(pli_target, backstop_radius, 0, PLI_MAX_COORDINATE))},
        {PLII_MEMBER(target_state, places), PLII_PER_NODE, .is_kept = true, PLII_SAVED_AS("i")}),
    .stages = {[PLII_STAGE_FORCES] = {target_start, TARGET_START_ORDER},
               [PLII_STAGE_POSITION] = {target_solve, TARGET_ORDER},
               [PLII_STAGE_FINISH] = {target_finish, TARGET_FINISH_ORDER}},
    .substepped = PLII_SUBSTEPPED(.order = TARGET_SUBSTEP_ORDER, .sweep = target_sweep, .room = target_room,
                                  .is_idle = target_is_idle),
    .disable = target_let_go_all,
    .topology_reserve = target_topology_reserve,
    .topology_commit = target_topology_commit,
};

// ------------------------------------------------------------------------------------------------------------ checks

/* Of target `index`; without a backstop a normal may be anything finite. */
static pli_status target_check_normal(const pli_body* body, const pli_target* target, const pli_vec3* normals,
                                      int index, const char* function) {
    if (normals == NULL || !(target->backstop_radius > 0.0f)) { return PLI_OK; }
    if (pli_vec3_length(normals[index]) > 0.0f) { return PLI_OK; }
    return plii_fail(body->context, PLI_ERROR_INVALID_VALUE, function, "normal %d has no length, target %d a backstop",
                     index, index);
}

static pli_status target_check(const pli_body* body, const pli_targets_def* def, int index, int* users,
                               const char* function) {
    const pli_target* target = &def->targets[index];
    const int node = target->node;
    const float most = PLI_MAX_COORDINATE;
    PLII_FAIL_IF(node < 0 || node >= body->node_count, body->context, PLI_ERROR_INDEX_OUT_OF_RANGE, function,
                 "node %d of target %d is out of range, the body has %d nodes", node, index, body->node_count);
    PLII_FAIL_IF(users[node] > 0, body->context, PLI_ERROR_INVALID_VALUE, function,
                 "targets %d and %d are both of node %d", users[node] - 1, index, node);
    users[node] = index + 1;
    PLII_TRY(
        plii_body_check_between(body, "max_distance of target", index, target->max_distance, 0.0f, most, function));
    PLII_TRY(plii_body_check_between(body, "backstop_radius of target", index, target->backstop_radius, 0.0f, most,
                                     function));
    PLII_TRY(plii_body_check_between(body, "backstop_distance of target", index, target->backstop_distance,
                                     -target->max_distance, most, function));
    PLII_FAIL_IF(target->backstop_radius > 0.0f && def->normals == NULL, body->context, PLI_ERROR_INVALID_VALUE,
                 function, "normals is null, target %d has a backstop", index);
    return target_check_normal(body, target, def->normals, index, function);
}

static pli_status target_check_def(pli_body* body, const pli_targets_def* def, const char* function) {
    pli_context* context = body->context;
    PLII_TRY(PLII_CHECK_MADE(context, pli_targets_def, def, function));
    if (def->targets == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "targets is null"); }
    PLII_FAIL_IF(def->count < 1, context, PLI_ERROR_INVALID_VALUE, function, "count is %d, below 1", def->count);
    PLII_TRY(plii_check_finite_points(context, def->count, def->positions, "position", function));
    PLII_TRY(plii_check_finite_points(context, def->count, def->normals, "normal", function));
    plii_scratch scratch = {.context = context};
    int* users = PLII_TAKE(&scratch, int, body->node_count);
    pli_status status = PLI_OK;
    if (scratch.is_short) {
        status = plii_fail(context, PLI_ERROR_OUT_OF_MEMORY, function, "no memory for %d targets", def->count);
    }
    for (int i = 0; i < def->count && status == PLI_OK; ++i) {
        status = target_check(body, def, i, users, function);
    }
    plii_scratch_free(&scratch);
    return status;
}

// ------------------------------------------------------------------------------------------------------------- calls

static pli_status target_move(pli_body* body, const pli_vec3* positions, const pli_vec3* normals, int count,
                              bool takes_nodes, const char* function) {
    PLII_TRY(plii_check_body_idle(body, function));
    target_state* state = plii_feature_state(body, &plii_target_class);
    const int given = state != NULL ? state->given : 0;
    PLII_FAIL_IF(count != given || given == 0, body->context, PLI_ERROR_INVALID_VALUE, function,
                 "count is %d, the body has %d targets", count, given);
    if (positions == NULL) { return plii_fail(body->context, PLI_ERROR_NULL_ARGUMENT, function, "positions is null"); }
    PLII_TRY(plii_check_finite_points(body->context, count, positions, "position", function));
    PLII_TRY(plii_check_finite_points(body->context, count, normals, "normal", function));
    for (int i = 0; i < count; ++i) {
        PLII_TRY(target_check_normal(body, &state->items[i].limits, normals, i, function));
    }
    target_set_poses(body, state, positions, normals);
    if (takes_nodes) { target_place_nodes(body, state); }
    return PLI_OK;
}

PLII_DEFINE_DEFAULT(pli_targets_def, 0)
pli_status pli_body_enable_targets(pli_body* body, const pli_targets_def* def) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    PLII_TRY(target_check_def(body, def, __func__));
    PLII_TRY_ENABLE(body, target_state, state, plii_target_class);
    if (!PLII_RESERVE(body->context, &state->items, &state->capacity, def->count)) {
        return PLII_FAIL_ENABLED(body, plii_target_class, __func__, "no memory for %d targets", def->count);
    }
    target_let_go_all(body, state);
    state->count = state->given = def->count;
    for (int i = 0; i < def->count; ++i) {
        target_item* item = &state->items[i];
        *item = (target_item){.limits = def->targets[i]};
        pli_vec4* position = &body->positions[item->limits.node];
        item->to.position = plii_xyz(*position);
        item->is_held = item->limits.max_distance == 0.0f && position->w > 0.0f;
        state->places[item->limits.node] = i + 1;
        if (!item->is_held) { continue; }
        item->inverse_mass = position->w;
        position->w = 0.0f;
        body->velocities[item->limits.node] = (pli_vec4){0};
        body->link_revision += 1;
    }
    target_set_poses(body, state, def->positions, def->normals);
    target_find_limits(state);
    target_place_nodes(body, state);
    return plii_body_changed(body, PLI_OK);
}

PLII_DEFINE_DISABLE(pli_body_disable_targets, plii_check_body_idle, plii_target_class)

pli_status pli_body_move_targets(pli_body* body, const pli_vec3* positions, const pli_vec3* normals, int count) {
    return target_move(body, positions, normals, count, false, __func__);
}
pli_status pli_body_teleport_targets(pli_body* body, const pli_vec3* positions, const pli_vec3* normals, int count) {
    return target_move(body, positions, normals, count, true, __func__);
}
