// Whole comparison of a scene: one step, free run and time.

#include "compare.h"

#include "description/recorder.h"
#include "measure.h"
#include "statistics.h"

#include <algorithm>
#include <cmath>

namespace demos {

namespace {

// Largest distance between the same nodes; infinite once one of them is not finite.
double largest_distance(const Engine& a, const Engine& b) {
    double largest = 0.0;
    for (size_t i = 0; i < a.description().softs.size(); ++i) {
        const SoftState state_a = a.soft(static_cast<int>(i)), state_b = b.soft(static_cast<int>(i));
        if (state_a.positions.size() != state_b.positions.size()) { return HUGE_VAL; } // cut differently
        for (size_t k = 0; k < state_a.positions.size(); ++k) {
            const pli_vec3 d = pli_vec3_sub(state_a.positions[k], state_b.positions[k]);
            const double distance = static_cast<double>(pli_vec3_length(d));
            largest = std::isfinite(distance) ? std::max(largest, distance) : HUGE_VAL;
        }
    }
    return largest;
}

} // namespace

EngineOptions bullet_options(const EngineOptions& options, SolverKind of_pliant) {
    EngineOptions result;
    result.step_seconds = options.step_seconds;
    // Sweeps of another solver say nothing about iterations of this one.
    if (of_pliant == SolverKind::position_based) { result.solver.iterations = options.solver.iterations; }
    return result;
}

EngineOptions reference_options(const EngineOptions& options, Witness witness) {
    EngineOptions result = options;
    result.reference = true;
    result.bullet_witness = witness == Witness::bullet;
    return result;
}

Comparison compare(const Description& description, int frames, const Progress& progress, Witness witness,
                   const EngineOptions& options) {
    Comparison result;
    result.solver = choose_solver(description, EngineKind::pliant, options);
    const bool is_same_solver = result.solver.kind == SolverKind::position_based;
    const int frames_before = is_same_solver ? frames : 0, steps = frames_before + frames;
    result.scene = description.source != nullptr ? description.source->name : "";
    const Progress first_half = [&](int frame, int) {
        if (progress) { progress(frame, steps); }
    };
    if (is_same_solver) { result.one_step = compare_one_step(description, frames, first_half, witness, options); }

    // The engine as it is used is timed, against the same run of btSoftBody that the errors come from.
    const auto bullet = make_engine(EngineKind::bullet, description, bullet_options(options, result.solver.kind));
    const auto pliant = make_engine(EngineKind::pliant, description, options);
    const auto reference_mode =
        is_same_solver ? make_engine(EngineKind::pliant, description, reference_options(options, witness)) : nullptr;
    const double diagonal = bounds_diagonal(description.rest_bounds);
    std::vector<double> bullet_times, pliant_times;
    for (int frame = 1; frame <= frames; ++frame) {
        bullet->step();
        bullet_times.push_back(bullet->step_milliseconds());
        pliant->step();
        pliant_times.push_back(pliant->step_milliseconds());
        if (reference_mode != nullptr) { reference_mode->step(); }
        FreeRun& free_run = result.free_run;
        double* error = frame == 30    ? &free_run.error_30
                        : frame == 60  ? &free_run.error_60
                        : frame == 300 ? &free_run.error_300
                                       : nullptr;
        const Engine& compared = reference_mode != nullptr ? *reference_mode : *pliant;
        if (error != nullptr) { *error = largest_distance(*bullet, compared) / diagonal; }
        if (progress) { progress(frames_before + frame, steps); }
    }
    result.nodes = measure(*bullet).nodes;
    result.bullet_ms = median(bullet_times);
    result.pliant_ms = median(pliant_times);
    result.time_ratio = result.bullet_ms / result.pliant_ms;
    return result;
}

} // namespace demos
