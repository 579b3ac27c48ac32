#ifndef PLII_CONVEX_PENETRATION_H
#define PLII_CONVEX_PENETRATION_H

/* Penetration of overlapping convex cores by libccd, for plii_convex_options.penetration. Only programs that name one
   of these functions need libccd. Neither makes more support calls than the query allows. */

#include "geometry/convex_distance.h"

/* Minkowski portal refinement, aimed along the direction it found until that stops improving. No heap. */
bool plii_penetration_mpr(const plii_penetration_query* query, plii_penetration_result* result);

/* The expanding polytope algorithm: accurate; allocates with malloc inside libccd. */
bool plii_penetration_epa(const plii_penetration_query* query, plii_penetration_result* result);

#endif
