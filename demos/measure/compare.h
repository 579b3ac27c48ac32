#ifndef DEMOS_COMPARE_H
#define DEMOS_COMPARE_H

// How far Pliant is from btSoftBody in one scene.

#include "engines/engine.h"

#include <functional>

namespace demos {

// Each frame Pliant (reference mode) takes over the state of btSoftBody and of the rigid world, both make one step.
// Error of a frame = max over nodes of max(|dx|, dt |dv|) / diagonal of the rest bounds.
struct OneStep {
    int frames = 0;
    double median = 0, p99 = 0, maximum = 0;
    double bit_equal_share = 0;        // of the frames, 0..1; rigid bodies must be equal too
    int frames_with_lone_contacts = 0; // a contact that only one engine made
    int frames_above_limit = 0;        // error above 1e-5
    int unexplained_frames = 0;        // above 1e-5 without such a contact
    std::vector<double> errors;        // per frame
};

// Both from the same start, each on its own. Error as above without the velocity; < 0: not reached.
struct FreeRun {
    double error_30 = -1, error_60 = -1, error_300 = -1;
};

struct Comparison {
    std::string scene;
    SolverRun solver;                // of Pliant
    std::optional<OneStep> one_step; // with Bullet's solver only
    FreeRun free_run;
    int nodes = 0;
    double bullet_ms = 0, pliant_ms = 0; // medians per step, free run
    double time_ratio = 0;               // bullet_ms / pliant_ms
};

using Progress = std::function<void(int frame, int frames)>; // may be empty

// Where Pliant takes the nearest points of clusters from in a comparison: from Bullet's GJK and EPA or its own.
enum class Witness { bullet, pliant };

// What btSoftBody and Pliant's reference mode take of the options for Pliant.
EngineOptions bullet_options(const EngineOptions& options, SolverKind of_pliant);
EngineOptions reference_options(const EngineOptions& options, Witness witness);

// Of `options` solver and length of a step are used, by btSoftBody too; the solver must be Bullet's.
OneStep compare_one_step(const Description& description, int frames, const Progress& progress,
                         Witness witness = Witness::bullet, const EngineOptions& options = {});
// With another solver than Bullet's there is no one-step part, and the free run is not in reference mode.
Comparison compare(const Description& description, int frames, const Progress& progress,
                   Witness witness = Witness::bullet, const EngineOptions& options = {});

} // namespace demos
#endif
