#pragma once

#include "pliant/math.h"

/* The sign (+1, 0, -1) of ((b - a) x (c - a)) . (p - a) without rounding: +1 when p lies on the side from which
   a, b, c run counter-clockwise, 0 when all four lie in a plane. Coordinates must be finite. */
int plii_orient3d(pli_vec3 a, pli_vec3 b, pli_vec3 c, pli_vec3 p);
