#pragma once

/* Points between nodes, by their barycentric weights. */

#include "math/vec.h"

/* Inverse of the mass that some nodes show at a point, 1/kg, if pinned ones were as light as the lightest of the
   others. Where the point moves by what this tells, no node goes much farther than the point would; without it, a node
   that bears a thousandth of it beside pinned ones goes a thousand times as far. `nodes`: w = inverse mass. */
static inline float plii_point_weight_unpinned(const pli_vec4* nodes, int count, const int* indices,
                                               const float* weights) {
    float lightest = 0.0f, sum = 0.0f;
    for (int k = 0; k < count; ++k) {
        lightest = plii_max(lightest, nodes[indices[k]].w);
    }
    for (int k = 0; k < count; ++k) {
        const float inverse_mass = nodes[indices[k]].w;
        sum += weights[k] * weights[k] * (inverse_mass > 0.0f ? inverse_mass : lightest);
    }
    return sum;
}
