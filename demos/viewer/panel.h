#ifndef DEMOS_VIEWER_PANEL_H
#define DEMOS_VIEWER_PANEL_H

// The panel beside the picture.

#include "session.h"
#include "tools.h"

#include <optional>

namespace viewer {

// What the panel shows and changes in place.
struct PanelState {
    bool is_hidden = false, hides_timeline = false;
    bool is_paused = false;
    render::Look look;
    bool follows = false;    // the camera goes along with the soft bodies
    float cut_radius = 1.0f; // m
    BallSettings ball;
    double frames_per_second = 0;
};

// What the user has asked for in the panel.
struct PanelWishes {
    const scene* chosen = nullptr;
    std::optional<SessionOptions> options; // other engines, or another solver
    bool restart = false, step = false, look_changed = false;
    int neighbour = 0; // -1 previous scene, 1 next
};

// In pixels, of a window of that width; 0 when the panel is hidden.
int panel_width(const PanelState& state, int window_width, float scale);
PanelWishes describe_panel(Session& session, PanelState& state, const SessionOptions& options, int width, int height);
// The name of an engine at the top of its picture.
void describe_title(const std::string& title, int left, int width);

} // namespace viewer
#endif
