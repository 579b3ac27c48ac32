#include "demo_page.h"

#include "../report/svg.h"

namespace app {

using report::escaped;

static const char* const page_head = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Pliant beside Bullet</title>
<style>
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 1100px; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.6rem; margin-bottom: .3rem; }
h2 { font-size: 1.15rem; margin: 2rem 0 .2rem; }
p { margin: .2rem 0 .6rem; }
img { width: 100%; height: auto; border-radius: 6px; display: block; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: 1rem 0; }
th, td { padding: .3rem .9rem; text-align: right; border-bottom: 1px solid #8886; white-space: nowrap; }
th:first-child, td:first-child { text-align: left; padding-left: 0; }
.notes { font-size: .9rem; opacity: .8; }
</style>
</head>
<body>
)";

static std::string table_html(const Table& table) {
    std::string html = "<div class=\"wide\"><table>\n";
    for (size_t i = 0; i < table.rows().size(); ++i) {
        const std::string tag = i == 0 ? "th" : "td";
        html += "<tr>";
        for (const std::string& cell : table.rows()[i]) {
            html += "<" + tag + ">" + escaped(cell) + "</" + tag + ">";
        }
        html += "</tr>\n";
    }
    return html + "</table></div>\n";
}

std::string demo_page(const std::vector<DemoPicture>& pictures, const Table& table, const std::string& notes) {
    std::string html = page_head;
    html += "<h1>Pliant beside Bullet</h1>\n<p>The same scenes on both engines: Pliant on the left, btSoftBody on the "
            "right.</p>\n";
    html += table_html(table);
    html += "<p class=\"notes\">" + escaped(notes) + "</p>\n";
    for (const DemoPicture& each : pictures) {
        html += "<h2>" + escaped(each.scene) + "</h2>\n<p>" + escaped(each.summary) + "</p>\n<img src=\"" +
                escaped(each.file) + "\" alt=\"" + escaped(each.scene) + " on Pliant and on Bullet\">\n";
    }
    return html + "</body>\n</html>\n";
}

} // namespace app
