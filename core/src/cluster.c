/* Clusters: frames, shape matching, damping, and the way of impulses from clusters to nodes (Müller and others,
   "Meshless deformations based on shape matching", 2005). Bullet: initializeClusters, updateClusters, applyClusters,
   dampClusters, in their order of operations. */

#include "cluster_impl.h"

#include "fat_box.h"
#include "polar.h"
#include "rotation_batch.h"
#include "world_impl.h"

/* Mass of a pinned node: as_bullet an absolute one, else this many times all other masses of the cluster. */
#define CLUSTER_BULLET_PINNED_MASS 1e18f
#define CLUSTER_PINNED_MASS_RATIO 1e6

// ------------------------------------------------------------------------------------------------------- the feature

static pli_vec3 cluster_centre(const pli_body* body, const plii_clusters* clusters, const plii_cluster* cluster) {
    const plii_cluster_member* members = &clusters->members[cluster->first_member];
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < cluster->member_count; ++i) {
        sum = pli_vec3_add(sum, pli_vec3_scale(plii_xyz(body->positions[members[i].node]), members[i].mass));
    }
    return pli_vec3_scale(sum, cluster->inverse_mass);
}

static pli_mat3 cluster_covariance(const pli_body* body, const plii_clusters* clusters, const plii_cluster* cluster,
                                   pli_vec3 centre) {
    const plii_cluster_member* members = &clusters->members[cluster->first_member];
    const float epsilon = clusters->def.as_bullet ? 1e-4f : 0.0f;
    pli_mat3 covariance = plii_mat3_diagonal(epsilon * 1.0f, epsilon * 2.0f, epsilon * 3.0f);
    for (int i = 0; i < cluster->member_count; ++i) {
        const pli_vec3 now = pli_vec3_sub(plii_xyz(body->positions[members[i].node]), centre);
        covariance.rows[0] = pli_vec3_add(covariance.rows[0], pli_vec3_scale(members[i].rest, now.x));
        covariance.rows[1] = pli_vec3_add(covariance.rows[1], pli_vec3_scale(members[i].rest, now.y));
        covariance.rows[2] = pli_vec3_add(covariance.rows[2], pli_vec3_scale(members[i].rest, now.z));
    }
    return covariance;
}

static void cluster_update_velocities(const pli_body* body, const plii_clusters* clusters, plii_cluster* cluster) {
    const plii_cluster_member* members = &clusters->members[cluster->first_member];
    pli_vec3 momentum = pli_vec3_make(0, 0, 0), spin = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < cluster->member_count; ++i) {
        const pli_vec3 share = pli_vec3_scale(plii_xyz(body->velocities[members[i].node]), members[i].mass);
        const pli_vec3 arm = pli_vec3_sub(plii_xyz(body->positions[members[i].node]), cluster->frame.origin);
        momentum = pli_vec3_add(momentum, share);
        spin = pli_vec3_add(spin, pli_vec3_cross(arm, share));
    }
    const pli_cluster_settings* settings = &cluster->settings;
    cluster->linear_velocity =
        pli_vec3_scale(pli_vec3_scale(momentum, cluster->inverse_mass), 1.0f - settings->linear_damping);
    cluster->angular_velocity =
        pli_vec3_scale(pli_mat3_mul_vec3(cluster->inverse_inertia, spin), 1.0f - settings->angular_damping);
}

/* The frame is known; what follows from it. */
static void cluster_update_from_frame(const pli_body* body, const plii_clusters* clusters, plii_cluster* cluster) {
    const pli_mat3 rotation = cluster->frame.rotation;
    cluster->inverse_inertia =
        pli_mat3_mul(pli_mat3_mul(rotation, cluster->inverse_inertia_local), pli_mat3_transpose(rotation));
    cluster_update_velocities(body, clusters, cluster);
    cluster->velocity_impulse = cluster->angular_velocity_impulse = pli_vec3_make(0, 0, 0);
    cluster->drift_impulse = cluster->angular_drift_impulse = pli_vec3_make(0, 0, 0);
    cluster->velocity_impulse_count = cluster->drift_impulse_count = 0;
}

static void cluster_match(pli_body* body, const plii_clusters* clusters, const plii_cluster* cluster) {
    const plii_cluster_member* members = &clusters->members[cluster->first_member];
    for (int i = 0; i < cluster->member_count; ++i) {
        pli_vec4* position = &body->positions[members[i].node];
        if (!(position->w > 0.0f) && !clusters->def.as_bullet) { continue; }
        const pli_vec3 goal = pli_transform_point(cluster->frame, members[i].rest);
        plii_set_xyz(position, pli_vec3_lerp(plii_xyz(*position), goal, cluster->settings.matching));
    }
}

static void cluster_update_bounds(const pli_body* body, const plii_clusters* clusters, plii_cluster* cluster) {
    pli_vec3 min = plii_cluster_node(body, clusters, cluster, 0), max = min;
    for (int i = 1; i < cluster->member_count; ++i) {
        const pli_vec3 x = plii_cluster_node(body, clusters, cluster, i);
        min = plii_vec3_min(min, x);
        max = plii_vec3_max(max, x);
    }
    const pli_bounds bounds = {min, max};
    if (clusters->def.as_bullet && cluster->has_bounds) {
        const pli_vec3 motion = pli_vec3_scale(pli_vec3_scale(cluster->linear_velocity, body->step.dt), 3.0f);
        plii_fat_box_update(&cluster->bounds, bounds, motion, body->collision_margin);
    } else {
        cluster->bounds = bounds;
        cluster->has_bounds = true;
    }
}

/* As Bullet does: one cluster after the other, so that the matching of one is seen by the next. */
static void clusters_update_in_order(pli_body* body, plii_clusters* clusters, int first) {
    for (int i = first; i < clusters->count; ++i) {
        plii_cluster* cluster = &clusters->items[i];
        cluster->frame.origin = cluster_centre(body, clusters, cluster);
        const pli_mat3 covariance = cluster_covariance(body, clusters, cluster, cluster->frame.origin);
        cluster->frame.rotation = plii_polar_factor(covariance, cluster->frame.rotation);
        cluster_update_from_frame(body, clusters, cluster);
        if (cluster->settings.matching > 0.0f) { cluster_match(body, clusters, cluster); }
        if (cluster->settings.collides) { cluster_update_bounds(body, clusters, cluster); }
    }
}

/* Frames of all clusters first, a batch at a time; then matching. */
static void clusters_update_in_batches(pli_body* body, plii_clusters* clusters, int first) {
    for (int begin = first; begin < clusters->count; begin += PLII_ROTATION_LANES) {
        const int end = begin + PLII_ROTATION_LANES < clusters->count ? begin + PLII_ROTATION_LANES : clusters->count;
        pli_mat3 covariances[PLII_ROTATION_LANES];
        pli_mat3 rotations[PLII_ROTATION_LANES];
        for (int i = begin; i < end; ++i) {
            plii_cluster* cluster = &clusters->items[i];
            cluster->frame.origin = cluster_centre(body, clusters, cluster);
            covariances[i - begin] = cluster_covariance(body, clusters, cluster, cluster->frame.origin);
            rotations[i - begin] = cluster->frame.rotation;
        }
        plii_rotation_batch(covariances, rotations, end - begin);
        for (int i = begin; i < end; ++i) {
            clusters->items[i].frame.rotation = rotations[i - begin];
            cluster_update_from_frame(body, clusters, &clusters->items[i]);
        }
    }
    for (int i = first; i < clusters->count; ++i) {
        if (clusters->items[i].settings.matching > 0.0f) { cluster_match(body, clusters, &clusters->items[i]); }
    }
    for (int i = first; i < clusters->count; ++i) {
        if (clusters->items[i].settings.collides) { cluster_update_bounds(body, clusters, &clusters->items[i]); }
    }
}

static void clusters_update_from(pli_body* body, plii_clusters* clusters, int first) {
    if (clusters->def.as_bullet) {
        clusters_update_in_order(body, clusters, first);
    } else {
        clusters_update_in_batches(body, clusters, first);
    }
}

static void clusters_update(pli_body* body, void* state, const plii_step* step) {
    (void)step;
    clusters_update_from(body, state, 0);
}

/* Adds the rigid motion of a cluster to its members' sums. */
static void cluster_spread(const pli_body* body, const plii_clusters* clusters, const plii_cluster* cluster,
                           pli_vec3 displacement, pli_vec3 turn) {
    const plii_cluster_member* members = &clusters->members[cluster->first_member];
    for (int i = 0; i < cluster->member_count; ++i) {
        const pli_vec3 arm = pli_vec3_sub(plii_xyz(body->positions[members[i].node]), cluster->frame.origin);
        const pli_vec3 moved = pli_vec3_scale(pli_vec3_add(displacement, pli_vec3_cross(turn, arm)), members[i].mass);
        pli_vec4* sum = &clusters->node_sums[members[i].node];
        plii_set_xyz(sum, pli_vec3_add(plii_xyz(*sum), moved));
        sum->w += members[i].mass;
    }
}

static void clusters_move_nodes(pli_body* body, plii_clusters* clusters) {
    for (int i = 0; i < body->node_count; ++i) {
        pli_vec4* sum = &clusters->node_sums[i];
        if (sum->w > 0.0f && (body->positions[i].w > 0.0f || clusters->def.as_bullet)) {
            plii_set_xyz(&body->positions[i],
                         pli_vec3_add(plii_xyz(body->positions[i]), plii_vec3_divide(plii_xyz(*sum), sum->w)));
        }
        *sum = (pli_vec4){0, 0, 0, 0};
    }
}

static void clusters_apply_velocity_impulses(pli_body* body, void* state, const plii_step* step) {
    plii_clusters* clusters = state;
    bool any = false;
    for (int i = 0; i < clusters->count; ++i) {
        const plii_cluster* cluster = &clusters->items[i];
        if (cluster->velocity_impulse_count == 0) { continue; }
        any = true;
        cluster_spread(body, clusters, cluster, pli_vec3_scale(cluster->velocity_impulse, step->dt),
                       pli_vec3_scale(cluster->angular_velocity_impulse, step->dt));
    }
    if (any) { clusters_move_nodes(body, clusters); }
}

/* Corrections are averaged, not summed. */
static void clusters_apply_drift_impulses(pli_body* body, plii_clusters* clusters, const plii_step* step) {
    bool any = false;
    for (int i = 0; i < clusters->count; ++i) {
        plii_cluster* cluster = &clusters->items[i];
        if (cluster->drift_impulse_count == 0) { continue; }
        any = true;
        const float count = (float)cluster->drift_impulse_count;
        cluster->drift_impulse = plii_vec3_divide(cluster->drift_impulse, count);
        cluster->angular_drift_impulse = plii_vec3_divide(cluster->angular_drift_impulse, count);
        cluster_spread(body, clusters, cluster, pli_vec3_scale(cluster->drift_impulse, step->dt),
                       pli_vec3_scale(cluster->angular_drift_impulse, step->dt));
    }
    if (any) { clusters_move_nodes(body, clusters); }
}

static void cluster_damp_nodes(pli_body* body, const plii_clusters* clusters, const plii_cluster* cluster) {
    const plii_cluster_member* members = &clusters->members[cluster->first_member];
    for (int i = 0; i < cluster->member_count; ++i) {
        const int node = members[i].node;
        if (!(body->positions[node].w > 0.0f)) { continue; }
        const pli_vec3 arm = pli_vec3_sub(plii_xyz(body->previous[node]), cluster->frame.origin);
        const pli_vec3 rigid = pli_vec3_add(cluster->linear_velocity, pli_vec3_cross(cluster->angular_velocity, arm));
        const pli_vec3 own = plii_xyz(body->velocities[node]);
        if (pli_vec3_length_squared(rigid) <= pli_vec3_length_squared(own)) {
            const pli_vec3 change = pli_vec3_scale(pli_vec3_sub(rigid, own), cluster->settings.node_damping);
            plii_set_xyz(&body->velocities[node], pli_vec3_add(own, change));
        }
    }
}

static void clusters_finish(pli_body* body, void* state, const plii_step* step) {
    plii_clusters* clusters = state;
    for (int i = 0; i < clusters->count; ++i) {
        if (clusters->items[i].settings.node_damping > 0.0f) {
            cluster_damp_nodes(body, clusters, &clusters->items[i]);
        }
    }
    clusters_apply_drift_impulses(body, clusters, step);
}

static size_t clusters_node_sums_bytes(const pli_body* body) {
    return (size_t)body->node_count * sizeof(pli_vec4);
}

void plii_clusters_release(pli_body* body, plii_clusters* clusters) {
    plii_release(body->context, clusters->items, (size_t)clusters->capacity * sizeof *clusters->items);
    plii_release(body->context, clusters->members, (size_t)clusters->member_capacity * sizeof *clusters->members);
    plii_release(body->context, clusters->node_sums, clusters_node_sums_bytes(body));
    const pli_clusters_def def = clusters->def;
    *clusters = (plii_clusters){.def = def};
}

static void clusters_disable(pli_body* body, void* state) {
    plii_clusters_release(body, state);
    body->joint_iterations = 0;
}

static size_t clusters_bytes(const pli_body* body, const void* state) {
    const plii_clusters* clusters = state;
    return (size_t)clusters->capacity * sizeof *clusters->items +
           (size_t)clusters->member_capacity * sizeof *clusters->members +
           (clusters->node_sums != NULL ? clusters_node_sums_bytes(body) : 0);
}

const plii_feature_class plii_clusters_class = {
    .name = "clusters",
    .state_size = sizeof(plii_clusters),
    .stages = {[PLII_STAGE_UPDATE] = {clusters_update, PLII_ORDER_CLUSTERS},
               [PLII_STAGE_PREPARE] = {clusters_apply_velocity_impulses, PLII_ORDER_APPLY_CLUSTERS},
               [PLII_STAGE_FINISH] = {clusters_finish, PLII_ORDER_APPLY_CLUSTERS}},
    .disable = clusters_disable,
    .bytes = clusters_bytes,
};

// --------------------------------------------------------------------------------------------- masses and rest shape

static void cluster_take_masses(const pli_body* body, const plii_clusters* clusters, plii_cluster* cluster) {
    plii_cluster_member* members = &clusters->members[cluster->first_member];
    double free_mass = 0.0;
    cluster->contains_pinned_node = false;
    for (int i = 0; i < cluster->member_count; ++i) {
        const float inverse_mass = body->positions[members[i].node].w;
        if (inverse_mass > 0.0f) {
            free_mass += 1.0 / (double)inverse_mass;
        } else {
            cluster->contains_pinned_node = true;
        }
    }
    float pinned_mass = CLUSTER_BULLET_PINNED_MASS;
    if (!clusters->def.as_bullet) { pinned_mass = (float)(CLUSTER_PINNED_MASS_RATIO * fmax(free_mass, 1e-6)); }
    float total = 0.0f;
    for (int i = 0; i < cluster->member_count; ++i) {
        const float inverse_mass = body->positions[members[i].node].w;
        members[i].mass = inverse_mass > 0.0f ? 1.0f / inverse_mass : pinned_mass;
        total += members[i].mass;
    }
    cluster->inverse_mass = 1.0f / total;
}

/* Symmetric 3x3 matrix to eigenvalues and orthonormal columns, by Jacobi rotations. */
static void cluster_eigen(double a[3][3], double vectors[3][3]) {
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            vectors[i][k] = i == k ? 1.0 : 0.0;
        }
    }
    for (int sweep = 0; sweep < 16; ++sweep) {
        for (int p = 0; p < 2; ++p) {
            for (int q = p + 1; q < 3; ++q) {
                if (a[p][q] == 0.0) { continue; }
                const double theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
                const double t = (theta >= 0.0 ? 1.0 : -1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
                const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double kp = a[k][p], kq = a[k][q];
                    a[k][p] = c * kp - s * kq;
                    a[k][q] = s * kp + c * kq;
                }
                for (int k = 0; k < 3; ++k) {
                    const double pk = a[p][k], qk = a[q][k];
                    a[p][k] = c * pk - s * qk;
                    a[q][k] = s * pk + c * qk;
                }
                for (int k = 0; k < 3; ++k) {
                    const double kp = vectors[k][p], kq = vectors[k][q];
                    vectors[k][p] = c * kp - s * kq;
                    vectors[k][q] = s * kp + c * kq;
                }
            }
        }
    }
}

/* Inverse of an inertia that may be singular: nodes in a line, or one node, do not turn about the directions in which
   they have no inertia (Bullet divides by zero there). */
static pli_mat3 cluster_pseudo_inverse(pli_mat3 inertia) {
    double a[3][3], vectors[3][3];
    for (int i = 0; i < 3; ++i) {
        a[i][0] = (double)inertia.rows[i].x;
        a[i][1] = (double)inertia.rows[i].y;
        a[i][2] = (double)inertia.rows[i].z;
    }
    cluster_eigen(a, vectors);
    const double largest = fmax(a[0][0], fmax(a[1][1], a[2][2]));
    double inverse[3][3] = {{0}};
    for (int k = 0; k < 3; ++k) {
        if (!(a[k][k] > 1e-6 * largest) || !(a[k][k] > 1e-30)) { continue; }
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                inverse[i][j] += vectors[i][k] * vectors[j][k] / a[k][k];
            }
        }
    }
    pli_mat3 result;
    for (int i = 0; i < 3; ++i) {
        result.rows[i] = pli_vec3_make((float)inverse[i][0], (float)inverse[i][1], (float)inverse[i][2]);
    }
    return plii_mat3_is_finite(result) ? result : plii_mat3_diagonal(0, 0, 0);
}

static void cluster_take_rest_shape(const pli_body* body, const plii_clusters* clusters, plii_cluster* cluster) {
    plii_cluster_member* members = &clusters->members[cluster->first_member];
    const pli_vec3 centre = cluster_centre(body, clusters, cluster);
    pli_mat3 inertia = plii_mat3_diagonal(0, 0, 0);
    for (int i = 0; i < cluster->member_count; ++i) {
        const pli_vec3 k = pli_vec3_sub(plii_xyz(body->positions[members[i].node]), centre);
        const float mass = members[i].mass;
        members[i].rest = k;
        inertia.rows[0].x += mass * (k.y * k.y + k.z * k.z);
        inertia.rows[1].y += mass * (k.x * k.x + k.z * k.z);
        inertia.rows[2].z += mass * (k.x * k.x + k.y * k.y);
        inertia.rows[0].y -= mass * k.x * k.y;
        inertia.rows[0].z -= mass * k.x * k.z;
        inertia.rows[1].z -= mass * k.y * k.z;
    }
    inertia.rows[1].x = inertia.rows[0].y;
    inertia.rows[2].x = inertia.rows[0].z;
    inertia.rows[2].y = inertia.rows[1].z;
    const pli_mat3 inverse = plii_mat3_inverse(inertia);
    const bool is_regular = clusters->def.as_bullet && plii_mat3_is_finite(inverse);
    cluster->inverse_inertia_local = is_regular ? inverse : cluster_pseudo_inverse(inertia);
    cluster->frame = (pli_transform){pli_mat3_identity(), centre};
    cluster->linear_velocity = cluster->angular_velocity = pli_vec3_make(0, 0, 0);
    cluster->has_bounds = false;
}

void plii_clusters_settle(pli_body* body, plii_clusters* clusters, int first) {
    for (int i = first; i < clusters->count; ++i) {
        cluster_take_masses(body, clusters, &clusters->items[i]);
        cluster_take_rest_shape(body, clusters, &clusters->items[i]);
    }
    clusters_update_from(body, clusters, first);
}

// ----------------------------------------------------------------------------------------------------------- editing

plii_clusters* plii_body_clusters(const pli_body* body) {
    return plii_feature_state(body, &plii_clusters_class);
}

pli_clusters_def pli_clusters_def_default(void) {
    return (pli_clusters_def){.iterations = 4, .cookie = PLII_DEF_COOKIE};
}

static pli_cluster_settings cluster_default_settings(void) {
    return (pli_cluster_settings){.collides = true, .max_self_impulse = 100.0f, .self_impulse_factor = 1.0f};
}

static pli_status clusters_check_idle(const pli_body* body, const char* function) {
    PLII_TRY(plii_check_body(body, function));
    if (!body->world->is_stepping) { return PLI_OK; }
    return plii_fail(body->context, PLI_ERROR_WRONG_STATE, function, "not allowed between predict and solve");
}

pli_status pli_body_enable_clusters(pli_body* body, const pli_clusters_def* def) {
    PLII_TRY(clusters_check_idle(body, __func__));
    const pli_clusters_def used = def != NULL ? *def : pli_clusters_def_default();
    if (used.cookie != PLII_DEF_COOKIE) {
        return PLII_FAIL(body->context, PLI_ERROR_INVALID_DEF, "start from pli_clusters_def_default()");
    }
    if (used.iterations < 1) {
        return PLII_FAIL(body->context, PLI_ERROR_INVALID_VALUE, "iterations is %d, at least 1 is allowed",
                         used.iterations);
    }
    void* state = NULL;
    PLII_TRY(plii_feature_enable(body, &plii_clusters_class, &state));
    plii_clusters* clusters = state;
    const bool has_other_masses = used.as_bullet != clusters->def.as_bullet;
    clusters->def = used;
    body->joint_iterations = used.iterations;
    if (has_other_masses) { plii_clusters_settle(body, clusters, 0); }
    return PLI_OK;
}

/* Everything that holds to clusters of this body goes with them. */
static void clusters_forget(pli_body* body) {
    for (int i = 0; i < body->world->body_count; ++i) {
        pli_body* other = body->world->bodies[i];
        for (int k = 0; k < other->pipeline.feature_count; ++k) {
            const plii_feature* feature = &other->pipeline.features[k];
            if (feature->klass->forget_clusters != NULL) {
                feature->klass->forget_clusters(other, feature->state, body);
            }
        }
    }
}

void pli_body_disable_clusters(pli_body* body) {
    if (clusters_check_idle(body, __func__) != PLI_OK || plii_body_clusters(body) == NULL) { return; }
    clusters_forget(body);
    plii_clusters_release(body, plii_body_clusters(body));
    plii_feature_disable(body, &plii_clusters_class);
}

pli_status pli_body_remove_clusters(pli_body* body) {
    PLII_TRY(clusters_check_idle(body, __func__));
    plii_clusters* clusters = plii_body_clusters(body);
    if (clusters == NULL) { return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE, "clusters are not enabled"); }
    clusters_forget(body);
    plii_clusters_release(body, clusters);
    return PLI_OK;
}

pli_status plii_clusters_append(pli_body* body, plii_clusters* clusters, const int* nodes, int node_count) {
    pli_context* context = body->context;
    if (node_count > INT32_MAX - clusters->member_count ||
        !PLII_RESERVE(context, &clusters->items, &clusters->capacity, clusters->count + 1) ||
        !PLII_RESERVE(context, &clusters->members, &clusters->member_capacity, clusters->member_count + node_count)) {
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    if (clusters->node_sums == NULL) {
        clusters->node_sums = plii_allocate(context, clusters_node_sums_bytes(body));
        if (clusters->node_sums == NULL) { return PLI_ERROR_OUT_OF_MEMORY; }
    }
    clusters->items[clusters->count++] = (plii_cluster){
        .settings = cluster_default_settings(), .first_member = clusters->member_count, .member_count = node_count};
    for (int i = 0; i < node_count; ++i) {
        clusters->members[clusters->member_count++] = (plii_cluster_member){.node = nodes[i]};
    }
    return PLI_OK;
}

static pli_status cluster_check_nodes(pli_body* body, const int* nodes, int node_count, const char* function) {
    pli_context* context = body->context;
    if (nodes == NULL) { return plii_fail(context, PLI_ERROR_NULL_ARGUMENT, function, "nodes is null"); }
    if (node_count < 1 || node_count > body->node_count) {
        return plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "%d nodes, the body has %d", node_count,
                         body->node_count);
    }
    uint8_t* is_taken = plii_allocate(context, (size_t)body->node_count);
    if (is_taken == NULL) { return plii_fail(context, PLI_ERROR_OUT_OF_MEMORY, function, "no memory for the check"); }
    pli_status status = PLI_OK;
    for (int i = 0; i < node_count && status == PLI_OK; ++i) {
        status = plii_check_node(body, nodes[i], function);
        if (status == PLI_OK && is_taken[nodes[i]] != 0) {
            status = plii_fail(context, PLI_ERROR_INVALID_VALUE, function, "node %d is named twice", nodes[i]);
        }
        if (status == PLI_OK) { is_taken[nodes[i]] = 1; }
    }
    plii_release(context, is_taken, (size_t)body->node_count);
    return status;
}

pli_status pli_body_add_cluster(pli_body* body, const int* nodes, int node_count, int* cluster) {
    PLII_TRY(clusters_check_idle(body, __func__));
    PLII_TRY(cluster_check_nodes(body, nodes, node_count, __func__));
    const bool was_enabled = plii_body_clusters(body) != NULL;
    if (!was_enabled) { PLII_TRY(pli_body_enable_clusters(body, NULL)); }
    plii_clusters* clusters = plii_body_clusters(body);
    if (plii_clusters_append(body, clusters, nodes, node_count) != PLI_OK) {
        if (!was_enabled) { pli_body_disable_clusters(body); }
        return PLII_FAIL(body->context, PLI_ERROR_OUT_OF_MEMORY, "no memory for a cluster of %d nodes", node_count);
    }
    plii_clusters_settle(body, clusters, clusters->count - 1);
    if (cluster != NULL) { *cluster = clusters->count - 1; }
    return PLI_OK;
}

pli_status pli_body_reset_clusters(pli_body* body) {
    PLII_TRY(clusters_check_idle(body, __func__));
    plii_clusters* clusters = plii_body_clusters(body);
    if (clusters == NULL) { return PLII_FAIL(body->context, PLI_ERROR_WRONG_STATE, "clusters are not enabled"); }
    plii_clusters_settle(body, clusters, 0);
    return PLI_OK;
}

// ------------------------------------------------------------------------------------------------------------ access

pli_status plii_check_cluster(const pli_body* body, int cluster, const char* function) {
    PLII_TRY(plii_check_body(body, function));
    const plii_clusters* clusters = plii_body_clusters(body);
    const int count = clusters != NULL ? clusters->count : 0;
    if (cluster >= 0 && cluster < count) { return PLI_OK; }
    return plii_fail(body->context, PLI_ERROR_INDEX_OUT_OF_RANGE, function,
                     "cluster %d is out of range, the body has %d clusters", cluster, count);
}

int pli_body_cluster_count(const pli_body* body) {
    if (plii_check_body(body, __func__) != PLI_OK) { return 0; }
    const plii_clusters* clusters = plii_body_clusters(body);
    return clusters != NULL ? clusters->count : 0;
}

pli_status pli_body_get_cluster_settings(const pli_body* body, int cluster, pli_cluster_settings* settings) {
    PLII_TRY(plii_check_cluster(body, cluster, __func__));
    if (settings == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "settings is null"); }
    *settings = plii_body_clusters(body)->items[cluster].settings;
    return PLI_OK;
}

static bool cluster_is_share(float value) {
    return value >= 0.0f && value <= 1.0f;
}

pli_status pli_body_set_cluster_settings(pli_body* body, int cluster, const pli_cluster_settings* settings) {
    PLII_TRY(plii_check_cluster(body, cluster, __func__));
    if (settings == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "settings is null"); }
    if (!cluster_is_share(settings->matching) || !cluster_is_share(settings->node_damping) ||
        !cluster_is_share(settings->linear_damping) || !cluster_is_share(settings->angular_damping) ||
        !cluster_is_share(settings->self_impulse_factor)) {
        return PLII_FAIL(body->context, PLI_ERROR_INVALID_VALUE,
                         "matching %g, node, linear and angular damping %g, %g, %g, self_impulse_factor %g: all must "
                         "be in [0, 1]",
                         (double)settings->matching, (double)settings->node_damping, (double)settings->linear_damping,
                         (double)settings->angular_damping, (double)settings->self_impulse_factor);
    }
    if (!(settings->max_self_impulse >= 0.0f)) {
        return PLII_FAIL(body->context, PLI_ERROR_INVALID_VALUE, "max_self_impulse is %g, it must not be negative",
                         (double)settings->max_self_impulse);
    }
    plii_body_clusters(body)->items[cluster].settings = *settings;
    return PLI_OK;
}

/* Members are records; the public view wants plain indices, which stand first in them. */
pli_status pli_body_get_cluster(const pli_body* body, int cluster, pli_cluster_view* view) {
    PLII_TRY(plii_check_cluster(body, cluster, __func__));
    if (view == NULL) { return PLII_FAIL(body->context, PLI_ERROR_NULL_ARGUMENT, "view is null"); }
    const plii_clusters* clusters = plii_body_clusters(body);
    const plii_cluster* item = &clusters->items[cluster];
    *view = (pli_cluster_view){
        .node_count = item->member_count,
        .nodes = &clusters->members[item->first_member].node,
        .node_stride = (int)(sizeof(plii_cluster_member) / sizeof(int)),
        .frame = item->frame,
        .inverse_mass = item->inverse_mass,
        .inverse_inertia_world = item->inverse_inertia,
        .linear_velocity = item->linear_velocity,
        .angular_velocity = item->angular_velocity,
        .contains_pinned_node = item->contains_pinned_node,
    };
    return PLI_OK;
}
