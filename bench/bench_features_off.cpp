// What a feature costs that is off: steps of two equal sheets in turn, one that never had it and one that had it before
// for a step. `ratio` of the medians is 1 but for noise; the first line, with no feature at all, shows the noise.

extern "C" {
#include "pliant/pliant.h"
}

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <vector>

namespace {

constexpr int size = 32;
constexpr float dt = 1.0f / 60.0f;

void check(pli_status status) {
    if (status != PLI_OK) { throw std::runtime_error(pli_status_string(status)); }
}

using Switch = void (*)(pli_body*);

struct Feature {
    const char* name;
    Switch enable, disable;
};

// With functions that take a def, and disable with or without a status.
template <auto enable, auto def> void enable_by_def(pli_body* body) {
    const auto used = def();
    check(enable(body, &used));
}
template <auto disable> void disable_checked(pli_body* body) {
    check(disable(body));
}

void nothing(pli_body*) {}
void enable_xpbd_all(pli_body* body) {
    enable_by_def<pli_body_enable_xpbd, pli_xpbd_def_default>(body);
    enable_by_def<pli_body_enable_xpbd_links, pli_xpbd_links_def_default>(body);
    enable_by_def<pli_body_enable_rigid_contacts, pli_rigid_contacts_def_default>(body);
}
void disable_xpbd_all(pli_body* body) {
    check(pli_body_disable_rigid_contacts(body));
    check(pli_body_disable_xpbd_links(body));
    check(pli_body_disable_xpbd(body));
}
void enable_aero(pli_body* body) {
    pli_aero_def def = pli_aero_def_default();
    def.drag = 0.1f;
    check(pli_body_enable_aero(body, &def));
}
void enable_clusters(pli_body* body) {
    check(pli_body_enable_clusters(body, nullptr));
    check(pli_body_generate_clusters(body, 16, 100, nullptr));
    enable_by_def<pli_body_enable_cluster_contacts, pli_cluster_contacts_def_default>(body);
}
void disable_clusters(pli_body* body) {
    check(pli_body_disable_cluster_contacts(body));
    check(pli_body_disable_clusters(body));
}

const Feature features[] = {
    {"none", nothing, nothing},
    {"colored links", [](pli_body* body) { check(pli_body_enable_colored_links(body)); },
     [](pli_body* body) { check(pli_body_disable_colored_links(body)); }},
    {"velocity links", [](pli_body* body) { check(pli_body_enable_velocity_links(body)); },
     [](pli_body* body) { check(pli_body_disable_velocity_links(body)); }},
    {"rigid contacts", enable_by_def<pli_body_enable_rigid_contacts, pli_rigid_contacts_def_default>,
     disable_checked<pli_body_disable_rigid_contacts>},
    {"rigid face contacts", enable_by_def<pli_body_enable_rigid_face_contacts, pli_rigid_face_contacts_def_default>,
     disable_checked<pli_body_disable_rigid_face_contacts>},
    {"soft contacts", enable_by_def<pli_body_enable_soft_contacts, pli_soft_contacts_def_default>,
     disable_checked<pli_body_disable_soft_contacts>},
    {"clusters and their contacts", enable_clusters, disable_clusters},
    {"aerodynamics", enable_aero, disable_checked<pli_body_disable_aero>},
    {"pressure", [](pli_body* body) { check(pli_body_enable_pressure(body, 1.0f)); },
     disable_checked<pli_body_disable_pressure>},
    {"volume", [](pli_body* body) { check(pli_body_enable_volume_conservation(body, 1.0f)); },
     disable_checked<pli_body_disable_volume_conservation>},
    {"pose matching", [](pli_body* body) { check(pli_body_enable_pose_matching(body, 0.1f)); },
     disable_checked<pli_body_disable_pose_matching>},
    {"self-collision of nodes", enable_by_def<pli_body_enable_self_collision, pli_self_collision_def_default>,
     disable_checked<pli_body_disable_self_collision>},
    {"self-collision of faces", enable_by_def<pli_body_enable_self_faces, pli_self_faces_def_default>,
     disable_checked<pli_body_disable_self_faces>},
    {"implicit solver", enable_by_def<pli_body_enable_implicit, pli_implicit_def_default>,
     disable_checked<pli_body_disable_implicit>},
    {"XPBD with links and contacts", enable_xpbd_all, disable_xpbd_all},
};

// A sheet at its place without gravity, so that all steps are alike, above a rigid floor that it does not reach.
class Sheet {
public:
    Sheet() {
        check(pli_context_create(nullptr, &context_));
        pli_world_def def = pli_world_def_default();
        def.gravity = pli_vec3_make(0, 0, 0);
        check(pli_world_create(context_, &def, &world_));
        pli_patch_def patch = pli_patch_def_default();
        patch.corner_00 = pli_vec3_make(-1, 1, -1);
        patch.corner_10 = pli_vec3_make(1, 1, -1);
        patch.corner_01 = pli_vec3_make(-1, 1, 1);
        patch.corner_11 = pli_vec3_make(1, 1, 1);
        patch.columns = patch.rows = size;
        patch.diagonals = true;
        pli_mesh* mesh = nullptr;
        check(pli_mesh_create_patch(context_, &patch, &mesh));
        check(pli_body_create(world_, mesh, nullptr, &body_));
        pli_mesh_destroy(mesh);
        const pli_rigid_def rigid = pli_rigid_def_default();
        pli_rigid* floor = nullptr;
        check(pli_rigid_create(world_, &rigid, &floor));
    }
    ~Sheet() {
        pli_world_destroy(world_);
        pli_context_destroy(context_);
    }
    Sheet(const Sheet&) = delete;
    Sheet& operator=(const Sheet&) = delete;

    pli_body* body() { return body_; }
    void step() { check(pli_world_step(world_, dt)); }

private:
    pli_context* context_ = nullptr;
    pli_world* world_ = nullptr;
    pli_body* body_ = nullptr;
};

constexpr int steps = 10; // timed together

double seconds_of_steps(Sheet& sheet) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < steps; ++i) {
        sheet.step();
    }
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

void run(benchmark::State& state, const Feature& feature) {
    Sheet untouched, switched;
    feature.enable(switched.body());
    switched.step();
    feature.disable(switched.body());
    untouched.step();
    std::vector<double> without, off;
    for (auto _ : state) {
        const bool is_even = without.size() % 2 == 0; // who comes first may matter
        if (is_even) { without.push_back(seconds_of_steps(untouched)); }
        off.push_back(seconds_of_steps(switched));
        if (!is_even) { without.push_back(seconds_of_steps(untouched)); }
        state.SetIterationTime((without.back() + off.back()) / (2 * steps));
    }
    const double never = median(without) / steps * 1e6, now_off = median(off) / steps * 1e6;
    state.counters["never_us"] = never;
    state.counters["off_us"] = now_off;
    state.counters["ratio"] = now_off / never;
}

} // namespace

int main(int argc, char** argv) {
    for (const Feature& feature : features) {
        benchmark::RegisterBenchmark(feature.name, [&feature](benchmark::State& state) { run(state, feature); })
            ->UseManualTime()
            ->Unit(benchmark::kMicrosecond)
            ->Iterations(1000);
    }
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
