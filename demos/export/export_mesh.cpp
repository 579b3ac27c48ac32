#include "export_mesh.h"

#include "render/bodies.h"
#include "render/geometry.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <unordered_map>

namespace exporting {

// Stretch of links by their ends, in either order.
class LinkStretch {
public:
    explicit LinkStretch(const demos::SoftState& soft) {
        for (size_t i = 0; i < soft.rest_lengths.size(); ++i) {
            const int a = soft.link_nodes[2 * i], b = soft.link_nodes[2 * i + 1];
            const float length = pli_vec3_length(
                pli_vec3_sub(soft.positions[static_cast<size_t>(a)], soft.positions[static_cast<size_t>(b)]));
            const float rest = soft.rest_lengths[i];
            of_link.push_back(rest > 0.0f ? length / rest - 1.0f : 0.0f);
            by_ends_.emplace(key(a, b), of_link.back());
        }
    }

    // Of each cell of `corners` nodes.
    std::vector<float> mean_of_cells(const std::vector<int>& nodes, size_t corners) const {
        std::vector<float> means;
        for (size_t first = 0; first + corners <= nodes.size(); first += corners) {
            float sum = 0.0f;
            int count = 0;
            for (size_t i = 0; i < corners; ++i) {
                for (size_t k = i + 1; k < corners; ++k) {
                    const auto found = by_ends_.find(key(nodes[first + i], nodes[first + k]));
                    if (found == by_ends_.end()) { continue; }
                    sum += found->second;
                    ++count;
                }
            }
            means.push_back(count > 0 ? sum / static_cast<float>(count) : 0.0f);
        }
        return means;
    }

    std::vector<float> of_link;

private:
    static uint64_t key(int a, int b) {
        return static_cast<uint64_t>(std::min(a, b)) << 32 | static_cast<uint64_t>(std::max(a, b));
    }

    std::unordered_map<uint64_t, float> by_ends_;
};

// Of nodes of triangles and tetrahedra; a link between two of them is drawn by these or bends them.
static std::vector<bool> nodes_of_cells(const ExportMesh& mesh) {
    std::vector<bool> in_cell(mesh.points.size());
    for (const std::vector<int>* nodes : {&mesh.triangles, &mesh.tetras}) {
        for (const int node : *nodes) {
            in_cell[static_cast<size_t>(node)] = true;
        }
    }
    return in_cell;
}

std::string file_name(const std::string& text) {
    std::string name = text;
    for (char& c : name) {
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-') { c = '_'; }
    }
    return name;
}

ExportMesh take_soft(const demos::Engine& engine, int index) {
    const demos::SoftState soft = engine.soft(index);
    ExportMesh mesh;
    mesh.name =
        "soft" + std::to_string(index) + "_" + file_name(engine.description().softs[static_cast<size_t>(index)].name);
    mesh.points = soft.positions;
    mesh.velocities = soft.velocities;
    mesh.tetras = soft.tetra_nodes;
    mesh.triangles_are_surface = soft.face_nodes.empty();
    mesh.triangles = mesh.triangles_are_surface ? render::tetra_surface(soft) : soft.face_nodes;
    mesh.normals = render::smooth_normals(mesh.points, mesh.triangles);
    const LinkStretch stretch(soft);
    mesh.triangle_stretch = stretch.mean_of_cells(mesh.triangles, 3);
    mesh.tetra_stretch = stretch.mean_of_cells(mesh.tetras, 4);
    const std::vector<bool> in_cell = nodes_of_cells(mesh);
    for (size_t i = 0; i < stretch.of_link.size(); ++i) {
        const int a = soft.link_nodes[2 * i], b = soft.link_nodes[2 * i + 1];
        if (in_cell[static_cast<size_t>(a)] && in_cell[static_cast<size_t>(b)]) { continue; }
        mesh.lines.insert(mesh.lines.end(), {a, b});
        mesh.line_stretch.push_back(stretch.of_link[i]);
    }
    return mesh;
}

} // namespace exporting
