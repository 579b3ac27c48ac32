#include "scene_parts.h"

#include "description/function_scene.h"
#include "description/recorder.h"
#include "engines/solvers.h"

#include <cmath>

namespace demos {

pli_mesh* make_chain(scene_builder* builder, const std::vector<pli_vec3>& places, const std::vector<float>& masses) {
    pli_mesh* mesh = nullptr;
    if (!scene_check(builder, pli_mesh_create(scene_context(builder), &mesh))) { return nullptr; }
    for (size_t i = 0; i < places.size(); ++i) {
        int node = 0;
        scene_check(builder, pli_mesh_append_node(mesh, places[i], masses[i], &node));
        if (node > 0) { scene_check(builder, pli_mesh_append_link(mesh, node - 1, node, 0, nullptr)); }
    }
    return mesh;
}

pli_mesh* make_grid(scene_builder* builder, const GridDef& grid) {
    pli_mesh* mesh = nullptr;
    if (!scene_check(builder, pli_mesh_create(scene_context(builder), &mesh))) { return nullptr; }
    const auto node = [&](int column, int row) { return row * grid.columns + column; };
    for (int row = 0; row < grid.rows; ++row) {
        for (int column = 0; column < grid.columns; ++column) {
            scene_check(builder, pli_mesh_append_node(mesh, grid.place(column, row), grid.mass(column, row), nullptr));
        }
    }
    const auto link = [&](int a, int b) { scene_check(builder, pli_mesh_append_link(mesh, a, b, 0, nullptr)); };
    const auto face = [&](int a, int b, int c) {
        scene_check(builder, pli_mesh_append_face(mesh, a, b, c, 0, nullptr));
    };
    for (int row = 0; row < grid.rows; ++row) {
        for (int column = 0; column < grid.columns; ++column) {
            const int here = node(column, row);
            const bool has_right = column + 1 < grid.columns, has_below = row + 1 < grid.rows;
            if (has_right) { link(here, here + 1); }
            if (has_below) { link(here, here + grid.columns); }
            if (!has_right || !has_below) { continue; }
            const int right = here + 1, below = here + grid.columns, across = below + 1;
            if ((column + row) % 2 == 0) {
                link(here, across);
                face(here, below, across);
                face(here, across, right);
            } else {
                link(right, below);
                face(here, below, right);
                face(right, below, across);
            }
        }
    }
    return mesh;
}

scene_soft_def precision_def(const char* name, float stiffness, float damping, float step_seconds) {
    scene_soft_def def = scene_soft_def_default();
    def.name = name;
    def.link_stiffness = stiffness;
    def.collision_margin = 0.02f;
    def.solver.velocity_damping = 1.0f - std::exp(-damping * step_seconds);
    return def;
}

static reference::Point to_reference(pli_vec3 p) {
    return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

reference::Network network_of(const PrecisionScene& which) {
    const FunctionScene source(which.name, [&](scene_builder* builder) { which.build(builder, frame_seconds); });
    const std::unique_ptr<Description> description = Description::build(source, {});
    const SoftRecord& soft = description->softs.front();
    const pli_mesh_view mesh = pli_mesh_get_view(soft.mesh.get());
    reference::Network network;
    network.gravity = to_reference(description->gravity);
    for (int i = 0; i < mesh.node_count; ++i) {
        network.positions.push_back(to_reference(mesh.positions[i]));
        const double inverse = static_cast<double>(mesh.inverse_masses[i]);
        network.masses.push_back(inverse > 0.0 ? 1.0 / inverse : 0.0);
    }
    for (int i = 0; i < mesh.link_count; ++i) {
        const pli_link& link = mesh.links[i];
        const reference::Point a = network.positions[static_cast<size_t>(link.nodes[0])];
        const reference::Point b = network.positions[static_cast<size_t>(link.nodes[1])];
        const double share = static_cast<double>(mesh.materials[link.material].linear_stiffness);
        network.springs.push_back(
            {link.nodes[0], link.nodes[1], share * link_stiffness(soft), std::hypot(b.x - a.x, b.y - a.y, b.z - a.z)});
    }
    return network;
}

double position_error(const Engine& engine, const std::vector<reference::Point>& expected) {
    const std::vector<pli_vec3> positions = engine.soft(0).positions;
    double sum = 0;
    for (size_t i = 0; i < positions.size(); ++i) {
        const reference::Point p = to_reference(positions[i]);
        const double distance = std::hypot(p.x - expected[i].x, p.y - expected[i].y, p.z - expected[i].z);
        sum += distance * distance;
    }
    return std::sqrt(sum / static_cast<double>(positions.size())) / bounds_diagonal(engine.description().rest_bounds);
}

namespace {

class EndEvaluation final : public Evaluation {
public:
    explicit EndEvaluation(std::function<std::vector<double>(const Engine&)> errors) : errors_(std::move(errors)) {}
    std::vector<double> errors(const Engine& engine) override { return errors_(engine); }

private:
    std::function<std::vector<double>(const Engine&)> errors_;
};

} // namespace

std::function<std::unique_ptr<Evaluation>(const Setting&)>
at_the_end(std::function<std::vector<double>(const Engine&)> errors) {
    return [errors](const Setting&) { return std::make_unique<EndEvaluation>(errors); };
}

// The reference is found when it is first needed.
std::function<std::unique_ptr<Evaluation>(const Setting&)> against_rest(const PrecisionScene& which,
                                                                        std::function<double(const Engine&)> other) {
    const PrecisionScene bare = which;
    const auto expected = std::make_shared<std::vector<reference::Point>>();
    return [bare, other, expected](const Setting&) {
        if (expected->empty()) { *expected = reference::rest(network_of(bare)); }
        return std::make_unique<EndEvaluation>([other, expected](const Engine& engine) {
            std::vector<double> errors{position_error(engine, *expected)};
            if (other) { errors.push_back(other(engine)); }
            return errors;
        });
    };
}

const std::vector<PrecisionScene>& precision_scenes() {
    static const std::vector<PrecisionScene> scenes = [] {
        std::vector<PrecisionScene> made;
        add_rope_scenes(made);
        add_sheet_scenes(made);
        add_body_scenes(made);
        add_invariant_scenes(made);
        return made;
    }();
    return scenes;
}

} // namespace demos
