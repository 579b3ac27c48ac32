#include "tools.h"

#include <cmath>

namespace viewer {

void SweptCut::begin(const Ray& ray) {
    last_ = ray;
    is_active_ = true;
}

void SweptCut::move(Session& session, const Ray& ray) {
    const pli_vec3 way = pli_vec3_sub(ray.to, last_.to);
    if (!(pli_vec3_length_squared(way) > 0.0f)) { return; }
    session.act([last = last_, ray](demos::Engine& engine, size_t) {
        const pli_vec3 first[2] = {last.from, last.to}, second[2] = {ray.from, ray.to};
        engine.cut_swept(first, second);
        return true;
    });
    last_ = ray;
}

void cut_ball(Session& session, const Ray& ray, float radius) {
    session.act([ray, radius](demos::Engine& engine, size_t) {
        const demos::RayHit hit = engine.cast_ray(ray.from, ray.to, 0);
        if (hit.soft >= 0) { engine.cut_sphere(hit.soft, hit.point, radius); }
        return hit.soft >= 0;
    });
}

float usual_cut_radius(const demos::Description& description) {
    if (!description.cuts.empty()) { return description.cuts.front().radius; }
    const pli_bounds& bounds = description.rest_bounds;
    const pli_vec3 size = pli_vec3_sub(bounds.max, bounds.min);
    const float radius = 0.06f * pli_vec3_length(size);
    return std::isfinite(radius) && radius > 0.0f ? radius : 1.0f;
}

} // namespace viewer
