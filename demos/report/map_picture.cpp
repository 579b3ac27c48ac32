#include "map_picture.h"

#include "svg.h"

#include <algorithm>

namespace report {

static const char* fill_of(Shade shade) {
    return shade == Shade::good ? "#cfe8cf" : shade == Shade::fair ? "#d7e3f4" : "#f2b8b0";
}

std::string map_picture(const std::string& title, const std::vector<std::string>& columns,
                        const std::vector<MapRow>& rows) {
    constexpr double width = 1000, left = 390, row_height = 23, top = 84, group_gap = 8;
    const double cell_width = (width - left - 12) / static_cast<double>(columns.size());
    double height = top + 12;
    for (size_t i = 0; i < rows.size(); ++i) {
        height += row_height + (i > 0 && rows[i].group != rows[i - 1].group ? group_gap : 0.0);
    }
    Svg svg(width, height);
    svg.text(12, 32, title, {19, "start", "#111", true, 0});
    for (size_t k = 0; k < columns.size(); ++k) {
        svg.text(left + cell_width * (static_cast<double>(k) + 0.5), top - 12, columns[k],
                 {columns.size() > 4 ? 12.0 : 14.0, "middle", "#111", true, 0});
    }
    double y = top;
    for (size_t i = 0; i < rows.size(); ++i) {
        const MapRow& row = rows[i];
        const bool begins = i == 0 || row.group != rows[i - 1].group;
        if (begins && i > 0) { y += group_gap; }
        if (begins) { svg.text(12, y + 16, row.group, {13, "start", "#555", true, 0}); }
        svg.text(left - 10, y + 16, row.name, {13, "end", "#222", false, 0});
        for (size_t k = 0; k < row.cells.size(); ++k) {
            const MapCell& cell = row.cells[k];
            const double x = left + cell_width * static_cast<double>(k);
            svg.begin_hint(cell.hint.empty() ? cell.text : cell.hint);
            svg.rectangle(x + 1, y + 1, cell_width - 2, row_height - 2, fill_of(cell.shade));
            const double size = std::min(13.0, 1.7 * cell_width / static_cast<double>(cell.text.size() + 1));
            svg.text(x + cell_width / 2, y + 16, cell.text, {size, "middle", "#111", false, 0});
            svg.end_hint();
        }
        y += row_height;
    }
    return svg.document();
}

} // namespace report
