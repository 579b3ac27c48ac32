// Which objects of the Bullet world have a rigid body in the core, and for how long.

#include "bridge_impl.h"
#include "pair_algorithm.h"
#include "rigid_proxy.h"
#include "soft_object.h"

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <algorithm>

namespace pliant {

// Of an object that lives; another one may have been at its address before.
std::unique_ptr<RigidProxy>& Bridge::Impl::proxy_of(const btCollisionObject& object) {
    std::unique_ptr<RigidProxy>& proxy = proxies_[&object];
    if (proxy && !proxy->is_of(object)) {
        let_go(*proxy);
        replaced_.push_back(std::move(proxy));
    }
    if (proxy && proxy->is_let_go && !is_stepping()) { proxy->reset(); }
    if (!proxy) { proxy = std::make_unique<RigidProxy>(object); }
    return proxy;
}

RigidProxy* Bridge::Impl::acquire_proxy(const btCollisionObject& object) {
    const std::lock_guard<std::mutex> lock(mutex_);
    RigidProxy* proxy = proxy_of(object).get();
    ++proxy->pair_count;
    return proxy;
}

void Bridge::Impl::drop(PairAlgorithm& pair) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (pair.collected_index >= 0) { pairs_[static_cast<std::size_t>(pair.collected_index)] = nullptr; }
    if (pair.proxy == nullptr) { return; }
    RigidProxy& proxy = *pair.proxy;
    proxy.pair_count -= 1;
    // The object may be about to be deleted, and another one to come to its address. Inside a step the core cannot let
    // go of it; then the end of the step does.
    // Broad phases of axes end pairs while bounds are brought up to date, some before the prediction.
    if (is_stepping() || is_inside_step() || is_restoring_) {
        has_unused_proxies_ = has_unused_proxies_ || !proxy.is_needed();
        // Its contacts have been made, and some ask shapes when they are solved.
        if (is_stepping() && proxy.pair_count == 0 && proxy.present_step == step_) { proxy.let_go_of_shapes(); }
        return;
    }
    // Outside of a step pairs end with an object that leaves the world.
    proxy.is_followed = false;
    followed_.clear();
    if (!proxy.is_needed() && !proxy.is_let_go) { proxies_.erase(proxy.object()); }
}

void Bridge::Impl::collect(PairAlgorithm& pair) {
    std::unique_lock<std::mutex> lock(mutex_, std::defer_lock);
    if (dispatches_in_parallel_) { lock.lock(); }
    // Bullet's collision detection may be asked for at other times; contacts have no use then.
    if (!collects_pairs_ || pair.collected_index >= 0) { return; }
    if (pair.proxy != nullptr && pair.proxy->is_let_go) { return; }
    // As with what a rope is tied to.
    if (pair.proxy != nullptr && pli_body_ignores_rigid(pair.soft.body(), pair.proxy->rigid())) { return; }
    pair.collected_index = static_cast<int>(pairs_.size());
    pairs_.push_back(&pair);
    if (pair.proxy != nullptr && !pair.proxy->is_captured(step_)) { pair.proxy->capture(step_, followed_dt_); }
}

const RigidProxy* Bridge::Impl::find_proxy(const pli_rigid& rigid) const {
    for (const auto& [object, proxy] : proxies_) {
        if (proxy->rigid() == &rigid) { return proxy.get(); }
    }
    return nullptr;
}

// Null for a rigid body that the game has made in the core's world, with user data of its own.
RigidProxy* Bridge::Impl::living_proxy(const pli_rigid& rigid) const {
    const auto found = proxies_.find(static_cast<const btCollisionObject*>(pli_rigid_get_user_data(&rigid)));
    if (found == proxies_.end()) { return nullptr; }
    RigidProxy& proxy = *found->second;
    if (proxy.rigid() != &rigid || proxy.is_let_go) { return nullptr; }
    const bool is_here = proxy.find_in(bullet_world_->getCollisionObjectArray()) == RigidProxy::Place::here;
    return is_here ? &proxy : nullptr;
}

const btCollisionObject* Bridge::Impl::living_object(const pli_rigid& rigid) const {
    const RigidProxy* proxy = living_proxy(rigid);
    return proxy != nullptr ? proxy->object() : nullptr;
}

pli_rigid* Bridge::Impl::known_rigid(const btCollisionObject& object) const {
    const auto found = proxies_.find(&object);
    return found != proxies_.end() ? found->second->rigid() : nullptr;
}

pli_rigid* Bridge::Impl::pin_proxy(const btCollisionObject& object) {
    if (status != PLI_OK) { return nullptr; }
    const char* const refusal = bullet_world_ == nullptr                ? "the bridge has left its Bullet world"
                                : is_stepping()                         ? "not allowed inside of a step"
                                : object.getCollisionShape() == nullptr ? "the object has no shape"
                                                                        : nullptr;
    if (refusal != nullptr) {
        (void)fail(PLI_ERROR_WRONG_STATE, "pliant::Bridge::rigid", refusal);
        return nullptr;
    }
    const std::unique_ptr<RigidProxy>& proxy = proxy_of(object);
    if (proxy->prepare({context, mode, surface_thickness, nullptr}, world) != PLI_OK && proxy->rigid() == nullptr) {
        if (!proxy->is_needed()) { proxies_.erase(&object); }
        return nullptr;
    }
    proxy->read_present_state(0);
    (void)proxy->set_present_state();
    pin(*proxy);
    return proxy->rigid();
}

void Bridge::Impl::pin(RigidProxy& proxy) {
    proxy.is_pinned = has_pinned_ = true;
    // The object lives now. Out of the world it begins anew.
    if (proxy.object()->getWorldArrayIndex() < 0) { proxy.was_in_world = false; }
    if (!proxy.was_in_world) { proxy.set_present(false); }
    if (bullet_world_state() == WorldState::alive) { look_for_new_pinned(); }
}

void Bridge::Impl::forget(const btCollisionObject& object) {
    const auto place = proxies_.find(&object);
    if (place == proxies_.end()) { return; }
    RigidProxy& proxy = *place->second;
    followed_.clear();
    if (is_stepping()) {
        let_go(proxy);
        return;
    }
    proxy.reset();
    if (!proxy.is_needed()) { proxies_.erase(place); }
}

void Bridge::Impl::refresh(const btCollisionObject& object) {
    const auto place = proxies_.find(&object);
    if (place != proxies_.end()) { place->second->refresh(); }
}

pli_status Bridge::Impl::use_sampled_mesh(const btCollisionObject& object, const pli_sampled_mesh_def& def) {
    if (status != PLI_OK) { return status; }
    const char* const function = "pliant::Bridge::use_sampled_mesh";
    if (bullet_world_ == nullptr) {
        return fail(PLI_ERROR_WRONG_STATE, function, "the bridge has left its Bullet world");
    }
    if (is_stepping()) { return fail(PLI_ERROR_WRONG_STATE, function, "not allowed inside of a step"); }
    const btCollisionShape* shape = object.getCollisionShape();
    if (shape == nullptr || !has_triangles(*shape)) {
        return fail(PLI_ERROR_INVALID_VALUE, function, "the object has no shape of triangles");
    }
    const std::unique_ptr<RigidProxy>& proxy = proxy_of(object);
    const bool was_known = proxy->rigid() != nullptr || proxy->is_needed();
    const ShapeOptions options{context, mode, surface_thickness, nullptr};
    const std::optional<pli_sampled_mesh_def> before = proxy->sampled_mesh();
    proxy->use_sampled_mesh(def);
    const pli_status result = proxy->prepare(options, world);
    if (result == PLI_OK) {
        proxy->read_present_state(0);
        pin(*proxy);
        return proxy->set_present_state();
    }
    if (!was_known) {
        proxies_.erase(&object);
        return result;
    }
    proxy->use_sampled_mesh(before);
    (void)proxy->prepare(options, world);
    return result;
}

// ------------------------------------------------------------------------------------- objects that leave the world

// Inside a step, or before the prediction: what was an anchor until now holds nothing in this step. It goes after the
// solve, so that the event is one of this step.
void Bridge::Impl::let_go(RigidProxy& proxy) {
    proxy.let_go();
    has_let_go_ = true;
    for (PairAlgorithm*& pair : pairs_) {
        if (pair == nullptr || pair->proxy != &proxy) { continue; }
        pair->collected_index = -1;
        pair = nullptr;
    }
}

// Anchors and joints of the game to a body that a contact event named, and not rigid().
void Bridge::Impl::pin_held() {
    for (const auto& object : objects_) {
        object->for_each_held_rigid([&](const pli_rigid& rigid) {
            RigidProxy* proxy = living_proxy(rigid);
            if (proxy == nullptr || proxy->is_pinned) { return; }
            proxy->is_pinned = proxy->was_in_world = has_pinned_ = true;
        });
    }
}

// Objects given to rigid() before they came into the world.
void Bridge::Impl::look_for_new_pinned() {
    for (const auto& entry : proxies_) {
        RigidProxy& proxy = *entry.second;
        if (!proxy.is_pinned || proxy.was_in_world || proxy.is_let_go) { continue; }
        const RigidProxy::Place place = proxy.find_in(bullet_world_->getCollisionObjectArray());
        if (place == RigidProxy::Place::not_here) { continue; }
        if (place == RigidProxy::Place::taken_by_another) {
            let_go(proxy);
            continue;
        }
        proxy.was_in_world = true;
        proxy.set_present(true);
    }
}

// Before the prediction.
void Bridge::Impl::look_for_pinned(btScalar dt) {
    if (!has_pinned_) { return; }
    has_pinned_ = std::any_of(proxies_.begin(), proxies_.end(), [](const auto& e) { return e.second->is_pinned; });
    look_for_new_pinned();
    for (const auto& entry : proxies_) {
        RigidProxy& proxy = *entry.second;
        if (!proxy.is_pinned || !proxy.was_in_world || proxy.is_let_go) { continue; }
        const RigidProxy::Place place = proxy.find_in(bullet_world_->getCollisionObjectArray());
        if (place != RigidProxy::Place::here) {
            let_go(proxy);
            continue;
        }
        // Anchors start from where the last step has left it. Bullet has moved kinematic bodies already; a game may
        // have put one elsewhere before the step.
        if (!proxy.is_dynamic() && !proxy.has_jumped(dt)) { continue; }
        note(proxy.set_start_state(mode, dt));
    }
}

// Between the parts of a step that run code of others.
void Bridge::Impl::let_go_of_removed() {
    const btCollisionObjectArray& objects = bullet_world_->getCollisionObjectArray();
    for (RigidProxy* proxy : touched_) {
        if (!proxy->is_let_go && proxy->find_in(objects) != RigidProxy::Place::here) { let_go(*proxy); }
    }
}

void Bridge::Impl::finish_let_go() {
    if (!has_let_go_) { return; }
    has_let_go_ = false;
    for (const auto& entry : proxies_) {
        if (entry.second->is_let_go) { entry.second->reset(); }
    }
    for (auto place = replaced_.begin(); place != replaced_.end();) {
        (*place)->drop_rigid();
        const bool is_in_use = (*place)->pair_count > 0;
        has_let_go_ = has_let_go_ || is_in_use;
        place = is_in_use ? std::next(place) : replaced_.erase(place);
    }
    has_unused_proxies_ = true;
}

void Bridge::Impl::sweep_proxies() {
    if (!has_unused_proxies_) { return; }
    has_unused_proxies_ = false;
    for (auto place = proxies_.begin(); place != proxies_.end();) {
        place = place->second->is_needed() ? std::next(place) : proxies_.erase(place);
    }
}

// ------------------------------------------------------------------------------------------- proxies made ahead

FollowedObject::FollowedObject(const btCollisionObject& of)
    : object(&of), type(of.getInternalType()), number(ObjectIdentity(of).number), id(-1), group(0), mask(0) {
    if (const btBroadphaseProxy* handle = of.getBroadphaseHandle()) {
        id = handle->getUid();
        group = handle->m_collisionFilterGroup;
        mask = handle->m_collisionFilterMask;
    }
}

// Looks whether the Bullet world holds what it held in the last step, and when it does not brings the proxies up to
// date.
void Bridge::Impl::follow_world() {
    if (!prepares_ahead_) { return; }
    const btCollisionObjectArray& array = bullet_world_->getCollisionObjectArray();
    const auto size = static_cast<std::size_t>(array.size());
    const auto is_known = [&](std::size_t i) { return followed_[i] == FollowedObject(*array[static_cast<int>(i)]); };
    std::size_t known = 0;
    while (known < size && known < followed_.size() && is_known(known)) {
        ++known;
    }
    if (known == size && size == followed_.size()) { return; }

    followed_.erase(followed_.begin() + static_cast<std::ptrdiff_t>(known), followed_.end());
    for (std::size_t i = known; i < size; ++i) {
        followed_.emplace_back(*array[static_cast<int>(i)]);
    }
    for (const auto& entry : proxies_) {
        entry.second->is_followed = false;
    }
    for (const FollowedObject& followed : followed_) {
        const bool meets = std::any_of(objects_.begin(), objects_.end(), [&](const auto& soft) {
            const FollowedObject own(*soft);
            return (followed.group & own.mask) != 0 && (own.group & followed.mask) != 0;
        });
        if (meets) { follow(*followed.object); }
    }
    has_unused_proxies_ = true;
    sweep_proxies();
    make_room();
}

void Bridge::Impl::follow(const btCollisionObject& object) {
    const int type = object.getInternalType();
    const bool is_soft = type == btCollisionObject::CO_SOFT_BODY || SoftObject::from(&object) != nullptr;
    if (is_soft || object.getCollisionShape() == nullptr) { return; } // sensors are met by contact events
    const int id = FollowedObject(object).id;
    std::unique_ptr<RigidProxy>& proxy = proxy_of(object);
    const bool was_away = proxy->rigid() != nullptr && proxy->followed_id != id && !proxy->is_needed();
    if (was_away) { proxy = std::make_unique<RigidProxy>(object); }
    proxy->is_followed = true;
    proxy->followed_id = id;
    // What is wrong with it is told when it is met.
    if (proxy->rigid() == nullptr) { (void)proxy->prepare({context, mode, surface_thickness, nullptr}, world); }
}

// For the lists of a step: few objects meet many others at a time.
void Bridge::Impl::make_room() {
    constexpr std::size_t pairs_per_object = 8;
    const std::size_t softs = objects_.size(), all = softs + proxies_.size();
    const std::size_t pairs = std::min(softs * all, pairs_per_object * all);
    pairs_.reserve(pairs);
    sorted_pairs_.reserve(pairs);
    rigid_pairs_.reserve(pairs);
    places_.reserve(pairs);
    body_pairs_.reserve(pairs);
    touched_.reserve(proxies_.size());
    held_.reserve(proxies_.size());
    loaded_.reserve(static_cast<std::size_t>(bullet_world_->getNumCollisionObjects()));
    ConstraintList::of(*bullet_world_).reserve(bullet_world_->getNumConstraints() + static_cast<int>(proxies_.size()));
}

} // namespace pliant
