// Vertices of a sheet of 100 x 100 nodes into a buffer of 32 B per vertex. `per_vertex` in s.

#include "pliant/pliant.h"

#include <benchmark/benchmark.h>

#include <numeric>
#include <stdexcept>
#include <vector>

namespace {

void check(pli_status status) {
    if (status != PLI_OK) { throw std::runtime_error(pli_status_string(status)); }
}

void write_vertices(benchmark::State& state, bool with_normals, bool through_nodes) {
    pli_context* context = nullptr;
    pli_world* world = nullptr;
    pli_mesh* mesh = nullptr;
    pli_body* body = nullptr;
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_10 = {1, 0, 0};
    patch.corner_01 = {0, 0, 1};
    patch.corner_11 = {1, 0, 1};
    patch.columns = patch.rows = 100;
    check(pli_context_create(nullptr, &context));
    check(pli_world_create(context, nullptr, &world));
    check(pli_mesh_create_patch(context, &patch, &mesh));
    check(pli_body_create(world, mesh, nullptr, &body));
    check(pli_body_enable_normals(body));
    check(pli_world_step(world, 1.0f / 60.0f));

    pli_vertex_buffer_def buffer = pli_vertex_buffer_def_default();
    buffer.vertex_count = patch.columns * patch.rows;
    buffer.stride = 32;
    std::vector<float> vertices(static_cast<std::size_t>(buffer.vertex_count) * 8);
    std::vector<int> nodes(static_cast<std::size_t>(buffer.vertex_count));
    std::iota(nodes.begin(), nodes.end(), 0);
    buffer.vertices = vertices.data();
    buffer.vertex_nodes = through_nodes ? nodes.data() : nullptr;
    if (!with_normals) { buffer.normal_offset = -1; }
    for (auto _ : state) {
        check(pli_body_write_vertices(body, &buffer, 0.4f));
        benchmark::ClobberMemory();
    }
    state.counters["per_vertex"] = benchmark::Counter(
        buffer.vertex_count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    pli_body_destroy(body);
    pli_mesh_destroy(mesh);
    pli_world_destroy(world);
    pli_context_destroy(context);
}

BENCHMARK_CAPTURE(write_vertices, positions, false, false);
BENCHMARK_CAPTURE(write_vertices, normals, true, false);
BENCHMARK_CAPTURE(write_vertices, normals_of_doubled_vertices, true, true);

} // namespace

BENCHMARK_MAIN();
