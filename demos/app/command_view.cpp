// pliant view: scenes in a window.

#include "commands.h"
#include "measure/measure.h"
#include "report/output_file.h"
#include "scenes/scene_choice.h"
#include "viewer/viewer.h"

#include <nlohmann/json.hpp>

#include <iostream>

namespace app {

using nlohmann::ordered_json;

static ordered_json vector_json(pli_vec3 v) {
    return {v.x, v.y, v.z};
}

static ordered_json engine_json(const viewer::Run& run, const viewer::Place& place) {
    ordered_json softs = ordered_json::array(), rigids = ordered_json::array();
    for (const demos::SoftState& soft : run.snapshot.softs) {
        pli_vec3 sum = pli_vec3_make(0, 0, 0);
        for (const pli_vec3 position : soft.positions) {
            sum = pli_vec3_add(sum, position);
        }
        softs.push_back(
            {{"nodes", soft.positions.size()},
             {"links", soft.rest_lengths.size()},
             {"faces", soft.face_nodes.size() / 3},
             {"parts", demos::part_count(soft)},
             {"middle", vector_json(pli_vec3_scale(sum, 1.0f / static_cast<float>(soft.positions.size())))}});
    }
    for (const demos::RigidState& rigid : run.snapshot.rigids) {
        rigids.push_back(vector_json(rigid.pose.origin));
    }
    ordered_json node = nullptr;
    if (place.kind == viewer::Place::Kind::node && place.soft < run.engine->soft_count()) {
        node = vector_json(run.engine->node_position(place.soft, place.node));
    }
    return {{"engine", run.engine->name()},
            {"ms_per_step", run.ms_per_step},
            {"kinetic_energy", run.measures.kinetic_energy},
            {"max_stretch", run.measures.max_stretch},
            {"node", node},
            {"softs", softs},
            {"rigids", rigids}};
}

static ordered_json report_json(const viewer::Session& session, const viewer::Place& place) {
    ordered_json engines = ordered_json::array(), controls = ordered_json::object();
    for (const viewer::Run& run : session.runs()) {
        engines.push_back(engine_json(run, place));
    }
    for (size_t i = 0; i < session.description().controls.size(); ++i) {
        controls[session.description().controls[i].name] = session.control(i);
    }
    return {{"scene", session.description().source->name},
            {"frame", session.frame()},
            {"last_frame", session.timeline() != nullptr ? session.timeline()->last() : session.frame()},
            {"message", session.message()},
            {"controls", controls},
            {"engines", engines}};
}

static viewer::Engines engines_of(const std::string& name) {
    return name == "bullet" ? viewer::Engines::bullet
           : name == "both" ? viewer::Engines::both
                            : viewer::Engines::pliant;
}

int run_view(const ViewOptions& options) {
    viewer::ViewerOptions viewer_options;
    viewer_options.first = &demos::choose_scene(options.scene.empty() ? "Cloth" : options.scene);
    viewer_options.meshes = {options.mesh_file, options.tetra_base};
    viewer_options.session.engines = engines_of(options.engine);
    viewer_options.session.engine = engine_options(options.step);
    viewer_options.session.make_timeline = [](demos::PliantEngine& engine) {
        return std::make_unique<viewer::Timeline>(engine);
    };
    viewer_options.width = options.width;
    viewer_options.height = options.height;
    viewer_options.frames = options.frames;
    if (!options.script_file.empty()) { viewer_options.script = viewer::read_script(options.script_file); }
    if (options.frames == 0 && (!options.png_file.empty() || options.json)) {
        throw demos::Error("--png and --json need --frames, after which the window closes");
    }
    const report::OutputFile png(options.png_file);
    ordered_json reports = ordered_json::array();
    viewer_options.report = [&](const viewer::Session& session, const viewer::Place& place) {
        reports.push_back(report_json(session, place));
    };

    viewer::Viewer viewer(viewer_options);
    viewer.run();
    if (options.frames > 0) { png.write(viewer.last_picture().to_png()); }
    if (options.json) {
        reports.push_back(report_json(viewer.session(), {}));
        std::cout << ordered_json{{"reports", reports}}.dump(2) << '\n';
    }
    return 0;
}

} // namespace app
