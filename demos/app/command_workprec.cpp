// pliant workprec: error against run time of every solver, as tables, CSV and plots.

#include "commands.h"
#include "measure/workprec/workprec.h"
#include "progress.h"
#include "report/csv.h"
#include "report/error_plot.h"
#include "report/output_file.h"
#include "report/table.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iostream>

namespace app {

using demos::Family;
using demos::PrecisionPoint;
using demos::PrecisionScene;
using demos::Setting;

struct SceneResult {
    const PrecisionScene* which;
    std::vector<PrecisionPoint> points;
};

static constexpr double error_goals[] = {0.1, 0.01, 0.001};

static std::vector<const PrecisionScene*> choose(const std::vector<std::string>& names) {
    std::vector<const PrecisionScene*> chosen;
    std::string known;
    for (const PrecisionScene& each : demos::precision_scenes()) {
        known += (known.empty() ? "" : ", ") + each.name;
        const auto is_this = [&](const std::string& name) { return name == each.name || name == "all"; };
        if (names.empty() || std::any_of(names.begin(), names.end(), is_this)) { chosen.push_back(&each); }
    }
    for (const std::string& name : names) {
        const bool exists = name == "all" || std::any_of(chosen.begin(), chosen.end(), [&](const PrecisionScene* each) {
                                return each->name == name;
                            });
        if (!exists) { throw demos::Error("workprec has no scene named " + name + "; it has: " + known); }
    }
    return chosen;
}

static std::string setting_text(const Setting& setting) {
    const std::string rate = "1/" + std::to_string(setting.steps_per_second) + " s";
    if (setting.family == Family::xpbd) {
        return rate + ", " + std::to_string(setting.substeps) + " x " + std::to_string(setting.iterations);
    }
    return rate + ", " + std::to_string(setting.iterations);
}

static std::string csv_text(const std::vector<SceneResult>& results) {
    std::string text = report::csv_line({"scene", "metric", "solver", "dt_s", "substeps", "iterations",
                                         "ms_per_simulated_second", "error", "on_front"});
    for (const SceneResult& result : results) {
        for (size_t metric = 0; metric < result.which->metrics.size(); ++metric) {
            for (const PrecisionPoint& point : result.points) {
                const Setting& setting = point.setting;
                const double error = point.errors[metric];
                text += report::csv_line({result.which->name, result.which->metrics[metric].id,
                                          family_name(setting.family), report::exact(1.0 / setting.steps_per_second),
                                          std::to_string(setting.substeps), std::to_string(setting.iterations),
                                          report::exact(point.cost), std::isfinite(error) ? report::exact(error) : "",
                                          point.on_front(metric) ? "1" : "0"});
            }
        }
    }
    return text;
}

static std::string plot(const SceneResult& result, size_t metric) {
    std::vector<report::PlotCurve> curves;
    for (int k = 0; k < demos::family_count; ++k) {
        const auto family = static_cast<Family>(k);
        curves.push_back({family_name(family), {}});
        for (const PrecisionPoint& point : result.points) {
            const double error = point.errors[metric];
            if (point.setting.family != family || !std::isfinite(error)) { continue; }
            curves.back().points.push_back({point.cost, error, point.on_front(metric),
                                            setting_text(point.setting) + ": " + report::fixed(point.cost, 2) +
                                                " ms, " + report::short_error(error)});
        }
    }
    return report::error_plot(result.which->name + ": " + result.which->summary,
                              "time of the soft bodies per simulated second, ms", result.which->metrics[metric].title,
                              curves);
}

// "0.31 ms (1/60 s, 10)"
static std::string cheapest_text(const SceneResult& result, Family family, size_t metric, double error) {
    const PrecisionPoint* point = cheapest(result.points, family, metric, error);
    return point == nullptr ? "-" : report::fixed(point->cost, 2) + " ms (" + setting_text(point->setting) + ")";
}

// "4.6 (3.9 to 5.2)"
static std::string ratio_text(const SceneResult& result, Family family, size_t metric) {
    const std::optional<demos::TimeRatio> ratio = time_ratio(result.points, family, metric);
    if (!ratio) { return "-"; }
    return report::fixed(ratio->median, 1) + " (" + report::fixed(ratio->least, 1) + " to " +
           report::fixed(ratio->most, 1) + ")";
}

static void print_text(const std::vector<SceneResult>& results) {
    for (const SceneResult& result : results) {
        for (size_t metric = 0; metric < result.which->metrics.size(); ++metric) {
            const demos::Metric& shown = result.which->metrics[metric];
            std::cout << result.which->name << ", " << shown.id << " " << shown.title << '\n';
            report::Table table({"  solver", "10 %", "1 %", "0.1 %", "ratio"});
            for (int k = 0; k < demos::family_count; ++k) {
                const auto family = static_cast<Family>(k);
                std::vector<std::string> cells{std::string("  ") + family_name(family)};
                for (const double goal : error_goals) {
                    cells.push_back(cheapest_text(result, family, metric, goal));
                }
                cells.push_back(ratio_text(result, family, metric));
                table.add(std::move(cells));
            }
            std::cout << table.text() << '\n';
        }
    }
    std::cout << "The cheapest setting of each solver with at most this error: time of the soft bodies per simulated "
                 "second (step, iterations; of xpbd substeps x sweeps).\n"
                 "ratio: time of btSoftBody over that of the solver at equal error, median (least to most) over the "
                 "errors that both reach.\n";
}

static nlohmann::ordered_json to_json(const std::vector<SceneResult>& results) {
    nlohmann::ordered_json scenes = nlohmann::ordered_json::array();
    for (const SceneResult& result : results) {
        nlohmann::ordered_json metrics = nlohmann::ordered_json::array();
        for (const demos::Metric& metric : result.which->metrics) {
            metrics.push_back({{"id", metric.id}, {"title", metric.title}});
        }
        nlohmann::ordered_json ratios = nlohmann::ordered_json::array();
        for (int k = 0; k < demos::family_count; ++k) {
            const auto family = static_cast<Family>(k);
            for (size_t metric = 0; metric < result.which->metrics.size(); ++metric) {
                const std::optional<demos::TimeRatio> ratio = time_ratio(result.points, family, metric);
                if (!ratio) { continue; }
                ratios.push_back({{"solver", family_name(family)},
                                  {"metric", result.which->metrics[metric].id},
                                  {"least", ratio->least},
                                  {"median", ratio->median},
                                  {"most", ratio->most}});
            }
        }
        nlohmann::ordered_json points = nlohmann::ordered_json::array();
        for (const PrecisionPoint& point : result.points) {
            nlohmann::ordered_json errors = nlohmann::ordered_json::array();
            for (const double error : point.errors) {
                errors.push_back(std::isfinite(error) ? nlohmann::ordered_json(error)
                                                      : nlohmann::ordered_json(nullptr));
            }
            points.push_back({{"solver", family_name(point.setting.family)},
                              {"dt", 1.0 / point.setting.steps_per_second},
                              {"substeps", point.setting.substeps},
                              {"iterations", point.setting.iterations},
                              {"ms_per_simulated_second", point.cost},
                              {"errors", errors},
                              {"on_front", point.front}});
        }
        scenes.push_back(
            {{"scene", result.which->name}, {"metrics", metrics}, {"time_ratios", ratios}, {"points", points}});
    }
    return {{"scenes", scenes}};
}

int run_workprec(const WorkprecOptions& options) {
    namespace fs = std::filesystem;
    const std::vector<const PrecisionScene*> scenes = choose(options.scenes);
    if (!options.folder.empty()) { report::make_folder(options.folder); }
    const auto file = [&](const std::string& name) {
        return report::OutputFile(options.folder.empty() ? std::string() : (fs::path(options.folder) / name).string());
    };
    const report::OutputFile csv = file("workprec.csv");
    std::vector<SceneResult> results;
    {
        Progress progress(options.json);
        for (const PrecisionScene* which : scenes) {
            progress.start(which->name + " [" + std::to_string(results.size() + 1) + "/" +
                           std::to_string(scenes.size()) + "]");
            results.push_back({which, measure_precision(*which, options.is_quick,
                                                        [&](int done, int total) { progress.show(done, total); })});
            for (size_t metric = 0; metric < which->metrics.size(); ++metric) {
                file("workprec_" + which->name + "_" + which->metrics[metric].id + ".svg")
                    .write(plot(results.back(), metric));
            }
        }
    }
    csv.write(csv_text(results));
    if (options.json) {
        std::cout << to_json(results).dump(2) << '\n';
    } else {
        print_text(results);
    }
    return 0;
}

} // namespace app
