// Self-collision of nodes: the miss rate of two shifted grids against the complete search in a table, then the cost per
// node of the hashed search and of whole steps.

#include <pliant/pliant.h>

extern "C" {
#include "node_hash.h"
}

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
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

// The search alone.
void search(benchmark::State& state) {
    const std::vector<pli_vec3> points = folded_sheet_of(static_cast<int>(state.range(0)));
    const int count = static_cast<int>(points.size());
    pli_context* context = make_context();
    plii_node_hash hash = {};
    plii_node_pairs pairs = {};
    for (auto _ : state) {
        plii_node_hash_build(context, &hash, count, points.data(), 1.5f * spacing, 0.0f);
        plii_node_hash_find(context, &hash, points.data(), 1.5f * spacing, &pairs);
        benchmark::DoNotOptimize(pairs.pairs);
    }
    state.counters["time/node"] =
        benchmark::Counter(count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    state.counters["pairs/node"] = static_cast<double>(pairs.count) / count;
    plii_node_hash_free(context, &hash);
    plii_node_pairs_free(context, &pairs);
    pli_context_destroy(context);
}
BENCHMARK(search)->Arg(10000)->Arg(100000)->Unit(benchmark::kMillisecond)->MinTime(0.5);

// A body of loose nodes in those places, so that nothing but self-collision is timed: search and 4 iterations.
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
BENCHMARK(step)->Arg(10000)->Arg(100000)->Unit(benchmark::kMillisecond)->MinTime(0.5);

} // namespace

BENCHMARK_MAIN();
