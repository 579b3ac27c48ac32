#ifndef PLIANT_BULLET_SHAPES_H
#define PLIANT_BULLET_SHAPES_H

// Bullet's collision shapes as shapes of the core.

#include "pliant_bullet/pliant_bullet.h"

#include <LinearMath/btTransform.h>

#include <cstdint>
#include <memory>
#include <vector>

class btCollisionShape;
class btConcaveShape;
class btConvexShape;

namespace pliant {

struct ShapeRelease {
    void operator()(pli_shape* shape) const { pli_shape_release(shape); }
};
using ShapePointer = std::unique_ptr<pli_shape, ShapeRelease>;

/// Behind a shape of the core that asks a shape of Bullet.
struct AskedShape {
    bool is_gone = false; ///< Bullet's may be deleted: nothing is there to be met
};

/// A leaf of a collision shape, with its pose in the object.
struct ShapePart {
    ShapePointer shape;                        ///< null: `triangles` is to be cut into slabs
    AskedShape* asked = nullptr;               ///< of `shape`; null: it has all that it needs
    const btConvexShape* convex = nullptr;     ///< null: not convex
    const btConcaveShape* triangles = nullptr; ///< reference mode
    btTransform pose;
};

struct ShapeOptions {
    pli_context* context;
    CollisionMode mode;
    float surface_thickness;                  ///< m, of open triangle surfaces
    const pli_sampled_mesh_def* sampled_mesh; ///< null: triangles are not sampled
};

/// Appends the leaves of `shape`. Leaves that the core cannot use (a radius of zero) are left out and reported by the
/// returned status; the others are appended nevertheless.
pli_status make_shape_parts(const btCollisionShape& shape, const ShapeOptions& options, std::vector<ShapePart>& parts);

/// Changes when the shape becomes another one, or is scaled, gets another margin or other children.
std::uint64_t shape_fingerprint(const btCollisionShape& shape);

/// Distances by Bullet's GJK and EPA, as btSparseSdf samples them, of a shape that is asked.
pli_status make_gjk_shape(pli_context* context, const btConvexShape& shape, ShapePart& part);
/// The same behind a lattice of 0.25 m.
pli_status make_lattice_shape(pli_context* context, const btConvexShape& shape, ShapePart& part);
/// The same of a shape that the result keeps.
pli_status make_lattice_shape(pli_context* context, std::unique_ptr<btConvexShape> shape, ShapePointer& result);

/// Triangles, copied into the core when they are few and do not change in place, otherwise asked from Bullet point by
/// point. No shape where there are none.
pli_status make_concave_shape(pli_context* context, const btConcaveShape& shape, float surface_thickness,
                              ShapePart& part);

/// Scaled by a negative volume, as games mirror things: triangles are then the other way round.
bool is_mirrored(const btConcaveShape& shape);

/// Whether a shape or one of its children is a mesh of triangles.
bool has_triangles(const btCollisionShape& shape);
/// The solid inside of the triangles of such a leaf.
pli_status make_sampled_shape(const btCollisionShape& shape, const ShapeOptions& options, ShapePointer& result);

/// Bounds at the identity transform.
pli_bounds local_bounds(const btCollisionShape& shape);

} // namespace pliant

#endif
