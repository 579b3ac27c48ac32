#ifndef DEMOS_VIEWER_SCRIPT_H
#define DEMOS_VIEWER_SCRIPT_H

// A file that does what mouse and keys would do, frame by frame. docs/program.md describes it.

#include "input.h"

#include <string>
#include <vector>

namespace viewer {

// Where the cursor goes.
struct Place {
    enum class Kind { pixel, node, by };
    Kind kind = Kind::pixel;
    int soft = 0, node = 0; // over this node
    float x = 0, y = 0;     // pixels of the window, or from where the cursor is
};

struct Command {
    enum class Kind { press, release, move, wheel, key, key_down, key_up, set, steps, go, scene, report };
    Kind kind = Kind::report;
    int frame = 0; // happens before the step that follows so many frames
    Key key = Key::none;
    Button button = Button::none;
    bool shift = false, control = false;
    Place place;
    float value = 0; // of a wheel or a control
    int index = 0;   // of a control, the number of steps, or a frame
    std::string name;
    std::string source; // file and line, as in messages
};

// Commands in the order of frames. Throws demos::Error with the file and the line.
std::vector<Command> read_script(const std::string& path);

} // namespace viewer
#endif
