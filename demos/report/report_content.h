#ifndef DEMOS_REPORT_REPORT_CONTENT_H
#define DEMOS_REPORT_REPORT_CONTENT_H

// What the page of `pliant report` is made from.

#include <nlohmann/json.hpp>

#include <string>
#include <utility>
#include <vector>

namespace report {

struct ReportPicture {
    std::string scene, summary;
    std::string png; // bytes
};

struct ReportPlot {
    std::string scene, svg;
};

struct ReportContent {
    bool is_quick = false;
    std::vector<std::pair<std::string, std::string>> facts;
    std::vector<ReportPicture> pictures;
    std::string picture_problem; // why there are no pictures; empty: there are
    // Of the subcommands; null: not part of the page.
    nlohmann::json comparison, speed, precision, stability;
    std::vector<nlohmann::json> costs; // documents of `run --costs`, by scene; none: not part of the page
    std::vector<ReportPlot> plots;     // in the order of scenes
    std::string stability_svg;
};

} // namespace report
#endif
