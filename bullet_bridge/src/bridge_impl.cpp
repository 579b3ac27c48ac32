#include "bridge_impl.h"

#include "bridge_action.h"
#include "convert.h"
#include "pair_algorithm.h"
#include "rigid_proxy.h"
#include "soft_object.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <LinearMath/btIDebugDraw.h>

#include <algorithm>
#include <new>

namespace pliant {

Bridge::Impl::Impl(btDiscreteDynamicsWorld& bullet_world, const BridgeDef& def)
    : mode(def.mode), surface_thickness(def.surface_thickness), context(def.context), bullet_world_(&bullet_world),
      prepares_ahead_(def.prepares_rigids_ahead) {
    if (context == nullptr) {
        status = pli_context_create(nullptr, &context);
        owns_context_ = status == PLI_OK;
    }
    if (status == PLI_OK && !(surface_thickness > 0.0f)) { status = PLI_ERROR_INVALID_VALUE; }
    pli_world_def world_def = def.world;
    if (def.mode == CollisionMode::reference) { world_def.as_bullet = true; }
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
    detach();
    objects_.clear();
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
    if (bullet_world_ == nullptr || bullet_world_state() == WorldState::gone) { return PLI_ERROR_WRONG_STATE; }
    pli_body* made = nullptr;
    const pli_status result = pli_body_create(world, mesh, def, body != nullptr ? &made : nullptr);
    if (result != PLI_OK) { return result; }
    try {
        objects_.push_back(std::make_unique<SoftObject>(*this, made));
    } catch (const std::bad_alloc&) {
        pli_body_destroy(made);
        return PLI_ERROR_OUT_OF_MEMORY;
    }
    bullet_world_->addCollisionObject(objects_.back().get(), group, mask);
    look_for_new_pinned();
    *body = made;
    return PLI_OK;
}

pli_status Bridge::Impl::remove_body(pli_body* body) {
    if (status != PLI_OK || body == nullptr) { return status; }
    if (is_stepping()) { return PLI_ERROR_WRONG_STATE; }
    const auto place =
        std::find_if(objects_.begin(), objects_.end(), [body](const auto& object) { return object->body() == body; });
    if (place == objects_.end()) { return PLI_ERROR_INVALID_VALUE; }
    const bool is_in_world = bullet_world_ != nullptr && (*place)->getBroadphaseHandle() != nullptr;
    if (is_in_world) { bullet_world_->removeCollisionObject(place->get()); }
    objects_.erase(place);
    pli_body_destroy(body);
    return PLI_OK;
}

SoftObject* Bridge::Impl::find(const pli_body* body) const {
    for (const auto& object : objects_) {
        if (object->body() == body) { return object.get(); }
    }
    return nullptr;
}

// ------------------------------------------------------------------------------------------------------ proxies

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
    if (is_stepping()) {
        has_unused_proxies_ = has_unused_proxies_ || !proxy.is_needed();
        // Its contacts have been made, and some ask shapes when they are solved.
        if (proxy.pair_count == 0 && proxy.present_step == step_) { proxy.let_go_of_shapes(); }
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
    if (pair.proxy != nullptr && !pair.proxy->is_captured(step_)) { pair.proxy->capture(step_); }
}

const RigidProxy* Bridge::Impl::find_proxy(const pli_rigid& rigid) const {
    for (const auto& [object, proxy] : proxies_) {
        if (proxy->rigid() == &rigid) { return proxy.get(); }
    }
    return nullptr;
}

pli_rigid* Bridge::Impl::pin_proxy(const btCollisionObject& object) {
    if (status != PLI_OK || bullet_world_ == nullptr || is_stepping()) { return nullptr; }
    if (object.getCollisionShape() == nullptr) { return nullptr; }
    const std::unique_ptr<RigidProxy>& proxy = proxy_of(object);
    if (proxy->prepare({context, mode, surface_thickness, nullptr}, world) != PLI_OK && proxy->rigid() == nullptr) {
        if (!proxy->is_needed()) { proxies_.erase(&object); }
        return nullptr;
    }
    proxy->read_present_state();
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
    if (bullet_world_ == nullptr || is_stepping()) { return PLI_ERROR_WRONG_STATE; }
    const btCollisionShape* shape = object.getCollisionShape();
    if (shape == nullptr || !has_triangles(*shape)) { return PLI_ERROR_INVALID_VALUE; }
    const std::unique_ptr<RigidProxy>& proxy = proxy_of(object);
    const bool was_known = proxy->rigid() != nullptr || proxy->is_needed();
    const ShapeOptions options{context, mode, surface_thickness, nullptr};
    const std::optional<pli_sampled_mesh_def> before = proxy->sampled_mesh();
    proxy->use_sampled_mesh(def);
    const pli_status result = proxy->prepare(options, world);
    if (result == PLI_OK) {
        proxy->read_present_state();
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
void Bridge::Impl::look_for_pinned() {
    if (!has_pinned_) { return; }
    has_pinned_ = std::any_of(proxies_.begin(), proxies_.end(), [](const auto& e) { return e.second->is_pinned; });
    look_for_new_pinned();
    for (const auto& entry : proxies_) {
        RigidProxy& proxy = *entry.second;
        if (!proxy.is_pinned || !proxy.was_in_world || proxy.is_let_go) { continue; }
        const RigidProxy::Place place = proxy.find_in(bullet_world_->getCollisionObjectArray());
        if (place != RigidProxy::Place::here) { let_go(proxy); }
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
    : object(&of), type(of.getInternalType()), id(-1), group(0), mask(0) {
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
    if (is_soft || !object.hasContactResponse() || object.getCollisionShape() == nullptr) { return; }
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
    pairs_.reserve(std::min(softs * all, pairs_per_object * all));
    touched_.reserve(proxies_.size());
}

// --------------------------------------------------------------------------------------------------------- step

bool Bridge::Impl::is_inside_step() const {
    // Bullet sets the length of the step right before its collision detection; updateAction takes it back.
    return bullet_world_ != nullptr && bullet_world_->getDispatchInfo().m_timeStep > 0;
}

void Bridge::Impl::predict_inside_step() {
    if (is_inside_step() && !is_stepping()) { begin_step(bullet_world_->getDispatchInfo().m_timeStep); }
}

void Bridge::Impl::begin_step(btScalar dt) {
    step_status = PLI_OK;
    look_for_pinned();
    follow_world();
    for (const auto& object : objects_) {
        const bool should_rest = !object->isActive() || object->getWorldArrayIndex() < 0;
        if (should_rest != object->frozen_by_bridge && should_rest != pli_body_is_frozen(object->body())) {
            pli_body_set_frozen(object->body(), should_rest);
            object->frozen_by_bridge = should_rest;
        }
    }
    ++step_;
    note(pli_world_predict(world, to_float(dt)));
    collects_pairs_ = is_stepping();
}

void Bridge::Impl::update(btCollisionWorld& bullet_world, btScalar dt) {
    bullet_world.getDispatchInfo().m_timeStep = 0;
    // Nobody asked for bounds: no body is in the world, or Bullet detected no collisions.
    if (!is_stepping()) { begin_step(dt); }
    if (!is_stepping()) { return; }
    collide_pairs();
    finish_step(dt);
}

void Bridge::Impl::collide_pairs() {
    collects_pairs_ = false;
    if (dispatches_in_parallel_) {
        // Threads took the pairs in any order; the objects' places in the world do not depend on them.
        std::sort(pairs_.begin(), pairs_.end(), [](const PairAlgorithm* a, const PairAlgorithm* b) {
            if (a == nullptr || b == nullptr) { return a != nullptr && b == nullptr; }
            const std::pair<int, int> place_a(a->soft.getWorldArrayIndex(), a->other.getWorldArrayIndex());
            const std::pair<int, int> place_b(b->soft.getWorldArrayIndex(), b->other.getWorldArrayIndex());
            return place_a < place_b;
        });
    }
    const ShapeOptions options{context, mode, surface_thickness, nullptr};
    for (PairAlgorithm* pair : pairs_) {
        if (pair == nullptr) { continue; }
        pair->collected_index = -1;
        if (pair->other_soft != nullptr) {
            note(pli_world_collide_bodies(world, pair->soft.body(), pair->other_soft->body()));
            continue;
        }
        RigidProxy& proxy = *pair->proxy;
        take_part(proxy);
        if (proxy.rigid() != nullptr) { note(proxy.collide(options, world, pair->soft.body(), pair->slabs)); }
    }
    pairs_.clear();
}

// Brings a proxy up to date, once per step, and has it solved.
void Bridge::Impl::take_part(RigidProxy& proxy) {
    if (proxy.present_step == step_) { return; }
    proxy.present_step = step_;
    proxy.note_place();
    proxy.read_present_state(); // well before the core looks at it: what was just stored in parts is slow to read
    note(proxy.prepare({context, mode, surface_thickness, nullptr}, world));
    if (proxy.rigid() != nullptr) { touched_.push_back(&proxy); }
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

void Bridge::Impl::finish_step(btScalar dt) {
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
        if (!proxy->is_let_go) { proxy->write_back(dt); }
    }
    touched_.clear();
    finish_let_go();
    sweep_proxies();
}

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
