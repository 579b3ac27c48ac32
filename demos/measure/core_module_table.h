#ifndef DEMOS_CORE_MODULE_TABLE_H
#define DEMOS_CORE_MODULE_TABLE_H

// Lists that core_modules.cmake writes, as C++, from the object files of the core.

#include <cstddef>
#include <vector>

namespace demos {

// An object file.
struct CoreModule {
    const char* name;
    size_t bytes; // code and data
};
// Something by its name, and a module.
struct CoreEntry {
    const char *name, *module;
};

extern const std::vector<CoreModule> core_modules;
extern const std::vector<CoreEntry> core_needs;           // modules, and who needs them
extern const std::vector<CoreEntry> core_functions;       // public, and where they are
extern const std::vector<CoreEntry> core_feature_modules; // where features are

} // namespace demos
#endif
