// How far soft bodies are stretched in Bullet's demo scenes, over runs whose steps differ a little: one run of a body
// that bounces says little.
//
//   stretch_over_runs [RUNS] [SCENE...]    6 runs, all 33 scenes

#include "engines/engine.h"
#include "measure/measure.h"
#include "scenes/scenes.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

namespace {

constexpr int first_frame = 300, last_frame = 900;

// Root mean square over the links and the frames from the first to the last.
double stretch_of_run(demos::EngineKind kind, bool in_mesh_order, const demos::Description& description,
                      float step_seconds) {
    demos::EngineOptions options;
    options.step_seconds = step_seconds;
    options.solver.in_mesh_order = in_mesh_order;
    const std::unique_ptr<demos::Engine> engine = demos::make_engine(kind, description, options);
    double sum = 0;
    for (int frame = 0; frame < last_frame; ++frame) {
        engine->step();
        if (frame < first_frame) { continue; }
        const double stretch = demos::measure(*engine).rms_stretch;
        sum += stretch * stretch / (last_frame - first_frame);
    }
    return std::sqrt(sum);
}

struct Spread {
    double mean = 0, deviation = 0;
};

Spread stretch_over_runs(demos::EngineKind kind, bool in_mesh_order, const demos::Description& description, int runs) {
    double sum = 0, squares = 0;
    for (int run = 0; run < runs; ++run) {
        const float step_seconds = demos::frame_seconds * (1.0f + 2e-5f * static_cast<float>(run - runs / 2));
        const double stretch = stretch_of_run(kind, in_mesh_order, description, step_seconds);
        sum += stretch;
        squares += stretch * stretch;
    }
    const double mean = sum / runs;
    return {mean, std::sqrt(std::fmax(0.0, squares / runs - mean * mean))};
}

void print_scene(const scene& which, int runs) {
    const std::unique_ptr<demos::Description> description = demos::Description::build(which, {});
    const Spread bullet = stretch_over_runs(demos::EngineKind::bullet, false, *description, runs);
    const Spread colored = stretch_over_runs(demos::EngineKind::pliant, false, *description, runs);
    const Spread ordered = stretch_over_runs(demos::EngineKind::pliant, true, *description, runs);
    std::printf("%-18s %8.2g (%.1g) %8.2g (%.1g) %8.2g (%.1g) %8.3f %8.3f\n", which.name, bullet.mean, bullet.deviation,
                colored.mean, colored.deviation, ordered.mean, ordered.deviation, colored.mean / bullet.mean,
                ordered.mean / bullet.mean);
    std::fflush(stdout);
}

bool is_wanted(const std::vector<std::string>& names, const scene& which) {
    bool wanted = names.empty();
    for (const std::string& name : names) {
        wanted = wanted || name == which.name;
    }
    return wanted;
}

} // namespace

int main(int count, char** arguments) {
    const int runs = count > 1 ? std::atoi(arguments[1]) : 6;
    if (runs < 1) {
        std::fprintf(stderr, "stretch_over_runs [RUNS] [SCENE...]\n");
        return 2;
    }
    const std::vector<std::string> names(arguments + (count > 1 ? 2 : 1), arguments + count);
    std::printf("%-18s %15s %15s %15s %8s %8s\n", "scene", "btSoftBody", "colours", "mesh order", "ratio", "ratio");
    for (int i = 0; i < scene_demo_count; ++i) {
        if (is_wanted(names, *scene_list[i])) { print_scene(*scene_list[i], runs); }
    }
    return 0;
}
