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

// A copy of this process at work, and what it has written so far.
struct Child {
    size_t index = 0;
    pid_t id = 0;
    int in = -1;
    double limit = 0; // ms
    Stopwatch watch{};
    std::string text{};

    double left() const { return limit - watch.milliseconds(); }
};

Child start_child(const ChildWork& work, size_t index) {
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
        child(work.work, ends[1]);
    }
    close(ends[1]);
    return {index, id, ends[0], 1000.0 * work.seconds};
}

// What there is to read; false at the end of the pipe.
bool read_some(Child& from) {
    char bytes[4096];
    const ssize_t size = read(from.in, bytes, sizeof bytes);
    if (size < 0 && errno == EINTR) { return true; }
    if (size <= 0) { return false; }
    from.text.append(bytes, static_cast<size_t>(size));
    return true;
}

ChildAnswer end_child(Child& ended, bool is_in_time) {
    close(ended.in);
    if (!is_in_time) { kill(ended.id, SIGKILL); }
    int status = 0;
    while (waitpid(ended.id, &status, 0) < 0 && errno == EINTR) {}
    ChildAnswer answer;
    answer.text = std::move(ended.text);
    answer.seconds = 0.001 * ended.watch.milliseconds();
    if (!is_in_time) {
        answer.end = ChildEnd::timed_out;
    } else if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
        answer.end = ChildEnd::answered;
    } else if (WIFSIGNALED(status)) {
        answer.signal = WTERMSIG(status);
    }
    return answer;
}

// Until one of them has written something, or the time of one is over.
std::vector<pollfd> wait_for(const std::vector<Child>& children) {
    std::vector<pollfd> ready;
    double left = 1e6;
    for (const Child& each : children) {
        ready.push_back({each.in, POLLIN, 0});
        left = std::min(left, each.left());
    }
    if (poll(ready.data(), static_cast<nfds_t>(ready.size()), static_cast<int>(std::max(left, 0.0)) + 1) < 0) {
        for (pollfd& each : ready) {
            each.revents = 0; // a signal came
        }
    }
    return ready;
}

} // namespace

void run_in_children(const std::vector<ChildWork>& works, int jobs,
                     const std::function<void(size_t, const ChildAnswer&)>& done) {
    std::vector<Child> running;
    for (size_t next = 0; next < works.size() || !running.empty();) {
        while (next < works.size() && running.size() < static_cast<size_t>(std::max(jobs, 1))) {
            running.push_back(start_child(works[next], next));
            ++next;
        }
        const std::vector<pollfd> ready = wait_for(running);
        std::vector<Child> still_running;
        for (size_t i = 0; i < running.size(); ++i) {
            Child& each = running[i];
            const bool has_ended = ready[i].revents != 0 && !read_some(each);
            if (has_ended || each.left() <= 0.0) {
                done(each.index, end_child(each, has_ended));
            } else {
                still_running.push_back(std::move(each));
            }
        }
        running = std::move(still_running);
    }
}

ChildAnswer run_in_child(const std::function<std::string()>& work, double seconds) {
    ChildAnswer answer;
    run_in_children({{work, seconds}}, 1, [&](size_t, const ChildAnswer& given) { answer = given; });
    return answer;
}

} // namespace demos
