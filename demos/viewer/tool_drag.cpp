#include "tools.h"

#include <algorithm>
#include <cmath>

namespace viewer {

using render::operator+;
using render::operator-;
using render::operator*;

bool DragTool::begin(Session& session, const render::Camera& camera, const Ray& ray, float radius) {
    grips_.clear();
    normal_ = camera.forward;
    std::vector<demos::RayHit> hits(session.runs().size());
    session.for_each([&](demos::Engine& engine, size_t run) { hits[run] = engine.cast_ray(ray.from, ray.to, radius); });
    const auto is_met = [](const demos::RayHit& hit) { return hit.is_hit(); };
    if (std::none_of(hits.begin(), hits.end(), is_met)) { return false; }
    session.act([hits](demos::Engine& engine, size_t run) { return hits[run].is_hit() && engine.grab(hits[run]); });
    session.for_each([&](demos::Engine& engine, size_t run) {
        if (engine.is_holding()) { grips_.push_back({run, hits[run].point, engine.grip() - hits[run].point}); }
    });
    return is_active();
}

void DragTool::move(Session& session, const Ray& ray) const {
    const pli_vec3 way = ray.to - ray.from;
    const float descent = pli_vec3_dot(way, normal_);
    if (!(descent > 0.0f)) { return; }
    std::vector<std::pair<size_t, pli_vec3>> goals; // of a run
    for (const Grip& grip : grips_) {
        const float share = pli_vec3_dot(grip.point - ray.from, normal_) / descent;
        goals.emplace_back(grip.run, ray.from + way * share + grip.offset);
    }
    session.move([goals](demos::Engine& engine, size_t run) {
        for (const auto& [of, goal] : goals) {
            if (of == run) { engine.drag(goal); }
        }
        return true;
    });
}

void DragTool::end(Session& session) {
    session.act([](demos::Engine& engine, size_t) {
        engine.let_go();
        return true;
    });
    grips_.clear();
}

} // namespace viewer
