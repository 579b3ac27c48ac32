// A rope that hangs between two points, and one that swings with a box at its end.

#include "measure/measure.h"
#include "scene_parts.h"

#include <algorithm>
#include <cmath>

namespace demos {

namespace {

constexpr int rope_links = 20;
constexpr float rope_link = 0.1f, rope_span = 1.2f, node_mass = 0.05f;
constexpr float stiff = 1e6f; // N/m: links keep their length to some 1e-5

// Falls from the shape of a V.
void build_hanging_rope(scene_builder* builder, float step_seconds) {
    std::vector<pli_vec3> places;
    std::vector<float> masses(rope_links + 1, node_mass);
    masses.front() = masses.back() = 0;
    const float part = rope_span / rope_links, drop = std::sqrt(rope_link * rope_link - part * part);
    for (int i = 0; i <= rope_links; ++i) {
        const auto down = static_cast<float>(std::min(i, rope_links - i));
        places.push_back(pli_vec3_make(part * static_cast<float>(i), -drop * down, 0));
    }
    const scene_soft_def def = precision_def("rope", stiff, 3, step_seconds);
    scene_add_soft(builder, make_chain(builder, places, masses), &def);
}

PrecisionScene hanging_rope() {
    PrecisionScene made;
    made.name = "rope";
    made.summary = "A rope hangs between two points.";
    made.metrics = {{"E2", "distance from the catenary / size"}, {"E3", "rms stretch"}};
    made.seconds = 10;
    made.build = build_hanging_rope;
    const std::vector<reference::Point> expected =
        reference::hanging_chain(rope_links, static_cast<double>(rope_link), static_cast<double>(rope_span));
    made.evaluate = at_the_end([expected](const Engine& engine) -> std::vector<double> {
        return {position_error(engine, expected), measure(engine).rms_stretch};
    });
    return made;
}

constexpr float swing_seconds = 1, swing_interval = 0.1f;
constexpr float box_mass = 1;

void build_swinging_rope(scene_builder* builder, float step_seconds) {
    std::vector<pli_vec3> places;
    std::vector<float> masses(rope_links + 1, 0.01f);
    masses.front() = 0;
    for (int i = 0; i <= rope_links; ++i) {
        places.push_back(pli_vec3_make(rope_link * static_cast<float>(i), 0, 0));
    }
    const scene_soft_def def = precision_def("rope", stiff, 0, step_seconds);
    const int rope = scene_add_soft(builder, make_chain(builder, places, masses), &def);
    const scene_rigid_def box = scene_rigid_box("box", pli_vec3_make(0.05f, 0.05f, 0.05f), box_mass, places.back());
    scene_add_anchor(builder, rope, rope_links, scene_add_rigid(builder, &box), true, 1);
}

// Held at its centre the box does not turn: it is a mass at the end of the rope.
std::vector<std::vector<reference::Point>> swing_reference(const PrecisionScene& which) {
    reference::Network network = network_of(which);
    network.masses.back() += static_cast<double>(box_mass);
    constexpr int steps = 8000;
    return reference::trajectory(network, static_cast<double>(swing_interval),
                                 static_cast<int>(std::lround(swing_seconds / swing_interval)), steps);
}

class SwingEvaluation final : public Evaluation {
public:
    SwingEvaluation(const Setting& setting, std::vector<std::vector<reference::Point>> expected)
        : expected_(std::move(expected)),
          steps_(static_cast<int>(std::lround(swing_interval * static_cast<float>(setting.steps_per_second)))) {}

    void after_step(const Engine& engine, int step) override {
        if (step % steps_ != 0) { return; }
        const double error = position_error(engine, expected_.at(static_cast<size_t>(step / steps_ - 1)));
        squares_ += error * error;
        stretch_ = std::max(stretch_, measure(engine).rms_stretch);
        ++samples_;
    }
    std::vector<double> errors(const Engine&) override { return {std::sqrt(squares_ / samples_), stretch_}; }

private:
    const std::vector<std::vector<reference::Point>> expected_;
    int steps_, samples_ = 0;
    double squares_ = 0, stretch_ = 0;
};

PrecisionScene swinging_rope() {
    PrecisionScene made;
    made.name = "swing";
    made.summary = "A rope with a box at its end swings down.";
    made.metrics = {{"E1", "distance from the trajectory / size"}, {"E3", "largest rms stretch"}};
    made.seconds = static_cast<double>(swing_seconds);
    made.build = build_swinging_rope;
    const PrecisionScene bare = made;
    made.evaluate = [bare](const Setting& setting) {
        static const std::vector<std::vector<reference::Point>> expected = swing_reference(bare);
        return std::make_unique<SwingEvaluation>(setting, expected);
    };
    return made;
}

} // namespace

void add_rope_scenes(std::vector<PrecisionScene>& scenes) {
    scenes.push_back(hanging_rope());
    scenes.push_back(swinging_rope());
}

} // namespace demos
