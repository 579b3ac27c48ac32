#include "progress.h"

#include <unistd.h>

#include <cstdio>

namespace app {

using namespace std::chrono_literals;

Progress::Progress(bool is_quiet)
    : is_terminal_(isatty(STDERR_FILENO) == 1), is_quiet_(is_quiet), last_(Clock::now()) {}

Progress::~Progress() {
    clear();
}

void Progress::start(const std::string& what) {
    what_ = what;
}

void Progress::show(int done, int total, const char* unit) {
    const auto interval = is_terminal_ ? Clock::duration(100ms) : Clock::duration(3s);
    const Clock::time_point now = Clock::now();
    if (now - last_ < interval || (is_quiet_ && !is_terminal_)) { return; }
    last_ = now;
    std::fprintf(stderr, "%s%s: %s %d of %d%s", is_terminal_ ? "\r\033[K" : "", what_.c_str(), unit, done, total,
                 is_terminal_ ? "" : "\n");
    std::fflush(stderr);
    is_line_open_ = is_terminal_;
}

void Progress::clear() {
    if (is_line_open_) { std::fputs("\r\033[K", stderr); }
    is_line_open_ = false;
}

} // namespace app
