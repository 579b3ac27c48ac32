#include "bridge_action.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

namespace pliant {

namespace {

// Bridges of different worlds may live in different threads.
std::mutex left_mutex;
BridgeAction* first_left = nullptr;

} // namespace

void BridgeAction::updateAction(btCollisionWorld* world, btScalar dt) {
    if (bridge_ != nullptr) { bridge_->update(*world, dt); }
}

void BridgeAction::debugDraw(btIDebugDraw* drawer) {
    if (bridge_ != nullptr) { bridge_->debug_draw(drawer); }
}

void BridgeAction::leave_in(const btDiscreteDynamicsWorld& world, std::unique_ptr<BridgeAction> action) {
    const std::lock_guard<std::mutex> lock(left_mutex);
    action->bridge_ = nullptr;
    action->left_in_ = &world;
    action->next_ = first_left;
    first_left = action.release();
}

void BridgeAction::take_left_out_of(btDiscreteDynamicsWorld& world) {
    const std::lock_guard<std::mutex> lock(left_mutex);
    for (BridgeAction** place = &first_left; *place != nullptr;) {
        BridgeAction* action = *place;
        if (action->left_in_ != &world) {
            place = &action->next_;
            continue;
        }
        *place = action->next_;
        world.removeAction(action); // nothing where the world is another one
        delete action;
    }
}

} // namespace pliant
