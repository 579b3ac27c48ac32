#pragma once

#include "math/vec.h"

/* Matrices are worked on in blocks of this many. */
#define PLII_ROTATION_FOLLOW_LANES 4

/* plii_rotation_fit for starts that are near the result, such as that of the last step, in float: right to 3e-6 rad.
   What turns out not to be near, or has no one nearest rotation, is left to plii_rotation_fit. A result depends only on
   its own matrix and start. */
void plii_rotation_fit_warm(int count, const pli_mat3* matrices, pli_quat* quaternions, pli_mat3* rotations);
