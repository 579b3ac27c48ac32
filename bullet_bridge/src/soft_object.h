#ifndef PLIANT_BULLET_SOFT_OBJECT_H
#define PLIANT_BULLET_SOFT_OBJECT_H

// What Bullet sees of a soft body: a movable collision object whose concave shape yields the faces where they are now,
// and to rays and sweeps the links of a body without faces.

#include "bridge_impl.h"
#include "convert.h"

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>

#include <vector>

namespace pliant {

/// A concave type that no class of Bullet has. CUSTOM_CONCAVE_SHAPE_TYPE will not do: it is also the type of
/// btSdfCollisionShape, and contactTest casts shapes of that type to it.
constexpr int soft_shape_type = FAST_CONCAVE_MESH_PROXYTYPE;

/// Its address tells the shapes of the bridge from those of a game.
inline constexpr char soft_shape_name[] = "PliantSoftBody";

class SoftObject;

ATTRIBUTE_ALIGNED16(class) SoftShape : public btConcaveShape {
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    SoftShape(Bridge::Impl & bridge, pli_body * body, const SoftObject& object);

    void getAabb(const btTransform& transform, btVector3& aabb_min, btVector3& aabb_max) const override;
    void processAllTriangles(btTriangleCallback * callback, const btVector3& aabb_min, const btVector3& aabb_max)
        const override;
    void calculateLocalInertia(btScalar mass, btVector3 & inertia) const override;
    void setLocalScaling(const btVector3& scaling) override;
    const btVector3& getLocalScaling() const override {
        return unit_scaling_;
    }
    void setMargin(btScalar margin) override;
    btScalar getMargin() const override;
    const char* getName() const override {
        return soft_shape_name;
    }
    const SoftObject& object() const {
        return object_;
    }
    /// Bit for bit: where soft objects are unless a game moves them.
    bool is_identity(const btTransform& transform) const {
        return same_bits(transform, identity_);
    }

private:
    /// Only then the Bullet world may be asked for its state: it may have gone.
    bool is_in_world() const;

    Bridge::Impl& bridge_;
    pli_body* body_;
    const SoftObject& object_;
    btVector3 unit_scaling_;
    const btTransform& identity_; // one for all: many soft bodies would fetch as many lines of the cache
};

ATTRIBUTE_ALIGNED16(class) SoftObject : public btCollisionObject {
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    SoftObject(Bridge::Impl & bridge, pli_body * body);
    ~SoftObject() override;

    Bridge::Impl& bridge() const {
        return bridge_;
    }
    pli_body* body() const {
        return body_;
    }
    bool is_moved() const {
        return !shape_.is_identity(getWorldTransform()) && !(getWorldTransform() == btTransform::getIdentity());
    }

    /// Pairs of soft bodies without a feature that looks at other bodies are dropped before Bullet takes them up.
    bool checkCollideWithOverride(const btCollisionObject* other) const override;

    /// Calls `visit` with each rigid body of the core that anchors and joints hold, with one after the other once.
    template <typename Visit> void for_each_held_rigid(const Visit& visit) const {
        const auto get = [&] { return pli_body_get_held_rigids(body_, static_cast<int>(held_.size()), held_.data()); };
        const auto count = static_cast<std::size_t>(get());
        if (count != held_.size()) {
            held_.resize(count);
            (void)get();
        }
        const pli_rigid* last = nullptr;
        for (const pli_rigid* rigid : held_) {
            if (rigid != last) { visit(*rigid); }
            last = rigid;
        }
    }
    /// The same with each dynamic body in the Bullet world, which has to live.
    template <typename Visit> void for_each_held(const Visit& visit) const {
        for_each_held_rigid([&](const pli_rigid& rigid) {
            if (pli_rigid_get_kind(&rigid) != PLI_RIGID_DYNAMIC) { return; }
            const btCollisionObject* object = bridge_.living_object(rigid);
            if (object != nullptr) { visit(*object); }
        });
    }

    bool is_frozen_by_bridge = false;              ///< frozen because the object is inactive, to be thawed with it
    bool wants_sleep = false;                      ///< it rests, and Bullet may put it to sleep
    bool is_asleep = false;                        ///< Bullet has
    bool has_grounds = false;                      ///< `grounds` are those of this sleep
    std::vector<const btCollisionObject*> grounds; ///< what does not sleep below or beside it; may have been deleted

    /// Null when the object is no soft body.
    static const SoftObject* from(const btCollisionObject* object) {
        // Classes of a game may have no run-time type information, and a cast of their objects would crash.
        const btCollisionShape* shape = object != nullptr ? object->getCollisionShape() : nullptr;
        const bool may_be = shape != nullptr && object->getInternalType() == CO_USER_TYPE &&
                            shape->getShapeType() == soft_shape_type && shape->getName() == soft_shape_name;
        const SoftObject* owner = may_be ? &static_cast<const SoftShape*>(shape)->object() : nullptr;
        return owner == object ? owner : nullptr;
    }

private:
    Bridge::Impl& bridge_;
    pli_body* body_;
    SoftShape shape_;
    mutable std::vector<pli_rigid*> held_; ///< of the last call
};

} // namespace pliant

#endif
