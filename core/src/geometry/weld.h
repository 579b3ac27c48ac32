#pragma once

#include "base/context.h"
#include "pliant/math.h"

/* Points at equal positions, where -0 is 0, are one place: `places` [count] receives the place of each, numbered by
   first points. Returns how many places there are, or PLI_NULL_INDEX when out of memory. */
int plii_weld_points(pli_context* context, int count, const pli_vec3* points, int* places);
