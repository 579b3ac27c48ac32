// Whole steps of XPBD: a cube of tetrahedra that keep their volumes, a sheet without compliance that has come to rest,
// and a large sheet that hangs or lies on a ball. The counter `stretch` is the root mean square of length / rest - 1 of
// the links at the end.

extern "C" {
#include "pliant/pliant.h"
}

#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>

namespace {

constexpr float dt = 1.0f / 60.0f;

void check(pli_status status) {
    if (status != PLI_OK) { throw std::runtime_error(pli_status_string(status)); }
}

struct Deleter {
    void operator()(pli_context* context) const { pli_context_destroy(context); }
    void operator()(pli_mesh* mesh) const { pli_mesh_destroy(mesh); }
    void operator()(pli_world* world) const { pli_world_destroy(world); }
};
template <class T> using Owned = std::unique_ptr<T, Deleter>;

// A world with one body that XPBD steps.
struct Sample {
    Owned<pli_context> context;
    Owned<pli_mesh> mesh;
    Owned<pli_world> world;
    pli_body* body = nullptr;

    Sample() {
        pli_context* made = nullptr;
        check(pli_context_create(nullptr, &made));
        context.reset(made);
        pli_mesh* made_mesh = nullptr;
        check(pli_mesh_create(made, &made_mesh));
        mesh.reset(made_mesh);
        pli_world* made_world = nullptr;
        check(pli_world_create(made, nullptr, &made_world));
        world.reset(made_world);
    }
    void make_body(int substeps) {
        check(pli_body_create(world.get(), mesh.get(), nullptr, &body));
        pli_xpbd_def def = pli_xpbd_def_default();
        def.substeps = substeps;
        check(pli_body_enable_xpbd(body, &def));
        const pli_xpbd_links_def links = pli_xpbd_links_def_default();
        check(pli_body_enable_xpbd_links(body, &links));
    }
    void step() { check(pli_world_step(world.get(), dt)); }
    double stretch() const {
        const pli_body_view view = pli_body_get_view(body);
        double sum = 0.0;
        for (int i = 0; i < view.link_count; ++i) {
            const int* nodes = view.link_nodes + static_cast<std::ptrdiff_t>(i) * view.link_node_stride;
            const pli_vec4 a = view.positions[nodes[0]], b = view.positions[nodes[1]];
            const double x = static_cast<double>(a.x - b.x), y = static_cast<double>(a.y - b.y),
                         z = static_cast<double>(a.z - b.z);
            const double ratio =
                std::sqrt(x * x + y * y + z * z) / static_cast<double>(pli_body_get_rest_length(body, i)) - 1.0;
            sum += ratio * ratio;
        }
        return std::sqrt(sum / view.link_count);
    }
};

// A cube of 16^3 nodes and 15^3 cells of five tetrahedra, all edges links, held by one face.
void tetra_cube(benchmark::State& state, bool with_links) {
    constexpr int size = 16;
    Sample sample;
    for (int i = 0; i < size * size * size; ++i) {
        const pli_vec3 position =
            pli_vec3_make(0.1f * static_cast<float>(i % size), 0.1f * static_cast<float>(i / size % size),
                          0.1f * static_cast<float>(i / (size * size)));
        check(pli_mesh_append_node(sample.mesh.get(), position, i % size == 0 ? 0.0f : 0.01f, nullptr));
    }
    // Corners of a cell by bits x, y, z; cells in turn with the one mirrored.
    const int tetras[2][5][4] = {{{0, 1, 2, 4}, {3, 2, 1, 7}, {5, 4, 7, 1}, {6, 7, 4, 2}, {1, 2, 4, 7}},
                                 {{1, 3, 0, 5}, {2, 0, 3, 6}, {4, 5, 6, 0}, {7, 6, 5, 3}, {0, 5, 3, 6}}};
    std::set<std::pair<int, int>> edges;
    for (int cell = 0; cell < (size - 1) * (size - 1) * (size - 1); ++cell) {
        const int x = cell % (size - 1), y = cell / (size - 1) % (size - 1), z = cell / ((size - 1) * (size - 1));
        for (const auto& tetra : tetras[(x + y + z) % 2]) {
            int nodes[4];
            for (int k = 0; k < 4; ++k) {
                nodes[k] = x + (tetra[k] & 1) + size * (y + (tetra[k] >> 1 & 1)) + size * size * (z + (tetra[k] >> 2));
            }
            check(pli_mesh_append_tetra(sample.mesh.get(), nodes[0], nodes[1], nodes[2], nodes[3], 0, nullptr));
            for (int k = 0; with_links && k < 4; ++k) {
                for (int m = 0; m < k; ++m) {
                    edges.emplace(std::min(nodes[k], nodes[m]), std::max(nodes[k], nodes[m]));
                }
            }
        }
    }
    for (const auto& edge : edges) {
        check(pli_mesh_append_link(sample.mesh.get(), edge.first, edge.second, 0, nullptr));
    }
    sample.make_body(10);
    check(pli_body_enable_xpbd_tetras(sample.body, 0.0f));
    for (auto _ : state) {
        sample.step();
    }
    const pli_body_view view = pli_body_get_view(sample.body);
    state.counters["tetras"] = view.tetra_count;
    state.counters["links"] = view.link_count;
    if (with_links) { state.counters["stretch"] = sample.stretch(); }
}

// 64x64 nodes, 4 m, structural and both shear links, held by two corners, 1 % of the velocity lost per step, after 20
// s.
void stiff_sheet(benchmark::State& state, int substeps) {
    constexpr int size = 64;
    Sample sample;
    for (int i = 0; i < size * size; ++i) {
        const pli_vec3 position = pli_vec3_make(4.0f / (size - 1) * static_cast<float>(i % size), 0.0f,
                                                4.0f / (size - 1) * static_cast<float>(i / size));
        check(pli_mesh_append_node(sample.mesh.get(), position, i == 0 || i == size - 1 ? 0.0f : 1e-3f, nullptr));
    }
    const int steps[][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};
    for (int i = 0; i < size * size; ++i) {
        for (const auto& step : steps) {
            const int x = i % size + step[0], y = i / size + step[1];
            if (x < 0 || x >= size || y >= size) { continue; }
            check(pli_mesh_append_link(sample.mesh.get(), i, y * size + x, 0, nullptr));
        }
    }
    sample.make_body(substeps);
    pli_solver_settings settings = pli_body_get_solver_settings(sample.body);
    settings.velocity_damping = 0.01f;
    check(pli_body_set_solver_settings(sample.body, &settings));
    for (int i = 0; i < 1200; ++i) {
        sample.step();
    }
    for (auto _ : state) {
        sample.step();
    }
    state.counters["links"] = pli_body_get_view(sample.body).link_count;
    state.counters["stretch"] = sample.stretch();
}

// 128x128 nodes, 1.27 m, structural, both shear and bending links, 10 substeps. It hangs by two corners, or has come to
// rest on a ball with half of its nodes.
void large_sheet(benchmark::State& state, bool lies) {
    constexpr int size = 128;
    constexpr float radius = 0.37f;
    Sample sample;
    for (int i = 0; i < size * size; ++i) {
        const pli_vec3 position = pli_vec3_make(0.01f * static_cast<float>(i % size) - 0.635f, radius + 0.01f,
                                                0.01f * static_cast<float>(i / size) - 0.635f);
        const bool is_held = !lies && (i == 0 || i == size - 1);
        check(pli_mesh_append_node(sample.mesh.get(), position, is_held ? 0.0f : 1e-4f, nullptr));
    }
    const int steps[][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}, {2, 0}, {0, 2}};
    for (int i = 0; i < size * size; ++i) {
        for (const auto& step : steps) {
            const int x = i % size + step[0], y = i / size + step[1];
            if (x < 0 || x >= size || y >= size) { continue; }
            check(pli_mesh_append_link(sample.mesh.get(), i, y * size + x, 0, nullptr));
        }
    }
    sample.make_body(10);
    if (lies) {
        check(pli_body_set_collision_margin(sample.body, 0.005f));
        pli_shape* ball = nullptr;
        check(pli_shape_create_sphere(sample.context.get(), radius, &ball));
        pli_rigid_def rigid = pli_rigid_def_default();
        rigid.shapes = &ball;
        rigid.shape_count = 1;
        pli_rigid* made = nullptr;
        check(pli_rigid_create(sample.world.get(), &rigid, &made));
        pli_shape_release(ball);
        pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
        contacts.friction = 0.5f;
        check(pli_body_enable_rigid_contacts(sample.body, &contacts));
        pli_solver_settings settings = pli_body_get_solver_settings(sample.body);
        settings.velocity_damping = 0.05f;
        check(pli_body_set_solver_settings(sample.body, &settings));
    }
    for (int i = 0; i < 120; ++i) {
        sample.step();
    }
    for (auto _ : state) {
        sample.step();
    }
    state.counters["links"] = pli_body_get_view(sample.body).link_count;
    state.counters["contacts"] = pli_body_get_rigid_contacts(sample.body, 0, nullptr);
    state.counters["stretch"] = sample.stretch();
}

} // namespace

BENCHMARK_CAPTURE(tetra_cube, volumes, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(tetra_cube, volumes and links, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stiff_sheet, 10 substeps, 10)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stiff_sheet, 14 substeps, 14)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stiff_sheet, 20 substeps, 20)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(stiff_sheet, 40 substeps, 40)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(large_sheet, hanging, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(large_sheet, lying on a ball, true)->Unit(benchmark::kMillisecond);
BENCHMARK_MAIN();
