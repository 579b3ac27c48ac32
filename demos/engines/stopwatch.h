#ifndef DEMOS_STOPWATCH_H
#define DEMOS_STOPWATCH_H

#include <ctime>

namespace demos {

// Wall time since it was made: a clock of processor time is a call of the system, longer than many a part of a step.
class Stopwatch {
public:
    double milliseconds() const {
        const timespec end = now();
        return 1e3 * static_cast<double>(end.tv_sec - start_.tv_sec) +
               1e-6 * static_cast<double>(end.tv_nsec - start_.tv_nsec);
    }

private:
    static timespec now() {
        timespec time = {};
        clock_gettime(CLOCK_MONOTONIC, &time);
        return time;
    }

    timespec start_ = now();
};

} // namespace demos
#endif
