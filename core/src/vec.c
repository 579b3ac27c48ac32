/* Matrix helpers; the order of operations follows btMatrix3x3. */

#include "vec.h"

/* The range of row . p over the box; an axis that the row does not see must not bring in its infinity. */
static void bounds_project(pli_bounds local, pli_vec3 row, float offset, float* low, float* high) {
    const float weights[3] = {row.x, row.y, row.z};
    const float mins[3] = {local.min.x, local.min.y, local.min.z};
    const float maxs[3] = {local.max.x, local.max.y, local.max.z};
    *low = *high = offset;
    for (int i = 0; i < 3; ++i) {
        if (weights[i] == 0.0f) { continue; }
        const bool is_positive = weights[i] > 0.0f;
        *low += weights[i] * (is_positive ? mins[i] : maxs[i]);
        *high += weights[i] * (is_positive ? maxs[i] : mins[i]);
    }
    if (isnan(*low)) { *low = -INFINITY; }
    if (isnan(*high)) { *high = INFINITY; }
}

pli_bounds plii_bounds_transform(pli_bounds local, pli_transform pose) {
    pli_bounds world;
    bounds_project(local, pose.rotation.rows[0], pose.origin.x, &world.min.x, &world.max.x);
    bounds_project(local, pose.rotation.rows[1], pose.origin.y, &world.min.y, &world.max.y);
    bounds_project(local, pose.rotation.rows[2], pose.origin.z, &world.min.z, &world.max.z);
    return world;
}

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

static pli_vec3 mat3_cofactors(pli_mat3 m) {
    return pli_vec3_cross(m.rows[1], m.rows[2]);
}

float plii_mat3_determinant(pli_mat3 m) {
    return pli_vec3_dot(m.rows[0], mat3_cofactors(m));
}

pli_mat3 plii_mat3_inverse(pli_mat3 m) {
    const pli_vec3 a = m.rows[0], b = m.rows[1], c = m.rows[2];
    const pli_vec3 cofactors = mat3_cofactors(m);
    const float s = 1.0f / pli_vec3_dot(a, cofactors);
    return (pli_mat3){{
        {cofactors.x * s, (a.z * c.y - a.y * c.z) * s, (a.y * b.z - a.z * b.y) * s},
        {cofactors.y * s, (a.x * c.z - a.z * c.x) * s, (a.z * b.x - a.x * b.z) * s},
        {cofactors.z * s, (a.y * c.x - a.x * c.y) * s, (a.x * b.y - a.y * b.x) * s},
    }};
}
