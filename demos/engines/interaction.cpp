// What a user does to a scene that runs: rays, dragging, balls.

#include "rigid_world.h"

namespace demos {

RayHit Engine::cast_ray(pli_vec3 from, pli_vec3 to, float radius) const {
    const RayHit soft = cast_soft_ray(from, to, radius);
    const RayHit rigid = rigids().cast_ray(from, to);
    return soft.is_hit() && soft.fraction <= rigid.fraction ? soft : rigid;
}

bool Engine::grab(const RayHit& hit) {
    let_go();
    if (hit.rigid >= 0 && !rigids().hold(hit.rigid, hit.point)) { return false; }
    if (hit.rigid < 0 && hit.node < 0) { return false; }
    if (hit.rigid < 0) { grab_soft(hit); }
    held_ = hit;
    goal_ = grip();
    return true;
}

pli_vec3 Engine::grip() const {
    return held_.node >= 0 ? soft_grip(held_) : held_.point;
}

void Engine::drag(pli_vec3 goal) {
    goal_ = goal;
}

void Engine::let_go() {
    rigids().let_go();
    if (held_.node >= 0) { let_go_soft(held_); }
    held_ = RayHit();
}

void Engine::shoot(pli_vec3 from, pli_vec3 velocity, float radius, float mass) {
    if (static_cast<size_t>(rigid_count()) >= description().rigids.size() + most_balls) {
        throw Error("there are " + std::to_string(most_balls) + " balls already");
    }
    rigids().add_ball(from, velocity, radius, mass);
}

std::vector<RigidRecord> Engine::balls() const {
    std::vector<RigidRecord> shot;
    for (size_t i = description().rigids.size(); i < static_cast<size_t>(rigid_count()); ++i) {
        shot.push_back(rigid_record(static_cast<int>(i)));
    }
    return shot;
}

void Engine::set_balls(const std::vector<RigidRecord>& balls) {
    const size_t first = description().rigids.size();
    while (static_cast<size_t>(rigid_count()) > first + balls.size()) {
        rigids().remove_last_ball();
    }
    for (size_t i = static_cast<size_t>(rigid_count()) - first; i < balls.size(); ++i) {
        rigids().add_ball(balls[i]);
    }
}

void Engine::set_gravity(pli_vec3 gravity) {
    rigids().set_gravity(gravity);
}

void Engine::prepare_step() {
    for (const ControlEvent& event : description().control_events) {
        if (clock_.begins(event.frame)) { set_control(event.control, event.value); }
    }
    if (held_.rigid >= 0) { rigids().drag(goal_); }
    if (held_.node >= 0) { drag_soft(held_, goal_, clock_.step_seconds()); }
}

} // namespace demos
