#ifndef DEMOS_CHILD_PROCESS_H
#define DEMOS_CHILD_PROCESS_H

// Work that may hang or crash, in a process of its own.

#include <functional>
#include <string>
#include <vector>

namespace demos {

enum class ChildEnd { answered, timed_out, crashed };

struct ChildAnswer {
    ChildEnd end = ChildEnd::crashed;
    std::string text;   // what the work returned
    int signal = 0;     // that ended it; 0: none
    double seconds = 0; // wall time
};

// Runs the work in a copy of this process, which must have one thread only, and ends it after so many seconds of wall
// time. What the copy prints is lost. Throws Error when no process can be made.
ChildAnswer run_in_child(const std::function<std::string()>& work, double seconds);

struct ChildWork {
    std::function<std::string()> work;
    double seconds = 0; // after which it is ended
};

// The same for several works, `jobs` at a time; `done` gets each answer with its index as it comes.
void run_in_children(const std::vector<ChildWork>& works, int jobs,
                     const std::function<void(size_t, const ChildAnswer&)>& done);

} // namespace demos
#endif
