/* The matrix that turns a wanted change of relative displacement into an impulse, for contacts and anchors between a
   node and a rigid body. Bullet: ImpulseMatrix(dt, ima, imb, iwi, r), in its order of operations. */

#include "body/rigid_lanes.h"

pli_mat3 plii_effective_mass(float dt, float point_inverse_mass, float rigid_inverse_mass,
                             pli_mat3 rigid_inverse_inertia, pli_vec3 offset) {
    const plii_lanes_mat3 m = plii_lanes_effective_mass(dt, point_inverse_mass, rigid_inverse_mass,
                                                        &rigid_inverse_inertia, plii_lanes_from_vec3(&offset));
    plii_float4 rows[4] = {m.columns[0], m.columns[1], m.columns[2], plii_float4_all(0.0f)};
    plii_float4_transpose(rows);
    pli_mat3 matrix;
    for (int i = 0; i < 3; ++i) {
        plii_lanes_to_vec3(&matrix.rows[i], rows[i]);
    }
    return matrix;
}
