// Scenes of growing size: a sheet held at its corners, a ball of air on the ground, many small balls.

#include "bench.h"

#include <algorithm>
#include <cmath>

namespace demos {

namespace {

constexpr int series_iterations = 10;

scene_soft_def series_def() {
    scene_soft_def def = scene_soft_def_default();
    def.solver.position_iterations = series_iterations;
    return def;
}

void add_ground(scene_builder* builder) {
    const scene_rigid_def def = scene_rigid_box("ground", pli_vec3_make(500, 1, 500), 0, pli_vec3_make(0, -1, 0));
    scene_add_rigid(builder, &def);
}

// Structural and shear links, 5 cm apart.
template <int columns> void build_sheet(scene_builder* builder) {
    const float half = 0.025f * static_cast<float>(columns - 1);
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(-half, 0, -half);
    patch.corner_10 = pli_vec3_make(half, 0, -half);
    patch.corner_01 = pli_vec3_make(-half, 0, half);
    patch.corner_11 = pli_vec3_make(half, 0, half);
    patch.columns = patch.rows = columns;
    patch.pins = PLI_PATCH_PIN_CORNERS;
    patch.diagonals = true;
    pli_mesh* mesh = nullptr;
    if (!scene_check(builder, pli_mesh_create_patch(scene_context(builder), &patch, &mesh))) { return; }
    scene_check(builder, pli_mesh_set_total_mass(mesh, 0.001f * static_cast<float>(columns * columns)));
    scene_soft_def def = series_def();
    def.name = "sheet";
    scene_add_soft(builder, mesh, &def);
}

void add_ball(scene_builder* builder, pli_vec3 center, float radius, int nodes, float pressure) {
    pli_mesh* mesh = nullptr;
    const pli_vec3 radii = pli_vec3_make(radius, radius, radius);
    if (!scene_check(builder, pli_mesh_create_ellipsoid(scene_context(builder), center, radii, nodes, &mesh))) {
        return;
    }
    scene_check(builder, pli_mesh_set_total_mass(mesh, 1));
    scene_soft_def def = series_def();
    def.name = "ball";
    def.collision_margin = 0.05f;
    def.pressure = pressure;
    scene_add_soft(builder, mesh, &def);
}

template <int nodes> void build_sphere(scene_builder* builder) {
    add_ground(builder);
    add_ball(builder, pli_vec3_make(0, 1.1f, 0), 1, nodes, 20);
}

template <int count> void build_bodies(scene_builder* builder) {
    add_ground(builder);
    const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
    for (int i = 0; i < count; ++i) {
        const float x = static_cast<float>(i % columns), z = static_cast<float>(i / columns);
        add_ball(builder, pli_vec3_make(3 * x, 1.1f, 3 * z), 1, 100, 20);
    }
}

scene make_scene(const char* name, void (*build)(scene_builder*)) {
    scene made{};
    made.name = name;
    made.summary = "";
    made.build = build;
    return made;
}

} // namespace

const std::vector<BenchSeries>& bench_series() {
    static const std::vector<BenchSeries> all = {
        {"sheet",
         {make_scene("sheet 32", build_sheet<32>), make_scene("sheet 64", build_sheet<64>),
          make_scene("sheet 128", build_sheet<128>), make_scene("sheet 256", build_sheet<256>),
          make_scene("sheet 512", build_sheet<512>), make_scene("sheet 1024", build_sheet<1024>)}},
        {"sphere",
         {make_scene("sphere 1000", build_sphere<1000>), make_scene("sphere 5000", build_sphere<5000>),
          make_scene("sphere 20000", build_sphere<20000>), make_scene("sphere 50000", build_sphere<50000>),
          make_scene("sphere 200000", build_sphere<200000>)}},
        {"bodies",
         {make_scene("bodies 1", build_bodies<1>), make_scene("bodies 10", build_bodies<10>),
          make_scene("bodies 100", build_bodies<100>), make_scene("bodies 1000", build_bodies<1000>)}},
    };
    return all;
}

BenchOptions series_options(const Description& description, bool is_quick) {
    int nodes = 0;
    for (const SoftRecord& soft : description.softs) {
        nodes += pli_mesh_get_view(soft.mesh.get()).node_count;
    }
    constexpr int most_bullet_nodes = 300000;
    BenchOptions options;
    options.frames = std::clamp((is_quick ? 200000 : 2000000) / std::max(nodes, 1), 4, 60);
    options.settled_frames = 0;
    options.rounds = is_quick || nodes > 100000 ? 1 : 2;
    options.with_reference = false;
    options.with_bullet = nodes <= most_bullet_nodes;
    return options;
}

} // namespace demos
