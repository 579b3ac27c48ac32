/* Boxes along the axes. */

#include "math/simd_float4.h"

#include "math/bounds.h"

pli_bounds plii_bounds_transform(pli_bounds local, pli_transform pose) {
    const plii_lanes_mat3 rotation = plii_lanes_from_mat3(&pose.rotation);
    const plii_lanes_bounds bounds = plii_lanes_bounds_transform(&local, &rotation, plii_lanes_from_vec3(&pose.origin));
    pli_bounds world;
    plii_lanes_to_vec3(&world.min, bounds.low);
    plii_lanes_to_vec3(&world.max, bounds.high);
    return world;
}
