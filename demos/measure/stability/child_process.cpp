#include "child_process.h"

#include "description/error.h"
#include "engines/stopwatch.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>

namespace demos {

namespace {

[[noreturn]] void child(const std::function<std::string()>& work, int out) {
    const int nothing = open("/dev/null", O_WRONLY);
    dup2(nothing, STDOUT_FILENO);
    dup2(nothing, STDERR_FILENO);
    int status = 1;
    try {
        const std::string text = work();
        size_t done = 0;
        while (done < text.size()) {
            const ssize_t count = write(out, text.data() + done, text.size() - done);
            if (count < 0 && errno != EINTR) { _exit(1); }
            if (count > 0) { done += static_cast<size_t>(count); }
        }
        status = 0;
    } catch (const std::exception&) {} // a crash like any other
    _exit(status);
}

// Reads until the end of the pipe; false when the time is over.
bool read_all(int in, double seconds, std::string& text) {
    const Stopwatch watch;
    for (;;) {
        const double left = 1000.0 * seconds - watch.milliseconds();
        if (left <= 0.0) { return false; }
        pollfd ready{in, POLLIN, 0};
        const int count = poll(&ready, 1, static_cast<int>(std::min(left, 1e6)) + 1);
        if (count == 0 || (count < 0 && errno == EINTR)) { continue; }
        if (count < 0) { return false; }
        char bytes[4096];
        const ssize_t size = read(in, bytes, sizeof bytes);
        if (size < 0 && errno == EINTR) { continue; }
        if (size <= 0) { return true; }
        text.append(bytes, static_cast<size_t>(size));
    }
}

} // namespace

ChildAnswer run_in_child(const std::function<std::string()>& work, double seconds) {
    int ends[2];
    if (pipe(ends) != 0) { throw Error(std::string("no pipe to a process: ") + std::strerror(errno)); }
    std::fflush(nullptr); // else the copy would hold it too
    const pid_t id = fork();
    if (id < 0) {
        const int reason = errno;
        close(ends[0]);
        close(ends[1]);
        throw Error(std::string("no process for the work: ") + std::strerror(reason));
    }
    if (id == 0) {
        close(ends[0]);
        child(work, ends[1]);
    }
    close(ends[1]);
    ChildAnswer answer;
    const bool is_in_time = read_all(ends[0], seconds, answer.text);
    close(ends[0]);
    if (!is_in_time) { kill(id, SIGKILL); }
    int status = 0;
    while (waitpid(id, &status, 0) < 0 && errno == EINTR) {}
    if (!is_in_time) {
        answer.end = ChildEnd::timed_out;
    } else if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
        answer.end = ChildEnd::answered;
    } else if (WIFSIGNALED(status)) {
        answer.signal = WTERMSIG(status);
    }
    return answer;
}

} // namespace demos
