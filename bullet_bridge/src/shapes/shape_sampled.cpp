// Triangle meshes as solids on a sampled grid of the core.

#include "shapes/shapes.h"
#include "shapes/triangle_copy.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>

#include <climits>

namespace pliant {

namespace {

class ConvexMeshCopy final : public btInternalTriangleIndexCallback {
public:
    explicit ConvexMeshCopy(TriangleCopy& copy) : copy_(copy) {}

    void internalProcessTriangleIndex(btVector3* corners, int part, int index) override {
        copy_.processTriangle(corners, part, index);
    }

private:
    TriangleCopy& copy_;
};

} // namespace

bool has_triangles(const btCollisionShape& shape) {
    if (shape.isCompound()) {
        const auto& compound = static_cast<const btCompoundShape&>(shape);
        for (int i = 0; i < compound.getNumChildShapes(); ++i) {
            if (has_triangles(*compound.getChildShape(i))) { return true; }
        }
        return false;
    }
    switch (shape.getShapeType()) {
    case CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE:
        return true;
    case STATIC_PLANE_PROXYTYPE:
    case TERRAIN_SHAPE_PROXYTYPE:
    case EMPTY_SHAPE_PROXYTYPE:
        return false;
    default:
        return shape.isConcave();
    }
}

pli_status make_sampled_shape(const btCollisionShape& shape, const ShapeOptions& options, ShapePointer& result) {
    TriangleCopy copy(INT_MAX / 6);
    if (shape.isConvex()) {
        const auto& convex = static_cast<const btConvexTriangleMeshShape&>(shape);
        const btVector3 everything(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
        ConvexMeshCopy callback(copy);
        convex.getMeshInterface()->InternalProcessAllTriangles(&callback, -everything, everything);
    } else {
        btVector3 low, high;
        shape.getAabb(btTransform::getIdentity(), low, high);
        static_cast<const btConcaveShape&>(shape).processAllTriangles(&copy, low, high);
    }
    if (!copy.is_complete() || copy.triangles.empty()) {
        return pli_context_fail(options.context, PLI_ERROR_INVALID_MESH, "pliant::Bridge::use_sampled_mesh",
                                copy.is_complete() ? "a mesh has no triangles" : "a mesh has too many triangles");
    }
    pli_shape* made = nullptr;
    const pli_status status = pli_shape_create_sampled_mesh(
        options.context, static_cast<int>(copy.points.size()), copy.points.data(),
        static_cast<int>(copy.triangles.size() / 3), copy.triangles.data(), options.sampled_mesh, &made);
    result.reset(made);
    return status;
}

} // namespace pliant
