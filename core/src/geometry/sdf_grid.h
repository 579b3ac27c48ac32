#pragma once

/* Signed distances to a solid that triangles enclose, at the points of a grid. */

#include "geometry/triangle_soup.h"

/* Lengths are in cells: sample (i, j, k) lies at the point (i, j, k). */
typedef struct plii_sdf_grid {
    int counts[3];  /* samples along each axis */
    float* samples; /* [counts[0] * counts[1] * counts[2]], x first; negative inside */
} plii_sdf_grid;

/* Fills the samples, for which the caller has made room; hides triangles of the soup that lie inside of the solid.
   @return PLI_ERROR_OUT_OF_MEMORY, or PLI_ERROR_INVALID_MESH when nothing is inside; without a message */
pli_status plii_sdf_grid_run(plii_soup* soup, const plii_sdf_grid* sampling);
