#include "soft_object.h"

#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <LinearMath/btAabbUtil2.h>

namespace pliant {

namespace {

// Bullet's continuous collision sweeps a sphere along the motion of a fast rigid body and stops it at what it hits, as
// if that were fixed. Soft bodies give way, and take their share of the impulse in their own contacts.
bool is_motion_clamping(const btTriangleCallback& callback) {
    const auto* sweep = dynamic_cast<const btTriangleConvexcastCallback*>(&callback);
    return sweep != nullptr && sweep->m_convexShape->getShapeType() == SPHERE_SHAPE_PROXYTYPE;
}

// Rays meet links as capsules of the margin, solids without faces as they are.
void cast_ray(const pli_body* body, int targets, btTriangleRaycastCallback& callback) {
    pli_ray_def def = pli_ray_def_default();
    def.from = to_pli(callback.m_from);
    def.to = to_pli(callback.m_to);
    def.targets = targets;
    def.radius = pli_body_get_collision_margin(body);
    pli_ray_hit hit{};
    if (pli_body_cast_ray(body, &def, &hit) != PLI_OK || hit.kind == PLI_FEATURE_NONE) { return; }
    const btScalar fraction = btScalar(hit.fraction);
    if (fraction >= callback.m_hitFraction) { return; }
    callback.m_hitFraction = callback.reportHit(to_bullet(hit.normal), fraction, 0, hit.index);
}

// A triangle without width, to which Bullet adds the margin.
void sweep_links(const pli_body_view& view, const btVector3& aabb_min, const btVector3& aabb_max,
                 btTriangleConvexcastCallback& callback) {
    for (int i = 0; i < view.link_count; ++i) {
        btVector3 corners[3];
        for (int k = 0; k < 2; ++k) {
            const pli_vec4& p = view.positions[view.link_nodes[view.link_node_stride * i + k]];
            corners[k] = to_bullet(pli_vec3_make(p.x, p.y, p.z));
        }
        corners[2] = corners[1];
        if (TestTriangleAgainstAabb2(corners, aabb_min, aabb_max)) { callback.processTriangle(corners, 0, i); }
    }
}

// Bodies without faces, for queries only: what collides with links is the core's to find.
void query_links(const pli_body* body, const pli_body_view& view, const btVector3& aabb_min, const btVector3& aabb_max,
                 btTriangleCallback& callback) {
    if (auto* ray = dynamic_cast<btTriangleRaycastCallback*>(&callback)) {
        cast_ray(body, view.tetra_count > 0 ? PLI_RAY_TETRAS : PLI_RAY_LINKS, *ray);
    } else if (auto* sweep = dynamic_cast<btTriangleConvexcastCallback*>(&callback)) {
        sweep_links(view, aabb_min, aabb_max, *sweep);
    }
}

} // namespace

SoftShape::SoftShape(Bridge::Impl& bridge, pli_body* body, const SoftObject& object)
    : bridge_(bridge), body_(body), object_(object), unit_scaling_(1, 1, 1), identity_(btTransform::getIdentity()) {
    m_shapeType = soft_shape_type;
}

bool SoftShape::is_in_world() const {
    return object_.getWorldArrayIndex() >= 0 && object_.getBroadphaseHandle() != nullptr;
}

void SoftShape::getAabb(const btTransform& transform, btVector3& aabb_min, btVector3& aabb_max) const {
    // Bullet asks for bounds at the start of its collision detection: the moment to move the bodies ahead.
    const bool has_world = is_in_world();
    if (has_world) { bridge_.predict_inside_step(); }
    const pli_bounds bounds = pli_body_get_bounds(body_);
    if (is_identity(transform)) {
        aabb_min = to_bullet(bounds.min);
        aabb_max = to_bullet(bounds.max);
        if (!has_world) { return; }
        if (bridge_.has_ahead()) { bridge_.reach_ahead(aabb_min, aabb_max); }
        if (!pli_body_is_resting(body_)) { return; }
        // It may sleep with what it holds, if that is in its island, which overlapping bounds make.
        object_.for_each_held([&](const btCollisionObject& held) {
            aabb_min.setMin(held.getWorldTransform().getOrigin());
            aabb_max.setMax(held.getWorldTransform().getOrigin());
        });
        return;
    }
    const btVector3 ends[2] = {to_bullet(bounds.min), to_bullet(bounds.max)};
    // Compounds ask for the bounds in their own frame.
    aabb_min = aabb_max = transform * ends[0];
    for (int corner = 1; corner < 8; ++corner) {
        const btVector3 p =
            transform * btVector3(ends[corner & 1].x(), ends[corner >> 1 & 1].y(), ends[corner >> 2].z());
        aabb_min.setMin(p);
        aabb_max.setMax(p);
    }
}

void SoftShape::processAllTriangles(btTriangleCallback* callback, const btVector3& aabb_min,
                                    const btVector3& aabb_max) const {
    if (is_in_world() && bridge_.is_inside_step() && is_motion_clamping(*callback)) { return; }
    const pli_body_view view = pli_body_get_view(body_);
    if (view.face_count == 0) { query_links(body_, view, aabb_min, aabb_max, *callback); }
    for (int f = 0; f < view.face_count; ++f) {
        btVector3 corners[3];
        for (int i = 0; i < 3; ++i) {
            const pli_vec4& p = view.positions[view.face_nodes[3 * f + i]];
            corners[i] = to_bullet(pli_vec3_make(p.x, p.y, p.z));
        }
        if (TestTriangleAgainstAabb2(corners, aabb_min, aabb_max)) { callback->processTriangle(corners, 0, f); }
    }
}

void SoftShape::calculateLocalInertia(btScalar, btVector3& inertia) const {
    inertia.setZero();
}

// Soft bodies are scaled as meshes.
void SoftShape::setLocalScaling(const btVector3&) {}

void SoftShape::setMargin(btScalar margin) {
    (void)pli_body_set_collision_margin(body_, to_float(margin));
}

btScalar SoftShape::getMargin() const {
    return btScalar(pli_body_get_collision_margin(body_));
}

SoftObject::SoftObject(Bridge::Impl& bridge, pli_body* body)
    : bridge_(bridge), body_(body), shape_(bridge, body, *this) {
    m_internalType = CO_USER_TYPE;
    // Neither static nor kinematic, so that islands join over it, and sleep with it alone.
    m_collisionFlags = 0;
    // Has the override called. The end of the last setIgnoreCollisionCheck takes it back, which costs time only.
    m_checkCollideWith = 1;
    setCollisionShape(&shape_);
}

SoftObject::~SoftObject() {
    bridge_.end_body_of(*this);
}

bool SoftObject::checkCollideWithOverride(const btCollisionObject* other) const {
    const SoftObject* soft = from(other);
    const bool may_meet =
        soft == nullptr || (pli_body_collides_with_bodies(body_) && pli_body_collides_with_bodies(soft->body_));
    return may_meet && btCollisionObject::checkCollideWithOverride(other);
}

} // namespace pliant
