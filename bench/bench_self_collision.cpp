// Self-collision of nodes: the miss rate of two shifted grids against the complete search in a table, then the cost per
// node of the hashed search and of whole steps, and of frames of cloth under XPBD.

#include <pliant/pliant.h>

extern "C" {
#include "geometry/spatial_hash.h"
}

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace {

pli_context* make_context() {
    pli_context* context = nullptr;
    pli_context_create(nullptr, &context);
    return context;
}

class Random {
public:
    float unit() {
        state_ = state_ * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        return static_cast<float>(state_ >> 40) / 16777216.0f;
    }

private:
    uint64_t state_ = 1;
};

constexpr float spacing = 0.01f;

// A sheet in folds: layers a spacing apart, joined by bends.
std::vector<pli_vec3> folded_sheet(int columns, int rows, int per_layer) {
    std::vector<pli_vec3> points;
    Random random;
    for (int y = 0; y < rows; ++y) {
        const int layer = y / per_layer, along = y % per_layer;
        const int place = layer % 2 == 0 ? along : per_layer - 1 - along;
        for (int x = 0; x < columns; ++x) {
            const pli_vec3 noise = pli_vec3_make(random.unit(), random.unit(), random.unit());
            const pli_vec3 point =
                pli_vec3_make(spacing * static_cast<float>(x), 0.9f * spacing * static_cast<float>(layer),
                              spacing * static_cast<float>(place));
            points.push_back(pli_vec3_add(point, pli_vec3_scale(noise, 0.2f * spacing)));
        }
    }
    return points;
}

std::vector<pli_vec3> folded_sheet_of(int count) {
    const int side = static_cast<int>(std::lround(std::sqrt(count)));
    return folded_sheet(side, count / side, 25);
}

std::vector<pli_vec3> random_points(int count, float size) {
    std::vector<pli_vec3> points;
    Random random;
    for (int i = 0; i < count; ++i) {
        points.push_back(pli_vec3_make(size * random.unit(), size * random.unit(), size * random.unit()));
    }
    return points;
}

// ---- what two grids miss

void free_hash(pli_context* context, plii_spatial_hash* hash) {
    PLII_RELEASE(context, hash->starts, hash->start_capacity);
    PLII_RELEASE(context, hash->cells, hash->cell_capacity);
    PLII_RELEASE(context, hash->nodes, hash->node_capacity);
    PLII_RELEASE(context, hash->columns, hash->column_capacity);
    PLII_RELEASE(context, hash->components, hash->component_capacity);
}

// Pairs that lie in no common cell of the two grids, of all nearer than `distance`.
void print_miss_rate(const char* name, const std::vector<pli_vec3>& points, float distance) {
    const int count = static_cast<int>(points.size());
    pli_context* context = make_context();
    plii_spatial_hash all = {}, grids[2] = {{}, {}};
    plii_node_pairs pairs = {};
    plii_spatial_hash_build(context, &all, count, points.data(), distance, 0.0f);
    for (int g = 0; g < 2; ++g) {
        plii_spatial_hash_build(context, &grids[g], count, points.data(), distance,
                                0.5f * distance * static_cast<float>(g));
    }
    int missed = 0, missed_near = 0, near = 0;
    for (int i = 0; i < count; ++i) {
        const size_t a = static_cast<size_t>(i);
        int k = pairs.count;
        plii_spatial_hash_find(context, &all, i, points[a], distance, &pairs);
        for (; k < pairs.count; ++k) {
            const plii_node_pair pair = pairs.pairs[k];
            const size_t b = static_cast<size_t>(pair.other);
            const bool is_seen = plii_spatial_hash_same_cell(&grids[0], points[a], points[b]) ||
                                 plii_spatial_hash_same_cell(&grids[1], points[a], points[b]);
            const bool is_near = pair.distance_squared < 0.25f * distance * distance;
            missed += !is_seen;
            near += is_near;
            missed_near += is_near && !is_seen;
        }
    }
    std::printf("%-28s %8d pairs, missed by two grids %5.1f %%; nearer than half: %7d pairs, missed %5.1f %%\n", name,
                pairs.count, 100.0 * missed / pairs.count, near, 100.0 * missed_near / near);
    PLII_RELEASE(context, pairs.pairs, pairs.capacity);
    for (plii_spatial_hash* hash : {&all, &grids[0], &grids[1]}) {
        free_hash(context, hash);
    }
    pli_context_destroy(context);
}

// A standing sheet after it has fallen onto a floor, with self-collision.
std::vector<pli_vec3> fallen_sheet(int side, int steps) {
    pli_context* context = make_context();
    pli_world* world = nullptr;
    pli_world_create(context, nullptr, &world);
    const float half = 0.5f * spacing * static_cast<float>(side - 1);
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(-half, 0.02f, 0);
    patch.corner_10 = pli_vec3_make(half, 0.02f, 0);
    patch.corner_01 = pli_vec3_make(-half, 2.0f * half, 0.03f * half);
    patch.corner_11 = pli_vec3_make(half, 2.0f * half, 0.05f * half);
    patch.columns = patch.rows = side;
    patch.diagonals = true;
    pli_mesh* mesh = nullptr;
    pli_mesh_create_patch(context, &patch, &mesh);
    pli_mesh_set_total_mass(mesh, 0.3f);
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.5f * spacing;
    def.solver.position_iterations = 4;
    def.solver.velocity_damping = 0.02f;
    pli_body* body = nullptr;
    pli_body_create(world, mesh, &def, &body);
    pli_mesh_destroy(mesh);
    const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    pli_body_enable_rigid_contacts(body, &contacts);
    pli_self_collision_def self = pli_self_collision_def_default();
    self.thickness = 0.9f * spacing;
    pli_body_enable_self_collision(body, &self);
    pli_shape* floor = nullptr;
    pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0, &floor);
    pli_rigid_def rigid_def = pli_rigid_def_default();
    rigid_def.shape_count = 1;
    rigid_def.shapes = &floor;
    pli_rigid* rigid = nullptr;
    pli_rigid_create(world, &rigid_def, &rigid);
    for (int i = 0; i < steps; ++i) {
        pli_world_step(world, 1.0f / 60.0f);
    }
    const pli_body_view view = pli_body_get_view(body);
    std::vector<pli_vec3> points;
    for (int i = 0; i < view.node_count; ++i) {
        points.push_back(pli_vec3_make(view.positions[i].x, view.positions[i].y, view.positions[i].z));
    }
    pli_world_destroy(world);
    pli_shape_release(floor);
    pli_context_destroy(context);
    return points;
}

void print_miss_rates() {
    print_miss_rate("random points", random_points(20000, 0.2f), 0.01f);
    print_miss_rate("cloth after a fall, 60 x 60", fallen_sheet(60, 600), 1.2f * spacing);
}

// ---- times

// The search alone.
void search(benchmark::State& state) {
    const std::vector<pli_vec3> points = folded_sheet_of(static_cast<int>(state.range(0)));
    const int count = static_cast<int>(points.size());
    pli_context* context = make_context();
    plii_spatial_hash hash = {};
    plii_node_pairs pairs = {};
    for (auto _ : state) {
        plii_spatial_hash_build(context, &hash, count, points.data(), 1.5f * spacing, 0.0f);
        pairs.count = 0;
        for (int i = 0; i < count; ++i) {
            plii_spatial_hash_find(context, &hash, i, points[static_cast<size_t>(i)], 1.5f * spacing, &pairs);
        }
        benchmark::DoNotOptimize(pairs.pairs);
    }
    state.counters["time/node"] =
        benchmark::Counter(count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    state.counters["pairs/node"] = static_cast<double>(pairs.count) / count;
    free_hash(context, &hash);
    PLII_RELEASE(context, pairs.pairs, pairs.capacity);
    pli_context_destroy(context);
}
BENCHMARK(search)->Arg(10000)->Arg(100000)->Arg(400000)->Unit(benchmark::kMillisecond)->MinTime(0.5);

// A body of loose nodes in those places, so that nothing but self-collision is timed: search and 4 iterations. It has
// come to rest, whatever the number of nodes and of timed steps.
void step(benchmark::State& state) {
    const std::vector<pli_vec3> points = folded_sheet_of(static_cast<int>(state.range(0)));
    pli_context* context = make_context();
    pli_world_def world_def = pli_world_def_default();
    world_def.gravity = pli_vec3_make(0, 0, 0);
    pli_world* world = nullptr;
    pli_world_create(context, &world_def, &world);
    pli_mesh* mesh = nullptr;
    pli_mesh_create(context, &mesh);
    for (const pli_vec3& point : points) {
        pli_mesh_append_node(mesh, point, 0.001f, nullptr);
    }
    pli_body_def def = pli_body_def_default();
    def.solver.position_iterations = 4;
    def.solver.velocity_damping = 0.1f;
    pli_body* body = nullptr;
    pli_body_create(world, mesh, &def, &body);
    pli_mesh_destroy(mesh);
    pli_self_collision_def self = pli_self_collision_def_default();
    self.thickness = spacing;
    pli_body_enable_self_collision(body, &self);
    for (int i = 0; i < 60; ++i) {
        pli_world_step(world, 1.0f / 60.0f);
    }
    for (auto _ : state) {
        pli_world_step(world, 1.0f / 60.0f);
    }
    state.counters["time/node"] =
        benchmark::Counter(static_cast<double>(points.size()),
                           benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    state.counters["pairs/node"] =
        static_cast<double>(pli_body_get_self_collision_report(body).pairs) / static_cast<double>(points.size());
    pli_world_destroy(world);
    pli_context_destroy(context);
}
BENCHMARK(step)->Arg(10000)->Arg(100000)->Arg(400000)->Unit(benchmark::kMillisecond)->MinTime(0.5);

// A sheet under XPBD with 10 substeps that falls onto a floor and folds: 10 s of it, in frames of 1/60 s. Range:
// columns, rows, whether with self-collision, and how much more the sheet leans, in 1e-5 of its height: how it folds,
// and how long it takes to come to rest, depends on that.
void frame(benchmark::State& state) {
    const int columns = static_cast<int>(state.range(0)), rows = static_cast<int>(state.range(1));
    pli_context* context = make_context();
    pli_world* world = nullptr;
    pli_world_create(context, nullptr, &world);
    const float width = spacing * static_cast<float>(columns - 1), height = spacing * static_cast<float>(rows - 1);
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = pli_vec3_make(0, 0.02f, 0);
    patch.corner_10 = pli_vec3_make(width, 0.02f, 0);
    patch.corner_01 = pli_vec3_make(0, 0.02f + height, 0.02f * height);
    const float lean = 0.01f + 1e-5f * static_cast<float>(state.range(3));
    patch.corner_11 = pli_vec3_make(width, 0.02f + height, lean * height);
    patch.columns = columns;
    patch.rows = rows;
    patch.diagonals = true;
    pli_mesh* mesh = nullptr;
    pli_mesh_create_patch(context, &patch, &mesh);
    pli_mesh_set_total_mass(mesh, 0.2f);
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.5f * spacing;
    def.solver.velocity_damping = 0.002f;
    pli_body* body = nullptr;
    pli_body_create(world, mesh, &def, &body);
    pli_mesh_destroy(mesh);
    pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    contacts.friction = 0.5f;
    pli_body_enable_rigid_contacts(body, &contacts);
    const pli_xpbd_def xpbd = pli_xpbd_def_default();
    pli_body_enable_xpbd(body, &xpbd);
    const pli_xpbd_links_def links = pli_xpbd_links_def_default();
    pli_body_enable_xpbd_links(body, &links);
    pli_body_enable_colored_links(body);
    pli_self_collision_def self = pli_self_collision_def_default();
    self.thickness = spacing;
    if (state.range(2) != 0) { pli_body_enable_self_collision(body, &self); }
    pli_shape* floor = nullptr;
    pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0, &floor);
    pli_rigid_def rigid_def = pli_rigid_def_default();
    rigid_def.shape_count = 1;
    rigid_def.shapes = &floor;
    pli_rigid* rigid = nullptr;
    pli_rigid_create(world, &rigid_def, &rigid);
    int searches = 0;
    for (auto _ : state) {
        pli_world_step(world, 1.0f / 60.0f);
        searches += pli_body_get_self_collision_report(body).searches;
    }
    const double nodes = static_cast<double>(columns) * rows;
    state.counters["pairs/node"] = pli_body_get_self_collision_report(body).pairs / nodes;
    state.counters["contacts/node"] = pli_body_get_self_collision_report(body).contacts / nodes;
    state.counters["searches"] = benchmark::Counter(searches, benchmark::Counter::kAvgIterations);
    pli_world_destroy(world);
    pli_shape_release(floor);
    pli_context_destroy(context);
}
BENCHMARK(frame)
    ->ArgsProduct({{35}, {35}, {0, 1}, {0, 1, 3, -2, 10, -5}})
    ->ArgsProduct({{30}, {200}, {0, 1}, {0, 1, 3, -2, 10, -5}})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(600);

} // namespace

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) { return 1; }
    print_miss_rates();
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
