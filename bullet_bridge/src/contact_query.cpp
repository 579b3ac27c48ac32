#include "contact_query.h"

#include "convert.h"
#include "soft_object.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <LinearMath/btAabbUtil2.h>

namespace pliant {

namespace {

/// Which part of the other object is looked at, as Bullet's callbacks name it.
struct Part {
    int part, index;
};

class Query {
public:
    Query(const SoftObject& soft, bool soft_is_first, btManifoldResult& result)
        : margin_(btScalar(pli_body_get_collision_margin(soft.body()))), view_(pli_body_get_view(soft.body())),
          pose_(soft.getWorldTransform()), soft_is_first_(soft_is_first), result_(result),
          reach_(result.getPersistentManifold()->getContactBreakingThreshold() +
                 result.m_closestPointDistanceThreshold) {}

    void meet(const btCollisionShape& shape, const btTransform& pose, Part part) {
        if (shape.isCompound()) {
            const auto& compound = static_cast<const btCompoundShape&>(shape);
            for (int i = 0; i < compound.getNumChildShapes(); ++i) {
                meet(*compound.getChildShape(i), pose * compound.getChildTransform(i), {-1, i});
            }
        } else if (shape.getShapeType() == STATIC_PLANE_PROXYTYPE) {
            meet_plane(static_cast<const btStaticPlaneShape&>(shape), pose, part);
        } else if (shape.isConvex()) {
            meet_convex(static_cast<const btConvexShape&>(shape), pose, part);
        } else if (shape.isConcave() && shape.getShapeType() != SDF_SHAPE_PROXYTYPE) {
            meet_concave(static_cast<const btConcaveShape&>(shape), pose);
        }
    }

private:
    /// Bullet's detector goes on to the sum of the margins beyond the margins.
    struct Near final : btDiscreteCollisionDetectorInterface::Result {
        Near(btManifoldResult& of, btScalar distance) : result(of), reach(distance) {}
        void setShapeIdentifiersA(int part, int index) override { result.setShapeIdentifiersA(part, index); }
        void setShapeIdentifiersB(int part, int index) override { result.setShapeIdentifiersB(part, index); }
        void addContactPoint(const btVector3& normal, const btVector3& point, btScalar distance) override {
            if (distance <= reach) { result.addContactPoint(normal, point, distance); }
        }
        btManifoldResult& result;
        btScalar reach;
    };

    btVector3 node(int index) const {
        const pli_vec4& p = view_.positions[index];
        return pose_ * to_bullet(pli_vec3_make(p.x, p.y, p.z));
    }

    /// Faces, and without faces links as triangles without width, whose bounds come within reach of a box.
    template <typename Do> void for_pieces(btVector3 low, btVector3 high, Do&& call) const {
        const btScalar more = reach_ + margin_;
        low -= btVector3(more, more, more);
        high += btVector3(more, more, more);
        const bool has_faces = view_.face_count > 0;
        for (int i = 0; i < (has_faces ? view_.face_count : view_.link_count); ++i) {
            const int* nodes = has_faces ? view_.face_nodes + 3 * i : view_.link_nodes + view_.link_node_stride * i;
            const btVector3 corners[3] = {node(nodes[0]), node(nodes[1]), node(nodes[has_faces ? 2 : 1])};
            if (!TestTriangleAgainstAabb2(corners, low, high)) { continue; }
            btTriangleShape piece(corners[0], corners[1], corners[2]);
            piece.setMargin(margin_);
            call(piece, i);
        }
    }

    void name(int piece, Part other) const {
        if (soft_is_first_) {
            result_.setShapeIdentifiersA(0, piece);
            result_.setShapeIdentifiersB(other.part, other.index);
        } else {
            result_.setShapeIdentifiersA(other.part, other.index);
            result_.setShapeIdentifiersB(0, piece);
        }
    }

    void find_points(const btTriangleShape& piece, const btConvexShape& shape, const btTransform& pose) const {
        const btTransform& world = btTransform::getIdentity();
        btVoronoiSimplexSolver simplex;
        btGjkEpaPenetrationDepthSolver depth;
        btGjkPairDetector detector(soft_is_first_ ? static_cast<const btConvexShape*>(&piece) : &shape,
                                   soft_is_first_ ? &shape : static_cast<const btConvexShape*>(&piece), &simplex,
                                   &depth);
        btDiscreteCollisionDetectorInterface::ClosestPointInput input;
        input.m_transformA = soft_is_first_ ? world : pose;
        input.m_transformB = soft_is_first_ ? pose : world;
        const btScalar most = reach_ + piece.getMargin() + shape.getMargin();
        input.m_maximumDistanceSquared = most * most;
        Near near(result_, reach_);
        detector.getClosestPoints(input, near, nullptr);
    }

    void meet_convex(const btConvexShape& shape, const btTransform& pose, Part part) const {
        btVector3 low, high;
        shape.getAabb(pose, low, high);
        for_pieces(low, high, [&](const btTriangleShape& piece, int index) {
            name(index, part);
            find_points(piece, shape, pose);
        });
    }

    void meet_plane(const btStaticPlaneShape& plane, const btTransform& pose, Part part) const {
        const btVector3 normal = pose.getBasis() * plane.getPlaneNormal();
        const btScalar constant = plane.getPlaneConstant() + normal.dot(pose.getOrigin());
        const btVector3 all(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
        for_pieces(-all, all, [&](const btTriangleShape& piece, int index) {
            const btVector3 deepest = piece.localGetSupportingVertex(-normal);
            const btScalar distance = normal.dot(deepest) - constant;
            if (distance > reach_) { return; }
            name(index, part);
            // Bullet wants the point on the second object, and the normal from there to the first.
            const btVector3 point = soft_is_first_ ? deepest - normal * distance : deepest;
            result_.addContactPoint(soft_is_first_ ? normal : -normal, point, distance);
        });
    }

    // Soft bodies of the bridge see triangles of others without Bullet's margin.
    void meet_concave(const btConcaveShape& shape, const btTransform& pose) const {
        struct Triangles final : btTriangleCallback {
            void processTriangle(btVector3* corners, int part, int index) override {
                btTriangleShape triangle(corners[0], corners[1], corners[2]);
                triangle.setMargin(margin);
                query->name(piece_index, {part, index});
                query->find_points(*piece, triangle, *pose);
            }
            const Query* query = nullptr;
            const btTriangleShape* piece = nullptr;
            int piece_index = 0;
            const btTransform* pose = nullptr;
            btScalar margin = 0;
        } triangles;
        triangles.query = this;
        triangles.pose = &pose;
        if (shape.getShapeType() == soft_shape_type) { triangles.margin = shape.getMargin(); }
        const btScalar more = reach_ + triangles.margin;
        const btTransform to_shape = pose.inverse();
        btVector3 low, high;
        shape.getAabb(pose, low, high);
        for_pieces(low, high, [&](const btTriangleShape& piece, int index) {
            triangles.piece = &piece;
            triangles.piece_index = index;
            btVector3 piece_low, piece_high;
            piece.getAabb(to_shape, piece_low, piece_high); // with the piece's margin
            const btVector3 around(more, more, more);
            shape.processAllTriangles(&triangles, piece_low - around, piece_high + around);
        });
    }

    btScalar margin_;
    pli_body_view view_;
    btTransform pose_; ///< by which the game has moved the body since the last step
    bool soft_is_first_;
    btManifoldResult& result_;
    btScalar reach_; ///< of points that are told, beyond the margins
};

} // namespace

ContactQuery::ContactQuery(const btCollisionAlgorithmConstructionInfo& info, const SoftObject& soft, bool soft_is_first,
                           const btCollisionObjectWrapper* wrap0, const btCollisionObjectWrapper* wrap1)
    : btCollisionAlgorithm(info), soft_(soft), soft_is_first_(soft_is_first),
      manifold_(info.m_dispatcher1->getNewManifold(wrap0->getCollisionObject(), wrap1->getCollisionObject())) {}

ContactQuery::~ContactQuery() {
    m_dispatcher->releaseManifold(manifold_);
}

void ContactQuery::processCollision(const btCollisionObjectWrapper* wrap0, const btCollisionObjectWrapper* wrap1,
                                    const btDispatcherInfo&, btManifoldResult* result) {
    const btCollisionObjectWrapper& other = soft_is_first_ ? *wrap1 : *wrap0;
    result->setPersistentManifold(manifold_);
    Query(soft_, soft_is_first_, *result)
        .meet(*other.getCollisionShape(), other.getWorldTransform(), {other.m_partId, other.m_index});
}

btScalar ContactQuery::calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                             btManifoldResult*) {
    return btScalar(1);
}

void ContactQuery::getAllContactManifolds(btManifoldArray& manifolds) {
    manifolds.push_back(manifold_);
}

} // namespace pliant
