#ifndef TESTS_CLI_PROGRAM_RUN_H
#define TESTS_CLI_PROGRAM_RUN_H

// Runs the program pliant in a folder of its own and catches what it prints.

#include <nlohmann/json.hpp>

#include <string>

namespace cli {

struct Result {
    int status; // exit status; -1 when the program was ended by a signal
    std::string output, errors;
};

// `arguments` as for a shell, with `environment` ("NAME=value ...") before the program.
Result run(const std::string& arguments, const std::string& environment = "");

// A path in the test's own empty folder, which is removed at the end of the program.
std::string scratch(const std::string& name);

bool exists(const std::string& path);
std::string read_file(const std::string& path);
void write_file(const std::string& path, const std::string& bytes);
// Names of all files in the test's folder.
std::string scratch_files();

// The one JSON document that the program prints; fails the test when the exit status is not 0, when there is anything
// else on stdout or anything at all on stderr.
nlohmann::json run_json(const std::string& arguments);

} // namespace cli
#endif
