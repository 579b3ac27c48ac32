// pliant stability: extreme cases with btSoftBody and the three solvers; who survives, and how well.

#include "commands.h"
#include "measure/stability/stability.h"
#include "progress.h"
#include "report/csv.h"
#include "report/map_picture.h"
#include "report/output_file.h"
#include "report/table.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <thread>

namespace app {

using demos::Cell;
using demos::StabilityCase;

struct MapRow {
    const StabilityCase* which;
    std::vector<Cell> cells; // by column
};

struct Map {
    std::vector<demos::Column> columns;
    std::vector<MapRow> rows;
};

static std::vector<demos::Column> choose_columns(const std::vector<std::string>& solvers) {
    std::vector<demos::Column> chosen;
    for (const demos::Column column : demos::all_columns) {
        const bool is_named = std::find(solvers.begin(), solvers.end(), column_name(column)) != solvers.end();
        if (solvers.empty() || is_named) { chosen.push_back(column); }
    }
    return chosen;
}

static std::vector<const StabilityCase*> choose_cases(const std::vector<StabilityCase>& all,
                                                      const std::vector<std::string>& groups,
                                                      const std::string& part_of_name) {
    std::vector<const StabilityCase*> chosen;
    std::string known;
    for (const StabilityCase& each : all) {
        if (known.find(each.group) == std::string::npos) { known += (known.empty() ? "" : ", ") + each.group; }
        const bool is_named = std::find(groups.begin(), groups.end(), each.group) != groups.end();
        const bool is_wanted = groups.empty() ? !each.is_asked_for_only : is_named;
        if (is_wanted && each.name.find(part_of_name) != std::string::npos) { chosen.push_back(&each); }
    }
    for (const std::string& group : groups) {
        const bool exists =
            std::any_of(all.begin(), all.end(), [&](const StabilityCase& each) { return each.group == group; });
        if (!exists) { throw demos::Error("there is no group of cases named " + group + "; there are: " + known); }
    }
    if (chosen.empty()) { throw demos::Error("no case has \"" + part_of_name + "\" in its name"); }
    return chosen;
}

static std::string figure_text(const Cell& cell) {
    if (cell.figure < 0.0) { return ""; }
    char text[40];
    std::snprintf(text, sizeof text, "%.2g", cell.figure);
    return text;
}

static std::string cell_text(const Cell& cell) {
    const std::string figure = figure_text(cell);
    return demos::verdict_name(cell.verdict) + (figure.empty() ? "" : " " + figure);
}

static std::string csv_text(const Map& map) {
    std::string text = report::csv_line({"group", "case", "solver", "verdict", "survives", "figure", "value", "note"});
    for (const MapRow& row : map.rows) {
        for (size_t k = 0; k < row.cells.size(); ++k) {
            const Cell& cell = row.cells[k];
            text += report::csv_line({row.which->group, row.which->name, column_name(map.columns[k]),
                                      demos::verdict_name(cell.verdict), is_survival(cell.verdict) ? "1" : "0",
                                      row.which->figure_name, cell.figure < 0.0 ? "" : report::exact(cell.figure),
                                      cell.note});
        }
    }
    return text;
}

static std::string picture(const Map& map) {
    std::vector<std::string> columns;
    for (const demos::Column column : map.columns) {
        columns.push_back(column == demos::Column::bt_soft_body ? "btSoftBody"
                                                                : std::string("Pliant ") + column_name(column));
    }
    std::vector<report::MapRow> shown;
    for (const MapRow& row : map.rows) {
        report::MapRow made{row.which->group, row.which->name, {}};
        for (const Cell& cell : row.cells) {
            const report::Shade shade = cell.verdict == demos::Verdict::survives ? report::Shade::good
                                        : is_survival(cell.verdict)              ? report::Shade::fair
                                                                                 : report::Shade::bad;
            made.cells.push_back({cell_text(cell), cell.note, shade});
        }
        shown.push_back(std::move(made));
    }
    return report::map_picture("Stability: who survives, and how well", columns, shown);
}

static nlohmann::ordered_json to_json(const Map& map) {
    nlohmann::ordered_json cells = nlohmann::ordered_json::array();
    for (const MapRow& row : map.rows) {
        for (size_t k = 0; k < row.cells.size(); ++k) {
            const Cell& cell = row.cells[k];
            cells.push_back(
                {{"group", row.which->group},
                 {"case", row.which->name},
                 {"figure", row.which->figure_name},
                 {"solver", column_name(map.columns[k])},
                 {"verdict", demos::verdict_name(cell.verdict)},
                 {"survives", is_survival(cell.verdict)},
                 {"value", cell.figure < 0.0 ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(cell.figure)},
                 {"note", cell.note}});
        }
    }
    return {{"cells", cells}};
}

static void print_text(const Map& map) {
    std::vector<std::string> headings{"case", "figure"};
    for (const demos::Column column : map.columns) {
        headings.push_back(column_name(column));
    }
    report::Table table(std::move(headings));
    std::string notes;
    std::vector<size_t> survivors(map.columns.size());
    for (const MapRow& row : map.rows) {
        std::vector<std::string> cells{row.which->group + ": " + row.which->name, row.which->figure_name};
        for (size_t k = 0; k < row.cells.size(); ++k) {
            const Cell& cell = row.cells[k];
            cells.push_back(cell_text(cell));
            if (is_survival(cell.verdict)) { ++survivors[k]; }
            if (cell.verdict == demos::Verdict::survives && cell.note.empty()) { continue; }
            notes += row.which->name + ", " + column_name(map.columns[k]) + ": " + demos::verdict_name(cell.verdict) +
                     (cell.note.empty() ? "" : ": " + cell.note) + "\n";
        }
        table.add(std::move(cells));
    }
    std::vector<std::string> sums{"survived", ""};
    for (const size_t count : survivors) {
        sums.push_back(std::to_string(count) + " of " + std::to_string(map.rows.size()));
    }
    table.add(std::move(sums));
    std::cout << table.text() << '\n' << notes;
}

int run_stability(const StabilityOptions& options) {
    namespace fs = std::filesystem;
    demos::StabilityOptions settings;
    if (options.rest_steps > 0) { settings.rest_steps = options.rest_steps; }
    settings.sleeps = !options.awake;
    settings.seed = options.seed;
    settings.random_count = options.random_count;
    settings.columns = choose_columns(options.solvers);
    settings.jobs = options.jobs > 0 ? options.jobs : static_cast<int>(std::thread::hardware_concurrency());
    const std::vector<StabilityCase> all = stability_cases(settings);
    const std::vector<const StabilityCase*> chosen = choose_cases(all, options.groups, options.part_of_name);
    if (!options.folder.empty()) { report::make_folder(options.folder); }
    const auto path = [&](const char* name) {
        return options.folder.empty() ? std::string() : (fs::path(options.folder) / name).string();
    };
    const report::OutputFile csv(path("stability.csv")), svg(path("stability.svg"));
    Map map{settings.columns, {}};
    {
        Progress progress(options.json);
        int done = 0;
        const std::vector<std::vector<Cell>> cells = run_cells(chosen, settings, [&](const StabilityCase& which) {
            progress.start(which.name);
            progress.show(++done, static_cast<int>(chosen.size() * settings.columns.size()), "cell");
        });
        for (size_t i = 0; i < chosen.size(); ++i) {
            map.rows.push_back({chosen[i], cells[i]});
        }
    }
    csv.write(csv_text(map));
    svg.write(picture(map));
    if (options.json) {
        std::cout << to_json(map).dump(2) << '\n';
    } else {
        print_text(map);
    }
    return 0;
}

} // namespace app
