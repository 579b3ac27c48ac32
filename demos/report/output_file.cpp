#include "output_file.h"

#include "description/error.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace report {

namespace fs = std::filesystem;

[[noreturn]] static void fail_for(const fs::path& path, const std::string& why) {
    throw demos::Error("cannot write " + path.string() + ": " + why);
}

[[noreturn]] static void fail_with_errno(const fs::path& path) {
    fail_for(path, std::strerror(errno));
}

static fs::path partial_path(const fs::path& path) {
    fs::path partial = path;
    partial += ".partial-" + std::to_string(getpid());
    return partial;
}

static int create_file(const fs::path& path) {
    return open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
}

// Closes the descriptor. False with errno set when not all bytes were written.
static bool write_all(int descriptor, const std::string& bytes) {
    size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t count = ::write(descriptor, bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno == EINTR) { continue; }
        if (count < 0) {
            const int reason = errno;
            close(descriptor);
            errno = reason;
            return false;
        }
        done += static_cast<size_t>(count);
    }
    return close(descriptor) == 0;
}

OutputFile::OutputFile(const std::string& path) {
    if (path.empty()) { return; }
    std::error_code error;
    path_ = fs::weakly_canonical(path, error);
    if (error) { fail_for(path, error.message()); }
    const fs::file_status status = fs::status(path_, error);
    if (fs::is_directory(status)) { fail_for(path, "it is a folder"); }
    if (fs::exists(status) && access(path_.c_str(), W_OK) != 0) { fail_with_errno(path); }
    is_special_ = fs::exists(status) && !fs::is_regular_file(status);
    if (is_special_) { return; }
    const fs::path partial = partial_path(path_);
    const int descriptor = create_file(partial);
    if (descriptor < 0) { fail_with_errno(path); }
    close(descriptor);
    unlink(partial.c_str());
}

void OutputFile::write(const std::string& bytes) const {
    if (path_.empty()) { return; }
    if (is_special_) {
        const int descriptor = open(path_.c_str(), O_WRONLY | O_CLOEXEC);
        if (descriptor < 0 || !write_all(descriptor, bytes)) { fail_with_errno(path_); }
        return;
    }
    const fs::path partial = partial_path(path_);
    const int descriptor = create_file(partial);
    if (descriptor < 0) { fail_with_errno(path_); }
    if (!write_all(descriptor, bytes) || rename(partial.c_str(), path_.c_str()) != 0) {
        const int reason = errno;
        unlink(partial.c_str());
        errno = reason;
        fail_with_errno(path_);
    }
}

void make_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) { throw demos::Error("cannot make the folder " + folder.string() + ": " + error.message()); }
    if (!fs::is_directory(folder)) { throw demos::Error(folder.string() + " is not a folder"); }
}

} // namespace report
