#ifndef DEMOS_SPAN_CLOCK_H
#define DEMOS_SPAN_CLOCK_H

// What threads without number could save of a step.

#include "engines/stopwatch.h"
#include "predicted_threads.h"

#include <pliant/base.h>

#include <algorithm>

namespace demos {

// A hook that runs the parts of a range one after the other and times each. With as many threads as parts a range would
// take as long as its longest part; with fewer, each thread takes the next part when it has done one.
class SpanClock {
public:
    // ms since the last call that so many threads would save, and threads without number, of the time without the
    // clock's own.
    struct Savings {
        std::array<double, predicted_threads.size()> of_threads{};
        double of_all = 0, own = 0;
    };

    // A pli_parallel_for_fn, `user` is the clock.
    static void parallel_for(pli_range_fn* range, void* task, int count, int grain, void* user) {
        SpanClock& clock = *static_cast<SpanClock*>(user);
        const int size = std::max(grain, 1);
        double all = 0, longest = 0;
        const Stopwatch whole;
        std::array<std::array<double, predicted_threads.back()>, predicted_threads.size()> loads{};
        for (int begin = 0; begin < count; begin += std::min(size, count - begin)) {
            const Stopwatch watch;
            range(begin, begin + std::min(size, count - begin), task);
            const double time = std::max(watch.milliseconds() - clock.empty_, 0.0);
            all += time;
            longest = std::max(longest, time);
            for (size_t i = 0; i < loads.size(); ++i) {
                *std::min_element(loads[i].begin(), loads[i].begin() + predicted_threads[i]) += time;
            }
        }
        clock.savings_.own += whole.milliseconds() - all;
        clock.savings_.of_all += all - longest;
        for (size_t i = 0; i < loads.size(); ++i) {
            clock.savings_.of_threads[i] += all - *std::max_element(loads[i].begin(), loads[i].end());
        }
    }

    Savings take() {
        const Savings savings = savings_;
        savings_ = {};
        return savings;
    }

private:
    static double measure_empty() {
        double least = Stopwatch().milliseconds();
        for (int i = 0; i < 1000; ++i) {
            least = std::min(least, Stopwatch().milliseconds());
        }
        return least;
    }

    const double empty_ = measure_empty();
    Savings savings_;
};

} // namespace demos
#endif
