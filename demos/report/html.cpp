#include "html.h"

#include "svg.h"

namespace report {

static const char* const head_start = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>)";

static const char* const head_style = R"(</title>
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
)";

static const char* const head_end = R"(</style>
</head>
<body>
)";

std::string page_head(const std::string& title, const std::string& style) {
    return head_start + escaped(title) + head_style + style + head_end;
}

std::string page_end() {
    return "</body>\n</html>\n";
}

std::string table_html(const Table& table) {
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

std::string png_uri(const std::string& bytes) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text = "data:image/png;base64,";
    text.reserve(text.size() + (bytes.size() + 2) / 3 * 4);
    for (size_t i = 0; i < bytes.size(); i += 3) {
        const size_t count = bytes.size() - i < 3 ? bytes.size() - i : 3;
        unsigned value = 0;
        for (size_t k = 0; k < 3; ++k) {
            value = value << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        }
        for (size_t k = 0; k < 4; ++k) {
            text += k <= count ? digits[value >> (18 - 6 * k) & 63u] : '=';
        }
    }
    return text;
}

} // namespace report
