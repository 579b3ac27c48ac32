#ifndef DEMOS_CORE_MODULES_H
#define DEMOS_CORE_MODULES_H

// What the core library consists of, as its object files tell when the program is built.

#include <cstddef>
#include <string>
#include <vector>

namespace demos {

// All that a body can have, by the names that it is listed with.
std::vector<std::string> core_features();
size_t core_bytes();

// Of the core, in a static program: the modules (object files, one per source file) that a linker takes for these
// public functions and features, and all that they need; bytes of code and data. Linkers that drop unused sections
// (--gc-sections) make it less. Throws Error for a name that the core does not have.
struct LinkedCore {
    size_t bytes = 0;
    std::vector<std::string> modules; // by name
};
LinkedCore linked_core(const std::vector<std::string>& functions, const std::vector<std::string>& features);

} // namespace demos
#endif
