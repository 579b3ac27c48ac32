#ifndef DEMOS_WORKPREC_H
#define DEMOS_WORKPREC_H

// Error against run time: each scene with every solver over a grid of steps and iterations. docs/workprec.md says what
// is measured.

#include "engines/engine.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace demos {

// A curve of the plots.
enum class Family { bt_soft_body, position_ordered, position_colored, jacobi, chebyshev, gradients, xpbd };
constexpr int family_count = 7;

const char* family_name(Family family);

struct Setting {
    Family family = Family::bt_soft_body;
    int steps_per_second = 60;
    int substeps = 1, iterations = 1;
};

EngineKind engine_of(const Setting& setting);
EngineOptions options_of(const Setting& setting);

std::vector<Setting> settings(bool is_quick);

struct Metric {
    std::string id;    // "E2", part of file names
    std::string title; // with its unit
};

// Looks at one run.
class Evaluation {
public:
    virtual ~Evaluation() = default;
    virtual void after_step(const Engine&, int /*step*/) {}
    // By metric of the scene; all at least 0.
    virtual std::vector<double> errors(const Engine& engine) = 0;
};

struct PrecisionScene {
    std::string name, summary;
    std::vector<Metric> metrics;
    double seconds = 1;                // simulated
    scene_resolution resolution{0, 0}; // for scenes that take one
    // For steps of this length, s.
    std::function<void(scene_builder*, float)> build;
    std::function<std::unique_ptr<Evaluation>(const Setting&)> evaluate;
    std::function<bool(const Setting&)> takes{}; // empty: all settings
};

const std::vector<PrecisionScene>& precision_scenes();

struct PrecisionPoint {
    Setting setting;
    double cost = 0;            // ms of soft bodies per simulated second
    std::vector<double> errors; // by metric; infinite when the run did not stay finite
    bool on_front(size_t metric) const { return front[metric]; }
    std::vector<bool> front; // by metric: nothing of the same family is both faster and better
};

// Calls `progress` with the number of settings that are done and of all.
std::vector<PrecisionPoint> measure_precision(const PrecisionScene& which, bool is_quick,
                                              const std::function<void(int, int)>& progress);

// The cheapest point of a family with at most this error; null: none.
const PrecisionPoint* cheapest(const std::vector<PrecisionPoint>& points, Family family, size_t metric, double error);

// Times of `btSoftBody` over those of a family where both have the same error, from the worst error on the front of
// `btSoftBody` down to the least that both reach; between points, fronts are straight lines on logarithmic axes.
struct TimeRatio {
    double least = 0, median = 0, most = 0;
};
// Nothing when there is no such error.
std::optional<TimeRatio> time_ratio(const std::vector<PrecisionPoint>& points, Family family, size_t metric);

} // namespace demos
#endif
