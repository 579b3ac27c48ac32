/* Anchors between nodes and points of rigid bodies, in the order of creation. Bullet: appendAnchor, PSolve_Anchors. */

#include "pliant/anchor.h"
#include "base/id_pool.h"
#include "body/node_constraint.h"
#include "body/pipeline.h"
#include "body/substep_rigid.h"

typedef struct plii_anchor {
    int node, slot;
    pli_rigid* rigid;
    pli_vec3 pivot; /* in the frame of the rigid body */
    float influence;
    float compliance; /* m/N */
    bool is_idle;     /* in this step: the rigid body is not present */
    /* At the prediction, after which the host may move the rigid body. */
    pli_vec3 start; /* of the goal */
    unsigned pose_version;
    union { /* for one step */
        struct {
            pli_vec3 offset; /* from the centre of the rigid body, world axes */
            pli_vec3 goal;   /* of the node */
            pli_vec3 way;    /* m, of the error at the start of the step, that goes in it; of a dynamic body */
            pli_mat3 matrix; /* from the change of displacement that is wanted to an impulse */
        } step;
        struct {
            plii_substep_rigid_pivot pivot;
            pli_vec3 goal;        /* of the node, at the start of the step */
            pli_vec3 goal_motion; /* in the step, of a rigid body that takes no impulses */
            pli_vec3 left;        /* m, of the error at the start of the substep, after it */
            pli_mat3 inverse;     /* of the sum of both inverse masses and the compliance */
            pli_vec3 multiplier;  /* kg m */
        } substeps;
    };
} plii_anchor;

/* Stays when the last anchor goes, so that old ids stay stale and the hardness is kept. */
typedef struct plii_anchors {
    float hardness;
    plii_anchor* items; /* in the order of creation */
    int item_count, item_capacity;
    plii_id_pool ids;
} plii_anchors;

/* The node is where the body's point is at the end of the step, whatever else pulls at it. */
static bool anchor_is_exact(const pli_body* body, const plii_anchor* anchor) {
    if (anchor->rigid->kind == PLI_RIGID_DYNAMIC || body->world->def.reference_mode) { return false; }
    return body->solver_class->has_substeps ? !(anchor->compliance > 0.0f) : anchor->influence >= 1.0f;
}

/* Of a static or kinematic body: where its velocities lead, from where its host has put it since the prediction. */
static pli_transform anchor_end_pose(const pli_body* body, const plii_anchor* anchor) {
    const pli_rigid* rigid = anchor->rigid;
    float left = body->host_dt;
    if (anchor->pose_version != rigid->pose_version) { left = body->interval.lead; }
    if (rigid->kind == PLI_RIGID_STATIC || !(left > 0.0f)) { return rigid->state.pose; }
    return plii_rigid_advance(rigid->state.pose, plii_rigid_velocity(rigid), left);
}

/* m/s, of dynamic bodies, as the load of a rope that was frozen. Anchors that yield are off by what pulls at them. */
static float anchor_recovery_speed(const pli_body* body, const plii_anchor* anchor) {
    const bool yields = body->solver_class->has_substeps ? anchor->compliance > 0.0f : anchor->influence < 1.0f;
    return anchor->rigid->kind == PLI_RIGID_DYNAMIC && !yields ? 10.0f : INFINITY;
}
/* Share of an error at the start of a step that goes in it. */
static float anchor_share(const pli_body* body, const plii_anchor* anchor, pli_vec3 error, float hardness, float dt) {
    const float length = pli_vec3_length(error);
    const float most = plii_max(anchor_recovery_speed(body, anchor), PLII_ANCHOR_RECOVERY_RATE * length) * dt;
    return length * hardness > most ? most / length : hardness;
}

static void anchor_prepare(pli_body* body, void* state) {
    plii_anchors* anchors = state;
    for (PLII_EACH(plii_anchor, anchor, anchors->items, anchors->item_count)) {
        pli_rigid* rigid = anchor->rigid;
        anchor->is_idle = rigid->is_absent;
        if (anchor->is_idle) { continue; }
        const pli_vec3 offset = pli_mat3_mul_vec3(rigid->state.pose.rotation, anchor->pivot);
        anchor->step.offset = offset;
        anchor->step.goal = pli_vec3_add(offset, rigid->state.pose.origin);
        plii_effective_mass(body->step.dt, body->positions[anchor->node].w, rigid, !body->world->def.reference_mode,
                            offset, &anchor->step.matrix);
        if (anchor_is_exact(body, anchor)) {
            anchor->step.goal = pli_transform_point(anchor_end_pose(body, anchor), anchor->pivot);
        }
        const pli_vec3 off = pli_vec3_sub(anchor->start, plii_xyz(body->previous[anchor->node]));
        anchor->step.way = pli_vec3_scale(off, anchor_share(body, anchor, off, anchors->hardness, body->host_dt));
        plii_rigid_touch(rigid);
    }
}

/* Of one that was added after the prediction its rigid body may have moved since. */
static void anchor_note_start(plii_anchor* anchor) {
    plii_rigid_begin_path(anchor->rigid);
    anchor->start = pli_transform_point(anchor->rigid->path.begin, anchor->pivot);
    anchor->pose_version = anchor->rigid->path.begin_version;
}

static void anchor_note_starts(pli_body* body, void* state) {
    plii_anchors* anchors = state;
    for (int i = 0; i < anchors->item_count; ++i) {
        anchor_note_start(&anchors->items[i]);
    }
}

/* What the node is to do beside its motion: go along, and a share of what it was off at the start of the step. Bullet
   takes the share of the way from where it is now, its motion included: a node alone then swings to and fro, farther
   each time, where the share is over 2/3. */
static pli_vec3 anchor_error(const pli_body* body, const plii_anchor* anchor, float hardness) {
    const pli_vec3 node = plii_xyz(body->positions[anchor->node]), start = plii_xyz(body->previous[anchor->node]);
    const pli_vec3 way = body->world->def.reference_mode
                             ? pli_vec3_scale(pli_vec3_sub(anchor->step.goal, node), hardness)
                             : anchor->step.way;
    const pli_vec3 along = plii_rigid_motion_at(body, anchor->rigid, anchor->step.offset);
    return pli_vec3_add(pli_vec3_sub(along, pli_vec3_sub(node, start)), way);
}

static void anchor_push(pli_body* body, const plii_anchor* anchor, float hardness) {
    const float dt = body->step.dt;
    pli_vec4* position = &body->positions[anchor->node];
    const bool is_fixed = anchor->rigid->state.inverse_mass == 0.0f;
    const pli_vec3 node = plii_xyz(*position), error = anchor_error(body, anchor, hardness);
    const pli_vec3 impulse = pli_vec3_scale(pli_mat3_mul_vec3(anchor->step.matrix, error), anchor->influence);
    /* Neither side can move, or the soft body leaves finite numbers and must not take the rigid body along. */
    if (!plii_vec3_is_finite(impulse)) { return; }
    plii_set_xyz(position, pli_vec3_add(node, pli_vec3_scale(impulse, dt * position->w)));
    if (is_fixed) { return; }
    plii_rigid_push_at(body, anchor->rigid, pli_vec3_neg(impulse), anchor->step.offset);
    anchor->rigid->path.is_pushed = true;
}

/* Before links, which start from where nodes are led. */
static void anchor_solve(pli_body* body, void* state) {
    const plii_anchors* anchors = state;
    if (body->solver_class->solves_constraints) { return; }
    for (PLII_EACH(const plii_anchor, anchor, anchors->items, anchors->item_count)) {
        if (anchor->is_idle) { continue; }
        if (anchor_is_exact(body, anchor)) {
            if (body->positions[anchor->node].w > 0.0f) {
                plii_set_xyz(&body->positions[anchor->node], anchor->step.goal);
            }
        } else if (body->world->def.reference_mode) {
            anchor_push(body, anchor, anchors->hardness);
        }
    }
}

/* After links: what they pull with is felt in the same step. A step later it would swing loads up. */
static void anchor_couple(pli_body* body, void* state) {
    const plii_anchors* anchors = state;
    if (body->solver_class != &plii_position_solver || body->world->def.reference_mode) { return; }
    for (PLII_EACH(const plii_anchor, anchor, anchors->items, anchors->item_count)) {
        if (!anchor->is_idle && !anchor_is_exact(body, anchor)) { anchor_push(body, anchor, anchors->hardness); }
    }
}

/* After all else that moves nodes or changes velocities. */
static void anchor_finish(pli_body* body, void* state) {
    const plii_anchors* anchors = state;
    for (PLII_EACH(const plii_anchor, anchor, anchors->items, anchors->item_count)) {
        if (anchor->is_idle || !anchor_is_exact(body, anchor)) { continue; }
        if (!(body->positions[anchor->node].w > 0.0f)) { continue; }
        const pli_transform end = anchor_end_pose(body, anchor);
        plii_set_xyz(&body->positions[anchor->node], pli_transform_point(end, anchor->pivot));
        const pli_vec3 offset = pli_mat3_mul_vec3(end.rotation, anchor->pivot);
        plii_set_xyz(&body->velocities[anchor->node], plii_rigid_pace_at(body, anchor->rigid, offset));
    }
}

static int anchor_list_constraints(const pli_body* body, const void* state, int capacity,
                                   plii_node_constraint* constraints) {
    const plii_anchors* anchors = state;
    int count = 0;
    for (PLII_EACH(const plii_anchor, anchor, anchors->items, anchors->item_count)) {
        if (anchor->rigid->is_absent || count++ >= capacity) { continue; }
        plii_node_constraint* constraint = &constraints[count - 1];
        *constraint = (plii_node_constraint){
            .node = anchor->node, .rigid = anchor->rigid, .is_anchor = true, .pivot = anchor->pivot};
        constraint->leads = anchor_is_exact(body, anchor);
        constraint->hardness = constraint->leads ? 1.0f : anchors->hardness;
        constraint->recovery_speed = anchor_recovery_speed(body, anchor);
        if (constraint->leads) {
            constraint->start = anchor->start;
            constraint->end = pli_transform_point(anchor_end_pose(body, anchor), anchor->pivot);
        }
        constraint->influence = plii_min(anchor->influence, 1.0f);
    }
    return count;
}

// ------------------------------------------------------------------------------------------------------- substeps

/* C = node - point of the rigid body as one constraint of three rows. */

static void anchor_substeps_begin(pli_body* body, void* data) {
    plii_anchors* anchors = data;
    for (PLII_EACH(plii_anchor, anchor, anchors->items, anchors->item_count)) {
        pli_rigid* rigid = anchor->rigid;
        anchor->is_idle = rigid->is_absent;
        if (anchor->is_idle) { continue; }
        anchor->substeps.goal = anchor->start;
        const pli_vec3 offset = pli_mat3_mul_vec3(rigid->path.begin.rotation, anchor->pivot);
        anchor->substeps.pivot = (plii_substep_rigid_pivot){{rigid, offset}, offset};
        if (rigid->kind != PLI_RIGID_DYNAMIC) {
            const pli_vec3 end = pli_transform_point(anchor_end_pose(body, anchor), anchor->pivot);
            anchor->substeps.goal_motion = pli_vec3_sub(end, anchor->start);
        }
        plii_substep_follow_rigid(body, rigid);
        plii_rigid_touch(rigid);
    }
}

static float anchor_alpha(const plii_anchor* anchor, const plii_substep* substep) {
    return anchor->compliance * substep->inverse_dt * substep->inverse_dt;
}

static void anchor_substep_restart(pli_body* body, void* data, const plii_substep* substep) {
    const plii_anchors* anchors = data;
    for (PLII_EACH(plii_anchor, anchor, anchors->items, anchors->item_count)) {
        if (anchor->is_idle) { continue; }
        const pli_rigid* rigid = anchor->rigid;
        plii_substep_rigid_pivot* pivot = &anchor->substeps.pivot;
        anchor->substeps.multiplier = anchor->substeps.left = pli_vec3_make(0, 0, 0);
        if (rigid->kind == PLI_RIGID_DYNAMIC) {
            plii_substep_rigid_pivot_turn(pivot);
            const pli_vec3 start = plii_substep_start(body, substep, anchor->node);
            const pli_vec3 goal = pli_vec3_add(anchor->substeps.goal, plii_substep_rigid_pivot_moved(pivot));
            const pli_vec3 off = pli_vec3_sub(start, goal);
            anchor->substeps.left = pli_vec3_scale(off, 1.0f - anchor_share(body, anchor, off, 1.0f, substep->host_dt));
        }
        const float inverse_mass = substep->displacements[anchor->node].w + anchor_alpha(anchor, substep);
        plii_effective_mass(1.0f, inverse_mass, rigid, true, pivot->point.offset, &anchor->substeps.inverse);
    }
}

/* At the end of the substep. */
static pli_vec3 anchor_goal(const pli_body* body, const plii_anchor* anchor, const plii_substep* substep) {
    if (anchor->rigid->kind != PLI_RIGID_DYNAMIC) {
        const float time = (float)(substep->index + 1) * substep->dt * body->step.inverse_dt;
        return pli_vec3_add(anchor->substeps.goal, pli_vec3_scale(anchor->substeps.goal_motion, time));
    }
    const plii_substep_rigid_pivot* pivot = &anchor->substeps.pivot;
    const pli_vec3 start = pli_vec3_add(anchor->substeps.goal, plii_substep_rigid_pivot_moved(pivot));
    return pli_vec3_add(pli_vec3_add(start, anchor->substeps.left),
                        plii_substep_rigid_point_motion(&pivot->point, substep));
}

static void anchor_substep_sweep(pli_body* body, void* data, const plii_substep* substep) {
    const plii_anchors* anchors = data;
    for (PLII_EACH(plii_anchor, anchor, anchors->items, anchors->item_count)) {
        if (anchor->is_idle) { continue; }
        const plii_substep_rigid_point* point = &anchor->substeps.pivot.point;
        const pli_vec3 goal = anchor_goal(body, anchor, substep);
        const pli_vec3 error = pli_vec3_add(pli_vec3_sub(plii_substep_position(body, substep, anchor->node), goal),
                                            pli_vec3_scale(anchor->substeps.multiplier, anchor_alpha(anchor, substep)));
        const pli_vec3 change = pli_vec3_neg(pli_mat3_mul_vec3(anchor->substeps.inverse, error));
        if (!plii_vec3_is_finite(change)) { continue; } /* neither side can move */
        anchor->substeps.multiplier = pli_vec3_add(anchor->substeps.multiplier, change);
        plii_substep_move(substep, anchor->node, change, 1.0f);
        plii_substep_rigid_point_push(point, pli_vec3_neg(change), substep);
    }
}

// ----------------------------------------------------------------------------------------------------- the feature

/* body->anchored of a node that is in the list of a call. */
enum { ANCHOR_LISTED = 2 };

/* Takes out the anchor of a slot, those to a rigid body that goes away, and those of nodes that are listed; the others
   keep their order. Returns whether there were some. */
static bool anchor_remove(pli_body* body, plii_anchors* anchors, int slot, const pli_rigid* gone) {
    const int before = anchors->item_count;
    PLII_ID_POOL_REMOVE_IF(&anchors->ids, plii_anchor, at, anchors->items, anchors->item_count,
                           at->slot == slot || at->rigid == gone || body->anchored[at->node] == ANCHOR_LISTED);
    memset(body->anchored, 0, (size_t)body->node_count);
    for (int i = 0; i < anchors->item_count; ++i) {
        body->anchored[anchors->items[i].node] = 1;
    }
    return anchors->item_count < before;
}

static void anchor_on_rigid_removed(pli_body* body, void* state, plii_notice notice, const void* rigid) {
    if (anchor_remove(body, state, PLI_NULL_INDEX, rigid)) { plii_world_add_anchors_lost(body); }
}

static void anchor_visit_joined(const void* state, plii_joined_fn* visit, void* user) {
    const plii_anchors* anchors = state;
    for (int i = 0; i < anchors->item_count; ++i) {
        visit(NULL, anchors->items[i].rigid, user);
    }
}

static bool anchor_is_anchored_to(const pli_body* body, int node, const pli_rigid* rigid) {
    const plii_anchors* anchors = plii_feature_state(body, &plii_anchor_class);
    for (int i = 0; i < anchors->item_count; ++i) {
        if (anchors->items[i].node == node && anchors->items[i].rigid == rigid) { return true; }
    }
    return false;
}

static void anchor_enable(pli_body* body, void* state) {
    plii_anchors* anchors = state;
    body->is_anchored_to = anchor_is_anchored_to;
    anchors->hardness = 0.7f;
}

/* Before contacts; after all; they take their nodes along after links and tethers. */
enum { ANCHOR_START_ORDER = 10, ANCHOR_ORDER = 10, ANCHOR_LAST_ORDER = 200, ANCHOR_SUBSTEP_ORDER = 50 };

static bool anchor_is_sound(const pli_body* body, const void* data) {
    const plii_anchors* anchors = data;
    for (int i = 0; i < anchors->item_count; ++i) {
        const plii_anchor* anchor = &anchors->items[i];
        if (!plii_id_pool_has(&anchors->ids, anchor->slot, i) || body->anchored[anchor->node] == 0) { return false; }
    }
    return plii_id_pool_is_sound(&anchors->ids, anchors->item_count);
}

static const plii_field anchor_fields[] = {
    PLII_FIELD(plii_anchor, influence, 0, PLI_MAX_FACTOR),
    PLII_FIELD(plii_anchor, compliance, 0, PLI_MAX_COEFFICIENT),
};
const plii_feature_class plii_anchor_class = {
    .name = "anchors",
    .is_made_by_calls = true,
    .state_size = sizeof(plii_anchors),
    .settings = PLII_LIMITS_AT(0, PLII_FIELD(plii_anchors, hardness, 0, 1)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(plii_anchors, hardness, PLII_SAVED, "f"),
                                    PLII_STATE_OF(plii_anchors, ids.first_free1, PLII_SAVED, "i")),
    .is_sound = anchor_is_sound,
    /* Anchors stay with their node; a copy of the node is free. */
    .arrays = PLII_ARRAYS(
        {PLII_COUNTED_LIST(plii_anchors, items, item_capacity, item_count), .is_kept = true,
         PLII_SAVED_AS("niS5fB3fu*"), .settings = {anchor_fields, 2, 0}},
        {PLII_COUNTED_LIST(plii_anchors, ids.slots, ids.capacity, ids.count), .is_kept = true, PLII_SAVED_AS("uii")},
        {PLII_MEMBER(pli_body, anchored), PLII_PER_NODE, .is_in_body = true, .is_kept = true, PLII_SAVED_AS("B")}),
    .stages = {[PLII_STAGE_FORCES] = {anchor_note_starts, ANCHOR_START_ORDER},
               [PLII_STAGE_PREPARE] = {anchor_prepare, ANCHOR_ORDER},
               [PLII_STAGE_POSITION] = {anchor_solve, ANCHOR_ORDER},
               [PLII_STAGE_COUPLE] = {anchor_couple, ANCHOR_ORDER},
               [PLII_STAGE_FINISH] = {anchor_finish, ANCHOR_LAST_ORDER}},
    .substepped = PLII_SUBSTEPPED(.order = ANCHOR_SUBSTEP_ORDER, .begin = anchor_substeps_begin,
                                  .restart = anchor_substep_restart, .sweep = anchor_substep_sweep),
    .enable = anchor_enable,
    .list_constraints = anchor_list_constraints,
    .visit_joined = anchor_visit_joined,
    .on[PLII_RIGID_REMOVED] = anchor_on_rigid_removed,
};

PLII_DEFINE_DEFAULT(pli_anchor_def, .influence = 1.0f)

static pli_status anchor_check_rigid(const pli_body* body, const pli_rigid* rigid, const char* name,
                                     const char* function) {
    PLII_TRY(plii_check_handle(rigid, PLII_HANDLE_RIGID, body->context, name, function));
    PLII_FAIL_IF(rigid->world != body->world, body->context, PLI_ERROR_INVALID_VALUE, function,
                 "%s is in another world", name);
    return PLI_OK;
}

static pli_status anchor_check(pli_body* body, const pli_anchor_def* def, const char* function) {
    pli_context* context = body->context;
    PLII_TRY(PLII_CHECK_MADE(context, pli_anchor_def, def, function));
    const plii_anchor numbers = {.influence = def->influence, .compliance = def->compliance};
    PLII_TRY(PLII_CHECK_FIELDS(context, &numbers, anchor_fields, function));
    PLII_TRY(plii_check_node(body, def->node, function));
    PLII_TRY(anchor_check_rigid(body, def->rigid, "def->rigid", function));
    if (def->local_pivot != NULL) {
        PLII_TRY(plii_check_vec3_within(context, *def->local_pivot, PLI_MAX_COORDINATE, "local_pivot", function));
    }
    return PLI_OK;
}

static bool anchor_reserve(pli_body* body, plii_anchors* anchors, int more) {
    return more <= INT_MAX - anchors->item_count &&
           PLII_RESERVE(body->context, &anchors->items, &anchors->item_capacity, anchors->item_count + more) &&
           plii_id_pool_reserve(body->context, &anchors->ids, more);
}

/* Room is there. */
static plii_anchor* anchor_append(pli_body* body, plii_anchors* anchors, const pli_anchor_def* def) {
    plii_anchor* anchor = &anchors->items[anchors->item_count];
    *anchor = (plii_anchor){.node = def->node,
                            .slot = plii_id_pool_alloc(&anchors->ids, anchors->item_count),
                            .rigid = def->rigid,
                            .influence = def->influence,
                            .compliance = def->compliance};
    /* In a step nodes are where they are to be at its end. */
    const bool is_ahead = body->world->is_stepping && !body->world->def.reference_mode;
    plii_rigid_begin_path(def->rigid);
    const pli_transform pose = is_ahead ? plii_rigid_end_pose(def->rigid, body->host_dt) : def->rigid->state.pose;
    anchor->pivot =
        def->local_pivot != NULL ? *def->local_pivot : plii_localize(pose, plii_xyz(body->positions[def->node]));
    anchor_note_start(anchor);
    anchors->item_count += 1;
    body->anchored[def->node] = 1;
    return anchor;
}

pli_status pli_body_add_anchor(pli_body* body, const pli_anchor_def* def, pli_anchor_id* id) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(anchor_check(body, def, __func__));
    PLII_TRY_ENABLE(body, plii_anchors, anchors, plii_anchor_class);
    if (!anchor_reserve(body, anchors, 1) ||
        (def->disable_collision && pli_body_ignore_rigid(body, def->rigid, true) != PLI_OK)) {
        return PLII_FAIL_ENABLED(body, plii_anchor_class, __func__, "no memory for an anchor");
    }
    const plii_anchor* anchor = anchor_append(body, anchors, def);
    if (id != NULL) { *id = (pli_anchor_id){anchor->slot + 1, anchors->ids.slots[anchor->slot].generation}; }
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_remove_anchor(pli_body* body, pli_anchor_id id) {
    PLII_TRY(plii_check_body_change(body, __func__));
    plii_anchors* anchors = plii_feature_state(body, &plii_anchor_class);
    const int item = anchors != NULL ? plii_id_pool_find(&anchors->ids, id.index1, id.generation) : PLI_NULL_INDEX;
    PLII_FAIL_IF(item == PLI_NULL_INDEX, body->context, PLI_ERROR_STALE_ID, __func__, "the body has no anchor {%d, %u}",
                 (int)id.index1, (unsigned)id.generation);
    (void)anchor_remove(body, anchors, anchors->items[item].slot, NULL);
    return plii_body_changed(body, PLI_OK);
}

// -------------------------------------------------------------------------------------------- many nodes at once

/* Of one node of the list, when those before it are marked. */
static pli_status anchor_check_listed(const pli_body* body, const int* nodes, int place, bool are_anchored,
                                      const char* function) {
    const int node = nodes[place];
    PLII_FAIL_IF(node < 0 || node >= body->node_count, body->context, PLI_ERROR_INDEX_OUT_OF_RANGE, function,
                 "nodes[%d] = %d is out of range, the body has %d nodes", place, node, body->node_count);
    int first = 0; /* in the list */
    while (body->anchored[node] == ANCHOR_LISTED && nodes[first] != node) {
        ++first;
    }
    PLII_FAIL_IF(body->anchored[node] == ANCHOR_LISTED, body->context, PLI_ERROR_INVALID_VALUE, function,
                 "nodes[%d] and nodes[%d] are both %d", first, place, node);
    PLII_FAIL_IF((body->anchored[node] != 0) != are_anchored, body->context, PLI_ERROR_INVALID_VALUE, function,
                 "nodes[%d] = %d is %s anchored", place, node, are_anchored ? "not" : "already");
    return PLI_OK;
}

/* Marks as listed all nodes of the list, which are to be anchored or free; on an error none. */
static pli_status anchor_mark_nodes(pli_body* body, const int* nodes, int count, bool are_anchored,
                                    const char* function) {
    pli_status status = PLI_OK;
    int marked = 0;
    while (marked < count && status == PLI_OK) {
        status = anchor_check_listed(body, nodes, marked, are_anchored, function);
        if (status == PLI_OK) { body->anchored[nodes[marked++]] = ANCHOR_LISTED; }
    }
    for (int i = 0; i < marked && status != PLI_OK; ++i) {
        body->anchored[nodes[i]] = are_anchored ? 1 : 0;
    }
    return status;
}

static pli_status anchor_check_list(pli_body* body, const int* nodes, int count, const char* function) {
    PLII_FAIL_IF(count < 0, body->context, PLI_ERROR_INVALID_VALUE, function, "count is %d, negative", count);
    PLII_FAIL_IF(nodes == NULL && count > 0, body->context, PLI_ERROR_NULL_ARGUMENT, function, "nodes is null");
    return PLI_OK;
}

pli_status pli_body_attach_nodes(pli_body* body, const int* nodes, int count, pli_rigid* rigid) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(anchor_check_list(body, nodes, count, __func__));
    PLII_TRY(anchor_check_rigid(body, rigid, "rigid", __func__));
    PLII_TRY_ENABLE(body, void, state, plii_anchor_class);
    if (!anchor_reserve(body, state, count)) {
        return PLII_FAIL_ENABLED(body, plii_anchor_class, __func__, "no memory for %d anchors", count);
    }
    const pli_status status = anchor_mark_nodes(body, nodes, count, false, __func__);
    pli_anchor_def def = pli_anchor_def_default();
    def.rigid = rigid;
    for (int i = 0; i < count && status == PLI_OK; ++i) {
        def.node = nodes[i];
        anchor_append(body, state, &def);
    }
    if (status == PLI_OK && count > 0) { return plii_body_changed(body, PLI_OK); }
    plii_feature_undo(body, &plii_anchor_class);
    return status;
}

pli_status pli_body_detach_nodes(pli_body* body, const int* nodes, int count) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(anchor_check_list(body, nodes, count, __func__));
    if (count == 0) { return PLI_OK; }
    plii_anchors* anchors = plii_feature_state(body, &plii_anchor_class);
    PLII_FAIL_IF(anchors == NULL || anchors->item_count == 0, body->context, PLI_ERROR_INVALID_VALUE, __func__,
                 "the body has no anchors");
    PLII_TRY(anchor_mark_nodes(body, nodes, count, true, __func__));
    (void)anchor_remove(body, anchors, PLI_NULL_INDEX, NULL);
    return plii_body_changed(body, PLI_OK);
}
PLII_DEFINE_STATE_GET(int, pli_body_anchor_count, plii_anchors, plii_anchor_class, state->item_count, 0)

pli_status pli_body_set_anchor_hardness(pli_body* body, float hardness) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(plii_check_limits(body->context, &hardness, &plii_anchor_class.settings, __func__));
    return plii_feature_enable_with(body, &plii_anchor_class, &hardness, sizeof hardness, NULL);
}
