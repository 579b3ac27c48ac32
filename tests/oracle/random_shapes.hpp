// Random shapes of rigid bodies, all kinds that btSoftBody meets.
#pragma once

#include "random_dice.hpp"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <btBulletCollisionCommon.h>

#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace random_shapes {

using Shape = std::unique_ptr<btCollisionShape>;

enum class Kind {
    box,
    sphere,
    capsule,
    cylinder,
    cone,
    hull,
    spheres,
    compound, // the last one that may move
    plane,
    triangles,
    heights
};
constexpr int movable_count = 8, kind_count = 11;

inline const char* kind_name(Kind kind) {
    constexpr const char* names[kind_count] = {"box",     "sphere",   "capsule", "cylinder",  "cone",   "hull",
                                               "spheres", "compound", "plane",   "triangles", "heights"};
    return names[static_cast<int>(kind)];
}

inline btVector3 vector(pli_vec3 v) {
    return btVector3(v.x, v.y, v.z);
}

// A shape and what it points to.
template <typename Base> class Owning final : public Base {
public:
    template <typename... Arguments>
    explicit Owning(std::shared_ptr<void> owned, Arguments&&... arguments)
        : Base(std::forward<Arguments>(arguments)...), m_owned(std::move(owned)) {}

private:
    std::shared_ptr<void> m_owned;
};

inline Shape make_hull(const Dice& dice) {
    auto hull = std::make_unique<btConvexHullShape>();
    const int count = dice.integer("points", 4, 14);
    for (int i = 0; i < count; ++i) {
        hull->addPoint(vector(dice.vector("point" + std::to_string(i), 1.2f)), i + 1 == count);
    }
    return hull;
}

inline Shape make_spheres(const Dice& dice) {
    btVector3 centers[4];
    btScalar radii[4];
    const int count = dice.integer("spheres", 1, 4);
    for (int i = 0; i < count; ++i) {
        centers[i] = vector(dice.vector("center" + std::to_string(i), 0.8f));
        radii[i] = dice.uniform("radius" + std::to_string(i), 0.2f, 0.7f);
    }
    return std::make_unique<btMultiSphereShape>(centers, radii, count);
}

// Hills on a grid of 0.8 m.
inline float hill(const Dice& dice, int x, int z) {
    return dice.uniform("hill" + std::to_string(x) + "," + std::to_string(z), -0.4f, 0.4f);
}

inline Shape make_triangles(const Dice& dice) {
    auto mesh = std::make_shared<btTriangleMesh>();
    const auto corner = [&](int x, int z) {
        return btVector3(0.8f * static_cast<float>(x), hill(dice, x, z), 0.8f * static_cast<float>(z));
    };
    for (int x = -3; x < 3; ++x) {
        for (int z = -3; z < 3; ++z) {
            mesh->addTriangle(corner(x, z), corner(x, z + 1), corner(x + 1, z));
            mesh->addTriangle(corner(x + 1, z), corner(x, z + 1), corner(x + 1, z + 1));
        }
    }
    btStridingMeshInterface* triangles = mesh.get();
    return std::make_unique<Owning<btBvhTriangleMeshShape>>(std::move(mesh), triangles, true);
}

inline Shape make_heights(const Dice& dice) {
    auto heights = std::make_shared<std::vector<float>>();
    for (int z = 0; z < 7; ++z) {
        for (int x = 0; x < 7; ++x) {
            heights->push_back(hill(dice, x, z));
        }
    }
    const float* values = heights->data();
    auto shape = std::make_unique<Owning<btHeightfieldTerrainShape>>(std::move(heights), 7, 7, values, btScalar(-0.5f),
                                                                     btScalar(0.5f), 1, false);
    return shape;
}

inline Shape make(const Dice& dice, Kind kind);

inline Shape make_compound(const Dice& dice) {
    auto children = std::make_shared<std::vector<Shape>>();
    auto compound = std::make_unique<Owning<btCompoundShape>>(children);
    const int count = dice.integer("children", 1, 3);
    for (int i = 0; i < count; ++i) {
        const Dice child = dice.part("child", i);
        children->push_back(make(child, static_cast<Kind>(child.integer("kind", 0, movable_count - 2))));
        const pli_quat turn = child.turn("turn");
        compound->addChildShape(
            btTransform(btQuaternion(turn.x, turn.y, turn.z, turn.w), vector(child.vector("place", 1.0f))),
            children->back().get());
    }
    return compound;
}

inline Shape make_plain(const Dice& dice, Kind kind) {
    const btVector3 half(dice.uniform("halfx", 0.2f, 1.5f), dice.uniform("halfy", 0.2f, 1.5f),
                         dice.uniform("halfz", 0.2f, 1.5f));
    const btScalar radius = dice.uniform("radius", 0.2f, 1.2f), height = dice.uniform("height", 0.1f, 2.0f);
    const int axis = dice.integer("axis", 0, 2);
    switch (kind) {
    case Kind::box:
        return std::make_unique<btBoxShape>(half);
    case Kind::sphere:
        return std::make_unique<btSphereShape>(radius);
    case Kind::capsule:
        if (axis == 0) { return std::make_unique<btCapsuleShapeX>(radius, height); }
        if (axis == 1) { return std::make_unique<btCapsuleShape>(radius, height); }
        return std::make_unique<btCapsuleShapeZ>(radius, height);
    case Kind::cylinder:
        if (axis == 0) { return std::make_unique<btCylinderShapeX>(half); }
        if (axis == 1) { return std::make_unique<btCylinderShape>(half); }
        return std::make_unique<btCylinderShapeZ>(half);
    case Kind::cone:
        if (axis == 0) { return std::make_unique<btConeShapeX>(radius, height); }
        if (axis == 1) { return std::make_unique<btConeShape>(radius, height); }
        return std::make_unique<btConeShapeZ>(radius, height);
    case Kind::hull:
        return make_hull(dice);
    case Kind::spheres:
        return make_spheres(dice);
    case Kind::compound:
        return make_compound(dice);
    case Kind::plane:
        return std::make_unique<btStaticPlaneShape>(btVector3(dice.uniform("slope", -0.3f, 0.3f), 1, 0).normalized(),
                                                    dice.uniform("offset", -0.5f, 0.5f));
    case Kind::triangles:
        return make_triangles(dice);
    case Kind::heights:
        return make_heights(dice);
    }
    return nullptr;
}

inline Shape make(const Dice& dice, Kind kind) {
    Shape shape = make_plain(dice, kind);
    if (kind != Kind::plane && dice.has(std::string("scaled ") + kind_name(kind), 0.25)) {
        shape->setLocalScaling(
            btVector3(dice.uniform("sx", 0.5f, 1.8f), dice.uniform("sy", 0.5f, 1.8f), dice.uniform("sz", 0.5f, 1.8f)));
    }
    if (dice.has("own margin", 0.15)) { shape->setMargin(dice.uniform("margin", 0.005f, 0.15f)); }
    return shape;
}

} // namespace random_shapes
