#ifndef DEMOS_VIEWER_TIMELINE_H
#define DEMOS_VIEWER_TIMELINE_H

// The frames that a scene on Pliant has gone through, to go back to and on from again: its whole state at some of them
// (keyframes), and what the user did in each. What a session calls is virtual: one without a timeline links none.

#include "measure/recording.h"

#include <functional>

namespace viewer {

class Timeline {
public:
    // What the user does between two steps. False: nothing has changed.
    using Input = std::function<bool(demos::Engine&)>;
    static constexpr size_t usual_most_bytes = size_t{128} << 20, usual_frame_bytes = 120000;

    // Of an engine at its start, which outlives this. The engine reads each keyframe as it is made: what Bullet knows
    // of pairs is then the same as when it goes back there. With more than `most_bytes` keyframes become rarer, then
    // the oldest frames are forgotten; two keyframes are kept always. Large ones, which take long to make, are rarer
    // too: at most `frame_bytes` per frame. Throws Error where its state cannot be written.
    explicit Timeline(demos::PliantEngine& engine, size_t most_bytes = usual_most_bytes,
                      size_t frame_bytes = usual_frame_bytes);

    virtual ~Timeline() = default;

    int frame() const { return frame_; } // that the engine is at
    int first() const { return keyframes_.front().keyframe.frame; }
    int last() const { return last_; }
    bool is_at_end() const { return frame_ == last_; }
    size_t bytes() const { return bytes_; }
    // In which the user has done something, in their order.
    std::vector<int> input_frames() const;

    // One frame on, as it was, or a new one after the last. Throws Error, and is then at no other frame.
    virtual void step();
    // Does something in this frame, and keeps it, unless it throws. What came after this frame is no more then.
    virtual void act(Input input);
    // The same for what the next one replaces in the same frame: the cursor moves more often than there are frames.
    virtual void move(Input input);
    // To a frame from first() to last(), with what the user did in it. Throws Error where it cannot.
    virtual void go_to(int frame);

private:
    struct Moment {
        demos::Keyframe keyframe; // before what the user does in this frame
        demos::ScriptState script;
        std::vector<demos::RigidRecord> balls;
        size_t bytes() const;
    };
    struct Entry {
        int frame;
        bool is_move;
        Input input;
    };

    void take(Input input, bool is_move);
    void keep(Input input, bool is_move);
    void cut_off();
    bool is_keyframe_due() const;
    void add_keyframe();
    void make_room();
    void go_back(int frame);
    void restore(const Moment& moment);
    void repeat_inputs();

    demos::PliantEngine& engine_;
    size_t most_bytes_, frame_bytes_;
    size_t bytes_ = 0;
    std::vector<Moment> keyframes_; // never empty
    std::vector<Entry> inputs_;     // by frame
    std::vector<int> read_;         // in which the engine has read its own state, see add_keyframe(); in their order
    int frame_ = 0, last_ = 0;
    int interval_; // frames from a keyframe to the next, at least
};

} // namespace viewer
#endif
