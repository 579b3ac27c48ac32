#include "csv.h"

namespace report {

static std::string quoted(const std::string& cell) {
    if (cell.find_first_of(",\"\n\r") == std::string::npos) { return cell; }
    std::string text = "\"";
    for (const char c : cell) {
        text += c;
        if (c == '"') { text += c; }
    }
    return text + "\"";
}

std::string csv_line(const std::vector<std::string>& cells) {
    std::string line;
    for (size_t i = 0; i < cells.size(); ++i) {
        line += (i == 0 ? "" : ",") + quoted(cells[i]);
    }
    return line + "\n";
}

} // namespace report
