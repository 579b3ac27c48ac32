#ifndef DEMOS_REPORT_CSV_H
#define DEMOS_REPORT_CSV_H

#include <string>
#include <vector>

namespace report {

// One line of comma-separated values, with its end; cells are quoted where they must be (RFC 4180).
std::string csv_line(const std::vector<std::string>& cells);

} // namespace report
#endif
