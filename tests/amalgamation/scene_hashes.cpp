// Prints the state of scenes after 60 steps as hashes: ten under the solvers that they ask for, three under the
// implicit one.

#include "measure/measure.h"
#include "scenes/scene_choice.h"

#include <cstdio>
#include <optional>

static void print_hash(const char* name, std::optional<demos::SolverKind> solver) {
    const auto description = demos::Description::build(demos::choose_scene(name), demos::SceneOptions());
    demos::EngineOptions options;
    options.solver.kind = solver;
    const auto engine = demos::make_engine(demos::EngineKind::pliant, *description, options);
    for (int step = 0; step < 60; ++step) {
        engine->step();
    }
    std::printf("%s %016llx\n", name, static_cast<unsigned long long>(demos::measure(*engine).state_hash));
}

int main() {
    for (const char* name : {"Cloth", "Bunny", "ClusterCar", "Cutting1", "TetraCube", "Ropes", "Flag", "TwistedCloth",
                             "Pressure", "Aero2"}) {
        print_hash(name, std::nullopt);
    }
    for (const char* name : {"Cloth", "Bunny", "Ropes"}) {
        print_hash(name, demos::SolverKind::implicit);
    }
    return 0;
}
