// pliant report: one page of everything that the other subcommands measure. Each is run as it is, and the page is made
// from the JSON document that it prints and from the pictures that it writes.

#include "commands.h"
#include "engines/bullet_memory.h"
#include "render/picture.h"
#include "report/machine_facts.h"
#include "report/output_file.h"
#include "report/report_page.h"
#include "scenes/scene_choice.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <iostream>
#include <sstream>

namespace app {

namespace fs = std::filesystem;
using nlohmann::json;

static constexpr int report_panel_width = 640, report_panel_height = 480;
static constexpr int quick_rest_steps = 1000, quick_comparison_frames = 120;

// What of everything is measured.
struct ReportPlan {
    std::vector<std::string> scenes, precision_scenes, stability_groups; // the latter two: none means all
    int comparison_frames, rest_steps;
};

// Without the group of cases that holds the one in which btSoftBody hangs until its time is over, and without long
// steps, which take longest.
static const ReportPlan quick_plan = {
    {"Bunny", "RopeAttach", "TetraBunny", "Cutting1"},
    {"rope", "sheet"},
    {"stiffness", "mass ratio", "coordinates", "gravity", "impact", "contact", "rest", "input"},
    quick_comparison_frames,
    quick_rest_steps};
static const ReportPlan full_plan = {{"all"}, {}, {}, 300, 0};

// ------------------------------------------------------------------------------------- output of other subcommands

// Takes what is written to stdout while it lives.
class CaughtOutput {
public:
    CaughtOutput() : before_(std::cout.rdbuf(text_.rdbuf())) {}
    ~CaughtOutput() { std::cout.rdbuf(before_); }
    CaughtOutput(const CaughtOutput&) = delete;
    CaughtOutput& operator=(const CaughtOutput&) = delete;

    std::string text() const { return text_.str(); }

private:
    std::ostringstream text_;
    std::streambuf* before_;
};

// The document that a subcommand prints; it is kept in a file too, when one is named.
static json document_of(const std::function<void()>& command, const fs::path& file = "") {
    std::string text;
    {
        const CaughtOutput output;
        command();
        text = output.text();
    }
    if (!file.empty()) { report::OutputFile(file.string()).write(text); }
    return json::parse(text);
}

static std::string file_text(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    if (!file) { throw demos::Error(path.string() + " cannot be read"); }
    return text.str();
}

// ---------------------------------------------------------------------------------------------------- pictures

static render::Snapshot snapshot_of(demos::EngineKind kind, const demos::Description& description, int frames) {
    const std::unique_ptr<demos::Engine> engine = demos::make_engine(kind, description, {});
    for (int frame = 0; frame < frames; ++frame) {
        engine->step();
    }
    return render::take_snapshot(*engine);
}

static void draw_pictures(const std::vector<const scene*>& scenes, report::ReportContent& content) {
    std::unique_ptr<render::Painter> painter;
    try {
        painter = std::make_unique<render::Painter>();
    } catch (const demos::Error& error) {
        content.picture_problem = error.what();
        return;
    }
    for (const scene* which : scenes) {
        const std::unique_ptr<demos::Description> description = demos::Description::build(*which, {});
        const int frames = std::max(which->picture_frame, 1);
        const render::Snapshot pliant = snapshot_of(demos::EngineKind::pliant, *description, frames);
        const render::Snapshot bullet = snapshot_of(demos::EngineKind::bullet, *description, frames);
        const std::string detail = "frame " + std::to_string(frames);
        content.pictures.push_back({which->name, which->summary,
                                    painter
                                        ->draw({{&pliant, "Pliant", detail}, {&bullet, "Bullet (btSoftBody)", detail}},
                                               report_panel_width, report_panel_height)
                                        .to_png()});
    }
}

// ------------------------------------------------------------------------------------------------ measurements

static json comparison_of(const ReportPlan& plan, const fs::path& data) {
    CompareOptions options;
    options.scenes = plan.scenes;
    options.frames = plan.comparison_frames;
    options.json = true;
    return document_of([&] { run_compare(options); }, data / "compare.json");
}

static json speed_of(const ReportPlan& plan, const fs::path& data) {
    BenchOptions options;
    options.scenes = plan.scenes;
    options.is_quick = options.json = true;
    options.frames = 300; // until what falls has landed
    return document_of([&] { run_bench(options); }, data / "bench.json");
}

static void measure_precision(const ReportPlan& plan, const fs::path& data, report::ReportContent& content) {
    WorkprecOptions options;
    options.scenes = plan.precision_scenes;
    options.is_quick = options.json = true;
    options.folder = data.string();
    content.precision = document_of([&] { run_workprec(options); }, data / "workprec.json");
    for (const json& each : content.precision.at("scenes")) {
        const std::string name = each.at("scene");
        for (const json& metric : each.at("metrics")) {
            const std::string id = metric.at("id");
            content.plots.push_back({name, file_text(data / ("workprec_" + name + "_" + id + ".svg"))});
        }
    }
}

static void measure_stability(const ReportPlan& plan, const fs::path& data, report::ReportContent& content) {
    StabilityOptions options;
    options.groups = plan.stability_groups;
    options.rest_steps = plan.rest_steps;
    options.folder = data.string();
    options.json = true;
    content.stability = document_of([&] { run_stability(options); }, data / "stability.json");
    content.stability_svg = file_text(data / "stability.svg");
}

static void measure_costs(const std::vector<const scene*>& scenes, const fs::path& data,
                          report::ReportContent& content) {
    for (const scene* which : scenes) {
        RunOptions options;
        options.scene = which->name;
        options.has_costs = options.json = true;
        content.costs.push_back(document_of([&] { run_scene(options); }));
    }
    report::OutputFile((data / "costs.json").string()).write(json{{"scenes", content.costs}}.dump(2) + "\n");
    report::OutputFile((data / "costs.md").string()).write(report::costs_markdown(content.costs));
}

int run_report(const ReportOptions& options) {
    const ReportPlan& plan = options.is_quick ? quick_plan : full_plan;
    const std::vector<const scene*> scenes = demos::choose_scenes(plan.scenes);
    report::make_folder(options.folder);
    const fs::path folder = fs::canonical(options.folder), data = folder / "data";
    report::make_folder(data);
    const report::OutputFile page((folder / "index.html").string());
    demos::count_bullet_memory(); // before Bullet allocates anything
    report::ReportContent content;
    content.is_quick = options.is_quick;
    content.facts = report::machine_facts();
    const auto is_wanted = [&](const std::string& part) {
        const std::vector<std::string>& wanted = options.parts;
        return wanted.empty() || std::find(wanted.begin(), wanted.end(), part) != wanted.end();
    };
    const std::pair<const char*, std::function<void()>> parts[] = {
        {"pictures", [&] { draw_pictures(scenes, content); }},
        {"comparison", [&] { content.comparison = comparison_of(plan, data); }},
        {"speed", [&] { content.speed = speed_of(plan, data); }},
        {"precision", [&] { measure_precision(plan, data, content); }},
        {"stability", [&] { measure_stability(plan, data, content); }},
        {"costs", [&] { measure_costs(scenes, data, content); }},
    };
    int number = 0;
    for (const auto& [name, measure] : parts) {
        ++number;
        if (!is_wanted(name)) { continue; }
        std::cerr << "[" << number << "/" << std::size(parts) << "] " << name << std::endl;
        measure();
    }
    page.write(report::report_page(content));
    std::cout << "Open this page:\n" << page.path().string() << '\n';
    return 0;
}

} // namespace app
