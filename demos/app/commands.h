#ifndef DEMOS_APP_COMMANDS_H
#define DEMOS_APP_COMMANDS_H

// The subcommands. Each returns the exit status; failures are thrown as demos::Error.

#include "engines/engine.h"
#include "export/frame_export.h"

#include <cstdint>
#include <string>
#include <vector>

namespace app {

struct ListOptions {
    bool json = false;
};

// --solver, --substeps, --iterations, --dt, --threads and --simd as they were given; empty: not given.
struct StepOptions {
    std::optional<std::string> solver;
    std::optional<int> substeps, iterations;
    std::optional<double> seconds;
    int threads = 1;
    std::string simd = "best";
};

demos::EngineOptions engine_options(const StepOptions& options);

// --self-collision and --resolution, the latter as "N" or "NxM".
struct SceneChanges {
    std::string self_collision = "on", resolution;
};

demos::SceneOptions scene_options(const SceneChanges& changes);

struct RunOptions {
    std::string scene, engine = "pliant";
    bool reference = false;
    int frames = 0; // 0: up to the scene's picture
    StepOptions step;
    SceneChanges changes;
    std::string mesh_file, tetra_base, png_file, csv_file;
    exporting::ExportOptions frame_files;
    std::string record_file;
    int keyframe_interval = 600; // frames
    bool has_costs = false;
    bool json = false;
};

struct ReplayOptions {
    std::string file;
    int from = 0; // frame
    bool verify = false;
    bool json = false;
};

struct DivergeOptions {
    std::string first, second; // the second may be empty: this build
    bool json = false;
};

struct CompareOptions {
    std::vector<std::string> scenes;
    int frames = 300;
    std::string csv_file;
    std::string witness = "bullet"; // or "pliant"
    bool snapshots = false;         // instead: whether scenes that go back go the same way again
    StepOptions step;
    SceneChanges changes;
    bool json = false;
};

struct BenchOptions {
    std::vector<std::string> scenes;
    std::string series; // in place of scenes
    int frames = 0;     // 0: 300, or 60 when quick; in a series by size
    bool is_quick = false;
    int threads = 1;
    std::string csv_file;
    bool json = false;
};

struct DemoOptions {
    std::string folder = "pliant-demo";
    int frames = 300;
};

struct ViewOptions {
    std::string scene, engine = "pliant"; // or "bullet" or "both"
    StepOptions step;
    std::string mesh_file, tetra_base, png_file, script_file;
    int width = 1280, height = 720;
    int frames = 0; // 0: until the window is closed
    bool json = false;
};

struct StabilityOptions {
    std::vector<std::string> groups;  // none: all
    std::string part_of_name;         // of cases; empty: all
    std::vector<std::string> solvers; // columns; none: all
    int rest_steps = 0;               // 0: the default
    bool awake = false;
    int jobs = 0;      // cells at a time; 0: as many as there are processors
    uint64_t seed = 1; // of the random cases
    int random_count = 100;
    std::string folder; // empty: no files
    bool json = false;
};

struct SoakOptions {
    double minutes = 0.0; // 0: no soak
    uint64_t seed = 1;
    std::string folder; // for the bytes of a finding; empty: the working folder
    bool json = false;
};

struct WorkprecOptions {
    std::vector<std::string> scenes; // none: all
    bool is_quick = false;
    std::string folder; // empty: no files
    bool json = false;
};

struct ServeOptions {
    std::string folder = "build/web";
    int port = 8000; // 0: any that is free
};

struct ReportOptions {
    std::vector<std::string> parts; // none: all
    std::string folder = "pliant-report";
    bool is_quick = false;
};

int run_list(const ListOptions& options);
int run_report(const ReportOptions& options);
int run_scene(const RunOptions& options);
int run_serve(const ServeOptions& options);
int run_replay(const ReplayOptions& options);
int run_diverge(const DivergeOptions& options);
int run_compare(const CompareOptions& options);
int run_compare_snapshots(const CompareOptions& options);
int run_bench(const BenchOptions& options);
int run_demo(const DemoOptions& options);
int run_view(const ViewOptions& options);
int run_stability(const StabilityOptions& options);
int run_soak(const SoakOptions& options);
int run_workprec(const WorkprecOptions& options);

} // namespace app
#endif
