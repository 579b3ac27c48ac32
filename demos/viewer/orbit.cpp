#include "orbit.h"

#include <algorithm>
#include <cmath>

namespace viewer {

using render::operator+;
using render::operator-;
using render::operator*;

static constexpr float degrees_per_radian = 57.29577951f;
static constexpr float degrees_per_pixel = 0.35f;
static constexpr float least_height = 0.05f; // m above the ground, more than the near plane cuts off

void Orbit::look_from(const render::Camera& camera) {
    distance_ = camera.distance;
    target_ = camera.eye + camera.forward * distance_;
    yaw_ = degrees_per_radian * std::atan2(camera.forward.x, camera.forward.z);
    pitch_ = degrees_per_radian * std::asin(std::clamp(camera.forward.y, -1.0f, 1.0f));
    rise();
}

void Orbit::rise() {
    const float highest = (target_.y - ground_ - least_height) / distance_; // sine of the line of sight's pitch
    if (highest < 1.0f) { pitch_ = std::min(pitch_, degrees_per_radian * std::asin(std::max(highest, -1.0f))); }
}

void Orbit::shift(pli_vec3 way) {
    target_ = pli_vec3_add(target_, way);
    rise();
}

void Orbit::turn(float right, float down) {
    yaw_ = std::fmod(yaw_ - degrees_per_pixel * right, 360.0f);
    pitch_ = std::clamp(pitch_ - degrees_per_pixel * down, -89.0f, 89.0f);
    rise();
}

void Orbit::pan(float right, float down, int height) {
    const render::Camera now = camera(1.0f);
    const float pixel = now.pixel_size(height);
    target_ = target_ - now.right * (right * pixel) + now.up * (down * pixel);
    target_.y = std::max(target_.y, ground_);
    rise();
}

void Orbit::zoom(float steps) {
    distance_ = std::clamp(distance_ * std::pow(0.9f, steps), 0.01f, 10000.0f);
    rise();
}

render::Camera Orbit::camera(float aspect) const {
    render::Camera camera = render::turned_camera(yaw_, pitch_, aspect);
    camera.distance = distance_;
    camera.eye = target_ - camera.forward * distance_;
    return camera;
}

Ray ray_through(const render::Camera& camera, float across, float up) {
    const pli_vec3 direction =
        camera.forward + camera.right * (across * camera.tangent_x) + camera.up * (up * camera.tangent_y);
    return {camera.eye, camera.eye + direction * (100.0f * camera.distance)};
}

bool place_of(const render::Camera& camera, pli_vec3 point, float& across, float& up) {
    const pli_vec3 offset = point - camera.eye;
    const float depth = pli_vec3_dot(offset, camera.forward);
    if (!(depth > 0.0f)) { return false; }
    across = pli_vec3_dot(offset, camera.right) / (depth * camera.tangent_x);
    up = pli_vec3_dot(offset, camera.up) / (depth * camera.tangent_y);
    return true;
}

} // namespace viewer
