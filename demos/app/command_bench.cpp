// pliant bench: what the soft bodies of scenes cost in Pliant and in btSoftBody.

#include "commands.h"
#include "engines/bullet_memory.h"
#include "measure/bench.h"
#include "progress.h"
#include "report/output_file.h"
#include "report/table.h"
#include "scenes/scene_choice.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iostream>

namespace app {

using demos::BenchResult;
using demos::EngineCost;

// ------------------------------------------------------------------------------------------------------ figures

static double bytes_per_node(const BenchResult& result, const EngineCost& cost) {
    return static_cast<double>(cost.bytes) / std::max(result.nodes, 1);
}

// Geometric mean of the ratios of those results that have one; 0 without any.
static double mean_ratio(const std::vector<BenchResult>& results, double (BenchResult::*ratio)() const,
                         EngineCost BenchResult::*engine, bool of_touching = false) {
    double sum = 0;
    int count = 0;
    for (const BenchResult& result : results) {
        if (!result.bullet.is_measured || !(result.*engine).is_measured) { continue; }
        if (of_touching && result.touching_frames == 0) { continue; }
        sum += std::log((result.*ratio)());
        ++count;
    }
    return count > 0 ? std::exp(sum / count) : 0.0;
}

// --------------------------------------------------------------------------------------------------------- JSON

static nlohmann::ordered_json number_or_null(double value) {
    return value < 0.0 ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(value);
}

static nlohmann::ordered_json to_json(const BenchResult& result, const EngineCost& cost) {
    if (!cost.is_measured) { return nullptr; }
    nlohmann::ordered_json json = {
        {"median_ms", cost.median},
        {"touching_median_ms", number_or_null(result.touching_frames > 0 ? cost.touching_median : -1.0)},
        {"minimum_ms", cost.minimum},
        {"mean_ms", cost.mean},
        {"predict_ms", cost.parts[0]},
        {"collide_ms", cost.parts[1]},
        {"solve_ms", cost.parts[2]},
        {"world_step_ms", cost.whole_step},
        {"setup_ms", cost.setup},
        {"rms_stretch", cost.rms_stretch},
        {"rms_speed", cost.rms_speed},
        {"max_stretch", cost.max_stretch},
        {"finite", cost.finite},
        {"bytes_per_node", bytes_per_node(result, cost)},
        {"allocations_per_step", cost.allocations_per_step},
        {"last_allocating_frame", cost.last_allocating_frame}};
    if (cost.one_thread_median > 0.0) {
        json["one_thread_median_ms"] = cost.one_thread_median;
        json["work_over_span"] = cost.work_over_span;
        for (size_t i = 0; i < demos::predicted_threads.size(); ++i) {
            json["predicted_speedups"][std::to_string(demos::predicted_threads[i])] = cost.predicted_speedups[i];
        }
    }
    return json;
}

static nlohmann::ordered_json to_json(const BenchResult& result) {
    const bool has_ratio = result.bullet.is_measured, has_reference = has_ratio && result.reference.is_measured;
    nlohmann::ordered_json stages = nlohmann::ordered_json::array();
    for (const demos::StageCost& stage : result.stages) {
        stages.push_back({{"stage", stage.stage},
                          {"feature", stage.feature.empty() ? nlohmann::ordered_json(nullptr)
                                                            : nlohmann::ordered_json(stage.feature)},
                          {"microseconds", stage.microseconds}});
    }
    return {
        {"scene", result.scene},
        {"nodes", result.nodes},
        {"links", result.links},
        {"clusters", result.clusters},
        {"bodies", result.bodies},
        {"frames", result.frames},
        {"touching_frames", result.touching_frames},
        {"touching_ratio", number_or_null(has_ratio && result.touching_frames > 0 ? result.touching_ratio() : -1.0)},
        {"ratio", number_or_null(has_ratio ? result.ratio() : -1.0)},
        {"reference_ratio", number_or_null(has_reference ? result.reference_ratio() : -1.0)},
        {"world_step_ratio", number_or_null(has_ratio ? result.whole_ratio() : -1.0)},
        {"pliant", to_json(result, result.pliant)},
        {"reference", to_json(result, result.reference)},
        {"bullet", to_json(result, result.bullet)},
        {"ns_per_link", number_or_null(result.ns_per_link)},
        {"ns_per_contact", number_or_null(result.ns_per_contact)},
        {"ns_per_cluster", number_or_null(result.ns_per_cluster)},
        {"stages", stages}};
}

// ---------------------------------------------------------------------------------------------------------- CSV

static std::string bench_csv_heading() {
    std::string line = "scene,nodes,links,clusters,bodies,ratio,reference_ratio,world_step_ratio,ns_per_link,"
                       "ns_per_contact,ns_per_cluster";
    for (const char* engine : {"pliant", "reference", "bullet"}) {
        for (const char* key :
             {"median_ms", "minimum_ms", "mean_ms", "predict_ms", "collide_ms", "solve_ms", "world_step_ms", "setup_ms",
              "rms_stretch", "max_stretch", "bytes_per_node", "allocations_per_step"}) {
            line += std::string(",") + engine + "_" + key;
        }
    }
    return line + "\n";
}

static std::string csv_line(const BenchResult& result) {
    const bool has_ratio = result.bullet.is_measured, has_reference = has_ratio && result.reference.is_measured;
    std::string line = result.scene;
    for (const int value : {result.nodes, result.links, result.clusters, result.bodies}) {
        line += "," + std::to_string(value);
    }
    const auto add = [&](bool is_there, double value) {
        line += "," + (is_there ? report::exact(value) : std::string());
    };
    add(has_ratio, result.ratio());
    add(has_reference, result.reference_ratio());
    add(has_ratio, result.whole_ratio());
    for (const double value : {result.ns_per_link, result.ns_per_contact, result.ns_per_cluster}) {
        add(value >= 0.0, value);
    }
    for (const EngineCost* cost : {&result.pliant, &result.reference, &result.bullet}) {
        for (const double value : {cost->median, cost->minimum, cost->mean, cost->parts[0], cost->parts[1],
                                   cost->parts[2], cost->whole_step, cost->setup, cost->rms_stretch, cost->max_stretch,
                                   bytes_per_node(result, *cost), cost->allocations_per_step}) {
            add(cost->is_measured, value);
        }
    }
    return line + "\n";
}

// --------------------------------------------------------------------------------------------------------- text

static std::string or_dash(bool is_there, double value, int decimals) {
    return is_there ? report::fixed(value, decimals) : "-";
}

static std::string predictions_text(const EngineCost& cost) {
    std::string text;
    for (const double speedup : cost.predicted_speedups) {
        text += (text.empty() ? "" : "/") + report::fixed(speedup, 1);
    }
    return text;
}

static std::string summary_text(const std::vector<BenchResult>& results) {
    report::Table table({"scene",          "nodes",      "links",       "Pliant ms", "one thread",   "work/span",
                         "4/8/16 threads", "predict",    "collide",     "solve",     "reference ms", "Bullet ms",
                         "ratio",          "ref. ratio", "world ratio", "ns/link",   "stretch",      "Bullet's",
                         "B/node",         "Bullet's",   "alloc/step",  "Bullet's"});
    for (const BenchResult& result : results) {
        const bool has_bullet = result.bullet.is_measured, has_reference = result.reference.is_measured;
        const bool has_threads = result.pliant.one_thread_median > 0.0;
        table.add({result.scene,
                   std::to_string(result.nodes),
                   std::to_string(result.links),
                   report::fixed(result.pliant.median, 4),
                   or_dash(has_threads, result.pliant.one_thread_median, 4),
                   or_dash(has_threads, result.pliant.work_over_span, 1),
                   has_threads ? predictions_text(result.pliant) : "-",
                   report::fixed(result.pliant.parts[0], 4),
                   report::fixed(result.pliant.parts[1], 4),
                   report::fixed(result.pliant.parts[2], 4),
                   or_dash(has_reference, result.reference.median, 4),
                   or_dash(has_bullet, result.bullet.median, 4),
                   or_dash(has_bullet, result.ratio(), 2),
                   or_dash(has_bullet && has_reference, result.reference_ratio(), 2),
                   or_dash(has_bullet, result.whole_ratio(), 2),
                   or_dash(result.ns_per_link >= 0.0, result.ns_per_link, 2),
                   report::fixed(result.pliant.rms_stretch, 4),
                   or_dash(has_bullet, result.bullet.rms_stretch, 4),
                   report::fixed(bytes_per_node(result, result.pliant), 0),
                   or_dash(has_bullet, bytes_per_node(result, result.bullet), 0),
                   report::fixed(result.pliant.allocations_per_step, 2),
                   or_dash(has_bullet, result.bullet.allocations_per_step, 2)});
    }
    return table.text();
}

static std::string stages_text(const BenchResult& result) {
    report::Table table({"us per step", "stage", "feature"});
    for (const demos::StageCost& stage : result.stages) {
        table.add({report::fixed(stage.microseconds, 2), stage.stage, stage.feature});
    }
    return table.text();
}

static void print_text(const std::vector<BenchResult>& results) {
    std::cout << summary_text(results);
    const double mean = mean_ratio(results, &BenchResult::ratio, &BenchResult::pliant);
    if (mean > 0.0 && results.size() > 1) {
        std::cout << "geometric mean of the ratios: " << report::fixed(mean, 2);
        const double reference = mean_ratio(results, &BenchResult::reference_ratio, &BenchResult::reference);
        if (reference > 0.0) { std::cout << ", in reference mode " << report::fixed(reference, 2); }
        std::cout << '\n';
    }
    if (results.size() == 1) { std::cout << '\n' << stages_text(results[0]); }
    std::cout
        << "\nms: median over the frames of what the soft bodies take of a step. ratio: Bullet ms / Pliant ms; "
           "world ratio: of whole steps,\nrigid bodies included. stretch: root mean square of the links in "
           "the last second of 15 s,\nor with --quick and --series of the frames. alloc/step: over the second half of "
           "the "
           "frames.\n"
           "work/span: how many times as fast as on one thread a step is at most, however many threads there are; "
           "4/8/16 threads: predicted\nfrom the times of parts, without the cost of handing them over.\n";
}

// ------------------------------------------------------------------------------------------------------ command

static std::vector<BenchResult> bench_scenes(const BenchOptions& options) {
    const std::vector<const scene*> scenes = demos::choose_scenes(options.scenes);
    demos::BenchOptions bench;
    bench.frames = options.frames > 0 ? options.frames : options.is_quick ? 60 : 300;
    bench.rounds = options.is_quick ? 1 : 3;
    if (options.is_quick) { bench.settled_frames = 0; }
    bench.threads = options.threads;
    std::vector<BenchResult> results;
    Progress progress(options.json);
    for (const scene* which : scenes) {
        const std::unique_ptr<demos::Description> description = demos::Description::build(*which, {});
        progress.start(std::string(which->name) + " [" + std::to_string(results.size() + 1) + "/" +
                       std::to_string(scenes.size()) + "]");
        results.push_back(
            demos::bench_scene(*description, bench, [&](int frame, int frames) { progress.show(frame, frames); }));
    }
    return results;
}

static std::vector<BenchResult> bench_sizes(const BenchOptions& options) {
    const demos::BenchSeries& series = demos::find_bench_series(options.series);
    std::vector<BenchResult> results;
    Progress progress(options.json);
    for (const demos::BenchSize& size : series.sizes) {
        const std::unique_ptr<demos::Description> description =
            demos::Description::build(size.which, size.scene_options);
        demos::BenchOptions bench = demos::series_options(series, size, *description, options.is_quick);
        if (options.frames > 0) { bench.frames = options.frames; }
        bench.threads = options.threads;
        progress.start(size.which.name);
        results.push_back(
            demos::bench_scene(*description, bench, [&](int frame, int frames) { progress.show(frame, frames); }));
    }
    return results;
}

int run_bench(const BenchOptions& options) {
    if (options.scenes.empty() == options.series.empty()) {
        throw demos::Error("bench takes either names of scenes or --series");
    }
    if (!options.scenes.empty()) { demos::choose_scenes(options.scenes); } // an unknown name before the work
    const report::OutputFile csv(options.csv_file);
    demos::count_bullet_memory();
    const std::vector<BenchResult> results = options.series.empty() ? bench_scenes(options) : bench_sizes(options);
    std::string lines = bench_csv_heading();
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const BenchResult& result : results) {
        lines += csv_line(result);
        rows.push_back(to_json(result));
    }
    csv.write(lines);
    if (!options.json) {
        print_text(results);
        return 0;
    }
    const double mean = mean_ratio(results, &BenchResult::ratio, &BenchResult::pliant);
    const double reference_mean = mean_ratio(results, &BenchResult::reference_ratio, &BenchResult::reference);
    const double touching_mean = mean_ratio(results, &BenchResult::touching_ratio, &BenchResult::pliant, true);
    std::cout << nlohmann::ordered_json{{"scenes", rows},
                                        {"geometric_mean", number_or_null(mean > 0.0 ? mean : -1.0)},
                                        {"touching_geometric_mean",
                                         number_or_null(touching_mean > 0.0 ? touching_mean : -1.0)},
                                        {"reference_geometric_mean",
                                         number_or_null(reference_mean > 0.0 ? reference_mean : -1.0)}}
                     .dump(2)
              << '\n';
    return 0;
}

} // namespace app
