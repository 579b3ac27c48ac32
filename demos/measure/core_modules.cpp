// Follows needs from module to module.

#include "core_modules.h"

#include "core_module_table.h"
#include "description/error.h"

#include <set>

namespace demos {

namespace {

std::string module_of(const std::vector<CoreEntry>& entries, const std::string& name) {
    for (const CoreEntry& entry : entries) {
        if (name == entry.name) { return entry.module; }
    }
    throw Error("the core has no " + name);
}

void add_with_needs(const std::string& module, std::set<std::string>& linked) {
    if (!linked.insert(module).second) { return; }
    for (const CoreEntry& need : core_needs) {
        if (module == need.module) { add_with_needs(need.name, linked); }
    }
}

} // namespace

std::vector<std::string> core_features() {
    std::vector<std::string> names;
    for (const CoreEntry& feature : core_feature_modules) {
        names.emplace_back(feature.name);
    }
    return names;
}

size_t core_bytes() {
    size_t sum = 0;
    for (const CoreModule& module : core_modules) {
        sum += module.bytes;
    }
    return sum;
}

LinkedCore linked_core(const std::vector<std::string>& functions, const std::vector<std::string>& features) {
    std::set<std::string> linked;
    for (const std::string& name : functions) {
        add_with_needs(module_of(core_functions, name), linked);
    }
    for (const std::string& name : features) {
        add_with_needs(module_of(core_feature_modules, name), linked);
    }
    LinkedCore result;
    for (const CoreModule& module : core_modules) {
        if (linked.count(module.name) > 0) { result.bytes += module.bytes; }
    }
    result.modules.assign(linked.begin(), linked.end());
    return result;
}

} // namespace demos
