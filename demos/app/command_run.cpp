// pliant run: one scene in one engine, its measures, and a picture of its end.

#include "commands.h"
#include "measure/costs.h"
#include "measure/measure.h"
#include "measure/recording.h"
#include "measure/statistics.h"
#include "progress.h"
#include "render/picture.h"
#include "report/output_file.h"
#include "report/table.h"
#include "scenes/scene_choice.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>

namespace app {

static constexpr int picture_width = 1280, picture_height = 720;

struct RunResult {
    int frames = 0; // made; fewer than wanted when the state is no longer finite
    double ms_per_step = 0;
    demos::Measures measures;
    scene_self_collision self_collision = SCENE_SELF_NONE;
    std::optional<int> crossings; // of scenes with self-collision to choose, on Pliant
    std::optional<demos::SceneCosts> costs;
    std::string csv;
};

static const char* self_collision_name(scene_self_collision kind) {
    return kind == SCENE_SELF_NODES   ? "nodes"
           : kind == SCENE_SELF_GRIDS ? "grids"
           : kind == SCENE_SELF_FACES ? "faces"
                                      : "off";
}

static std::string csv_line(const demos::Engine& engine, const demos::Measures& measures, int frame, double time) {
    const pli_vec3 center = demos::center_of_mass(engine);
    const double values[] = {time,
                             engine.step_milliseconds(),
                             measures.kinetic_energy,
                             measures.max_stretch,
                             static_cast<double>(center.x),
                             static_cast<double>(center.y),
                             static_cast<double>(center.z)};
    std::string line = std::to_string(frame);
    for (const double value : values) {
        line += "," + report::exact(value);
    }
    return line + "\n";
}

static RunResult run_frames(demos::Engine& engine, int frames, double step_seconds, exporting::FrameExport& frame_files,
                            demos::Recorder* recorder, Progress& progress) {
    RunResult result;
    result.csv = "frame,time_s,ms,kinetic_energy_J,max_stretch,center_x,center_y,center_z\n";
    std::vector<double> milliseconds;
    frame_files.add(engine, 0, 0.0);
    do {
        engine.step();
        ++result.frames;
        if (recorder != nullptr) { recorder->add_frame(dynamic_cast<demos::PliantEngine&>(engine)); }
        milliseconds.push_back(engine.step_milliseconds());
        result.measures = demos::measure(engine);
        result.csv += csv_line(engine, result.measures, result.frames, result.frames * step_seconds);
        if (result.measures.finite) { frame_files.add(engine, result.frames, result.frames * step_seconds); }
        progress.show(result.frames, frames);
    } while (result.frames < frames && result.measures.finite);
    frame_files.finish();
    result.ms_per_step = demos::median(std::move(milliseconds));
    return result;
}

static std::string hash_text(uint64_t hash) {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

static std::string engine_title(const RunOptions& options, demos::SolverKind solver) {
    if (options.engine == "bullet") { return "Bullet"; }
    if (solver == demos::SolverKind::implicit) { return "Pliant, implicit"; }
    if (solver == demos::SolverKind::xpbd) { return "Pliant, XPBD"; }
    return options.reference ? "Pliant, reference mode" : "Pliant";
}

// Until the time of the scene's picture.
static int default_frames(const scene& which, float step_seconds) {
    const int frames = which.picture_frame > 0 ? which.picture_frame : 300;
    return std::max(1, static_cast<int>(std::lround(static_cast<float>(frames) * demos::frame_seconds / step_seconds)));
}

static nlohmann::ordered_json to_json(const demos::SceneCosts& costs) {
    nlohmann::ordered_json features = nlohmann::ordered_json::array(), passes = nlohmann::ordered_json::array();
    for (const demos::FeatureCost& feature : costs.features) {
        features.push_back({{"feature", feature.name},
                            {"is_needed", feature.is_needed},
                            {"has_passes", feature.has_passes},
                            {"bodies", feature.bodies},
                            {"bytes", feature.bytes},
                            {"microseconds", feature.microseconds}});
    }
    for (const demos::StageCost& pass : costs.passes) {
        passes.push_back(
            {{"stage", pass.stage},
             {"feature", pass.feature.empty() ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(pass.feature)},
             {"microseconds", pass.microseconds}});
    }
    return {{"bytes", costs.bytes},
            {"bytes_per_node", costs.bytes_per_node()},
            {"microseconds", costs.microseconds},
            {"features", features},
            {"passes", passes},
            {"left_out", costs.left_out},
            {"linked_bytes", costs.linked_bytes},
            {"core_bytes", costs.core_bytes},
            {"linked_modules", costs.linked_modules}};
}

static std::string costs_text(const demos::SceneCosts& costs) {
    report::Table features({"feature", "bytes", "us per step", ""});
    for (const demos::FeatureCost& feature : costs.features) {
        features.add({feature.name, std::to_string(feature.bytes),
                      feature.has_passes ? report::fixed(feature.microseconds, 2) : "-",
                      feature.is_needed ? "needed" : ""});
    }
    features.add({"all, bodies included", std::to_string(costs.bytes), report::fixed(costs.microseconds, 2), ""});
    report::Table passes({"pass", "us per step"});
    for (const demos::StageCost& pass : costs.passes) {
        passes.add(
            {pass.stage + (pass.feature.empty() ? "" : ": " + pass.feature), report::fixed(pass.microseconds, 2)});
    }
    std::string text = "\n" + features.text() + "\n" + passes.text() + "\nleft out: ";
    for (size_t i = 0; i < costs.left_out.size(); ++i) {
        text += (i == 0 ? "" : ", ") + costs.left_out[i];
    }
    text += "\nlinked: " + std::to_string(costs.linked_bytes) + " of the core's " + std::to_string(costs.core_bytes) +
            " bytes, in " + std::to_string(costs.linked_modules.size()) + " modules: ";
    for (size_t i = 0; i < costs.linked_modules.size(); ++i) {
        text += (i == 0 ? "" : ", ") + costs.linked_modules[i];
    }
    return text + "\n";
}

static void print_json(const RunOptions& options, const scene& which, const demos::SolverRun& solver,
                       const RunResult& result) {
    const demos::Measures& measures = result.measures;
    nlohmann::ordered_json document = {
        {"scene", which.name},
        {"engine", options.engine},
        {"solver", solver_name(solver.kind)},
        {"substeps", solver.substeps},
        {"iterations", solver.iterations},
        {"dt", options.step.seconds.value_or(1.0 / 60.0)},
        {"reference", options.reference},
        {"frames", result.frames},
        {"nodes", measures.nodes},
        {"links", measures.links},
        {"faces", measures.faces},
        {"tetras", measures.tetras},
        {"clusters", measures.clusters},
        {"ms_per_step", result.ms_per_step},
        {"finite", measures.finite},
        {"max_stretch", measures.max_stretch},
        {"rms_speed", measures.rms_speed},
        {"self_collision", self_collision_name(result.self_collision)},
        {"crossings", result.crossings.has_value() ? nlohmann::ordered_json(*result.crossings) : nullptr},
        {"kinetic_energy", measures.kinetic_energy},
        {"state_hash", hash_text(measures.state_hash)},
    };
    if (result.costs.has_value()) { document["costs"] = to_json(*result.costs); }
    std::cout << document.dump(2) << '\n';
}

static void print_text(const RunOptions& options, const scene& which, const demos::SolverRun& solver,
                       const RunResult& result) {
    const demos::Measures& measures = result.measures;
    const auto line = [](const char* label, const std::string& value) {
        std::cout << "  " << label << std::string(16 - std::string(label).size(), ' ') << value << '\n';
    };
    std::cout << which.name << " on " << engine_title(options, solver.kind) << ", " << result.frames << " frames\n";
    line("nodes", std::to_string(measures.nodes));
    line("links", std::to_string(measures.links));
    line("faces", std::to_string(measures.faces));
    if (measures.tetras > 0) { line("tetras", std::to_string(measures.tetras)); }
    if (measures.clusters > 0) { line("clusters", std::to_string(measures.clusters)); }
    line("ms per step", report::fixed(result.ms_per_step, 3) + " (median)");
    line("max stretch", report::fixed(measures.max_stretch, 4));
    line("kinetic energy", report::fixed(measures.kinetic_energy, 4) + " J");
    if (result.crossings.has_value()) {
        line("self-collision", self_collision_name(result.self_collision));
        line("crossing faces", std::to_string(*result.crossings) + " pairs");
        line("speed", report::fixed(measures.rms_speed, 4) + " m/s (root mean square)");
    }
    line("state hash", hash_text(measures.state_hash));
    if (result.costs.has_value()) { std::cout << costs_text(*result.costs); }
}

static demos::RecordedSettings recorded_settings(const RunOptions& options, const scene& which,
                                                 const demos::SolverRun& solver, float step_seconds) {
    return {which.name,
            options.changes.self_collision,
            options.changes.resolution,
            demos::solver_name(solver.kind),
            solver.substeps,
            options.step.iterations.value_or(0),
            options.step.threads,
            step_seconds,
            options.reference};
}

int run_scene(const RunOptions& options) {
    const scene& which = demos::choose_scene(options.scene);
    const bool is_bullet = options.engine == "bullet";
    if (options.reference && is_bullet) {
        throw demos::Error("--reference is a mode of Pliant and does not go with --engine bullet");
    }
    if (options.has_costs && is_bullet) {
        throw demos::Error("--costs are those of Pliant and do not go with --engine bullet");
    }
    const report::OutputFile png(options.png_file), csv(options.csv_file), recording(options.record_file);
    if (recording.is_wanted() && (is_bullet || !options.mesh_file.empty() || !options.tetra_base.empty())) {
        throw demos::Error("--record is of scenes on Pliant as they are, without --engine bullet, --mesh or --tetra");
    }
    if (png.is_wanted() && png.path() == csv.path()) {
        throw demos::Error("--png and --csv name the same file: " + options.png_file);
    }
    const std::unique_ptr<render::Painter> painter = png.is_wanted() ? std::make_unique<render::Painter>() : nullptr;
    demos::SceneOptions scene_settings = scene_options(options.changes);
    scene_settings.mesh_file = options.mesh_file;
    scene_settings.tetra_base = options.tetra_base;
    if (is_bullet && scene_settings.self_collision.value_or(SCENE_SELF_NONE) != SCENE_SELF_NONE) {
        throw demos::Error("btSoftBody has no self-collision of " + options.changes.self_collision);
    }
    const std::unique_ptr<demos::Description> description = demos::Description::build(which, scene_settings);
    const demos::EngineKind kind = is_bullet ? demos::EngineKind::bullet : demos::EngineKind::pliant;
    demos::EngineOptions engine_settings = engine_options(options.step);
    engine_settings.reference = options.reference;
    engine_settings.ordered_pairs = recording.is_wanted();
    const demos::SolverRun solver = choose_solver(*description, kind, engine_settings);
    const std::unique_ptr<demos::Engine> engine = demos::make_engine(kind, *description, engine_settings);

    const float step_seconds = engine_settings.step_seconds;
    const int frames = options.frames > 0 ? options.frames : default_frames(which, step_seconds);
    if (options.frame_files.first > frames) {
        throw demos::Error("--export-from " + std::to_string(options.frame_files.first) + " is after the last frame, " +
                           std::to_string(frames));
    }
    exporting::FrameExport frame_files(options.frame_files);
    Progress progress(options.json);
    progress.start(std::string(which.name) + " on " + engine->name());
    std::optional<demos::Recorder> recorder;
    if (recording.is_wanted()) {
        recorder.emplace(recorded_settings(options, which, solver, step_seconds), options.keyframe_interval);
    }
    RunResult result = run_frames(*engine, frames, static_cast<double>(step_seconds), frame_files,
                                  recorder.has_value() ? &*recorder : nullptr, progress);
    if (options.has_costs && result.measures.finite) {
        progress.start(std::string(which.name) + ", costs");
        result.costs = demos::measure_costs(*description, engine_settings, result.frames,
                                            [&](int frame, int all) { progress.show(frame, all); });
    }
    progress.clear();
    if (description->has_self_collision) {
        result.self_collision = engine->self_collision();
        if (result.measures.finite) { result.crossings = engine->crossings(); }
    }

    csv.write(result.csv);
    if (recorder.has_value()) { recording.write(recorder->recording().to_bytes()); }
    if (painter != nullptr && result.measures.finite) {
        const render::Snapshot snapshot = render::take_snapshot(*engine);
        const std::string title = std::string(which.name) + ": " + engine_title(options, solver.kind);
        const std::string detail =
            "frame " + std::to_string(result.frames) + ", " + report::fixed(result.ms_per_step, 3) + " ms per step";
        png.write(painter->draw({{&snapshot, title, detail}}, picture_width, picture_height).to_png());
    }
    if (options.json) {
        print_json(options, which, solver, result);
    } else {
        print_text(options, which, solver, result);
        if (png.is_wanted() && result.measures.finite) {
            std::cout << "  picture         " << png.path().string() << '\n';
        }
        if (frame_files.frames() > 0) {
            std::cout << "  exported        " << frame_files.frames() << " frames to " << options.frame_files.folder
                      << '\n';
        }
        if (recording.is_wanted()) { std::cout << "  recording       " << recording.path().string() << '\n'; }
        if (csv.is_wanted()) { std::cout << "  measures        " << csv.path().string() << '\n'; }
    }
    if (!result.measures.finite) {
        throw demos::Error(std::string(which.name) + " on " + engine->name() + " is no longer finite after frame " +
                           std::to_string(result.frames));
    }
    return 0;
}

} // namespace app
