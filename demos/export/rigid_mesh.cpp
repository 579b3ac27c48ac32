#include "rigid_mesh.h"

#include "render/bodies.h"

#include <array>
#include <map>

namespace exporting {

// A point on a sharp edge is there once for each of its normals.
static void weld(const std::vector<render::Vertex>& vertices, ExportMesh& mesh) {
    std::map<std::array<float, 6>, int> known;
    for (const render::Vertex& vertex : vertices) {
        const pli_vec3 p = vertex.position, n = vertex.normal;
        const std::array<float, 6> key{p.x, p.y, p.z, n.x, n.y, n.z};
        const auto [entry, is_new] = known.try_emplace(key, static_cast<int>(mesh.points.size()));
        if (is_new) {
            mesh.points.push_back(p);
            mesh.normals.push_back(n);
        }
        mesh.triangles.push_back(entry->second);
    }
}

RigidMesh::RigidMesh(const demos::Engine& engine, int index) : index_(index) {
    const demos::RigidRecord& record = engine.rigid_record(index);
    render::Batch batch;
    render::append_shape(batch, record.shape, pli_transform_identity());
    weld(batch.vertices, local_);
    local_.name = "rigid" + std::to_string(index) + "_" + file_name(record.name);
    local_.triangle_stretch.assign(local_.triangles.size() / 3, 0.0f);
}

ExportMesh RigidMesh::take(const demos::Engine& engine) const {
    const demos::RigidState state = engine.rigid(index_);
    ExportMesh mesh = local_;
    for (size_t i = 0; i < mesh.points.size(); ++i) {
        mesh.points[i] = pli_transform_point(state.pose, local_.points[i]);
        mesh.normals[i] = pli_mat3_mul_vec3(state.pose.rotation, local_.normals[i]);
        const pli_vec3 arm = pli_vec3_sub(mesh.points[i], state.pose.origin);
        mesh.velocities.push_back(pli_vec3_add(state.linear_velocity, pli_vec3_cross(state.angular_velocity, arm)));
    }
    return mesh;
}

} // namespace exporting
