#ifndef DEMOS_EXPORT_TEXT_BUFFER_H
#define DEMOS_EXPORT_TEXT_BUFFER_H

// Numbers appended to text, independent of the locale.

#include <pliant/math.h>

#include <string>

namespace exporting {

void append(std::string& text, float value); // as many digits as it takes to read the same float back
void append(std::string& text, int value);
void append(std::string& text, pli_vec3 value); // three numbers with spaces between them

} // namespace exporting
#endif
