#pragma once

/* A text file in memory, read word by word, with line numbers for messages. Numbers are alike in every locale. */

#include "base/context.h"

typedef struct plii_text {
    pli_context* context;
    const char* function; /* for messages */
    const char* path;
    char* data;
    size_t size;
    const char *at, *end;
    int line;
    bool joins_lines; /* a backslash at the end of a line continues it */
} plii_text;

/* `function` and `path` must outlive the text. Where a missing file is fine, `missing` receives whether it is. */
pli_status plii_text_open(pli_context* context, const char* path, const char* function, bool* missing, plii_text* text);
void plii_text_close(plii_text* text);

/* "path:line: message"; gives PLI_ERROR_FILE_FORMAT. */
pli_status plii_text_fail(const plii_text* text, const char* format, ...) PLI_PRINTF_LIKE(2, 3);

/* Returns early with such an error where something is wrong. */
#define PLII_TEXT_FAIL_IF(is_wrong, ...)                                                                               \
    do {                                                                                                               \
        if (is_wrong) { return plii_text_fail(__VA_ARGS__); }                                                          \
    } while (0)

/* The beginning of a word for a message: a terminal must not get what a binary file holds. */
enum { PLII_QUOTE_LENGTH = 40 };
typedef struct plii_quote {
    char text[PLII_QUOTE_LENGTH + 4]; /* other bytes than those of printable ASCII as '.', "..." where it is cut */
} plii_quote;
plii_quote plii_text_quote(const char* word, int length);

/* Whether nothing but blanks and a comment (# to the end) is left in the line. */
bool plii_text_is_line_done(plii_text* text);
/* Goes to the start of the next line; false at the end of the file. */
bool plii_text_next_line(plii_text* text);
/* Goes to the next line with content, which may be the present one; false at the end of the file. */
bool plii_text_find_content(plii_text* text);

/* False at the end of the line. The word is not terminated. */
bool plii_text_read_word(plii_text* text, const char** word, int* length);
/* Fail where the next word is missing or no such number; `what` names the value. */
pli_status plii_text_read_float(plii_text* text, const char* what, float* value);
pli_status plii_text_read_coordinate(plii_text* text, const char* what, float limit, float* value);
pli_status plii_text_read_int(plii_text* text, const char* what, int* value);

/* A whole word as a number; false when it is none, or too large. */
bool plii_parse_int(const char* word, int length, int* value);
