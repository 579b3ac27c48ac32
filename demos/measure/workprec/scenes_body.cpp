// Closed and solid bodies: a ball that keeps its volume, a cube under its weight, the bunny.

#include "engines/solvers.h"
#include "measure/measure.h"
#include "scene_parts.h"
#include "scenes/scenes.h"

#include <algorithm>
#include <cmath>

namespace demos {

namespace {

void add_floor(scene_builder* builder) {
    const scene_rigid_def floor = scene_rigid_box("floor", pli_vec3_make(20, 1, 20), 0, pli_vec3_make(0, -1, 0));
    scene_add_rigid(builder, &floor);
}

// ------------------------------------------------------------------------------------------------ ball

constexpr float volume_stiffness = 300; // N/m^5

void build_ball(scene_builder* builder, float step_seconds) {
    add_floor(builder);
    pli_mesh* mesh = nullptr;
    scene_check(builder, pli_mesh_create_ellipsoid(scene_context(builder), pli_vec3_make(0, 0.7f, 0),
                                                   pli_vec3_make(0.5f, 0.5f, 0.5f), 200, &mesh));
    scene_check(builder, pli_mesh_set_total_mass(mesh, 1));
    scene_soft_def def = precision_def("ball", 5000, 2, step_seconds);
    def.volume_conservation = volume_stiffness;
    scene_add_soft(builder, mesh, &def);
}

double enclosed_volume(const SoftState& state) {
    double volume = 0;
    for (size_t i = 0; i < state.face_nodes.size(); i += 3) {
        const auto corner = [&](size_t k) { return state.positions[static_cast<size_t>(state.face_nodes[i + k])]; };
        volume += static_cast<double>(pli_vec3_dot(corner(0), pli_vec3_cross(corner(1), corner(2)))) / 6;
    }
    return volume;
}

// Over the whole run: at its end alone the volume is too large with some settings and too small with others, and those
// between happen to be right.
class BallEvaluation final : public Evaluation {
public:
    void after_step(const Engine& engine, int) override {
        const double at_rest = static_cast<double>(pli_mesh_volume(engine.description().softs.front().mesh.get()));
        const double error = enclosed_volume(engine.soft(0)) / at_rest - 1;
        squares_ += error * error;
        ++steps_;
    }
    std::vector<double> errors(const Engine& engine) override {
        return {std::sqrt(squares_ / steps_), measure(engine).rms_stretch};
    }

private:
    double squares_ = 0;
    int steps_ = 0;
};

PrecisionScene ball() {
    PrecisionScene made;
    made.name = "volume";
    made.summary = "A ball that keeps its volume falls to the ground.";
    made.metrics = {{"E3", "volume / volume at rest - 1, root mean square over 5 s"}, {"E3_stretch", "rms stretch"}};
    made.seconds = 5;
    made.build = build_ball;
    made.evaluate = [](const Setting&) { return std::make_unique<BallEvaluation>(); };
    return made;
}

// ------------------------------------------------------------------------------------------------ cube

// The edges of the tetrahedra alone, held at the bottom: what all solvers have in common.
void build_cube(scene_builder* builder, float step_seconds) {
    pli_mesh* solid = scene_tetra_mesh(builder, "tetra_cube");
    pli_mesh* mesh = nullptr;
    if (solid == nullptr || !scene_check(builder, pli_mesh_create(scene_context(builder), &mesh))) {
        pli_mesh_destroy(solid);
        return;
    }
    const pli_mesh_view view = pli_mesh_get_view(solid);
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec3 p = pli_vec3_scale(view.positions[i], 0.5f);
        const float mass = p.y < -0.499f ? 0.0f : 0.01f;
        scene_check(builder, pli_mesh_append_node(mesh, p, mass, nullptr));
    }
    for (int i = 0; i < view.link_count; ++i) {
        scene_check(builder, pli_mesh_append_link(mesh, view.links[i].nodes[0], view.links[i].nodes[1], 0, nullptr));
    }
    pli_mesh_destroy(solid);
    scene_check(builder, pli_mesh_shuffle_links(mesh));
    const scene_soft_def def = precision_def("cube", 100, 3, step_seconds);
    scene_add_soft(builder, mesh, &def);
}

PrecisionScene cube() {
    PrecisionScene made;
    made.name = "cube";
    made.summary = "A cube of tetrahedra of 100 N/m, held below, sinks under its weight.";
    made.metrics = {{"E2", "distance from its place at rest / size"}};
    made.seconds = 6;
    made.build = build_cube;
    made.evaluate = against_rest(made, nullptr);
    return made;
}

// ------------------------------------------------------------------------------------------------ bunny

void build_bunny(scene_builder* builder, float) {
    scene_find("Bunny")->build(builder);
}

// Mean stretch over the fall and the time after it, penetration of the ground at the end.
class BunnyEvaluation final : public Evaluation {
public:
    void after_step(const Engine& engine, int) override {
        stretch_ += measure(engine).rms_stretch;
        ++steps_;
    }
    std::vector<double> errors(const Engine& engine) override { return {stretch_ / steps_, measure(engine).rms_speed}; }

private:
    double stretch_ = 0;
    int steps_ = 0;
};

PrecisionScene bunny() {
    PrecisionScene made;
    made.name = "bunny";
    made.summary = "A bunny falls to the ground.";
    made.metrics = {{"E3", "rms stretch, mean over 3 s"}, {"E5", "rms speed at the end, m/s"}};
    made.seconds = 3;
    made.build = build_bunny;
    made.evaluate = [](const Setting&) { return std::make_unique<BunnyEvaluation>(); };
    return made;
}

} // namespace

void add_body_scenes(std::vector<PrecisionScene>& scenes) {
    scenes.push_back(ball());
    scenes.push_back(cube());
    scenes.push_back(bunny());
}

} // namespace demos
