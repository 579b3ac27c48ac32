#ifndef DEMOS_VIEWER_TOOLS_H
#define DEMOS_VIEWER_TOOLS_H

// What the mouse does to bodies. All tools act on every run of a session with the same ray.

#include "orbit.h"
#include "session.h"

namespace viewer {

// Pulls a point of a soft body, or a rigid body that moves, in the plane that faces the camera.
class DragTool {
public:
    // False when the ray meets nothing that can be dragged, in no run.
    bool begin(Session& session, const render::Camera& camera, const Ray& ray, float radius);
    void move(Session& session, const Ray& ray) const;
    void end(Session& session);
    bool is_active() const { return !grips_.empty(); }

private:
    struct Grip {
        size_t run;
        pli_vec3 point;  // where the ray met
        pli_vec3 offset; // from there to what is moved
    };
    std::vector<Grip> grips_;
    pli_vec3 normal_{};
};

// Cuts along the surface that the cursor's ray sweeps.
class SweptCut {
public:
    void begin(const Ray& ray);
    void move(Session& session, const Ray& ray);
    void end() { is_active_ = false; }
    bool is_active() const { return is_active_; }

private:
    Ray last_{};
    bool is_active_ = false;
};

// Cuts a ball out of the soft body that the ray meets first.
void cut_ball(Session& session, const Ray& ray, float radius);
// Ball cuts have the radius of those of the scene's script, or a share of the size of the soft bodies.
float usual_cut_radius(const demos::Description& description);

struct BallSettings {
    float radius = 0.5f, mass = 5.0f, speed = 25.0f; // m, kg, m/s
};

BallSettings usual_ball(const render::Camera& camera);
// Away from the camera along the ray.
void shoot_ball(Session& session, const render::Camera& camera, const Ray& ray, const BallSettings& ball);

} // namespace viewer
#endif
