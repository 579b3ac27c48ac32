// Steps of a still sheet with contacts of faces, 800 faces: on one box, on a floor of sixteen boxes, and over a ball,
// which is round everywhere, with each kind of solver.

extern "C" {
#include "pliant/pliant.h"
}

#include <benchmark/benchmark.h>

#include <stdexcept>

namespace {

enum class Ground { box, tiles, ball };
enum class Solver { position_based, implicit, xpbd };

void check(pli_status status) {
    if (status != PLI_OK) { throw std::runtime_error(pli_status_string(status)); }
}

void add_static(pli_world* world, pli_shape* shape, pli_vec3 position) {
    pli_rigid_def def = pli_rigid_def_default();
    def.shapes = &shape;
    def.shape_count = 1;
    def.state.pose.origin = position;
    pli_rigid* rigid = nullptr;
    check(pli_rigid_create(world, &def, &rigid));
    pli_shape_release(shape);
}

void add_ground(pli_context* context, pli_world* world, Ground ground) {
    pli_shape* shape = nullptr;
    if (ground == Ground::ball) {
        check(pli_shape_create_sphere(context, 0.5f, &shape));
        add_static(world, shape, pli_vec3_make(0, -0.52f, 0));
        return;
    }
    const int tiles = ground == Ground::tiles ? 4 : 1;
    const float width = 2.2f / static_cast<float>(tiles);
    for (int i = 0; i < tiles * tiles; ++i) {
        check(pli_shape_create_box(context, pli_vec3_make(width / 2, 0.5f, width / 2), &shape));
        const auto column = static_cast<float>(i % tiles), row = static_cast<float>(i / tiles);
        add_static(world, shape, pli_vec3_make((column + 0.5f) * width - 1.1f, -0.5f, (row + 0.5f) * width - 1.1f));
    }
}

pli_body* add_sheet(pli_context* context, pli_world* world, Solver solver) {
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(-1, 0.03f, -1);
    patch.corner_10 = pli_vec3_make(1, 0.03f, -1);
    patch.corner_01 = pli_vec3_make(-1, 0.03f, 1);
    patch.corner_11 = pli_vec3_make(1, 0.03f, 1);
    patch.columns = patch.rows = 21;
    pli_mesh* mesh = nullptr;
    pli_body* body = nullptr;
    check(pli_mesh_create_patch(context, &patch, &mesh));
    check(pli_mesh_set_total_mass(mesh, 1));
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.02f;
    check(pli_body_create(world, mesh, &def, &body));
    pli_mesh_destroy(mesh);
    if (solver == Solver::position_based) { check(pli_body_enable_colored_links(body)); }
    if (solver == Solver::implicit) { check(pli_body_enable_implicit(body, nullptr)); }
    if (solver == Solver::xpbd) {
        check(pli_body_enable_xpbd(body, nullptr));
        check(pli_body_enable_xpbd_links(body, nullptr));
    }
    check(pli_body_enable_rigid_contacts(body, nullptr));
    check(pli_body_enable_rigid_face_contacts(body, nullptr));
    return body;
}

void step(benchmark::State& state, Ground ground, Solver solver) {
    pli_context* context = nullptr;
    pli_world* world = nullptr;
    check(pli_context_create(nullptr, &context));
    check(pli_world_create(context, nullptr, &world));
    add_ground(context, world, ground);
    pli_body* body = add_sheet(context, world, solver);
    for (int i = 0; i < 180; ++i) {
        check(pli_world_step(world, 1.0f / 60.0f));
    }
    for (auto _ : state) {
        check(pli_world_step(world, 1.0f / 60.0f));
    }
    state.counters["face_contacts"] = pli_body_get_rigid_face_contacts(body, 0, nullptr);
    pli_world_destroy(world);
    pli_context_destroy(context);
}

BENCHMARK_CAPTURE(step, box_position_based, Ground::box, Solver::position_based)->Iterations(100);
BENCHMARK_CAPTURE(step, box_implicit, Ground::box, Solver::implicit)->Iterations(100);
BENCHMARK_CAPTURE(step, box_xpbd, Ground::box, Solver::xpbd)->Iterations(100);
BENCHMARK_CAPTURE(step, tiles_position_based, Ground::tiles, Solver::position_based)->Iterations(100);
BENCHMARK_CAPTURE(step, tiles_implicit, Ground::tiles, Solver::implicit)->Iterations(100);
BENCHMARK_CAPTURE(step, tiles_xpbd, Ground::tiles, Solver::xpbd)->Iterations(100);
BENCHMARK_CAPTURE(step, ball_implicit, Ground::ball, Solver::implicit)->Iterations(100);
BENCHMARK_CAPTURE(step, ball_xpbd, Ground::ball, Solver::xpbd)->Iterations(100);

} // namespace

BENCHMARK_MAIN();
