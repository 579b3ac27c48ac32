#ifndef DEMOS_VIEWER_SESSION_H
#define DEMOS_VIEWER_SESSION_H

// A scene that runs on one engine or on two beside each other, and what goes wrong with it.

#include "input.h"
#include "measure/measure.h"
#include "render/snapshot.h"
#include "timeline.h"

#include <functional>
#include <set>

namespace viewer {

enum class Engines { pliant, bullet, both };

struct SessionOptions {
    Engines engines = Engines::pliant;
    demos::EngineOptions engine; // beside Pliant btSoftBody keeps to its own solver
    // Makes what goes back in time, where Pliant runs alone. Null: nothing does, and nothing of it is linked.
    std::unique_ptr<Timeline> (*make_timeline)(demos::PliantEngine& engine) = nullptr;
};

// One engine with its figures.
struct Run {
    std::unique_ptr<demos::Engine> engine;
    demos::SolverRun solver;
    render::Snapshot snapshot; // the last state that was finite
    demos::Measures measures;
    double ms_per_step = 0; // smoothed
};

class Session {
public:
    // Throws demos::Error when no engine can run the scene.
    Session(const scene& which, const demos::SceneOptions& scene_options, const SessionOptions& options);

    const demos::Description& description() const { return *description_; }
    const std::vector<Run>& runs() const { return runs_; }
    int frame() const { return frame_; }
    float step_seconds() const { return options_.engine.step_seconds; }
    // The last thing that went wrong, empty: nothing yet.
    const std::string& message() const { return message_; }
    void set_message(const std::string& message) { message_ = message; }

    void restart();
    // One frame on; after a step back through those that have been, as they were.
    void step();
    // Null: there is none, since btSoftBody cannot go back.
    const Timeline* timeline() const { return timeline_.get(); }
    // To the frame of the timeline that is nearest to this one.
    void go_to(int frame);
    // What is drawn of contacts and clusters changes with the look, without a step.
    void take_snapshots(const render::Look& look);

    // Asks the engine of each run. Failures become the message, the others go on.
    void for_each(const std::function<void(demos::Engine&, size_t run)>& action);
    // Changes something in the engine of each run, and keeps it for the timeline, with all that it has captured. False:
    // nothing has changed. Failures as above.
    using Action = std::function<bool(demos::Engine&, size_t run)>;
    void act(const Action& action);
    // The same for what the next such action replaces.
    void move(const Action& action);

    float control(size_t index) const;
    void set_control(size_t index, float value);
    // Keys that are down move controls with the next steps.
    void set_keys(const std::set<Key>& keys) { keys_ = keys; }

private:
    void take(const Action& action, bool is_move);
    void move_controls();

    std::unique_ptr<demos::Description> description_;
    SessionOptions options_;
    render::Look look_;
    std::vector<Run> runs_;
    std::unique_ptr<Timeline> timeline_; // of the engine of the only run
    std::set<Key> keys_;
    std::vector<bool> moved_by_keys_; // controls that spring back when the keys are let go
    std::string message_;
    int frame_ = 0;
    bool is_over_ = false; // a run has stopped for good
};

} // namespace viewer
#endif
