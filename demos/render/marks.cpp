#include "marks.h"

#include <algorithm>

namespace render {

static constexpr pli_vec3 normal_color{0.02f, 0.25f, 0.60f}; // linear
static constexpr pli_vec3 contact_color{0.75f, 0.02f, 0.02f};
static constexpr pli_vec3 cluster_colors[] = {{0.05f, 0.45f, 0.15f}, {0.10f, 0.25f, 0.75f}, {0.75f, 0.55f, 0.02f},
                                              {0.45f, 0.08f, 0.55f}, {0.02f, 0.50f, 0.55f}, {0.75f, 0.20f, 0.05f}};
static constexpr int tube_slices = 5;

static Batch marks_batch(pli_vec3 color, bool is_on_top) {
    Batch batch;
    batch.is_on_top = is_on_top;
    batch.front = batch.back = color;
    batch.has_shadow = false;
    return batch;
}

// As long as the mesh is fine: half of the mean rest length.
static float normal_length(const demos::SoftState& soft) {
    float sum = 0.0f;
    for (const float length : soft.rest_lengths) {
        sum += length;
    }
    return soft.rest_lengths.empty() ? 0.0f : 0.5f * sum / static_cast<float>(soft.rest_lengths.size());
}

static Batch make_normals(const Snapshot& snapshot, float pixel) {
    Batch batch = marks_batch(normal_color, false);
    for (const demos::SoftState& soft : snapshot.softs) {
        if (soft.face_nodes.empty()) { continue; }
        const std::vector<pli_vec3> normals = smooth_normals(soft.positions, soft.face_nodes);
        std::vector<bool> in_face(soft.positions.size());
        for (const int node : soft.face_nodes) {
            in_face[static_cast<size_t>(node)] = true;
        }
        const float length = std::max(normal_length(soft), 6.0f * pixel);
        for (size_t i = 0; i < normals.size(); ++i) {
            if (!in_face[i]) { continue; }
            append_tube(batch, soft.positions[i], soft.positions[i] + normals[i] * length, 0.8f * pixel, tube_slices);
        }
    }
    return batch;
}

static Batch make_contacts(const Snapshot& snapshot, float pixel) {
    Batch batch = marks_batch(contact_color, true);
    for (const std::vector<demos::ContactMark>& contacts : snapshot.contacts) {
        for (const demos::ContactMark& contact : contacts) {
            pli_transform pose = pli_transform_identity();
            pose.origin = contact.point;
            append_sphere(batch, 2.5f * pixel, pose, 8);
            append_tube(batch, contact.point, contact.point + contact.normal * (22.0f * pixel), 1.2f * pixel,
                        tube_slices);
        }
    }
    return batch;
}

// A star from the centre of each cluster to its nodes.
static void append_clusters(std::vector<Batch>& batches, const Snapshot& snapshot, float pixel) {
    const size_t first = batches.size();
    for (const pli_vec3 color : cluster_colors) {
        batches.push_back(marks_batch(color, true));
    }
    for (size_t i = 0; i < snapshot.clusters.size(); ++i) {
        for (size_t k = 0; k < snapshot.clusters[i].size(); ++k) {
            const demos::ClusterMark& cluster = snapshot.clusters[i][k];
            Batch& batch = batches[first + k % std::size(cluster_colors)];
            for (const int node : cluster.nodes) {
                append_tube(batch, cluster.center, snapshot.softs[i].positions[static_cast<size_t>(node)], 0.7f * pixel,
                            tube_slices);
            }
        }
    }
}

void append_marks(std::vector<Batch>& batches, const Snapshot& snapshot, float pixel, const Look& look) {
    if (look.normals) { batches.push_back(make_normals(snapshot, pixel)); }
    if (look.contacts) { batches.push_back(make_contacts(snapshot, pixel)); }
    if (look.clusters) { append_clusters(batches, snapshot, pixel); }
}

} // namespace render
