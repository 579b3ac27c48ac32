#ifndef DEMOS_SOFT_CLOCK_H
#define DEMOS_SOFT_CLOCK_H

// What soft bodies take of a step, taken in the same way in both engines: prediction with the bounds that the broad
// phase asks for, the pairs that the dispatcher hands to soft bodies, and everything after the rigid bodies' own step.

#include "bullet_memory.h"
#include "engine.h"
#include "stopwatch.h"

#include <algorithm>

namespace demos {

class SoftClock {
public:
    // From its making to its end time and Bullet's memory count for a part. Windows do not nest.
    class Window {
    public:
        Window(SoftClock& clock, SoftPart part) : clock_(clock), part_(part), memory_(bullet_memory()) {}
        ~Window() {
            clock_.times_.parts[static_cast<size_t>(part_)] += std::max(watch_.milliseconds() - clock_.own_, 0.0);
            const BulletMemory after = bullet_memory();
            clock_.allocations_ += after.allocations - memory_.allocations;
            clock_.live_bytes_ += after.live_bytes - memory_.live_bytes;
        }
        Window(const Window&) = delete;
        Window& operator=(const Window&) = delete;

    private:
        SoftClock& clock_;
        SoftPart part_;
        BulletMemory memory_;
        Stopwatch watch_;
    };

    void start_step() { times_ = {}; }
    const StepTimes& times() const { return times_; }
    // Of Bullet's allocator inside the windows; 0 while its memory is not counted.
    uint64_t allocations() const { return allocations_; }
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

    const double own_ = measure_own();
    StepTimes times_;
    uint64_t allocations_ = 0;
    int64_t live_bytes_ = 0;
};

} // namespace demos
#endif
