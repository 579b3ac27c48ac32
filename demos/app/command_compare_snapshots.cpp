// pliant compare --snapshots: whether scenes that go back to a moment go the same way again.

#include "commands.h"
#include "description/error.h"
#include "measure/recording.h"
#include "measure/rollback.h"
#include "progress.h"
#include "report/output_file.h"
#include "report/table.h"
#include "scenes/scene_choice.h"
#include "scenes/scenes.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <filesystem>
#include <iostream>

#include <unistd.h>

namespace app {

namespace {

constexpr int save_frame = 60;

struct Row {
    std::string scene, kind;
    demos::Rollback rollback;
};

// What another process of this program prints.
std::string output_of(const std::string& arguments) {
    const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
    std::FILE* pipe = popen(("\"" + self + "\" " + arguments).c_str(), "r");
    if (pipe == nullptr) { throw demos::Error("no other process of this program can be started"); }
    std::string text;
    char part[4096];
    for (size_t size = 0; (size = std::fread(part, 1, sizeof part, pipe)) > 0;) {
        text.append(part, size);
    }
    (void)pclose(pipe);
    return text;
}

// Runs the scene here, with its state in a file at `save_frame`, and has another process make the frames after it from
// the file.
demos::Rollback compare_file(const scene& which, const demos::Description& description, const CompareOptions& options,
                             const demos::EngineOptions& settings) {
    demos::EngineOptions ordered = settings;
    ordered.ordered_pairs = true;
    const demos::SolverRun solver = choose_solver(description, demos::EngineKind::pliant, ordered);
    demos::PliantEngine engine(description, ordered);
    demos::Recorder recorder({which.name, options.changes.self_collision, options.changes.resolution,
                              demos::solver_name(solver.kind), solver.substeps, settings.solver.iterations.value_or(0),
                              settings.threads, settings.step_seconds, false},
                             0);
    for (int i = 0; i < save_frame + options.frames; ++i) {
        engine.step();
        recorder.add_frame(engine);
        if (i + 1 == save_frame) { recorder.add_keyframe(engine); }
    }
    demos::Rollback result;
    result.solver = solver.kind;
    result.threads = settings.threads;
    result.save_frame = save_frame;
    result.frames = options.frames;
    result.bytes = recorder.recording().keyframes.front().state.size();
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("pliant-" + std::to_string(getpid()) + ".recording");
    report::OutputFile(path.string()).write(recorder.recording().to_bytes());
    const std::string printed =
        output_of("replay \"" + path.string() + "\" --verify --json --from " + std::to_string(save_frame));
    std::filesystem::remove(path);
    const nlohmann::json told = nlohmann::json::parse(printed, nullptr, false);
    if (!told.is_object()) { throw demos::Error(std::string(which.name) + ": the other process has failed"); }
    const int unequal = told.at("first_unequal_frame").get<int>();
    result.first_unequal_frame = unequal > 0 ? unequal - save_frame : 0;
    return result;
}

bool can_run(const demos::Description& description, const demos::EngineOptions& options) {
    try {
        (void)choose_solver(description, demos::EngineKind::pliant, options);
    } catch (const demos::Error&) { return false; }
    return true;
}

nlohmann::ordered_json to_json(const Row& row) {
    const demos::Rollback& rollback = row.rollback;
    return {{"scene", row.scene},
            {"solver", demos::solver_name(rollback.solver)},
            {"threads", rollback.threads},
            {"kind", row.kind},
            {"save_frame", rollback.save_frame},
            {"frames", rollback.frames},
            {"bytes", rollback.bytes},
            {"first_unequal_frame", rollback.first_unequal_frame},
            {"equal", rollback.is_equal()}};
}

void print_text(const std::vector<Row>& rows) {
    report::Table table({"scene", "solver", "threads", "kind", "saved at", "frames", "bytes", "equal"});
    for (const Row& row : rows) {
        const demos::Rollback& rollback = row.rollback;
        table.add({row.scene, demos::solver_name(rollback.solver), std::to_string(rollback.threads), row.kind,
                   std::to_string(rollback.save_frame), std::to_string(rollback.frames), std::to_string(rollback.bytes),
                   rollback.is_equal() ? "all" : "not " + std::to_string(rollback.first_unequal_frame)});
    }
    std::cout << table.text()
              << "\nkind: rollback in one process, or a file that another process goes on from. saved at: frame of the "
                 "snapshot,\nfor a rollback after cuts of the script. frames: that were repeated from there. "
                 "equal: all frames,\nor the first one that is not.\n";
}

} // namespace

int run_compare_snapshots(const CompareOptions& options) {
    std::vector<const scene*> scenes = demos::choose_scenes(options.scenes);
    if (scenes.empty()) { scenes.assign(scene_list, scene_list + scene_count); }
    std::vector<Row> rows;
    bool are_equal = true;
    Progress progress(options.json);
    for (const scene* which : scenes) {
        const std::unique_ptr<demos::Description> description =
            demos::Description::build(*which, scene_options(options.changes));
        for (const demos::SolverKind solver :
             {demos::SolverKind::position_based, demos::SolverKind::xpbd, demos::SolverKind::implicit}) {
            demos::EngineOptions settings = engine_options(options.step);
            if (options.step.solver.has_value() && *options.step.solver != demos::solver_name(solver)) { continue; }
            settings.solver.kind = solver;
            if (!can_run(*description, settings)) { continue; }
            for (const int threads : {1, 3}) {
                progress.start(std::string(which->name) + ", " + demos::solver_name(solver) + ", " +
                               std::to_string(threads) + " threads");
                settings.threads = threads;
                rows.push_back({which->name, "rollback",
                                demos::compare_rollback(*description, settings, save_frame, options.frames)});
                are_equal = are_equal && rows.back().rollback.is_equal();
                rows.push_back({which->name, "file", compare_file(*which, *description, options, settings)});
                are_equal = are_equal && rows.back().rollback.is_equal();
            }
        }
    }
    progress.clear();
    if (options.json) {
        nlohmann::ordered_json list = nlohmann::ordered_json::array();
        for (const Row& row : rows) {
            list.push_back(to_json(row));
        }
        std::cout << nlohmann::ordered_json{{"snapshots", list}}.dump(2) << '\n';
    } else {
        print_text(rows);
    }
    return are_equal ? 0 : 1;
}

} // namespace app
