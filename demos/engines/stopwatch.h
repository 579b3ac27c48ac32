#ifndef DEMOS_STOPWATCH_H
#define DEMOS_STOPWATCH_H

#include <chrono>

namespace demos {

// Wall time since it was made.
class Stopwatch {
public:
    double milliseconds() const {
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace demos
#endif
