// Whole steps of sheets on one thread and on two in turn, medians: what docs/benchmarks.md says of threads.

#include <pliant/pliant.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <vector>

namespace {

constexpr int steps = 200, iterations = 10;
constexpr float dt = 1.0f / 60.0f, spacing = 0.01f, node_mass = 1e-4f;

enum class Solver { positions, xpbd_rigid, xpbd_compliant };

class Sheet {
public:
    // Held at two corners. With XPBD also links between every second node of rows and columns.
    Sheet(int columns, Solver solver, pli_threads* threads) {
        pli_context_def def = pli_context_def_default();
        if (threads != nullptr) {
            def.parallel_for = pli_threads_parallel_for;
            def.parallel_user = threads;
        }
        pli_mesh* mesh = nullptr;
        is_made_ = pli_context_create(&def, &context_) == PLI_OK && pli_mesh_create(context_, &mesh) == PLI_OK &&
                   pli_world_create(context_, nullptr, &world_) == PLI_OK;
        fill(mesh, columns, solver != Solver::positions);
        is_made_ = is_made_ && pli_body_create(world_, mesh, nullptr, &body_) == PLI_OK;
        pli_mesh_destroy(mesh);
        is_made_ = is_made_ && (solver == Solver::positions ? use_positions() : use_xpbd(solver));
    }
    ~Sheet() {
        pli_world_destroy(world_);
        pli_context_destroy(context_);
    }
    Sheet(const Sheet&) = delete;
    Sheet& operator=(const Sheet&) = delete;

    bool is_made() const { return is_made_; }
    uint64_t state_hash() const { return pli_body_state_hash(body_); }

    double step_milliseconds() {
        const auto begin = std::chrono::steady_clock::now();
        is_made_ = pli_world_step(world_, dt) == PLI_OK && is_made_;
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    }

private:
    void fill(pli_mesh* mesh, int columns, bool has_bending) {
        const int ways[6][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}, {2, 0}, {0, 2}};
        for (int i = 0; i < columns * columns && is_made_; ++i) {
            const float x = spacing * static_cast<float>(i % columns), z = spacing * static_cast<float>(i / columns);
            const bool is_held = i == 0 || i == columns - 1;
            is_made_ =
                pli_mesh_append_node(mesh, pli_vec3_make(x, 0, z), is_held ? 0.0f : node_mass, nullptr) == PLI_OK;
        }
        for (int i = 0; i < columns * columns && is_made_; ++i) {
            for (int k = 0; k < (has_bending ? 6 : 4); ++k) {
                const int x = i % columns + ways[k][0], y = i / columns + ways[k][1];
                if (x < 0 || x >= columns || y >= columns) { continue; }
                is_made_ = pli_mesh_append_link(mesh, i, y * columns + x, 0, nullptr) == PLI_OK && is_made_;
            }
        }
    }
    bool use_positions() {
        pli_solver_settings settings = pli_body_get_solver_settings(body_);
        settings.position_iterations = iterations;
        return pli_body_enable_colored_links(body_) == PLI_OK &&
               pli_body_set_solver_settings(body_, &settings) == PLI_OK;
    }
    bool use_xpbd(Solver solver) {
        pli_xpbd_def def = pli_xpbd_def_default();
        def.substeps = iterations;
        pli_xpbd_links_def links = pli_xpbd_links_def_default();
        links.compliance = links.bending_compliance = solver == Solver::xpbd_compliant ? 1e-6f : 0.0f;
        return pli_body_enable_xpbd(body_, &def) == PLI_OK && pli_body_enable_xpbd_links(body_, &links) == PLI_OK;
    }

    pli_context* context_ = nullptr;
    pli_world* world_ = nullptr;
    pli_body* body_ = nullptr;
    bool is_made_ = false;
};

double median(std::vector<double> times) {
    std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2), times.end());
    return times[times.size() / 2];
}

// In turn for `run` steps each.
bool compare(const char* name, int columns, Solver solver, int run) {
    pli_threads* pool = nullptr;
    if (pli_threads_create(2, &pool) != PLI_OK) { return false; }
    const std::unique_ptr<pli_threads, void (*)(pli_threads*)> threads(pool, pli_threads_destroy);
    Sheet alone(columns, solver, nullptr), shared(columns, solver, pool);
    std::vector<double> one, two;
    for (int i = 0; i < steps && alone.is_made() && shared.is_made(); i += run) {
        for (int k = 0; k < run; ++k) {
            one.push_back(alone.step_milliseconds());
        }
        for (int k = 0; k < run; ++k) {
            two.push_back(shared.step_milliseconds());
        }
    }
    if (!alone.is_made() || !shared.is_made()) { return false; }
    std::printf("%-33s %3d in turn: one %.3f ms, two %.3f ms, ratio %.2f%s\n", name, run, median(one), median(two),
                median(one) / median(two), alone.state_hash() == shared.state_hash() ? "" : ", results differ");
    return true;
}

} // namespace

int main() {
    bool is_done = true;
    for (const int run : {1, steps}) {
        is_done = is_done && compare("128 x 128, ten sweeps", 128, Solver::positions, run) &&
                  compare("256 x 256, ten sweeps", 256, Solver::positions, run) &&
                  compare("128 x 128, XPBD, ten substeps", 128, Solver::xpbd_rigid, run) &&
                  compare("128 x 128, XPBD with compliance", 128, Solver::xpbd_compliant, run);
    }
    return is_done ? 0 : 1;
}
