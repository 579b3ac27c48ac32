// Sleep: Bullet's islands decide what sleeps. A soft body that rests lets its object want to; what Bullet puts to sleep
// or wakes does so in the core, and the other way round.

#include "bridge_impl.h"
#include "convert.h"
#include "soft_object.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btAabbUtil2.h>

namespace pliant {

namespace {

// An awake object that may wake soft bodies, along its motion in the step.
bool is_moving(const btCollisionObject& object) {
    const btRigidBody* body = btRigidBody::upcast(&object);
    if (body == nullptr || !object.isActive() || object.isStaticObject() || !object.hasContactResponse()) {
        return false;
    }
    return !object.isKinematicObject() || !body->getLinearVelocity().fuzzyZero() ||
           !body->getAngularVelocity().fuzzyZero();
}

void get_swept_aabb(const btRigidBody& body, btScalar dt, btVector3& aabb_min, btVector3& aabb_max) {
    body.getAabb(aabb_min, aabb_max);
    const btVector3 motion = body.getLinearVelocity() * dt;
    const btScalar reach =
        (aabb_max - aabb_min).length() * btScalar(0.5) * btMin(btScalar(1), body.getAngularVelocity().length() * dt);
    const btVector3 turn(reach, reach, reach), none(0, 0, 0);
    btVector3 forth = motion, back = motion;
    forth.setMax(none);
    back.setMin(none);
    aabb_min += back - turn;
    aabb_max += forth + turn;
}

} // namespace

// Before the prediction.
void Bridge::Impl::follow_activation(SoftObject& object) {
    pli_body* body = object.body();
    const bool should_rest = !object.isActive() || object.getWorldArrayIndex() < 0;
    const bool may_sleep = object.wants_sleep && object.getWorldArrayIndex() >= 0;
    if (should_rest && may_sleep && !object.is_frozen_by_bridge) {
        if (object.is_asleep ? pli_body_is_asleep(body) : pli_body_is_resting(body)) {
            if (!object.is_asleep) { note(pli_body_set_asleep(body, true)); }
            object.is_asleep = true;
            return;
        }
        wake(object); // a call has changed it
    } else if (object.is_asleep) {
        wake(object);
    }
    const bool should_freeze = should_rest && !may_sleep;
    if (should_freeze == object.is_frozen_by_bridge || should_freeze == pli_body_is_frozen(body)) { return; }
    (void)pli_body_set_frozen(body, should_freeze);
    object.is_frozen_by_bridge = should_freeze;
}

void Bridge::Impl::wake(SoftObject& object) {
    if (object.is_asleep) { (void)pli_body_set_asleep(object.body(), false); }
    object.is_asleep = object.wants_sleep = false;
    if (object.getActivationState() != DISABLE_SIMULATION) { object.activate(true); }
}

// Islands wake what an awake body has met, a step later.
void Bridge::Impl::wake_met(btScalar dt) {
    bool is_any_asleep = false;
    for (const auto& object : objects_) {
        is_any_asleep = is_any_asleep || object->is_asleep;
    }
    if (!is_any_asleep) { return; }
    const btCollisionObjectArray& array = bullet_world_->getCollisionObjectArray();
    for (int i = 0; i < array.size(); ++i) {
        if (!is_moving(*array[i])) { continue; }
        const FollowedObject mover(*array[i]);
        btVector3 low, high;
        get_swept_aabb(*btRigidBody::upcast(array[i]), dt, low, high);
        for (const auto& object : objects_) {
            if (!object->is_asleep) { continue; }
            const pli_bounds bounds = pli_body_get_bounds(object->body());
            if (!TestAabbAgainstAabb2(low, high, to_bullet(bounds.min), to_bullet(bounds.max))) { continue; }
            const FollowedObject own(*object);
            if ((mover.group & own.mask) != 0 && (own.group & mover.mask) != 0) { wake(*object); }
        }
    }
}

// After the solve.
void Bridge::Impl::offer_sleep() {
    for (const auto& object : objects_) {
        if (object->getWorldArrayIndex() < 0 || object->is_asleep) { continue; }
        // A body that has met this one in the prediction has woken what slept with it.
        const bool is_resting = pli_body_is_resting(object->body());
        if (is_resting != object->wants_sleep) {
            object->setActivationState(is_resting ? WANTS_DEACTIVATION : ACTIVE_TAG);
        }
        object->wants_sleep = is_resting;
    }
}

} // namespace pliant
