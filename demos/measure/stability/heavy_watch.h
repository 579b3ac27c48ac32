#ifndef DEMOS_HEAVY_WATCH_H
#define DEMOS_HEAVY_WATCH_H

// Shows the bodies of a running case to the checks of the group `heavy`.

#include "heavy_checks.h"

namespace demos {

// Which checks a case has. Reach and stretch are always checked, energy where the scene moves no rigid body.
struct HeavyRules {
    float step_seconds = frame_seconds;
    int substeps = 1;              // of XPBD
    double seconds = 0;            // of the run
    double figure_from = 0;        // s, of the stretch
    bool has_passage = true;       // nodes stay out of rigid bodies
    int lying = -1;                // rigid body that cloth carries; < 0: none
    int never_higher = -1;         // rigid body that never rises above its start
    bool rests = true;             // at the end
    Lasting stays{};               // from `stays_from` on
    double stays_from = -1;        // s; < 0: nothing has to stay
    bool has_fast_anchors = false; // to a body that the scene moves
};

std::function<std::unique_ptr<Watcher>()> watch_heavy(const HeavyRules& rules);

} // namespace demos
#endif
