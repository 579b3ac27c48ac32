#include "demo_page.h"

#include "html.h"
#include "svg.h"

namespace report {

std::string demo_page(const std::vector<DemoPicture>& pictures, const Table& table, const std::string& notes) {
    std::string html = page_head("Pliant beside Bullet");
    html += "<h1>Pliant beside Bullet</h1>\n<p>The same scenes on both engines: Pliant on the left, btSoftBody on the "
            "right.</p>\n";
    html += table_html(table);
    html += "<p class=\"notes\">" + escaped(notes) + "</p>\n";
    for (const DemoPicture& each : pictures) {
        html += "<h2>" + escaped(each.scene) + "</h2>\n<p>" + escaped(each.summary) + "</p>\n<img src=\"" +
                escaped(each.file) + "\" alt=\"" + escaped(each.scene) + " on Pliant and on Bullet\">\n";
    }
    return html + page_end();
}

} // namespace report
