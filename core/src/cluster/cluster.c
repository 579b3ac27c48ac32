/* Clusters: frames, shape matching (Müller and others, "Meshless deformations based on shape matching", 2005), damping,
   impulses for nodes. Bullet, in order of operations: updateClusters, applyClusters, dampClusters. */

#include "body/pipeline.h"
#include "body/substep.h"
#include "cluster/cluster_impl.h"
#include "math/bounds.h"
#include "math/rotation_fit.h"
#include "math/simd_float4.h"

pli_vec3 plii_cluster_centre(const pli_body* body, const plii_cluster* cluster) {
    const plii_cluster_member* members = plii_cluster_members(body, cluster);
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < cluster->member_count; ++i) {
        sum = pli_vec3_add(sum, pli_vec3_scale(plii_xyz(body->positions[members[i].node]), members[i].rest.w));
    }
    return pli_vec3_scale(sum, cluster->inverse_mass);
}

/* In reference mode; others sum up in one pass. */
static pli_mat3 cluster_covariance(const pli_body* body, const plii_cluster* cluster) {
    const plii_cluster_member* members = plii_cluster_members(body, cluster);
    const float epsilon = 1e-4f;
    pli_mat3 covariance = plii_mat3_diagonal(epsilon * 1.0f, epsilon * 2.0f, epsilon * 3.0f);
    for (int i = 0; i < cluster->member_count; ++i) {
        const pli_vec3 now = pli_vec3_sub(plii_xyz(body->positions[members[i].node]), cluster->frame.origin);
        const pli_vec3 rest = plii_xyz(members[i].rest);
        covariance.rows[0] = pli_vec3_add(covariance.rows[0], pli_vec3_scale(rest, now.x));
        covariance.rows[1] = pli_vec3_add(covariance.rows[1], pli_vec3_scale(rest, now.y));
        covariance.rows[2] = pli_vec3_add(covariance.rows[2], pli_vec3_scale(rest, now.z));
    }
    return covariance;
}

static void cluster_update_velocities(const pli_body* body, plii_cluster* cluster) {
    const plii_cluster_member* members = plii_cluster_members(body, cluster);
    pli_vec3 momentum = pli_vec3_make(0, 0, 0), spin = momentum;
    for (int i = 0; i < cluster->member_count; ++i) {
        const pli_vec3 share = pli_vec3_scale(plii_xyz(body->velocities[members[i].node]), members[i].rest.w);
        const pli_vec3 arm = pli_vec3_sub(plii_xyz(body->positions[members[i].node]), cluster->frame.origin);
        momentum = pli_vec3_add(momentum, share);
        spin = pli_vec3_add(spin, pli_vec3_cross(arm, share));
    }
    const pli_cluster_settings* settings = &cluster->settings;
    plii_set_xyz(&cluster->linear_velocity,
                 pli_vec3_scale(pli_vec3_scale(momentum, cluster->inverse_mass), 1.0f - settings->linear_damping));
    plii_set_xyz(&cluster->angular_velocity,
                 pli_vec3_scale(pli_mat3_mul_vec3(cluster->inverse_inertia, spin), 1.0f - settings->angular_damping));
}

/* Turned to where the frame is. */
static void cluster_update_inertia(plii_cluster* cluster) {
    const pli_mat3 rotation = cluster->frame.rotation, turned = pli_mat3_mul(rotation, cluster->inverse_inertia_local);
    cluster->inverse_inertia = pli_mat3_mul(turned, pli_mat3_transpose(rotation));
}

static void cluster_match(pli_body* body, const plii_cluster* cluster) {
    const plii_cluster_member* members = plii_cluster_members(body, cluster);
    const plii_lanes_mat3 columns = plii_lanes_columns(&cluster->frame.rotation);
    const plii_float4 origin = plii_lanes_from_vec3(&cluster->frame.origin);
    for (int i = 0; i < cluster->member_count; ++i) {
        const int node = members[i].node;
        if (!(body->positions[node].w > 0.0f) && !body->clusters->def.reference_mode) { continue; }
        const plii_float4 goal = plii_lanes_combine(columns, plii_float4_from(&members[i].rest)) + origin;
        plii_body_pull_predicted(body, node, plii_lanes_vec3(goal), cluster->settings.matching);
    }
}

static void cluster_update_bounds(const pli_body* body, plii_cluster* cluster) {
    const plii_cluster_member* members = plii_cluster_members(body, cluster);
    plii_float4 low = plii_float4_from(&body->positions[members[0].node]), high = low;
    for (int i = 1; i < cluster->member_count; ++i) {
        const plii_float4 x = plii_float4_from(&body->positions[members[i].node]);
        low = plii_lanes_min(low, x);
        high = plii_lanes_max(high, x);
    }
    const pli_bounds bounds = {plii_lanes_vec3(low), plii_lanes_vec3(high)};
    if (body->clusters->def.reference_mode && cluster->has_bounds) {
        const pli_vec3 motion = pli_vec3_scale(pli_vec3_scale(plii_xyz(cluster->linear_velocity), body->step.dt), 3.0f);
        plii_fat_aabb_update(&cluster->bounds, bounds, motion, body->collision_margin);
    } else {
        cluster->bounds = bounds;
        cluster->has_bounds = true;
    }
}

static void cluster_update_frame_of_bullet(const pli_body* body, plii_cluster* cluster) {
    cluster->frame.origin = plii_cluster_centre(body, cluster);
    const pli_mat3 covariance = cluster_covariance(body, cluster);
    const pli_mat3 rotation = plii_polar_factor_of_bullet(covariance);
    cluster->has_no_frame = !plii_mat3_is_finite(rotation);
    cluster->frame.rotation = cluster->has_no_frame ? plii_polar_factor(covariance, cluster->frame.rotation) : rotation;
    cluster_update_inertia(cluster);
    cluster_update_velocities(body, cluster);
}

/* What a frame and its motion are made of, about where the centre is by the first member and the rotation of before:
   sums of large numbers round to one side, by which matching would pull what rests in every step. */
typedef struct cluster_sums {
    plii_float4 about, moment, momentum, spin; /* w of each is of no use */
    plii_float4 rest, products[3];             /* rest positions, and these by each coordinate of the present ones */
} cluster_sums;

/* One pass: each of the sums is a chain of additions, which then wait for each other no longer. */
static cluster_sums cluster_sum_up(const pli_body* body, const plii_cluster* cluster) {
    const plii_cluster_member* members = plii_cluster_members(body, cluster);
    const plii_float4 zero = plii_float4_all(0.0f);
    const pli_vec3 arm = pli_mat3_mul_vec3(cluster->frame.rotation, plii_xyz(members[0].rest));
    const plii_float4 about = plii_float4_from(&body->positions[members[0].node]) - plii_lanes_from_vec3(&arm);
    cluster_sums sums = {about, zero, zero, zero, zero, {zero, zero, zero}};
    const bool is_predicted = body->solver_class->has_substeps && body->world->is_stepping; /* velocities are not */
    for (int i = 0; i < cluster->member_count; ++i) {
        const plii_float4 rest = plii_float4_from(&members[i].rest), mass = plii_lanes_all_w(rest);
        const int node = members[i].node;
        const plii_float4 x = plii_float4_from(&body->positions[node]), now = x - about;
        plii_float4 velocity = plii_float4_from(&body->velocities[node]);
        if (is_predicted) { velocity = (x - plii_float4_from(&body->previous[node])) * body->step.inverse_dt; }
        const plii_float4 share = velocity * mass;
        sums.moment += now * mass;
        sums.momentum += share;
        sums.spin += plii_lanes_cross(now, share);
        sums.rest += rest;
        sums.products[0] += rest * plii_lanes_all_x(now);
        sums.products[1] += rest * plii_lanes_all_y(now);
        sums.products[2] += rest * plii_lanes_all_z(now);
    }
    return sums;
}

/* Sets centre and velocities, the angular one still without the inverse inertia, and returns the covariance. */
static pli_mat3 cluster_read_sums(plii_cluster* cluster, const cluster_sums* sums) {
    const plii_float4 inverse_mass = plii_float4_all(cluster->inverse_mass);
    const plii_float4 centre = sums->moment * inverse_mass;
    plii_lanes_to_vec3(&cluster->frame.origin, sums->about + centre);
    const plii_float4 spin = sums->spin - plii_lanes_cross(centre, sums->momentum);
    const plii_float4 left = plii_float4_all(1.0f - cluster->settings.linear_damping);
    plii_float4_to(&cluster->linear_velocity, plii_lanes_xyz(sums->momentum * inverse_mass * left));
    plii_float4_to(&cluster->angular_velocity, plii_lanes_xyz(spin));
    if (cluster->is_point) { return plii_mat3_diagonal(0, 0, 0); }
    const plii_float4 shifts[3] = {plii_lanes_all_x(centre), plii_lanes_all_y(centre), plii_lanes_all_z(centre)};
    pli_mat3 covariance;
    for (int k = 0; k < 3; ++k) {
        plii_lanes_to_vec3(&covariance.rows[k], sums->products[k] - sums->rest * shifts[k]);
    }
    return covariance;
}

/* Of up to four: the rotations of a cloth of small clusters would take most of the time one by one. */
static void clusters_update_few(const pli_body* body, plii_cluster** items, int count) {
    pli_mat3 rotations[PLII_LANES];
    pli_quat* quaternions[PLII_LANES] = {0};
    for (int i = 0; i < count; ++i) {
        const cluster_sums sums = cluster_sum_up(body, items[i]);
        rotations[i] = cluster_read_sums(items[i], &sums);
        quaternions[i] = &items[i]->warm_rotation;
    }
    plii_rotations_fit_warm(count, rotations, quaternions);
    for (int i = 0; i < count; ++i) {
        plii_cluster* cluster = items[i];
        cluster->has_frame = true;
        cluster->frame.rotation = rotations[i];
        cluster_update_inertia(cluster);
        const pli_vec3 spin = pli_mat3_mul_vec3(cluster->inverse_inertia, plii_xyz(cluster->angular_velocity));
        plii_set_xyz(&cluster->angular_velocity, pli_vec3_scale(spin, 1.0f - cluster->settings.angular_damping));
    }
}

void plii_cluster_update_frame(const pli_body* body, plii_cluster* cluster) {
    if (cluster->has_frame) { return; }
    if (!body->clusters->def.reference_mode) {
        clusters_update_few(body, &cluster, 1);
    } else {
        cluster->has_frame = true;
        cluster_update_frame_of_bullet(body, cluster);
    }
}

void plii_clusters_update_frames(const pli_body* body, pli_bounds near) {
    plii_clusters* clusters = body->clusters;
    plii_cluster* items[PLII_LANES];
    int count = 0;
    for (int i = 0; i < clusters->count; ++i) {
        plii_cluster* cluster = &clusters->items[i];
        const bool is_near = cluster->settings.collides && plii_bounds_overlap(cluster->bounds, near);
        if (is_near && !cluster->has_frame) { items[count++] = cluster; }
        if (count == PLII_LANES || (count > 0 && i + 1 == clusters->count)) {
            clusters_update_few(body, items, count);
            count = 0;
        }
    }
}

/* Each frame right before its matching: that of positions which the cluster before has moved would push and turn all
   of them together. */
static void clusters_update_from(pli_body* body, plii_clusters* clusters, int first, bool in_step) {
    const bool is_of_bullet = clusters->def.reference_mode;
    clusters->keeps_momentum = false;
    for (int i = first; i < clusters->count; ++i) {
        plii_cluster* cluster = &clusters->items[i];
        const bool matches = in_step && cluster->settings.matching > 0.0f;
        const bool needs_frame = is_of_bullet || !in_step || matches || cluster->settings.node_damping > 0.0f;
        cluster->has_frame = false;
        cluster->split = 1.0f;
        cluster->keeps_momentum = false;
        cluster->impulse = cluster->drift = (plii_cluster_impulse){.count = 0};
        if (needs_frame) {
            plii_cluster_update_frame(body, cluster);
            cluster->has_frame = in_step || is_of_bullet; /* nodes may be placed before the next step */
        }
        if (matches) { cluster_match(body, cluster); }
        if (is_of_bullet && cluster->settings.collides) { cluster_update_bounds(body, cluster); }
    }
    for (int i = first; i < clusters->count && !is_of_bullet; ++i) {
        if (clusters->items[i].settings.collides) { cluster_update_bounds(body, &clusters->items[i]); }
    }
}

void plii_clusters_settle(pli_body* body, plii_clusters* clusters, int first) {
    for (int i = first; i < clusters->count; ++i) {
        plii_cluster_set_rest_shape(body, &clusters->items[i]);
    }
    clusters_update_from(body, clusters, first, false);
}

static void clusters_update(pli_body* body, void* state) {
    clusters_update_from(body, state, 0, true);
}

/* Adds the rigid motion of a cluster to its members' sums. Those of several that keep momentum move as the mean of all,
   so each such motion is that of its shares of their masses, with an inertia of the same form. */
static void cluster_spread(const pli_body* body, const plii_cluster* cluster, pli_vec3 displacement,
                           pli_vec3 rotation_vector, bool keeps_momentum) {
    const plii_cluster_member* members = plii_cluster_members(body, cluster);
    pli_vec4* sums = body->clusters->node_sums;
    plii_float4 centre = plii_lanes_from_vec3(&cluster->frame.origin), axis = plii_lanes_from_vec3(&rotation_vector);
    plii_float4 all = plii_lanes_xyzw(displacement.x, displacement.y, displacement.z, keeps_momentum ? 0.0f : 1.0f);
    if (keeps_momentum) {
        plii_float4 mass = plii_float4_all(0.0f), moment = mass, spread = mass, own_spread = mass;
        for (int i = 0; i < cluster->member_count; ++i) {
            const plii_float4 rest = plii_lanes_all_w(plii_float4_from(&members[i].rest));
            const plii_float4 own = rest * rest / sums[members[i].node].w;
            const plii_float4 arm = plii_lanes_xyz(plii_float4_from(&body->positions[members[i].node]) - centre);
            mass += own;
            moment += arm * own;
            spread += arm * arm * rest;
            own_spread += arm * arm * own;
        }
        const plii_float4 shift = moment / mass, push = all * (1.0f / cluster->inverse_mass);
        const pli_vec3 turn = plii_lanes_vec3(plii_lanes_cross(shift, push));
        const pli_vec3 change = pli_mat3_mul_vec3(cluster->inverse_inertia, turn);
        const plii_float4 one = plii_lanes_xyzw(1, 1, 1, 0);
        own_spread -= moment * shift;
        const float more = plii_lanes_dot(spread, one) / plii_max(plii_lanes_dot(own_spread, one), FLT_MIN);
        axis = (axis - plii_lanes_from_vec3(&change)) * more;
        centre += shift;
        all = push / mass;
    }
    for (int i = 0; i < cluster->member_count; ++i) {
        const plii_float4 arm = plii_float4_from(&body->positions[members[i].node]) - centre;
        const plii_float4 moved = all + plii_lanes_cross(axis, plii_lanes_xyz(arm));
        pli_vec4* sum = &sums[members[i].node];
        plii_float4_to(sum, plii_float4_from(sum) + moved * members[i].rest.w);
    }
}

/* `rate`: 1/s, of velocities, which XPBD starts from. What stands against forces acts through substeps as they do. */
static void clusters_move_nodes(pli_body* body, plii_clusters* clusters, float rate) {
    const plii_float4 zero = plii_float4_all(0.0f);
    const float late = 0.5f - 0.5f / (float)body->solver_class->pace(body).substeps;
    for (int i = 0; i < body->node_count; ++i) {
        pli_vec4* sum = &clusters->node_sums[i];
        if (sum->w > 0.0f && (body->positions[i].w > 0.0f || clusters->def.reference_mode)) {
            const plii_float4 moved = plii_lanes_xyz(plii_float4_from(sum) * (1.0f / sum->w));
            const plii_float4 v = plii_float4_from(&body->velocities[i]), x = plii_float4_from(&body->positions[i]);
            plii_float4_to(&body->positions[i], x + moved);
            if (rate > 0.0f) {
                plii_float4_to(&body->velocities[i], v + moved * rate);
                const plii_float4 given = x - plii_float4_from(&body->previous[i]) - v * body->step.dt;
                const float ratio = -plii_lanes_dot(given, moved) / plii_max(plii_lanes_dot(moved, moved), FLT_MIN);
                const plii_float4 back = moved * (-late * plii_clamp(ratio, 0.0f, 1.0f));
                /* Where a body that is lost goes back to. */
                if (plii_lanes_xyz_finite(back)) { plii_add_xyz(&body->previous[i], plii_lanes_vec3(back)); }
            }
        }
        plii_float4_to(sum, zero);
    }
}

/* Leaves the masses that they give a node in w of its sum, for clusters_apply. */
void plii_clusters_split_masses(plii_clusters* clusters) {
    for (int i = 0; i < 2 * clusters->count; ++i) {
        plii_cluster* cluster = &clusters->items[i % clusters->count];
        float mass = 0.0f;
        for (int k = 0; cluster->keeps_momentum && k < cluster->member_count; ++k) {
            const plii_cluster_member* member = &clusters->members[cluster->first_member + k];
            float* total = &clusters->node_sums[member->node].w;
            *total += i < clusters->count ? member->rest.w : 0.0f;
            mass += member->rest.w * member->rest.w / *total;
        }
        clusters->keeps_momentum |= cluster->keeps_momentum;
        if (cluster->keeps_momentum) { cluster->split = 1.0f / (mass * cluster->inverse_mass); }
    }
}

/* Nodes are displaced along tangents, which makes a body larger: by 3 % at this angle, rad. */
#define CLUSTER_MAX_DRIFT_ANGLE 0.25f

/* Changes of velocity are summed, corrections averaged. Clusters that keep momentum come first and share with each
   other only: beside joints and what rests on rigid bodies impulses are averaged as they always were. */
static void clusters_apply(pli_body* body, plii_clusters* clusters, float dt, bool is_drift, float rate) {
    bool any = false;
    const int rest = clusters->count;
    const bool shares = clusters->keeps_momentum && !is_drift;
    for (int i = clusters->keeps_momentum ? 0 : rest; i < 2 * rest; ++i) {
        const plii_cluster* cluster = &clusters->items[i < rest ? i : i - rest];
        plii_cluster_impulse sum = is_drift ? cluster->drift : cluster->impulse;
        if (sum.count == 0 || cluster->keeps_momentum != (i < rest)) { continue; }
        any = true;
        if (is_drift) {
            sum.linear = plii_vec3_divide(sum.linear, (float)sum.count);
            sum.angular = plii_vec3_divide(sum.angular, (float)sum.count);
            const float angle = pli_vec3_length(sum.angular) * dt;
            const float most = clusters->def.reference_mode ? INFINITY : CLUSTER_MAX_DRIFT_ANGLE;
            if (angle > most) { sum.angular = pli_vec3_scale(sum.angular, most / angle); }
        }
        cluster_spread(body, cluster, pli_vec3_scale(sum.linear, dt), pli_vec3_scale(sum.angular, dt),
                       shares && i < rest);
    }
    if (any || shares) { clusters_move_nodes(body, clusters, rate); }
}

/* Velocity iterations go on from velocities alone; btSoftBody loses the impulses there. */
static void clusters_prepare(pli_body* body, void* state) {
    const bool is_of_velocities = body->solver_class == &plii_position_solver && body->solver.velocity_iterations > 0;
    const bool is_of_bullet = ((const plii_clusters*)state)->def.reference_mode;
    const bool changes_velocities = body->solver_class->has_substeps || (is_of_velocities && !is_of_bullet);
    clusters_apply(body, state, body->step.dt, false, changes_velocities ? body->step.inverse_dt : 0.0f);
}

static void cluster_damp_nodes(pli_body* body, const plii_cluster* cluster) {
    const plii_cluster_member* members = plii_cluster_members(body, cluster);
    const plii_float4 linear = plii_float4_from(&cluster->linear_velocity);
    const plii_float4 angular = plii_float4_from(&cluster->angular_velocity);
    const plii_float4 centre = plii_lanes_from_vec3(&cluster->frame.origin);
    const float damping = cluster->settings.node_damping;
    for (int i = 0; i < cluster->member_count; ++i) {
        const int node = members[i].node;
        if (!(body->positions[node].w > 0.0f)) { continue; }
        const plii_float4 arm = plii_float4_from(&body->previous[node]) - centre;
        const plii_float4 rigid = linear + plii_lanes_cross(angular, arm);
        const plii_float4 velocity = plii_float4_from(&body->velocities[node]);
        if (!(plii_lanes_dot(rigid, rigid) <= plii_lanes_dot(velocity, velocity))) { continue; }
        plii_float4_to(&body->velocities[node], plii_lanes_xyz(velocity + (rigid - velocity) * damping));
    }
}

static void clusters_finish(pli_body* body, void* state) {
    plii_clusters* clusters = state;
    for (PLII_EACH(const plii_cluster, cluster, clusters->items, clusters->count)) {
        if (cluster->settings.node_damping > 0.0f && !cluster->has_no_inverse && !cluster->has_no_frame) {
            cluster_damp_nodes(body, cluster);
        }
    }
    clusters_apply(body, clusters, body->step.dt, true, 0.0f);
}

void plii_clusters_release(pli_body* body, plii_clusters* clusters) {
    PLII_RELEASE(body->context, clusters->items, clusters->capacity);
    PLII_RELEASE(body->context, clusters->members, clusters->member_capacity);
    memset(clusters->node_sums, 0, (size_t)body->node_count * sizeof *clusters->node_sums);
    *clusters = (plii_clusters){.def = clusters->def, .node_sums = clusters->node_sums};
}

static void clusters_enable(pli_body* body, void* state) {
    body->clusters = state;
    body->clusters->def = pli_clusters_def_default();
    body->joint_iterations = body->clusters->def.iterations;
}
static void clusters_disable(pli_body* body, void* state) {
    /* Also when their last user was another feature. */
    plii_features_notify(body->world, PLII_CLUSTERS_REMOVED, body);
    body->joint_iterations = 0;
    body->clusters = NULL;
}

/* A copy of a member, and a node between two members, joins the cluster where they are in the rest shape. `indices1`
   holds for each node its index in the cluster + 1, or 0. Returns the number of members. */
static int cluster_join(const plii_topology_change* change, plii_cluster_member* members, int count, int* indices1) {
    for (int i = 0; i < count; ++i) {
        indices1[members[i].node] = i + 1;
    }
    for (int i = change->old_node_count; i < change->node_count; ++i) {
        const plii_node_origin* origin = &change->node_origins[i - change->old_node_count];
        const int a = indices1[origin->a], b = indices1[origin->b];
        if (a == 0 || b == 0) { continue; }
        const pli_vec3 rest =
            pli_vec3_lerp(plii_xyz(members[a - 1].rest), plii_xyz(members[b - 1].rest), origin->share);
        members[count++] = (plii_cluster_member){.node = i, .rest = {rest.x, rest.y, rest.z, 0.0f}};
        indices1[i] = count;
    }
    for (int i = 0; i < count; ++i) {
        indices1[members[i].node] = 0;
    }
    return count;
}

/* Lists the members of all clusters with those that join, after the present ones. */
static bool clusters_topology_reserve(const pli_body* body, void* state, const plii_topology_change* change) {
    plii_clusters* clusters = state;
    plii_scratch scratch = {.context = body->context};
    int* indices1 = PLII_TAKE(&scratch, int, change->node_count);
    const int new_nodes = change->node_count - change->old_node_count;
    clusters->next_member_count = 0;
    for (int i = 0; i < clusters->count && !scratch.is_short; ++i) {
        plii_cluster* cluster = &clusters->items[i];
        const int end = clusters->member_count + clusters->next_member_count;
        scratch.is_short = !PLII_RESERVE(body->context, &clusters->members, &clusters->member_capacity,
                                         end + cluster->member_count + new_nodes);
        if (scratch.is_short) { break; }
        memcpy(&clusters->members[end], &clusters->members[cluster->first_member],
               (size_t)cluster->member_count * sizeof *clusters->members);
        cluster->next_member_count = cluster_join(change, &clusters->members[end], cluster->member_count, indices1);
        clusters->next_member_count += cluster->next_member_count;
    }
    const bool is_complete = !scratch.is_short;
    plii_scratch_free(&scratch);
    return is_complete;
}

/* The rest shape stays, also where links take the present one: a frame must not turn in its joints. */
static void clusters_topology_commit(pli_body* body, void* state, const plii_topology_change* change) {
    plii_clusters* clusters = state;
    if (clusters->count == 0) { return; }
    memmove(clusters->members, &clusters->members[clusters->member_count],
            (size_t)clusters->next_member_count * sizeof *clusters->members);
    clusters->member_count = 0;
    for (PLII_EACH(plii_cluster, cluster, clusters->items, clusters->count)) {
        cluster->first_member = clusters->member_count;
        cluster->member_count = cluster->next_member_count;
        clusters->member_count += cluster->member_count;
        plii_cluster_update_masses(body, cluster);
    }
    clusters_update_from(body, clusters, 0, false);
}

/* Impulses of joints and cluster contacts are applied before anything else is solved. */
enum { CLUSTERS_UPDATE_ORDER = 10, CLUSTERS_APPLY_ORDER = 5 };

static bool clusters_is_sound(const pli_body* body, const void* data) {
    const plii_clusters* clusters = data;
    int members = 0;
    for (PLII_EACH(const plii_cluster, cluster, clusters->items, clusters->count)) {
        if (cluster->first_member != members || cluster->member_count < 1) { return false; }
        if (cluster->member_count > clusters->member_count - members) { return false; }
        members += cluster->member_count;
    }
    return members == clusters->member_count;
}

const plii_feature_class plii_clusters_class = {
    .name = "clusters",
    .state_size = sizeof(plii_clusters),
    .settings = PLII_LIMITS_AT(offsetof(plii_clusters, def), PLII_FIELD(pli_clusters_def, iterations, 1, INT_MAX)),
    .state_parts = PLII_STATE_PARTS(PLII_STATE_OF(plii_clusters, def, PLII_SAVED, "iBu"),
                                    PLII_STATE_SPAN(plii_clusters, next_member_count, keeps_momentum, PLII_LEFT, NULL)),
    .is_sound = clusters_is_sound,
    .stages = {[PLII_STAGE_UPDATE] = {clusters_update, CLUSTERS_UPDATE_ORDER},
               [PLII_STAGE_PREPARE] = {clusters_prepare, CLUSTERS_APPLY_ORDER},
               [PLII_STAGE_FINISH] = {clusters_finish, CLUSTERS_APPLY_ORDER}},
    .arrays = PLII_ARRAYS(
        PLII_LEFT_PER_NODE(plii_clusters, node_sums),
        {PLII_COUNTED_LIST(plii_clusters, items, capacity, count), PLII_SAVED_AS("4fB2f3i4Bg9g3f12g4g10g8g6gi6giU6g3B"),
         .settings = PLII_LIMITS(plii_cluster, settings, plii_cluster_settings_fields)},
        {PLII_COUNTED_LIST(plii_clusters, members, member_capacity, member_count), PLII_SAVED_AS("n4f")}),
    .substepped = PLII_SUBSTEPPED(.order = CLUSTERS_APPLY_ORDER, .begin = clusters_prepare),
    .enable = clusters_enable,
    .disable = clusters_disable,
    .topology_reserve = clusters_topology_reserve,
    .topology_commit = clusters_topology_commit,
};
