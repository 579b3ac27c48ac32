#include "bodies.h"

#include "description/finite.h"
#include "marks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace render {

// Warm, saturated colours for what is soft, cool greys and blues for what is rigid; sRGB.
static constexpr unsigned soft_colors[] = {0xe4572e, 0xf2a31b, 0xc43d8b, 0x8f2d56,
                                           0xe8c53a, 0xd7263d, 0xf58a4b, 0x9a4fb5};
static constexpr unsigned moving_colors[] = {0x4f7da6, 0x7d93ad, 0x35607f, 0x93b1c9, 0x5a6b80, 0x3f8f9b};
static constexpr unsigned static_colors[] = {0x8d99a6, 0x76838f, 0xa3adb8};
static constexpr unsigned ground_color = 0xb4bcc0;
static constexpr unsigned pin_color = 0x23272e;
static constexpr unsigned anchor_color = 0xf6f1dc;

static float linear_channel(unsigned channel) {
    return std::pow(static_cast<float>(channel & 0xff) / 255.0f, 2.2f);
}

static pli_vec3 linear_color(unsigned srgb) {
    return pli_vec3_make(linear_channel(srgb >> 16), linear_channel(srgb >> 8), linear_channel(srgb));
}

template <size_t count> static pli_vec3 pick_color(const unsigned (&colors)[count], size_t index) {
    return linear_color(colors[index % count]);
}

static pli_vec3 point_at(const std::vector<pli_vec3>& points, int index) {
    return points[static_cast<size_t>(index)];
}

// ---------------------------------------------------------------------------------------------- rigid bodies

void append_shape(Batch& batch, const demos::Shape& shape, const pli_transform& pose) {
    switch (shape.kind) {
    case SCENE_SHAPE_BOX:
        append_box(batch, shape.half_extents, pose);
        break;
    case SCENE_SHAPE_SPHERE:
        append_sphere(batch, shape.radius, pose, 48);
        break;
    case SCENE_SHAPE_CAPSULE:
        append_capsule(batch, shape.radius, shape.half_height, shape.axis, pose);
        break;
    case SCENE_SHAPE_CYLINDER: {
        const std::array<float, 3> half{shape.half_extents.x, shape.half_extents.y, shape.half_extents.z};
        const auto axis = static_cast<size_t>(shape.axis);
        // Bullet takes the radius from the next axis, or x for a cylinder along y or z.
        append_cylinder(batch, shape.axis == 0 ? half[1] : half[0], half[axis], shape.axis, pose);
        break;
    }
    case SCENE_SHAPE_TRIANGLE_MESH:
        append_mesh(batch, shape.points, shape.triangles, pose);
        break;
    case SCENE_SHAPE_COMPOUND:
        for (size_t i = 0; i < shape.children.size(); ++i) {
            append_shape(batch, shape.children[i], pli_transform_mul(pose, shape.child_poses[i]));
        }
        break;
    }
}

static Batch make_rigid(const demos::RigidRecord& record, const pli_transform& pose) {
    Batch batch;
    append_shape(batch, record.shape, pose);
    return batch;
}

bool is_ground(const Extent::Rigid& rigid, const Box& soft) {
    const pli_vec3 size = rigid.bounds.max - rigid.bounds.min;
    return rigid.is_static && std::min(size.x, size.z) > 2.5f * std::max(soft.diagonal(), 1.0f);
}

float ground_height(const std::vector<Extent>& extents) {
    float height = -1e30f;
    for (const Extent& extent : extents) {
        for (const Extent::Rigid& rigid : extent.rigids) {
            const bool is_below = rigid.bounds.max.y <= extent.soft.max.y;
            if (is_below && is_ground(rigid, extent.soft)) { height = std::max(height, rigid.bounds.max.y); }
        }
    }
    return height;
}

// ----------------------------------------------------------------------------------------------- soft bodies

std::vector<int> tetra_surface(const demos::SoftState& soft) {
    static constexpr int sides[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
    struct Side {
        int count;
        std::array<int, 4> nodes; // three corners, then the node across
    };
    std::map<std::array<int, 3>, Side> found;
    for (size_t i = 0; i + 3 < soft.tetra_nodes.size(); i += 4) {
        for (const auto& side : sides) {
            std::array<int, 4> nodes{};
            for (size_t k = 0; k < 4; ++k) {
                nodes[k] = soft.tetra_nodes[i + static_cast<size_t>(side[k])];
            }
            std::array<int, 3> key{nodes[0], nodes[1], nodes[2]};
            std::sort(key.begin(), key.end());
            Side& entry = found.try_emplace(key, Side{0, nodes}).first->second;
            ++entry.count;
        }
    }
    std::vector<int> faces;
    for (const auto& [key, side] : found) {
        if (side.count != 1) { continue; }
        const pli_vec3 a = point_at(soft.positions, side.nodes[0]), b = point_at(soft.positions, side.nodes[1]),
                       c = point_at(soft.positions, side.nodes[2]), across = point_at(soft.positions, side.nodes[3]);
        const bool is_inward = pli_vec3_dot(pli_vec3_cross(b - a, c - a), across - a) > 0.0f;
        faces.insert(faces.end(), {side.nodes[0], side.nodes[is_inward ? 2 : 1], side.nodes[is_inward ? 1 : 2]});
    }
    return faces;
}

static float median_rest_length(const demos::SoftState& soft) {
    std::vector<float> lengths = soft.rest_lengths;
    if (lengths.empty()) { return 0.0f; }
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    return *middle;
}

static pli_transform place_at(pli_vec3 origin) {
    pli_transform pose = pli_transform_identity();
    pose.origin = origin;
    return pose;
}

// Links that belong to no face and to no tetrahedron, as tubes with round joints.
static void append_ropes(Batch& batch, const demos::SoftState& soft, const std::vector<int>& faces, float pixel) {
    std::vector<bool> in_face(soft.positions.size()), has_joint(soft.positions.size());
    for (const std::vector<int>* nodes : {&faces, &soft.tetra_nodes}) {
        for (const int node : *nodes) {
            in_face[static_cast<size_t>(node)] = true;
        }
    }
    const float radius = std::max(0.1f * median_rest_length(soft), 2.2f * pixel);
    for (size_t i = 0; i + 1 < soft.link_nodes.size(); i += 2) {
        const int ends[2] = {soft.link_nodes[i], soft.link_nodes[i + 1]};
        if (in_face[static_cast<size_t>(ends[0])] && in_face[static_cast<size_t>(ends[1])]) { continue; }
        append_tube(batch, point_at(soft.positions, ends[0]), point_at(soft.positions, ends[1]), radius);
        for (const int end : ends) {
            if (has_joint[static_cast<size_t>(end)]) { continue; }
            has_joint[static_cast<size_t>(end)] = true;
            append_sphere(batch, 1.3f * radius, place_at(point_at(soft.positions, end)), 20);
        }
    }
}

static Batch make_soft(const demos::SoftState& soft, size_t index, float pixel, const Look& look) {
    Batch batch;
    batch.front = pick_color(soft_colors, index);
    batch.back = pli_vec3_lerp(batch.front, linear_color(0xfff2dc), 0.22f);
    batch.wire = look.mesh_lines || look.wireframe ? 0.6f : 0.0f;
    batch.is_hollow = look.wireframe;
    batch.gloss = 0.18f;
    const std::vector<int> faces = soft.face_nodes.empty() ? tetra_surface(soft) : soft.face_nodes;
    append_mesh(batch, soft.positions, faces, pli_transform_identity());
    append_ropes(batch, soft, faces, pixel);
    return batch;
}

// Small balls where nodes are pinned or anchored.
static Batch make_markers(const Snapshot& snapshot, float pixel) {
    Batch batch;
    batch.front = batch.back = linear_color(pin_color);
    batch.gloss = 0.3f;
    for (const demos::SoftState& soft : snapshot.softs) {
        for (size_t i = 0; i < soft.positions.size(); ++i) {
            if (soft.inverse_masses[i] == 0.0f) { append_sphere(batch, 5.0f * pixel, place_at(soft.positions[i]), 16); }
        }
    }
    return batch;
}

static Batch make_anchors(const Snapshot& snapshot, float pixel) {
    Batch batch;
    batch.front = batch.back = linear_color(anchor_color);
    batch.gloss = 0.3f;
    for (size_t i = 0; i < snapshot.softs.size() && i < snapshot.description->softs.size(); ++i) {
        for (const demos::AnchorRecord& anchor : snapshot.description->softs[i].anchors) {
            append_sphere(batch, 5.0f * pixel, place_at(point_at(snapshot.softs[i].positions, anchor.node)), 16);
        }
    }
    return batch;
}

// -------------------------------------------------------------------------------------------------- snapshot

Extent measure_extent(const Snapshot& snapshot) {
    Extent extent;
    for (const demos::SoftState& soft : snapshot.softs) {
        for (const pli_vec3 position : soft.positions) {
            if (!demos::is_finite(position)) {
                throw demos::Error("no picture of a scene with a node that is not finite");
            }
            extent.soft.add(position);
            extent.soft_points.push_back(position);
        }
    }
    for (size_t i = 0; i < snapshot.rigids.size(); ++i) {
        const demos::RigidRecord& record = snapshot.rigid_record(i);
        Extent::Rigid rigid{{}, record.mass == 0.0f};
        for (const Vertex& vertex : make_rigid(record, snapshot.rigids[i].pose).vertices) {
            if (!demos::is_finite(vertex.position)) {
                throw demos::Error("no picture of a scene with a rigid body that is not finite");
            }
            rigid.bounds.add(vertex.position);
        }
        extent.rigids.push_back(rigid);
    }
    return extent;
}

std::vector<Batch> make_batches(const Snapshot& snapshot, const Extent& extent, const Box& soft, float pixel,
                                const Look& look) {
    std::vector<Batch> batches;
    size_t moving = 0, standing = 0;
    for (size_t i = 0; i < snapshot.rigids.size(); ++i) {
        Batch batch = make_rigid(snapshot.rigid_record(i), snapshot.rigids[i].pose);
        batch.gloss = 0.15f;
        if (is_ground(extent.rigids[i], soft)) {
            batch.surface = Surface::ground;
            batch.front = linear_color(ground_color);
            batch.gloss = 0.0f;
        } else if (extent.rigids[i].is_static) {
            batch.front = pick_color(static_colors, standing++);
        } else {
            batch.front = pick_color(moving_colors, moving++);
        }
        batch.back = batch.front;
        batches.push_back(std::move(batch));
    }
    for (size_t i = 0; i < snapshot.softs.size(); ++i) {
        batches.push_back(make_soft(snapshot.softs[i], i, pixel, look));
    }
    batches.push_back(make_markers(snapshot, pixel));
    batches.push_back(make_anchors(snapshot, pixel));
    append_marks(batches, snapshot, pixel, look);
    return batches;
}

} // namespace render
