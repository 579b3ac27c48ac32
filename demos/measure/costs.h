#ifndef DEMOS_COSTS_H
#define DEMOS_COSTS_H

// What the soft bodies of a scene pay for on Pliant: the features that are on, their passes, their memory.

#include "bench.h"

namespace demos {

// Sums over the soft bodies.
struct FeatureCost {
    std::string name;
    bool is_needed = true;  // is on only because other features need it
    bool has_passes = true; // of its own in a step
    int bodies = 0;         // that have it
    size_t bytes = 0;
    double microseconds = 0; // mean per step
};

struct SceneCosts {
    int nodes = 0;
    size_t bytes = 0;                  // of all soft bodies, features included
    double microseconds = 0;           // mean per step, of all passes
    std::vector<FeatureCost> features; // in the order of enabling
    std::vector<StageCost> passes;     // in the order of a step
    std::vector<std::string> left_out; // features that no soft body has
    // Of the core, what a static program links that has these features and the scene's shapes; see core_modules.h.
    size_t linked_bytes = 0, core_bytes = 0;
    std::vector<std::string> linked_modules;

    double bytes_per_node() const { return nodes > 0 ? static_cast<double>(bytes) / nodes : 0.0; }
};

// Runs the scene once more, with clocks in it.
SceneCosts measure_costs(const Description& description, const EngineOptions& options, int frames,
                         const Progress& progress);

} // namespace demos
#endif
