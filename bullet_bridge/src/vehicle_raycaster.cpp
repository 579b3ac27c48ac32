#include <pliant_bullet/vehicle_raycaster.h>

#include "soft_object.h"

#include <BulletDynamics/ConstraintSolver/btTypedConstraint.h>
#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

namespace pliant {

namespace {

struct GroundRay final : btCollisionWorld::ClosestRayResultCallback {
    using ClosestRayResultCallback::ClosestRayResultCallback;

    bool needsCollision(btBroadphaseProxy* proxy) const override {
        const auto* object = static_cast<const btCollisionObject*>(proxy->m_clientObject);
        if (!ClosestRayResultCallback::needsCollision(proxy) || !object->hasContactResponse()) { return false; }
        return !ignores_soft_bodies || SoftObject::from(object) == nullptr;
    }

    bool ignores_soft_bodies = true;
};

} // namespace

VehicleRaycaster::VehicleRaycaster(btDynamicsWorld& world, SoftBodies soft_bodies)
    : world_(world), soft_bodies_(soft_bodies) {}

void* VehicleRaycaster::castRay(const btVector3& from, const btVector3& to, btVehicleRaycasterResult& result) {
    GroundRay ray(from, to);
    ray.ignores_soft_bodies = soft_bodies_ == SoftBodies::ignored;
    ray.m_collisionFilterGroup = filter_group;
    ray.m_collisionFilterMask = filter_mask;
    world_.rayTest(from, to, ray);
    if (!ray.hasHit()) { return nullptr; }
    // The vehicle takes it as the answer yes and reads nothing of it.
    const btRigidBody* ground = btRigidBody::upcast(ray.m_collisionObject);
    if (ground == nullptr && SoftObject::from(ray.m_collisionObject) != nullptr) {
        ground = &btTypedConstraint::getFixedBody();
    }
    if (ground == nullptr) { return nullptr; }
    result.m_hitPointInWorld = ray.m_hitPointWorld;
    result.m_hitNormalInWorld = ray.m_hitNormalWorld.normalized();
    result.m_distFraction = ray.m_closestHitFraction;
    return const_cast<btRigidBody*>(ground);
}

} // namespace pliant
