// Prints the state of ten scenes after 60 steps as hashes.

#include "measure/measure.h"
#include "scenes/scene_choice.h"

#include <cstdio>

int main() {
    for (const char* name : {"Cloth", "Bunny", "ClusterCar", "Cutting1", "TetraCube", "Ropes", "Flag", "TwistedCloth",
                             "Pressure", "Aero2"}) {
        const auto description = demos::Description::build(demos::choose_scene(name), demos::SceneOptions());
        const auto engine = demos::make_engine(demos::EngineKind::pliant, *description, demos::EngineOptions());
        for (int step = 0; step < 60; ++step) {
            engine->step();
        }
        std::printf("%s %016llx\n", name, static_cast<unsigned long long>(demos::measure(*engine).state_hash));
    }
    return 0;
}
