#ifndef TESTS_FUZZ_INPUT_FILE_H
#define TESTS_FUZZ_INPUT_FILE_H

/* Files for the readers, written again for each input, in a folder of this process that goes at its end. */

#include <pliant/base.h>

#include <stddef.h>
#include <stdint.h>

/* A path in the folder; valid for good. The same `name` gives the same path. */
const char* input_path(const char* name);
/* Where `data` is NULL the file is removed. */
void input_write(const char* path, const uint8_t* data, size_t size);

/* Ends the process where `context` holds memory, or where a failure has no message of printable ASCII. */
void input_check(const pli_context* context, pli_status status);

#endif
