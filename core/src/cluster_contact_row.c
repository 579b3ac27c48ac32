/* A contact as the iterations see it: how the normal and two tangents move its sides, ready made. Impulses are summed
   over the iterations, the sum along the normal pushes only, and friction is bounded by it (Catto, "Iterative dynamics
   with temporal coherence", 2005). */

#include "lanes.h"

#include "cluster_contact_row.h"

/* Two unit vectors at right angles to a third and to each other (Duff and others, "Building an orthonormal basis,
   revisited", 2017). */
static void row_find_tangents(pli_vec3 n, pli_vec3 tangents[2]) {
    const float sign = n.z < 0.0f ? -1.0f : 1.0f;
    const float a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    tangents[0] = pli_vec3_make(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    tangents[1] = pli_vec3_make(b, sign + n.y * n.y * a, -n.y);
}

/* What an impulse along each direction does to a side: its turning moments go to `turns`. Velocity along the direction
   per unit, 1/kg. */
static plii_float4 row_take_side(float inverse_mass, const pli_mat3* inverse_inertia, pli_vec3 arm,
                                 plii_vec3x4 directions, pli_vec4 turns[3]) {
    const plii_vec3x4 moments = plii_vec3x4_cross(plii_vec3x4_all(arm), directions);
    const plii_vec3x4 changes = {plii_vec3x4_dot(plii_vec3x4_all(inverse_inertia->rows[0]), moments),
                                 plii_vec3x4_dot(plii_vec3x4_all(inverse_inertia->rows[1]), moments),
                                 plii_vec3x4_dot(plii_vec3x4_all(inverse_inertia->rows[2]), moments)};
    plii_float4 records[4] = {moments.x, moments.y, moments.z, plii_float4_all(0.0f)};
    plii_float4_turn(records);
    for (int k = 0; k < 3; ++k) {
        plii_float4_to(&turns[k], records[k]);
    }
    return plii_float4_add(plii_float4_all(inverse_mass), plii_vec3x4_dot(moments, changes));
}

static plii_float4 row_take_target(const plii_joint_target* target, pli_vec3 arm, plii_vec3x4 directions,
                                   pli_vec4 turns[3]) {
    const plii_cluster* cluster = target->cluster;
    if (cluster != NULL) {
        return row_take_side(cluster->inverse_mass, &cluster->inverse_inertia, arm, directions, turns);
    }
    const pli_rigid* rigid = target->rigid;
    if (rigid != NULL) {
        return row_take_side(rigid->state.inverse_mass, &rigid->state.inverse_inertia_world, arm, directions, turns);
    }
    for (int k = 0; k < 3; ++k) {
        turns[k] = (pli_vec4){0, 0, 0, 0};
    }
    return plii_float4_all(0.0f);
}

void plii_contact_row_make(const plii_joint_target targets[2], const pli_vec3 arms[2], pli_vec3 normal,
                           plii_contact_row* row) {
    pli_vec3 tangents[2];
    row_find_tangents(normal, tangents);
    plii_float4 records[4] = {plii_lanes_from_vec3(&normal), plii_lanes_from_vec3(&tangents[0]),
                              plii_lanes_from_vec3(&tangents[1]), plii_float4_all(0.0f)};
    for (int k = 0; k < 3; ++k) {
        plii_float4_to(&row->directions[k], records[k]);
    }
    plii_float4_turn(records);
    const plii_vec3x4 directions = {records[0], records[1], records[2]};
    const plii_float4 response = plii_float4_add(row_take_target(&targets[0], arms[0], directions, row->turns[0]),
                                                 row_take_target(&targets[1], arms[1], directions, row->turns[1]));
    /* 0 where nothing can move. */
    const plii_float4 zero = plii_float4_all(0.0f);
    const plii_mask4 can_move =
        plii_lanes_both(plii_lanes_less(plii_float4_all(FLT_MIN), response), plii_lanes_finite(response));
    const plii_float4 mass = plii_lanes_select(can_move, plii_float4_div(plii_float4_all(1.0f), response), zero);
    plii_float4_store(row->masses, mass);
    plii_float4_store(row->impulses, zero);
    plii_float4_store(row->wanted_speeds, zero);
    row->targets[0] = targets[0];
    row->targets[1] = targets[1];
}

/* Linear and angular. */
PLII_SIMD_INLINE void row_take_velocity(const plii_joint_target* target, plii_float4* linear, plii_float4* angular) {
    if (target->cluster != NULL) {
        *linear = plii_float4_from(&target->cluster->linear_velocity);
        *angular = plii_float4_from(&target->cluster->angular_velocity);
    } else if (target->rigid != NULL) {
        *linear = plii_lanes_from_vec3(&target->rigid->state.linear_velocity);
        *angular = plii_lanes_from_vec3(&target->rigid->state.angular_velocity);
    } else {
        *linear = *angular = plii_float4_all(0.0f);
    }
}

PLII_SIMD_INLINE plii_float4 row_speed(const plii_contact_row* row, int k, plii_float4 linear, plii_float4 angular_a,
                                       plii_float4 angular_b) {
    const plii_float4 turned = plii_float4_sub(plii_float4_mul(plii_float4_from(&row->turns[0][k]), angular_a),
                                               plii_float4_mul(plii_float4_from(&row->turns[1][k]), angular_b));
    return plii_float4_add(plii_float4_mul(plii_float4_from(&row->directions[k]), linear), turned);
}

PLII_SIMD_INLINE plii_float4 row_sum(const pli_vec4 records[3], plii_float4 x, plii_float4 y, plii_float4 z) {
    return plii_float4_add(plii_float4_add(plii_float4_mul(plii_float4_from(&records[0]), x),
                                           plii_float4_mul(plii_float4_from(&records[1]), y)),
                           plii_float4_mul(plii_float4_from(&records[2]), z));
}

PLII_SIMD_INLINE plii_float4 row_turn(const plii_cluster* cluster, plii_float4 moment) {
    const pli_vec3* rows = cluster->inverse_inertia.rows;
    plii_float4 turns[4] = {plii_float4_mul(plii_lanes_from_vec3(&rows[0]), moment),
                            plii_float4_mul(plii_lanes_from_vec3(&rows[1]), moment),
                            plii_float4_mul(plii_lanes_from_vec3(&rows[2]), moment), plii_float4_all(0.0f)};
    plii_float4_turn(turns);
    return plii_float4_add(plii_float4_add(turns[0], turns[1]), turns[2]);
}

PLII_SIMD_INLINE void row_push(plii_cluster* cluster, plii_float4 impulse, plii_float4 moment) {
    const plii_float4 change = plii_float4_mul(impulse, plii_float4_all(cluster->inverse_mass));
    plii_float4_to(&cluster->linear_velocity, plii_float4_add(plii_float4_from(&cluster->linear_velocity), change));
    plii_float4_to(&cluster->angular_velocity,
                   plii_float4_add(plii_float4_from(&cluster->angular_velocity), row_turn(cluster, moment)));
}

/* What the iterations did to the velocity of a cluster its nodes have still to follow. */
static void row_finish_side(const plii_contact_row* row, int side, plii_float4 x, plii_float4 y, plii_float4 z) {
    plii_cluster* cluster = row->targets[side].cluster;
    if (cluster == NULL) { return; }
    plii_float4 change = plii_float4_mul(row_sum(row->directions, x, y, z), plii_float4_all(cluster->inverse_mass));
    plii_float4 turn = row_turn(cluster, row_sum(row->turns[side], x, y, z));
    if (side == 1) {
        change = plii_float4_negate(change);
        turn = plii_float4_negate(turn);
    }
    const plii_float4 linear = plii_lanes_from_vec3(&cluster->velocity_impulse);
    const plii_float4 angular = plii_lanes_from_vec3(&cluster->angular_velocity_impulse);
    plii_lanes_to_vec3(&cluster->velocity_impulse, plii_float4_add(linear, change));
    plii_lanes_to_vec3(&cluster->angular_velocity_impulse, plii_float4_add(angular, turn));
    cluster->velocity_impulse_count += 1;
}

void plii_contact_row_finish(const plii_contact_row* row) {
    /* The motions of clusters that share nodes are averaged over those that were pushed. */
    if (row->impulses[0] == 0.0f && row->impulses[1] == 0.0f && row->impulses[2] == 0.0f) { return; }
    const plii_float4 x = plii_float4_all(row->impulses[0]), y = plii_float4_all(row->impulses[1]);
    const plii_float4 z = plii_float4_all(row->impulses[2]);
    row_finish_side(row, 0, x, y, z);
    row_finish_side(row, 1, x, y, z);
}

void plii_contact_row_solve(plii_contact_row* row, const pli_vec3* rigid_arm) {
    plii_float4 linear, linear_b, angular, angular_b;
    row_take_velocity(&row->targets[0], &linear, &angular);
    row_take_velocity(&row->targets[1], &linear_b, &angular_b);
    linear = plii_float4_sub(linear, linear_b);
    plii_float4 speeds[4] = {row_speed(row, 0, linear, angular, angular_b),
                             row_speed(row, 1, linear, angular, angular_b),
                             row_speed(row, 2, linear, angular, angular_b), plii_float4_all(0.0f)};
    plii_float4_turn(speeds);
    const plii_float4 speed = plii_float4_add(plii_float4_add(speeds[0], speeds[1]), speeds[2]);
    const plii_float4 before = plii_float4_load(row->impulses);
    const plii_float4 missing =
        plii_float4_mul(plii_float4_sub(plii_float4_load(row->wanted_speeds), speed), plii_float4_load(row->masses));
    float wanted[4];
    plii_float4_store(wanted, plii_float4_add(before, missing));

    const float normal = plii_clamp(wanted[0], 0.0f, row->limit);
    const float old = row->impulses[0];
    /* Going apart, with nothing to take back: no friction either. */
    if (old == 0.0f && !(normal > 0.0f)) { return; }
    const float bound = row->friction * normal;
    const float squared = wanted[1] * wanted[1] + wanted[2] * wanted[2];
    const float scale = squared > bound * bound ? bound / sqrtf(squared) : 1.0f;
    const float first = wanted[1] * scale, second = wanted[2] * scale;
    const plii_float4 x = plii_float4_all(normal - old);
    const plii_float4 y = plii_float4_all(first - row->impulses[1]), z = plii_float4_all(second - row->impulses[2]);
    row->impulses[0] = normal;
    row->impulses[1] = first;
    row->impulses[2] = second;
    const plii_float4 push = row_sum(row->directions, x, y, z);
    if (row->targets[0].cluster != NULL) { row_push(row->targets[0].cluster, push, row_sum(row->turns[0], x, y, z)); }
    const plii_float4 back = plii_float4_negate(push);
    if (row->targets[1].cluster != NULL) {
        row_push(row->targets[1].cluster, back, plii_float4_negate(row_sum(row->turns[1], x, y, z)));
    } else if (row->targets[1].rigid != NULL) {
        pli_vec3 impulse;
        plii_lanes_to_vec3(&impulse, back);
        plii_rigid_apply_impulse(row->targets[1].rigid, impulse, *rigid_arm);
    }
}
