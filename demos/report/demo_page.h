#ifndef DEMOS_REPORT_DEMO_PAGE_H
#define DEMOS_REPORT_DEMO_PAGE_H

// The page that `pliant demo` leaves: pictures and a table, in one folder, without network.

#include "table.h"

namespace report {

struct DemoPicture {
    std::string scene, summary, file; // the file's name beside the page
};

std::string demo_page(const std::vector<DemoPicture>& pictures, const Table& table, const std::string& notes);

} // namespace report
#endif
