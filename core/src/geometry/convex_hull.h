#pragma once

/* Convex hull of points, for hull meshes and hull shapes. */

#include "base/context.h"
#include "pliant/math.h"

typedef struct plii_convex_hull {
    int triangle_count;
    int (*triangles)[3]; /* [triangle_count] indices of points, counter-clockwise seen from outside */
} plii_convex_hull;

/* A closed, exactly convex triangulated surface. Points that lie closer to the result than `tolerance` (m, 0 or more;
   raised to a few roundings of the coordinates) may be left out, and points in a face or on an edge between others
   are. Expected time O(n log n). `points` must be finite. PLI_ERROR_INVALID_VALUE (less than 4 points),
   PLI_ERROR_INVALID_MESH (points in a plane), PLI_ERROR_OUT_OF_MEMORY. */
pli_status plii_convex_hull_create(pli_context* context, int point_count, const pli_vec3* points, float tolerance,
                                   const char* function, plii_convex_hull* hull);
/* The points that are corners: `corners` [point_count] gets the number of each, or PLI_NULL_INDEX; how many. */
int plii_convex_hull_corners(const plii_convex_hull* hull, int point_count, int* corners);
void plii_convex_hull_destroy(pli_context* context, plii_convex_hull* hull);
