/* The matrix that turns a wanted change of relative displacement into an impulse, for contacts and anchors between a
   node and a rigid body. Bullet: ImpulseMatrix(dt, ima, imb, iwi, r), in its order of operations. */

#include "rigid_impl.h"

/* Without the products by zero of the cross and the diagonal matrices. */
pli_mat3 plii_impulse_matrix(float dt, float point_inverse_mass, float rigid_inverse_mass,
                             pli_mat3 rigid_inverse_inertia, pli_vec3 offset) {
    const pli_vec3* w = rigid_inverse_inertia.rows;
    const float x = offset.x, y = offset.y, z = offset.z;
    /* [offset]x W */
    const pli_vec3 turned[3] = {pli_vec3_sub(pli_vec3_scale(w[2], y), pli_vec3_scale(w[1], z)),
                                pli_vec3_sub(pli_vec3_scale(w[0], z), pli_vec3_scale(w[2], x)),
                                pli_vec3_sub(pli_vec3_scale(w[1], x), pli_vec3_scale(w[0], y))};
    float response[3][3];
    for (int i = 0; i < 3; ++i) {
        const pli_vec3 t = turned[i];
        response[i][0] = t.z * y - t.y * z;
        response[i][1] = t.x * z - t.z * x;
        response[i][2] = t.y * x - t.x * y;
        response[i][i] = point_inverse_mass + (rigid_inverse_mass + response[i][i]);
    }
    pli_mat3 sum;
    for (int i = 0; i < 3; ++i) {
        sum.rows[i] = pli_vec3_make(response[i][0], response[i][1], response[i][2]);
    }
    pli_mat3 matrix = plii_mat3_inverse(sum);
    const float inverse_dt = 1.0f / dt;
    for (int i = 0; i < 3; ++i) {
        /* The sum with a product by zero makes negative zeros positive. */
        matrix.rows[i] = pli_vec3_add(pli_vec3_scale(matrix.rows[i], inverse_dt), pli_vec3_make(0, 0, 0));
    }
    return matrix;
}
