#ifndef DEMOS_RENDER_CAMERA_H
#define DEMOS_RENDER_CAMERA_H

// Where a picture is taken from.

#include "bodies.h"

namespace render {

struct Camera {
    pli_vec3 eye, right, up, forward; // unit vectors
    float tangent_x, tangent_y;       // of half the angle of view
    float distance;                   // from the eye to the middle of what is shown

    Matrix4 view_projection(float near, float far) const;
    // Size of a pixel at the middle of what is shown, m.
    float pixel_size(int height) const { return 2.0f * distance * tangent_y / static_cast<float>(height); }
};

// What a camera has to show: soft bodies, rigid bodies near them, and the ground below when it is near.
struct View {
    Box soft;                          // of the soft bodies of all snapshots
    std::vector<pli_vec3> soft_points; // their nodes
    Box focus;                         // of `points`
    std::vector<pli_vec3> points;      // all that is to be seen
};

View make_view(const std::vector<Extent>& extents);

// Looks along the direction of the angles; the eye is at the origin and the distance is not set yet.
Camera turned_camera(float yaw_degrees, float pitch_degrees, float aspect);

// The scene's own camera when it has one and sees all soft bodies; otherwise one from the same or a usual direction
// that shows all points of the view.
Camera choose_camera(const demos::Description& description, const View& view, float aspect);

} // namespace render
#endif
