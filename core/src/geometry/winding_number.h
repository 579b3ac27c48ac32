#pragma once

/* How often a surface goes round a point: 1 inside of a closed surface that faces outward and 0 outside; with holes
   or doubled parts something in between that changes gradually. */

#include "geometry/triangle_soup.h"

/* What many triangles look like from afar. */
typedef struct plii_winding_cluster {
    pli_vec3 centre;     /* weighted by area */
    float reach_squared; /* farther from the centre than this the cluster counts as one */
    pli_vec3 area_normal;
    float area;
} plii_winding_cluster;

typedef struct plii_winding {
    const plii_soup* soup;
    plii_winding_cluster* clusters; /* of the items of the soup's tree, of four of these each, and so on up to one */
    int level_count, begin[PLII_BVH_MAX_LEVELS + 1]; /* of each level in `clusters` */
} plii_winding;

/* False when out of memory. The soup must outlive it. */
bool plii_winding_build(plii_winding* winding, const plii_soup* soup);
void plii_winding_free(plii_winding* winding);

/* At a point, in logarithmic time. */
float plii_winding_at(const plii_winding* winding, pli_vec3 point);
