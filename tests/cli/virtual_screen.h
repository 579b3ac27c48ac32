#ifndef TESTS_CLI_VIRTUAL_SCREEN_H
#define TESTS_CLI_VIRTUAL_SCREEN_H

// An X server without a screen, for programs with windows.

#include <string>

namespace cli {

class VirtualScreen {
public:
    VirtualScreen(); // starts Xvfb
    ~VirtualScreen();
    VirtualScreen(const VirtualScreen&) = delete;
    VirtualScreen& operator=(const VirtualScreen&) = delete;

    // Xvfb is here and has started.
    bool is_there() const { return !display_.empty(); }
    // For cli::run: where the window goes.
    std::string environment() const { return "env -u WAYLAND_DISPLAY DISPLAY=" + display_; }

private:
    int process_ = -1;
    std::string display_;
};

} // namespace cli
#endif
