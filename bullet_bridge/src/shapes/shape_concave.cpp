// Triangle meshes, heightfields and other shapes that yield triangles. The sign of a distance comes from the face
// nearest to the point; among faces that share the nearest edge or corner, from the one that the point is most in
// front of or behind (which is right for every surface: Baerentzen and Aanaes 2005 discuss the alternatives).

#include "convert.h"
#include "shapes/shapes.h"
#include "shapes/triangle_copy.h"

#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <new>

namespace pliant {

namespace {

// ------------------------------------------------------------------------------------- triangles asked from Bullet

struct SurfaceShape final : AskedShape {
    SurfaceShape(const btConcaveShape& asked, float surface_thickness)
        : shape(&asked), thickness(surface_thickness), bounds(local_bounds(asked)),
          side(is_mirrored(asked) ? btScalar(-1) : btScalar(1)), up_axis(-1),
          takes_turns(asked.getShapeType() == GIMPACT_SHAPE_PROXYTYPE) {
        if (asked.getShapeType() != TERRAIN_SHAPE_PROXYTYPE) { return; }
        up_axis = static_cast<const btHeightfieldTerrainShape&>(asked).getUpAxis();
        side = asked.getLocalScaling()[up_axis] < 0 ? btScalar(-1) : btScalar(1);
    }

    const btConcaveShape* shape;
    float thickness;
    pli_bounds bounds;
    btScalar side;    ///< of its triangles that is the front: -1 the other one
    int up_axis;      ///< of a heightfield, whose front that is: its triangles turn by the axis; otherwise -1
    bool takes_turns; ///< GImpact counts who reads its vertices, and not atomically
};

// One for all: objects may share a shape.
std::mutex gimpact_mutex;

btVector3 closest_on_segment(const btVector3& p, const btVector3& a, const btVector3& b) {
    const btVector3 ab = b - a;
    const btScalar length2 = ab.length2();
    if (length2 <= 0) { return a; }
    const btScalar t = (p - a).dot(ab) / length2;
    return a + ab * std::clamp(t, btScalar(0), btScalar(1));
}

class NearestTriangle final : public btTriangleCallback {
public:
    NearestTriangle(const btVector3& point, const SurfaceShape& surface)
        : point_(point), surface_side_(surface.side), up_axis_(surface.up_axis) {}

    void processTriangle(btVector3* corners, int, int) override {
        const btVector3 turning = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        const bool is_turned = up_axis_ >= 0 && turning[up_axis_] < 0;
        const btScalar side = is_turned ? -surface_side_ : surface_side_;
        const btVector3 cross = turning * side;
        const btScalar cross_length = cross.length();
        if (!(cross_length > 0)) { return; }
        const btVector3 face_normal = cross / cross_length;
        const btScalar height = face_normal.dot(point_ - corners[0]);
        btVector3 closest = point_ - face_normal * height;
        bool is_inside = true;
        for (int i = 0; i < 3; ++i) {
            const btVector3& a = corners[i];
            const btVector3& b = corners[(i + 1) % 3];
            if ((b - a).cross(closest - a).dot(face_normal) * side < 0) { is_inside = false; }
        }
        if (!is_inside) {
            const btVector3 in_plane = closest;
            btScalar best = BT_LARGE_FLOAT;
            for (int i = 0; i < 3; ++i) {
                const btVector3 c = closest_on_segment(in_plane, corners[i], corners[(i + 1) % 3]);
                if ((c - in_plane).length2() < best) {
                    best = (c - in_plane).length2();
                    closest = c;
                }
            }
        }
        const btScalar distance = (point_ - closest).length();
        // Faces around one edge or corner give the same distance up to rounding.
        const btScalar tie = btScalar(1e-5) * (distance_ < 1 ? btScalar(1) : distance_);
        const bool is_tied = found_ && std::fabs(distance - distance_) <= tie;
        if (found_ && !is_tied && distance > distance_) { return; }
        if (is_tied && std::fabs(height) <= std::fabs(height_)) { return; }
        found_ = true;
        distance_ = distance;
        height_ = height;
        closest_ = closest;
        face_normal_ = face_normal;
    }

    bool found() const { return found_; }
    btScalar signed_distance() const { return height_ < 0 ? -distance_ : distance_; }
    btVector3 normal() const {
        // On the surface, and within rounding of it, the direction to the nearest point says nothing.
        if (distance_ <= btScalar(1e-5)) { return face_normal_; }
        return (point_ - closest_) / signed_distance();
    }

private:
    btVector3 point_;
    btScalar surface_side_;
    int up_axis_;
    bool found_ = false;
    btScalar distance_ = 0, height_ = 0;
    btVector3 closest_, face_normal_;
};

void surface_distances(const void* user, int count, const pli_vec3* points, float max_distance, float* distances,
                       pli_vec3* normals) {
    const auto& surface = *static_cast<const SurfaceShape*>(user);
    const bool is_limited = max_distance < 1e6f;
    const float reach = std::max(max_distance, surface.thickness);
    std::unique_lock<std::mutex> lock(gimpact_mutex, std::defer_lock);
    if (surface.takes_turns) { lock.lock(); }
    for (int i = 0; i < count; ++i) {
        const btVector3 point = to_bullet(points[i]);
        const btVector3 extent = to_bullet(pli_vec3_make(reach, reach, reach));
        NearestTriangle nearest(point, surface);
        if (!surface.is_gone) {
            surface.shape->processAllTriangles(&nearest, is_limited ? point - extent : to_bullet(surface.bounds.min),
                                               is_limited ? point + extent : to_bullet(surface.bounds.max));
        }
        const float distance = nearest.found() ? to_float(nearest.signed_distance()) : INFINITY;
        const bool is_behind = distance < -surface.thickness;
        distances[i] = is_behind ? INFINITY : distance;
        if (normals != nullptr && nearest.found()) { normals[i] = to_pli(nearest.normal()); }
    }
}

pli_bounds surface_bounds(const void* user) {
    return static_cast<const SurfaceShape*>(user)->bounds;
}

void surface_destroy(void* user) {
    delete static_cast<SurfaceShape*>(user);
}

pli_status make_surface_shape(pli_context* context, const btConcaveShape& shape, float thickness, ShapePart& part) {
    auto* surface = new (std::nothrow) SurfaceShape(shape, thickness);
    if (surface == nullptr) {
        return pli_context_fail(context, PLI_ERROR_OUT_OF_MEMORY, "pliant::Bridge", "no memory for a concave shape");
    }
    pli_shape_def def = pli_shape_def_default();
    def.user = surface;
    def.distances = surface_distances;
    def.bounds = surface_bounds;
    def.destroy = surface_destroy;
    pli_shape* made = nullptr;
    const pli_status status = pli_shape_create(context, &def, &made);
    if (status != PLI_OK) {
        delete surface;
        return status;
    }
    part.shape.reset(made);
    part.asked = surface;
    return PLI_OK;
}

} // namespace

bool is_mirrored(const btConcaveShape& shape) {
    btVector3 scaling = shape.getLocalScaling();
    if (shape.getShapeType() == SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE) {
        scaling *= static_cast<const btScaledBvhTriangleMeshShape&>(shape).getChildShape()->getLocalScaling();
    }
    return scaling.x() * scaling.y() * scaling.z() < 0;
}

pli_status make_concave_shape(pli_context* context, const btConcaveShape& shape, float surface_thickness,
                              ShapePart& part) {
    // Games edit the heights of a heightfield while it is in use, and GImpact meshes deform.
    const int type = shape.getShapeType();
    const bool may_change = type == TERRAIN_SHAPE_PROXYTYPE || type == GIMPACT_SHAPE_PROXYTYPE;
    if (!may_change) {
        TriangleCopy copy(65536); // more are not worth a copy
        btVector3 low, high;
        shape.getAabb(btTransform::getIdentity(), low, high);
        shape.processAllTriangles(&copy, low, high);
        if (copy.is_complete()) {
            if (copy.triangles.empty()) { return PLI_OK; }
            if (is_mirrored(shape)) { copy.turn_over(); }
            pli_shape* made = nullptr;
            const pli_status status = pli_shape_create_triangle_mesh(
                context, static_cast<int>(copy.points.size()), copy.points.data(),
                static_cast<int>(copy.triangles.size() / 3), copy.triangles.data(), surface_thickness, &made);
            part.shape.reset(made);
            return status;
        }
    }
    return make_surface_shape(context, shape, surface_thickness, part);
}

} // namespace pliant
