#include "light.h"

#include <algorithm>
#include <cmath>

namespace render {

Light make_light(const Camera& camera, const View& view, int shadow_size) {
    Light light{};
    const pli_vec3 back = normalized(pli_vec3_make(-camera.forward.x, 0, -camera.forward.z));
    light.direction = normalized(pli_vec3_make(0, 1.25f, 0) + back * 0.55f - camera.right * 0.75f);
    const pli_vec3 forward = light.direction * -1.0f;
    const pli_vec3 right = normalized(pli_vec3_cross(forward, pli_vec3_make(0, 1, 0)));
    const pli_vec3 up = pli_vec3_cross(right, forward);
    const pli_vec3 center = view.focus.center();
    const float reach = 0.75f * std::max(view.focus.diagonal(), 0.1f);
    const float depth = 6.0f * reach;
    const pli_vec3 eye = center + light.direction * depth;
    light.projection =
        multiply(orthographic(-reach, reach, -reach, reach, 0.0f, 2.0f * depth), look_along(eye, right, up, forward));
    light.texel = 2.0f * reach / static_cast<float>(shadow_size);
    return light;
}

float round_spacing(float wanted) {
    const float power = std::pow(10.0f, std::floor(std::log10(wanted)));
    const float ratio = wanted / power;
    return power * (ratio < 1.5f ? 1.0f : ratio < 3.5f ? 2.0f : ratio < 7.5f ? 5.0f : 10.0f);
}

} // namespace render
