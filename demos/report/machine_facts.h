#ifndef PLIANT_APP_MACHINE_FACTS_H
#define PLIANT_APP_MACHINE_FACTS_H

// What measurements were made with.

#include <string>
#include <utility>
#include <vector>

namespace app {

// Names and values: processor, system, compiler, versions.
std::vector<std::pair<std::string, std::string>> machine_facts();

} // namespace app
#endif
