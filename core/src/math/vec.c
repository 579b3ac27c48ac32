/* Matrix helpers; the order of operations follows btMatrix3x3. */

#include "math/vec.h"

pli_mat3 plii_mat3_add(pli_mat3 a, pli_mat3 b) {
    for (int i = 0; i < 3; ++i) {
        a.rows[i] = pli_vec3_add(a.rows[i], b.rows[i]);
    }
    return a;
}

pli_mat3 plii_mat3_diagonal(float x, float y, float z) {
    return (pli_mat3){{{x, 0, 0}, {0, y, 0}, {0, 0, z}}};
}

pli_mat3 plii_mat3_cross(pli_vec3 v) {
    return (pli_mat3){{{0, -v.z, v.y}, {v.z, 0, -v.x}, {-v.y, v.x, 0}}};
}

pli_mat3 plii_mat3_inverse(pli_mat3 m) {
    const pli_vec3 a = m.rows[0], b = m.rows[1], c = m.rows[2];
    const pli_vec3 cofactors = pli_vec3_cross(b, c);
    const float s = 1.0f / pli_vec3_dot(a, cofactors);
    return (pli_mat3){{
        {cofactors.x * s, (a.z * c.y - a.y * c.z) * s, (a.y * b.z - a.z * b.y) * s},
        {cofactors.y * s, (a.x * c.z - a.z * c.x) * s, (a.z * b.x - a.x * b.z) * s},
        {cofactors.z * s, (a.y * c.x - a.x * c.y) * s, (a.x * b.y - a.y * b.x) * s},
    }};
}
