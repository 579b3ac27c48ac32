// Follows needs from module to module. The lists are made by core_modules.cmake.

#include "core_modules.h"

#include "engine.h"

#include <set>

namespace demos {

namespace {

struct Module {
    const char* name;
    size_t bytes;
};
constexpr Module modules[] = {
#define CORE_MODULE(name, bytes) {name, bytes},
#define CORE_NEED(module, needed)
#define CORE_FUNCTION(name, module)
#define CORE_FEATURE(name, module)
#include "core_modules.inc"
#undef CORE_MODULE
#undef CORE_NEED
#undef CORE_FUNCTION
#undef CORE_FEATURE
};

struct Entry {
    const char *name, *module;
};
constexpr Entry needs[] = {
#define CORE_MODULE(name, bytes)
#define CORE_NEED(module, needed) {needed, module},
#define CORE_FUNCTION(name, module)
#define CORE_FEATURE(name, module)
#include "core_modules.inc"
#undef CORE_NEED
#undef CORE_FUNCTION
};
constexpr Entry functions_of_core[] = {
#define CORE_NEED(module, needed)
#define CORE_FUNCTION(name, module) {name, module},
#include "core_modules.inc"
#undef CORE_FUNCTION
#undef CORE_FEATURE
};
constexpr Entry features_of_core[] = {
#define CORE_FUNCTION(name, module)
#define CORE_FEATURE(name, module) {name, module},
#include "core_modules.inc"
#undef CORE_MODULE
#undef CORE_NEED
#undef CORE_FUNCTION
#undef CORE_FEATURE
};

template <size_t count> std::string module_of(const Entry (&entries)[count], const std::string& name) {
    for (const Entry& entry : entries) {
        if (name == entry.name) { return entry.module; }
    }
    throw Error("the core has no " + name);
}

void add_with_needs(const std::string& module, std::set<std::string>& linked) {
    if (!linked.insert(module).second) { return; }
    for (const Entry& need : needs) {
        if (module == need.module) { add_with_needs(need.name, linked); }
    }
}

} // namespace

std::vector<std::string> core_features() {
    std::vector<std::string> names;
    for (const Entry& feature : features_of_core) {
        names.emplace_back(feature.name);
    }
    return names;
}

size_t core_bytes() {
    size_t sum = 0;
    for (const Module& module : modules) {
        sum += module.bytes;
    }
    return sum;
}

LinkedCore linked_core(const std::vector<std::string>& functions, const std::vector<std::string>& features) {
    std::set<std::string> linked;
    for (const std::string& name : functions) {
        add_with_needs(module_of(functions_of_core, name), linked);
    }
    for (const std::string& name : features) {
        add_with_needs(module_of(features_of_core, name), linked);
    }
    LinkedCore result;
    for (const Module& module : modules) {
        if (linked.count(module.name) > 0) { result.bytes += module.bytes; }
    }
    result.modules.assign(linked.begin(), linked.end());
    return result;
}

} // namespace demos
