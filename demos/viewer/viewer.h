#ifndef DEMOS_VIEWER_VIEWER_H
#define DEMOS_VIEWER_VIEWER_H

// The window with a scene in it: what mouse and keys mean, and what is drawn.

#include "panel.h"
#include "render/image.h"
#include "render/renderer.h"
#include "script.h"
#include "timeline_bar.h"
#include "window.h"

#include <optional>

namespace viewer {

struct ViewerOptions {
    const scene* first = nullptr;
    demos::SceneOptions meshes; // for the first scene only
    SessionOptions session;
    int width = 1280, height = 720;
    int frames = 0; // each of one step and one picture, then the end; 0: until the window is closed
    std::vector<Command> script;
    // Called by `report` in a script, with the place that it names.
    std::function<void(const Session&, const Place&)> report;
};

class Viewer {
public:
    explicit Viewer(const ViewerOptions& options);

    void run();
    const Session& session() const { return *session_; }
    // The window as it was drawn last.
    const render::Image& last_picture() const { return *last_picture_; }

private:
    // Part of the window that shows one run, pixels from the top left corner.
    struct Viewport {
        int left, width, height;
    };

    void open(const scene& which, const demos::SceneOptions& scene_options);
    // Does what may fail; the failure is then shown in the panel, and all stays as it was.
    bool attempt(const std::function<void()>& action);
    void open_neighbour(int step);
    void change_options(const SessionOptions& options);
    void frame_scene();
    void follow_bodies(pli_vec3 center);
    std::vector<Viewport> viewports() const;
    render::Camera camera() const;
    Ray ray_at(float x, float y) const;
    float grip_radius() const;

    void handle(const Event& event);
    void handle_key(Key key);
    void handle_press(const Event& event);
    void handle_move(const Event& event);
    void handle_release();
    // Along the timeline, and stops there.
    void go_to(int frame);

    void run_script();
    void perform(const Command& command);
    void place_cursor(const Place& place, Event& event) const;

    void advance();
    void follow(const PanelWishes& wishes);
    void draw();

    ViewerOptions options_;
    Window window_;
    render::Renderer renderer_{render::quick_shadows};
    std::vector<std::unique_ptr<render::Canvas>> canvases_;
    std::unique_ptr<Session> session_;
    PanelState panel_;
    Orbit orbit_;
    pli_vec3 center_{}; // of the soft bodies in the last picture
    DragTool drag_;
    SweptCut cut_;
    enum class Motion { none, turn, pan } motion_ = Motion::none;
    std::set<Key> keys_;
    float cursor_x_ = 0, cursor_y_ = 0;
    bool wants_step_ = false;
    int drawn_ = 0;
    size_t next_command_ = 0;
    double step_debt_ = 0; // frames that real time is ahead
    double last_seconds_ = 0;
    std::optional<render::Image> last_picture_;
};

} // namespace viewer
#endif
