// Random scenes for both engines: what scene_builder.h can say, and what only tests say.
#pragma once

#include "random_dice.hpp"

#include "description/recorder.h"
#include "engines/engine.h"

#include <vector>

namespace random_scene {

struct MovedNode {
    int node;
    pli_vec3 offset;
};

// Of a soft body, beyond its record.
struct Extras {
    std::vector<pli_cluster_settings> clusters; // as many as there are at most
    int cluster_iterations = 4;
    std::vector<MovedNode> moved_nodes;
    int move_step = 0; // before this step
    bool sets_state = false;
};

struct Case {
    float step_seconds = demos::frame_seconds;
    demos::RecordedDescription description;
    std::vector<Extras> extras;
    std::set<std::string> features; // those that are there
};

// Throws demos::Error.
std::unique_ptr<Case> make(std::uint64_t key, const std::set<std::string>& off);

} // namespace random_scene
