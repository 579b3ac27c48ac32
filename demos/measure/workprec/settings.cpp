// The grid of settings.

#include "workprec.h"

namespace demos {

const char* family_name(Family family) {
    static const char* const names[family_count] = {"btSoftBody",
                                                    "position-based, ordered",
                                                    "position-based, coloured",
                                                    "implicit, Jacobi",
                                                    "implicit, Chebyshev",
                                                    "implicit, gradients",
                                                    "xpbd"};
    return names[static_cast<int>(family)];
}

EngineKind engine_of(const Setting& setting) {
    return setting.family == Family::bt_soft_body ? EngineKind::bullet : EngineKind::pliant;
}

EngineOptions options_of(const Setting& setting) {
    EngineOptions options;
    options.step_seconds = 1.0f / static_cast<float>(setting.steps_per_second);
    options.solver.iterations = setting.iterations;
    options.solver.kind = SolverKind::position_based;
    switch (setting.family) {
    case Family::bt_soft_body:
    case Family::position_colored:
        break;
    case Family::position_ordered:
        options.solver.in_mesh_order = true;
        break;
    case Family::jacobi:
    case Family::chebyshev:
    case Family::gradients:
        options.solver.kind = SolverKind::implicit;
        options.solver.implicit_method = setting.family == Family::jacobi      ? PLI_IMPLICIT_JACOBI
                                         : setting.family == Family::chebyshev ? PLI_IMPLICIT_CHEBYSHEV
                                                                               : PLI_IMPLICIT_CONJUGATE_GRADIENT;
        break;
    case Family::xpbd:
        options.solver.kind = SolverKind::xpbd;
        options.solver.substeps = setting.substeps;
        break;
    }
    return options;
}

// Every combination.
static void add(std::vector<Setting>& list, Family family, const std::vector<int>& rates,
                const std::vector<int>& substeps, const std::vector<int>& iterations) {
    for (const int rate : rates) {
        for (const int parts : substeps) {
            for (const int count : iterations) {
                list.push_back({family, rate, parts, count});
            }
        }
    }
}

std::vector<Setting> settings(bool is_quick) {
    const std::vector<int> rates = is_quick ? std::vector<int>{60, 240} : std::vector<int>{30, 60, 120, 240, 480};
    const std::vector<int> iterations = is_quick ? std::vector<int>{1, 10, 40} : std::vector<int>{1, 3, 10, 30, 100};
    const std::vector<int> sweeps = is_quick ? std::vector<int>{3, 27} : std::vector<int>{1, 3, 9, 27, 81};
    std::vector<Setting> list;
    for (const Family family : {Family::bt_soft_body, Family::position_ordered, Family::position_colored}) {
        add(list, family, rates, {1}, iterations);
    }
    add(list, Family::jacobi, rates, {1}, sweeps);
    add(list, Family::chebyshev, rates, {1}, is_quick ? std::vector<int>{27} : std::vector<int>{9, 27, 81});
    add(list, Family::gradients, rates, {1}, is_quick ? std::vector<int>{40} : std::vector<int>{10, 40, 160});
    if (is_quick) {
        add(list, Family::xpbd, {60}, {4, 16, 64}, {1});
    } else {
        add(list, Family::xpbd, rates, {1, 4, 10, 25, 60, 150}, {1, 4});
    }
    return list;
}

} // namespace demos
