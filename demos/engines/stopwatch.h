#ifndef DEMOS_STOPWATCH_H
#define DEMOS_STOPWATCH_H

#include <ctime>

namespace demos {

// As long as one lives, stopwatches of its thread show what the thread has of a processor: other programs disturb less.
class ProcessorTime {
public:
    ProcessorTime() { is_on() = true; }
    ~ProcessorTime() { is_on() = false; }
    ProcessorTime(const ProcessorTime&) = delete;
    ProcessorTime& operator=(const ProcessorTime&) = delete;

    static bool& is_on() {
        thread_local bool on = false;
        return on;
    }
};

// Wall time since it was made, or processor time.
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
        clock_gettime(ProcessorTime::is_on() ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &time);
        return time;
    }

    timespec start_ = now();
};

} // namespace demos
#endif
