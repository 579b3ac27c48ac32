#pragma once

/* Penetration of overlapping convex cores by libccd, for plii_convex_options.penetration. Only programs that name the
   function need libccd. */

#include "geometry/convex_distance.h"

/* The expanding polytope algorithm: accurate; allocates with malloc inside libccd. Makes no more support calls than the
   query allows. */
bool plii_penetration_epa(const plii_penetration_query* query, plii_penetration_result* result);
