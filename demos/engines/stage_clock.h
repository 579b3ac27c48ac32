#ifndef DEMOS_STAGE_CLOCK_H
#define DEMOS_STAGE_CLOCK_H

#include "stopwatch.h"

#include <map>
#include <utility>
#include <vector>

namespace demos {

// Own times of the parts that Pliant reports, by a stack of those that have begun.
class StageClock {
public:
    static void on_part(const char* stage, const char* feature, bool begins, void* user) {
        static_cast<StageClock*>(user)->turn(stage, feature, begins);
    }

    using Part = std::pair<const char*, const char*>; // stage and feature, which are literals of the core
    // Since the last call, ms; starts anew.
    std::map<Part, double> take() { return std::exchange(times_, {}); }

private:
    void turn(const char* stage, const char* feature, bool begins) {
        if (!open_.empty()) { times_[open_.back()] += watch_.milliseconds(); }
        if (begins) {
            open_.emplace_back(stage, feature);
        } else {
            open_.pop_back();
        }
        watch_ = Stopwatch();
    }

    std::vector<Part> open_;
    std::map<Part, double> times_;
    Stopwatch watch_;
};

} // namespace demos
#endif
