#ifndef DEMOS_SOFT_CLOCK_H
#define DEMOS_SOFT_CLOCK_H

// What soft bodies take of a step, taken in the same way in both engines: prediction with the bounds that the broad
// phase asks for, the pairs that the dispatcher hands to soft bodies, and everything after the rigid bodies' own step.

#include "bullet_memory.h"
#include "engine.h"
#include "heap_count.h"
#include "stopwatch.h"

#include <algorithm>

namespace demos {

class SoftClock {
public:
    // From its making to its end time and memory, of Bullet's allocator and of C++, count for a part. Windows do not
    // nest.
    class Window {
    public:
        Window(SoftClock& clock, SoftPart part) : clock_(clock.opened()), part_(part) {}
        ~Window() {
            clock_.times_.parts[static_cast<size_t>(part_)] += std::max(watch_.milliseconds() - clock_.own_, 0.0);
            clock_.count_memory(-1);
        }
        Window(const Window&) = delete;
        Window& operator=(const Window&) = delete;

    private:
        SoftClock& clock_;
        SoftPart part_;
        Stopwatch watch_;
    };

    // Inside a window: memory does not count, being that of the rigid world.
    class Pause {
    public:
        explicit Pause(SoftClock& clock) : clock_(clock), counts_(clock.windows_ > 0) {
            if (counts_) { clock_.count_memory(-1); }
        }
        ~Pause() {
            if (counts_) { clock_.count_memory(1); }
        }
        Pause(const Pause&) = delete;
        Pause& operator=(const Pause&) = delete;

    private:
        SoftClock& clock_;
        bool counts_;
    };

    void start_step() { times_ = {}; }
    const StepTimes& times() const { return times_; }
    // Inside the windows; of Bullet only while its memory is counted.
    uint64_t allocations() const { return allocations_; }
    // Of Bullet.
    int64_t live_bytes() const { return live_bytes_; }

private:
    // What a window with nothing in it takes, ms, the least of many: scenes of small bodies open hundreds in a step.
    static double measure_own() {
        double least = Stopwatch().milliseconds();
        for (int i = 0; i < 1000; ++i) {
            least = std::min(least, Stopwatch().milliseconds());
        }
        return least;
    }

    SoftClock& opened() {
        count_memory(1);
        return *this;
    }
    // Counts are differences: taken off at the start, added at the end.
    void count_memory(int windows) {
        const BulletMemory memory = bullet_memory();
        const uint64_t allocations = memory.allocations + heap_allocations();
        windows_ += windows;
        allocations_ += windows > 0 ? 0 - allocations : allocations;
        live_bytes_ += windows > 0 ? -memory.live_bytes : memory.live_bytes;
    }

    const double own_ = measure_own();
    StepTimes times_;
    int windows_ = 0;
    uint64_t allocations_ = 0;
    int64_t live_bytes_ = 0;
};

} // namespace demos
#endif
