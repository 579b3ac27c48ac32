// Time to make a patch of 512x512 nodes with structural, shear and bending links, part by part.

extern "C" {
#include "pliant/pliant.h"
}

#include <benchmark/benchmark.h>

#include <stdexcept>

namespace {

constexpr int size = 512;

void check(pli_status status) {
    if (status != PLI_OK) { throw std::runtime_error(pli_status_string(status)); }
}

enum Part { patch, bending, body, colors, xpbd, all, with_first_step };

// What is before the part is made outside of the time.
void setup(benchmark::State& state, Part part) {
    for (auto _ : state) {
        const auto time_of = [&](Part own, auto&& work) {
            const bool is_timed = part >= all || part == own;
            if (!is_timed) { state.PauseTiming(); }
            work();
            if (!is_timed) { state.ResumeTiming(); }
        };
        pli_context* context = nullptr;
        pli_mesh* mesh = nullptr;
        pli_world* world = nullptr;
        pli_body* made = nullptr;
        check(pli_context_create(nullptr, &context));
        check(pli_world_create(context, nullptr, &world));
        time_of(patch, [&] {
            pli_patch_def def = pli_patch_def_default();
            def.corner_00 = pli_vec3_make(-1, 0, -1);
            def.corner_10 = pli_vec3_make(1, 0, -1);
            def.corner_01 = pli_vec3_make(-1, 0, 1);
            def.corner_11 = pli_vec3_make(1, 0, 1);
            def.columns = def.rows = size;
            def.diagonals = true;
            check(pli_mesh_create_patch(context, &def, &mesh));
        });
        time_of(bending, [&] { check(pli_mesh_append_bending_links(mesh, 2, 0, nullptr)); });
        time_of(body, [&] { check(pli_body_create(world, mesh, nullptr, &made)); });
        if (part != xpbd) {
            time_of(colors, [&] { check(pli_body_enable_colored_links(made)); });
        } else {
            const pli_xpbd_def def = pli_xpbd_def_default();
            const pli_xpbd_links_def links = pli_xpbd_links_def_default();
            check(pli_body_enable_xpbd(made, &def));
            check(pli_body_enable_xpbd_links(made, &links));
        }
        if (part == with_first_step) { check(pli_world_step(world, 1.0f / 60.0f)); }
        state.PauseTiming();
        const pli_body_view view = pli_body_get_view(made);
        state.counters["links"] = view.link_count;
        state.counters["bytes/node"] = static_cast<double>(pli_body_bytes(made)) / static_cast<double>(view.node_count);
        pli_mesh_destroy(mesh);
        pli_world_destroy(world);
        pli_context_destroy(context);
        state.ResumeTiming();
    }
}

} // namespace

BENCHMARK_CAPTURE(setup, patch, patch)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(setup, bending links, bending)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(setup, body, body)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(setup, colors, colors)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(setup, XPBD links, xpbd)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(setup, all, all)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(setup, all and a step, with_first_step)->Unit(benchmark::kMillisecond);
BENCHMARK_MAIN();
