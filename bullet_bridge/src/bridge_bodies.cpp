// How a bridge begins and ends, and its soft bodies.

#include "accumulator.h"
#include "bridge_action.h"
#include "bridge_impl.h"
#include "convert.h"
#include "pair_algorithm.h"
#include "rigid_proxy.h"
#include "soft_object.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <algorithm>
#include <new>
#include <string>
#include <utility>

namespace pliant {

Bridge::Impl::Impl(btDiscreteDynamicsWorld& bullet_world, const BridgeDef& def)
    : mode(def.mode), surface_thickness(def.surface_thickness), context(def.context), bullet_world_(&bullet_world),
      prepares_ahead_(def.prepares_rigids_ahead) {
    if (context == nullptr) {
        status = pli_context_create(nullptr, &context);
        owns_context_ = status == PLI_OK;
    }
    const bool has_thickness = surface_thickness > 0.0f && surface_thickness <= PLI_MAX_COORDINATE;
    if (status == PLI_OK && !has_thickness) {
        status = fail(PLI_ERROR_INVALID_VALUE, "pliant::Bridge",
                      ("surface_thickness is " + std::to_string(surface_thickness) +
                       ", it has to be above 0 and at most PLI_MAX_COORDINATE")
                          .c_str());
    }
    pli_world_def world_def = def.world;
    world_def.gravity = def.gravity.value_or(to_pli(bullet_world.getGravity()));
    if (!def.gravity) { followed_gravity_ = world_def.gravity; }
    if (def.mode == CollisionMode::reference) { world_def.reference_mode = true; }
    world_def.host_puts_to_sleep = true;
    if (status == PLI_OK) { status = pli_world_create(context, &world_def, &world); }
    if (status != PLI_OK) {
        bullet_world_ = nullptr;
        return;
    }
    auto* dispatcher = dynamic_cast<btCollisionDispatcher*>(bullet_world.getDispatcher());
    if (dispatcher != nullptr) { register_pair_algorithm(*dispatcher); }
    dispatches_in_parallel_ = dynamic_cast<btCollisionDispatcherMt*>(dispatcher) != nullptr;
    // A length of step left over from an earlier step would look like a step in progress.
    bullet_world.getDispatchInfo().m_timeStep = 0;
    BridgeAction::take_left_out_of(bullet_world);
    action_ = std::make_unique<BridgeAction>(*this);
    bullet_world.addAction(action_.get());
}

Bridge::Impl::~Impl() {
    leave_world();
    std::exchange(objects_, {}).clear(); // whose destructors look for themselves in the list
    proxies_.clear();
    replaced_.clear();
    pli_world_destroy(world);
    if (owns_context_) { pli_context_destroy(context); }
}

// btCollisionWorld's destructor takes the broadphase handle from its objects and leaves their index. It tells nobody
// else.
Bridge::Impl::WorldState Bridge::Impl::bullet_world_state() const {
    for (const auto& object : objects_) {
        if (object->getWorldArrayIndex() < 0) { continue; }
        return object->getBroadphaseHandle() != nullptr ? WorldState::alive : WorldState::gone;
    }
    return WorldState::unknown;
}

void Bridge::Impl::detach() {
    if (bullet_world_ == nullptr) { return; }
    // Bullet and the core are at work with what would go.
    detaches_after_step_ = is_stepping() || (bullet_world_state() == WorldState::alive && is_inside_step());
    if (!detaches_after_step_) { leave_world(); }
}

void Bridge::Impl::leave_world() {
    if (bullet_world_ == nullptr) { return; }
    hide_holds();
    switch (bullet_world_state()) {
    case WorldState::alive:
        bullet_world_->removeAction(action_.get());
        for (const auto& object : objects_) {
            if (object->getWorldArrayIndex() >= 0) { bullet_world_->removeCollisionObject(object.get()); }
        }
        break;
    case WorldState::gone:
        break;
    case WorldState::unknown:
        BridgeAction::leave_in(*bullet_world_, std::move(action_));
        break;
    }
    action_.reset();
    bullet_world_ = nullptr;
}

// ------------------------------------------------------------------------------------------------------ bodies

pli_status Bridge::Impl::add_body(const pli_mesh* mesh, const pli_body_def* def, pli_body** body, int group, int mask) {
    if (status != PLI_OK) { return status; }
    const char* const function = "pliant::Bridge::add_body";
    if (bullet_world_ == nullptr || bullet_world_state() == WorldState::gone) {
        return fail(PLI_ERROR_WRONG_STATE, function, "the bridge has left its Bullet world, or that is gone");
    }
    pli_body* made = nullptr;
    pli_status result = pli_body_create(world, mesh, def, body != nullptr ? &made : nullptr);
    if (result != PLI_OK) { return result; }
    if (mode == CollisionMode::exact) {
        result = pli_body_enable_colored_links(made);
        if (result != PLI_OK) {
            pli_body_destroy(made);
            return result;
        }
    }
    try {
        objects_.push_back(std::make_unique<SoftObject>(*this, made));
    } catch (const std::bad_alloc&) {
        pli_body_destroy(made);
        return fail(PLI_ERROR_OUT_OF_MEMORY, function, "no memory for a collision object");
    }
    bullet_world_->addCollisionObject(objects_.back().get(), group, mask);
    look_for_new_pinned();
    *body = made;
    return PLI_OK;
}

pli_status Bridge::Impl::remove_body(pli_body* body) {
    if (status != PLI_OK || body == nullptr) { return status; }
    const char* const function = "pliant::Bridge::remove_body";
    if (is_stepping()) { return fail(PLI_ERROR_WRONG_STATE, function, "not allowed inside of a step"); }
    const auto place =
        std::find_if(objects_.begin(), objects_.end(), [body](const auto& object) { return object->body() == body; });
    if (place == objects_.end()) {
        return fail(PLI_ERROR_INVALID_VALUE, function, "the body is not one of this bridge");
    }
    const bool is_in_world = bullet_world_ != nullptr && (*place)->getBroadphaseHandle() != nullptr;
    if (is_in_world) { bullet_world_->removeCollisionObject(place->get()); }
    const std::unique_ptr<SoftObject> object = std::move(*place); // which finds no body to end
    objects_.erase(place);
    pli_body_destroy(body);
    return PLI_OK;
}

void Bridge::Impl::end_body_of(const SoftObject& object) {
    const auto place =
        std::find_if(objects_.begin(), objects_.end(), [&](const auto& own) { return own.get() == &object; });
    if (place == objects_.end()) { return; }
    (void)place->release();
    objects_.erase(place);
    if (is_stepping()) {
        bodies_to_end_.push_back(object.body());
    } else {
        pli_body_destroy(object.body());
    }
}

float Bridge::Impl::interpolation() const {
    if (bullet_world_ == nullptr || bullet_world_state() != WorldState::alive) { return 1; }
    const btScalar step = Accumulator::step(*bullet_world_);
    if (!(step > 0)) { return 1; }
    // Bullet goes outside after a negative or endless time to step.
    const float share = std::min(1.0f, std::max(0.0f, to_float(Accumulator::time(*bullet_world_) / step)));
    return bullet_world_->getLatencyMotionStateInterpolation() ? share : 1 + share;
}

btDiscreteDynamicsWorld* Bridge::Impl::bullet_world_between_steps() const {
    const bool is_alive = bullet_world_ != nullptr && bullet_world_state() == WorldState::alive;
    return is_alive && !is_stepping() && !is_inside_step() ? bullet_world_ : nullptr;
}

void Bridge::Impl::save_knowledge(Knowledge& knowledge) {
    follow_transforms();
    follow_world();
    knowledge.followed_gravity = followed_gravity_;
    knowledge.activations.clear();
    for (const auto& object : objects_) {
        knowledge.activations.push_back({object->is_frozen_by_bridge, object->wants_sleep, object->is_asleep});
    }
    const btCollisionObjectArray& array = bullet_world_->getCollisionObjectArray();
    knowledge.holds.assign(static_cast<std::size_t>(array.size()), Hold{});
    for (int i = 0; i < array.size() && has_holds_; ++i) {
        const auto found = proxies_.find(array[i]);
        if (found == proxies_.end() || found->second->hold_of(step_) == nullptr) { continue; }
        knowledge.holds[static_cast<std::size_t>(i)] = found->second->hold_of(step_)->hold;
    }
}

void Bridge::Impl::restore_knowledge(const Knowledge& knowledge) {
    followed_gravity_ = knowledge.followed_gravity;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
        const Knowledge::Activation& activation = knowledge.activations[i];
        objects_[i]->is_frozen_by_bridge = activation.is_frozen_by_bridge;
        objects_[i]->wants_sleep = activation.wants_sleep;
        objects_[i]->is_asleep = activation.is_asleep;
        objects_[i]->has_grounds = false;
    }
    for (const auto& entry : proxies_) {
        entry.second->follow_restored();
    }
    ++step_; // no hold is of this one
    has_holds_ = false;
    const btCollisionObjectArray& array = bullet_world_->getCollisionObjectArray();
    for (int i = 0; i < array.size(); ++i) {
        const Hold& hold = knowledge.holds[static_cast<std::size_t>(i)];
        const auto found = proxies_.find(array[i]);
        if ((hold.force.isZero() && hold.torque.isZero()) || found == proxies_.end()) { continue; }
        found->second->set_hold(hold, step_);
        has_holds_ = true;
    }
}

SoftObject* Bridge::Impl::find(const pli_body* body) const {
    for (const auto& object : objects_) {
        if (object->body() == body) { return object.get(); }
    }
    return nullptr;
}

} // namespace pliant
