#ifndef DEMOS_RENDER_LIGHT_H
#define DEMOS_RENDER_LIGHT_H

// What pictures are lit by, and the grid on the ground.

#include "camera.h"

namespace render {

inline constexpr pli_vec3 horizon_color{0.80f, 0.84f, 0.88f}; // linear
inline constexpr pli_vec3 zenith_color{0.20f, 0.36f, 0.62f};

// The key light, from behind the camera's left shoulder, and the box of the world that its shadow map covers.
struct Light {
    pli_vec3 direction; // towards the light
    Matrix4 projection;
    float texel; // m
};

Light make_light(const Camera& camera, const View& view, int shadow_size);

// 1, 2 or 5 times a power of ten, near `wanted`.
float round_spacing(float wanted);

} // namespace render
#endif
