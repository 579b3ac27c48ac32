#include "shapes/triangle_slabs.h"

#include "convert.h"

#include <BulletCollision/BroadphaseCollision/btQuantizedBvh.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <LinearMath/btAabbUtil2.h>

namespace pliant {

namespace {

constexpr btScalar slab_half_thickness = btScalar(0.06);

std::unique_ptr<btConvexShape> make_slab(const btVector3* corners) {
    btVector3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    normal.normalize();
    normal *= slab_half_thickness;
    btVector3 points[6];
    for (int i = 0; i < 3; ++i) {
        points[i] = corners[i] + normal;
        points[i + 3] = corners[i] - normal;
    }
    return std::make_unique<btConvexHullShape>(points[0].m_floats, 6);
}

template <typename Visit> class TriangleVisitor final : public btTriangleCallback {
public:
    explicit TriangleVisitor(Visit visit) : visit_(visit) {}
    void processTriangle(btVector3* corners, int part, int index) override { visit_(corners, part, index); }

private:
    Visit visit_;
};

} // namespace

pli_status TriangleSlabs::collect(pli_context* context, int part_index, const ShapePart& part, const btTransform& pose,
                                  const pli_bounds& body_bounds, std::vector<pli_shape*>& shapes,
                                  std::vector<const btConvexShape*>& hulls) {
    const btVector3 low = to_bullet(body_bounds.min), high = to_bullet(body_bounds.max);
    const btVector3 half_extents = (high - low) * btScalar(0.5);
    btTransform center;
    center.setIdentity();
    center.setOrigin((high + low) * btScalar(0.5));
    const btTransform body_in_mesh = (pose * part.pose).inverse() * center;
    btVector3 query_low, query_high;
    btTransformAabb(half_extents, part.triangles->getMargin() + slab_half_thickness, body_in_mesh, query_low,
                    query_high);

    pli_status status = PLI_OK;
    TriangleVisitor visitor([&](const btVector3* corners, int mesh_part, int index) {
        const int key = static_cast<int>(static_cast<unsigned>(mesh_part) << (31 - MAX_NUM_PARTS_IN_BITS)) | index;
        Slab& slab = slabs_[{part_index, key}];
        if (!slab.shape) {
            std::unique_ptr<btConvexShape> hull = make_slab(corners);
            slab.hull = hull.get();
            const pli_status made = make_lattice_shape(context, std::move(hull), slab.shape);
            if (made != PLI_OK) { status = made; }
        }
        if (slab.shape) {
            shapes.push_back(slab.shape.get());
            hulls.push_back(slab.hull);
        }
    });
    part.triangles->processAllTriangles(&visitor, query_low, query_high);
    return status;
}

} // namespace pliant
