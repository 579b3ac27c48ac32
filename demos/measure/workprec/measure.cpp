// Runs a scene with each setting.

#include "measure/measure.h"
#include "description/function_scene.h"
#include "measure/statistics.h"
#include "workprec.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace demos {

namespace {

// Some steps take longer than others: searches, contacts. The slowest hundredth is what other programs take from this
// one.
double mean_of_most(std::vector<double> times) {
    const auto kept = times.end() - static_cast<std::ptrdiff_t>((times.size() + 99) / 100);
    std::nth_element(times.begin(), kept, times.end());
    return std::accumulate(times.begin(), kept, 0.0) / static_cast<double>(kept - times.begin());
}

PrecisionPoint run_setting(const PrecisionScene& which, const Setting& setting) {
    PrecisionPoint point;
    point.setting = setting;
    point.errors.assign(which.metrics.size(), std::numeric_limits<double>::infinity());
    const EngineOptions options = options_of(setting);
    const FunctionScene source(which.name, [&](scene_builder* builder) { which.build(builder, options.step_seconds); });
    SceneOptions scene_options;
    scene_options.resolution = which.resolution;
    const std::unique_ptr<Description> description = Description::build(source, scene_options);
    const std::unique_ptr<Engine> engine = make_engine(engine_of(setting), *description, options);
    const std::unique_ptr<Evaluation> evaluation = which.evaluate(setting);
    const int steps = static_cast<int>(std::lround(which.seconds * setting.steps_per_second));
    std::vector<double> times;
    for (int step = 1; step <= steps; ++step) {
        engine->step();
        times.push_back(engine->step_times().sum());
        evaluation->after_step(*engine, step);
    }
    point.cost = mean_of_most(std::move(times)) * setting.steps_per_second;
    if (!measure(*engine).finite) { return point; }
    point.errors = evaluation->errors(*engine);
    for (double& error : point.errors) {
        if (!std::isfinite(error)) { error = std::numeric_limits<double>::infinity(); }
    }
    return point;
}

void mark_fronts(std::vector<PrecisionPoint>& points, size_t metrics) {
    for (PrecisionPoint& point : points) {
        point.front.assign(metrics, false);
        for (size_t metric = 0; metric < metrics; ++metric) {
            const bool is_beaten = std::any_of(points.begin(), points.end(), [&](const PrecisionPoint& other) {
                return other.setting.family == point.setting.family && other.cost < point.cost &&
                       other.errors[metric] <= point.errors[metric];
            });
            point.front[metric] = !is_beaten && std::isfinite(point.errors[metric]);
        }
    }
}

} // namespace

std::vector<PrecisionPoint> measure_precision(const PrecisionScene& which, bool is_quick,
                                              const std::function<void(int, int)>& progress) {
    std::vector<Setting> wanted = settings(is_quick);
    wanted.erase(std::remove_if(wanted.begin(), wanted.end(),
                                [&](const Setting& setting) { return which.takes && !which.takes(setting); }),
                 wanted.end());
    std::vector<PrecisionPoint> points;
    for (const Setting& setting : wanted) {
        progress(static_cast<int>(points.size()), static_cast<int>(wanted.size()));
        points.push_back(run_setting(which, setting));
    }
    mark_fronts(points, which.metrics.size());
    return points;
}

const PrecisionPoint* cheapest(const std::vector<PrecisionPoint>& points, Family family, size_t metric, double error) {
    const PrecisionPoint* best = nullptr;
    for (const PrecisionPoint& point : points) {
        if (point.setting.family != family || !(point.errors[metric] <= error)) { continue; }
        if (best == nullptr || point.cost < best->cost) { best = &point; }
    }
    return best;
}

namespace {

constexpr double smallest_error = 1e-9; // for logarithms

struct FrontPoint {
    double log_error, log_cost;
};

// From the largest error to the least.
std::vector<FrontPoint> front_of(const std::vector<PrecisionPoint>& points, Family family, size_t metric) {
    std::vector<FrontPoint> front;
    for (const PrecisionPoint& point : points) {
        if (point.setting.family != family || !point.on_front(metric)) { continue; }
        front.push_back({std::log(std::max(point.errors[metric], smallest_error)), std::log(point.cost)});
    }
    std::sort(front.begin(), front.end(),
              [](const FrontPoint& a, const FrontPoint& b) { return a.log_error > b.log_error; });
    return front;
}

// Larger errors cost as little as the largest.
double log_cost_at(const std::vector<FrontPoint>& front, double log_error) {
    if (log_error >= front.front().log_error) { return front.front().log_cost; }
    const auto next =
        std::find_if(front.begin(), front.end(), [&](const FrontPoint& point) { return point.log_error <= log_error; });
    if (next == front.end()) { return front.back().log_cost; }
    const FrontPoint &worse = *(next - 1), &better = *next;
    const double share = (worse.log_error - log_error) / (worse.log_error - better.log_error);
    return worse.log_cost + share * (better.log_cost - worse.log_cost);
}

} // namespace

std::optional<TimeRatio> time_ratio(const std::vector<PrecisionPoint>& points, Family family, size_t metric) {
    constexpr int levels = 41;
    const std::vector<FrontPoint> theirs = front_of(points, Family::bt_soft_body, metric),
                                  ours = front_of(points, family, metric);
    if (theirs.empty() || ours.empty()) { return std::nullopt; }
    const double high = theirs.front().log_error, low = std::max(theirs.back().log_error, ours.back().log_error);
    if (low > high) { return std::nullopt; }
    std::vector<double> ratios;
    for (int k = 0; k < levels; ++k) {
        const double log_error = low + (high - low) * k / (levels - 1);
        ratios.push_back(std::exp(log_cost_at(theirs, log_error) - log_cost_at(ours, log_error)));
    }
    const auto ends = std::minmax_element(ratios.begin(), ratios.end());
    return TimeRatio{*ends.first, median(ratios), *ends.second};
}

} // namespace demos
