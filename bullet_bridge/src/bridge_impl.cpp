#include "bridge_impl.h"

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
    bullet_world.addAction(this);
}

Bridge::Impl::~Impl() {
    detach();
    objects_.clear();
    proxies_.clear();
    pli_world_destroy(world);
    if (owns_context_) { pli_context_destroy(context); }
}

// btCollisionWorld's destructor takes the broadphase handle from its objects and leaves their index.
bool Bridge::Impl::bullet_world_is_gone() const {
    return std::any_of(objects_.begin(), objects_.end(), [](const auto& object) {
        return object->getWorldArrayIndex() >= 0 && object->getBroadphaseHandle() == nullptr;
    });
}

void Bridge::Impl::detach() {
    if (bullet_world_ == nullptr) { return; }
    if (!bullet_world_is_gone()) {
        bullet_world_->removeAction(this);
        for (const auto& object : objects_) {
            if (object->getWorldArrayIndex() >= 0) { bullet_world_->removeCollisionObject(object.get()); }
        }
    }
    bullet_world_ = nullptr;
}

// ------------------------------------------------------------------------------------------------------ bodies

pli_status Bridge::Impl::add_body(const pli_mesh* mesh, const pli_body_def* def, pli_body** body, int group, int mask) {
    if (status != PLI_OK) { return status; }
    if (bullet_world_ == nullptr) { return PLI_ERROR_WRONG_STATE; }
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

RigidProxy* Bridge::Impl::acquire_proxy(const btCollisionObject& object) {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::unique_ptr<RigidProxy>& proxy = proxies_[&object];
    if (!proxy) { proxy = std::make_unique<RigidProxy>(object); }
    ++proxy->pair_count;
    return proxy.get();
}

void Bridge::Impl::drop(PairAlgorithm& pair) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (pair.collected_index >= 0) { pairs_[static_cast<std::size_t>(pair.collected_index)] = nullptr; }
    if (pair.proxy == nullptr) { return; }
    pair.proxy->pair_count -= 1;
    // The object may be about to be deleted, and another one to come to its address. Inside a step the core cannot let
    // go of it; then the end of the step does.
    if (is_stepping()) {
        has_unused_proxies_ = has_unused_proxies_ || !pair.proxy->is_needed();
        return;
    }
    // Outside of a step pairs end with an object that leaves the world.
    pair.proxy->is_followed = false;
    followed_.clear();
    if (!pair.proxy->is_needed()) { proxies_.erase(pair.proxy->object()); }
}

void Bridge::Impl::collect(PairAlgorithm& pair) {
    std::unique_lock<std::mutex> lock(mutex_, std::defer_lock);
    if (dispatches_in_parallel_) { lock.lock(); }
    // Bullet's collision detection may be asked for outside of a step; contacts have no use then.
    if (!is_stepping() || pair.collected_index >= 0) { return; }
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
    std::unique_ptr<RigidProxy>& proxy = proxies_[&object];
    if (!proxy) { proxy = std::make_unique<RigidProxy>(object); }
    if (proxy->prepare({context, mode, surface_thickness, nullptr}, world) != PLI_OK && proxy->rigid() == nullptr) {
        if (!proxy->is_needed()) { proxies_.erase(&object); }
        return nullptr;
    }
    proxy->is_pinned = true;
    proxy->read_present_state();
    (void)proxy->set_present_state();
    return proxy->rigid();
}

void Bridge::Impl::forget(const btCollisionObject& object) {
    const auto place = proxies_.find(&object);
    if (place == proxies_.end() || is_stepping()) { return; }
    place->second->is_pinned = false;
    place->second->is_followed = false; // the object may be about to be deleted
    followed_.clear();
    if (!place->second->is_needed()) {
        proxies_.erase(place);
    } else {
        place->second->drop_rigid();
        place->second->use_sampled_mesh(std::nullopt);
    }
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
    const bool was_known = proxies_.count(&object) > 0;
    std::unique_ptr<RigidProxy>& proxy = proxies_[&object];
    if (!proxy) { proxy = std::make_unique<RigidProxy>(object); }
    const ShapeOptions options{context, mode, surface_thickness, nullptr};
    const std::optional<pli_sampled_mesh_def> before = proxy->sampled_mesh();
    proxy->use_sampled_mesh(def);
    const pli_status result = proxy->prepare(options, world);
    if (result == PLI_OK) {
        proxy->is_pinned = true;
        proxy->read_present_state();
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

// A pinned proxy whose object was removed from the world must not be read: the object may be deleted.
void Bridge::Impl::forget_removed_objects() {
    const btCollisionObjectArray& array = bullet_world_->getCollisionObjectArray();
    for (auto place = proxies_.begin(); place != proxies_.end();) {
        RigidProxy& proxy = *place->second;
        if (!proxy.is_pinned) {
            proxy.was_in_world = false;
            ++place;
            continue;
        }
        auto* object = const_cast<btCollisionObject*>(proxy.object()); // only to compare
        const int index = proxy.world_array_index;
        const bool is_where_it_was = index >= 0 && index < array.size() && array[index] == object;
        if (!is_where_it_was) {
            const int found = array.findLinearSearch(object);
            proxy.world_array_index = found < array.size() ? found : -1;
        }
        const bool has_left = proxy.was_in_world && proxy.world_array_index < 0;
        proxy.was_in_world = proxy.world_array_index >= 0;
        place = has_left && proxy.pair_count == 0 ? proxies_.erase(place) : std::next(place);
    }
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
    std::unique_ptr<RigidProxy>& proxy = proxies_[&object];
    const bool is_of_another = proxy && proxy->followed_id != id && !proxy->is_needed();
    if (!proxy || is_of_another) { proxy = std::make_unique<RigidProxy>(object); }
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
    forget_removed_objects();
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
}

void Bridge::Impl::updateAction(btCollisionWorld* bullet_world, btScalar dt) {
    bullet_world->getDispatchInfo().m_timeStep = 0;
    // Nobody asked for bounds: no body is in the world, or Bullet detected no collisions.
    if (!is_stepping()) { begin_step(dt); }
    if (!is_stepping()) { return; }
    collide_pairs();
    finish_step(dt);
}

void Bridge::Impl::collide_pairs() {
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
    proxy.read_present_state(); // well before the core looks at it: what was just stored in parts is slow to read
    note(proxy.prepare({context, mode, surface_thickness, nullptr}, world));
    if (proxy.rigid() != nullptr) { touched_.push_back(&proxy); }
}

void Bridge::Impl::finish_step(btScalar dt) {
    for (const auto& entry : proxies_) {
        // Anchors need no contact to act.
        if (entry.second->is_pinned && entry.second->world_array_index >= 0) { take_part(*entry.second); }
    }
    for (RigidProxy* proxy : touched_) {
        note(proxy->set_present_state());
    }
    if (before_solve) { before_solve(); }
    note(pli_world_solve(world));
    for (RigidProxy* proxy : touched_) {
        proxy->write_back(dt);
    }
    touched_.clear();
    sweep_proxies();
}

// Bodies with faces are drawn by Bullet; those without would be invisible.
void Bridge::Impl::debugDraw(btIDebugDraw* drawer) {
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
