#include "program_run.h"

#include "check.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

namespace cli {

namespace fs = std::filesystem;

// Removed with all that is in it when the test program ends.
struct Folder {
    fs::path path;
    Folder() {
        std::string name = (fs::temp_directory_path() / "pliant-cli-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr) { std::abort(); }
        path = name;
    }
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
};

static const fs::path& folder() {
    static const Folder the_folder;
    return the_folder.path;
}

std::string scratch(const std::string& name) {
    fs::create_directories(folder() / "work");
    return (folder() / "work" / name).string();
}

bool exists(const std::string& path) {
    return fs::exists(path);
}

std::string read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void write_file(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

std::string scratch_files() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(scratch(""))) {
        names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    std::string all;
    for (const std::string& name : names) {
        all += name + " ";
    }
    return all;
}

Result run(const std::string& arguments, const std::string& environment) {
    const std::string out = (folder() / "out").string(), err = (folder() / "err").string();
    // What the arguments redirect themselves goes where they say.
    const std::string command = environment + " '" + PLIANT_PROGRAM + "' >'" + out + "' 2>'" + err + "' " + arguments;
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(out), read_file(err)};
}

nlohmann::json run_json(const std::string& arguments) {
    const Result result = run(arguments);
    if (result.status != 0 || !result.errors.empty()) {
        fail_msg("pliant %s: exit status %d, stderr: %s", arguments.c_str(), result.status, result.errors.c_str());
    }
    nlohmann::json document = nlohmann::json::parse(result.output, nullptr, false);
    if (document.is_discarded()) { fail_msg("pliant %s: not one JSON document", arguments.c_str()); }
    return document;
}

} // namespace cli
