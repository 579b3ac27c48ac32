// Time per link and sweep of a step of ten sweeps over the links of a body: in the order of the mesh, by colours with
// each instruction set, and btSoftBody's; by colours also of a body that lies on a floor, whose contacts are solved
// between the sweeps; there `time/link` is the median of the sweeps alone. The counter `stretch` tells what speed is
// bought with: root mean square of length / rest - 1 of the same body hung up by some nodes, after 300 steps of 1/60 s
// with 10 sweeps (that of btSoftBody is that of the ordered links, whose results are the same).
//
// Run with --benchmark_repetitions=9 --benchmark_enable_random_interleaving=true on a machine that does other things.

extern "C" {
#include "body/body_impl.h"
#include "body/pipeline.h"
#include "pliant/contact.h"
#include "pliant/generate.h"
#include "pliant/io.h"
#include "pliant/rigid.h"
#include "pliant/shape.h"
#include "pliant/world.h"
#include "pliant/xpbd.h"
}

#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

void check(pli_status status) {
    if (status != PLI_OK) { throw std::runtime_error(pli_status_string(status)); }
}

struct Deleter {
    void operator()(pli_context* context) const { pli_context_destroy(context); }
    void operator()(pli_mesh* mesh) const { pli_mesh_destroy(mesh); }
    void operator()(pli_world* world) const { pli_world_destroy(world); }
};
template <class T> using Owned = std::unique_ptr<T, Deleter>;

enum class Kind { bunny, sphere, shuffled_sphere, sheet, bent_sheet, rope, long_rope };

constexpr int sheet_size = 256, sphere_size = 20000, rope_links = 20, long_rope_links = 100, sweeps = 10;

// The same sphere with nodes in another order.
pli_mesh* with_shuffled_nodes(pli_context* context, pli_mesh* mesh) {
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    std::vector<int> place(static_cast<size_t>(view.node_count)), node(place.size());
    std::iota(node.begin(), node.end(), 0);
    uint32_t seed = 1;
    for (size_t i = node.size(); i > 1; --i) {
        seed = seed * 1664525u + 1013904223u;
        std::swap(node[i - 1], node[(seed >> 8) % i]);
    }
    pli_mesh* shuffled = nullptr;
    check(pli_mesh_create(context, &shuffled));
    for (size_t i = 0; i < node.size(); ++i) {
        place[static_cast<size_t>(node[i])] = static_cast<int>(i);
        check(pli_mesh_append_node(shuffled, view.positions[node[i]], 1.0f, nullptr));
    }
    for (int i = 0; i < view.link_count; ++i) {
        check(pli_mesh_append_link(shuffled, place[static_cast<size_t>(view.links[i].nodes[0])],
                                   place[static_cast<size_t>(view.links[i].nodes[1])], 0, nullptr));
    }
    pli_mesh_destroy(mesh);
    return shuffled;
}

Owned<pli_mesh> make_mesh(pli_context* context, Kind kind) {
    pli_mesh* mesh = nullptr;
    switch (kind) {
    case Kind::rope:
    case Kind::long_rope:
        check(pli_mesh_create_rope(context, pli_vec3_make(0, 1, 0), pli_vec3_make(1, -1, 0),
                                   (kind == Kind::rope ? rope_links : long_rope_links) - 1, 0, &mesh));
        break;
    case Kind::bunny:
        check(pli_mesh_read_obj(context, PLIANT_DATA "/bunny.obj", &mesh));
        check(pli_mesh_shuffle_links(mesh));
        break;
    case Kind::sphere:
    case Kind::shuffled_sphere:
        check(pli_mesh_create_ellipsoid(context, pli_vec3_make(0, 0, 0), pli_vec3_make(1, 1, 1), sphere_size, &mesh));
        if (kind == Kind::shuffled_sphere) { mesh = with_shuffled_nodes(context, mesh); }
        break;
    case Kind::sheet:
    case Kind::bent_sheet: {
        pli_patch_def def = pli_patch_def_default();
        def.corner_00 = pli_vec3_make(-1, 0, -1);
        def.corner_10 = pli_vec3_make(1, 0, -1);
        def.corner_01 = pli_vec3_make(-1, 0, 1);
        def.corner_11 = pli_vec3_make(1, 0, 1);
        def.columns = def.rows = sheet_size;
        def.diagonals = true;
        check(pli_mesh_create_patch(context, &def, &mesh));
        if (kind == Kind::bent_sheet) { check(pli_mesh_append_bending_links(mesh, 2, 0, nullptr)); }
        break;
    }
    }
    check(pli_mesh_set_total_mass(mesh, 1.0f));
    return Owned<pli_mesh>(mesh);
}

// A body in a world of its own, stretched a little so that every link has something to do.
struct Sample {
    Owned<pli_context> context;
    Owned<pli_mesh> mesh;
    Owned<pli_world> world;
    pli_body* body = nullptr;

    Sample(Kind kind, bool is_colored, pli_simd simd) {
        pli_context_def def = pli_context_def_default();
        def.simd = simd;
        pli_context* made = nullptr;
        check(pli_context_create(&def, &made));
        context.reset(made);
        mesh = make_mesh(made, kind);
        pli_world* made_world = nullptr;
        check(pli_world_create(made, nullptr, &made_world));
        world.reset(made_world);
        pli_body_def body_def = pli_body_def_default();
        body_def.solver.position_iterations = sweeps;
        check(pli_body_create(made_world, mesh.get(), &body_def, &body));
        if (is_colored) { check(pli_body_enable_colored_links(body)); }
        plii_run_stage(body, PLII_STAGE_PREPARE);
    }
    void stretch() {
        for (int i = 0; i < body->node_count; ++i) {
            body->positions[i].x *= 1.05f;
        }
    }
};

double measured_stretch(const pli_body* body) {
    double sum = 0.0;
    for (int i = 0; i < body->link_count; ++i) {
        const plii_link& link = body->links[i];
        const pli_vec3 a = plii_xyz(body->positions[link.nodes[0]]), b = plii_xyz(body->positions[link.nodes[1]]);
        const double ratio = std::sqrt(static_cast<double>(pli_vec3_length_squared(pli_vec3_sub(a, b))) /
                                       static_cast<double>(link.rest_length_squared)) -
                             1.0;
        sum += ratio * ratio;
    }
    return std::sqrt(sum / body->link_count);
}

double settled_stretch(Kind kind, bool is_colored) {
    Sample sample(kind, is_colored, PLI_SIMD_BEST);
    pli_body* body = sample.body;
    float top = -1e9f;
    for (int i = 0; i < body->node_count; ++i) {
        top = std::max(top, body->positions[i].y + body->positions[i].z);
    }
    for (int i = 0; i < body->node_count; ++i) {
        const bool is_held = body->positions[i].y + body->positions[i].z > 0.9f * top;
        if (is_held) { check(pli_body_set_node_mass(body, i, 0.0f)); }
    }
    pli_solver_settings settings = pli_body_get_solver_settings(body);
    settings.velocity_damping = 0.01f;
    check(pli_body_set_solver_settings(body, &settings));
    for (int i = 0; i < 300; ++i) {
        check(pli_world_step(sample.world.get(), 1.0f / 60.0f));
    }
    return measured_stretch(body);
}

double remembered_stretch(Kind kind, bool is_colored) {
    static std::map<std::pair<Kind, bool>, double> known;
    const auto key = std::make_pair(kind, is_colored);
    if (known.count(key) == 0) { known[key] = settled_stretch(kind, is_colored); }
    return known[key];
}

void count_links(benchmark::State& state, int link_count, double stretch) {
    state.counters["links"] = link_count;
    state.counters["stretch"] = stretch;
    state.counters["time/link"] =
        benchmark::Counter(link_count, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void pliant_links(benchmark::State& state, Kind kind, bool is_colored, pli_simd simd) {
    Sample sample(kind, is_colored, simd);
    pli_body* body = sample.body;
    sample.stretch();
    for (auto _ : state) {
        for (int i = 0; i < sweeps; ++i) {
            body->sweep_links(body, body->sweep_links_state);
        }
        benchmark::ClobberMemory();
    }
    count_links(state, sweeps * body->link_count, remembered_stretch(kind, is_colored));
}

// The lowest nodes have sunk into a floor.
void lay_down(Sample& sample) {
    pli_body* body = sample.body;
    float low = 1e9f, high = -1e9f;
    for (int i = 0; i < body->node_count; ++i) {
        low = std::min(low, body->positions[i].y);
        high = std::max(high, body->positions[i].y);
    }
    pli_shape* floor = nullptr;
    check(pli_shape_create_plane(sample.context.get(), pli_vec3_make(0, 1, 0), low + 0.1f * (high - low), &floor));
    pli_rigid_def def = pli_rigid_def_default();
    def.shapes = &floor;
    def.shape_count = 1;
    pli_rigid* rigid = nullptr;
    check(pli_rigid_create(sample.world.get(), &def, &rigid));
    pli_shape_release(floor);
    const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    check(pli_body_enable_rigid_contacts(body, &contacts));
    for (int i = 0; i < 3; ++i) {
        check(pli_world_step(sample.world.get(), 1.0f / 60.0f));
    }
}

void touching_links(benchmark::State& state, Kind kind, pli_simd simd) {
    Sample sample(kind, true, simd);
    pli_body* body = sample.body;
    lay_down(sample);
    plii_feature_disable(body, &plii_links_class); // this function sweeps them, and the stage solves the contacts
    sample.stretch();
    std::vector<double> times; // s, of sweeps over the links
    for (auto _ : state) {
        for (int i = 0; i < sweeps; ++i) {
            const auto start = std::chrono::steady_clock::now();
            body->sweep_links(body, body->sweep_links_state);
            times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
            plii_run_stage(body, PLII_STAGE_POSITION);
        }
    }
    const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
    std::nth_element(times.begin(), middle, times.end());
    state.counters["links"] = sweeps * body->link_count;
    state.counters["contacts"] = pli_body_get_rigid_contacts(body, 0, nullptr);
    state.counters["time/link"] = *middle / body->link_count;
}

void bullet_links(benchmark::State& state, Kind kind) {
    Sample sample(kind, false, PLI_SIMD_BEST);
    const pli_body* source = sample.body;
    std::vector<btVector3> points;
    std::vector<btScalar> masses;
    for (int i = 0; i < source->node_count; ++i) {
        const pli_vec4& p = source->positions[i];
        points.emplace_back(p.x, p.y, p.z);
        masses.push_back(1.0f / p.w);
    }
    btSoftBodyWorldInfo info;
    btSoftBody body(&info, source->node_count, points.data(), masses.data());
    for (int i = 0; i < source->link_count; ++i) {
        body.appendLink(source->links[i].nodes[0], source->links[i].nodes[1]);
    }
    body.resetLinkRestLengths();
    body.updateLinkConstants();
    for (int i = 0; i < body.m_nodes.size(); ++i) {
        body.m_nodes[i].m_x.setX(body.m_nodes[i].m_x.x() * 1.05f);
    }
    for (auto _ : state) {
        for (int i = 0; i < sweeps; ++i) {
            btSoftBody::PSolve_Links(&body, 1.0f, 0.0f);
        }
        benchmark::ClobberMemory();
    }
    count_links(state, sweeps * source->link_count, remembered_stretch(kind, false));
}

// A whole step of 10 substeps with one sweep each, per link and substep, of a sheet of 128x128 nodes with structural,
// shear and bending links that hangs by two corners.
void xpbd_step(benchmark::State& state, pli_simd simd, float compliance, float damping) {
    constexpr int size = 128, substeps = 10;
    pli_context_def context_def = pli_context_def_default();
    context_def.simd = simd;
    pli_context* made = nullptr;
    check(pli_context_create(&context_def, &made));
    const Owned<pli_context> context(made);
    pli_mesh* made_mesh = nullptr;
    check(pli_mesh_create(made, &made_mesh));
    const Owned<pli_mesh> mesh(made_mesh);
    for (int i = 0; i < size * size; ++i) {
        const pli_vec3 position =
            pli_vec3_make(0.01f * static_cast<float>(i % size), 0.0f, 0.01f * static_cast<float>(i / size));
        check(pli_mesh_append_node(made_mesh, position, i == 0 || i == size - 1 ? 0.0f : 1e-4f, nullptr));
    }
    const int steps[][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}, {2, 0}, {0, 2}};
    for (int i = 0; i < size * size; ++i) {
        for (const auto& step : steps) {
            const int x = i % size + step[0], y = i / size + step[1];
            if (x < 0 || x >= size || y >= size) { continue; }
            check(pli_mesh_append_link(made_mesh, i, y * size + x, 0, nullptr));
        }
    }
    pli_world* made_world = nullptr;
    check(pli_world_create(made, nullptr, &made_world));
    const Owned<pli_world> world(made_world);
    pli_body* body = nullptr;
    check(pli_body_create(made_world, made_mesh, nullptr, &body));
    const pli_xpbd_def def = pli_xpbd_def_default();
    check(pli_body_enable_xpbd(body, &def));
    pli_xpbd_links_def links = pli_xpbd_links_def_default();
    links.compliance = links.bending_compliance = compliance;
    links.damping = damping;
    check(pli_body_enable_xpbd_links(body, &links));
    for (auto _ : state) {
        check(pli_world_step(made_world, 1.0f / 60.0f));
    }
    count_links(state, substeps * body->link_count, measured_stretch(body));
}

const struct {
    Kind kind;
    const char* name;
} meshes[] = {{Kind::bunny, "bunny"},
              {Kind::sphere, "sphere 20k, links shuffled"},
              {Kind::shuffled_sphere, "sphere 20k, nodes and links shuffled"},
              {Kind::sheet, "sheet 256x256"},
              {Kind::bent_sheet, "sheet 256x256 with bending links"},
              {Kind::rope, "rope of 20 links"},
              {Kind::long_rope, "rope of 100 links"}};

const struct {
    pli_simd simd;
    const char* name;
} paths[] = {{PLI_SIMD_PORTABLE, "portable"},
             {PLI_SIMD_SSE2, "SSE2"},
             {PLI_SIMD_AVX2, "AVX2"},
             {PLI_SIMD_AVX512, "AVX-512"},
             {PLI_SIMD_NEON, "NEON"}};

bool is_available(pli_simd simd) {
    pli_context_def def = pli_context_def_default();
    def.simd = simd;
    pli_context* context = nullptr;
    const pli_status status = pli_context_create(&def, &context);
    pli_context_destroy(context);
    return status == PLI_OK;
}

} // namespace

int main(int argc, char** argv) {
    for (const auto& mesh : meshes) {
        const std::string name = mesh.name;
        benchmark::RegisterBenchmark((name + "/btSoftBody").c_str(), bullet_links, mesh.kind);
        benchmark::RegisterBenchmark((name + "/ordered").c_str(), pliant_links, mesh.kind, false, PLI_SIMD_BEST);
        for (const auto& path : paths) {
            if (!is_available(path.simd)) { continue; }
            benchmark::RegisterBenchmark((name + "/colored " + path.name).c_str(), pliant_links, mesh.kind, true,
                                         path.simd);
            if (mesh.kind == Kind::rope || mesh.kind == Kind::long_rope) { continue; }
            benchmark::RegisterBenchmark((name + "/touching " + path.name).c_str(), touching_links, mesh.kind,
                                         path.simd);
        }
    }
    for (const auto& path : paths) {
        if (!is_available(path.simd)) { continue; }
        const std::string name = std::string("XPBD, sheet 128x128, ") + path.name;
        benchmark::RegisterBenchmark((name + "/rigid").c_str(), xpbd_step, path.simd, 0.0f, 0.0f);
        benchmark::RegisterBenchmark((name + "/compliant").c_str(), xpbd_step, path.simd, 1e-6f, 0.0f);
        benchmark::RegisterBenchmark((name + "/damped").c_str(), xpbd_step, path.simd, 1e-6f, 0.1f);
    }
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
