// The scene builder's meshes, rigid bodies and soft bodies: checks what a scene says and writes it down.

#include "recorder_checks.h"

#include <cmath>

using demos::checked_index;
using demos::checked_node;
using demos::Error;
using demos::is_finite;
using demos::is_positive;
using demos::require;
using demos::soft_record;

// ---------------------------------------------------------------------------------------------------- checks

static demos::Shape checked_shape(const scene_shape& shape, const std::string& owner);

static void check_extents(const scene_shape& shape, const std::string& owner) {
    switch (shape.kind) {
    case SCENE_SHAPE_BOX:
    case SCENE_SHAPE_CYLINDER:
        require(is_positive(shape.half_extents.x) && is_positive(shape.half_extents.y) &&
                    is_positive(shape.half_extents.z),
                owner + ": half extents must be positive");
        break;
    case SCENE_SHAPE_SPHERE:
        require(is_positive(shape.radius), owner + ": the radius must be positive");
        break;
    case SCENE_SHAPE_CAPSULE:
        require(is_positive(shape.radius) && is_positive(shape.half_height),
                owner + ": radius and half height must be positive");
        break;
    case SCENE_SHAPE_TRIANGLE_MESH:
        require(shape.points != nullptr && shape.triangles != nullptr && shape.point_count > 0 &&
                    shape.triangle_count > 0,
                owner + ": the triangle mesh is empty");
        break;
    case SCENE_SHAPE_COMPOUND:
        require(shape.children != nullptr && shape.child_poses != nullptr && shape.child_count > 0,
                owner + ": the compound is empty");
        break;
    default:
        throw Error(owner + ": unknown kind of shape " + std::to_string(static_cast<int>(shape.kind)));
    }
}

static void copy_triangles(const scene_shape& shape, const std::string& owner, demos::Shape& copy) {
    copy.points.assign(shape.points, shape.points + shape.point_count);
    copy.triangles.assign(shape.triangles, shape.triangles + 3 * static_cast<ptrdiff_t>(shape.triangle_count));
    for (const pli_vec3& point : copy.points) {
        require(is_finite(point), owner + ": a point of the triangle mesh is not finite");
    }
    for (const int index : copy.triangles) {
        require(index >= 0 && index < shape.point_count,
                owner + ": triangle index " + std::to_string(index) + " is out of range");
    }
}

static void copy_children(const scene_shape& shape, const std::string& owner, demos::Shape& copy) {
    for (int i = 0; i < shape.child_count; ++i) {
        const scene_shape& child = shape.children[i];
        require(child.kind != SCENE_SHAPE_COMPOUND && child.kind != SCENE_SHAPE_TRIANGLE_MESH,
                owner + ": children of a compound must be convex");
        require(is_finite(shape.child_poses[i]), owner + ": a child's pose is not finite");
        copy.children.push_back(checked_shape(child, owner));
        copy.child_poses.push_back(shape.child_poses[i]);
    }
}

static demos::Shape checked_shape(const scene_shape& shape, const std::string& owner) {
    check_extents(shape, owner);
    require(shape.axis >= 0 && shape.axis <= 2, owner + ": the axis must be 0, 1 or 2");
    require(std::isfinite(shape.margin), owner + ": the margin is not finite");
    demos::Shape copy{};
    copy.kind = shape.kind;
    copy.half_extents = shape.half_extents;
    copy.radius = shape.radius;
    copy.half_height = shape.half_height;
    copy.axis = shape.axis;
    copy.margin = shape.margin;
    copy.is_solid = shape.is_solid;
    if (shape.kind == SCENE_SHAPE_TRIANGLE_MESH) { copy_triangles(shape, owner, copy); }
    if (shape.kind == SCENE_SHAPE_COMPOUND) { copy_children(shape, owner, copy); }
    return copy;
}

// ----------------------------------------------------------------------------------------------- the builder

pli_context* scene_context(scene_builder* builder) {
    return builder->description.context;
}

bool scene_check(scene_builder* builder, pli_status status) {
    builder->guard([&] {
        const std::string detail = pli_last_error(builder->description.context);
        require(status == PLI_OK, std::string(pli_status_string(status)) + (detail.empty() ? "" : ": " + detail));
    });
    return status == PLI_OK;
}

pli_mesh* scene_triangle_mesh(scene_builder* builder, const char* name) {
    pli_mesh* mesh = nullptr;
    builder->guard([&] {
        require(name != nullptr, "a mesh needs a name");
        mesh = demos::make_named_mesh(builder->description.context, name, builder->options.mesh_file).release();
    });
    return mesh;
}

pli_mesh* scene_tetra_mesh(scene_builder* builder, const char* name) {
    pli_mesh* mesh = nullptr;
    builder->guard([&] {
        require(name != nullptr, "a mesh needs a name");
        mesh = demos::make_named_tetra_mesh(builder->description.context, name, builder->options.tetra_base).release();
    });
    return mesh;
}

int scene_add_rigid(scene_builder* builder, const scene_rigid_def* def) {
    builder->guard([&] {
        require(def != nullptr && def->name != nullptr, "a rigid body needs a definition with a name");
        const std::string name = def->name;
        require(def->mass >= 0.0f && std::isfinite(def->mass), name + ": the mass must be zero or positive");
        require(def->friction >= 0.0f && std::isfinite(def->friction), name + ": the friction must not be negative");
        require(is_finite(def->pose), name + ": the pose is not finite");
        require(def->mass == 0.0f || def->shape.kind != SCENE_SHAPE_TRIANGLE_MESH,
                name + ": a triangle mesh must be static");
        require(def->mass == 0.0f || !def->is_collision_only, name + ": a plain collision object has no mass");
        require(!def->is_kinematic || (def->mass == 0.0f && !def->is_collision_only),
                name + ": a kinematic body is a rigid body of mass 0");
        builder->description.rigids.push_back({name, checked_shape(def->shape, name), def->mass, def->pose,
                                               def->friction, def->is_collision_only, def->is_kinematic});
    });
    return static_cast<int>(builder->description.rigids.size()) - 1;
}

static bool is_share(float value) {
    return value >= 0.0f && value <= 1.0f;
}

static void check_clusters(const scene_soft_def& def, const std::string& name) {
    require(!def.has_clusters || def.cluster_count >= 0, name + ": the number of clusters must not be negative");
    require(is_share(def.cluster_matching) && is_share(def.cluster_node_damping),
            name + ": matching and node damping of a cluster must be between 0 and 1");
    require(!def.has_cluster_contacts || def.has_clusters, name + ": cluster contacts need clusters");
    require(!def.has_cluster_contacts || (!def.has_rigid_contacts && !def.has_soft_contacts),
            name + ": btSoftBody knows one friction for all contacts; choose those of clusters or the others");
    require(!def.has_cluster_contacts || (def.cluster_contacts.with_rigids && def.cluster_contacts.with_bodies),
            name + ": clusters meet rigid bodies and soft bodies");
}

static void check_soft(const scene_soft_def& def, const std::string& name) {
    const pli_solver_settings& solver = def.solver;
    require(def.collision_margin >= 0.0f && std::isfinite(def.collision_margin),
            name + ": the collision margin must not be negative");
    require(solver.velocity_iterations >= 0 && solver.position_iterations >= 0 && solver.drift_iterations >= 0,
            name + ": iterations must not be negative");
    require(std::isfinite(def.pressure) && std::isfinite(def.volume_conservation) && std::isfinite(def.pose_matching),
            name + ": pressure, volume conservation and pose matching must be finite");
    require(!def.has_soft_contacts || !def.has_rigid_contacts ||
                std::equal_to<float>()(def.soft_contacts.friction, def.rigid_contacts.friction),
            name + ": btSoftBody knows one friction for rigid and soft contacts");
    check_clusters(def, name);
    require(def.link_stiffness >= 0.0f && std::isfinite(def.link_stiffness),
            name + ": the stiffness of links must not be negative");
    require(def.link_damping >= 0.0f && std::isfinite(def.link_damping),
            name + ": the damping of links must not be negative");
    require(def.self_collision == SCENE_SELF_NONE || is_positive(def.thickness),
            name + ": self-collision needs a thickness");
    require(is_share(def.self_friction), name + ": the friction of self-collision must be between 0 and 1");
}

int scene_add_soft(scene_builder* builder, pli_mesh* mesh, const scene_soft_def* def) {
    demos::MeshPointer owned(mesh);
    builder->guard([&] {
        require(def != nullptr && def->name != nullptr, "a soft body needs a definition with a name");
        require(mesh != nullptr && pli_mesh_get_view(mesh).node_count > 0,
                std::string(def->name) + ": a soft body needs a mesh with nodes");
        check_soft(*def, def->name);
        demos::SoftRecord record{};
        record.name = def->name;
        record.mesh = std::move(owned);
        record.def = *def;
        record.def.name = nullptr; // record.name is the copy that lasts
        if (def->self_collision != SCENE_SELF_NONE) {
            record.def.self_collision = builder->options.self_collision.value_or(def->self_collision);
            builder->description.has_self_collision = true;
        }
        record.order = static_cast<int>(builder->description.rigids.size());
        builder->description.softs.push_back(std::move(record));
    });
    return static_cast<int>(builder->description.softs.size()) - 1;
}

void scene_set_velocity(scene_builder* builder, int soft, pli_vec3 velocity) {
    builder->guard([&] {
        demos::SoftRecord& record = soft_record(builder, soft);
        require(is_finite(velocity), record.name + ": the velocity is not finite");
        record.velocity = velocity;
    });
}

void scene_add_first_force(scene_builder* builder, int soft, int node, pli_vec3 force) {
    builder->guard([&] {
        demos::SoftRecord& record = soft_record(builder, soft);
        require(is_finite(force), record.name + ": the force is not finite");
        record.first_forces.push_back({checked_node(record, node), force});
    });
}

void scene_add_anchor(scene_builder* builder, int soft, int node, int rigid, bool disable_collision, float influence) {
    builder->guard([&] {
        demos::SoftRecord& record = soft_record(builder, soft);
        const std::vector<demos::RigidRecord>& rigids = builder->description.rigids;
        checked_index(rigid, rigids.size(), "rigid body");
        require(!rigids[static_cast<size_t>(rigid)].is_collision_only,
                record.name + ": an anchor needs a rigid body, not a plain collision object");
        require(std::isfinite(influence), record.name + ": the influence of an anchor is not finite");
        record.anchors.push_back({checked_node(record, node), rigid, disable_collision, influence});
    });
}

void scene_set_gravity(scene_builder* builder, pli_vec3 gravity) {
    builder->guard([&] {
        require(is_finite(gravity), "the gravity is not finite");
        builder->description.gravity = gravity;
    });
}

void scene_set_camera(scene_builder* builder, scene_camera camera) {
    builder->guard([&] {
        require(is_finite(camera.target) && is_positive(camera.distance) && std::isfinite(camera.yaw_degrees) &&
                    std::isfinite(camera.pitch_degrees),
                "the camera needs a finite target and angles and a positive distance");
        builder->description.has_camera = true;
        builder->description.camera = camera;
    });
}
