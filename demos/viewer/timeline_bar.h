#ifndef DEMOS_VIEWER_TIMELINE_BAR_H
#define DEMOS_VIEWER_TIMELINE_BAR_H

// The timeline below the picture: frames, where the user did something, and buttons to go along it.

#include "session.h"

#include <optional>

namespace viewer {

// What the user has asked for there.
struct TimelineWishes {
    std::optional<int> frame; // to go to
    bool toggles_pause = false;
};

// At the lower edge of a picture, pixels of the window.
TimelineWishes describe_timeline(const Session& session, bool is_paused, int left, int width, int height);

} // namespace viewer
#endif
