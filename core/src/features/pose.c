/* Pose matching: nodes are pulled towards the best-fitting position of the rest shape (Müller and others, "Meshless
   deformations based on shape matching", 2005). Bullet: setPose(false, true), updatePose and kMT. */

#include "pliant/pose.h"
#include "body/link_graph.h"
#include "body/pipeline.h"
#include "math/dvec3.h"
#include "math/rotation_fit.h"
#include "math/simd_float4.h"

typedef struct pose_state {
    float matching;
    pli_vec3* rest; /* [node_count] m, from the centre of mass */
    float* weights; /* [node_count], sum 1 */
    int* parts;     /* [node_count] smallest node of each part */
    int* next;      /* [node_count] another node of the part, from the smallest on; node_count: there is none */
    bool is_parted; /* by a cut: parts have a pose each */
    pli_mat3 rotation;
    pli_vec3 centre;        /* m */
    pli_vec3 rest_centre;   /* m, mean of `rest` by the weights; not in reference mode */
    double weight;          /* sum of the weights */
    uint32_t link_revision; /* of the body, as of the weights */
} pose_state;

static pli_vec3 pose_centre(const pli_body* body, const pose_state* pose) {
    pli_vec3 centre = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < body->node_count; ++i) {
        centre = pli_vec3_add(centre, pli_vec3_scale(plii_xyz(body->positions[i]), pose->weights[i]));
    }
    return centre;
}

/* After a node of a part; without `next`, of the body. What calls it is in line, so that that is known there. */
static inline int pose_after(const int* next, int node) {
    return next != NULL ? next[node] : node + 1;
}

/* Mean of positions by the weights, m from the origin. In double and near the body: what a sum of floats is off by far
   from the origin would pull at the body in each step. */
PLII_SIMD_INLINE pli_vec3 pose_offset(const pli_body* body, const pose_state* pose, const int* next, int first,
                                      pli_vec3 origin) {
    plii_dvec3 sum = {0, 0, 0};
    for (int i = first; i < body->node_count; i = pose_after(next, i)) {
        const pli_vec3 arm = pli_vec3_sub(plii_xyz(body->positions[i]), origin);
        sum = plii_dvec3_add_scaled(sum, plii_dvec3_from(arm), (double)pose->weights[i]);
    }
    return plii_dvec3_to_float(plii_dvec3_scale(sum, 1.0 / pose->weight));
}

PLII_SIMD_INLINE pli_mat3 pose_covariance(const pli_body* body, const pose_state* pose, const int* next, int first,
                                          pli_vec3 origin, pli_mat3 covariance) {
    const plii_float4 from = plii_lanes_from_vec3(&origin);
    plii_lanes_mat3 sums = plii_lanes_rows(&covariance);
    for (int i = first; i < body->node_count; i = pose_after(next, i)) {
        const plii_float4 now = (plii_float4_from(&body->positions[i]) - from) * pose->weights[i];
        const plii_float4 rest = plii_lanes_from_vec3(&pose->rest[i]);
        sums.at[0] += rest * plii_lanes_all_x(now);
        sums.at[1] += rest * plii_lanes_all_y(now);
        sums.at[2] += rest * plii_lanes_all_z(now);
    }
    return (pli_mat3){{plii_lanes_vec3(sums.at[0]), plii_lanes_vec3(sums.at[1]), plii_lanes_vec3(sums.at[2])}};
}

/* The sum of the weights, and the mean of the rest pose. */
static void pose_measure(const pli_body* body, pose_state* pose, const int* next, int first) {
    plii_dvec3 sum = {0, 0, 0};
    pose->weight = 0;
    for (int i = first; i < body->node_count; i = pose_after(next, i)) {
        sum = plii_dvec3_add_scaled(sum, plii_dvec3_from(pose->rest[i]), (double)pose->weights[i]);
        pose->weight += (double)pose->weights[i];
    }
    pose->rest_centre = plii_dvec3_to_float(plii_dvec3_scale(sum, 1.0 / pose->weight));
}

/* Shares of the total mass, where a pinned node counts a thousand times all others, or each as one if all are. */
static void pose_update_weights(const pli_body* body, pose_state* pose) {
    float free_mass = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        free_mass += body->positions[i].w > 0.0f ? 1.0f / body->positions[i].w : 0.0f;
    }
    const float pinned_mass = free_mass > 0.0f ? free_mass * (float)body->node_count * 1000.0f : 1.0f;
    float total = free_mass;
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { total += pinned_mass; }
    }
    for (int i = 0; i < body->node_count; ++i) {
        const float inverse_mass = body->positions[i].w;
        pose->weights[i] = inverse_mass > 0.0f ? 1.0f / (inverse_mass * total) : pinned_mass / total;
    }
    pose_measure(body, pose, NULL, 0);
}

static void pose_run_as_in_bullet(pli_body* body, pose_state* pose) {
    pose->centre = pose_centre(body, pose);
    plii_body_update_bounds(body);
    body->has_early_bounds = true;
    /* A small diagonal keeps a mesh in a coordinate plane from being singular. */
    const pli_mat3 small = plii_mat3_diagonal(PLII_EPSILON, PLII_EPSILON * 2.0f, PLII_EPSILON * 3.0f);
    pose->rotation = plii_polar_factor(pose_covariance(body, pose, NULL, 0, pose->centre, small), pose->rotation);
    const pli_transform frame = {pose->rotation, pose->centre};
    for (int i = 0; i < body->node_count && pose->matching > 0.0f; ++i) {
        if (!(body->positions[i].w > 0.0f)) { continue; } /* pinned nodes stay */
        plii_body_pull_predicted(body, i, pli_transform_point(frame, pose->rest[i]), pose->matching);
    }
}

PLII_SIMD_INLINE void pose_pull(pli_body* body, pose_state* pose, const int* next, int first) {
    const pli_vec3 origin = plii_xyz(body->positions[first]), offset = pose_offset(body, pose, next, first, origin);
    pose->centre = pli_vec3_add(origin, offset);
    /* Of any size, pinned, flat or inverted; what the arms are off the centre by is taken off. */
    const pli_vec3 moved = pli_vec3_scale(offset, (float)-pose->weight), rest = pose->rest_centre;
    const pli_mat3 start_sum = {
        {pli_vec3_scale(rest, moved.x), pli_vec3_scale(rest, moved.y), pli_vec3_scale(rest, moved.z)}};
    const pli_mat3 covariance = pose_covariance(body, pose, next, first, origin, start_sum);
    pli_quat turned = plii_quat_near(&pose->rotation);
    pose->rotation = covariance;
    plii_rotations_fit_warm(1, &pose->rotation, &(pli_quat*){&turned});
    const pli_vec3 start = pli_vec3_sub(offset, pli_mat3_mul_vec3(pose->rotation, pose->rest_centre));
    const plii_float4 from = plii_lanes_from_vec3(&origin), frame_origin = plii_lanes_from_vec3(&start);
    const plii_lanes_mat3 columns = plii_lanes_columns(&pose->rotation);
    const float matching = pose->matching;
    for (int i = matching > 0.0f ? first : body->node_count; i < body->node_count; i = pose_after(next, i)) {
        if (!(body->positions[i].w > 0.0f)) { continue; } /* pinned nodes stay */
        const plii_float4 goal = plii_lanes_combine(columns, plii_lanes_from_vec3(&pose->rest[i])) + frame_origin;
        const plii_float4 arm = plii_float4_from(&body->positions[i]) - from;
        const pli_vec3 way = plii_lanes_vec3((goal - arm) * matching);
        plii_add_xyz(&body->positions[i], way);
        if (!body->solver_class->has_substeps) { continue; }
        plii_add_xyz(&body->velocities[i], pli_vec3_scale(way, body->step.inverse_dt));
    }
}

static void pose_run(pli_body* body, void* state) {
    pose_state* pose = state;
    if (body->world->def.reference_mode) {
        pose_run_as_in_bullet(body, pose);
        return;
    }
    if (pose->link_revision != body->link_revision) { /* pulled by weights of other masses it would get a momentum */
        pose->link_revision = body->link_revision;
        pose_update_weights(body, pose);
    }
    if (!pose->is_parted) { pose_pull(body, pose, NULL, 0); }
    for (int part = body->node_count - 1; pose->is_parted && part >= 0; --part) {
        if (pose->parts[part] != part) { continue; }
        pose_measure(body, pose, pose->next, part);
        pose_pull(body, pose, pose->next, part);
    }
}

static void pose_find_parts(const pli_body* body, pose_state* pose) {
    plii_body_find_parts(body, pose->parts);
    for (int i = 0; i < body->node_count; ++i) {
        pose->next[i] = pose->parts[i] != i ? pose->next[pose->parts[i]] : body->node_count;
        if (pose->parts[i] != i) { pose->next[pose->parts[i]] = i; }
    }
}

/* New nodes lie between their parents at rest too. Masses have moved to them, so the centre is taken again. */
static void pose_topology_commit(pli_body* body, void* state, const plii_topology_change* change) {
    pose_state* pose = state;
    pli_vec3* rest = pose->rest;
    for (int i = change->old_node_count; i < change->node_count; ++i) {
        const plii_node_origin origin = change->node_origins[i - change->old_node_count];
        rest[i] = pli_vec3_lerp(rest[origin.a], rest[origin.b], origin.share);
    }
    const int* before = change->old_arrays[2];
    pose_find_parts(body, pose);
    for (int i = 0; i < change->old_node_count && !body->world->def.reference_mode; ++i) {
        pose->is_parted |= pose->parts[i] != pose->parts[before[i]];
    }
    pose_update_weights(body, pose);
    for (int i = 0; i < change->node_count; ++i) {
        rest[i] = pli_vec3_sub(rest[i], pose->rest_centre);
    }
}

/* What follows from the rest pose, the weights and the topology is found anew. */
static void pose_on_restored(pli_body* body, void* state) {
    pose_state* pose = state;
    pose_find_parts(body, pose);
    pose_measure(body, pose, NULL, 0);
    pose->link_revision = body->link_revision - 1;
}

enum { POSE_ORDER = 40 }; /* after all else that follows from predicted positions */
const plii_feature_class plii_pose_class = {
    .name = "pose matching",
    .state_size = sizeof(pose_state),
    .settings = PLII_LIMITS_AT(0, PLII_FIELD(pose_state, matching, 0, 1)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(pose_state, matching, PLII_SAVED, "f"),
                                    PLII_STATE_OF(pose_state, is_parted, PLII_SAVED, "B"),
                                    PLII_STATE_SPAN(pose_state, rotation, centre, PLII_SAVED, "12f"),
                                    PLII_STATE_SPAN(pose_state, rest_centre, link_revision, PLII_LEFT, NULL)),
    .on_restored = pose_on_restored,
    .stages = {[PLII_STAGE_UPDATE] = {pose_run, POSE_ORDER}},
    .arrays = PLII_ARRAYS({PLII_MEMBER(pose_state, rest), PLII_PER_NODE, .is_kept = true, PLII_SAVED_AS("3f")},
                          {PLII_MEMBER(pose_state, weights), PLII_PER_NODE, PLII_SAVED_AS("f")},
                          PLII_LEFT_PER_NODE(pose_state, parts), PLII_LEFT_PER_NODE(pose_state, next)),
    .topology_commit = pose_topology_commit,
};

pli_status pli_body_enable_pose_matching(pli_body* body, float matching) {
    PLII_TRY(plii_check_body_change(body, __func__));
    PLII_TRY(plii_check_limits(body->context, &matching, &plii_pose_class.settings, __func__));
    pose_state* pose = NULL;
    PLII_TRY(plii_feature_enable_with(body, &plii_pose_class, &matching, sizeof matching, (void**)&pose));
    pli_vec3 origin = plii_xyz(body->positions[0]), offset = pli_vec3_make(0, 0, 0);
    pose->rotation = pli_mat3_identity();
    pose_find_parts(body, pose);
    pose_update_weights(body, pose);
    if (body->world->def.reference_mode) {
        origin = pose_centre(body, pose);
    } else {
        offset = pose_offset(body, pose, NULL, 0, origin);
    }
    pose->centre = pli_vec3_add(origin, offset);
    for (int i = 0; i < body->node_count; ++i) {
        pose->rest[i] = pli_vec3_sub(pli_vec3_sub(plii_xyz(body->positions[i]), origin), offset);
    }
    pose->link_revision = body->link_revision - 1;
    return PLI_OK;
}
PLII_DEFINE_DISABLE(pli_body_disable_pose_matching, plii_check_body_change, plii_pose_class)

pli_status pli_body_get_pose(const pli_body* body, pli_transform* transform) {
    PLII_TRY(plii_check_body(body, __func__));
    if (transform == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "pose is null"); }
    const pose_state* pose = plii_feature_state(body, &plii_pose_class);
    if (pose == NULL) { return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE, "pose matching is not enabled"); }
    *transform = (pli_transform){pose->rotation, pose->centre};
    return PLI_OK;
}
