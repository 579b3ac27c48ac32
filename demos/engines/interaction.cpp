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
    held_ = hit;
    goal_ = hit.rigid >= 0 ? hit.point : node_position(hit.soft, hit.node);
    return true;
}

void Engine::drag(pli_vec3 goal) {
    goal_ = goal;
}

void Engine::let_go() {
    rigids().let_go();
    held_ = RayHit();
}

void Engine::shoot(pli_vec3 from, pli_vec3 velocity, float radius, float mass) {
    if (static_cast<size_t>(rigid_count()) >= description().rigids.size() + most_balls) {
        throw Error("there are " + std::to_string(most_balls) + " balls already");
    }
    rigids().add_ball(from, velocity, radius, mass);
}

// A held node gets the velocity that brings it to the goal in one step, but none that would tear at its links.
static pli_vec3 velocity_towards(pli_vec3 goal, pli_vec3 position, float seconds) {
    constexpr float fastest = 60.0f; // m/s
    const pli_vec3 velocity = pli_vec3_scale(pli_vec3_sub(goal, position), 1.0f / seconds);
    const float speed = pli_vec3_length(velocity);
    return speed > fastest ? pli_vec3_scale(velocity, fastest / speed) : velocity;
}

void Engine::prepare_step() {
    for (const ControlEvent& event : description().control_events) {
        if (clock_.begins(event.frame)) { set_control(event.control, event.value); }
    }
    if (held_.rigid >= 0) { rigids().drag(goal_); }
    if (held_.node >= 0) {
        const pli_vec3 position = node_position(held_.soft, held_.node);
        set_node_velocity(held_.soft, held_.node, velocity_towards(goal_, position, clock_.step_seconds()));
    }
}

} // namespace demos
