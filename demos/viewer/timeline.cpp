#include "timeline.h"

#include "description/error.h"

#include <algorithm>

namespace viewer {

static constexpr int first_interval = 30, most_interval = 240; // frames; as many are repeated at most to go back
static constexpr size_t input_bytes = 128;                     // of an input, about

size_t Timeline::Moment::bytes() const {
    return sizeof *this + keyframe.state.size() + balls.size() * sizeof(demos::RigidRecord);
}

Timeline::Timeline(demos::PliantEngine& engine, size_t most_bytes, size_t frame_bytes)
    : engine_(engine), most_bytes_(most_bytes), frame_bytes_(frame_bytes), interval_(first_interval) {
    add_keyframe();
}

std::vector<int> Timeline::input_frames() const {
    std::vector<int> frames;
    for (const Entry& entry : inputs_) {
        if (frames.empty() || frames.back() != entry.frame) { frames.push_back(entry.frame); }
    }
    return frames;
}

// ---------------------------------------------------------------------------------------------------------- going on

void Timeline::step() {
    engine_.step();
    if (frame_ < last_) {
        ++frame_;
        if (std::binary_search(read_.begin(), read_.end(), frame_)) {
            demos::read_state(engine_, demos::write_state(engine_));
        }
        repeat_inputs();
        return;
    }
    last_ = ++frame_;
    // What the user holds is not in a keyframe: it is grabbed again from the one before.
    if (!is_keyframe_due() || engine_.is_holding()) { return; }
    try {
        add_keyframe();
    } catch (const demos::Error&) {} // a state that no file may have, as one that is not finite: repeated from before
}

void Timeline::act(Input input) {
    take(std::move(input), false);
}

void Timeline::move(Input input) {
    take(std::move(input), true);
}

void Timeline::take(Input input, bool is_move) {
    if (frame_ < last_ && engine_.is_holding()) { // whoever has held it lets go later, in frames that are no more
        cut_off();
        engine_.let_go();
        keep([](demos::Engine& engine) { return engine.let_go(), true; }, false);
    }
    if (!input(engine_)) { return; }
    cut_off();
    keep(std::move(input), is_move);
}

void Timeline::keep(Input input, bool is_move) {
    if (is_move && !inputs_.empty() && inputs_.back().is_move && inputs_.back().frame == frame_) {
        inputs_.back().input = std::move(input);
        return;
    }
    inputs_.push_back({frame_, is_move, std::move(input)});
    bytes_ += input_bytes;
}

// -------------------------------------------------------------------------------------------------------- what is kept

void Timeline::cut_off() {
    while (!inputs_.empty() && inputs_.back().frame > frame_) {
        inputs_.pop_back();
        bytes_ -= input_bytes;
    }
    while (keyframes_.back().keyframe.frame > frame_) {
        bytes_ -= keyframes_.back().bytes();
        keyframes_.pop_back();
    }
    while (read_.back() > frame_) {
        read_.pop_back();
    }
    last_ = frame_;
}

// By its size and not by the clock: the engine reads each keyframe, and goes the same way on any machine.
bool Timeline::is_keyframe_due() const {
    const demos::Keyframe& last = keyframes_.back().keyframe;
    const auto by_size = std::min(last.state.size() / frame_bytes_, size_t{most_interval});
    return frame_ - last.frame >= std::max(interval_, static_cast<int>(by_size));
}

// The engine reads what it has written: what Bullet knows of pairs is then the same as when it goes back here. That
// goes for all time, also when the keyframe has been taken out.
void Timeline::add_keyframe() {
    Moment moment{{frame_, demos::write_state(engine_)}, engine_.script_state(), engine_.balls()};
    demos::read_state(engine_, moment.keyframe.state);
    keyframes_.push_back(std::move(moment));
    read_.push_back(frame_);
    bytes_ += keyframes_.back().bytes();
    make_room();
}

void Timeline::make_room() {
    while (bytes_ > most_bytes_ && interval_ < most_interval && keyframes_.size() > 2) {
        interval_ *= 2;
        for (size_t i = 1; i + 1 < keyframes_.size(); ++i) { // every second one, but never the last
            bytes_ -= keyframes_[i].bytes();
            keyframes_.erase(keyframes_.begin() + static_cast<std::ptrdiff_t>(i));
        }
    }
    while (bytes_ > most_bytes_ && keyframes_.size() > 2) {
        bytes_ -= keyframes_.front().bytes();
        keyframes_.erase(keyframes_.begin());
        const auto kept =
            std::find_if(inputs_.begin(), inputs_.end(), [&](const Entry& entry) { return entry.frame >= first(); });
        bytes_ -= input_bytes * static_cast<size_t>(kept - inputs_.begin());
        inputs_.erase(inputs_.begin(), kept);
    }
}

// --------------------------------------------------------------------------------------------------------- going back

void Timeline::go_to(int frame) {
    if (frame < first() || frame > last_) {
        throw demos::Error("frame " + std::to_string(frame) + " is not on the timeline, which has " +
                           std::to_string(first()) + " to " + std::to_string(last_));
    }
    const auto is_between = [&](const Moment& moment) {
        return moment.keyframe.frame > frame_ && moment.keyframe.frame < frame;
    };
    if (frame <= frame_ || std::any_of(keyframes_.begin(), keyframes_.end(), is_between)) { go_back(frame); }
    while (frame_ < frame) {
        step();
    }
}

// To a keyframe before the frame, so that the last step is made and its contacts can be seen.
void Timeline::go_back(int frame) {
    size_t place = 0;
    while (place + 1 < keyframes_.size() && keyframes_[place + 1].keyframe.frame < frame) {
        ++place;
    }
    restore(keyframes_[place]);
    repeat_inputs();
}

void Timeline::restore(const Moment& moment) {
    engine_.let_go();
    engine_.set_balls(moment.balls);
    demos::read_state(engine_, moment.keyframe.state);
    engine_.set_script_state(moment.script);
    frame_ = moment.keyframe.frame;
}

void Timeline::repeat_inputs() {
    const auto from =
        std::find_if(inputs_.begin(), inputs_.end(), [&](const Entry& entry) { return entry.frame >= frame_; });
    for (auto entry = from; entry != inputs_.end() && entry->frame == frame_; ++entry) {
        (void)entry->input(engine_);
    }
}

} // namespace viewer
