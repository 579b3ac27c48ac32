// What BridgeSnapshot keeps of Bullet: the state of objects that steps change, and the contact points that the next
// step starts from.

#include "bridge_moment.h"

#include "../accumulator.h"

#include <BulletCollision/CollisionShapes/btCollisionShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

namespace pliant {

namespace {

// Bullet has no function that sets it; an explicit instantiation may name private members (see object_identity.cpp).
using Inertia = btMatrix3x3 btRigidBody::*;

struct InertiaKey {
    friend Inertia inertia(InertiaKey);
};

template <Inertia Member> struct ShowInertia {
    friend Inertia inertia(InertiaKey) { return Member; }
};
template struct ShowInertia<&btRigidBody::m_invInertiaTensorWorld>;

} // namespace

btMatrix3x3& inverse_inertia_of(btRigidBody& body) {
    return body.*inertia(InertiaKey());
}

namespace {

bool is_of(const Points& points, const btPersistentManifold& manifold) {
    return points.bodies[0] == manifold.getBody0() && points.bodies[1] == manifold.getBody1();
}

// Two objects have several manifolds where one is a compound; its points know the child.
bool is_of_same_children(const Points& points, const btPersistentManifold& manifold) {
    if (manifold.getNumContacts() == 0 || !is_of(points, manifold)) { return false; }
    const btManifoldPoint &kept = points.points[0], &now = manifold.getContactPoint(0);
    return kept.m_partId0 == now.m_partId0 && kept.m_index0 == now.m_index0 && kept.m_partId1 == now.m_partId1 &&
           kept.m_index1 == now.m_index1;
}

} // namespace

namespace {

// All pairs end, and what the broad phase knows follows from where objects are. The last one leaves first, so that all
// get their ids again.
void join_broad_phase_anew(btDiscreteDynamicsWorld& world) {
    const btCollisionObjectArray& array = world.getCollisionObjectArray();
    btBroadphaseInterface& broad_phase = *world.getBroadphase();
    std::vector<std::pair<int, int>> filters(static_cast<std::size_t>(array.size())); // group, mask
    for (int i = array.size() - 1; i >= 0; --i) {
        btBroadphaseProxy* proxy = array[i]->getBroadphaseHandle(); // whatever is in a world has one
        filters[static_cast<std::size_t>(i)] = {proxy->m_collisionFilterGroup, proxy->m_collisionFilterMask};
        broad_phase.getOverlappingPairCache()->cleanProxyFromPairs(proxy, world.getDispatcher());
        broad_phase.destroyProxy(proxy, world.getDispatcher());
        array[i]->setBroadphaseHandle(nullptr);
    }
    for (int i = 0; i < array.size(); ++i) {
        const auto [group, mask] = filters[static_cast<std::size_t>(i)];
        const btCollisionShape& shape = *array[i]->getCollisionShape();
        btVector3 low, high;
        shape.getAabb(array[i]->getWorldTransform(), low, high);
        array[i]->setBroadphaseHandle(
            broad_phase.createProxy(low, high, shape.getShapeType(), array[i], group, mask, world.getDispatcher()));
    }
}

btSequentialImpulseConstraintSolver* seeded_solver(btDiscreteDynamicsWorld& world) {
    return dynamic_cast<btSequentialImpulseConstraintSolver*>(world.getConstraintSolver());
}

} // namespace

void BridgeSnapshot::Moment::take(btDiscreteDynamicsWorld& world) {
    const btCollisionObjectArray& array = world.getCollisionObjectArray();
    objects.clear();
    for (int i = 0; i < array.size(); ++i) {
        objects.emplace_back(*array[i]);
    }
    take_contacts(*world.getDispatcher());
    gravity = world.getGravity();
    accumulated_time = Accumulator::time(world);
    const auto* solver = seeded_solver(world);
    seed = solver != nullptr ? solver->getRandSeed() : 0;
}

void BridgeSnapshot::Moment::take_contacts(const btDispatcher& dispatcher) {
    contacts.clear();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold = *const_cast<btDispatcher&>(dispatcher).getManifoldByIndexInternal(i);
        const int count = manifold.getNumContacts();
        if (count == 0) { continue; }
        Points& kept = contacts.emplace_back();
        kept.bodies[0] = manifold.getBody0();
        kept.bodies[1] = manifold.getBody1();
        kept.count = count;
        for (int k = 0; k < count; ++k) {
            kept.points[k] = manifold.getContactPoint(k);
            kept.points[k].m_userPersistentData = nullptr; // the user's, who has it freed when a point goes
        }
    }
}

bool BridgeSnapshot::Moment::fits(const btDiscreteDynamicsWorld& world) const {
    const btCollisionObjectArray& array = world.getCollisionObjectArray();
    if (static_cast<std::size_t>(array.size()) != objects.size()) { return false; }
    for (int i = 0; i < array.size(); ++i) {
        if (!(objects[static_cast<std::size_t>(i)].identity == FollowedObject(*array[i]))) { return false; }
    }
    return true;
}

void BridgeSnapshot::Moment::give_contacts_back(btDispatcher& dispatcher) const {
    const auto count = static_cast<std::size_t>(dispatcher.getNumManifolds());
    std::vector<bool> is_given(contacts.size(), false);
    std::vector<const Points*> chosen(count, nullptr);
    for (const auto fits : {is_of_same_children, is_of}) {
        for (std::size_t i = 0; i < count; ++i) {
            const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(static_cast<int>(i));
            for (std::size_t k = 0; k < contacts.size() && chosen[i] == nullptr; ++k) {
                if (is_given[k] || !fits(contacts[k], manifold)) { continue; }
                chosen[i] = &contacts[k];
                is_given[k] = true;
            }
        }
    }
    for (std::size_t i = 0; i < count; ++i) {
        btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(static_cast<int>(i));
        manifold.clearManifold();
        if (chosen[i] == nullptr) { continue; }
        manifold.setNumContacts(chosen[i]->count);
        for (int p = 0; p < chosen[i]->count; ++p) {
            manifold.getContactPoint(p) = chosen[i]->points[p];
        }
    }
}

void BridgeSnapshot::Moment::give_back(btDiscreteDynamicsWorld& world, bool forgets_pairs) const {
    const btCollisionObjectArray& array = world.getCollisionObjectArray();
    // Pairs of objects that sleep get no manifolds, so nothing sleeps while these are made.
    for (int i = 0; i < array.size(); ++i) {
        objects[static_cast<std::size_t>(i)].give_back(*array[i]);
        array[i]->forceActivationState(ACTIVE_TAG);
    }
    if (forgets_pairs) { join_broad_phase_anew(world); }
    world.performDiscreteCollisionDetection();
    for (int i = 0; i < array.size(); ++i) {
        const ObjectState& state = objects[static_cast<std::size_t>(i)];
        array[i]->forceActivationState(state.activation);
        array[i]->setDeactivationTime(state.deactivation_time);
    }
    give_contacts_back(*world.getDispatcher());
    Accumulator::time(world) = accumulated_time;
    if (auto* solver = seeded_solver(world)) { solver->setRandSeed(seed); }
}

BridgeSnapshot::BridgeSnapshot() : moment_(std::make_unique<Moment>()) {}
BridgeSnapshot::~BridgeSnapshot() = default;
BridgeSnapshot::BridgeSnapshot(BridgeSnapshot&&) noexcept = default;
BridgeSnapshot& BridgeSnapshot::operator=(BridgeSnapshot&&) noexcept = default;

pli_status BridgeSnapshot::save(const Bridge& bridge) {
    moment_->is_empty = true;
    btDiscreteDynamicsWorld* bullet_world = bridge.impl_->bullet_world_between_steps();
    if (bullet_world == nullptr) { return bridge.impl_->fail_between_steps("pliant::BridgeSnapshot::save"); }
    bridge.impl_->save_knowledge(moment_->bridge);
    moment_->soft.resize(pli_world_snapshot_size(bridge.world()));
    const pli_status status = pli_world_save(bridge.world(), moment_->soft.data(), moment_->soft.size(), nullptr);
    if (status != PLI_OK) { return status; }
    moment_->take(*bullet_world);
    moment_->is_empty = false;
    return PLI_OK;
}

pli_status BridgeSnapshot::restore(Bridge& bridge) const {
    btDiscreteDynamicsWorld* bullet_world = bridge.impl_->bullet_world_between_steps();
    const char* const function = "pliant::BridgeSnapshot::restore";
    if (bullet_world == nullptr) { return bridge.impl_->fail_between_steps(function); }
    if (moment_->is_empty) { return bridge.impl_->fail(PLI_ERROR_INVALID_VALUE, function, "the snapshot is empty"); }
    if (!moment_->fits(*bullet_world)) {
        return bridge.impl_->fail(PLI_ERROR_INVALID_VALUE, function,
                                  "the Bullet world has other objects, or has read a file since");
    }
    const pli_status status = pli_world_restore(bridge.world(), moment_->soft.data(), moment_->soft.size());
    if (status != PLI_OK) { return status; }
    restore_bullet(bridge, *bullet_world, *moment_, false);
    return PLI_OK;
}

void BridgeSnapshot::restore_bullet(Bridge& bridge, btDiscreteDynamicsWorld& world, const Moment& moment,
                                    bool forgets_pairs) {
    bridge.impl_->restore_knowledge(moment.bridge);
    world.setGravity(moment.gravity); // before the bodies, which may have others
    bridge.impl_->set_restoring(true);
    moment.give_back(world, forgets_pairs);
    bridge.impl_->set_restoring(false);
}

std::size_t BridgeSnapshot::bytes() const {
    return moment_->is_empty
               ? 0
               : moment_->soft.size() + moment_->objects.size() * sizeof(ObjectState) +
                     moment_->contacts.size() * sizeof(Points) + moment_->bridge.holds.size() * sizeof(Hold);
}

} // namespace pliant
