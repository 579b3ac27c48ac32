#include "machine_facts.h"

#include <LinearMath/btScalar.h>
#include <pliant/pliant.h>

#include <sys/utsname.h>

#include <ctime>
#include <fstream>
#include <thread>

namespace report {

static std::string processor_name() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);) {
        const size_t colon = line.find(": ");
        if (line.rfind("model name", 0) == 0 && colon != std::string::npos) { return line.substr(colon + 2); }
    }
    return "unknown";
}

static std::string system_name() {
    utsname names{};
    if (uname(&names) != 0) { return "unknown"; }
    return std::string(names.sysname) + " " + names.release + ", " + names.machine;
}

static std::string compiler_name() {
#ifdef __clang__
    return "Clang " __clang_version__;
#else
    return "GCC " __VERSION__;
#endif
}

static std::string now() {
    const std::time_t time = std::time(nullptr);
    char text[40] = "unknown";
    std::tm parts{};
    if (gmtime_r(&time, &parts) != nullptr) { std::strftime(text, sizeof text, "%Y-%m-%d %H:%M UTC", &parts); }
    return text;
}

std::vector<std::pair<std::string, std::string>> machine_facts() {
    const int bullet = BT_BULLET_VERSION;
    return {{"Processor", processor_name() + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads"},
            {"System", system_name()},
            {"Compiler", compiler_name()},
            {"Build", APP_BUILD_TYPE},
            {"Pliant", APP_VERSION},
            {"Bullet", std::to_string(bullet / 100) + "." + std::to_string(bullet % 100)},
            {"Made", now()}};
}

} // namespace report
