/* Files for the readers. */

#define _POSIX_C_SOURCE 200809L

#include "input_file.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MOST_FILES = 4 };

typedef struct input_file {
    char path[160];
    int descriptor; /* -1: there is no such file now */
} input_file;

static char folder[128];
static input_file files[MOST_FILES];
static int file_count;

static void stop(const char* reason) {
    fprintf(stderr, "finding: %s\n", reason);
    abort();
}

static void remove_all(void) {
    for (int i = 0; i < file_count; ++i) {
        unlink(files[i].path);
    }
    rmdir(folder);
}

/* In memory where there is such a place. */
static void make_folder(void) {
    const char* const place = access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp";
    snprintf(folder, sizeof folder, "%s/pliant-fuzz-XXXXXX", place);
    if (mkdtemp(folder) == NULL) { stop("no folder for the input"); }
    atexit(remove_all);
}

const char* input_path(const char* name) {
    if (folder[0] == '\0') { make_folder(); }
    for (int i = 0; i < file_count; ++i) {
        if (strcmp(files[i].path + strlen(folder) + 1, name) == 0) { return files[i].path; }
    }
    if (file_count == MOST_FILES) { stop("too many files"); }
    input_file* made = &files[file_count++];
    snprintf(made->path, sizeof made->path, "%s/%s", folder, name);
    made->descriptor = -1;
    return made->path;
}

void input_write(const char* path, const uint8_t* data, size_t size) {
    input_file* file = files;
    while (file->path != path) {
        ++file;
    }
    if (data == NULL) {
        if (file->descriptor >= 0) {
            close(file->descriptor);
            unlink(path);
        }
        file->descriptor = -1;
        return;
    }
    if (file->descriptor < 0) { file->descriptor = open(path, O_RDWR | O_CREAT, 0600); }
    if (file->descriptor < 0 || ftruncate(file->descriptor, (off_t)size) != 0 ||
        pwrite(file->descriptor, data, size, 0) != (ssize_t)size) {
        stop("the input cannot be written");
    }
}

void input_check(const pli_context* context, pli_status status) {
    if (pli_context_allocated_bytes(context) != 0) { stop("memory left"); }
    if (status == PLI_OK) { return; }
    const char* message = pli_last_error(context);
    if (message[0] == '\0') { stop("no message"); }
    for (const char* at = message; *at != '\0'; ++at) {
        if (*at < ' ' || *at > '~') { stop("a message with other bytes than printable ASCII"); }
    }
}
