#ifndef PLIANT_BULLET_PAIR_ALGORITHM_H
#define PLIANT_BULLET_PAIR_ALGORITHM_H

// Bullet's collision algorithm for pairs with a soft body. It makes no contacts for Bullet's rigid solver: it tells the
// bridge that the pair is to be collided in this step, and keeps what lives as long as the pair.

#include "bridge_impl.h"
#include "rigid_proxy.h"
#include "shapes/triangle_slabs.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>

class btCollisionDispatcher;

namespace pliant {

class PairAlgorithm final : public btCollisionAlgorithm {
public:
    /// One of the objects is a soft body; `other_soft` or `proxy` is null.
    PairAlgorithm(const btCollisionAlgorithmConstructionInfo& info, const SoftObject& soft,
                  const SoftObject* other_soft, const btCollisionObject& other);
    ~PairAlgorithm() override;

    void processCollision(const btCollisionObjectWrapper* wrap0, const btCollisionObjectWrapper* wrap1,
                          const btDispatcherInfo& info, btManifoldResult* result) override;
    btScalar calculateTimeOfImpact(btCollisionObject* object0, btCollisionObject* object1, const btDispatcherInfo& info,
                                   btManifoldResult* result) override;
    void getAllContactManifolds(btManifoldArray& manifolds) override;

    const SoftObject& soft;
    const SoftObject* const other_soft;
    const btCollisionObject& other;
    RigidProxy* const proxy;
    TriangleSlabs slabs;      ///< of concave shapes in reference mode
    int collected_index = -1; ///< place among the bridge's pairs of this step
};

/// Makes the dispatcher use PairAlgorithm for soft bodies, and ContactQuery for contact tests. Objects that only share
/// the shape type keep the algorithm of the dispatcher's configuration. May be called again.
void register_pair_algorithm(btCollisionDispatcher& dispatcher);

} // namespace pliant

#endif
