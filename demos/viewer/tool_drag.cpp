#include "tools.h"

#include <cmath>

namespace viewer {

using render::operator+;
using render::operator-;
using render::operator*;

bool DragTool::begin(Session& session, const render::Camera& camera, const Ray& ray, float radius) {
    grips_.clear();
    normal_ = camera.forward;
    session.for_each([&](demos::Engine& engine, size_t run) {
        const demos::RayHit hit = engine.cast_ray(ray.from, ray.to, radius);
        if (!hit.is_hit() || !engine.grab(hit)) { return; }
        grips_.push_back({run, hit.point, engine.grip() - hit.point});
    });
    return is_active();
}

void DragTool::move(Session& session, const Ray& ray) const {
    const pli_vec3 way = ray.to - ray.from;
    const float descent = pli_vec3_dot(way, normal_);
    if (!(descent > 0.0f)) { return; }
    session.for_each([&](demos::Engine& engine, size_t run) {
        for (const Grip& grip : grips_) {
            if (grip.run != run) { continue; }
            const float share = pli_vec3_dot(grip.point - ray.from, normal_) / descent;
            engine.drag(ray.from + way * share + grip.offset);
        }
    });
}

void DragTool::end(Session& session) {
    session.for_each([](demos::Engine& engine, size_t) { engine.let_go(); });
    grips_.clear();
}

} // namespace viewer
