#include "statistics.h"

#include <algorithm>

namespace demos {

double median(std::vector<double> values) {
    if (values.empty()) { return 0.0; }
    std::sort(values.begin(), values.end());
    const size_t half = values.size() / 2;
    return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

pli_vec3 center_of_mass(const Engine& engine) {
    double mass = 0, x = 0, y = 0, z = 0;
    for (size_t i = 0; i < engine.description().softs.size(); ++i) {
        const SoftState soft = engine.soft(static_cast<int>(i));
        for (size_t node = 0; node < soft.positions.size(); ++node) {
            if (!(soft.inverse_masses[node] > 0.0f)) { continue; }
            const double m = 1.0 / static_cast<double>(soft.inverse_masses[node]);
            mass += m;
            x += m * static_cast<double>(soft.positions[node].x);
            y += m * static_cast<double>(soft.positions[node].y);
            z += m * static_cast<double>(soft.positions[node].z);
        }
    }
    if (mass == 0.0) { return pli_vec3_make(0, 0, 0); }
    return pli_vec3_make(static_cast<float>(x / mass), static_cast<float>(y / mass), static_cast<float>(z / mass));
}

} // namespace demos
