#include "text_buffer.h"

#include <charconv>

namespace exporting {

template <class number> static void append_number(std::string& text, number value) {
    char digits[32];
    const std::to_chars_result end = std::to_chars(digits, digits + sizeof digits, value);
    text.append(digits, end.ptr);
}

void append(std::string& text, float value) {
    append_number(text, value);
}

void append(std::string& text, int value) {
    append_number(text, value);
}

void append(std::string& text, pli_vec3 value) {
    append(text, value.x);
    text += ' ';
    append(text, value.y);
    text += ' ';
    append(text, value.z);
}

} // namespace exporting
