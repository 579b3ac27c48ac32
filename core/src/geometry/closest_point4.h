#pragma once

/* Four triangles at a time, from one point: enough to tell which of many are worth plii_closest_point_on_triangle. */

#include "geometry/closest_point.h"
#include "math/simd_float4.h"

/* Corners relative to the point. */
typedef struct plii_triangle4 {
    plii_vec3x4 a, b, c;
} plii_triangle4;

/* Bits: one per triangle. */
typedef struct plii_distance4 {
    plii_float4 squared; /* to the nearest point, in float: see plii_closest_point_on_triangle; m^2 */
    plii_float4 height;  /* of the point over the plane, along the normal; m */
    plii_float4 longest_squared;
    int usable; /* plii_triangle_size.is_usable */
    int inside; /* the nearest point lies inside of the triangle */
} plii_distance4;

/* Of the corners of four triangles as they are seen from `point`. */
PLII_SIMD_INLINE plii_vec3x4 plii_triangle4_corner(const pli_vec4* positions, int i, int j, int k, int l,
                                                   plii_vec3x4 point) {
    return plii_vec3x4_sub(plii_vec3x4_of(plii_float4_from(&positions[i]), plii_float4_from(&positions[j]),
                                          plii_float4_from(&positions[k]), plii_float4_from(&positions[l])),
                           point);
}

PLII_SIMD_INLINE plii_triangle4 plii_triangle4_seen(const pli_vec4* positions, const int* const faces[4],
                                                    pli_vec3 point) {
    const plii_vec3x4 from = plii_vec3x4_all(point);
    const int *f = faces[0], *g = faces[1], *h = faces[2], *i = faces[3];
    return (plii_triangle4){plii_triangle4_corner(positions, f[0], g[0], h[0], i[0], from),
                            plii_triangle4_corner(positions, f[1], g[1], h[1], i[1], from),
                            plii_triangle4_corner(positions, f[2], g[2], h[2], i[2], from)};
}

/* Six times the volume of triangle and point, positive where the point is on the side of the normal. */
PLII_SIMD_INLINE plii_float4 plii_triangle4_volume(const plii_triangle4* t) {
    const plii_vec3x4 ab = plii_vec3x4_sub(t->b, t->a), ac = plii_vec3x4_sub(t->c, t->a);
    return -plii_vec3x4_dot(t->a, plii_vec3x4_cross(ab, ac));
}

/* From the point to an edge. */
PLII_SIMD_INLINE plii_float4 plii_triangle4_edge_squared(plii_vec3x4 start, plii_vec3x4 edge,
                                                         plii_float4 edge_squared) {
    const plii_float4 t = -plii_vec3x4_dot(start, edge) / edge_squared;
    const plii_float4 share = plii_lanes_min(plii_lanes_max(t, plii_float4_all(0.0f)), plii_float4_all(1.0f));
    const plii_vec3x4 nearest = plii_vec3x4_add(start, plii_vec3x4_scale(edge, share));
    return plii_vec3x4_dot(nearest, nearest);
}

/* False: the point is farther from the planes of all of them. */
PLII_SIMD_INLINE bool plii_triangle4_may_be_near(const plii_triangle4* triangle, float distance) {
    const plii_vec3x4 a = triangle->a;
    const plii_vec3x4 cross = plii_vec3x4_cross(plii_vec3x4_sub(triangle->b, a), plii_vec3x4_sub(triangle->c, a));
    const plii_float4 volume = plii_vec3x4_dot(a, cross), limit = plii_vec3x4_dot(cross, cross) * (distance * distance);
    return plii_lanes_bits(volume * volume > 1.001f * limit) != 15;
}

PLII_SIMD_INLINE plii_distance4 plii_triangle4_distance(const plii_triangle4* triangle) {
    const plii_vec3x4 a = triangle->a, b = triangle->b, c = triangle->c;
    const plii_vec3x4 ab = plii_vec3x4_sub(b, a), ac = plii_vec3x4_sub(c, a), bc = plii_vec3x4_sub(c, b);
    const plii_float4 ab_squared = plii_vec3x4_dot(ab, ab), ac_squared = plii_vec3x4_dot(ac, ac);
    const plii_float4 bc_squared = plii_vec3x4_dot(bc, bc);
    const plii_vec3x4 cross = plii_vec3x4_cross(ab, ac);
    const plii_float4 area = plii_float4_sqrt(plii_vec3x4_dot(cross, cross));
    const plii_float4 longest = plii_lanes_max(ab_squared, plii_lanes_max(ac_squared, bc_squared));
    const plii_float4 height = -plii_vec3x4_dot(a, cross) / area;
    const plii_mask4 inside = (plii_vec3x4_dot(plii_vec3x4_cross(a, b), cross) > 0.0f) &
                              (plii_vec3x4_dot(plii_vec3x4_cross(b, c), cross) > 0.0f) &
                              (plii_vec3x4_dot(plii_vec3x4_cross(c, a), cross) > 0.0f);
    const plii_float4 edges = plii_lanes_min(
        plii_triangle4_edge_squared(a, ab, ab_squared),
        plii_lanes_min(plii_triangle4_edge_squared(a, ac, ac_squared), plii_triangle4_edge_squared(b, bc, bc_squared)));
    return (plii_distance4){
        .squared = plii_lanes_select(inside, height * height, edges),
        .height = height,
        .longest_squared = longest,
        .usable = plii_lanes_bits((area > plii_float4_all(PLII_TRIANGLE_MIN_SHAPE) * longest) & (area > FLT_MIN)),
        .inside = plii_lanes_bits(inside)};
}
