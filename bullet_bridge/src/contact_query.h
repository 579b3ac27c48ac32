#ifndef PLIANT_BULLET_CONTACT_QUERY_H
#define PLIANT_BULLET_CONTACT_QUERY_H

// Bullet's collision algorithm for its contactTest and contactPairTest with a soft body: the closest points of its
// faces, or its links where it has none, with any other shape. It reads where things are now and changes nothing.

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>

class btPersistentManifold;

namespace pliant {

class SoftObject;

class ContactQuery final : public btCollisionAlgorithm {
public:
    /// `soft_is_first`: of the two objects that processCollision gets.
    ContactQuery(const btCollisionAlgorithmConstructionInfo& info, const SoftObject& soft, bool soft_is_first,
                 const btCollisionObjectWrapper* wrap0, const btCollisionObjectWrapper* wrap1);
    ~ContactQuery() override;

    void processCollision(const btCollisionObjectWrapper* wrap0, const btCollisionObjectWrapper* wrap1,
                          const btDispatcherInfo& info, btManifoldResult* result) override;
    btScalar calculateTimeOfImpact(btCollisionObject* object0, btCollisionObject* object1, const btDispatcherInfo& info,
                                   btManifoldResult* result) override;
    void getAllContactManifolds(btManifoldArray& manifolds) override;

private:
    const SoftObject& soft_;
    const bool soft_is_first_;
    btPersistentManifold* manifold_; ///< names the two objects to Bullet's callbacks
};

} // namespace pliant

#endif
