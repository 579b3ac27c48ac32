/* Nearest points on triangles. plii_closest_point_on_triangle: Ericson, Real-Time Collision Detection, 5.1.5. */

#include "geometry/closest_point.h"

#include "math/dvec3.h"

plii_triangle_size plii_measure_triangle(pli_vec3 a, pli_vec3 b, pli_vec3 c) {
    const pli_vec3 ab = pli_vec3_sub(b, a), ac = pli_vec3_sub(c, a), bc = pli_vec3_sub(c, b);
    const pli_vec3 cross = pli_vec3_cross(ab, ac);
    const float area = pli_vec3_length(cross);
    const float longest =
        plii_max(pli_vec3_length_squared(ab), plii_max(pli_vec3_length_squared(ac), pli_vec3_length_squared(bc)));
    return (plii_triangle_size){.doubled_area = area,
                                .longest_squared = longest,
                                .normal = pli_vec3_make(cross.x / area, cross.y / area, cross.z / area),
                                .is_usable = area > PLII_TRIANGLE_MIN_SHAPE * longest && area > FLT_MIN};
}

static pli_vec3 closest_point_at(plii_dvec3 start, plii_dvec3 edge, double t) {
    return plii_dvec3_to_float(plii_dvec3_add_scaled(start, edge, t));
}

/* In double: of a triangle of kilometres, products of floats would lose a point a metre above it. */
pli_vec3 plii_closest_point_on_triangle(pli_vec3 point, pli_vec3 vertex_a, pli_vec3 vertex_b, pli_vec3 vertex_c,
                                        plii_closest_feature* closest) {
    const plii_dvec3 p = plii_dvec3_from(point), a = plii_dvec3_from(vertex_a), b = plii_dvec3_from(vertex_b),
                     c = plii_dvec3_from(vertex_c);
    const plii_dvec3 ab = plii_dvec3_sub(b, a), ac = plii_dvec3_sub(c, a);
    const plii_dvec3 ap = plii_dvec3_sub(p, a), bp = plii_dvec3_sub(p, b), cp = plii_dvec3_sub(p, c);
    const double d1 = plii_dvec3_dot(ab, ap), d2 = plii_dvec3_dot(ac, ap);
    const double d3 = plii_dvec3_dot(ab, bp), d4 = plii_dvec3_dot(ac, bp);
    const double d5 = plii_dvec3_dot(ab, cp), d6 = plii_dvec3_dot(ac, cp);
    if (d1 <= 0.0 && d2 <= 0.0) {
        *closest = (plii_closest_feature){PLII_TRIANGLE_VERTEX_0, {1.0f, 0.0f, 0.0f}};
        return vertex_a;
    }
    if (d3 >= 0.0 && d4 <= d3) {
        *closest = (plii_closest_feature){PLII_TRIANGLE_VERTEX_1, {0.0f, 1.0f, 0.0f}};
        return vertex_b;
    }
    if (d6 >= 0.0 && d5 <= d6) {
        *closest = (plii_closest_feature){PLII_TRIANGLE_VERTEX_2, {0.0f, 0.0f, 1.0f}};
        return vertex_c;
    }
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3) { /* else a is b: the others are one edge */
        const double t = d1 / (d1 - d3);
        *closest = (plii_closest_feature){PLII_TRIANGLE_EDGE_01, {(float)(1.0 - t), (float)t, 0.0f}};
        return closest_point_at(a, ab, t);
    }
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        const double t = d2 / (d2 - d6);
        *closest = (plii_closest_feature){PLII_TRIANGLE_EDGE_20, {(float)(1.0 - t), 0.0f, (float)t}};
        return closest_point_at(a, ac, t);
    }
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0) {
        const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        *closest = (plii_closest_feature){PLII_TRIANGLE_EDGE_12, {0.0f, (float)(1.0 - t), (float)t}};
        return closest_point_at(b, plii_dvec3_sub(c, b), t);
    }
    const double scale = 1.0 / (va + vb + vc), v = vb * scale, w = vc * scale;
    *closest = (plii_closest_feature){PLII_TRIANGLE_FACE, {(float)(va * scale), (float)v, (float)w}};
    return closest_point_at(plii_dvec3_add_scaled(a, ab, v), ac, w);
}

static void closest_point_project_on_edge(pli_vec3 a, pli_vec3 b, pli_vec3* point, float* distance_squared) {
    const pli_vec3 d = pli_vec3_sub(b, a);
    const float edge_squared = pli_vec3_length_squared(d);
    if (!(edge_squared > PLII_EPSILON)) { return; }
    const float t = plii_clamp(-pli_vec3_dot(a, d) / edge_squared, 0.0f, 1.0f);
    const pli_vec3 p = pli_vec3_add(a, pli_vec3_scale(d, t));
    const float squared = pli_vec3_length_squared(p);
    if (squared < *distance_squared) {
        *point = p;
        *distance_squared = squared;
    }
}

bool plii_project_origin_on_triangle(pli_vec3 a, pli_vec3 b, pli_vec3 c, pli_vec3* point, float* distance_squared) {
    const pli_vec3 q = pli_vec3_cross(pli_vec3_sub(b, a), pli_vec3_sub(c, a));
    const float area_squared = pli_vec3_length_squared(q);
    if (!(area_squared > PLII_EPSILON)) { return false; }
    const pli_vec3 normal = plii_vec3_divide(q, sqrtf(area_squared));
    const float k = pli_vec3_dot(a, normal);
    const pli_vec3 p = pli_vec3_scale(normal, k);
    const pli_vec3 ap = pli_vec3_sub(a, p), bp = pli_vec3_sub(b, p), cp = pli_vec3_sub(c, p);
    if (pli_vec3_dot(pli_vec3_cross(ap, bp), q) > 0.0f && pli_vec3_dot(pli_vec3_cross(bp, cp), q) > 0.0f &&
        pli_vec3_dot(pli_vec3_cross(cp, ap), q) > 0.0f) {
        *point = p;
        *distance_squared = k * k;
        return true;
    }
    float nearest = FLT_MAX;
    closest_point_project_on_edge(a, b, point, &nearest);
    closest_point_project_on_edge(b, c, point, &nearest);
    closest_point_project_on_edge(c, a, point, &nearest);
    if (!(nearest < FLT_MAX)) { return false; }
    *distance_squared = nearest;
    return true;
}

pli_vec3 plii_barycentric_by_areas(pli_vec3 a, pli_vec3 b, pli_vec3 c, pli_vec3 p) {
    const pli_vec3 ap = pli_vec3_sub(a, p), bp = pli_vec3_sub(b, p), cp = pli_vec3_sub(c, p);
    const float area_ab = pli_vec3_length(pli_vec3_cross(ap, bp));
    const float area_bc = pli_vec3_length(pli_vec3_cross(bp, cp));
    const float area_ca = pli_vec3_length(pli_vec3_cross(cp, ap));
    const float inverse_sum = 1.0f / (area_ab + area_bc + area_ca);
    return pli_vec3_make(area_bc * inverse_sum, area_ca * inverse_sum, area_ab * inverse_sum);
}
