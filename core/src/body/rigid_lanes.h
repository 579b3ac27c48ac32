#pragma once

/* Where the shapes of a rigid body are, in lanes, for contacts of nodes. */

#include "body/rigid_impl.h"
#include "math/simd_float4.h"

/* Where a shape is; w is zero. */
typedef struct plii_lanes_pose {
    plii_lanes_mat3 rotation, inverse; /* the latter is the transpose */
    plii_float4 origin;
} plii_lanes_pose;

/* plii_rigid_shape_transform */
PLII_SIMD_INLINE plii_lanes_pose plii_lanes_rigid_shape_pose(const pli_rigid* rigid, int index) {
    const pli_transform *own = &rigid->state.pose, *local = &rigid->shape_poses[index];
    const plii_lanes_mat3 own_rotation = plii_lanes_from_mat3(&own->rotation);
    /* By rows: the product with the transpose. */
    const plii_lanes_mat3 local_rows = {{plii_lanes_from_vec3(&local->rotation.rows[0]),
                                         plii_lanes_from_vec3(&local->rotation.rows[1]),
                                         plii_lanes_from_vec3(&local->rotation.rows[2])}};
    plii_float4 rows[4] = {plii_lanes_mat3_mul(&local_rows, plii_lanes_from_vec3(&own->rotation.rows[0])),
                           plii_lanes_mat3_mul(&local_rows, plii_lanes_from_vec3(&own->rotation.rows[1])),
                           plii_lanes_mat3_mul(&local_rows, plii_lanes_from_vec3(&own->rotation.rows[2])),
                           plii_float4_all(0.0f)};
    plii_lanes_pose pose = {.inverse = {{rows[0], rows[1], rows[2]}}};
    plii_float4_transpose(rows);
    pose.rotation = (plii_lanes_mat3){{rows[0], rows[1], rows[2]}};
    pose.origin =
        plii_lanes_mat3_mul(&own_rotation, plii_lanes_from_vec3(&local->origin)) + plii_lanes_from_vec3(&own->origin);
    return pose;
}

/* A shape of a rigid body at its present pose. */
typedef struct plii_shape_place {
    plii_lanes_pose pose;
    plii_lanes_bounds bounds;
    /* Wherever it is. */
    pli_bounds own_bounds;
    float radius, least_extent; /* m, of these: half the diagonal, half the shortest side */
} plii_shape_place;
