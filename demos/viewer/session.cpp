#include "session.h"

#include <algorithm>

namespace viewer {

Session::Session(const scene& which, const demos::SceneOptions& scene_options, const SessionOptions& options)
    : description_(demos::Description::build(which, scene_options)), options_(options) {
    restart();
}

void Session::restart() {
    std::vector<demos::EngineKind> kinds;
    if (options_.engines != Engines::bullet) { kinds.push_back(demos::EngineKind::pliant); }
    if (options_.engines != Engines::pliant) { kinds.push_back(demos::EngineKind::bullet); }
    std::vector<Run> started;
    std::string problem;
    for (const demos::EngineKind kind : kinds) {
        demos::EngineOptions settings = options_.engine;
        const bool is_beside = options_.engines == Engines::both && kind == demos::EngineKind::bullet;
        const bool has_other_solver =
            settings.solver.kind.value_or(demos::SolverKind::position_based) != demos::SolverKind::position_based;
        if (is_beside && has_other_solver) { settings.solver = {}; }
        // So that it goes the same way again.
        settings.ordered_pairs = kind == demos::EngineKind::pliant && options_.make_timeline != nullptr;
        try {
            Run run;
            run.solver = demos::choose_solver(*description_, kind, settings);
            run.engine = demos::make_engine(kind, *description_, settings);
            run.snapshot = render::take_snapshot(*run.engine, look_);
            run.measures = demos::measure(*run.engine);
            started.push_back(std::move(run));
        } catch (const demos::Error& error) {
            problem = error.what(); // the other one may do
        }
    }
    if (started.empty()) { throw demos::Error(problem); }
    timeline_.reset();
    runs_ = std::move(started);
    message_ = problem;
    auto* engine = dynamic_cast<demos::PliantEngine*>(runs_.front().engine.get());
    if (options_.make_timeline != nullptr && runs_.size() == 1 && engine != nullptr) {
        try {
            timeline_ = options_.make_timeline(*engine);
        } catch (const demos::Error& error) { message_ = std::string("no timeline: ") + error.what(); }
    }
    frame_ = 0;
    is_over_ = false;
    moved_by_keys_.assign(description_->controls.size(), false);
}

void Session::for_each(const std::function<void(demos::Engine&, size_t)>& action) {
    for (size_t i = 0; i < runs_.size(); ++i) {
        try {
            action(*runs_[i].engine, i);
        } catch (const demos::Error& error) { message_ = error.what(); }
    }
}

void Session::act(const Action& action) {
    take(action, false);
}

void Session::move(const Action& action) {
    take(action, true);
}

void Session::take(const Action& action, bool is_move) {
    if (timeline_ == nullptr) {
        for_each([&](demos::Engine& engine, size_t run) { (void)action(engine, run); });
        return;
    }
    try {
        const Timeline::Input input = [action](demos::Engine& engine) { return action(engine, 0); };
        is_move ? timeline_->move(input) : timeline_->act(input);
    } catch (const demos::Error& error) { message_ = error.what(); }
}

void Session::go_to(int frame) {
    if (timeline_ == nullptr) { return; }
    try {
        timeline_->go_to(std::clamp(frame, timeline_->first(), timeline_->last()));
        is_over_ = false;
        message_.clear();
    } catch (const demos::Error& error) { message_ = error.what(); }
    frame_ = timeline_->frame();
    take_snapshots(look_);
}

void Session::step() {
    if (is_over_) { return; }
    move_controls();
    ++frame_;
    for (Run& run : runs_) {
        try {
            timeline_ != nullptr ? timeline_->step() : run.engine->step();
            const double milliseconds = run.engine->step_milliseconds();
            run.ms_per_step = frame_ == 1 ? milliseconds : 0.95 * run.ms_per_step + 0.05 * milliseconds;
            run.measures = demos::measure(*run.engine);
            if (!run.measures.finite) { throw demos::Error("the state is no longer finite"); }
        } catch (const demos::Error& error) {
            is_over_ = true;
            message_ = run.engine->name() + " stopped after frame " + std::to_string(frame_) + ": " + error.what();
        }
    }
    if (!is_over_) { take_snapshots(look_); }
}

void Session::take_snapshots(const render::Look& look) {
    look_ = look;
    if (is_over_) { return; }
    for (Run& run : runs_) {
        run.snapshot = render::take_snapshot(*run.engine, look);
        run.measures = demos::measure(*run.engine);
    }
}

// -------------------------------------------------------------------------------------------------- controls

float Session::control(size_t index) const {
    return runs_.front().engine->control(static_cast<int>(index));
}

void Session::set_control(size_t index, float value) {
    act([index, value](demos::Engine& engine, size_t) {
        engine.set_control(static_cast<int>(index), value);
        return true;
    });
}

static float towards(float value, float goal, float change) {
    return value < goal ? std::min(value + change, goal) : std::max(value - change, goal);
}

// What springs back takes half a second from end to end, the rest three. In frames that have been it does so by itself.
void Session::move_controls() {
    const bool is_new = timeline_ == nullptr || timeline_->is_at_end();
    for (size_t i = 0; i < description_->controls.size(); ++i) {
        const scene_control& def = description_->controls[i].def;
        if (def.keys == SCENE_KEYS_NONE) { continue; }
        const bool is_upright = def.keys == SCENE_KEYS_UP_DOWN;
        const bool to_high = keys_.count(is_upright ? Key::up : Key::right) != 0;
        const bool to_low = keys_.count(is_upright ? Key::down : Key::left) != 0;
        const float value = control(i);
        const float seconds = def.springs_back ? 0.5f : 3.0f;
        const float change = (def.high - def.low) * step_seconds() / seconds;
        float wanted = value;
        if (to_high != to_low) {
            wanted = towards(value, to_high ? def.high : def.low, change);
            moved_by_keys_[i] = true;
        } else if (is_new && def.springs_back && moved_by_keys_[i]) {
            wanted = towards(value, def.initial, change);
        }
        if (wanted < value || wanted > value) { set_control(i, wanted); }
    }
}

} // namespace viewer
