#ifndef DEMOS_ERROR_H
#define DEMOS_ERROR_H

#include <stdexcept>

namespace demos {

// Every failure that a user can cause; what() is one line.
struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

} // namespace demos
#endif
