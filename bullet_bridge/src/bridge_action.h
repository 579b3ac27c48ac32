#ifndef PLIANT_BULLET_BRIDGE_ACTION_H
#define PLIANT_BULLET_BRIDGE_ACTION_H

// A bridge's entry in the Bullet world's list of actions.

#include "bridge_impl.h"

#include <BulletDynamics/Dynamics/btActionInterface.h>

namespace pliant {

class BridgeAction final : public btActionInterface {
public:
    explicit BridgeAction(Bridge::Impl& bridge) : bridge_(&bridge) {}

    void updateAction(btCollisionWorld* world, btScalar dt) override;
    void debugDraw(btIDebugDraw* drawer) override;

    /// For the end of a bridge that cannot tell whether its Bullet world still lives: Bullet tells nobody when a world
    /// goes, and a world that has gone must not be asked to take an action out. From now on the action does nothing,
    /// and it is kept, as the world may still call it.
    static void leave_in(const btDiscreteDynamicsWorld& world, std::unique_ptr<BridgeAction> action);
    /// Takes out what bridges left in a world, which lives now, or in an earlier one at its address.
    static void take_left_out_of(btDiscreteDynamicsWorld& world);

private:
    Bridge::Impl* bridge_;
    const btDiscreteDynamicsWorld* left_in_ = nullptr; // only to compare
    BridgeAction* next_ = nullptr;                     // among those that were left
};

} // namespace pliant

#endif
