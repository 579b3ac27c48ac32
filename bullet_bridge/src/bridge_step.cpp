// The bridge's part of a step of the Bullet world.

#include "bridge_impl.h"
#include "convert.h"
#include "pair_algorithm.h"
#include "rigid_proxy.h"
#include "soft_object.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btAabbUtil2.h>
#include <LinearMath/btIDebugDraw.h>

#include <algorithm>
#include <utility>

namespace pliant {

namespace {

bool is_equal(pli_vec3 a, pli_vec3 b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

// An awake object that may wake soft bodies, along its motion in the step.
bool is_moving(const btCollisionObject& object) {
    const btRigidBody* body = btRigidBody::upcast(&object);
    if (body == nullptr || !object.isActive() || !object.hasContactResponse()) { return false; }
    // One of mass 0 that was made kinematic has the flag of static ones too.
    if (!object.isKinematicObject()) { return !object.isStaticObject(); }
    return !body->getLinearVelocity().fuzzyZero() || !body->getAngularVelocity().fuzzyZero();
}

// Steps of motion that a kinematic body may be ahead of where soft bodies have met it.
constexpr btScalar kinematic_way_back = 4;

void get_swept_aabb(const btRigidBody& body, btScalar dt, btVector3& aabb_min, btVector3& aabb_max) {
    body.getAabb(aabb_min, aabb_max);
    const btVector3 motion = body.getLinearVelocity() * dt;
    const btScalar reach =
        (aabb_max - aabb_min).length() * btScalar(0.5) * btMin(btScalar(1), body.getAngularVelocity().length() * dt);
    const btVector3 turn(reach, reach, reach), none(0, 0, 0);
    btVector3 forth = motion, back = motion;
    if (body.isKinematicObject()) {
        // Bullet has moved it already, through all sub-steps of the frame. What rests on it goes along.
        forth.setMax(-motion * kinematic_way_back);
        back.setMin(-motion * kinematic_way_back);
    }
    forth.setMax(none);
    back.setMin(none);
    aabb_min += back - turn;
    aabb_max += forth + turn;
}

/// True while in scope.
struct ScopedFlag {
    explicit ScopedFlag(bool& of) : flag(of) { flag = true; }
    ~ScopedFlag() { flag = false; }
    ScopedFlag(const ScopedFlag&) = delete;
    ScopedFlag& operator=(const ScopedFlag&) = delete;
    bool& flag;
};

} // namespace

bool Bridge::Impl::is_inside_step() const {
    // Bullet sets the length of the step right before its collision detection; updateAction takes it back.
    return bullet_world_ != nullptr && bullet_world_->getDispatchInfo().m_timeStep > 0;
}

void Bridge::Impl::predict_inside_step() {
    if (!collects_pairs_ && is_inside_step() && !is_stepping()) {
        const ScopedFlag at_work(is_at_work_);
        begin_step(bullet_world_->getDispatchInfo().m_timeStep);
        show_holds(); // Bullet's solver is still to come
    }
}

void Bridge::Impl::follow_gravity() {
    if (!followed_gravity_) { return; }
    const pli_vec3 present = to_pli(bullet_world_->getGravity());
    if (is_equal(present, *followed_gravity_)) { return; }
    if (!is_equal(pli_world_get_gravity(world), *followed_gravity_)) {
        followed_gravity_.reset();
        return;
    }
    const pli_status result = pli_world_set_gravity(world, present);
    note(result);
    if (result == PLI_OK) { followed_gravity_ = present; }
}

// What a game does to a soft object's transform moves the body.
void Bridge::Impl::follow_transforms() {
    for (const auto& object : objects_) {
        if (!object->is_moved()) { continue; }
        const btTransform moved = object->getWorldTransform();
        object->setWorldTransform(btTransform::getIdentity());
        note(pli_body_transform(object->body(), to_pli(moved)));
    }
}

void Bridge::Impl::begin_step(btScalar dt) {
    step_status = PLI_OK;
    followed_dt_ = mode == CollisionMode::reference ? 0 : dt;
    follow_gravity();
    follow_transforms();
    pin_held();
    look_for_pinned(dt);
    follow_world();
    bool is_any_asleep = false;
    for (const auto& object : objects_) {
        const bool should_rest = !object->isActive() || object->getWorldArrayIndex() < 0;
        if (should_rest || object->is_asleep || object->is_frozen_by_bridge) {
            follow_activation(*object, should_rest);
        }
        is_any_asleep = is_any_asleep || object->is_asleep;
    }
    if (is_any_asleep) {
        wake_left();
        wake_met(dt);
    }
    follow_kinematic();
    ++step_;
    note(pli_world_predict(world, to_float(dt)));
    collects_pairs_ = is_stepping();
}

// Bullet moves kinematic bodies to the end of the frame, and looks for pairs with them there. Before the prediction.
void Bridge::Impl::follow_kinematic() {
    const btCollisionObjectArray& array = bullet_world_->getCollisionObjectArray();
    kinematic_.clear();
    ahead_.clear();
    const int size = followed_dt_ > 0 ? array.size() : 0;
    for (int i = 0; i < size; ++i) {
        if (!array[i]->isKinematicObject()) { continue; }
        const auto found = proxies_.find(array[i]);
        if (found == proxies_.end() || found->second->is_let_go || !found->second->is_of(*array[i])) { continue; }
        RigidProxy& proxy = *found->second;
        kinematic_.push_back(&proxy);
        Ahead body;
        if (!proxy.comes_on(followed_dt_, body.low, body.high)) { continue; }
        array[i]->getCollisionShape()->getAabb(array[i]->getWorldTransform(), body.ahead_low, body.ahead_high);
        ahead_.push_back(body);
    }
}

void Bridge::Impl::reach_ahead(btVector3& low, btVector3& high) const {
    const btVector3 own_low = low, own_high = high;
    for (const Ahead& body : ahead_) {
        if (!TestAabbAgainstAabb2(own_low, own_high, body.low, body.high)) { continue; }
        high.setMax(body.ahead_low);
        low.setMin(body.ahead_high);
    }
}

void Bridge::Impl::update(btCollisionWorld& bullet_world, btScalar dt) {
    {
        const ScopedFlag at_work(is_at_work_);
        bullet_world.getDispatchInfo().m_timeStep = 0;
        hide_holds();
        // Nobody asked for bounds: no body is in the world, or Bullet detected no collisions.
        if (!is_stepping()) { begin_step(dt); }
        if (is_stepping()) {
            collide_pairs();
            finish_step();
        }
        if (detaches_after_step_) { leave_world(); }
    }
    if (ends_after_step_) { delete this; }
}

bool Bridge::Impl::end_later() {
    ends_after_step_ = is_at_work_;
    return is_at_work_;
}

// Threads took the pairs in any order, and where an order is wanted that of the broad phase depends on what was before;
// the objects' places in the world do not.
void Bridge::Impl::sort_pairs() {
    std::sort(pairs_.begin(), pairs_.end(), [](const PairAlgorithm* a, const PairAlgorithm* b) {
        if (a == nullptr || b == nullptr) { return a != nullptr && b == nullptr; }
        const std::pair<int, int> place_a(a->soft.getWorldArrayIndex(), a->other.getWorldArrayIndex());
        const std::pair<int, int> place_b(b->soft.getWorldArrayIndex(), b->other.getWorldArrayIndex());
        return place_a < place_b;
    });
}

void Bridge::Impl::collide_pairs() {
    collects_pairs_ = false;
    if (pairs_.empty()) { return; }
    const bool is_ordered = bullet_world_->getDispatchInfo().m_deterministicOverlappingPairs;
    if (dispatches_in_parallel_ || is_ordered) { sort_pairs(); }
    if (mode == CollisionMode::reference) {
        collide_pairs_as_reference();
    } else {
        collide_rigid_pairs();
        body_pairs_.clear();
        for (const PairAlgorithm* pair : pairs_) {
            if (pair == nullptr || pair->other_soft == nullptr) { continue; }
            body_pairs_.push_back({pair->soft.body(), pair->other_soft->body()});
        }
        if (!body_pairs_.empty()) {
            note(pli_world_collide_body_pairs(world, body_pairs_.data(), static_cast<int>(body_pairs_.size())));
        }
    }
    for (PairAlgorithm* pair : pairs_) {
        if (pair != nullptr) { pair->collected_index = -1; }
    }
    pairs_.clear();
}

// One after the other, as Bullet comes to them. Some shapes depend on the soft body.
void Bridge::Impl::collide_pairs_as_reference() {
    const ShapeOptions options{context, mode, surface_thickness, nullptr};
    for (PairAlgorithm* pair : pairs_) {
        if (pair == nullptr) { continue; }
        if (pair->other_soft != nullptr) {
            note(pli_world_collide_bodies(world, pair->soft.body(), pair->other_soft->body()));
            continue;
        }
        RigidProxy& proxy = *pair->proxy;
        take_part(proxy);
        if (proxy.rigid() != nullptr) { note(proxy.collide(options, world, pair->soft.body(), pair->slabs)); }
    }
}

// By the places of their bodies in the Bullet world, and as they came.
void Bridge::Impl::sort_rigid_pairs() {
    sorted_pairs_.clear();
    for (std::size_t i = 0; i < rigid_pairs_.size(); ++i) {
        sorted_pairs_.push_back({places_[i], static_cast<int>(i), rigid_pairs_[i]});
    }
    std::sort(sorted_pairs_.begin(), sorted_pairs_.end(), [](const RigidPair& a, const RigidPair& b) {
        return a.place != b.place ? a.place < b.place : a.order < b.order;
    });
    std::transform(sorted_pairs_.begin(), sorted_pairs_.end(), rigid_pairs_.begin(),
                   [](const RigidPair& pair) { return pair.pair; });
}

// Body by body, so that threads can share them; mostly Bullet comes to them like that.
void Bridge::Impl::collide_rigid_pairs() {
    rigid_pairs_.clear();
    places_.clear();
    for (const PairAlgorithm* pair : pairs_) {
        if (pair == nullptr || pair->other_soft != nullptr) { continue; }
        RigidProxy& proxy = *pair->proxy;
        take_part(proxy);
        if (proxy.rigid() == nullptr) { continue; }
        const pli_status given = proxy.give_captured_state();
        note(given);
        if (given != PLI_OK) { continue; }
        rigid_pairs_.push_back({pair->soft.body(), proxy.rigid()});
        places_.push_back(pair->soft.getWorldArrayIndex());
    }
    if (rigid_pairs_.empty()) { return; }
    if (!std::is_sorted(places_.begin(), places_.end())) { sort_rigid_pairs(); }
    note(pli_world_collide_rigids(world, rigid_pairs_.data(), static_cast<int>(rigid_pairs_.size())));
}

// Brings a proxy up to date, once per step, and has it solved.
void Bridge::Impl::take_part(RigidProxy& proxy) {
    if (proxy.present_step == step_) { return; }
    proxy.present_step = step_;
    proxy.note_place();
    // Well before the core looks at it: what was just stored in parts is slow to read.
    proxy.read_present_state(followed_dt_);
    note(proxy.prepare({context, mode, surface_thickness, nullptr}, world));
    if (proxy.rigid() == nullptr) { return; }
    touched_.push_back(&proxy);
}

// Anchors need no contact to act.
void Bridge::Impl::take_part_of_pinned() {
    if (!has_pinned_) { return; }
    for (const auto& entry : proxies_) {
        RigidProxy& proxy = *entry.second;
        if (!proxy.is_pinned || !proxy.was_in_world || proxy.is_let_go) { continue; }
        // Actions may have removed it since the step began.
        if (proxy.find_in(bullet_world_->getCollisionObjectArray()) == RigidProxy::Place::here) {
            take_part(proxy);
        } else {
            let_go(proxy);
        }
    }
}

void Bridge::Impl::finish_step() {
    take_part_of_pinned();
    for (RigidProxy* proxy : touched_) {
        note(proxy->set_present_state());
    }
    if (before_solve) {
        before_solve();
        let_go_of_removed();
    }
    note(pli_world_solve(world));
    let_go_of_removed(); // the solve calls joint controllers and the profile
    for (RigidProxy* proxy : touched_) {
        if (!proxy->is_let_go && proxy->write_back(step_, followed_dt_)) { has_holds_ = true; }
    }
    touched_.clear();
    for (RigidProxy* proxy : kinematic_) {
        const bool is_met = proxy->present_step == step_ || proxy->is_let_go;
        if (!is_met && proxy->find_in(bullet_world_->getCollisionObjectArray()) == RigidProxy::Place::here) {
            proxy->go_along(followed_dt_);
        }
    }
    ahead_.clear();
    for (pli_body* body : std::exchange(bodies_to_end_, {})) {
        pli_body_destroy(body);
    }
    offer_sleep();
    finish_let_go();
    sweep_proxies();
}

// ---------------------------------------------------------------------------------------------------------- holds

void Bridge::Impl::find_loaded() {
    loaded_.assign(static_cast<std::size_t>(bullet_world_->getNumCollisionObjects()), false);
    const auto note_load = [this](const btCollisionObject& object) {
        const auto place = static_cast<std::size_t>(object.getWorldArrayIndex());
        if (place < loaded_.size()) { loaded_[place] = true; } // Bullet's fixed body, and other worlds' have none here
    };
    btDispatcher& dispatcher = *bullet_world_->getDispatcher();
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
        if (manifold.getNumContacts() == 0) { continue; }
        note_load(*manifold.getBody0());
        note_load(*manifold.getBody1());
    }
    for (int i = 0; i < bullet_world_->getNumConstraints(); ++i) {
        const btTypedConstraint& joint = *bullet_world_->getConstraint(i);
        note_load(joint.getRigidBodyA());
        note_load(joint.getRigidBodyB());
    }
}

// Of the step that has ended, in Bullet's order of objects.
void Bridge::Impl::show_holds() {
    if (!has_holds_) { return; }
    has_holds_ = false;
    if (bullet_world_->getDispatcher()->getNumManifolds() + bullet_world_->getNumConstraints() == 0) { return; }
    find_loaded();
    const btCollisionObjectArray& objects = bullet_world_->getCollisionObjectArray();
    for (const auto& entry : proxies_) {
        RigidProxy& proxy = *entry.second;
        if (proxy.hold_of(step_ - 1) == nullptr || proxy.is_let_go) { continue; }
        if (proxy.find_in(objects) != RigidProxy::Place::here || proxy.object()->isStaticOrKinematicObject()) {
            continue;
        }
        if (loaded_[static_cast<std::size_t>(proxy.object()->getWorldArrayIndex())]) { held_.push_back(&proxy); }
    }
    std::sort(held_.begin(), held_.end(), [](const RigidProxy* a, const RigidProxy* b) {
        return a->object()->getWorldArrayIndex() < b->object()->getWorldArrayIndex();
    });
    for (RigidProxy* proxy : held_) {
        proxy->hold().begin_step();
        ConstraintList::of(*bullet_world_).push_back(&proxy->hold());
    }
}

void Bridge::Impl::hide_holds() {
    if (held_.empty()) { return; } // between steps the world may be gone
    const btCollisionObjectArray& objects = bullet_world_->getCollisionObjectArray();
    for (RigidProxy* proxy : held_) {
        ConstraintList::of(*bullet_world_).remove(&proxy->hold());
        const bool is_here = !proxy->is_let_go && proxy->find_in(objects) == RigidProxy::Place::here;
        if (is_here && !proxy->object()->isStaticOrKinematicObject()) { proxy->take_back_hold(); }
    }
    held_.clear();
}

// ---------------------------------------------------------------------------------------------------------- sleep

// Bullet's islands decide what sleeps. A soft body that rests lets its object want to; what Bullet puts to sleep or
// wakes does so in the core, and the other way round.

// Before the prediction.
void Bridge::Impl::follow_activation(SoftObject& object, bool should_rest) {
    pli_body* body = object.body();
    bool may_sleep = object.wants_sleep && object.getWorldArrayIndex() >= 0;
    if (should_rest && may_sleep && !object.is_frozen_by_bridge) {
        if (object.is_asleep ? pli_body_is_asleep(body) : pli_body_is_resting(body)) {
            if (!object.is_asleep) { note(pli_body_set_asleep(body, true)); }
            object.is_asleep = true;
            return;
        }
        wake(object); // a call has changed it
        should_rest = !object.isActive();
        may_sleep = false;
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
    const btCollisionObjectArray& array = bullet_world_->getCollisionObjectArray();
    for (int i = 0; i < array.size(); ++i) {
        if (!is_moving(*array[i])) { continue; }
        const FollowedObject mover(*array[i]);
        const bool is_kinematic = array[i]->isKinematicObject();
        btVector3 low, high;
        get_swept_aabb(*btRigidBody::upcast(array[i]), dt, low, high);
        for (const auto& object : objects_) {
            if (!object->is_asleep) { continue; }
            const pli_bounds bounds = pli_body_get_bounds(object->body());
            // What rests on a lift is a margin from it, and its bounds touch it up to rounding.
            const btScalar near = is_kinematic ? object->getCollisionShape()->getMargin() / 4 : btScalar(0);
            const btVector3 around(near, near, near);
            if (!TestAabbAgainstAabb2(low, high, to_bullet(bounds.min) - around, to_bullet(bounds.max) + around)) {
                continue;
            }
            const FollowedObject own(*object);
            if ((mover.group & own.mask) != 0 && (own.group & mover.mask) != 0) { wake(*object); }
        }
    }
}

// Bullet's islands know nothing of static and kinematic objects: those that what has fallen asleep has pairs with.
void Bridge::Impl::look_for_grounds() {
    const auto look = [this](const btBroadphaseProxy* own, const btBroadphaseProxy* other) {
        auto* object = static_cast<btCollisionObject*>(own->m_clientObject);
        const auto* ground = static_cast<const btCollisionObject*>(other->m_clientObject);
        const SoftObject* soft = SoftObject::from(object);
        if (soft == nullptr || &soft->bridge() != this || !soft->is_asleep || soft->has_grounds) { return; }
        const auto found = proxies_.find(ground);
        if (found == proxies_.end() || found->second->rigid() == nullptr || !ground->isStaticOrKinematicObject()) {
            return;
        }
        static_cast<SoftObject*>(object)->grounds.push_back(ground);
    };
    const btBroadphasePairArray& pairs = bullet_world_->getPairCache()->getOverlappingPairArray();
    for (int i = 0; i < pairs.size(); ++i) {
        look(pairs[i].m_pProxy0, pairs[i].m_pProxy1);
        look(pairs[i].m_pProxy1, pairs[i].m_pProxy0);
    }
    for (const auto& object : objects_) {
        object->has_grounds = object->is_asleep;
    }
}

// What sleeps on an object that goes away, or that is a sensor now.
void Bridge::Impl::wake_left() {
    bool are_known = true;
    for (const auto& object : objects_) {
        if (object->is_asleep && object->has_grounds) { continue; }
        object->has_grounds = false;
        object->grounds.clear();
        are_known = are_known && !object->is_asleep;
    }
    if (!are_known) { look_for_grounds(); }
    for (const auto& object : objects_) {
        const bool is_left = std::any_of(object->grounds.begin(), object->grounds.end(), [this](const auto* ground) {
            const auto found = proxies_.find(ground);
            if (found == proxies_.end()) { return true; }
            const RigidProxy& proxy = *found->second;
            // A pair with it, or a look at the world's list in this step, shows that it is alive.
            const bool is_alive = (proxy.pair_count > 0 || proxy.is_followed) && !proxy.is_let_go;
            return !is_alive || !proxy.is_of(*ground) || proxy.has_changed(followed_dt_);
        });
        if (is_left) { wake(*object); }
    }
}

// After the solve.
void Bridge::Impl::offer_sleep() {
    for (const auto& object : objects_) {
        if (object->getWorldArrayIndex() < 0 || object->is_asleep) { continue; }
        bool is_resting = pli_body_is_resting(object->body());
        if (is_resting) {
            object->for_each_held([&](const btCollisionObject& held) {
                is_resting = is_resting && held.getIslandTag() == object->getIslandTag();
            });
        }
        if (is_resting != object->wants_sleep) {
            object->setActivationState(is_resting ? WANTS_DEACTIVATION : ACTIVE_TAG);
        }
        object->wants_sleep = is_resting;
    }
}

// ------------------------------------------------------------------------------------------------------- drawing

// Bodies with faces are drawn by Bullet; those without would be invisible.
void Bridge::Impl::debug_draw(btIDebugDraw* drawer) {
    if (drawer == nullptr || (drawer->getDebugMode() & btIDebugDraw::DBG_DrawWireframe) == 0) { return; }
    for (const auto& object : objects_) {
        const pli_body_view view = pli_body_get_view(object->body());
        if (view.face_count > 0) { continue; }
        for (int i = 0; i < view.link_count; ++i) {
            const int* nodes = view.link_nodes + i * view.link_node_stride;
            const pli_vec4& a = view.positions[nodes[0]];
            const pli_vec4& b = view.positions[nodes[1]];
            drawer->drawLine(to_bullet(pli_vec3_make(a.x, a.y, a.z)), to_bullet(pli_vec3_make(b.x, b.y, b.z)),
                             btVector3(1, 1, 1));
        }
    }
}

} // namespace pliant
