/* Runs inputs through an entry point, for compilers without a fuzzer: files, and packed corpora (files named *.pack:
   for each input its size in four bytes, the lowest first, then its bytes).

     usage: replay_NAME FILE...
            replay_NAME --pack PACK FILE...      makes a packed corpus
            replay_NAME --unpack PACK FOLDER     one file per input, named by number */

#include "entry.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct file_bytes {
    uint8_t* bytes;
    size_t size;
} file_bytes;

static void stop(const char* path, const char* reason) {
    fprintf(stderr, "%s: %s\n", path, reason);
    exit(1);
}

/* In a block of exactly its size, so that AddressSanitizer sees reads behind it. */
static file_bytes read_file(const char* path) {
    FILE* file = fopen(path, "rb");
    if (file == NULL || fseek(file, 0, SEEK_END) != 0) { stop(path, "cannot be opened"); }
    const long size = ftell(file);
    if (size < 0) { stop(path, "cannot be read"); }
    rewind(file);
    file_bytes all = {malloc((size_t)size > 0 ? (size_t)size : 1), (size_t)size};
    if (all.bytes == NULL || fread(all.bytes, 1, all.size, file) != all.size) { stop(path, "cannot be read"); }
    fclose(file);
    return all;
}

static void write_file(FILE* file, const char* path, const void* data, size_t size) {
    if (file == NULL || fwrite(data, 1, size, file) != size) { stop(path, "cannot be written"); }
}

static bool is_pack(const char* path) {
    const size_t length = strlen(path);
    return length >= 5 && strcmp(path + length - 5, ".pack") == 0;
}

/* Each input of a packed corpus is handed to `use`. */
static int walk_pack(const char* path, void (*use)(const uint8_t*, size_t, int, const char*), const char* folder) {
    const file_bytes all = read_file(path);
    int count = 0;
    for (size_t at = 0; at < all.size; ++count) {
        if (all.size - at < 4) { stop(path, "the last input has no size"); }
        size_t size = 0;
        for (size_t i = 0; i < 4; ++i) {
            size |= (size_t)all.bytes[at + i] << 8 * i;
        }
        at += 4;
        if (size > all.size - at) { stop(path, "the last input is cut off"); }
        use(all.bytes + at, size, count, folder);
        at += size;
    }
    free(all.bytes);
    return count;
}

static void run_input(const uint8_t* data, size_t size, int number, const char* folder) {
    (void)number;
    (void)folder;
    uint8_t* copy = malloc(size > 0 ? size : 1);
    if (copy == NULL) { return; }
    if (size > 0) { memcpy(copy, data, size); }
    LLVMFuzzerTestOneInput(copy, size);
    free(copy);
}

static void unpack_input(const uint8_t* data, size_t size, int number, const char* folder) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%05d", folder, number);
    FILE* file = fopen(path, "wb");
    write_file(file, path, data, size);
    fclose(file);
}

static void pack(const char* path, int count, char** inputs) {
    FILE* file = fopen(path, "wb");
    for (int i = 0; i < count; ++i) {
        const file_bytes input = read_file(inputs[i]);
        uint8_t size[4];
        for (size_t k = 0; k < 4; ++k) {
            size[k] = (uint8_t)(input.size >> 8 * k);
        }
        write_file(file, path, size, sizeof size);
        write_file(file, path, input.bytes, input.size);
        free(input.bytes);
    }
    if (file == NULL || fclose(file) != 0) { stop(path, "cannot be written"); }
}

int main(int argument_count, char** arguments) {
    if (argument_count >= 3 && strcmp(arguments[1], "--pack") == 0) {
        pack(arguments[2], argument_count - 3, arguments + 3);
        return 0;
    }
    if (argument_count == 4 && strcmp(arguments[1], "--unpack") == 0) {
        printf("%d inputs\n", walk_pack(arguments[2], unpack_input, arguments[3]));
        return 0;
    }
    int count = 0;
    for (int i = 1; i < argument_count; ++i) {
        if (is_pack(arguments[i])) {
            count += walk_pack(arguments[i], run_input, NULL);
            continue;
        }
        const file_bytes input = read_file(arguments[i]);
        LLVMFuzzerTestOneInput(input.bytes, input.size);
        free(input.bytes);
        ++count;
    }
    printf("%d inputs\n", count);
    return count > 0 ? 0 : 1;
}
