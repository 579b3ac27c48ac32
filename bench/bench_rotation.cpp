// Time per matrix of the nearest rotation: Pliant's with a start near the result and with a poor one, Pliant's
// iteration in Bullet's order, and Bullet's.

extern "C" {
#include "math/rotation_fit.h"
}

#include <LinearMath/btPolarDecomposition.h>

#include <benchmark/benchmark.h>

#include <cstdint>
#include <vector>

namespace {

// As in shape matching: a rotation times a moderate deformation.
struct Samples {
    std::vector<pli_mat3> matrices, rotations;
    std::vector<pli_quat> near, far;

    Samples() {
        uint64_t state = 1;
        const auto random = [&state] {
            state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
            return static_cast<float>(state >> 40) / 8388608.0f - 1.0f;
        };
        for (int i = 0; i < 1024; ++i) {
            pli_quat q;
            q.x = random(), q.y = random(), q.z = random(), q.w = random();
            pli_mat3 deformation = pli_mat3_identity();
            for (pli_vec3& row : deformation.rows) {
                row = pli_vec3_add(row, pli_vec3_scale(pli_vec3_make(random(), random(), random()), 0.2f));
            }
            matrices.push_back(pli_mat3_mul(pli_mat3_from_quat(q), deformation));
            far.push_back(pli_quat_identity());
        }
        rotations.resize(matrices.size());
        near = far;
        fit(near);
    }
    void fit(std::vector<pli_quat>& quaternions) {
        for (size_t i = 0; i < matrices.size(); ++i) {
            rotations[i] = plii_rotation_fit(&matrices[i], &quaternions[i]);
        }
    }
    int count() const { return static_cast<int>(matrices.size()); }
};

void per_matrix(benchmark::State& state, const Samples& samples) {
    state.counters["time/matrix"] =
        benchmark::Counter(static_cast<double>(samples.count()),
                           benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void fit(benchmark::State& state, bool is_near) {
    Samples samples;
    std::vector<pli_quat> quaternions;
    for (auto _ : state) {
        quaternions = is_near ? samples.near : samples.far;
        samples.fit(quaternions);
        benchmark::DoNotOptimize(samples.rotations.data());
    }
    per_matrix(state, samples);
}
BENCHMARK_CAPTURE(fit, near_start, true);
BENCHMARK_CAPTURE(fit, poor_start, false);

void polar_factor(benchmark::State& state) {
    Samples samples;
    const size_t count = samples.matrices.size();
    for (auto _ : state) {
        for (size_t i = 0; i < count; ++i) {
            samples.rotations[i] = plii_polar_factor(samples.matrices[i], pli_mat3_identity());
        }
        benchmark::DoNotOptimize(samples.rotations.data());
    }
    per_matrix(state, samples);
}
BENCHMARK(polar_factor);

void bullet_polar_decomposition(benchmark::State& state) {
    Samples samples;
    std::vector<btMatrix3x3> matrices, rotations;
    for (const pli_mat3& m : samples.matrices) {
        const pli_vec3 *x = &m.rows[0], *y = &m.rows[1], *z = &m.rows[2];
        matrices.emplace_back(x->x, x->y, x->z, y->x, y->y, y->z, z->x, z->y, z->z);
    }
    rotations.resize(matrices.size());
    const btPolarDecomposition decomposition;
    btMatrix3x3 stretch;
    for (auto _ : state) {
        for (size_t i = 0; i < matrices.size(); ++i) {
            decomposition.decompose(matrices[i], rotations[i], stretch);
        }
        benchmark::DoNotOptimize(rotations.data());
    }
    per_matrix(state, samples);
}
BENCHMARK(bullet_polar_decomposition);

} // namespace

BENCHMARK_MAIN();
