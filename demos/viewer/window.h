#ifndef DEMOS_VIEWER_WINDOW_H
#define DEMOS_VIEWER_WINDOW_H

// A window with an OpenGL 3.3 context, its events, and Dear ImGui on top of it.

#include "input.h"

#include <memory>
#include <string>
#include <vector>

namespace viewer {

class Window {
public:
    // Throws demos::Error when there is no display or no OpenGL 3.3.
    Window(const std::string& title, int width, int height);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    bool is_open() const;
    void close();
    void set_title(const std::string& title);

    // In pixels of the picture, as are the places of events.
    int width() const;
    int height() const;
    // Size of letters and widgets; 1 on a usual screen.
    float scale() const;

    // What has happened since the last call and is not meant for the panel.
    std::vector<Event> take_events();

    // Between these two the panel is described.
    void begin_panel();
    void draw_panel();
    void show();
    // Whether show() waits for the screen.
    void set_wait(bool wait);

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

} // namespace viewer
#endif
