#ifndef DEMOS_SPAN_CLOCK_H
#define DEMOS_SPAN_CLOCK_H

// What threads without number could save of a step.

#include "engines/stopwatch.h"

#include <pliant/base.h>

#include <algorithm>

namespace demos {

// A hook that runs the parts of a range one after the other and times each. With as many threads as parts a range would
// take as long as its longest part.
class SpanClock {
public:
    // A pli_parallel_for_fn, `user` is the clock.
    static void parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user) {
        SpanClock& clock = *static_cast<SpanClock*>(user);
        const int size = std::max(grain, 1);
        double all = 0, longest = 0;
        for (int begin = 0; begin < count; begin += std::min(size, count - begin)) {
            const Stopwatch watch;
            range(begin, begin + std::min(size, count - begin), task);
            const double time = watch.milliseconds();
            all += time;
            longest = std::max(longest, time);
        }
        clock.saved_ += all - longest;
    }

    // ms, since the last call.
    double take() {
        const double saved = saved_;
        saved_ = 0;
        return saved;
    }

private:
    double saved_ = 0;
};

} // namespace demos
#endif
