#ifndef PLIANT_BULLET_TRIANGLE_SLABS_H
#define PLIANT_BULLET_TRIANGLE_SLABS_H

// Concave shapes as btSoftBody sees them: each triangle near the body is a hull of its corners moved 0.06 m to both
// sides, behind a lattice. The hulls live as long as the pair and are looked up by part and triangle number, even when
// the shape reports another triangle under the same numbers later (a static plane does), as in
// btSoftBodyConcaveCollisionAlgorithm.

#include "shapes/shapes.h"

#include <map>
#include <utility>

namespace pliant {

class TriangleSlabs {
public:
    /// Appends the slabs of the triangles of `part` near `body_bounds` (world) to `shapes`, and the hulls that they are
    /// to `hulls`; both stay owned here.
    /// @param pose  world transform of the object
    pli_status collect(pli_context* context, int part_index, const ShapePart& part, const btTransform& pose,
                       const pli_bounds& body_bounds, std::vector<pli_shape*>& shapes,
                       std::vector<const btConvexShape*>& hulls);
    void clear() { slabs_.clear(); }

private:
    struct Slab {
        ShapePointer shape;
        const btConvexShape* hull = nullptr;
    };
    std::map<std::pair<int, int>, Slab> slabs_; ///< by part and Bullet's key of the triangle
};

} // namespace pliant

#endif
