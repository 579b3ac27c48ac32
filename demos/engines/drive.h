#ifndef DEMOS_DRIVE_H
#define DEMOS_DRIVE_H

// What a scene's script, or the user, drives and steers, the same for both engines.

#include "description/description.h"

#include <algorithm>
#include <cmath>

namespace demos {

// Frames of a scene's script, whatever the length of a step is. A frame begins before the first step that starts when
// it has passed.
class ScriptClock {
public:
    explicit ScriptClock(float step_seconds) : step_seconds_(step_seconds) {}

    // To be called before each step.
    void advance() {
        before_ = now_;
        // A step of exactly a frame must not depend on rounding.
        const double frames = static_cast<double>(steps_) * static_cast<double>(step_seconds_ / frame_seconds);
        now_ = static_cast<int>(std::floor(frames + 1e-3));
        ++steps_;
    }
    int frame() const { return now_; }
    float step_seconds() const { return step_seconds_; }
    // At the end of the step, s.
    double seconds() const { return static_cast<double>(steps_) * static_cast<double>(step_seconds_); }
    // Whether this step is the first one of the frame.
    bool begins(int frame) const { return before_ < frame && frame <= now_; }

private:
    float step_seconds_;
    long steps_ = 0;
    int before_ = -1, now_ = -1;
};

class Drive {
public:
    explicit Drive(const std::vector<DriveRecord>& script) : script_(&script) {}

    // To be called before the step that follows `frame` frames.
    void advance(int frame) {
        while (next_ < script_->size() && (*script_)[next_].frame <= frame) {
            const DriveRecord& now = (*script_)[next_++];
            if (!speed_taken_) {
                present_.speed = now.speed;
                present_.largest_change = now.largest_change;
            }
            if (!angle_taken_) { present_.angle = now.angle; }
        }
    }

    // What is set by hand goes before what the script says from then on.
    void take_speed(float speed, float largest_change) {
        present_.speed = speed;
        present_.largest_change = largest_change;
        speed_taken_ = true;
    }
    void take_angle(float angle) {
        present_.angle = angle;
        angle_taken_ = true;
    }

    // Relative speed that a driven joint goes for, rad/s.
    float speed(float present) const {
        const float change = present_.speed - present;
        return present + std::min(present_.largest_change, std::max(-present_.largest_change, change));
    }

    // The axis of a steered joint in the frame of its first end, which is turned by nothing at the start.
    pli_vec3 axis(const JointRecord& joint) const {
        return pli_vec3_add(pli_vec3_scale(joint.axis, std::cos(present_.angle)),
                            pli_vec3_scale(joint.side, std::sin(present_.angle)));
    }

private:
    const std::vector<DriveRecord>* script_;
    size_t next_ = 0;
    bool speed_taken_ = false, angle_taken_ = false;
    DriveRecord present_{};
};

inline bool is_steered(const JointRecord& joint) {
    return pli_vec3_length_squared(joint.side) > 0.0f;
}

} // namespace demos
#endif
