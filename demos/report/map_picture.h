#ifndef DEMOS_REPORT_MAP_PICTURE_H
#define DEMOS_REPORT_MAP_PICTURE_H

// A table as a picture: rows in groups, coloured cells.

#include <string>
#include <vector>

namespace report {

enum class Shade { good, fair, bad };

struct MapCell {
    std::string text, hint;
    Shade shade = Shade::good;
};

struct MapRow {
    std::string group, name;
    std::vector<MapCell> cells; // as many as columns
};

// SVG, 1000 pixels wide.
std::string map_picture(const std::string& title, const std::vector<std::string>& columns,
                        const std::vector<MapRow>& rows);

} // namespace report
#endif
