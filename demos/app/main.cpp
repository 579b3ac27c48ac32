// The program `pliant`: reads the command line, runs one subcommand, and turns every failure into one line on stderr
// and an exit status (1: the work failed, 2: the command line is wrong).

#include "commands.h"
#include "engines/engine.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <iostream>
#include <new>
#include <string>
#include <vector>

using app::BenchOptions;
using app::CompareOptions;
using app::DemoOptions;
using app::DivergeOptions;
using app::ListOptions;
using app::ReplayOptions;
using app::ReportOptions;
using app::RunOptions;
using app::ServeOptions;
using app::SoakOptions;
using app::StabilityOptions;
using app::ViewOptions;
using app::WorkprecOptions;

static constexpr int most_frames = 1000000, most_substeps = 1000, most_iterations = 10000, most_nodes_a_side = 1000,
                     most_threads = 256;
static constexpr double shortest_step = 1e-5, longest_step = 1.0; // s

static void add_frames(CLI::App* command, int& frames, const std::string& text) {
    command->add_option("--frames", frames, text)->check(CLI::Range(1, most_frames).description(""))->type_name("N");
}

static void add_json(CLI::App* command, bool& json) {
    command->add_flag("--json", json, "Print one JSON document instead of text");
}

static void add_threads(CLI::App* command, int& threads) {
    command->add_option("--threads", threads, "Of Pliant; results do not depend on it (default: 1)")
        ->check(CLI::Range(1, most_threads).description(""))
        ->type_name("N");
}

static void add_step(CLI::App* command, app::StepOptions& options) {
    command
        ->add_option("--solver", options.solver,
                     "What steps the soft bodies: position-based, implicit or xpbd (default: the scene's own, mostly "
                     "position-based)")
        ->check(CLI::IsMember({"position-based", "implicit", "xpbd"}).description(""))
        ->type_name("NAME");
    command->add_option("--substeps", options.substeps, "Parts of a step of xpbd (default: the scene's own or 10)")
        ->check(CLI::Range(1, most_substeps).description(""))
        ->type_name("N");
    command
        ->add_option(
            "--iterations", options.iterations,
            "Position iterations of position-based (default: the scene's own), sweeps of implicit (5; take an odd "
            "number), sweeps of xpbd in each substep (1)")
        ->check(CLI::Range(0, most_iterations).description(""))
        ->type_name("N");
    command->add_option("--dt", options.seconds, "Length of a step in s (default: 1/60)")
        ->check(CLI::Validator(
            [](const std::string& text) {
                double seconds = 0.0;
                const bool is_number = CLI::detail::lexical_cast(text, seconds);
                const bool is_allowed = is_number && seconds >= shortest_step && seconds <= longest_step; // not NaN
                return is_allowed ? std::string() : "Value " + text + " not in range 0.00001 to 1";
            },
            ""))
        ->type_name("S");
    add_threads(command, options.threads);
    command
        ->add_option("--simd", options.simd,
                     "Instructions of Pliant: best of this processor (default) or portable, those of every one of its "
                     "kind; results do not depend on it")
        ->check(CLI::IsMember({"best", "portable"}).description(""))
        ->type_name("NAME");
}

// "N" or "NxM"; the text is checked here and read by scene_options.
static std::string resolution_problem(const std::string& text) {
    const size_t cross = text.find('x');
    const std::string parts[2] = {text.substr(0, cross), cross == std::string::npos ? "2" : text.substr(cross + 1)};
    for (const std::string& part : parts) {
        const bool is_number =
            !part.empty() && part.size() <= 4 && part.find_first_not_of("0123456789") == std::string::npos;
        if (!is_number || std::stoi(part) < 2 || std::stoi(part) > most_nodes_a_side) {
            return "Value " + text + " is not a number from 2 to 1000 or two of them, as 30x200";
        }
    }
    return "";
}

static void add_scene_changes(CLI::App* command, app::SceneChanges& changes) {
    command
        ->add_option("--self-collision", changes.self_collision,
                     "on (default, the scene's own), off, or another kind: nodes, grids or faces")
        ->check(CLI::IsMember({"on", "off", "nodes", "grids", "faces"}).description(""))
        ->type_name("KIND");
    command
        ->add_option("--resolution", changes.resolution,
                     "Nodes of a cloth: N, or columns and rows as 30x200 (default: the scene's own)")
        ->check(CLI::Validator(resolution_problem, ""))
        ->type_name("N");
}

static void add_list(CLI::App& program, ListOptions& options, std::function<int()>& chosen) {
    CLI::App* command = program.add_subcommand("list", "List the scenes");
    add_json(command, options.json);
    command->callback([&] { chosen = [&] { return app::run_list(options); }; });
}

static void add_export(CLI::App* command, exporting::ExportOptions& options) {
    CLI::Option* folder =
        command->add_option("--export", options.folder, "Write the bodies of every frame to files in this folder");
    folder->type_name("DIR");
    command->add_option("--format", options.format, "Of these files: obj (default), pc2 or vtk")
        ->check(CLI::IsMember({"obj", "pc2", "vtk"}).description(""))
        ->type_name("NAME")
        ->needs(folder);
    command->add_option("--export-from", options.first, "First frame to write (default: 0, the start)")
        ->check(CLI::Range(0, most_frames).description(""))
        ->type_name("N")
        ->needs(folder);
    command->add_option("--export-every", options.every, "Write every N-th frame (default: 1)")
        ->check(CLI::Range(1, most_frames).description(""))
        ->type_name("N")
        ->needs(folder);
}

static void add_run(CLI::App& program, RunOptions& options, std::function<int()>& chosen) {
    CLI::App* command = program.add_subcommand("run", "Run a scene and measure it");
    command->add_option("scene", options.scene, "Name of the scene, as `pliant list` shows it")
        ->required()
        ->type_name("SCENE");
    command->add_option("--engine", options.engine, "Engine to run it with: pliant (default) or bullet")
        ->check(CLI::IsMember({"pliant", "bullet"}).description(""))
        ->type_name("NAME");
    command->add_flag("--reference", options.reference, "Pliant as for comparisons: with Bullet's sampled distances");
    add_frames(command, options.frames, "Steps (default: up to the scene's picture)");
    add_step(command, options.step);
    command->add_option("--mesh", options.mesh_file, "OBJ file in place of the scene's triangle mesh")
        ->type_name("FILE");
    command->add_option("--tetra", options.tetra_base, "BASE.node and BASE.ele in place of the scene's tetrahedra")
        ->type_name("BASE");
    add_scene_changes(command, options.changes);
    command->add_option("--png", options.png_file, "Write a picture of the last frame")->type_name("FILE");
    command->add_option("--csv", options.csv_file, "Write one line of measures per frame")->type_name("FILE");
    add_export(command, options.frame_files);
    CLI::Option* record =
        command->add_option("--record", options.record_file, "Write what `pliant replay` plays again");
    record->type_name("FILE");
    command
        ->add_option("--keyframes", options.keyframe_interval, "Frames from a whole state to the next (default: 600)")
        ->check(CLI::Range(1, most_frames).description(""))
        ->type_name("N")
        ->needs(record);
    command->add_flag("--costs", options.has_costs, "Tell what time and memory each feature takes");
    add_json(command, options.json);
    command->callback([&] { chosen = [&] { return app::run_scene(options); }; });
}

static void add_replay(CLI::App& program, ReplayOptions& options, std::function<int()>& chosen) {
    CLI::App* command = program.add_subcommand("replay", "Play a recording of `pliant run --record` again");
    command->add_option("file", options.file, "The recording")->required()->type_name("FILE");
    command->add_flag("--verify", options.verify, "Fail at the first frame that is not as recorded");
    command->add_option("--from", options.from, "Frame to begin at, by the keyframe before it (default: 0, the start)")
        ->check(CLI::Range(0, most_frames).description(""))
        ->type_name("FRAME");
    add_json(command, options.json);
    command->callback([&] { chosen = [&] { return app::run_replay(options); }; });
}

static void add_diverge(CLI::App& program, DivergeOptions& options, std::function<int()>& chosen) {
    CLI::App* command =
        program.add_subcommand("diverge", "Find where two recordings part: first frame, body, node and feature");
    command->add_option("first", options.first, "A recording")->required()->type_name("A");
    command->add_option("second", options.second, "Another one (default: what this build makes of the scene)")
        ->type_name("B");
    add_json(command, options.json);
    command->callback([&] { chosen = [&] { return app::run_diverge(options); }; });
}

static void add_compare(CLI::App& program, CompareOptions& options, std::function<int()>& chosen) {
    CLI::App* command = program.add_subcommand("compare", "Measure how far Pliant is from Bullet's btSoftBody");
    command->add_option("scenes", options.scenes, "Names of scenes, or all of Bullet's demo")->type_name("SCENE");
    CLI::Option* snapshots = command->add_flag(
        "--snapshots", options.snapshots,
        "Instead: save at frame 60, run on, restore, and compare the frames that follow with those that did, for every "
        "scene (or those that are named), solver and for 1 and 3 threads");
    add_frames(command, options.frames, "Steps (default: 300)");
    add_step(command, options.step);
    add_scene_changes(command, options.changes);
    command
        ->add_option("--witness", options.witness,
                     "Where Pliant takes the nearest points of clusters from: bullet (default) or pliant")
        ->check(CLI::IsMember({"bullet", "pliant"}).description(""))
        ->type_name("NAME");
    command->add_option("--csv", options.csv_file, "Write one line per scene")->type_name("FILE");
    add_json(command, options.json);
    command->callback([&, snapshots] {
        if (options.scenes.empty() && snapshots->empty()) { throw CLI::RequiredError("scenes"); }
        chosen = [&] { return options.snapshots ? app::run_compare_snapshots(options) : app::run_compare(options); };
    });
}

static void add_bench(CLI::App& program, BenchOptions& options, std::function<int()>& chosen) {
    CLI::App* command = program.add_subcommand("bench", "Measure what soft bodies cost, in Pliant and in btSoftBody");
    command->add_option("scenes", options.scenes, "Names of scenes, or all of Bullet's demo")->type_name("SCENE");
    command
        ->add_option(
            "--series", options.series,
            "Scenes of growing size instead: sheet, sphere or bodies; or those for threads: crowd, crowd-xpbd, "
            "flags, tori, fold, jacobi, gradients, drape")
        ->check(CLI::IsMember({"sheet", "sphere", "bodies", "crowd", "crowd-xpbd", "flags", "tori", "fold", "jacobi",
                               "gradients", "drape"})
                    .description(""))
        ->type_name("NAME");
    add_frames(command, options.frames, "Frames of 1/60 s (default: 300, or 60 with --quick)");
    command->add_flag("--quick", options.is_quick, "Fewer frames, and each only once");
    add_threads(command, options.threads);
    command->add_option("--csv", options.csv_file, "Write one line per scene")->type_name("FILE");
    add_json(command, options.json);
    command->callback([&] { chosen = [&] { return app::run_bench(options); }; });
}

static void add_demo(CLI::App& program, DemoOptions& options, std::function<int()>& chosen) {
    CLI::App* command = program.add_subcommand("demo", "Run four scenes on both engines and make a page of pictures");
    command->add_option("--out", options.folder, "Folder for the page and its pictures (default: pliant-demo)")
        ->type_name("DIR");
    add_frames(command, options.frames, "Frames of 1/60 s to measure (default: 300)");
    command->callback([&] { chosen = [&] { return app::run_demo(options); }; });
}

static void add_view(CLI::App& program, ViewOptions& options, std::function<int()>& chosen) {
    CLI::App* command = program.add_subcommand("view", "Run scenes in a window, with mouse and keys");
    command->add_option("scene", options.scene, "Name of the first scene (default: Cloth)")->type_name("SCENE");
    command->add_option("--engine", options.engine, "Engine to run it with: pliant (default), bullet or both")
        ->check(CLI::IsMember({"pliant", "bullet", "both"}).description(""))
        ->type_name("NAME");
    command->add_option("--mesh", options.mesh_file, "OBJ file in place of the scene's triangle mesh")
        ->type_name("FILE");
    command->add_option("--tetra", options.tetra_base, "BASE.node and BASE.ele in place of the scene's tetrahedra")
        ->type_name("BASE");
    add_step(command, options.step);
    command->add_option("--width", options.width, "Of the window, pixels (default: 1280)")
        ->check(CLI::Range(320, 8192).description(""))
        ->type_name("N");
    command->add_option("--height", options.height, "Of the window, pixels (default: 720)")
        ->check(CLI::Range(240, 8192).description(""))
        ->type_name("N");
    add_frames(command, options.frames, "Show so many frames, one step each, and end");
    command->add_option("--script", options.script_file, "What mouse and keys do, by frames")->type_name("FILE");
    command->add_option("--png", options.png_file, "Write a picture of the window at the last frame")
        ->type_name("FILE");
    add_json(command, options.json);
    command->callback([&] { chosen = [&] { return app::run_view(options); }; });
}

static void add_stability(CLI::App& program, StabilityOptions& options, SoakOptions& soak,
                          std::function<int()>& chosen) {
    CLI::App* command = program.add_subcommand("stability", "Run extreme cases with btSoftBody and the three solvers");
    command->add_option("groups", options.groups, "Groups of cases (default: all but heavy and random)")
        ->type_name("GROUP");
    command->add_option("--case", options.part_of_name, "Only cases with this text in their names")->type_name("TEXT");
    command->add_option("--solver", options.solvers, "Only these columns, as the table names them (default: all)")
        ->check(CLI::IsMember({"btSoftBody", "position-based", "implicit", "gradients", "xpbd"}).description(""))
        ->delimiter(',')
        ->type_name("NAME");
    command->add_flag("--awake", options.awake, "Bodies of the group heavy do not sleep");
    command->add_option("--rest-steps", options.rest_steps, "Steps of the cases at rest (default: 20000)")
        ->check(CLI::Range(2000, 10000000).description(""))
        ->type_name("N");
    command->add_option("--jobs", options.jobs, "Cells that run at the same time (default: one per processor)")
        ->check(CLI::Range(1, 256).description(""))
        ->type_name("N");
    command
        ->add_option("--out", options.folder,
                     "Write stability.csv and stability.svg, or the bytes of a finding, to this folder")
        ->type_name("DIR");
    CLI::Option* minutes =
        command->add_option("--soak", soak.minutes, "Build, step, cut and tear down random worlds for so long instead")
            ->check(CLI::Range(0.0, 1e6).description(""))
            ->type_name("MINUTES");
    CLI::Option* seed = command->add_option("--seed", soak.seed, "Other random worlds or cases (default: 1)");
    seed->type_name("N");
    command->add_option("--count", options.random_count, "Cases of the group random (default: 100)")
        ->check(CLI::Range(1, 1000000).description(""))
        ->type_name("N");
    add_json(command, options.json);
    command->callback([&, minutes, seed] {
        const bool is_random =
            std::find(options.groups.begin(), options.groups.end(), "random") != options.groups.end();
        if (!seed->empty() && minutes->empty() && !is_random) {
            throw CLI::RequiresError("--seed", "--soak or the group random");
        }
        options.seed = soak.seed;
        soak.folder = options.folder;
        soak.json = options.json;
        const bool is_soak = !minutes->empty();
        chosen = [&, is_soak] { return is_soak ? app::run_soak(soak) : app::run_stability(options); };
    });
}

static void add_workprec(CLI::App& program, WorkprecOptions& options, std::function<int()>& chosen) {
    CLI::App* command = program.add_subcommand("workprec", "Measure error against run time of every solver");
    command->add_option("scenes", options.scenes, "Names of its scenes, or all (default: all)")->type_name("SCENE");
    command->add_flag("--quick", options.is_quick, "Fewer settings");
    command->add_option("--out", options.folder, "Write workprec.csv and the plots to this folder")->type_name("DIR");
    add_json(command, options.json);
    command->callback([&] { chosen = [&] { return app::run_workprec(options); }; });
}

static void add_report(CLI::App& program, ReportOptions& options, std::function<int()>& chosen) {
    CLI::App* command = program.add_subcommand("report", "Make one page of pictures and of all measurements");
    command
        ->add_option("parts", options.parts,
                     "Parts of it: pictures, comparison, speed, precision, stability, costs (default: all)")
        ->check(CLI::IsMember({"pictures", "comparison", "speed", "precision", "stability", "costs"}).description(""))
        ->type_name("PART");
    command->add_option("--out", options.folder, "Folder for the page and its data (default: pliant-report)")
        ->type_name("DIR");
    command->add_flag("--quick", options.is_quick, "Four scenes, and a part of the other measurements");
    command->callback([&] { chosen = [&] { return app::run_report(options); }; });
}

static void add_serve(CLI::App& program, ServeOptions& options, std::function<int()>& chosen) {
    CLI::App* command = program.add_subcommand("serve", "Serve the page of the scenes to browsers of this machine");
    command->add_option("folder", options.folder, "What is served (default: build/web)")->type_name("DIR");
    command->add_option("--port", options.port, "0: any that is free (default: 8000)")
        ->check(CLI::Range(0, 65535).description(""))
        ->type_name("N");
    command->callback([&] { chosen = [&] { return app::run_serve(options); }; });
}

static int fail(const std::string& reason, int status) {
    std::cout.flush();
    const std::string line = reason.substr(0, reason.find('\n'));
    std::fprintf(stderr, "pliant: %s\n", line.c_str());
    return status;
}

// What is wrong with the command line, and where to read more.
static std::string usage_problem(CLI::App& program, const CLI::ParseError& error, int argument_count,
                                 char** arguments) {
    const std::vector<CLI::App*> named = program.get_subcommands();
    if (!named.empty()) { return error.what() + (" (see pliant " + named.front()->get_name() + " --help)"); }
    const std::string first = argument_count > 1 ? arguments[1] : "";
    const bool is_word = !first.empty() && first[0] != '-';
    return (is_word ? "there is no subcommand named " + first : error.what()) + " (see pliant --help)";
}

static int run_program(int argument_count, char** arguments) {
    ListOptions list;
    RunOptions run;
    CompareOptions compare;
    ReplayOptions replay;
    DivergeOptions diverge;
    BenchOptions bench;
    DemoOptions demo;
    ViewOptions view;
    StabilityOptions stability;
    SoakOptions soak;
    WorkprecOptions workprec;
    ReportOptions report;
    ServeOptions serve;
    std::function<int()> chosen;
    CLI::App program("Soft bodies of Pliant beside those of Bullet, on the same scenes.", "pliant");
    program.set_version_flag("--version", "pliant " APP_VERSION);
    program.require_subcommand(1);
    add_list(program, list, chosen);
    add_run(program, run, chosen);
    add_compare(program, compare, chosen);
    add_replay(program, replay, chosen);
    add_diverge(program, diverge, chosen);
    add_bench(program, bench, chosen);
    add_demo(program, demo, chosen);
    add_view(program, view, chosen);
    add_stability(program, stability, soak, chosen);
    add_workprec(program, workprec, chosen);
    add_report(program, report, chosen);
    add_serve(program, serve, chosen);
    try {
        program.parse(argument_count, arguments);
    } catch (const CLI::Success& request) { // --help, --version
        return program.exit(request);
    } catch (const CLI::ParseError& error) { return fail(usage_problem(program, error, argument_count, arguments), 2); }
    const int status = chosen();
    if (!std::cout.flush()) { throw demos::Error("standard output cannot be written"); }
    return status;
}

int main(int argument_count, char** arguments) {
    try {
        return run_program(argument_count, arguments);
    } catch (const std::bad_alloc&) { return fail("out of memory", 1); } catch (const std::exception& error) {
        return fail(error.what(), 1);
    }
}
