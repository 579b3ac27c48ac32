// What a step should keep: the equation of motion itself, momentum and energy.

#include "scene_parts.h"

#include <cmath>

namespace demos {

namespace {

using reference::Point;

Point from(pli_vec3 p) {
    return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

// ------------------------------------------------------------------------------------------------ free rope

constexpr int free_links = 20;
constexpr float free_rate = 3; // rad/s

// A free rope gets a spin in its first step and turns about its middle.
void build_free_rope(scene_builder* builder, float step_seconds) {
    constexpr float link = 0.1f, mass = 0.05f;
    std::vector<pli_vec3> places;
    for (int i = 0; i <= free_links; ++i) {
        places.push_back(pli_vec3_make(link * static_cast<float>(i - free_links / 2), 0, 0));
    }
    scene_set_gravity(builder, pli_vec3_make(0, 0, 0));
    const scene_soft_def def = precision_def("rope", 1e4f, 0, step_seconds);
    const std::vector<float> masses(places.size(), mass);
    const int rope = scene_add_soft(builder, make_chain(builder, places, masses), &def);
    for (int i = 0; i <= free_links; ++i) {
        const float speed = free_rate * places[static_cast<size_t>(i)].x;
        scene_add_first_force(builder, rope, i, pli_vec3_make(0, mass * speed / step_seconds, 0));
    }
}

struct Invariants {
    double momentum = 0, energy = 0; // about the z axis; of motion and springs
};

Invariants invariants_of(const Engine& engine, const reference::Network& network) {
    const SoftState state = engine.soft(0);
    Invariants sum;
    std::vector<Point> positions;
    for (size_t i = 0; i < state.positions.size(); ++i) {
        const Point p = from(state.positions[i]), v = from(state.velocities[i]);
        sum.momentum += network.masses[i] * (p.x * v.y - p.y * v.x);
        sum.energy += 0.5 * network.masses[i] * (v.x * v.x + v.y * v.y + v.z * v.z);
        positions.push_back(p);
    }
    sum.energy += reference::energy(network, positions);
    return sum;
}

class DriftEvaluation final : public Evaluation {
public:
    DriftEvaluation(reference::Network network, double seconds) : network_(std::move(network)), seconds_(seconds) {}

    void after_step(const Engine& engine, int step) override {
        if (step == 1) { start_ = invariants_of(engine, network_); }
    }
    std::vector<double> errors(const Engine& engine) override {
        const Invariants end = invariants_of(engine, network_);
        return {std::fabs(end.momentum / start_.momentum - 1) / seconds_,
                std::fabs(end.energy / start_.energy - 1) / seconds_};
    }

private:
    reference::Network network_;
    double seconds_;
    Invariants start_;
};

PrecisionScene free_rope() {
    PrecisionScene made;
    made.name = "spin";
    made.summary = "A free rope turns about its middle.";
    made.metrics = {{"E5_momentum", "change of angular momentum per second / itself"},
                    {"E5_energy", "change of energy per second / itself"}};
    made.seconds = 5;
    made.build = build_free_rope;
    const PrecisionScene bare = made;
    made.evaluate = [bare](const Setting&) {
        return std::make_unique<DriftEvaluation>(network_of(bare), bare.seconds);
    };
    return made;
}

// ------------------------------------------------------------------------------------------------ residual of a step

// A sheet held at one edge swings down, without damping.
void build_falling_sheet(scene_builder* builder, float step_seconds) {
    GridDef grid;
    grid.columns = grid.rows = 10;
    grid.place = [](int column, int row) {
        return pli_vec3_make(0.1f * static_cast<float>(column), 0, 0.1f * static_cast<float>(row));
    };
    grid.mass = [](int, int row) { return row == 0 ? 0.0f : 0.01f; };
    const scene_soft_def def = precision_def("sheet", 200, 0, step_seconds);
    scene_add_soft(builder, make_grid(builder, grid), &def);
}

// What is left of M (x - x^) / h^2 - f(x) at the end of each step, as an acceleration over that of gravity: x^ is where
// the nodes would be without springs.
class ResidualEvaluation final : public Evaluation {
public:
    ResidualEvaluation(reference::Network network, double step_seconds)
        : network_(std::move(network)), step_seconds_(step_seconds) {}

    void after_step(const Engine& engine, int) override {
        const SoftState now = engine.soft(0);
        if (!before_.positions.empty()) { add(now); }
        before_ = now;
    }
    std::vector<double> errors(const Engine&) override { return {std::sqrt(sum_ / steps_)}; }

private:
    void add(const SoftState& now) {
        std::vector<Point> positions;
        for (const pli_vec3 p : now.positions) {
            positions.push_back(from(p));
        }
        const std::vector<Point> pull = reference::accelerations(network_, positions);
        double weighted = 0, mass = 0;
        for (size_t i = 0; i < positions.size(); ++i) {
            if (!(network_.masses[i] > 0.0)) { continue; }
            const Point before = from(before_.positions[i]), v = from(before_.velocities[i]);
            const double h = step_seconds_;
            const double x = (positions[i].x - before.x - h * v.x) / (h * h) - pull[i].x;
            const double y = (positions[i].y - before.y - h * v.y) / (h * h) - pull[i].y;
            const double z = (positions[i].z - before.z - h * v.z) / (h * h) - pull[i].z;
            weighted += network_.masses[i] * (x * x + y * y + z * z);
            mass += network_.masses[i];
        }
        sum_ += weighted / mass / (network_.gravity.y * network_.gravity.y);
        ++steps_;
    }

    reference::Network network_;
    double step_seconds_, sum_ = 0;
    int steps_ = 0;
    SoftState before_;
};

PrecisionScene falling_sheet() {
    PrecisionScene made;
    made.name = "residual";
    made.summary = "A sheet held at one edge swings down.";
    made.metrics = {{"E4", "residual of a step / gravity"}};
    made.seconds = 1;
    made.build = build_falling_sheet;
    // Of steps that solve this equation: position-based solvers have another one, XPBD has one for each substep.
    made.takes = [](const Setting& setting) {
        const bool is_implicit = setting.family == Family::jacobi || setting.family == Family::chebyshev ||
                                 setting.family == Family::gradients;
        return is_implicit || (setting.family == Family::xpbd && setting.substeps == 1);
    };
    const PrecisionScene bare = made;
    made.evaluate = [bare](const Setting& setting) {
        return std::make_unique<ResidualEvaluation>(network_of(bare), 1.0 / setting.steps_per_second);
    };
    return made;
}

} // namespace

void add_invariant_scenes(std::vector<PrecisionScene>& scenes) {
    scenes.push_back(free_rope());
    scenes.push_back(falling_sheet());
}

} // namespace demos
