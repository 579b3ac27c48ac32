#ifndef PLIANT_BULLET_TRIANGLE_COPY_H
#define PLIANT_BULLET_TRIANGLE_COPY_H

// Triangles of a Bullet shape with shared corners, as the core takes them.

#include "convert.h"

#include <BulletCollision/CollisionShapes/btTriangleCallback.h>

#include <array>
#include <map>
#include <utility>
#include <vector>

namespace pliant {

class TriangleCopy final : public btTriangleCallback {
public:
    /// Triangles from `limit` on are counted only.
    explicit TriangleCopy(std::size_t limit) : limit_(limit) {}

    void processTriangle(btVector3* corners, int, int) override {
        if (++count_ > limit_) { return; }
        for (int i = 0; i < 3; ++i) {
            const pli_vec3 p = to_pli(corners[i]);
            // Corners are shared when they are the same point: the sign at edges needs the neighbours.
            const auto [place, is_new] = index_.try_emplace({p.x, p.y, p.z}, static_cast<int>(points.size()));
            if (is_new) { points.push_back(p); }
            triangles.push_back(place->second);
        }
    }

    bool is_complete() const { return count_ <= limit_; }
    /// Front becomes back.
    void turn_over() {
        for (std::size_t i = 0; i < triangles.size(); i += 3) {
            std::swap(triangles[i], triangles[i + 1]);
        }
    }

    std::vector<pli_vec3> points;
    std::vector<int> triangles;

private:
    std::size_t limit_, count_ = 0;
    std::map<std::array<float, 3>, int> index_;
};

} // namespace pliant

#endif
