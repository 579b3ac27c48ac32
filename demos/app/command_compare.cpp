// pliant compare: how far Pliant is from btSoftBody, per scene.

#include "commands.h"
#include "measure/compare.h"
#include "progress.h"
#include "report/output_file.h"
#include "report/table.h"
#include "scenes/scene_choice.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <iostream>

namespace app {

using demos::Comparison;

// -1 stands for a frame that was not reached.
static nlohmann::ordered_json error_or_null(double error) {
    return error < 0.0 ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(error);
}

// The frame with the largest error, counted from 1; 0 without frames.
static int worst_frame(const demos::OneStep& one_step) {
    if (one_step.errors.empty()) { return 0; }
    const auto worst = std::max_element(one_step.errors.begin(), one_step.errors.end());
    return static_cast<int>(worst - one_step.errors.begin()) + 1;
}

// Null with another solver than Bullet's.
static nlohmann::ordered_json to_json(const std::optional<demos::OneStep>& one_step) {
    if (!one_step.has_value()) { return nullptr; }
    return {{"frames", one_step->frames},
            {"median", one_step->median},
            {"p99", one_step->p99},
            {"maximum", one_step->maximum},
            {"worst_frame", worst_frame(*one_step)},
            {"bit_equal_share", one_step->bit_equal_share},
            {"frames_with_lone_contacts", one_step->frames_with_lone_contacts},
            {"frames_above_limit", one_step->frames_above_limit},
            {"unexplained_frames", one_step->unexplained_frames}};
}

static nlohmann::ordered_json to_json(const Comparison& comparison, double step_seconds) {
    const demos::FreeRun& free_run = comparison.free_run;
    return {{"scene", comparison.scene},
            {"solver", solver_name(comparison.solver.kind)},
            {"substeps", comparison.solver.substeps},
            {"iterations", comparison.solver.iterations},
            {"dt", step_seconds},
            {"nodes", comparison.nodes},
            {"one_step", to_json(comparison.one_step)},
            {"free_run",
             {{"error_30", error_or_null(free_run.error_30)},
              {"error_60", error_or_null(free_run.error_60)},
              {"error_300", error_or_null(free_run.error_300)}}},
            {"bullet_ms", comparison.bullet_ms},
            {"pliant_ms", comparison.pliant_ms},
            {"time_ratio", comparison.time_ratio}};
}

static constexpr size_t one_step_cells = 9;

static std::vector<std::string> csv_cells(const std::optional<demos::OneStep>& one_step) {
    if (!one_step.has_value()) { return std::vector<std::string>(one_step_cells); }
    return {std::to_string(one_step->frames),
            report::exact(one_step->median),
            report::exact(one_step->p99),
            report::exact(one_step->maximum),
            std::to_string(worst_frame(*one_step)),
            report::exact(one_step->bit_equal_share),
            std::to_string(one_step->frames_with_lone_contacts),
            std::to_string(one_step->frames_above_limit),
            std::to_string(one_step->unexplained_frames)};
}

static std::string csv_line(const Comparison& comparison) {
    const demos::FreeRun& free_run = comparison.free_run;
    const auto error_cell = [](double error) { return error < 0.0 ? std::string() : report::exact(error); };
    std::vector<std::string> cells = csv_cells(comparison.one_step);
    cells.insert(cells.begin(), {comparison.scene, std::to_string(comparison.nodes)});
    cells.insert(cells.end(),
                 {error_cell(free_run.error_30), error_cell(free_run.error_60), error_cell(free_run.error_300),
                  report::exact(comparison.bullet_ms), report::exact(comparison.pliant_ms),
                  report::exact(comparison.time_ratio), solver_name(comparison.solver.kind)});
    std::string line;
    for (const std::string& cell : cells) {
        line += (line.empty() ? "" : ",") + cell;
    }
    return line + "\n";
}

static const char* const compare_csv_heading =
    "scene,nodes,frames,median,p99,maximum,worst_frame,bit_equal_share,frames_with_lone_contacts,frames_above_limit,"
    "unexplained_frames,error_30,error_60,error_300,bullet_ms,pliant_ms,time_ratio,solver\n";

static std::vector<std::string> text_cells(const std::optional<demos::OneStep>& one_step) {
    if (!one_step.has_value()) { return {"-", "-", "-", "-", "-", "-", "-"}; }
    return {report::short_error(one_step->median),
            report::short_error(one_step->p99),
            report::short_error(one_step->maximum),
            report::fixed(100.0 * one_step->bit_equal_share, 1) + "%",
            std::to_string(one_step->frames_with_lone_contacts),
            std::to_string(one_step->frames_above_limit),
            std::to_string(one_step->unexplained_frames)};
}

static void print_text(const std::vector<Comparison>& comparisons) {
    bool has_other_solver = false;
    report::Table table({"scene", "nodes", "median", "p99", "maximum", "bit-equal", "lone", "above", "unexplained",
                         "free 30", "free 60", "free 300", "Bullet ms", "Pliant ms", "ratio"});
    for (const Comparison& comparison : comparisons) {
        std::vector<std::string> cells = text_cells(comparison.one_step);
        cells.insert(cells.begin(), {comparison.scene, std::to_string(comparison.nodes)});
        cells.insert(cells.end(),
                     {report::short_error(comparison.free_run.error_30),
                      report::short_error(comparison.free_run.error_60),
                      report::short_error(comparison.free_run.error_300), report::fixed(comparison.bullet_ms, 3),
                      report::fixed(comparison.pliant_ms, 3), report::fixed(comparison.time_ratio, 2)});
        table.add(std::move(cells));
        has_other_solver = has_other_solver || !comparison.one_step.has_value();
    }
    std::cout
        << table.text()
        << "\nmedian, p99, maximum: error of one step from the same state, over the frames; a share of the size of "
           "the soft bodies.\nlone: frames with a contact that only one engine made; above: frames with an error "
           "above 1e-5, and how many of these have no such contact.\nfree: error after that many frames from the "
           "same start. ratio: time of Bullet / time of Pliant.\n";
    if (has_other_solver) {
        std::cout << "Another solver than Bullet's has no one-step error: the free error is a difference of materials "
                     "and methods, no mistake of one of them.\n";
    }
}

int run_compare(const CompareOptions& options) {
    const std::vector<const scene*> scenes = demos::choose_scenes(options.scenes);
    const report::OutputFile csv(options.csv_file);
    const demos::EngineOptions settings = engine_options(options.step);
    std::vector<Comparison> comparisons;
    {
        Progress progress(options.json);
        for (const scene* which : scenes) {
            const std::unique_ptr<demos::Description> description =
                demos::Description::build(*which, scene_options(options.changes));
            progress.start(std::string(which->name) + " [" + std::to_string(comparisons.size() + 1) + "/" +
                           std::to_string(scenes.size()) + "]");
            comparisons.push_back(demos::compare(
                *description, options.frames, [&](int frame, int frames) { progress.show(frame, frames); },
                options.witness == "pliant" ? demos::Witness::pliant : demos::Witness::bullet, settings));
        }
    }
    std::string lines = compare_csv_heading;
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const Comparison& comparison : comparisons) {
        lines += csv_line(comparison);
        rows.push_back(to_json(comparison, static_cast<double>(settings.step_seconds)));
    }
    csv.write(lines);
    if (options.json) {
        std::cout << nlohmann::ordered_json{{"scenes", rows}}.dump(2) << '\n';
    } else {
        print_text(comparisons);
    }
    return 0;
}

} // namespace app
