#include "viewer.h"

#include "engines/stopwatch.h"
#include "scenes/scene_choice.h"
#include "scenes/scenes.h"

#include <algorithm>
#include <limits>

namespace viewer {

static constexpr int most_steps_per_picture = 4;
static constexpr int frames_per_page = 60;

Viewer::Viewer(const ViewerOptions& options) : options_(options), window_("pliant", options.width, options.height) {
    window_.set_wait(options.frames == 0);
    open(*options.first, options.meshes);
}

void Viewer::open(const scene& which, const demos::SceneOptions& scene_options) {
    auto opened = std::make_unique<Session>(which, scene_options, options_.session); // may throw: the old one stays
    drag_ = DragTool();
    cut_ = SweptCut();
    session_ = std::move(opened);
    session_->take_snapshots(panel_.look);
    panel_.follows = !session_->description().drives.empty();
    panel_.cut_radius = usual_cut_radius(session_->description());
    frame_scene();
    panel_.ball = usual_ball(camera());
    window_.set_title(std::string("pliant: ") + which.name);
    step_debt_ = 0;
}

bool Viewer::attempt(const std::function<void()>& action) {
    try {
        action();
        return true;
    } catch (const demos::Error& error) {
        session_->set_message(error.what());
        return false;
    }
}

// Scenes that the engine cannot run are passed over.
void Viewer::open_neighbour(int step) {
    const scene* present = session_->description().source;
    const scene* const* found = std::find(scene_list, scene_list + scene_count, present);
    int index = static_cast<int>(found - scene_list);
    for (int i = 0; i < scene_count; ++i) {
        index = (index + step + scene_count) % scene_count;
        if (attempt([&] { open(*scene_list[index], {}); })) { return; }
    }
}

void Viewer::change_options(const SessionOptions& options) {
    const SessionOptions before = options_.session;
    options_.session = options;
    const scene* present = session_->description().source;
    const demos::SceneOptions meshes = present == options_.first ? options_.meshes : demos::SceneOptions();
    if (!attempt([&] { open(*present, meshes); })) { options_.session = before; }
}

// --------------------------------------------------------------------------------------------------- camera

static render::View view_of(const Session& session, std::vector<render::Extent>& extents) {
    for (const Run& run : session.runs()) {
        extents.push_back(render::measure_extent(run.snapshot));
    }
    return render::make_view(extents);
}

void Viewer::frame_scene() {
    std::vector<render::Extent> extents;
    const render::View seen = view_of(*session_, extents);
    const Viewport viewport = viewports().front();
    const float aspect = static_cast<float>(viewport.width) / static_cast<float>(viewport.height);
    orbit_.stay_above(render::ground_height(extents));
    orbit_.look_from(render::choose_camera(session_->description(), seen, aspect));
    center_ = seen.soft.center();
}

void Viewer::follow_bodies(pli_vec3 center) {
    if (panel_.follows) { orbit_.shift(pli_vec3_sub(center, center_)); }
    center_ = center;
}

std::vector<Viewer::Viewport> Viewer::viewports() const {
    const int left = panel_width(panel_, window_.width(), window_.scale());
    const int count = session_ == nullptr ? 1 : static_cast<int>(session_->runs().size());
    const int width = std::max((window_.width() - left) / count, 1);
    std::vector<Viewport> all;
    for (int i = 0; i < count; ++i) {
        all.push_back({left + i * width, width, std::max(window_.height(), 1)});
    }
    return all;
}

render::Camera Viewer::camera() const {
    const Viewport viewport = viewports().front();
    return orbit_.camera(static_cast<float>(viewport.width) / static_cast<float>(viewport.height));
}

Ray Viewer::ray_at(float x, float y) const {
    const std::vector<Viewport> all = viewports();
    const Viewport* viewport = &all.front();
    for (const Viewport& each : all) {
        if (x >= static_cast<float>(each.left)) { viewport = &each; }
    }
    const float across = 2.0f * (x - static_cast<float>(viewport->left)) / static_cast<float>(viewport->width) - 1.0f;
    const float up = 1.0f - 2.0f * y / static_cast<float>(viewport->height);
    return ray_through(camera(), across, up);
}

// As thick as ropes must be to be hit without aiming.
float Viewer::grip_radius() const {
    return 6.0f * camera().pixel_size(window_.height());
}

// ---------------------------------------------------------------------------------------------------- events

void Viewer::handle(const Event& event) {
    switch (event.kind) {
    case Event::Kind::key_down:
        keys_.insert(event.key);
        handle_key(event.key);
        break;
    case Event::Kind::key_up:
        keys_.erase(event.key);
        break;
    case Event::Kind::button_down:
        handle_press(event);
        break;
    case Event::Kind::button_up:
        handle_release();
        break;
    case Event::Kind::move:
        handle_move(event);
        break;
    case Event::Kind::wheel:
        orbit_.zoom(event.steps);
        break;
    }
    cursor_x_ = event.x;
    cursor_y_ = event.y;
}

void Viewer::handle_key(Key key) {
    switch (key) {
    case Key::space:
        panel_.is_paused = !panel_.is_paused;
        break;
    case Key::period:
        wants_step_ = true;
        break;
    case Key::comma:
        go_to(session_->frame() - 1);
        break;
    case Key::page_up:
        go_to(session_->frame() - frames_per_page);
        break;
    case Key::page_down:
        go_to(session_->frame() + frames_per_page);
        break;
    case Key::home:
        go_to(0);
        break;
    case Key::end:
        go_to(std::numeric_limits<int>::max());
        break;
    case Key::t:
        panel_.hides_timeline = !panel_.hides_timeline;
        break;
    case Key::r:
        attempt([&] { session_->restart(); });
        break;
    case Key::n:
        open_neighbour(1);
        break;
    case Key::p:
        open_neighbour(-1);
        break;
    case Key::b:
        shoot_ball(*session_, camera(), ray_at(cursor_x_, cursor_y_), panel_.ball);
        session_->take_snapshots(panel_.look);
        break;
    case Key::f:
        frame_scene();
        break;
    case Key::h:
        panel_.is_hidden = !panel_.is_hidden;
        break;
    case Key::w:
        panel_.look.wireframe = !panel_.look.wireframe;
        break;
    case Key::c:
        panel_.look.contacts = !panel_.look.contacts;
        session_->take_snapshots(panel_.look);
        break;
    case Key::escape:
        window_.close();
        break;
    default:
        break;
    }
}

void Viewer::go_to(int frame) {
    handle_release();
    panel_.is_paused = true;
    session_->go_to(frame);
}

void Viewer::handle_press(const Event& event) {
    handle_release();
    const Ray ray = ray_at(event.x, event.y);
    if (event.button == Button::middle) {
        motion_ = Motion::pan;
    } else if (event.button == Button::right) {
        motion_ = event.shift ? Motion::pan : Motion::turn;
    } else if (event.control) {
        cut_ball(*session_, ray, panel_.cut_radius);
        session_->take_snapshots(panel_.look);
    } else if (event.shift) {
        cut_.begin(ray);
    } else if (!drag_.begin(*session_, camera(), ray, grip_radius())) {
        motion_ = Motion::turn;
    }
}

void Viewer::handle_move(const Event& event) {
    const Ray ray = ray_at(event.x, event.y);
    const float right = event.x - cursor_x_, down = event.y - cursor_y_;
    if (drag_.is_active()) { drag_.move(*session_, ray); }
    if (cut_.is_active()) {
        cut_.move(*session_, ray);
        session_->take_snapshots(panel_.look);
    }
    if (motion_ == Motion::turn) { orbit_.turn(right, down); }
    if (motion_ == Motion::pan) { orbit_.pan(right, down, window_.height()); }
}

void Viewer::handle_release() {
    if (drag_.is_active()) { drag_.end(*session_); }
    cut_.end();
    motion_ = Motion::none;
}

// ---------------------------------------------------------------------------------------------------- script

void Viewer::place_cursor(const Place& place, Event& event) const {
    event.x = place.x;
    event.y = place.y;
    if (place.kind == Place::Kind::by) {
        event.x += cursor_x_;
        event.y += cursor_y_;
    } else if (place.kind == Place::Kind::node) {
        const demos::Engine& engine = *session_->runs().front().engine;
        if (place.soft >= engine.soft_count()) {
            throw demos::Error("the scene has no soft body " + std::to_string(place.soft));
        }
        const Viewport viewport = viewports().front();
        float across = 0, up = 0;
        if (!place_of(camera(), engine.node_position(place.soft, place.node), across, up)) {
            throw demos::Error("node " + std::to_string(place.node) + " is behind the camera");
        }
        event.x = static_cast<float>(viewport.left) + 0.5f * (1.0f + across) * static_cast<float>(viewport.width);
        event.y = 0.5f * (1.0f - up) * static_cast<float>(viewport.height);
    }
}

void Viewer::perform(const Command& command) {
    Event event{Event::Kind::move};
    event.shift = command.shift;
    event.control = command.control;
    event.key = command.key;
    event.button = command.button;
    event.steps = command.value;
    event.x = cursor_x_;
    event.y = cursor_y_;
    switch (command.kind) {
    case Command::Kind::press:
        place_cursor(command.place, event);
        handle(event);
        event.kind = Event::Kind::button_down;
        break;
    case Command::Kind::release:
        event.kind = Event::Kind::button_up;
        break;
    case Command::Kind::move:
        place_cursor(command.place, event);
        break;
    case Command::Kind::wheel:
        place_cursor(command.place, event);
        event.kind = Event::Kind::wheel;
        break;
    case Command::Kind::key:
    case Command::Kind::key_down:
        event.kind = Event::Kind::key_down;
        break;
    case Command::Kind::key_up:
        event.kind = Event::Kind::key_up;
        break;
    case Command::Kind::set:
        if (static_cast<size_t>(command.index) >= session_->description().controls.size()) {
            throw demos::Error("the scene has no control " + std::to_string(command.index));
        }
        session_->set_control(static_cast<size_t>(command.index), command.value);
        return;
    case Command::Kind::scene:
        open(demos::choose_scene(command.name), {});
        return;
    case Command::Kind::steps:
        session_->set_keys(keys_);
        for (int i = 0; i < command.index; ++i) {
            session_->step();
        }
        return;
    case Command::Kind::go:
        go_to(command.index);
        return;
    case Command::Kind::report:
        options_.report(*session_, command.place);
        return;
    }
    handle(event);
    if (command.kind == Command::Kind::key) {
        event.kind = Event::Kind::key_up;
        handle(event);
    }
}

void Viewer::run_script() {
    while (next_command_ < options_.script.size() && options_.script[next_command_].frame <= drawn_) {
        const Command& command = options_.script[next_command_++];
        try {
            perform(command);
        } catch (const demos::Error& error) { throw demos::Error(command.source + ": " + error.what()); }
    }
}

// ------------------------------------------------------------------------------------------------------ frames

// With a number of frames each picture is one step; else steps keep up with the clock as well as they can.
void Viewer::advance() {
    int steps = options_.frames > 0 ? 1 : 0;
    if (options_.frames == 0) {
        step_debt_ += last_seconds_ / static_cast<double>(session_->step_seconds());
        steps = std::min(static_cast<int>(step_debt_), most_steps_per_picture);
        step_debt_ = steps == most_steps_per_picture ? 0.0 : step_debt_ - steps;
    }
    if (panel_.is_paused) { steps = wants_step_ ? 1 : 0; }
    if (wants_step_) { panel_.is_paused = true; }
    wants_step_ = false;
    session_->set_keys(keys_);
    for (int i = 0; i < steps; ++i) {
        session_->step();
    }
}

void Viewer::follow(const PanelWishes& wishes) {
    if (wishes.restart) {
        attempt([&] { session_->restart(); });
    }
    if (wishes.step) { wants_step_ = true; }
    if (wishes.look_changed) { session_->take_snapshots(panel_.look); }
    if (wishes.chosen != nullptr) {
        attempt([&] { open(*wishes.chosen, {}); });
    }
    if (wishes.neighbour != 0) { open_neighbour(wishes.neighbour); }
    if (wishes.options.has_value()) { change_options(*wishes.options); }
}

void Viewer::draw() {
    window_.begin_panel();
    const int width = panel_width(panel_, window_.width(), window_.scale());
    const PanelWishes wishes = describe_panel(*session_, panel_, options_.session, width, window_.height());
    TimelineWishes along;
    if (!panel_.is_hidden && !panel_.hides_timeline) {
        along = describe_timeline(*session_, panel_.is_paused, width, window_.width() - width, window_.height());
    }
    const std::vector<Run>& runs = session_->runs();
    const std::vector<Viewport> places = viewports();
    std::vector<render::Extent> extents;
    const render::View seen = view_of(*session_, extents);
    follow_bodies(seen.soft.center());
    canvases_.resize(runs.size());
    for (size_t i = 0; i < runs.size(); ++i) {
        std::unique_ptr<render::Canvas>& canvas = canvases_[i];
        if (canvas == nullptr || canvas->width() != places[i].width || canvas->height() != places[i].height) {
            canvas.reset();
            canvas = std::make_unique<render::Canvas>(places[i].width, places[i].height, 1);
        }
        renderer_.draw(*canvas, runs[i].snapshot, extents[i], seen, camera(), panel_.look);
        canvas->show(places[i].left, 0);
        if (runs.size() > 1) {
            const bool is_pliant = runs[i].engine->kind() == demos::EngineKind::pliant;
            describe_title(is_pliant ? "Pliant" : "Bullet (btSoftBody)", places[i].left, places[i].width);
        }
    }
    window_.draw_panel();
    follow(wishes);
    if (along.frame.has_value()) { go_to(*along.frame); }
    if (along.toggles_pause) { panel_.is_paused = !panel_.is_paused; }
}

void Viewer::run() {
    while (window_.is_open() && (options_.frames == 0 || drawn_ < options_.frames)) {
        const demos::Stopwatch watch;
        for (const Event& event : window_.take_events()) {
            handle(event);
        }
        run_script();
        advance();
        draw();
        ++drawn_;
        if (drawn_ == options_.frames) {
            run_script();
            last_picture_ = render::read_window(window_.width(), window_.height());
        }
        window_.show();
        last_seconds_ = watch.milliseconds() / 1000.0;
        const double rate = 1.0 / std::max(last_seconds_, 1e-6);
        panel_.frames_per_second = drawn_ == 1 ? rate : 0.9 * panel_.frames_per_second + 0.1 * rate;
    }
}

} // namespace viewer
