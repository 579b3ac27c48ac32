#ifndef DEMOS_REPORT_HTML_H
#define DEMOS_REPORT_HTML_H

// Parts of pages that need nothing beside themselves: no scripts, no network.

#include "table.h"

namespace report {

// Up to and with the beginning of the body; `style` is added to the common one.
std::string page_head(const std::string& title, const std::string& style = "");
std::string page_end();

std::string table_html(const Table& table);
// "data:image/png;base64,..."
std::string png_uri(const std::string& bytes);

} // namespace report
#endif
