#ifndef PLIANT_BULLET_SOFT_OBJECT_H
#define PLIANT_BULLET_SOFT_OBJECT_H

// What Bullet sees of a soft body: a movable collision object whose concave shape yields the faces where they are now,
// and to rays and sweeps the links of a body without faces.

#include "bridge_impl.h"

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>

namespace pliant {

/// A concave type that no class of Bullet has. CUSTOM_CONCAVE_SHAPE_TYPE will not do: it is also the type of
/// btSdfCollisionShape, and contactTest casts shapes of that type to it.
constexpr int soft_shape_type = FAST_CONCAVE_MESH_PROXYTYPE;

ATTRIBUTE_ALIGNED16(class) SoftShape : public btConcaveShape {
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    SoftShape(Bridge::Impl & bridge, pli_body * body, const btCollisionObject& object);

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
        return "PliantSoftBody";
    }

private:
    /// Only then the Bullet world may be asked for its state: it may have gone.
    bool is_in_world() const;

    Bridge::Impl& bridge_;
    pli_body* body_;
    const btCollisionObject& object_;
    btVector3 unit_scaling_;
    btTransform identity_;
};

ATTRIBUTE_ALIGNED16(class) SoftObject : public btCollisionObject {
public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    SoftObject(Bridge::Impl & bridge, pli_body * body);

    Bridge::Impl& bridge() const {
        return bridge_;
    }
    pli_body* body() const {
        return body_;
    }

    /// Pairs of soft bodies without a feature that looks at other bodies are dropped before Bullet takes them up.
    bool checkCollideWithOverride(const btCollisionObject* other) const override;

    bool is_frozen_by_bridge = false; ///< frozen because the object is inactive, to be thawed with it
    bool wants_sleep = false;         ///< it rests, and Bullet may put it to sleep
    bool is_asleep = false;           ///< Bullet has

    /// Null when the object is no soft body.
    static const SoftObject* from(const btCollisionObject* object) {
        return dynamic_cast<const SoftObject*>(object);
    }

private:
    Bridge::Impl& bridge_;
    pli_body* body_;
    SoftShape shape_;
};

} // namespace pliant

#endif
