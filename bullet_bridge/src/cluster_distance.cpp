// Witness points of clusters by btGjkEpaSolver2, as CollideCL_RS and CollideCL_SS ask for them.

#include "pliant_bullet/cluster_distance.h"

#include "convert.h"
#include "rigid_proxy.h"

#include <BulletCollision/CollisionShapes/btConvexInternalShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>

namespace pliant {

namespace {

// The hull of a cluster's nodes where they are now.
class ClusterShape final : public btConvexInternalShape {
public:
    ClusterShape(const pli_body* body, int cluster) : positions_(pli_body_get_view(body).positions) {
        is_valid_ = pli_body_get_cluster(body, cluster, &view_) == PLI_OK;
        m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
        m_collisionMargin = 0;
    }

    bool is_valid() const { return is_valid_; }
    btVector3 center() const { return to_bullet(view_.frame.origin); }

    btVector3 localGetSupportingVertex(const btVector3& direction) const override {
        int farthest = 0;
        btScalar most = direction.dot(node(0));
        for (int i = 1; i < view_.node_count; ++i) {
            const btScalar along = direction.dot(node(i));
            if (along > most) {
                most = along;
                farthest = i;
            }
        }
        return node(farthest);
    }
    btVector3 localGetSupportingVertexWithoutMargin(const btVector3& direction) const override {
        return localGetSupportingVertex(direction);
    }
    void batchedUnitVectorGetSupportingVertexWithoutMargin(const btVector3* directions, btVector3* points,
                                                           int count) const override {
        for (int i = 0; i < count; ++i) {
            points[i] = localGetSupportingVertex(directions[i]);
        }
    }
    void getAabb(const btTransform&, btVector3& low, btVector3& high) const override { low = high = center(); }
    void calculateLocalInertia(btScalar, btVector3& inertia) const override { inertia.setZero(); }
    const char* getName() const override { return "Cluster"; }

private:
    btVector3 node(int index) const {
        const pli_vec4& p = positions_[view_.nodes[index * view_.node_stride]];
        return to_bullet(pli_vec3_make(p.x, p.y, p.z));
    }

    const pli_vec4* positions_;
    pli_cluster_view view_{};
    bool is_valid_ = false;
};

} // namespace

bool bullet_cluster_distance(const pli_body* body, pli_cluster_contact* contact, void* user) {
    const ClusterShape cluster(body, contact->cluster);
    if (!cluster.is_valid()) { return false; }
    const btTransform here = btTransform::getIdentity();
    btGjkEpaSolver2::sResults results;
    bool is_found = false;
    if (contact->rigid != nullptr) {
        if (user == nullptr) { return false; }
        btTransform pose;
        const RigidProxy* proxy = static_cast<Bridge*>(user)->impl_->find_proxy(*contact->rigid);
        const btConvexShape* shape = proxy != nullptr ? proxy->convex_shape(contact->shape, pose) : nullptr;
        if (shape == nullptr) { return false; }
        is_found = btGjkEpaSolver2::SignedDistance(&cluster, here, shape, pose, btVector3(1, 0, 0), results);
    } else {
        const ClusterShape other(contact->other, contact->other_cluster);
        if (!other.is_valid()) { return false; }
        is_found =
            btGjkEpaSolver2::SignedDistance(&cluster, here, &other, here, cluster.center() - other.center(), results);
    }
    contact->witness = to_pli(results.witnesses[0]);
    contact->other_witness = to_pli(results.witnesses[1]);
    contact->normal = to_pli(results.normal);
    contact->distance = to_float(results.distance);
    return is_found;
}

} // namespace pliant
