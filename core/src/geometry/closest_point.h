#pragma once

#include "math/vec.h"

/* Which part of a triangle a point is nearest to. */
typedef enum plii_triangle_feature {
    PLII_TRIANGLE_VERTEX_0,
    PLII_TRIANGLE_VERTEX_1,
    PLII_TRIANGLE_VERTEX_2,
    PLII_TRIANGLE_EDGE_01,
    PLII_TRIANGLE_EDGE_12,
    PLII_TRIANGLE_EDGE_20,
    PLII_TRIANGLE_FACE
} plii_triangle_feature;

#define PLII_TRIANGLE_MIN_SHAPE 1e-6f /* of the longest edge squared: a doubled area below counts as none */

/* How large a triangle is. */
typedef struct plii_triangle_size {
    float doubled_area, longest_squared; /* m^2; of the longest edge */
    pli_vec3 normal;                     /* unit, where there is an area */
    bool is_usable;                      /* not too thin for a normal */
} plii_triangle_size;

plii_triangle_size plii_measure_triangle(pli_vec3 a, pli_vec3 b, pli_vec3 c);

/* A point of a triangle. */
typedef struct plii_closest_feature {
    plii_triangle_feature feature;
    pli_vec3 weights; /* barycentric */
} plii_closest_feature;

/* The point of triangle abc nearest to p; of one without an area, which may be a segment or a point, too. */
pli_vec3 plii_closest_point_on_triangle(pli_vec3 p, pli_vec3 a, pli_vec3 b, pli_vec3 c, plii_closest_feature* closest);

/* The point of triangle abc nearest to the origin and its squared distance, in btSoftBody's operations (ProjectOrigin).
   False, and nothing written, for a triangle that is degenerate: |cross product|^2 or squared edges not above
   FLT_EPSILON, whatever the size of the triangle. */
bool plii_project_origin_on_triangle(pli_vec3 a, pli_vec3 b, pli_vec3 c, pli_vec3* point, float* distance_squared);

/* Barycentric weights by areas, in btSoftBody's operations (BaryCoord). */
pli_vec3 plii_barycentric_by_areas(pli_vec3 a, pli_vec3 b, pli_vec3 c, pli_vec3 p);
