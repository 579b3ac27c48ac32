// 100 sheets of 32 x 32 nodes that lie on the ground: a save and a restore, beside copies of as many bytes to and fro,
// in one piece and from the arrays of the nodes; `bytes_per_node` is of what is copied. The same as a game has it:
// eight snapshots in turn, and a step before each save and each restore, which is not in the time. Steps of the same
// sheets awake and asleep.

#include "pliant/pliant.h"

#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <vector>

namespace {

void check(pli_status status) {
    if (status != PLI_OK) { throw std::runtime_error(pli_status_string(status)); }
}

enum class Dress { nodes, faces_and_air };

struct Sheets {
    static constexpr int columns = 32, count = 100;
    pli_context* context = nullptr;
    pli_world* world = nullptr;

    explicit Sheets(Dress dress) {
        check(pli_context_create(nullptr, &context));
        check(pli_world_create(context, nullptr, &world));
        pli_shape* plane = nullptr;
        check(pli_shape_create_plane(context, pli_vec3_make(0, 1, 0), 0, &plane));
        pli_rigid_def ground = pli_rigid_def_default();
        ground.shapes = &plane;
        ground.shape_count = 1;
        pli_rigid* rigid = nullptr;
        check(pli_rigid_create(world, &ground, &rigid));
        pli_shape_release(plane);
        for (int i = 0; i < count; ++i) {
            add(3.0f * static_cast<float>(i % 10), 3.0f * static_cast<float>(i / 10), dress);
        }
        for (int i = 0; i < 60; ++i) {
            check(pli_world_step(world, 1.0f / 60.0f));
        }
    }
    ~Sheets() {
        pli_world_destroy(world);
        pli_context_destroy(context);
    }
    Sheets(const Sheets&) = delete;
    Sheets& operator=(const Sheets&) = delete;

    void add(float x, float z, Dress dress) {
        pli_patch_def patch = pli_patch_def_default();
        patch.corner_00 = pli_vec3_make(x - 1, 0.3f, z - 1);
        patch.corner_10 = pli_vec3_make(x + 1, 0.3f, z - 1);
        patch.corner_01 = pli_vec3_make(x - 1, 0.3f, z + 1);
        patch.corner_11 = pli_vec3_make(x + 1, 0.3f, z + 1);
        patch.columns = patch.rows = columns;
        pli_mesh* mesh = nullptr;
        pli_body* body = nullptr;
        check(pli_mesh_create_patch(context, &patch, &mesh));
        check(pli_mesh_set_total_mass(mesh, 1));
        pli_body_def def = pli_body_def_default();
        def.collision_margin = 0.02f;
        check(pli_body_create(world, mesh, &def, &body));
        pli_mesh_destroy(mesh);
        check(pli_body_enable_colored_links(body));
        check(pli_body_enable_rigid_contacts(body, nullptr));
        if (dress == Dress::nodes) { return; }
        pli_aero_def aero = pli_aero_def_default();
        aero.drag = 0.01f;
        check(pli_body_enable_rigid_face_contacts(body, nullptr));
        check(pli_body_enable_soft_contacts(body, nullptr));
        check(pli_body_enable_aero(body, &aero));
    }
};

/* On a line of the cache, as snapshots are copied fastest. */
struct Release {
    void operator()(unsigned char* bytes) const { std::free(bytes); }
};
using Buffer = std::unique_ptr<unsigned char[], Release>;

Buffer make_buffer(std::size_t size) {
    constexpr std::size_t line = 64;
    Buffer buffer(static_cast<unsigned char*>(std::aligned_alloc(line, (size + line - 1) / line * line)));
    if (!buffer) { throw std::bad_alloc(); }
    std::memset(buffer.get(), 0, size);
    return buffer;
}

void count_bytes(benchmark::State& state, std::size_t size) {
    constexpr auto nodes = static_cast<double>(Sheets::count * Sheets::columns * Sheets::columns);
    state.counters["bytes_per_node"] = static_cast<double>(size) / nodes;
    state.SetBytesProcessed(static_cast<std::int64_t>(2 * size) * state.iterations());
}

void save_and_restore(benchmark::State& state, Dress dress) {
    const Sheets sheets(dress);
    const std::size_t size = pli_world_snapshot_size(sheets.world);
    const Buffer buffer = make_buffer(size);
    for (auto _ : state) {
        check(pli_world_save(sheets.world, buffer.get(), size, nullptr));
        check(pli_world_restore(sheets.world, buffer.get(), size));
    }
    count_bytes(state, size);
}

void copy_to_and_fro(benchmark::State& state, Dress dress) {
    const Sheets sheets(dress);
    const std::size_t size = pli_world_snapshot_size(sheets.world);
    const Buffer buffer = make_buffer(size), other = make_buffer(size);
    for (auto _ : state) {
        std::memcpy(other.get(), buffer.get(), size);
        benchmark::ClobberMemory();
        std::memcpy(buffer.get(), other.get(), size);
        benchmark::ClobberMemory();
    }
    count_bytes(state, size);
}

/* The nodes of the same sheets from where they lie, body by body, and back there. */
void copy_nodes_to_and_fro(benchmark::State& state) {
    const Sheets sheets(Dress::nodes);
    constexpr std::size_t bytes = sizeof(pli_vec4) * Sheets::columns * Sheets::columns;
    const Buffer buffer = make_buffer(3 * bytes * Sheets::count);
    std::vector<void*> arrays;
    for (int i = 0; i < Sheets::count; ++i) {
        const pli_body_view view = pli_body_get_view(pli_world_get_body(sheets.world, i));
        for (const pli_vec4* array : {view.positions, view.previous, view.velocities}) {
            arrays.push_back(const_cast<pli_vec4*>(array)); // gets what it has
        }
    }
    for (auto _ : state) {
        for (std::size_t i = 0; i < arrays.size(); ++i) {
            std::memcpy(buffer.get() + i * bytes, arrays[i], bytes);
        }
        benchmark::ClobberMemory();
        for (std::size_t i = 0; i < arrays.size(); ++i) {
            std::memcpy(arrays[i], buffer.get() + i * bytes, bytes);
        }
        benchmark::ClobberMemory();
    }
    count_bytes(state, 3 * bytes * Sheets::count);
}

template <class Save, class Restore>
void between_steps(benchmark::State& state, Dress dress, Save save, Restore restore) {
    const Sheets sheets(dress);
    const std::size_t size = pli_world_snapshot_size(sheets.world);
    std::vector<Buffer> frames;
    for (int i = 0; i < 8; ++i) {
        frames.push_back(make_buffer(size));
        check(pli_world_save(sheets.world, frames.back().get(), size, nullptr));
    }
    const Buffer block = make_buffer(size); /* what copies are of */
    const auto seconds = [&](const auto& work) {
        check(pli_world_step(sheets.world, 1.0f / 60.0f));
        const auto start = std::chrono::steady_clock::now();
        work();
        benchmark::ClobberMemory();
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    std::size_t frame = 0;
    for (auto _ : state) {
        unsigned char* const latest = frames[frame].get();
        frame = (frame + 1) % frames.size();
        unsigned char* const earliest = frames[frame].get();
        const double saving = seconds([&] { save(sheets.world, block.get(), latest, size); });
        state.SetIterationTime(saving + seconds([&] { restore(sheets.world, block.get(), earliest, size); }));
    }
    count_bytes(state, size);
}

void save_and_restore_between_steps(benchmark::State& state, Dress dress) {
    between_steps(
        state, dress,
        [](auto* world, auto*, auto* frame, auto size) { check(pli_world_save(world, frame, size, nullptr)); },
        [](auto* world, auto*, auto* frame, auto size) { check(pli_world_restore(world, frame, size)); });
}

void copy_between_steps(benchmark::State& state, Dress dress) {
    between_steps(
        state, dress, [](auto*, auto* block, auto* frame, auto size) { std::memcpy(frame, block, size); },
        [](auto*, auto* block, auto* frame, auto size) { std::memcpy(block, frame, size); });
}

void step(benchmark::State& state, bool is_asleep) {
    const Sheets sheets(Dress::nodes);
    for (int i = 0; i < pli_world_body_count(sheets.world) && is_asleep; ++i) {
        check(pli_body_enable_sleep(pli_world_get_body(sheets.world, i), nullptr));
        check(pli_body_set_asleep(pli_world_get_body(sheets.world, i), true));
    }
    for (auto _ : state) {
        check(pli_world_step(sheets.world, 1.0f / 60.0f));
    }
}

BENCHMARK_CAPTURE(step, awake, false);
BENCHMARK_CAPTURE(step, asleep, true);
BENCHMARK_CAPTURE(save_and_restore, contacts_of_nodes, Dress::nodes);
BENCHMARK_CAPTURE(copy_to_and_fro, contacts_of_nodes, Dress::nodes);
BENCHMARK(copy_nodes_to_and_fro);
BENCHMARK_CAPTURE(save_and_restore, contacts_of_faces_soft_contacts_air, Dress::faces_and_air);
BENCHMARK_CAPTURE(copy_to_and_fro, contacts_of_faces_soft_contacts_air, Dress::faces_and_air);
BENCHMARK_CAPTURE(save_and_restore_between_steps, contacts_of_nodes, Dress::nodes)->UseManualTime();
BENCHMARK_CAPTURE(copy_between_steps, contacts_of_nodes, Dress::nodes)->UseManualTime();
BENCHMARK_CAPTURE(save_and_restore_between_steps, contacts_of_faces_soft_contacts_air, Dress::faces_and_air)
    ->UseManualTime();
BENCHMARK_CAPTURE(copy_between_steps, contacts_of_faces_soft_contacts_air, Dress::faces_and_air)->UseManualTime();

} // namespace

BENCHMARK_MAIN();
