#include "table.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace report {

Table::Table(std::vector<std::string> headings) {
    rows_.push_back(std::move(headings));
}

void Table::add(std::vector<std::string> cells) {
    rows_.push_back(std::move(cells));
}

std::string Table::text() const {
    std::vector<size_t> widths(rows_[0].size());
    for (const auto& row : rows_) {
        for (size_t i = 0; i < row.size(); ++i) {
            widths[i] = std::max(widths[i], row[i].size());
        }
    }
    std::string text;
    for (const auto& row : rows_) {
        for (size_t i = 0; i < row.size(); ++i) {
            const std::string padding(widths[i] - row[i].size(), ' ');
            text += i == 0 ? row[i] + (row.size() > 1 ? padding : "") : "  " + padding + row[i];
        }
        text += '\n';
    }
    return text;
}

static std::string format(const char* pattern, int precision, double value) {
    char text[400];
    std::snprintf(text, sizeof text, pattern, precision, value);
    return text;
}

std::string fixed(double value, int decimals) {
    return format("%.*f", decimals, value);
}

std::string short_error(double value) {
    if (value < 0.0) { return "-"; }
    return value == 0.0 ? "0" : format("%.*e", 1, value);
}

std::string exact(double value) {
    return format("%.*g", 9, value);
}

} // namespace report
