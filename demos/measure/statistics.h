#ifndef DEMOS_STATISTICS_H
#define DEMOS_STATISTICS_H

#include "engines/engine.h"

namespace demos {

// Of an unsorted list; 0 for an empty one.
double median(std::vector<double> values);

// Centre of mass of all soft nodes with a mass, m.
pli_vec3 center_of_mass(const Engine& engine);

} // namespace demos
#endif
