#include "pliant_bullet/pliant_bullet.h"

#include "bridge_impl.h"
#include "rigid_proxy.h"
#include "soft_object.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

namespace pliant {

Bridge::Bridge(btDiscreteDynamicsWorld& bullet_world, const BridgeDef& def)
    : impl_(std::make_unique<Impl>(bullet_world, def)) {}

Bridge::~Bridge() {
    if (impl_->end_later()) { (void)impl_.release(); }
}

pli_status Bridge::status() const {
    return impl_->status;
}
pli_status Bridge::step_status() const {
    return impl_->status != PLI_OK ? impl_->status : impl_->step_status;
}
pli_context* Bridge::context() const {
    return impl_->context;
}
pli_world* Bridge::world() const {
    return impl_->world;
}

pli_status Bridge::add_body(const pli_mesh* mesh, const pli_body_def* def, pli_body** body, int group, int mask) {
    return impl_->add_body(mesh, def, body, group, mask);
}

pli_status Bridge::remove_body(pli_body* body) {
    return impl_->remove_body(body);
}

btCollisionObject* Bridge::object(const pli_body* body) const {
    return impl_->find(body);
}

const btCollisionObject* Bridge::object(const pli_rigid* rigid) const {
    const RigidProxy* proxy = rigid != nullptr ? impl_->find_proxy(*rigid) : nullptr;
    return proxy != nullptr ? proxy->object() : nullptr;
}

pli_body* Bridge::body(const btCollisionObject* object) const {
    const SoftObject* soft = SoftObject::from(object);
    return soft != nullptr && &soft->bridge() == impl_.get() ? soft->body() : nullptr;
}

pli_body* Bridge::from_object(const btCollisionObject* object) {
    const SoftObject* soft = SoftObject::from(object);
    return soft != nullptr ? soft->body() : nullptr;
}

pli_rigid* Bridge::rigid(btRigidBody& body) {
    return impl_->pin_proxy(body);
}
pli_rigid* Bridge::rigid(btCollisionObject& object) {
    return impl_->pin_proxy(object);
}
float Bridge::interpolation() const {
    return impl_->interpolation();
}
void Bridge::forget(const btCollisionObject& object) {
    impl_->forget(object);
}
void Bridge::refresh(const btCollisionObject& object) {
    impl_->refresh(object);
}
pli_status Bridge::use_sampled_mesh(const btCollisionObject& object, const pli_sampled_mesh_def& def) {
    return impl_->use_sampled_mesh(object, def);
}
void Bridge::set_before_solve(std::function<void()> hook) {
    impl_->before_solve = std::move(hook);
}
void Bridge::detach() {
    impl_->detach();
}

} // namespace pliant
