#include "report_page.h"

#include "conclusions.h"
#include "html.h"
#include "svg.h"

namespace report {

using nlohmann::json;

static const char* const report_style = R"(:root { color-scheme: light; background: #fff; color: #1c2024; }
body { max-width: 1000px; }
h2 { font-size: 1.3rem; margin: 2.6rem 0 .4rem; padding-top: .8rem; border-top: 2px solid #d5dae0; }
h3 { font-size: 1.05rem; margin: 1.6rem 0 .2rem; }
nav a { margin-right: 1.1rem; }
table { font-size: .82rem; margin: .6rem 0; }
th, td { padding: .2rem .42rem; }
th { border-bottom: 2px solid #b8c0c8; vertical-align: bottom; white-space: normal; }
tr:nth-child(even) td { background: #f5f7f9; }
figure { margin: .6rem 0 1.4rem; }
figcaption { font-size: .9rem; }
svg { width: 100%; height: auto; display: block; }
.plot { overflow-x: auto; }
.plot svg { min-width: 760px; }
.figures { display: flex; flex-wrap: wrap; gap: .8rem; margin: 1rem 0; padding: 0; list-style: none; }
.figures li { flex: 1 1 200px; background: #f0f4f8; border-radius: 6px; padding: .6rem .9rem; font-size: .85rem; }
.figures strong { display: block; font-size: 1.5rem; }
details { margin: .3rem 0; }
summary { cursor: pointer; }
.costs th:last-child, .costs td:last-child { text-align: left; white-space: normal; min-width: 17rem; }
.facts td { text-align: left; white-space: normal; }
.facts td:first-child { white-space: nowrap; }
.wide th:first-child, .wide td:first-child { position: sticky; left: 0; background: #fff; }
.wide tr:nth-child(even) td:first-child { background: #f5f7f9; }
.conclusions li { margin: .25rem 0; }
.side { display: none; font-size: .85rem; color: #666; }
@media (max-width: 800px) { .side { display: block; } }
)";

// ---------------------------------------------------------------------------------------------- cells of tables

static std::string fixed_cell(const json& value, int decimals) {
    return value.is_number() ? fixed(value.get<double>(), decimals) : "-";
}

static std::string error_cell(const json& value) {
    return value.is_number() ? short_error(value.get<double>()) : "-";
}

static std::string percent_cell(const json& share) {
    return share.is_number() ? fixed(100.0 * share.get<double>(), 2) : "-";
}

static std::string count_cell(const json& value) {
    return value.is_number() ? std::to_string(value.get<long long>()) : "-";
}

static std::string percent(double share) {
    return fixed(100.0 * share, 1) + " %";
}

static const char* const to_the_side = "<p class=\"side\">Wider than the screen: move it to the side.</p>\n";

static std::string wide_table(const Table& table) {
    return to_the_side + table_html(table);
}

static std::string paragraph(const std::string& text) {
    return "<p class=\"notes\">" + escaped(text) + "</p>\n";
}

static std::string heading(const char* id, const char* text) {
    return std::string("<h2 id=\"") + id + "\">" + text + "</h2>\n";
}

// ---------------------------------------------------------------------------------------------------- sections

static std::string facts_part(const ReportContent& content) {
    std::string html = heading("machine", "Machine and build") + "<table class=\"facts\">\n";
    for (const auto& [name, value] : content.facts) {
        html += "<tr><td>" + escaped(name) + "</td><td>" + escaped(value) + "</td></tr>\n";
    }
    return html + "</table>\n";
}

static std::string pictures_part(const ReportContent& content) {
    std::string html = heading("scenes", "Scenes");
    if (!content.picture_problem.empty()) { return html + paragraph("No pictures: " + content.picture_problem); }
    html +=
        paragraph("Pliant on the left, btSoftBody on the right, after the same number of steps from the same start. "
                  "None of them is in reference mode, in which both would show the same: Pliant runs as it does by "
                  "default, with coloured links and exact distances.");
    for (const ReportPicture& each : content.pictures) {
        html += "<figure><h3>" + escaped(each.scene) + "</h3>\n<img src=\"" + png_uri(each.png) + "\" alt=\"" +
                escaped(each.scene) + " on Pliant and on btSoftBody\">\n<figcaption>" + escaped(each.summary) +
                "</figcaption></figure>\n";
    }
    return html;
}

static std::string comparison_part(const json& document) {
    Table table({"scene", "nodes", "median, of the size", "p99, of the size", "maximum, of the size",
                 "bit-equal, of the nodes", "lone, frames", "above, frames", "unexplained, frames",
                 "free 30, of the size", "free 60, of the size", "free 300, of the size", "Bullet, ms", "Pliant, ms",
                 "Bullet / Pliant"});
    for (const json& each : document.at("scenes")) {
        const json &step = each.at("one_step"), &free_run = each.at("free_run");
        table.add({each.at("scene"), count_cell(each.at("nodes")), error_cell(step.at("median")),
                   error_cell(step.at("p99")), error_cell(step.at("maximum")),
                   percent(step.at("bit_equal_share").get<double>()), count_cell(step.at("frames_with_lone_contacts")),
                   count_cell(step.at("frames_above_limit")), count_cell(step.at("unexplained_frames")),
                   error_cell(free_run.at("error_30")), error_cell(free_run.at("error_60")),
                   error_cell(free_run.at("error_300")), fixed_cell(each.at("bullet_ms"), 3),
                   fixed_cell(each.at("pliant_ms"), 3), fixed_cell(each.at("time_ratio"), 2)});
    }
    return heading("comparison", "How near Pliant is to btSoftBody") + wide_table(table) +
           paragraph("All of this table is in reference mode. median, p99, maximum: error of one step from the same "
                     "state, as a share of the "
                     "size of the soft bodies. lone: frames with a contact that only one engine made; above: frames "
                     "with an error above 1e-5; unexplained: those of them without such a contact. free: error after "
                     "so many frames from the same start. ms: whole step, in the free run.");
}

static std::string speed_part(const json& document) {
    Table table({"scene", "nodes", "links", "frames that touch", "Pliant, ms", "reference mode, ms", "Bullet, ms",
                 "Bullet / Pliant", "all frames: Pliant, ms", "predict, ms", "collide, ms", "solve, ms", "Bullet, ms",
                 "Bullet / Pliant", "whole steps: Bullet / Pliant", "stretch, %", "stretch of Bullet, %",
                 "memory, B per node", "of Bullet, B per node"});
    for (const json& each : document.at("scenes")) {
        const json &pliant = each.at("pliant"), &reference = each.at("reference"), &bullet = each.at("bullet");
        table.add({each.at("scene"), count_cell(each.at("nodes")), count_cell(each.at("links")),
                   count_cell(each.at("touching_frames")) + " of " + count_cell(each.at("frames")),
                   fixed_cell(pliant.at("touching_median_ms"), 4), fixed_cell(reference.at("touching_median_ms"), 4),
                   fixed_cell(bullet.at("touching_median_ms"), 4), fixed_cell(each.at("touching_ratio"), 2),
                   fixed_cell(pliant.at("median_ms"), 4), fixed_cell(pliant.at("predict_ms"), 4),
                   fixed_cell(pliant.at("collide_ms"), 4), fixed_cell(pliant.at("solve_ms"), 4),
                   fixed_cell(bullet.at("median_ms"), 4), fixed_cell(each.at("ratio"), 2),
                   fixed_cell(each.at("world_step_ratio"), 2), percent_cell(pliant.at("rms_stretch")),
                   percent_cell(bullet.at("rms_stretch")), fixed_cell(pliant.at("bytes_per_node"), 0),
                   fixed_cell(bullet.at("bytes_per_node"), 0)});
    }
    return heading("speed", "Time of a step") + wide_table(table) +
           paragraph(
               "Medians of what the soft bodies take of a step, one thread; Bullet is btSoftBody. The first columns "
               "count the frames in which soft bodies touch something, in which the first columns of times are "
               "taken too; of scenes in which nothing touches there are none. stretch: root mean square over the "
               "links at the end.");
}

static std::string precision_part(const ReportContent& content) {
    std::string html = heading("precision", "Error against run time") +
                       paragraph("Each point is a run with one step length and one number of iterations; large points "
                                 "joined by a line are those that nothing of the same solver beats in both. Further "
                                 "down is more exact, further left is faster. The mouse shows the setting.");
    std::string scene;
    for (const ReportPlot& plot : content.plots) {
        if (plot.scene != scene) { html += "<h3>" + escaped(plot.scene) + "</h3>\n"; }
        scene = plot.scene;
        html += to_the_side + std::string("<figure class=\"plot\">") + plot.svg + "</figure>\n";
    }
    return html;
}

static std::string stability_part(const ReportContent& content) {
    return heading("stability", "Stability") +
           paragraph("Extreme cases with btSoftBody and with every solver of Pliant, each in a process of its own. A "
                     "case that is refused with a clear message, where that is right, counts as survived. The mouse "
                     "shows why a cell is not green.") +
           to_the_side + "<figure class=\"plot\">" + content.stability_svg + "</figure>\n";
}

// "links 11.4 µs; normals 0.2 µs, 8.4 kB": dearest first.
static std::string features_cell(const json& costs) {
    std::vector<json> features = costs.at("features");
    std::stable_sort(features.begin(), features.end(), [](const json& a, const json& b) {
        return a.at("microseconds").get<double>() > b.at("microseconds").get<double>();
    });
    std::string text;
    for (const json& feature : features) {
        text += (text.empty() ? "" : "; ") + feature.at("feature").get<std::string>();
        std::string separator = " ";
        if (feature.at("has_passes").get<bool>()) {
            text += separator + fixed(feature.at("microseconds").get<double>(), 1) + " µs";
            separator = ", ";
        }
        const double bytes = feature.at("bytes").get<double>();
        if (bytes > 0.0) { text += separator + fixed(bytes / 1000.0, 1) + " kB"; }
    }
    return text;
}

static Table costs_table(const std::vector<json>& documents) {
    Table table(
        {"scene", "nodes", "B/node", "µs/step", "linked kB", "off", "features that are on: time of a step, memory"});
    for (const json& each : documents) {
        const json& costs = each.at("costs");
        table.add({each.at("scene"), count_cell(each.at("nodes")), fixed_cell(costs.at("bytes_per_node"), 0),
                   fixed_cell(costs.at("microseconds"), 1), fixed(costs.at("linked_bytes").get<double>() / 1000.0, 0),
                   std::to_string(costs.at("left_out").size()), features_cell(costs)});
    }
    return table;
}

std::string costs_markdown(const std::vector<json>& costs) {
    const Table table = costs_table(costs);
    std::string text;
    for (const auto& row : table.rows()) {
        text += "|";
        for (const std::string& cell : row) {
            text += " " + cell + " |";
        }
        text += &row == table.rows().data() ? "\n|---|---|---|---|---|---|---|\n" : "\n";
    }
    return text;
}

static std::string costs_part(const std::vector<json>& costs) {
    return heading("costs", "What scenes pay for") + "<div class=\"costs\">" + wide_table(costs_table(costs)) +
           "</div>" +
           paragraph("Mean over the steps up to the scene's picture, with clocks in it; µs/step holds the step's own "
                     "work too. linked: bytes of the core in a program with these features. off: features that no soft "
                     "body has; they take neither time nor memory, and no code "
                     "of theirs is linked by a program that does not name them.");
}

static std::string conclusions_part(const std::vector<ConclusionGroup>& groups) {
    std::string html = heading("conclusions", "Conclusions") +
                       paragraph("From the figures above, as they were measured on this machine.");
    for (const ConclusionGroup& group : groups) {
        html += "<h3>" + escaped(group.heading) + "</h3>\n<ul class=\"conclusions\">\n";
        for (const std::string& sentence : group.sentences) {
            html += "<li>" + escaped(sentence) + "</li>\n";
        }
        html += "</ul>\n";
    }
    return html;
}

// --------------------------------------------------------------------------------------------- figures at the top

static std::string figure_item(const std::string& value, const std::string& text) {
    return "<li><strong>" + escaped(value) + "</strong>" + escaped(text) + "</li>\n";
}

static std::string survivals(const json& document, const char* solver) {
    int cases = 0, survived = 0;
    for (const json& cell : document.at("cells")) {
        if (cell.at("solver") != solver) { continue; }
        ++cases;
        survived += cell.at("survives").get<bool>() ? 1 : 0;
    }
    return std::to_string(survived) + " of " + std::to_string(cases);
}

static std::string figures_part(const ReportContent& content) {
    const bool has_all = !content.comparison.is_null() && !content.speed.is_null() && !content.stability.is_null();
    if (!has_all) { return ""; }
    int frames = 0, unexplained = 0;
    for (const json& each : content.comparison.at("scenes")) {
        frames += each.at("one_step").at("frames").get<int>();
        unexplained += each.at("one_step").at("unexplained_frames").get<int>();
    }
    return "<ul class=\"figures\">\n" +
           figure_item(fixed_cell(content.speed.at("touching_geometric_mean"), 2) + " ×",
                       "speed of btSoftBody in frames in which bodies touch, geometric mean of the scenes, one "
                       "thread") +
           figure_item(std::to_string(unexplained) + " of " + std::to_string(frames),
                       "frames in which one step differs from btSoftBody by more than 1e-5 without a contact that "
                       "only one engine made") +
           figure_item(survivals(content.stability, "position-based"),
                       "extreme cases survived by Pliant's solver of Bullet's method; btSoftBody: " +
                           survivals(content.stability, "btSoftBody")) +
           figure_item(survivals(content.stability, "xpbd"),
                       "survived by XPBD; implicit: " + survivals(content.stability, "implicit")) +
           "</ul>\n";
}

std::string report_page(const ReportContent& content) {
    std::string html = page_head("Pliant: report", report_style);
    html += "<h1>Pliant: report</h1>\n<p>Soft bodies of Pliant beside those of Bullet (btSoftBody), on the same "
            "scenes: looks, agreement, speed, precision, stability and costs, measured on this machine.";
    html += content.is_quick ? " The quick form: some of the scenes and settings.</p>\n" : "</p>\n";
    std::string links, parts;
    const auto add = [&](bool is_there, const char* id, const char* name, const auto& part) {
        if (!is_there) { return; }
        links += std::string("<a href=\"#") + id + "\">" + name + "</a>";
        parts += part();
    };
    add(!content.pictures.empty() || !content.picture_problem.empty(), "scenes", "Scenes",
        [&] { return pictures_part(content); });
    add(!content.comparison.is_null(), "comparison", "Agreement", [&] { return comparison_part(content.comparison); });
    add(!content.speed.is_null(), "speed", "Speed", [&] { return speed_part(content.speed); });
    add(!content.precision.is_null(), "precision", "Error against run time", [&] { return precision_part(content); });
    add(!content.stability.is_null(), "stability", "Stability", [&] { return stability_part(content); });
    add(!content.costs.empty(), "costs", "Costs", [&] { return costs_part(content.costs); });
    const std::vector<ConclusionGroup> groups = conclusions(content);
    add(!groups.empty(), "conclusions", "Conclusions", [&] { return conclusions_part(groups); });
    add(true, "machine", "Machine", [&] { return facts_part(content); });
    return html + "<nav>" + links + "</nav>\n" + figures_part(content) + parts + page_end();
}

} // namespace report
