#ifndef BENCH_CONVEX_PAIRS_HPP
#define BENCH_CONVEX_PAIRS_HPP

// Random pairs of convex hulls and opinions on their signed distance: Pliant's, Bullet's, and an exact one. For
// the benchmark and the comparison in tests/.

extern "C" {
#include "geometry/convex_distance.h"
#include "geometry/convex_hull.h"
}

#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace pairs {

struct Random {
    uint64_t state;
    uint32_t next() {
        state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        return static_cast<uint32_t>(state >> 33);
    }
    // In [0, 1).
    float unit() { return static_cast<float>(next() >> 7) / 16777216.0f; }
    float between(float low, float high) { return low + (high - low) * unit(); }
    int count(int low, int high) { return low + static_cast<int>(next() % static_cast<uint32_t>(high - low + 1)); }
};

inline pli_vec3 operator+(pli_vec3 a, pli_vec3 b) {
    return pli_vec3_add(a, b);
}

// A hull of points, with its support function and a count of its calls.
struct Hull {
    std::vector<pli_vec3> points;
    pli_vec3 centre = {0, 0, 0};
    mutable int calls = 0;

    void set_centre() {
        pli_vec3 sum = {0, 0, 0};
        for (const pli_vec3& p : points) {
            sum = sum + p;
        }
        centre = pli_vec3_scale(sum, 1.0f / static_cast<float>(points.size()));
    }
    static pli_vec3 support(const void* user, pli_vec3 direction) {
        const Hull& hull = *static_cast<const Hull*>(user);
        ++hull.calls;
        const pli_vec3* best = hull.points.data();
        float farthest = pli_vec3_dot(*best, direction);
        for (const pli_vec3& p : hull.points) {
            const float along = pli_vec3_dot(p, direction);
            if (along > farthest) {
                farthest = along;
                best = &p;
            }
        }
        return *best;
    }
    plii_convex convex() const { return {support, this, centre}; }
    double extent(double x, double y, double z) const {
        double farthest = -HUGE_VAL;
        for (const pli_vec3& p : points) {
            farthest = std::max(farthest, x * static_cast<double>(p.x) + y * static_cast<double>(p.y) +
                                              z * static_cast<double>(p.z));
        }
        return farthest;
    }
};

// 8 to 20 points in a ball of diameter 1.
inline Hull random_hull(Random& random, pli_vec3 position) {
    Hull hull;
    const int count = random.count(8, 20);
    while (static_cast<int>(hull.points.size()) < count) {
        const pli_vec3 p = {random.between(-0.5f, 0.5f), random.between(-0.5f, 0.5f), random.between(-0.5f, 0.5f)};
        if (pli_vec3_length_squared(p) <= 0.25f) { hull.points.push_back(position + p); }
    }
    hull.set_centre();
    return hull;
}

struct Pair {
    Hull a, b;
};

inline Pair random_pair(Random& random) {
    const pli_vec3 offset = {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
    return {random_hull(random, {0, 0, 0}), random_hull(random, offset)};
}

// Signed distance, normal (unit, from b to a).
struct Opinion {
    bool is_valid;
    double distance;
    double normal[3];
};

// How far a must move along the normal to touch b: for the right normal, minus the signed distance.
inline double way_along(const Pair& pair, const double* n) {
    return pair.b.extent(n[0], n[1], n[2]) + pair.a.extent(-n[0], -n[1], -n[2]);
}

inline double angle_degrees(const double* m, const double* n) {
    const double cross[3] = {m[1] * n[2] - m[2] * n[1], m[2] * n[0] - m[0] * n[2], m[0] * n[1] - m[1] * n[0]};
    const double sine = std::sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]);
    return std::atan2(sine, m[0] * n[0] + m[1] * n[1] + m[2] * n[2]) * (180.0 / 3.14159265358979323846);
}

inline Opinion pliant_opinion(const plii_convex_result& r) {
    return {r.relation == PLII_CONVEX_SEPARATED || r.relation == PLII_CONVEX_OVERLAPPING,
            static_cast<double>(r.distance),
            {static_cast<double>(r.normal.x), static_cast<double>(r.normal.y), static_cast<double>(r.normal.z)}};
}

inline btVector3 bullet(pli_vec3 v) {
    return btVector3(btScalar(v.x), btScalar(v.y), btScalar(v.z));
}

inline void bullet_shape(const Hull& hull, btConvexHullShape& shape) {
    for (const pli_vec3& p : hull.points) {
        shape.addPoint(bullet(p), false);
    }
    shape.setMargin(0);
    shape.recalcLocalAabb();
}

inline Opinion bullet_opinion(const btConvexHullShape& a, const btConvexHullShape& b, pli_vec3 between) {
    const btTransform identity = btTransform::getIdentity();
    btGjkEpaSolver2::sResults results;
    if (btGjkEpaSolver2::Distance(&a, identity, &b, identity, bullet(between), results)) {
        return {true, results.distance, {results.normal.x(), results.normal.y(), results.normal.z()}};
    }
    if (!btGjkEpaSolver2::Penetration(&a, identity, &b, identity, bullet(between), results, false)) {
        return {false, 0, {0, 0, 0}};
    }
    const btVector3 n = results.normal;
    return {true, results.distance, {n.x(), n.y(), n.z()}};
}

// The depth of an overlap, the least over all faces of the hull of a - b.
inline Opinion exact_overlap(pli_context* context, const Pair& pair) {
    std::vector<pli_vec3> points;
    for (const pli_vec3& p : pair.a.points) {
        for (const pli_vec3& q : pair.b.points) {
            points.push_back(pli_vec3_sub(p, q));
        }
    }
    plii_convex_hull hull;
    if (plii_convex_hull_create(context, static_cast<int>(points.size()), points.data(), 0, "exact_overlap", &hull) !=
        PLI_OK) {
        return {false, 0, {0, 0, 0}};
    }
    Opinion best = {false, -HUGE_VAL, {0, 0, 0}};
    for (int i = 0; i < hull.triangle_count; ++i) {
        const plii_dvec3 p = plii_dvec3_from(points[static_cast<size_t>(hull.triangles[i][0])]);
        const plii_dvec3 q = plii_dvec3_from(points[static_cast<size_t>(hull.triangles[i][1])]);
        const plii_dvec3 r = plii_dvec3_from(points[static_cast<size_t>(hull.triangles[i][2])]);
        const plii_dvec3 n = plii_dvec3_cross(plii_dvec3_sub(q, p), plii_dvec3_sub(r, p));
        const double length = plii_dvec3_length(n);
        if (!(length > 1e-9)) { continue; }
        const double unit[3] = {-n.x / length, -n.y / length, -n.z / length};
        const double way = way_along(pair, unit);
        if (-way > best.distance) { best = {true, -way, {unit[0], unit[1], unit[2]}}; }
    }
    plii_convex_hull_destroy(context, &hull);
    return best;
}

} // namespace pairs

#endif
