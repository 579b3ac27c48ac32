#ifndef PLIANT_APP_DEMO_PAGE_H
#define PLIANT_APP_DEMO_PAGE_H

// The page that `pliant demo` leaves: pictures and a table, in one folder, without network.

#include "table.h"

namespace app {

struct DemoPicture {
    std::string scene, summary, file; // the file's name beside the page
};

std::string demo_page(const std::vector<DemoPicture>& pictures, const Table& table, const std::string& notes);

} // namespace app
#endif
