/* Pose matching: nodes are pulled towards the rest shape in its best-fitting place (Müller and others, "Meshless
   deformations based on shape matching", 2005). Bullet: setPose(false, true), updatePose and kMT. */

#include "pliant/pose.h"

#include "body_impl.h"
#include "polar.h"

#include <string.h>

typedef struct pose_state {
    float matching;
    pli_vec3* rest; /* [node_count] m, from the centre of mass */
    float* weights; /* [node_count], sum 1 */
    pli_mat3 rotation;
    pli_vec3 centre; /* m */
} pose_state;

static pli_vec3 pose_centre(const pli_body* body, const pose_state* pose) {
    pli_vec3 centre = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < body->node_count; ++i) {
        centre = pli_vec3_add(centre, pli_vec3_scale(plii_xyz(body->positions[i]), pose->weights[i]));
    }
    return centre;
}

static void pose_run(pli_body* body, void* state, const plii_step* step) {
    (void)step;
    pose_state* pose = state;
    const pli_vec3 centre = pose_centre(body, pose);
    pose->centre = centre;

    /* Starting from a small diagonal keeps a mesh in a coordinate plane from being singular. */
    pli_mat3 covariance = plii_mat3_diagonal(PLII_EPSILON, PLII_EPSILON * 2.0f, PLII_EPSILON * 3.0f);
    for (int i = 0; i < body->node_count; ++i) {
        const pli_vec3 now = pli_vec3_scale(pli_vec3_sub(plii_xyz(body->positions[i]), centre), pose->weights[i]);
        const pli_vec3 rest = pose->rest[i];
        covariance.rows[0] = pli_vec3_add(covariance.rows[0], pli_vec3_scale(rest, now.x));
        covariance.rows[1] = pli_vec3_add(covariance.rows[1], pli_vec3_scale(rest, now.y));
        covariance.rows[2] = pli_vec3_add(covariance.rows[2], pli_vec3_scale(rest, now.z));
    }
    pose->rotation = plii_polar_factor(covariance, pose->rotation);

    if (!(pose->matching > 0.0f)) { return; }
    for (int i = 0; i < body->node_count; ++i) {
        if (body->positions[i].w > 0.0f) {
            const pli_vec3 goal = pli_vec3_add(pli_mat3_mul_vec3(pose->rotation, pose->rest[i]), centre);
            plii_set_xyz(&body->positions[i], pli_vec3_lerp(plii_xyz(body->positions[i]), goal, pose->matching));
        }
    }
}

static void pose_disable(pli_body* body, void* state) {
    pose_state* pose = state;
    const size_t count = (size_t)body->node_count;
    plii_release(body->context, pose->rest, count * sizeof *pose->rest);
    plii_release(body->context, pose->weights, count * sizeof *pose->weights);
    pose->rest = NULL;
    pose->weights = NULL;
}

static pli_status pose_enable(pli_body* body, void* state) {
    pose_state* pose = state;
    const size_t count = (size_t)body->node_count;
    pose->rest = plii_allocate(body->context, count * sizeof *pose->rest);
    pose->weights = plii_allocate(body->context, count * sizeof *pose->weights);
    if (pose->rest == NULL || pose->weights == NULL) {
        pose_disable(body, state);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    return PLI_OK;
}

static size_t pose_bytes(const pli_body* body, const void* state) {
    const pose_state* pose = state;
    return (size_t)body->node_count * (sizeof *pose->rest + sizeof *pose->weights);
}

/* Shares of the total mass, where a pinned node counts a thousand times all others. */
static void pose_take_weights(const pli_body* body, pose_state* pose) {
    float free_mass = 0.0f;
    for (int i = 0; i < body->node_count; ++i) {
        const float inverse_mass = body->positions[i].w;
        free_mass += inverse_mass > 0.0f ? 1.0f / inverse_mass : 0.0f;
    }
    const float pinned_mass = free_mass * (float)body->node_count * 1000.0f;
    float total = free_mass;
    for (int i = 0; i < body->node_count; ++i) {
        if (!(body->positions[i].w > 0.0f)) { total += pinned_mass; }
    }
    for (int i = 0; i < body->node_count; ++i) {
        const float inverse_mass = body->positions[i].w;
        pose->weights[i] = inverse_mass > 0.0f ? 1.0f / (inverse_mass * total) : pinned_mass / total;
        /* All nodes are pinned. */
        if (!(total > 0.0f)) { pose->weights[i] = 1.0f / (float)body->node_count; }
    }
}

static int pose_topology_blocks(const pli_body* body, const void* state, const plii_topology_change* change,
                                size_t* sizes) {
    const pose_state* pose = state;
    (void)body;
    sizes[0] = (size_t)change->node_count * sizeof *pose->rest;
    sizes[1] = (size_t)change->node_count * sizeof *pose->weights;
    return 2;
}

/* New nodes lie between their parents at rest too. Masses have moved to them, so the centre is taken again. */
static void pose_topology_commit(pli_body* body, void* state, const plii_topology_change* change, void** blocks) {
    pose_state* pose = state;
    pli_vec3* rest = blocks[0];
    memcpy(rest, pose->rest, (size_t)change->old_node_count * sizeof *rest);
    for (int i = change->old_node_count; i < change->node_count; ++i) {
        const plii_node_origin origin = change->node_origins[i - change->old_node_count];
        rest[i] = pli_vec3_lerp(rest[origin.a], rest[origin.b], origin.share);
    }
    plii_release(body->context, pose->rest, (size_t)change->old_node_count * sizeof *pose->rest);
    plii_release(body->context, pose->weights, (size_t)change->old_node_count * sizeof *pose->weights);
    pose->rest = rest;
    pose->weights = blocks[1];
    pose_take_weights(body, pose);
    pli_vec3 centre = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < change->node_count; ++i) {
        centre = pli_vec3_add(centre, pli_vec3_scale(rest[i], pose->weights[i]));
    }
    for (int i = 0; i < change->node_count; ++i) {
        rest[i] = pli_vec3_sub(rest[i], centre);
    }
}

static const plii_feature_class pose_class = {
    .name = "pose matching",
    .state_size = sizeof(pose_state),
    .stages = {[PLII_STAGE_UPDATE] = {pose_run, PLII_ORDER_POSE}},
    .enable = pose_enable,
    .disable = pose_disable,
    .bytes = pose_bytes,
    .topology_blocks = pose_topology_blocks,
    .topology_commit = pose_topology_commit,
};

static void pose_take_rest_shape(const pli_body* body, pose_state* pose) {
    pose_take_weights(body, pose);
    pose->centre = pose_centre(body, pose);
    pose->rotation = pli_mat3_identity();
    for (int i = 0; i < body->node_count; ++i) {
        pose->rest[i] = pli_vec3_sub(plii_xyz(body->positions[i]), pose->centre);
    }
}

pli_status pli_body_enable_pose_matching(pli_body* body, float matching) {
    PLII_TRY(plii_check_body(body, __func__));
    if (!plii_is_finite(matching)) {
        return PLII_FAIL(body->context, PLI_ERROR_NOT_FINITE, "matching is %g", (double)matching);
    }
    if (matching < 0.0f || matching > 1.0f) {
        return PLII_FAIL(body->context, PLI_ERROR_INVALID_VALUE, "matching is %g, 0 to 1 is allowed", (double)matching);
    }
    void* state = NULL;
    PLII_TRY(plii_feature_enable(body, &pose_class, &state));
    pose_state* pose = state;
    pose->matching = matching;
    pose_take_rest_shape(body, pose);
    return PLI_OK;
}

void pli_body_disable_pose_matching(pli_body* body) {
    if (plii_check_body(body, __func__) == PLI_OK) { plii_feature_disable(body, &pose_class); }
}

pli_status pli_body_get_pose(const pli_body* body, pli_transform* transform) {
    PLII_TRY(plii_check_body(body, __func__));
    if (transform == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "pose is null"); }
    const pose_state* pose = plii_feature_state(body, &pose_class);
    if (pose == NULL) { return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE, "pose matching is not enabled"); }
    transform->rotation = pose->rotation;
    transform->origin = pose->centre;
    return PLI_OK;
}
