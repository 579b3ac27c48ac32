#include "virtual_screen.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fcntl.h>

namespace cli {

VirtualScreen::VirtualScreen() {
    int number[2]; // Xvfb chooses a free display and writes its number
    if (pipe(number) != 0) { return; }
    process_ = fork();
    if (process_ == 0) {
        close(number[0]);
        const int nothing = open("/dev/null", O_RDWR);
        dup2(nothing, STDOUT_FILENO);
        dup2(nothing, STDERR_FILENO);
        const std::string descriptor = std::to_string(number[1]);
        execlp("Xvfb", "Xvfb", "-displayfd", descriptor.c_str(), "-screen", "0", "1280x720x24", "-nolisten", "tcp",
               static_cast<char*>(nullptr));
        _exit(127);
    }
    close(number[1]);
    char digit = 0;
    while (process_ > 0 && read(number[0], &digit, 1) == 1 && digit != '\n') {
        display_ += digit;
    }
    close(number[0]);
    if (!display_.empty()) { display_ = ":" + display_; }
}

VirtualScreen::~VirtualScreen() {
    if (process_ <= 0) { return; }
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
}

} // namespace cli
