/* The matrix that turns a wanted change of relative displacement into an impulse, for contacts and anchors between a
   node and a rigid body. Bullet: ImpulseMatrix(dt, ima, imb, iwi, r) and MassMatrix, in their order of operations. */

#include "body/rigid_impl.h"

pli_mat3 plii_point_response(float inverse_mass, pli_mat3 inverse_inertia, pli_vec3 offset) {
    const pli_mat3 cross = plii_mat3_cross(offset);
    const pli_mat3 turned = pli_mat3_mul(pli_mat3_mul(cross, inverse_inertia), cross);
    pli_mat3 response = plii_mat3_diagonal(inverse_mass, inverse_mass, inverse_mass);
    for (int i = 0; i < 3; ++i) {
        response.rows[i] = pli_vec3_sub(response.rows[i], turned.rows[i]);
    }
    return response;
}

pli_mat3 plii_effective_mass(float dt, float point_inverse_mass, float rigid_inverse_mass,
                             pli_mat3 rigid_inverse_inertia, pli_vec3 offset) {
    const pli_mat3 point = plii_mat3_diagonal(point_inverse_mass, point_inverse_mass, point_inverse_mass);
    const pli_mat3 rigid = plii_point_response(rigid_inverse_mass, rigid_inverse_inertia, offset);
    pli_mat3 matrix = plii_mat3_inverse(plii_mat3_add(point, rigid));
    for (int i = 0; i < 3; ++i) {
        matrix.rows[i] = pli_vec3_scale(matrix.rows[i], 1.0f / dt);
    }
    return matrix;
}
