#ifndef DEMOS_REPORT_REPORT_PAGE_H
#define DEMOS_REPORT_REPORT_PAGE_H

// The page that `pliant report` leaves, from the JSON documents of the subcommands: one file with everything in it.

#include "report_content.h"

namespace report {

std::string report_page(const ReportContent& content);
// The table of costs, for documents.
std::string costs_markdown(const std::vector<nlohmann::json>& costs);

} // namespace report
#endif
