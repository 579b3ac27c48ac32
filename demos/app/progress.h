#ifndef DEMOS_APP_PROGRESS_H
#define DEMOS_APP_PROGRESS_H

// How far long work has come, on stderr: one line that is overwritten on a terminal, otherwise a line every few
// seconds.

#include <chrono>
#include <string>

namespace app {

class Progress {
public:
    // `is_quiet`: write only when stderr is a terminal.
    explicit Progress(bool is_quiet);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    // What is being done from now on, for example "Bunny on pliant".
    void start(const std::string& what);
    void show(int done, int total, const char* unit = "frame");
    // Removes the line from the terminal, so that other text can follow.
    void clear();

private:
    using Clock = std::chrono::steady_clock;

    bool is_terminal_, is_quiet_, is_line_open_ = false;
    std::string what_;
    Clock::time_point last_;
};

} // namespace app
#endif
