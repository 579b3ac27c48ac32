/* The joints of a body, and when a step solves them. Bullet: prepareClusters, solveClusters, cleanupClusters. */

#include "base/id_pool.h"
#include "body/pipeline.h"
#include "cluster/joint_impl.h"

typedef struct joints_state {
    plii_joint* items; /* in the order of creation */
    int count, capacity;
    plii_id_pool ids;
} joints_state;

static plii_joint_end joint_end_of(const pli_joint_end* end) {
    if (end->body != NULL) { return plii_joint_end_of_cluster(end->body, end->cluster); }
    if (end->rigid != NULL) { return plii_joint_end_of_rigid(end->rigid); }
    return (plii_joint_end){.frame = pli_transform_identity()};
}

static void joints_visit_joined(const void* state, plii_joined_fn* visit, void* user) {
    const joints_state* joints = state;
    for (int i = 0; i < joints->count; ++i) {
        visit(joints->items[i].other.body, joints->items[i].other.rigid, user);
    }
}

/* The host may move the rigid bodies from here on. */
static void joints_note_starts(pli_body* body, void* state) {
    const joints_state* joints = state;
    for (int i = 0; i < joints->count; ++i) {
        pli_rigid* rigid = joints->items[i].other.rigid;
        if (rigid != NULL) { plii_rigid_begin_path(rigid); }
    }
}

/* The cluster is where the step leads. A rigid body that its host has not moved yet goes along with what the two have
   in common, or what flies with it would lag by a step's motion, as it does in Bullet. */
static void joint_move_along(const pli_body* body, const pli_rigid* rigid, plii_joint* joint) {
    const plii_cluster* cluster = joint->sides[0].target.cluster;
    if (cluster == NULL || rigid->kind == PLI_RIGID_STATIC || plii_rigid_is_moved_by_host(rigid)) { return; }
    const pli_vec3 turn = plii_xyz(cluster->angular_velocity);
    const pli_vec3 arm = pli_vec3_sub(rigid->state.pose.origin, cluster->frame.origin);
    const pli_vec3 there = pli_vec3_add(plii_xyz(cluster->linear_velocity), pli_vec3_cross(turn, arm));
    const float share = cluster->inverse_mass / (cluster->inverse_mass + rigid->state.inverse_mass);
    const plii_twist common = {pli_vec3_lerp(there, rigid->state.linear_velocity, share),
                               pli_vec3_lerp(turn, rigid->state.angular_velocity, share)};
    joint->sides[1].frame = plii_rigid_advance(rigid->state.pose, common, body->step.dt);
}

/* What is displaced apart from the rest of its body stretches links, which give energy for it. */
static bool joint_has_whole(const pli_body* body, const plii_joint_end* side) {
    return side->target.cluster == NULL || side->target.cluster->member_count == body->node_count;
}

static void joints_prepare(pli_body* body, void* state) {
    joints_state* joints = state;
    if (joints->count == 0) { return; } /* nor need there be clusters */
    const bool reference_mode = body->clusters->def.reference_mode;
    for (PLII_EACH(plii_joint, joint, joints->items, joints->count)) {
        pli_rigid* rigid = joint->other.rigid;
        joint->is_idle = rigid != NULL && rigid->is_absent;
        if (joint->is_idle) { continue; }
        joint->keeps_momentum = rigid != NULL && rigid->kind == PLI_RIGID_DYNAMIC && !reference_mode;
        joint->sides[0] = plii_joint_end_of_cluster(body, joint->cluster);
        joint->sides[1] = joint_end_of(&joint->other);
        joint->sides[1].has_factors = joint->keeps_momentum;
        const bool are_whole =
            joint_has_whole(body, joint->sides) && joint_has_whole(joint->other.body, joint->sides + 1);
        joint->split = reference_mode || are_whole ? joint->softness.split : 0.0f;
        if (rigid != NULL) {
            plii_rigid_touch(rigid);
            if (!reference_mode) { joint_move_along(body, rigid, joint); }
        }
        joint->klass->prepare(joint, body->step.dt, body->world->joint_iterations);
    }
}

/* `impulse` is of the other end; drifts displace the sides at their arms, or turn them. */
static void joint_apply(const plii_joint* joint, pli_vec3 impulse, bool is_drift) {
    const int count = is_drift && joint->keeps_momentum ? 1 : 2;
    for (int i = 0; i < count; ++i) {
        const pli_vec3 own = i == 0 ? pli_vec3_neg(impulse) : impulse;
        if (joint->klass->is_angular) {
            plii_joint_apply_torque(&joint->sides[i].target, own, is_drift);
        } else {
            plii_joint_apply(&joint->sides[i].target, own, joint->world[i], is_drift);
        }
    }
}

/* Few iterations tell one end of a chain little of the other: they go on from the impulses of the step before. */
static void joints_start(pli_body* body, void* state) {
    const joints_state* joints = state;
    for (PLII_EACH(plii_joint, joint, joints->items, joints->count)) {
        joint->impulse = pli_vec3_make(0, 0, 0);
        if (joint->is_idle || body->clusters->def.reference_mode) { continue; }
        pli_vec3 kept = pli_vec3_scale(joint->force, body->step.dt * joint->softness.velocity_factor);
        if (joint->klass->is_angular) { /* about the axis its motor decides anew */
            kept = pli_vec3_sub(kept, pli_vec3_scale(joint->world[0], pli_vec3_dot(kept, joint->world[0])));
        }
        joint_apply(joint, joint->impulse = kept, false);
    }
}

static void joints_solve(pli_body* body, void* state) {
    const joints_state* joints = state;
    for (PLII_EACH(plii_joint, joint, joints->items, joints->count)) {
        if (joint->is_idle) { continue; }
        const pli_vec3 impulse = joint->klass->solve(joint);
        joint->impulse = pli_vec3_add(joint->impulse, impulse);
        joint_apply(joint, impulse, false);
    }
}

static void joints_finish(pli_body* body, void* state) {
    const joints_state* joints = state;
    for (PLII_EACH(plii_joint, joint, joints->items, joints->count)) {
        if (!joint->is_idle && joint->split > 0.0f) { joint_apply(joint, joint->split_drift, true); }
        joint->force = pli_vec3_scale(joint->impulse, body->step.inverse_dt);
        if (!plii_vec3_is_finite(joint->force)) { joint->force = pli_vec3_make(0, 0, 0); }
    }
}

void plii_joint_split_drift(plii_joint* joint, int iterations, float response, float other_response) {
    const float split = joint->split;
    if (split > 0.0f) {
        joint->split_drift = pli_mat3_mul_vec3(joint->impulse_matrix, pli_vec3_scale(joint->drift, split));
    }
    float displaced = split;
    if (joint->keeps_momentum) {
        const float total = response + other_response;
        displaced = total > 0.0f ? split * (response / total) : 0.0f;
    }
    if (displaced > 0.0f) { joint->drift = pli_vec3_scale(joint->drift, 1.0f - displaced); }
    joint->drift = plii_vec3_divide(joint->drift, (float)iterations);
}

/* Takes out the joint of a slot, or those with what goes away, a body or a rigid body; the others keep their order.
   Returns whether there were some. */
static bool joints_remove(pli_body* body, joints_state* joints, int slot, const void* gone) {
    const int before = joints->count;
    PLII_ID_POOL_REMOVE_IF(&joints->ids, plii_joint, joint, joints->items, joints->count,
                           joint->slot == slot || (gone != NULL && (body == gone || joint->other.body == gone ||
                                                                    joint->other.rigid == gone)));
    return joints->count < before;
}

static void joints_on_removed(pli_body* body, void* state, plii_notice notice, const void* gone) {
    const bool had_some = joints_remove(body, state, PLI_NULL_INDEX, gone);
    if (had_some && notice == PLII_RIGID_REMOVED) { plii_world_add_anchors_lost(body); }
}

enum { JOINTS_ORDER = 10 }; /* before cluster contacts */

static bool joint_has_cluster(const pli_body* body, int cluster) {
    const plii_clusters* clusters = body->clusters;
    return clusters != NULL && cluster >= 0 && cluster < clusters->count;
}

static bool joints_is_sound(const pli_body* body, const void* data) {
    const joints_state* joints = data;
    for (int i = 0; i < joints->count; ++i) {
        const plii_joint* joint = &joints->items[i];
        const pli_joint_end* other = &joint->other;
        const bool is_sound =
            plii_id_pool_has(&joints->ids, joint->slot, i) && joint_has_cluster(body, joint->cluster) &&
            (other->body == NULL || (other->rigid == NULL && joint_has_cluster(other->body, other->cluster)));
        if (!is_sound) { return false; }
    }
    return plii_id_pool_is_sound(&joints->ids, joints->count);
}

/* Of the joint with the same id. */
static void joints_keep_callbacks(void* data, const void* before) {
    joints_state* joints = data;
    const joints_state* old = before;
    for (PLII_EACH(plii_joint, joint, joints->items, joints->count)) {
        const uint32_t generation = joints->ids.slots[joint->slot].generation;
        const int item = plii_id_pool_find(&old->ids, joint->slot + 1, generation);
        if (item != PLI_NULL_INDEX) { joint->controller = old->items[item].controller; }
    }
}

static const plii_field joint_softness_fields[] = {
    PLII_FIELD(pli_joint_softness, error_reduction, 0, 1),
    PLII_FIELD(pli_joint_softness, velocity_factor, 0, 1),
    PLII_FIELD(pli_joint_softness, split, 0, 1),
};
const plii_feature_class plii_joints_class = {
    .name = "joints",
    .state_size = sizeof(joints_state),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(joints_state, ids.first_free1, PLII_SAVED, "i")),
    .is_sound = joints_is_sound,
    .keep_callbacks = joints_keep_callbacks,
    /* Joints hold to clusters, which follow a cut and keep their index. */
    .arrays = PLII_ARRAYS(
        {PLII_COUNTED_LIST(joints_state, items, capacity, count), .is_kept = true, PLII_SAVED_AS("JiiPiR12f3X*"),
         .settings = PLII_LIMITS(plii_joint, softness, joint_softness_fields)},
        {PLII_COUNTED_LIST(joints_state, ids.slots, ids.capacity, ids.count), .is_kept = true, PLII_SAVED_AS("uii")}),
    .stages = {[PLII_STAGE_UPDATE] = {joints_note_starts, JOINTS_ORDER},
               [PLII_STAGE_JOINT_PREPARE] = {joints_prepare, JOINTS_ORDER},
               [PLII_STAGE_JOINT_START] = {joints_start, JOINTS_ORDER},
               [PLII_STAGE_JOINT_SOLVE] = {joints_solve, JOINTS_ORDER},
               [PLII_STAGE_JOINT_FINISH] = {joints_finish, JOINTS_ORDER}},
    .visit_joined = joints_visit_joined,
    .on = {[PLII_RIGID_REMOVED] = joints_on_removed,
           [PLII_BODY_REMOVED] = joints_on_removed,
           [PLII_CLUSTERS_REMOVED] = joints_on_removed},
};

static pli_status joint_check(pli_body* body, const plii_joint* joint, pli_vec3 world_value, const char* function) {
    pli_context* context = body->context;
    PLII_TRY(plii_check_cluster(body, joint->cluster, function));
    const pli_joint_end* other = &joint->other;
    PLII_FAIL_IF(other->body != NULL && other->rigid != NULL, context, PLI_ERROR_INVALID_VALUE, function,
                 "the other end has both a body and a rigid body");
    if (other->body != NULL) {
        PLII_TRY(plii_check_handle(other->body, PLII_HANDLE_BODY, context, "the other body", function));
        PLII_FAIL_IF(other->body->world != body->world, context, PLI_ERROR_INVALID_VALUE, function,
                     "the other body is in another world");
        PLII_TRY(plii_check_cluster(other->body, other->cluster, function));
        PLII_FAIL_IF(other->body == body && other->cluster == joint->cluster, context, PLI_ERROR_INVALID_VALUE,
                     function, "both ends are cluster %d", joint->cluster);
    }
    if (other->rigid != NULL) { PLII_TRY(plii_check_handle(other->rigid, PLII_HANDLE_RIGID, context, NULL, function)); }
    PLII_FAIL_IF(other->rigid != NULL && other->rigid->world != body->world, context, PLI_ERROR_INVALID_VALUE, function,
                 "the rigid body is not in the body's world");
    PLII_TRY(plii_check_vec3_within(context, world_value, PLI_MAX_COORDINATE, "the point or axis", function));
    return PLII_CHECK_FIELDS(context, &joint->softness, joint_softness_fields, function);
}

/* A point or an axis in a frame. */
static pli_vec3 joint_localize(const plii_joint_end* side, pli_vec3 value, bool is_axis) {
    if (is_axis) { return pli_mat3_transpose_mul_vec3(side->frame.rotation, value); }
    return pli_vec3_add(plii_localize(side->frame, value), side->rest_centre);
}

/* Nodes may have been moved since the step that it is of. In reference mode as in Bullet it stays. */
static void joint_renew_frame(const pli_body* body, int cluster) {
    plii_clusters* clusters = body->clusters;
    if (!clusters->def.reference_mode) { clusters->items[cluster].has_frame = false; }
}

pli_status plii_joint_add(pli_body* body, plii_joint* joint, pli_vec3 world_value, pli_joint_id* id,
                          const char* function) {
    PLII_TRY(joint_check(body, joint, world_value, function));
    PLII_TRY_ENABLE(body, joints_state, joints, plii_joints_class);
    if (!plii_id_pool_reserve(body->context, &joints->ids, 1) ||
        !PLII_GROW(body->context, &joints->items, &joints->capacity, joints->count)) {
        return PLII_FAIL_ENABLED(body, plii_joints_class, function, "no memory for another joint");
    }
    joint_renew_frame(body, joint->cluster);
    if (joint->other.body != NULL) { joint_renew_frame(joint->other.body, joint->other.cluster); }
    const plii_joint_end sides[2] = {plii_joint_end_of_cluster(body, joint->cluster), joint_end_of(&joint->other)};
    joint->local[0] = joint_localize(&sides[0], world_value, joint->klass->is_angular);
    joint->local[1] = joint_localize(&sides[1], world_value, joint->klass->is_angular);
    joint->slot = plii_id_pool_alloc(&joints->ids, joints->count);
    joints->items[joints->count++] = *joint;
    if (id != NULL) { *id = (pli_joint_id){joint->slot + 1, joints->ids.slots[joint->slot].generation}; }
    return plii_body_changed(body, PLI_OK);
}

pli_status pli_body_remove_joint(pli_body* body, pli_joint_id joint) {
    PLII_TRY(plii_check_body_idle(body, __func__));
    joints_state* joints = plii_feature_state(body, &plii_joints_class);
    const int item = joints != NULL ? plii_id_pool_find(&joints->ids, joint.index1, joint.generation) : PLI_NULL_INDEX;
    PLII_FAIL_IF(item == PLI_NULL_INDEX, body->context, PLI_ERROR_STALE_ID, __func__,
                 "joint %d of generation %u is gone", (int)joint.index1, (unsigned)joint.generation);
    (void)joints_remove(body, joints, joints->items[item].slot, NULL);
    return plii_body_changed(body, PLI_OK);
}
PLII_DEFINE_STATE_GET(int, pli_body_joint_count, joints_state, plii_joints_class, state->count, 0)
