#pragma once

/* Where the shapes of a rigid body are, for contacts of nodes. */

#include "body/rigid_impl.h"
#include "math/simd_float4.h"

/* A shape of a rigid body at its present pose. */
typedef struct plii_shape_place {
    pli_transform pose;
    plii_float4 low, high;      /* bounds */
    float radius, least_extent; /* m, of its own bounds: half the diagonal, half the shortest side */
} plii_shape_place;
