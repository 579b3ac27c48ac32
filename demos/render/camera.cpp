#include "camera.h"

#include <algorithm>
#include <cmath>

namespace render {

static constexpr float radians_per_degree = 0.01745329252f;
static constexpr float default_yaw = 215.0f, default_pitch = -20.0f; // degrees
static constexpr float tangent_vertical = 0.364f;                    // of 20 degrees
static constexpr float frame_top = 0.76f; // share of the upper half that is below the caption

Matrix4 Camera::view_projection(float near, float far) const {
    return multiply(perspective(tangent_x, tangent_y, near, far), look_along(eye, right, up, forward));
}

View make_view(const std::vector<Extent>& extents) {
    View view;
    for (const Extent& extent : extents) {
        view.soft.add(extent.soft);
        view.soft_points.insert(view.soft_points.end(), extent.soft_points.begin(), extent.soft_points.end());
    }
    view.points = view.soft_points;
    const float size = std::max(view.soft.diagonal(), 0.1f);
    Box focus = view.soft;
    for (const Extent& extent : extents) {
        for (const Extent::Rigid& rigid : extent.rigids) {
            // What moves may be larger and farther away: it is probably about to hit.
            const float rigid_size = rigid.bounds.diagonal();
            const float reach = rigid.is_static ? 0.25f * size : 0.6f * std::max(size, rigid_size);
            const bool is_far = view.soft.gap(rigid.bounds) > reach;
            const bool is_large = rigid_size > (rigid.is_static ? 2.5f : 12.0f) * size;
            if (is_ground(rigid, view.soft) || is_far || is_large) { continue; }
            focus.add(rigid.bounds);
            for (int i = 0; i < 8; ++i) {
                view.points.push_back(rigid.bounds.corner(i));
            }
        }
    }
    // The ground under the bodies, where their shadows fall, belongs into the picture when it is not far below.
    for (const Extent& extent : extents) {
        for (const Extent::Rigid& rigid : extent.rigids) {
            const float drop = focus.min.y - rigid.bounds.max.y;
            if (!is_ground(rigid, view.soft) || drop < 0.0f || drop > 0.8f * size) { continue; }
            const float inset = 0.15f;
            for (int i = 0; i < 4; ++i) {
                pli_vec3 corner = pli_vec3_lerp(focus.corner((i & 1) | (i & 2) << 1), focus.center(), inset);
                corner.y = rigid.bounds.max.y;
                view.points.push_back(corner);
            }
        }
    }
    for (const pli_vec3 point : view.points) {
        view.focus.add(point);
    }
    return view;
}

Camera turned_camera(float yaw_degrees, float pitch_degrees, float aspect) {
    const float yaw = yaw_degrees * radians_per_degree, pitch = pitch_degrees * radians_per_degree;
    Camera camera{};
    camera.forward = pli_vec3_make(std::sin(yaw) * std::cos(pitch), std::sin(pitch), std::cos(yaw) * std::cos(pitch));
    camera.right = pli_vec3_make(-std::cos(yaw), 0, std::sin(yaw));
    camera.up = pli_vec3_cross(camera.right, camera.forward);
    camera.tangent_y = tangent_vertical;
    camera.tangent_x = tangent_vertical * aspect;
    return camera;
}

// One pair of opposite sides of the frame, `below` and `above` the middle (tangents of the angles between them and the
// line of sight). A camera at `back` behind the origin and `shift` along the axis sees a point with offset a along the
// axis and depth d when -below (d + back) <= a - shift <= above (d + back).
struct FrameFit {
    float below, above;
    float highest = -1e30f, lowest = 1e30f;

    void add(float offset, float depth) {
        highest = std::max(highest, offset - above * depth);
        lowest = std::min(lowest, offset + below * depth);
    }
    float least_back() const { return (highest - lowest) / (above + below); }
    // In the middle of what is possible.
    float shift(float back) const { return 0.5f * (highest - above * back + lowest + below * back); }
};

static Camera fitted_camera(const View& view, float yaw_degrees, float pitch_degrees, float aspect) {
    Camera camera = turned_camera(yaw_degrees, pitch_degrees, aspect);
    FrameFit across{0.84f * camera.tangent_x, 0.84f * camera.tangent_x};
    FrameFit along{0.84f * camera.tangent_y, 0.9f * frame_top * camera.tangent_y};
    for (const pli_vec3 point : view.points) {
        const float depth = pli_vec3_dot(point, camera.forward);
        across.add(pli_vec3_dot(point, camera.right), depth);
        along.add(pli_vec3_dot(point, camera.up), depth);
    }
    const float back = std::max(across.least_back(), along.least_back());
    camera.eye = camera.right * across.shift(back) + camera.up * along.shift(back) - camera.forward * back;
    camera.distance = std::max(pli_vec3_dot(view.focus.center() - camera.eye, camera.forward), 0.1f);
    return camera;
}

// Whether all points are in the frame, and not behind the caption at its top.
static bool sees_all(const Camera& camera, const std::vector<pli_vec3>& points) {
    return std::all_of(points.begin(), points.end(), [&](pli_vec3 point) {
        const pli_vec3 offset = point - camera.eye;
        const float depth = pli_vec3_dot(offset, camera.forward);
        const float across = pli_vec3_dot(offset, camera.right), along = pli_vec3_dot(offset, camera.up);
        return std::fabs(across) < 0.95f * camera.tangent_x * depth && along < frame_top * camera.tangent_y * depth &&
               along > -0.95f * camera.tangent_y * depth;
    });
}

Camera choose_camera(const demos::Description& description, const View& view, float aspect) {
    if (!description.has_camera) { return fitted_camera(view, default_yaw, default_pitch, aspect); }
    const scene_camera& wanted = description.camera;
    Camera camera = turned_camera(wanted.yaw_degrees, wanted.pitch_degrees, aspect);
    camera.eye = wanted.target - camera.forward * wanted.distance;
    camera.distance = wanted.distance;
    return sees_all(camera, view.soft_points) ? camera
                                              : fitted_camera(view, wanted.yaw_degrees, wanted.pitch_degrees, aspect);
}

} // namespace render
