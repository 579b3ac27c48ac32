#ifndef DEMOS_VIEWER_ORBIT_H
#define DEMOS_VIEWER_ORBIT_H

// The camera that the mouse turns around a point, and the rays that go out from it.

#include "render/camera.h"

namespace viewer {

struct Ray {
    pli_vec3 from, to;
};

class Orbit {
public:
    // The camera stays above this height, m: it turns no further down than there.
    void stay_above(float ground) { ground_ = ground; }
    // From where a picture would be taken.
    void look_from(const render::Camera& camera);

    // By pixels of the mouse, in a viewport of that height.
    void turn(float right, float down);
    void pan(float right, float down, int height);
    void zoom(float steps); // > 0: nearer
    void shift(pli_vec3 way);

    render::Camera camera(float aspect) const;

private:
    void rise();

    pli_vec3 target_{};
    float distance_ = 10, yaw_ = 0, pitch_ = 0; // degrees
    float ground_ = -1e30f;
};

// Through a place of the viewport, -1 to 1 from left to right and from bottom to top.
Ray ray_through(const render::Camera& camera, float across, float up);
// Where the camera sees a point: in `across` and `up` as above; false when it is behind the camera.
bool place_of(const render::Camera& camera, pli_vec3 point, float& across, float& up);

} // namespace viewer
#endif
