#ifndef PLIANT_BULLET_BRIDGE_MOMENT_H
#define PLIANT_BULLET_BRIDGE_MOMENT_H

// What is kept of a moment of a Bullet world with soft bodies: the state of objects that steps change, and the contact
// points that the next step starts from.

#include "pliant_bullet/snapshot.h"

#include "../bridge_impl.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <vector>

namespace pliant {

/// Of the world, as the body has it. It follows from the pose only where Bullet or the game has brought it up to date.
btMatrix3x3& inverse_inertia_of(btRigidBody& body);

/// What steps change of an object. Forces outlive a step where the world does not clear them by itself.
struct ObjectState {
    FollowedObject identity;
    btTransform pose, interpolation_pose;
    btVector3 interpolation_linear_velocity, interpolation_angular_velocity;
    int activation;
    btScalar deactivation_time, hit_fraction;
    btVector3 linear_velocity, angular_velocity, force, torque, gravity;
    btMatrix3x3 inverse_inertia;

    explicit ObjectState(const btCollisionObject& object)
        : identity(object), pose(object.getWorldTransform()),
          interpolation_pose(object.getInterpolationWorldTransform()),
          interpolation_linear_velocity(object.getInterpolationLinearVelocity()),
          interpolation_angular_velocity(object.getInterpolationAngularVelocity()),
          activation(object.getActivationState()), deactivation_time(object.getDeactivationTime()),
          hit_fraction(object.getHitFraction()) {
        const btRigidBody* body = btRigidBody::upcast(&object);
        const btVector3 none(0, 0, 0);
        linear_velocity = body != nullptr ? body->getLinearVelocity() : none;
        angular_velocity = body != nullptr ? body->getAngularVelocity() : none;
        force = body != nullptr ? body->getTotalForce() : none;
        torque = body != nullptr ? body->getTotalTorque() : none;
        gravity = body != nullptr ? body->getGravity() : none;
        inverse_inertia = body != nullptr ? body->getInvInertiaTensorWorld() : btMatrix3x3::getIdentity();
    }

    void give_back(btCollisionObject& object) const {
        object.setWorldTransform(pose);
        object.setInterpolationWorldTransform(interpolation_pose);
        object.setInterpolationLinearVelocity(interpolation_linear_velocity);
        object.setInterpolationAngularVelocity(interpolation_angular_velocity);
        object.setHitFraction(hit_fraction);
        btRigidBody* body = btRigidBody::upcast(&object);
        if (body == nullptr) { return; }
        body->setLinearVelocity(linear_velocity);
        body->setAngularVelocity(angular_velocity);
        body->setGravity(gravity);
        inverse_inertia_of(*body) = inverse_inertia;
        body->clearForces();
        // Bullet scales by the linear factor what it adds; the sum has it already.
        const btVector3 factor = body->getLinearFactor(), angular_factor = body->getAngularFactor();
        body->setLinearFactor(btVector3(1, 1, 1));
        body->setAngularFactor(btVector3(1, 1, 1));
        body->applyCentralForce(force);
        body->applyTorque(torque);
        body->setLinearFactor(factor);
        body->setAngularFactor(angular_factor);
    }
};

/// Contact points of a manifold.
struct Points {
    const btCollisionObject* bodies[2];
    int count;
    btManifoldPoint points[MANIFOLD_CACHE_SIZE];
};

struct BridgeSnapshot::Moment {
    std::vector<unsigned char> soft;
    std::vector<ObjectState> objects;
    std::vector<Points> contacts;
    Bridge::Impl::Knowledge bridge;
    btVector3 gravity;
    btScalar accumulated_time = 0;
    unsigned long seed = 0;
    bool is_empty = true;

    /// Of a file (bridge_file.cpp), for the objects of now.
    /// Null, or what is wrong.
    const char* read(const btCollisionObjectArray& array, std::size_t activation_count, const unsigned char* bytes,
                     std::size_t size);
    void take(btDiscreteDynamicsWorld& world);
    void take_contacts(const btDispatcher& dispatcher);
    bool fits(const btDiscreteDynamicsWorld& world) const;
    /// `forgets_pairs`: what Bullet knows of pairs is made anew, in an order that depends on the moment alone.
    void give_back(btDiscreteDynamicsWorld& world, bool forgets_pairs) const;
    void give_contacts_back(btDispatcher& dispatcher) const;
};

} // namespace pliant

#endif
