#include "shapes/shapes.h"

#include "convert.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btConvexInternalShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMeshShape.h>

#include <cstring>

namespace pliant {

pli_bounds local_bounds(const btCollisionShape& shape) {
    btVector3 low, high;
    shape.getAabb(btTransform::getIdentity(), low, high);
    return {to_pli(low), to_pli(high)};
}

namespace {

pli_vec3 along_axis(int axis, btScalar length) {
    btVector3 v(0, 0, 0);
    v[axis] = length;
    return to_pli(v);
}

pli_status make_hull_shape(pli_context* context, const btConvexHullShape& hull, pli_shape** result) {
    std::vector<pli_vec3> points;
    for (int i = 0; i < hull.getNumPoints(); ++i) {
        points.push_back(to_pli(hull.getScaledPoint(i)));
    }
    const float radius = std::max(0.0f, to_float(hull.getMargin()));
    return pli_shape_create_convex_hull(context, static_cast<int>(points.size()), points.data(), radius, result);
}

pli_status make_exact_convex(pli_context* context, const btConvexShape& shape, ShapePart& part) {
    pli_shape* made = nullptr;
    pli_status status = PLI_ERROR_INVALID_MESH;
    switch (shape.getShapeType()) {
    case SPHERE_SHAPE_PROXYTYPE:
        status =
            pli_shape_create_sphere(context, to_float(static_cast<const btSphereShape&>(shape).getRadius()), &made);
        break;
    case BOX_SHAPE_PROXYTYPE:
        status = pli_shape_create_box(context, to_pli(static_cast<const btBoxShape&>(shape).getHalfExtentsWithMargin()),
                                      &made);
        break;
    case CAPSULE_SHAPE_PROXYTYPE: {
        const auto& capsule = static_cast<const btCapsuleShape&>(shape);
        status = pli_shape_create_capsule(context, along_axis(capsule.getUpAxis(), capsule.getHalfHeight()),
                                          to_float(capsule.getRadius()), &made);
        break;
    }
    case CYLINDER_SHAPE_PROXYTYPE: {
        const auto& cylinder = static_cast<const btCylinderShape&>(shape);
        const int axis = cylinder.getUpAxis();
        status = pli_shape_create_cylinder(context, along_axis(axis, cylinder.getHalfExtentsWithMargin()[axis]),
                                           to_float(cylinder.getRadius()), &made);
        break;
    }
    case CONVEX_HULL_SHAPE_PROXYTYPE:
        status = make_hull_shape(context, static_cast<const btConvexHullShape&>(shape), &made);
        break;
    default:
        break;
    }
    part.shape.reset(made);
    // Flat hulls and all other convex shapes.
    if (status == PLI_ERROR_INVALID_MESH) { status = make_gjk_shape(context, shape, part); }
    return status;
}

pli_status make_leaf(const btCollisionShape& shape, const ShapeOptions& options, ShapePart& part) {
    if (options.sampled_mesh != nullptr && has_triangles(shape)) {
        return make_sampled_shape(shape, options, part.shape);
    }
    const bool is_reference = options.mode == CollisionMode::reference;
    if (shape.isConvex()) {
        const auto& convex = static_cast<const btConvexShape&>(shape);
        part.convex = &convex;
        return is_reference ? make_lattice_shape(options.context, convex, part)
                            : make_exact_convex(options.context, convex, part);
    }
    const auto& concave = static_cast<const btConcaveShape&>(shape);
    if (is_reference) {
        part.triangles = &concave;
        return PLI_OK;
    }
    if (shape.getShapeType() == STATIC_PLANE_PROXYTYPE) {
        const auto& plane = static_cast<const btStaticPlaneShape&>(shape);
        pli_shape* made = nullptr;
        const pli_status status = pli_shape_create_plane(options.context, to_pli(plane.getPlaneNormal()),
                                                         to_float(plane.getPlaneConstant()), &made);
        part.shape.reset(made);
        return status;
    }
    return make_concave_shape(options.context, concave, options.surface_thickness, part);
}

// Bullet visits the children of a compound in the order of its tree, and contacts are made in that order.
std::vector<int> child_order(const btCompoundShape& compound, CollisionMode mode) {
    struct Collect final : btDbvt::ICollide {
        void Process(const btDbvtNode* leaf) override { order.push_back(leaf->dataAsInt); }
        std::vector<int> order;
    } collect;
    const btDbvt* tree = compound.getDynamicAabbTree();
    if (mode == CollisionMode::reference && tree != nullptr) {
        const btVector3 far_corner(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
        btAlignedObjectArray<const btDbvtNode*> stack;
        tree->collideTVNoStackAlloc(tree->m_root, btDbvtVolume::FromMM(-far_corner, far_corner), stack, collect);
        return collect.order;
    }
    for (int i = 0; i < compound.getNumChildShapes(); ++i) {
        collect.order.push_back(i);
    }
    return collect.order;
}

pli_status append_parts(const btCollisionShape& shape, const btTransform& pose, const ShapeOptions& options,
                        std::vector<ShapePart>& parts) {
    if (shape.isCompound()) {
        const auto& compound = static_cast<const btCompoundShape&>(shape);
        pli_status status = PLI_OK;
        for (const int i : child_order(compound, options.mode)) {
            const pli_status child =
                append_parts(*compound.getChildShape(i), pose * compound.getChildTransform(i), options, parts);
            if (status == PLI_OK) { status = child; }
        }
        return status;
    }
    // A type outside Bullet's three families (a fluid, another engine's) has nothing to collide with.
    if (!shape.isConvex() && !shape.isConcave()) { return PLI_OK; }
    if (shape.getShapeType() == EMPTY_SHAPE_PROXYTYPE) { return PLI_OK; }
    ShapePart part;
    part.pose = pose;
    const pli_status status = make_leaf(shape, options, part);
    const bool is_empty = !part.shape && part.triangles == nullptr; // a btSdfCollisionShape yields no triangles
    if (status == PLI_OK && !is_empty) { parts.push_back(std::move(part)); }
    return status;
}

// As FNV-1a, a value at a time: bytes are a chain of fifty multiplications for each object and step.
template <typename T> void add_to_hash(std::uint64_t& hash, T value) {
    static_assert(sizeof value <= sizeof hash);
    std::uint64_t word = 0;
    std::memcpy(&word, &value, sizeof value);
    hash = (hash ^ word) * 1099511628211u;
    hash ^= hash >> 32; // products do not reach lower bits
}

// Two of them, where they fit.
template <class A, class B> std::uint64_t to_word(A a, B b) {
    std::uint64_t word = 0;
    if constexpr (sizeof a + sizeof b <= sizeof word) {
        std::memcpy(&word, &a, sizeof a);
        std::memcpy(reinterpret_cast<unsigned char*>(&word) + sizeof a, &b, sizeof b);
    } else {
        add_to_hash(word, a);
        add_to_hash(word, b);
    }
    return word;
}

void add_to_hash(std::uint64_t& hash, const btVector3& v) {
    add_to_hash(hash, to_word(v.x(), v.y()));
    add_to_hash(hash, v.z());
}

// By products that do not wait for each other.
void add_to_hash(std::uint64_t& hash, const btVector3& a, const btVector3& b) {
    add_to_hash(hash, to_word(a.x(), a.y()) * 0x9e3779b97f4a7c15u + to_word(a.z(), b.x()) * 0xc2b2ae3d27d4eb4fu +
                          to_word(b.y(), b.z()) * 0x165667b19e3779f9u);
}

// Shapes of which these numbers say all.
bool has_dimensions(int type) {
    return type == BOX_SHAPE_PROXYTYPE || type == SPHERE_SHAPE_PROXYTYPE;
}

// Of a hull, a share of its points: another one at its address may have the same bounds.
void add_points(std::uint64_t& hash, const btConvexHullShape& hull) {
    const int count = hull.getNumPoints(), step = count / 16 + 1;
    add_to_hash(hash, count);
    for (int i = 0; i < count; i += step) {
        add_to_hash(hash, hull.getUnscaledPoints()[i]);
    }
}

// Of triangles that Bullet stores, their memory and number.
void add_triangles(std::uint64_t& hash, const btStridingMeshInterface& mesh) {
    add_to_hash(hash, &mesh);
    for (int part = 0; part < mesh.getNumSubParts(); ++part) {
        const unsigned char *points = nullptr, *indices = nullptr;
        int point_count = 0, point_stride = 0, index_stride = 0, triangle_count = 0;
        PHY_ScalarType scalar{}, index{};
        mesh.getLockedReadOnlyVertexIndexBase(&points, point_count, scalar, point_stride, &indices, index_stride,
                                              triangle_count, index, part);
        add_to_hash(hash, points);
        add_to_hash(hash, indices);
        add_to_hash(hash, to_word(point_count, triangle_count));
        mesh.unLockReadOnlyVertexBase(part);
    }
}

void add_shape(std::uint64_t& hash, const btCollisionShape& shape) {
    add_to_hash(hash, &shape);
    if (has_dimensions(shape.getShapeType())) {
        const auto& convex = static_cast<const btConvexInternalShape&>(shape);
        add_to_hash(hash, to_word(shape.getShapeType(), convex.getMarginNV()));
        add_to_hash(hash, convex.getLocalScalingNV(), convex.getImplicitShapeDimensions());
        return;
    }
    add_to_hash(hash, to_word(shape.getShapeType(), shape.getMargin()));
    add_to_hash(hash, shape.getLocalScaling());
    if (shape.getShapeType() == STATIC_PLANE_PROXYTYPE) {
        const auto& plane = static_cast<const btStaticPlaneShape&>(shape);
        add_to_hash(hash, plane.getPlaneNormal());
        add_to_hash(hash, plane.getPlaneConstant());
        return;
    }
    if (shape.isConvex() || shape.isConcave()) {
        btVector3 low, high;
        shape.getAabb(btTransform::getIdentity(), low, high);
        add_to_hash(hash, low, high);
    }
    switch (shape.getShapeType()) {
    case CONVEX_HULL_SHAPE_PROXYTYPE:
        add_points(hash, static_cast<const btConvexHullShape&>(shape));
        break;
    case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
        add_shape(hash, *static_cast<const btScaledBvhTriangleMeshShape&>(shape).getChildShape());
        break;
    case TRIANGLE_MESH_SHAPE_PROXYTYPE:
    case MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE:
        add_triangles(hash, *static_cast<const btTriangleMeshShape&>(shape).getMeshInterface());
        break;
    default:
        break;
    }
    if (!shape.isCompound()) { return; }
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); ++i) {
        const btTransform& pose = compound.getChildTransform(i);
        for (int row = 0; row < 3; ++row) {
            add_to_hash(hash, pose.getBasis().getRow(row));
        }
        add_to_hash(hash, pose.getOrigin());
        add_shape(hash, *compound.getChildShape(i));
    }
}

} // namespace

pli_status make_shape_parts(const btCollisionShape& shape, const ShapeOptions& options, std::vector<ShapePart>& parts) {
    return append_parts(shape, btTransform::getIdentity(), options, parts);
}

std::uint64_t shape_fingerprint(const btCollisionShape& shape) {
    std::uint64_t hash = 14695981039346656037u;
    add_shape(hash, shape);
    return hash;
}

} // namespace pliant
