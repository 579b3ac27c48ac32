#ifndef DEMOS_REPORT_MACHINE_FACTS_H
#define DEMOS_REPORT_MACHINE_FACTS_H

// What measurements were made with.

#include <string>
#include <utility>
#include <vector>

namespace report {

// Names and values: processor, system, compiler, versions.
std::vector<std::pair<std::string, std::string>> machine_facts();

} // namespace report
#endif
