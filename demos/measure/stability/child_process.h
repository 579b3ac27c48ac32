#ifndef DEMOS_CHILD_PROCESS_H
#define DEMOS_CHILD_PROCESS_H

// Work that may hang or crash, in a process of its own.

#include <functional>
#include <string>

namespace demos {

enum class ChildEnd { answered, timed_out, crashed };

struct ChildAnswer {
    ChildEnd end = ChildEnd::crashed;
    std::string text; // what the work returned
    int signal = 0;   // that ended it; 0: none
};

// Runs the work in a copy of this process, which must have one thread only, and ends it after so many seconds of wall
// time. What the copy prints is lost. Throws Error when no process can be made.
ChildAnswer run_in_child(const std::function<std::string()>& work, double seconds);

} // namespace demos
#endif
