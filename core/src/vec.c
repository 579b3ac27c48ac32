/* Matrix helpers; the order of operations follows btMatrix3x3. */

#include "lanes.h"

#include "vec.h"

/* Rows times the range of one axis: 0 where they do not see the axis, whose infinity must not come in. */
static void bounds_add_axis(plii_float4 weights, float min, float max, plii_float4* low, plii_float4* high) {
    const plii_float4 zero = plii_float4_all(0.0f);
    const plii_float4 at_min = plii_float4_mul(weights, plii_float4_all(min));
    const plii_float4 at_max = plii_float4_mul(weights, plii_float4_all(max));
    const plii_mask4 is_blind = plii_lanes_both(plii_lanes_at_most(weights, zero), plii_lanes_at_most(zero, weights));
    const plii_mask4 is_positive = plii_lanes_less(zero, weights);
    const plii_float4 least = plii_lanes_select(is_positive, at_min, at_max);
    const plii_float4 most = plii_lanes_select(is_positive, at_max, at_min);
    *low = plii_float4_add(*low, plii_lanes_select(is_blind, zero, least));
    *high = plii_float4_add(*high, plii_lanes_select(is_blind, zero, most));
}

pli_bounds plii_bounds_transform(pli_bounds local, pli_transform pose) {
    const pli_vec3* rows = pose.rotation.rows;
    plii_float4 columns[4] = {plii_lanes_from_vec3(&rows[0]), plii_lanes_from_vec3(&rows[1]),
                              plii_lanes_from_vec3(&rows[2]), plii_float4_all(0.0f)};
    plii_float4_turn(columns);
    plii_float4 low = plii_lanes_from_vec3(&pose.origin), high = low;
    bounds_add_axis(columns[0], local.min.x, local.max.x, &low, &high);
    bounds_add_axis(columns[1], local.min.y, local.max.y, &low, &high);
    bounds_add_axis(columns[2], local.min.z, local.max.z, &low, &high);
    /* Where infinities met there is no number. */
    low = plii_lanes_select(plii_lanes_at_most(low, low), low, plii_float4_all(-INFINITY));
    high = plii_lanes_select(plii_lanes_at_most(high, high), high, plii_float4_all(INFINITY));
    pli_bounds world;
    plii_lanes_to_vec3(&world.min, low);
    plii_lanes_to_vec3(&world.max, high);
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
