// Opening, stepping and touching a scene. A call that can fail returns words, which are empty when it did not.

#include "page.h"

#include "render/bodies.h"
#include "scenes/scene_choice.h"

#include <emscripten/emscripten.h>

namespace web {

Page& page() {
    static Page only;
    return only;
}

const char* answer(const std::string& text) {
    page().text = text;
    return page().text.c_str();
}

render::View view_of_all(std::vector<render::Extent>& extents) {
    for (const viewer::Run& run : page().session->runs()) {
        extents.push_back(render::measure_extent(run.snapshot));
    }
    return render::make_view(extents);
}

static void set_camera(float aspect) {
    std::vector<render::Extent> extents;
    const render::View view = view_of_all(extents);
    page().orbit.look_from(render::choose_camera(page().session->description(), view, aspect));
}

static viewer::SessionOptions read_options(const std::string& solver, int substeps, int iterations, bool is_beside) {
    viewer::SessionOptions options;
    options.engines = solver == "btSoftBody" ? viewer::Engines::bullet
                      : is_beside            ? viewer::Engines::both
                                             : viewer::Engines::pliant;
    for (const demos::SolverKind kind :
         {demos::SolverKind::position_based, demos::SolverKind::implicit, demos::SolverKind::xpbd}) {
        if (solver == demos::solver_name(kind)) { options.engine.solver.kind = kind; }
    }
    if (substeps > 0) { options.engine.solver.substeps = substeps; }
    if (iterations > 0) { options.engine.solver.iterations = iterations; }
    return options;
}

static demos::SceneOptions read_scene_options(const std::string& self_collision, int columns) {
    static constexpr struct {
        const char* name;
        scene_self_collision kind;
    } kinds[] = {{"off", SCENE_SELF_NONE},
                 {"nodes", SCENE_SELF_NODES},
                 {"grids", SCENE_SELF_GRIDS},
                 {"faces", SCENE_SELF_FACES}};
    demos::SceneOptions options;
    for (const auto& kind : kinds) {
        if (self_collision == kind.name) { options.self_collision = kind.kind; }
    }
    options.resolution.columns = columns;
    return options;
}

} // namespace web

extern "C" {

// `solver`: a name of demos::solver_name, btSoftBody, or empty for the scene's own; 0 substeps, iterations or columns
// and an empty self-collision: its own. `is_beside`: btSoftBody beside Pliant.
EMSCRIPTEN_KEEPALIVE const char* web_open(const char* name, const char* solver, int substeps, int iterations,
                                          const char* self_collision, int columns, int is_beside, float aspect) {
    using namespace web;
    try {
        auto opened =
            std::make_unique<viewer::Session>(demos::choose_scene(name), read_scene_options(self_collision, columns),
                                              read_options(solver, substeps, iterations, is_beside != 0));
        page().drag = {};
        page().cut = {};
        page().session = std::move(opened);
        page().session->take_snapshots(page().look);
        set_camera(aspect);
    } catch (const std::exception& error) { return answer(error.what()); }
    return answer("");
}

EMSCRIPTEN_KEEPALIVE const char* web_step() {
    web::page().session->step();
    return web::page().session->message().c_str();
}

EMSCRIPTEN_KEEPALIVE void web_show_all(float aspect) {
    web::set_camera(aspect);
}

EMSCRIPTEN_KEEPALIVE void web_turn(float right, float down) {
    web::page().orbit.turn(right, down);
}

EMSCRIPTEN_KEEPALIVE void web_pan(float right, float down, int height) {
    web::page().orbit.pan(right, down, height);
}

EMSCRIPTEN_KEEPALIVE void web_zoom(float steps) {
    web::page().orbit.zoom(steps);
}

// m/s^2, downwards.
EMSCRIPTEN_KEEPALIVE void web_set_gravity(float gravity) {
    web::page().session->for_each(
        [&](demos::Engine& engine, size_t) { engine.set_gravity(pli_vec3_make(0, -gravity, 0)); });
}

EMSCRIPTEN_KEEPALIVE void web_set_look(int wireframe, int contacts, int clusters) {
    render::Look& look = web::page().look;
    look.wireframe = wireframe != 0;
    look.contacts = contacts != 0;
    look.clusters = clusters != 0;
    if (web::page().session != nullptr) { web::page().session->take_snapshots(look); }
}

// Places of the pointer are -1 to 1 from left to right and from bottom to top.
static viewer::Ray ray_at(float across, float up, float aspect) {
    return viewer::ray_through(web::page().orbit.camera(aspect), across, up);
}

// 1 when a body is held then.
EMSCRIPTEN_KEEPALIVE int web_grab(float across, float up, float aspect) {
    web::Page& page = web::page();
    const render::Camera camera = page.orbit.camera(aspect);
    return page.drag.begin(*page.session, camera, ray_at(across, up, aspect), 0.02f * camera.distance) ? 1 : 0;
}

EMSCRIPTEN_KEEPALIVE void web_pull(float across, float up, float aspect) {
    web::Page& page = web::page();
    if (page.drag.is_active()) { page.drag.move(*page.session, ray_at(across, up, aspect)); }
}

EMSCRIPTEN_KEEPALIVE void web_let_go() {
    web::Page& page = web::page();
    if (page.drag.is_active()) { page.drag.end(*page.session); }
}

EMSCRIPTEN_KEEPALIVE void web_begin_cut(float across, float up, float aspect) {
    web::page().cut.begin(ray_at(across, up, aspect));
}

EMSCRIPTEN_KEEPALIVE const char* web_cut(float across, float up, float aspect) {
    web::Page& page = web::page();
    page.session->set_message("");
    page.cut.move(*page.session, ray_at(across, up, aspect));
    return page.session->message().c_str();
}

EMSCRIPTEN_KEEPALIVE const char* web_shoot(float across, float up, float aspect) {
    web::Page& page = web::page();
    page.session->set_message("");
    const render::Camera camera = page.orbit.camera(aspect);
    viewer::shoot_ball(*page.session, camera, ray_at(across, up, aspect), viewer::usual_ball(camera));
    return page.session->message().c_str();
}

EMSCRIPTEN_KEEPALIVE void web_set_control(int index, float value) {
    web::page().session->set_control(static_cast<size_t>(index), value);
}

// Where the camera sees a node; 0: behind itself.
EMSCRIPTEN_KEEPALIVE int web_node_place(int soft, int node, float aspect, float* place) {
    const pli_vec3 at = web::run(0).engine->node_position(soft, node);
    return viewer::place_of(web::page().orbit.camera(aspect), at, place[0], place[1]) ? 1 : 0;
}
}
