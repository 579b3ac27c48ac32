// A Bullet convex shape as a Pliant shape: distances by Bullet's own GJK and EPA, as btSparseSdf samples them. Around
// it goes a lattice of voxels of 0.25 m, which then holds the same numbers as btSparseSdf. Single precision.
#pragma once

#include "bullet_twin.hpp"

#include <pliant/bullet_reference.h>
#include <pliant/shape.h>

#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>

namespace twin {

namespace detail {

inline void convex_distances(const void* user, int count, const pli_vec3* points, float, float* distances,
                             pli_vec3* normals) {
    const auto* shape = static_cast<const btConvexShape*>(user);
    for (int i = 0; i < count; ++i) {
        btGjkEpaSolver2::sResults results;
        distances[i] = static_cast<float>(
            btGjkEpaSolver2::SignedDistance(to_bullet(points[i]), 0, shape, btTransform::getIdentity(), results));
        normals[i] = to_pliant(results.normal);
    }
}

inline pli_bounds convex_bounds(const void* user) {
    btVector3 low, high;
    static_cast<const btConvexShape*>(user)->getAabb(btTransform::getIdentity(), low, high);
    pli_bounds bounds;
    bounds.min = to_pliant(low);
    bounds.max = to_pliant(high);
    return bounds;
}

} // namespace detail

// The caller releases the result before `shape` goes.
inline pli_shape* make_lattice(pli_context* context, const btConvexShape& shape) {
    pli_shape_def def = pli_shape_def_default();
    def.user = const_cast<btConvexShape*>(&shape);
    def.distances = detail::convex_distances;
    def.bounds = detail::convex_bounds;
    pli_shape* source = nullptr;
    pli_shape* lattice = nullptr;
    if (pli_shape_create(context, &def, &source) == PLI_OK) {
        pli_shape_create_lattice(context, source, 0.25f, &lattice);
    }
    pli_shape_release(source);
    return lattice;
}

} // namespace twin
