/* The matrix that turns a wanted change of relative displacement into an impulse, for contacts and anchors between a
   node and a rigid body. Bullet: ImpulseMatrix(dt, ima, imb, iwi, r), in its order of operations. */

#include "rigid_impl.h"

pli_mat3 plii_impulse_matrix(float dt, float point_inverse_mass, float rigid_inverse_mass,
                             pli_mat3 rigid_inverse_inertia, pli_vec3 offset) {
    const pli_mat3 cross = plii_mat3_cross(offset);
    const pli_mat3 turn = pli_mat3_mul(pli_mat3_mul(cross, rigid_inverse_inertia), cross);
    pli_mat3 response = plii_mat3_diagonal(rigid_inverse_mass, rigid_inverse_mass, rigid_inverse_mass);
    for (int i = 0; i < 3; ++i) {
        response.rows[i] = pli_vec3_sub(response.rows[i], turn.rows[i]);
    }
    const pli_mat3 point = plii_mat3_diagonal(point_inverse_mass, point_inverse_mass, point_inverse_mass);
    const float inverse_dt = 1.0f / dt;
    return pli_mat3_mul(plii_mat3_diagonal(inverse_dt, inverse_dt, inverse_dt),
                        plii_mat3_inverse(plii_mat3_add(point, response)));
}
