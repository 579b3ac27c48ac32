// pliant compare --snapshots: whether scenes that go back to a moment go the same way again.

#include "commands.h"
#include "description/error.h"
#include "measure/rollback.h"
#include "progress.h"
#include "report/table.h"
#include "scenes/scene_choice.h"
#include "scenes/scenes.h"

#include <nlohmann/json.hpp>

#include <iostream>

namespace app {

namespace {

constexpr int save_frame = 60;

struct Row {
    std::string scene;
    demos::Rollback rollback;
};

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
            {"kind", "rollback"},
            {"save_frame", rollback.save_frame},
            {"frames", rollback.frames},
            {"bytes", rollback.bytes},
            {"first_unequal_frame", rollback.first_unequal_frame},
            {"equal", rollback.is_equal()}};
}

void print_text(const std::vector<Row>& rows) {
    report::Table table({"scene", "solver", "threads", "saved at", "frames", "bytes", "equal"});
    for (const Row& row : rows) {
        const demos::Rollback& rollback = row.rollback;
        table.add({row.scene, demos::solver_name(rollback.solver), std::to_string(rollback.threads),
                   std::to_string(rollback.save_frame), std::to_string(rollback.frames), std::to_string(rollback.bytes),
                   rollback.is_equal() ? "all" : "not " + std::to_string(rollback.first_unequal_frame)});
    }
    std::cout << table.text()
              << "\nsaved at: frame of the snapshot, after cuts of the script. frames: that were repeated from there. "
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
                rows.push_back(
                    {which->name, demos::compare_rollback(*description, settings, save_frame, options.frames)});
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
