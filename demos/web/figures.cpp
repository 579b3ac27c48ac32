// What the page tells in words and figures.

#include "page.h"
#include "scenes/scenes.h"

#include <emscripten/emscripten.h>

#include <cstdio>

namespace {

std::string quoted(const std::string& text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') { result += '\\'; }
        result += c;
    }
    return result + "\"";
}

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.9g", value);
    return text;
}

bool is_bullet(const viewer::Run& run) {
    return run.engine->kind() == demos::EngineKind::bullet;
}

const char* self_collision_name(const demos::Engine& engine) {
    static constexpr const char* names[] = {"off", "nodes", "grids", "faces"};
    return names[engine.self_collision()];
}

} // namespace

extern "C" {

// JSON: the scenes of the list.
EMSCRIPTEN_KEEPALIVE const char* web_scenes() {
    static constexpr const char* solvers[] = {"position-based", "implicit", "xpbd"};
    std::string list;
    for (int i = 0; i < scene_count; ++i) {
        const scene& each = *scene_list[i];
        list += (i > 0 ? "," : "") + std::string("{\"name\":") + quoted(each.name) +
                ",\"summary\":" + quoted(each.summary) + ",\"solver\":" + quoted(solvers[each.solver]) +
                ",\"own\":" + (each.is_own ? "true" : "false") +
                ",\"has_resolution\":" + (each.takes_resolution ? "true" : "false") +
                ",\"picture_frame\":" + std::to_string(each.picture_frame) + "}";
    }
    return web::answer("[" + list + "]");
}

// JSON: what the run is made of, and its controls.
EMSCRIPTEN_KEEPALIVE const char* web_facts() {
    const demos::Description& description = web::page().session->description();
    const viewer::Run& run = web::run(0);
    std::string controls, engines;
    for (const viewer::Run& each : web::page().session->runs()) {
        engines += (engines.empty() ? "" : ",") + quoted(is_bullet(each) ? "btSoftBody" : "Pliant");
    }
    const auto& records = description.controls;
    for (size_t i = 0; i < records.size(); ++i) {
        controls += (i > 0 ? "," : "") + std::string("{\"name\":") + quoted(records[i].name) +
                    ",\"low\":" + number(static_cast<double>(records[i].def.low)) +
                    ",\"high\":" + number(static_cast<double>(records[i].def.high)) +
                    ",\"value\":" + number(static_cast<double>(web::page().session->control(i))) + "}";
    }
    return web::answer("{\"solver\":" + quoted(is_bullet(run) ? "btSoftBody" : demos::solver_name(run.solver.kind)) +
                       ",\"substeps\":" + std::to_string(run.solver.substeps) +
                       ",\"iterations\":" + std::to_string(run.solver.iterations) + ",\"engines\":[" + engines +
                       "],\"gravity\":" + number(-static_cast<double>(description.gravity.y)) + ",\"self_collision\":" +
                       quoted(description.has_self_collision ? self_collision_name(*run.engine) : "") +
                       ",\"problem\":" + quoted(web::page().session->message()) + ",\"controls\":[" + controls + "]}");
}

// Ten figures of a run at present; their order is that of engine.js.
EMSCRIPTEN_KEEPALIVE void web_figures(int index, double* figures) {
    const viewer::Run& run = web::run(index);
    const demos::Measures& measures = run.measures;
    const double values[] = {static_cast<double>(web::page().session->frame()),
                             run.engine->step_milliseconds(),
                             run.ms_per_step,
                             measures.max_stretch,
                             measures.rms_speed,
                             measures.kinetic_energy,
                             static_cast<double>(measures.nodes),
                             static_cast<double>(measures.links),
                             static_cast<double>(measures.faces),
                             measures.finite ? 1.0 : 0.0};
    for (const double value : values) {
        *figures++ = value;
    }
}

// 16 hexadecimal digits, as `pliant run` prints them.
EMSCRIPTEN_KEEPALIVE const char* web_hash() {
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(web::run(0).measures.state_hash));
    return web::answer(text);
}
}
