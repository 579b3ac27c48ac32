#pragma once

/* What rigid_impl.h has for contacts and anchors of nodes, in lanes and with the same results. */

#include "body/rigid_impl.h"
#include "math/simd_float4.h"

/* Where a shape is; w is zero. */
typedef struct plii_lanes_pose {
    plii_lanes_mat3 rotation, inverse; /* the latter is the transpose */
    plii_float4 origin;
} plii_lanes_pose;

PLII_SIMD_INLINE plii_lanes_pose plii_lanes_rigid_shape_pose(const pli_rigid* rigid, int index) {
    const pli_transform pose = plii_rigid_shape_transform(rigid, index);
    const pli_vec3* rows = pose.rotation.rows;
    return (plii_lanes_pose){
        .rotation = plii_lanes_from_mat3(&pose.rotation),
        .inverse = {{plii_lanes_from_vec3(&rows[0]), plii_lanes_from_vec3(&rows[1]), plii_lanes_from_vec3(&rows[2])}},
        .origin = plii_lanes_from_vec3(&pose.origin)};
}

/* A shape of a rigid body at its present pose. */
typedef struct plii_shape_place {
    plii_lanes_pose pose;
    plii_lanes_bounds bounds;
    float radius, least_extent; /* m, of its own bounds: half the diagonal, half the shortest side */
} plii_shape_place;

/* plii_rigid_velocity_at */
PLII_SIMD_INLINE plii_float4 plii_lanes_rigid_velocity_at(const pli_rigid* rigid, plii_float4 offset) {
    return plii_lanes_from_vec3(&rigid->state.linear_velocity) +
           plii_lanes_cross(plii_lanes_from_vec3(&rigid->state.angular_velocity), offset);
}

/* plii_rigid_apply_impulse; w of the impulse is left out. */
PLII_SIMD_INLINE void plii_lanes_rigid_apply_impulse(pli_rigid* rigid, plii_float4 impulse, plii_float4 offset) {
    pli_rigid_state* state = &rigid->state;
    if (state->inverse_mass == 0.0f) { return; }
    const plii_float4 scaled = impulse * plii_lanes_from_vec3(&rigid->linear_factor);
    const plii_float4 push = scaled * state->inverse_mass;
    plii_lanes_to_vec3(&state->linear_velocity, plii_lanes_from_vec3(&state->linear_velocity) + push);
    const plii_lanes_mat3 inverse_inertia = plii_lanes_from_mat3(&state->inverse_inertia_world);
    const plii_float4 spin = plii_lanes_mat3_mul(&inverse_inertia, plii_lanes_cross(offset, scaled));
    const plii_float4 angular_change = spin * plii_lanes_from_vec3(&rigid->angular_factor);
    plii_lanes_to_vec3(&state->angular_velocity, plii_lanes_from_vec3(&state->angular_velocity) + angular_change);
}

/* A row of -[offset]x times `turned`, with the inverse masses of both on the diagonal: in the lane where `unit` is 1.
 */
PLII_SIMD_INLINE plii_float4 plii_lanes_impulse_row(plii_float4 offset, plii_float4 turned, plii_float4 point_mass,
                                                    plii_float4 rigid_mass, plii_float4 unit) {
    return point_mass * unit + (rigid_mass * unit + plii_lanes_cross(offset, turned));
}

/* plii_effective_mass, without the products by zero of Bullet's cross matrices; w is zero. */
PLII_SIMD_INLINE plii_lanes_mat3 plii_lanes_effective_mass(float dt, float point_inverse_mass, float rigid_inverse_mass,
                                                           const pli_mat3* rigid_inverse_inertia, plii_float4 offset) {
    static const float units[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    const plii_float4 point = plii_float4_all(point_inverse_mass), rigid = plii_float4_all(rigid_inverse_mass);
    const plii_float4 x = plii_lanes_all_x(offset), y = plii_lanes_all_y(offset), z = plii_lanes_all_z(offset);
    const plii_float4 w0 = plii_lanes_from_vec3(&rigid_inverse_inertia->rows[0]),
                      w1 = plii_lanes_from_vec3(&rigid_inverse_inertia->rows[1]),
                      w2 = plii_lanes_from_vec3(&rigid_inverse_inertia->rows[2]);
    /* Rows of [offset]x W */
    const plii_float4 turned0 = w2 * y - w1 * z, turned1 = w0 * z - w2 * x, turned2 = w1 * x - w0 * y;
    const plii_float4 a = plii_lanes_impulse_row(offset, turned0, point, rigid, plii_float4_load(units[0])),
                      b = plii_lanes_impulse_row(offset, turned1, point, rigid, plii_float4_load(units[1])),
                      c = plii_lanes_impulse_row(offset, turned2, point, rigid, plii_float4_load(units[2]));
    /* plii_mat3_inverse. Zeros of either sign above make zeros here, and the sum makes them positive. */
    const plii_float4 cofactors = plii_lanes_cross(b, c), zero = plii_float4_all(0.0f);
    const plii_float4 s = plii_float4_all(1.0f / plii_lanes_dot(a, cofactors)), per_dt = plii_float4_all(1.0f / dt);
    const plii_float4 column0 = cofactors * s * per_dt, column1 = plii_lanes_cross(c, a) * s * per_dt,
                      column2 = plii_lanes_cross(a, b) * s * per_dt;
    return (plii_lanes_mat3){
        {plii_lanes_xyz(column0 + zero), plii_lanes_xyz(column1 + zero), plii_lanes_xyz(column2 + zero)}};
}
