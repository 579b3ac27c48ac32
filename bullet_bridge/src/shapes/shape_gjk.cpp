// Convex shapes through Bullet's GJK and EPA: exactly what btSparseSdf asks for (btGjkEpaSolver2::SignedDistance).

#include "convert.h"
#include "shapes/shapes.h"

#include <pliant/bullet_reference.h>

#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <new>

namespace pliant {

namespace {

struct GjkShape final : AskedShape {
    explicit GjkShape(const btConvexShape& asked, std::unique_ptr<btConvexShape> keep = nullptr)
        : shape(&asked), kept(std::move(keep)), bounds(local_bounds(asked)) {}

    const btConvexShape* shape;
    std::unique_ptr<btConvexShape> kept;
    pli_bounds bounds;
};

float distance_to_bounds(const pli_bounds& bounds, pli_vec3 p) {
    const float x = std::max(std::max(bounds.min.x - p.x, p.x - bounds.max.x), 0.0f);
    const float y = std::max(std::max(bounds.min.y - p.y, p.y - bounds.max.y), 0.0f);
    const float z = std::max(std::max(bounds.min.z - p.z, p.z - bounds.max.z), 0.0f);
    return std::sqrt(x * x + y * y + z * z);
}

void gjk_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                   pli_vec3* normals) {
    const auto& gjk = *static_cast<const GjkShape*>(user);
    if (gjk.is_gone) {
        std::fill_n(distances, count, FLT_MAX);
        return;
    }
    for (int i = 0; i < count; ++i) {
        const float far_away = distance_to_bounds(gjk.bounds, points[i]);
        if (far_away > max_distance) {
            distances[i] = far_away;
            continue;
        }
        btGjkEpaSolver2::sResults result;
        result.normal.setValue(0, 1, 0);
        const btScalar distance =
            btGjkEpaSolver2::SignedDistance(to_bullet(points[i]), 0, gjk.shape, btTransform::getIdentity(), result);
        // A failure of GJK and EPA is reported as the largest number.
        distances[i] = distance < btScalar(FLT_MAX) ? to_float(distance) : FLT_MAX;
        if (normals != nullptr) { normals[i] = to_pli(result.normal); }
    }
}

pli_bounds gjk_bounds(const void* user) {
    return static_cast<const GjkShape*>(user)->bounds;
}

pli_vec3 gjk_support(const void* user, pli_vec3 direction) {
    const auto& gjk = *static_cast<const GjkShape*>(user);
    if (gjk.is_gone) { return pli_vec3_scale(pli_vec3_add(gjk.bounds.min, gjk.bounds.max), 0.5f); }
    return to_pli(gjk.shape->localGetSupportingVertexWithoutMargin(to_bullet(direction)));
}

void gjk_destroy(void* user) {
    delete static_cast<GjkShape*>(user);
}

// Takes `gjk`, which may be null.
pli_status make_shape_of(pli_context* context, GjkShape* gjk, ShapePointer& result) {
    if (gjk == nullptr) {
        return pli_context_fail(context, PLI_ERROR_OUT_OF_MEMORY, "pliant::Bridge", "no memory for a convex shape");
    }
    pli_shape_def def = pli_shape_def_default();
    def.user = gjk;
    def.distances = gjk_distances;
    def.bounds = gjk_bounds;
    def.support = gjk_support;
    def.radius = std::max(0.0f, to_float(gjk->shape->getMargin()));
    def.destroy = gjk_destroy;
    pli_shape* made = nullptr;
    const pli_status status = pli_shape_create(context, &def, &made);
    if (status != PLI_OK) { delete gjk; }
    result.reset(made);
    return status;
}

pli_status put_behind_lattice(pli_context* context, ShapePointer& shape) {
    const float bullet_voxel_size = 0.25f;
    pli_shape* made = nullptr;
    const pli_status status = pli_shape_create_lattice(context, shape.get(), bullet_voxel_size, &made);
    shape.reset(made);
    return status;
}

} // namespace

pli_status make_gjk_shape(pli_context* context, const btConvexShape& shape, ShapePart& part) {
    auto* gjk = new (std::nothrow) GjkShape(shape);
    const pli_status status = make_shape_of(context, gjk, part.shape);
    part.asked = status == PLI_OK ? gjk : nullptr;
    return status;
}

pli_status make_lattice_shape(pli_context* context, const btConvexShape& shape, ShapePart& part) {
    pli_status status = make_gjk_shape(context, shape, part);
    if (status == PLI_OK) { status = put_behind_lattice(context, part.shape); }
    if (status != PLI_OK) { part.asked = nullptr; }
    return status;
}

pli_status make_lattice_shape(pli_context* context, std::unique_ptr<btConvexShape> shape, ShapePointer& result) {
    const btConvexShape& kept = *shape;
    const pli_status status = make_shape_of(context, new (std::nothrow) GjkShape(kept, std::move(shape)), result);
    return status == PLI_OK ? put_behind_lattice(context, result) : status;
}

} // namespace pliant
