// pliant demo: four scenes on both engines, side by side, as a page of pictures with a table.

#include "commands.h"
#include "measure/compare.h"
#include "measure/measure.h"
#include "measure/statistics.h"
#include "progress.h"
#include "render/picture.h"
#include "report/demo_page.h"
#include "report/output_file.h"
#include "report/table.h"
#include "scenes/scene_choice.h"

#include <algorithm>
#include <cctype>
#include <iostream>

namespace app {

static constexpr int panel_width = 800, panel_height = 720;
static constexpr const char* demo_scenes[] = {"Bunny", "RopeAttach", "TetraBunny", "Cutting1"};

struct DemoRun {
    render::Snapshot snapshot; // at the frame of the picture
    double ms_per_step = 0;
    int nodes = 0;
};

static DemoRun run_engine(demos::EngineKind kind, const demos::Description& description, int frames, int picture_frame,
                          Progress& progress) {
    const std::unique_ptr<demos::Engine> engine = demos::make_engine(kind, description, {});
    progress.start(std::string(description.source->name) + " on " + engine->name());
    DemoRun run;
    std::vector<double> milliseconds;
    for (int frame = 1; frame <= frames; ++frame) {
        engine->step();
        milliseconds.push_back(engine->step_milliseconds());
        if (frame == picture_frame) { run.snapshot = render::take_snapshot(*engine); }
        progress.show(frame, frames);
    }
    const demos::Measures measures = demos::measure(*engine);
    if (!measures.finite) {
        throw demos::Error(std::string(description.source->name) + " on " + engine->name() + " does not stay finite");
    }
    run.ms_per_step = demos::median(std::move(milliseconds));
    run.nodes = measures.nodes;
    return run;
}

static std::string lower_case(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

static std::string time_text(double milliseconds) {
    return report::fixed(milliseconds, 3) + " ms per step";
}

int run_demo(const DemoOptions& options) {
    namespace fs = std::filesystem;
    std::vector<const scene*> scenes;
    for (const char* name : demo_scenes) {
        scenes.push_back(&demos::choose_scene(name));
    }
    report::make_folder(options.folder);
    const fs::path folder = fs::canonical(options.folder);
    const report::OutputFile page(folder / "index.html");
    std::vector<report::DemoPicture> pictures;
    std::vector<report::OutputFile> files;
    for (const scene* which : scenes) {
        pictures.push_back({which->name, which->summary, lower_case(which->name) + ".png"});
        files.emplace_back(folder / pictures.back().file);
    }

    const render::Painter painter;
    report::Table table(
        {"scene", "nodes", "Pliant ms", "Bullet ms", "ratio", "error median", "error p99", "bit-equal"});
    Progress progress(false);
    for (size_t i = 0; i < scenes.size(); ++i) {
        const scene& which = *scenes[i];
        progress.clear();
        std::cerr << "[" << i + 1 << "/" << scenes.size() << "] " << which.name << std::endl;
        const std::unique_ptr<demos::Description> description = demos::Description::build(which, {});
        const int picture_frame = std::clamp(which.picture_frame, 1, options.frames);
        const DemoRun pliant =
            run_engine(demos::EngineKind::pliant, *description, options.frames, picture_frame, progress);
        const DemoRun bullet =
            run_engine(demos::EngineKind::bullet, *description, options.frames, picture_frame, progress);
        progress.start(std::string(which.name) + ", one step at a time");
        const demos::OneStep one_step = demos::compare_one_step(
            *description, options.frames, [&](int frame, int frames) { progress.show(frame, frames); });
        files[i].write(painter
                           .draw({{&pliant.snapshot, "Pliant", time_text(pliant.ms_per_step)},
                                  {&bullet.snapshot, "Bullet (btSoftBody)", time_text(bullet.ms_per_step)}},
                                 panel_width, panel_height)
                           .to_png());
        table.add({which.name, std::to_string(pliant.nodes), report::fixed(pliant.ms_per_step, 3),
                   report::fixed(bullet.ms_per_step, 3),
                   pliant.ms_per_step > 0.0 ? report::fixed(bullet.ms_per_step / pliant.ms_per_step, 2) : "-",
                   report::short_error(one_step.median), report::short_error(one_step.p99),
                   report::fixed(100.0 * one_step.bit_equal_share, 1) + "%"});
    }
    progress.clear();
    const std::string notes =
        "Times: median per step of 1/60 s, " + std::to_string(options.frames) +
        " frames, with the rigid bodies. Ratio: time of Bullet / time of Pliant. Error: of one step "
        "from the same state, as a share of the size of the soft bodies.";
    page.write(report::demo_page(pictures, table, notes));
    std::cout << '\n' << table.text() << '\n' << notes << "\n\nOpen this page:\n" << page.path().string() << '\n';
    return 0;
}

} // namespace app
