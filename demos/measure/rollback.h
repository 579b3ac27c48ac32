#ifndef DEMOS_ROLLBACK_H
#define DEMOS_ROLLBACK_H

// Whether a scene that went back to a moment goes the same way again.

#include "engines/engine.h"

namespace demos {

struct Rollback {
    SolverKind solver = SolverKind::position_based;
    int threads = 1;
    int save_frame = 0;          // after the script's last cut: a snapshot does not fit another topology
    int frames = 0;              // that were repeated
    size_t bytes = 0;            // of the snapshot
    int first_unequal_frame = 0; // after the save, from 1; 0: none
    bool is_equal() const { return first_unequal_frame == 0; }
};

// Steps to `save_frame` or later, saves, steps `frames` on, restores, and steps them again: positions and velocities of
// all soft and rigid bodies are compared in each. Throws Error where the solver cannot run the scene.
Rollback compare_rollback(const Description& description, const EngineOptions& options, int save_frame, int frames);

} // namespace demos
#endif
