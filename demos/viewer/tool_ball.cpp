#include "tools.h"

namespace viewer {

using render::operator+;
using render::operator-;
using render::operator*;

// In proportion to what the camera sees: such a ball crosses the scene in about a second.
BallSettings usual_ball(const render::Camera& camera) {
    BallSettings ball;
    ball.radius = 0.02f * camera.distance;
    ball.speed = camera.distance;
    return ball;
}

void shoot_ball(Session& session, const render::Camera& camera, const Ray& ray, const BallSettings& ball) {
    const pli_vec3 direction = render::normalized(ray.to - ray.from);
    const pli_vec3 start = camera.eye + direction * (0.15f * camera.distance);
    session.act([=](demos::Engine& engine, size_t) {
        engine.shoot(start, direction * ball.speed, ball.radius, ball.mass);
        return true;
    });
}

} // namespace viewer
