#ifndef PLIANT_APP_STATISTICS_H
#define PLIANT_APP_STATISTICS_H

// Medians, and measures that the engines do not give.

#include "engines/engine.h"

namespace app {

// Of an unsorted list; 0 for an empty one.
double median(std::vector<double> values);

// Centre of mass of all soft nodes with a mass, m.
pli_vec3 center_of_mass(const demos::Engine& engine);

} // namespace app
#endif
