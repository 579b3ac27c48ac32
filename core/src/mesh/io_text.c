/* Text files: loading, words, numbers, messages with file and line. */

#include "mesh/io_text.h"

#include "math/vec.h"

#include <errno.h>
#include <limits.h>
#include <locale.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/* Reads to the end into a block that doubles; `used` receives what it holds. */
static pli_status text_load(plii_text* text, FILE* file, size_t* used) {
    text->size = 65536;
    text->data = plii_allocate(text->context, text->size);
    while (text->data != NULL) {
        *used += fread(text->data + *used, 1, text->size - *used, file);
        PLII_FAIL_IF(ferror(file) != 0, text->context, PLI_ERROR_FILE_OPEN, text->function, "%s: cannot be read: %s",
                     text->path, strerror(errno));
        if (*used < text->size) { return PLI_OK; }
        char* larger = text->size <= SIZE_MAX / 2 ? plii_allocate(text->context, text->size * 2) : NULL;
        if (larger != NULL) { memcpy(larger, text->data, *used); }
        plii_release(text->context, text->data, text->size);
        text->data = larger;
        text->size *= 2;
    }
    return plii_fail(text->context, PLI_ERROR_OUT_OF_MEMORY, text->function, "%s: no memory for the file", text->path);
}

pli_status plii_text_open(pli_context* context, const char* path, const char* function, bool* missing,
                          plii_text* text) {
    *text = (plii_text){.context = context, .function = function, .path = path, .line = 1};
    errno = 0;
    FILE* file = fopen(path, "rb");
    if (missing != NULL) { *missing = file == NULL && errno == ENOENT; }
    if (missing != NULL && *missing) { return PLI_OK; }
    if (file == NULL) { return plii_fail(context, PLI_ERROR_FILE_OPEN, function, "%s: %s", path, strerror(errno)); }
    size_t used = 0;
    const pli_status status = text_load(text, file, &used);
    fclose(file);
    if (status != PLI_OK) {
        plii_text_close(text);
        return status;
    }
    static const char byte_order_mark[3] = {'\xef', '\xbb', '\xbf'}; /* some editors begin UTF-8 with it */
    const bool has_mark = used >= 3 && memcmp(text->data, byte_order_mark, sizeof byte_order_mark) == 0;
    text->at = text->data + (has_mark ? sizeof byte_order_mark : 0);
    text->end = text->data + used;
    return PLI_OK;
}

void plii_text_close(plii_text* text) {
    plii_release(text->context, text->data, text->size);
    text->data = NULL;
}

pli_status plii_text_fail(const plii_text* text, const char* format, ...) {
    char message[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return plii_fail(text->context, PLI_ERROR_FILE_FORMAT, text->function, "%s:%d: %s", text->path, text->line,
                     message);
}

plii_quote plii_text_quote(const char* word, int length) {
    plii_quote quote;
    const int kept = length < PLII_QUOTE_LENGTH ? length : PLII_QUOTE_LENGTH;
    for (int i = 0; i < kept; ++i) {
        const bool is_printable = word[i] >= ' ' && word[i] <= '~';
        quote.text[i] = is_printable ? word[i] : '.';
    }
    strcpy(&quote.text[kept], kept < length ? "..." : "");
    return quote;
}

static bool text_is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/* Length of a backslash with the line end behind it, or 0. */
static int text_joint_length(const plii_text* text, const char* at) {
    if (!text->joins_lines || at == text->end || *at != '\\') { return 0; }
    const ptrdiff_t left = text->end - at;
    if (left >= 2 && at[1] == '\n') { return 2; }
    return left >= 3 && at[1] == '\r' && at[2] == '\n' ? 3 : 0;
}

static void text_skip_blanks(plii_text* text) {
    while (text->at < text->end) {
        const int joint = text_joint_length(text, text->at);
        if (joint > 0) {
            ++text->line;
            text->at += joint;
        } else if (text_is_blank(*text->at)) {
            ++text->at;
        } else {
            return;
        }
    }
}

bool plii_text_is_line_done(plii_text* text) {
    text_skip_blanks(text);
    return text->at == text->end || *text->at == '\n' || *text->at == '#';
}

bool plii_text_next_line(plii_text* text) {
    const char* word;
    int length;
    while (plii_text_read_word(text, &word, &length)) {}
    while (text->at < text->end && *text->at != '\n') {
        ++text->at;
    } /* a comment */
    if (text->at == text->end) { return false; }
    ++text->at;
    ++text->line;
    return true;
}

bool plii_text_find_content(plii_text* text) {
    while (plii_text_is_line_done(text)) {
        if (!plii_text_next_line(text)) { return false; }
    }
    return true;
}

bool plii_text_read_word(plii_text* text, const char** word, int* length) {
    if (plii_text_is_line_done(text)) { return false; }
    *word = text->at;
    while (text->at < text->end && !text_is_blank(*text->at) && *text->at != '\n' &&
           text_joint_length(text, text->at) == 0) {
        ++text->at;
    }
    const ptrdiff_t size = text->at - *word;
    *length = size < INT_MAX ? (int)size : INT_MAX;
    return true;
}

static bool text_is_digit(char c) {
    return c >= '0' && c <= '9';
}

/* strtof would also take hexadecimal numbers, "inf" and "nan", and the decimal separator of the locale only. */
static bool text_parse_float(const char* word, int length, float* value) {
    char copy[1024];
    const char* separator = localeconv()->decimal_point;
    const size_t separator_length = strlen(separator);
    size_t used = 0;
    for (int i = 0; i < length; ++i) {
        if (used + separator_length >= sizeof copy) { return false; }
        if (word[i] == '.') {
            memcpy(copy + used, separator, separator_length);
            used += separator_length;
        } else if (text_is_digit(word[i]) || memchr("+-eE", word[i], 4) != NULL) {
            copy[used++] = word[i];
        } else {
            return false;
        }
    }
    copy[used] = '\0';
    char* end = NULL;
    *value = strtof(copy, &end);
    return used > 0 && end == copy + used && plii_is_finite(*value);
}

bool plii_parse_int(const char* word, int length, int* value) {
    const int sign_length = length > 0 && (word[0] == '-' || word[0] == '+');
    if (length == sign_length) { return false; }
    int64_t magnitude = 0;
    for (int i = sign_length; i < length; ++i) {
        if (!text_is_digit(word[i])) { return false; }
        magnitude = magnitude * 10 + (word[i] - '0');
        if (magnitude > INT_MAX) { return false; }
    }
    *value = word[0] == '-' ? (int)-magnitude : (int)magnitude;
    return true;
}

static pli_status text_read(plii_text* text, const char* what, const char** word, int* length) {
    if (plii_text_read_word(text, word, length)) { return PLI_OK; }
    return plii_text_fail(text, "the line ends before %s", what);
}
static pli_status text_fail_number(const plii_text* text, const char* what, const char* word, int length) {
    return plii_text_fail(text, "%s is '%s', which is no usable number", what, plii_text_quote(word, length).text);
}

pli_status plii_text_read_float(plii_text* text, const char* what, float* value) {
    const char* word = NULL;
    int length = 0;
    PLII_TRY(text_read(text, what, &word, &length));
    return text_parse_float(word, length, value) ? PLI_OK : text_fail_number(text, what, word, length);
}

pli_status plii_text_read_coordinate(plii_text* text, const char* what, float limit, float* value) {
    PLII_TRY(plii_text_read_float(text, what, value));
    PLII_TEXT_FAIL_IF(fabsf(*value) > limit, text, "%s is %g, coordinates go to %g", what, (double)*value,
                      (double)limit);
    return PLI_OK;
}

pli_status plii_text_read_int(plii_text* text, const char* what, int* value) {
    const char* word = NULL;
    int length = 0;
    PLII_TRY(text_read(text, what, &word, &length));
    return plii_parse_int(word, length, value) ? PLI_OK : text_fail_number(text, what, word, length);
}
