#ifndef DEMOS_REPORT_OUTPUT_FILE_H
#define DEMOS_REPORT_OUTPUT_FILE_H

// A file that is either written whole or left as it was.

#include <filesystem>
#include <string>

namespace report {

class OutputFile {
public:
    // Throws demos::Error when the file could not be written, so that long work need not be done in vain. `path` may be
    // empty: then nothing is ever written.
    explicit OutputFile(const std::string& path);

    bool is_wanted() const { return !path_.empty(); }
    const std::filesystem::path& path() const { return path_; }
    // Replaces the file at once. Throws demos::Error; the file is then as before.
    void write(const std::string& bytes) const;

private:
    std::filesystem::path path_; // links resolved
    bool is_special_ = false;    // a device or a pipe, to be written in place
};

// Makes the folder and those above it. Throws demos::Error.
void make_folder(const std::filesystem::path& folder);

} // namespace report
#endif
