// Scenes of growing size: a sheet held at its corners, a ball of air on the ground, many small balls; and what threads
// are measured on: large cloth under each solver, crowds.

#include "bench.h"
#include "scenes/scenes.h"

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

// Structural and shear links, 5 cm apart. Two opposite corners are higher than the others by `twist` m.
void add_sheet(scene_builder* builder, int columns, int pins, float twist, const scene_soft_def& def) {
    const float half = 0.025f * static_cast<float>(columns - 1);
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(-half, twist, -half);
    patch.corner_10 = pli_vec3_make(half, 0, -half);
    patch.corner_01 = pli_vec3_make(-half, 0, half);
    patch.corner_11 = pli_vec3_make(half, twist, half);
    patch.columns = patch.rows = columns;
    patch.pins = pins;
    patch.diagonals = true;
    pli_mesh* mesh = nullptr;
    if (!scene_check(builder, pli_mesh_create_patch(scene_context(builder), &patch, &mesh))) { return; }
    scene_check(builder, pli_mesh_set_total_mass(mesh, 0.001f * static_cast<float>(columns * columns)));
    scene_add_soft(builder, mesh, &def);
}

template <int columns> void build_sheet(scene_builder* builder) {
    scene_soft_def def = series_def();
    def.name = "sheet";
    add_sheet(builder, columns, PLI_PATCH_PIN_CORNERS, 0, def);
}

// Bent, around a ball of a quarter of its width.
template <int columns> void build_drape(scene_builder* builder) {
    const float radius = 0.0125f * static_cast<float>(columns);
    scene_rigid_def ball = scene_rigid_def_default();
    ball.name = "ball";
    ball.shape = scene_sphere(radius);
    ball.pose.origin = pli_vec3_make(0, 0, 0);
    scene_add_rigid(builder, &ball);
    scene_soft_def def = series_def();
    def.name = "sheet";
    def.collision_margin = 0.025f;
    add_sheet(builder, columns, 0, 2 * radius, def);
}

// Flags of 30 by 20 nodes beside each other, held along one edge.
template <int count> void build_flags(scene_builder* builder) {
    constexpr float length = 1.5f, height = 1.0f, apart = 2.5f;
    scene_soft_def def = series_def();
    def.name = "flag";
    def.collision_margin = 0.02f;
    def.aero.model = PLI_AERO_VERTEX_TWO_SIDED;
    def.aero.lift = 0.1f;
    def.aero.drag = 0.02f;
    def.aero.wind = pli_vec3_make(6, 0, 1);
    for (int i = 0; i < count; ++i) {
        const float x = apart * static_cast<float>(i % 10), z = apart * static_cast<float>(i / 10);
        pli_patch_def patch = pli_patch_def_default();
        patch.corner_00 = pli_vec3_make(x, height, z);
        patch.corner_10 = pli_vec3_make(x + length, height, z);
        patch.corner_01 = pli_vec3_make(x, 0, z);
        patch.corner_11 = pli_vec3_make(x + length, 0, z);
        patch.columns = 30;
        patch.rows = 20;
        patch.diagonals = true;
        pli_mesh* mesh = nullptr;
        if (!scene_check(builder, pli_mesh_create_patch(scene_context(builder), &patch, &mesh))) { return; }
        scene_check(builder, pli_mesh_set_total_mass(mesh, 0.5f));
        for (int row = 0; row < patch.rows; ++row) {
            scene_check(builder, pli_mesh_set_node_mass(mesh, row * patch.columns, 0));
        }
        scene_add_soft(builder, mesh, &def);
    }
}

// Heaps of four that fall on each other.
template <int count> void build_tori(scene_builder* builder) {
    add_ground(builder);
    scene_soft_def def = series_def();
    def.name = "torus";
    def.collision_margin = 0.05f;
    def.solver.position_iterations = 4;
    def.has_soft_contacts = true;
    for (int i = 0; i < count; ++i) {
        pli_mesh* mesh = scene_triangle_mesh(builder, "torus");
        scene_check(builder, pli_mesh_append_bending_links(mesh, 2, 0, nullptr));
        scene_check(builder, pli_mesh_shuffle_links(mesh));
        const int heap = i / 4;
        const pli_vec3 at = pli_vec3_make(6 * static_cast<float>(heap % 4), 0.6f + 1.15f * static_cast<float>(i % 4),
                                          6 * static_cast<float>(heap / 4));
        scene_check(builder, pli_mesh_transform(mesh, {pli_mat3_identity(), at}));
        scene_check(builder, pli_mesh_set_total_mass_from_faces(mesh, 10));
        scene_add_soft(builder, mesh, &def);
    }
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

// Balls beside each other, their centres at a height of so many centimetres.
template <int count, int height> void build_bodies(scene_builder* builder) {
    add_ground(builder);
    const int columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
    for (int i = 0; i < count; ++i) {
        const float x = static_cast<float>(i % columns), z = static_cast<float>(i / columns);
        add_ball(builder, pli_vec3_make(3 * x, 0.01f * static_cast<float>(height), 3 * z), 1, 100, 20);
    }
}

BenchSize make_size(const char* name, void (*build)(scene_builder*), int frames = 0) {
    BenchSize size;
    size.which.name = name;
    size.which.summary = "";
    size.which.build = build;
    size.frames = frames;
    return size;
}

// Until it lies in folds.
BenchSize make_fold(const char* name, scene_self_collision self_collision) {
    BenchSize size;
    size.which = scene_folding_cloth;
    size.which.name = name;
    size.scene_options.self_collision = self_collision;
    size.scene_options.resolution = {100, 100};
    size.frames = 180;
    return size;
}

SolverOptions solver_options(SolverKind kind, pli_implicit_method method = PLI_IMPLICIT_JACOBI) {
    SolverOptions options;
    options.kind = kind;
    options.implicit_method = method;
    return options;
}

} // namespace

const std::vector<BenchSeries>& bench_series() {
    const auto make_all = [] {
        const std::vector<BenchSize> sheets = {make_size("sheet 64", build_sheet<64>),
                                               make_size("sheet 128", build_sheet<128>)};
        constexpr int touching = 102, high = 1000, crowd_frames = 30;
        const std::vector<BenchSize> crowds = {make_size("falling 1000", build_bodies<1000, high>, crowd_frames),
                                               make_size("resting 1000", build_bodies<1000, touching>, crowd_frames)};
        return std::vector<BenchSeries>{
            {"sheet",
             {make_size("sheet 32", build_sheet<32>), make_size("sheet 64", build_sheet<64>),
              make_size("sheet 128", build_sheet<128>), make_size("sheet 256", build_sheet<256>),
              make_size("sheet 512", build_sheet<512>), make_size("sheet 1024", build_sheet<1024>)}},
            {"sphere",
             {make_size("sphere 1000", build_sphere<1000>), make_size("sphere 5000", build_sphere<5000>),
              make_size("sphere 20000", build_sphere<20000>), make_size("sphere 50000", build_sphere<50000>),
              make_size("sphere 200000", build_sphere<200000>)}},
            {"bodies",
             {make_size("bodies 1", build_bodies<1, 110>), make_size("bodies 10", build_bodies<10, 110>),
              make_size("bodies 100", build_bodies<100, 110>), make_size("bodies 1000", build_bodies<1000, 110>)}},
            {"crowd", crowds},
            {"crowd-xpbd", crowds, solver_options(SolverKind::xpbd)},
            {"flags", {make_size("flags 50", build_flags<50>, 60)}},
            {"tori", {make_size("tori 64", build_tori<64>, 90)}},
            {"fold", {make_fold("fold nodes", SCENE_SELF_NODES), make_fold("fold faces", SCENE_SELF_FACES)}},
            {"jacobi", sheets, solver_options(SolverKind::implicit)},
            {"gradients", sheets, solver_options(SolverKind::implicit, PLI_IMPLICIT_CONJUGATE_GRADIENT)},
            {"drape",
             {make_size("drape 128", build_drape<128>, 60), make_size("drape 256", build_drape<256>, 60)},
             solver_options(SolverKind::xpbd)},
        };
    };
    static const std::vector<BenchSeries> all = make_all();
    return all;
}

const BenchSeries& find_bench_series(const std::string& name) {
    const std::vector<BenchSeries>& all = bench_series();
    const auto found = std::find_if(all.begin(), all.end(), [&](const auto& one) { return one.name == name; });
    if (found != all.end()) { return *found; }
    std::string names;
    for (const BenchSeries& one : all) {
        names += (names.empty() ? "" : ", ") + one.name;
    }
    throw Error("no series " + name + "; there are " + names);
}

BenchOptions series_options(const BenchSeries& series, const BenchSize& size, const Description& description,
                            bool is_quick) {
    int nodes = 0;
    for (const SoftRecord& soft : description.softs) {
        nodes += pli_mesh_get_view(soft.mesh.get()).node_count;
    }
    constexpr int most_bullet_nodes = 300000;
    BenchOptions options;
    options.frames =
        size.frames > 0 ? size.frames : std::clamp((is_quick ? 200000 : 2000000) / std::max(nodes, 1), 4, 60);
    options.settled_frames = 0;
    options.rounds = is_quick || nodes > 100000 ? 1 : 2;
    options.with_reference = false;
    options.with_bullet = nodes <= most_bullet_nodes && !series.solver.kind.has_value() &&
                          size.which.solver == SCENE_SOLVER_POSITION_BASED;
    options.solver = series.solver;
    return options;
}

} // namespace demos
