#pragma once

/* Triangles without connections, for questions that do not need any, with a tree over them. */

#include "geometry/bvh.h"

typedef struct plii_soup_triangle {
    pli_vec3 corners[3];
    bool is_turned; /* while they are sorted: an odd number of swaps has brought its corners into ascending order */
    bool is_hidden; /* not part of the surface that distances are measured to */
} plii_soup_triangle;

typedef struct plii_soup {
    pli_context* context;
    plii_soup_triangle* triangles;
    int count, capacity;
    plii_bvh tree;
} plii_soup;

/* The soup starts as {.context = ...}. Corners become (point - origin) * scale. Triangles without an area are left out;
   of those with the same corners one stays, turned as most of them are, and none when as many are turned either way.
   False when out of memory; the soup is to be freed in any case. */
bool plii_soup_build(plii_soup* soup, const pli_vec3* points, int triangle_count, const int* triangles, pli_vec3 origin,
                     float scale);
void plii_soup_free(plii_soup* soup);

/* The triangle nearest to a point among those that are not hidden, and its distance. With a `guess`, which may be
   PLI_NULL_INDEX, the search is faster the nearer the guess is. */
int plii_soup_nearest(const plii_soup* soup, pli_vec3 point, int guess, float* distance);

/* Signed distances, in cells, to the solid that the triangles enclose, at the points of a grid: sample (i, j, k) lies
   at the point (i, j, k). Fills `samples` [counts[0] * counts[1] * counts[2]], x first, negative inside; hides
   triangles that lie inside of the solid.
   @return PLI_ERROR_OUT_OF_MEMORY, or PLI_ERROR_INVALID_MESH when nothing is inside; without a message */
pli_status plii_soup_sample(plii_soup* soup, const int counts[3], float* samples);

/* Points at equal positions, where -0 is 0, are one place: `places` [count] receives the place of each, numbered by
   first points. Returns how many places there are, or PLI_NULL_INDEX when out of memory. */
int plii_weld_points(pli_context* context, int count, const pli_vec3* points, int* places);
