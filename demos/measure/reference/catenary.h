#ifndef DEMOS_REFERENCE_CATENARY_H
#define DEMOS_REFERENCE_CATENARY_H

#include <vector>

namespace reference {

struct Point {
    double x = 0, y = 0, z = 0;
};

// A chain of `links` rigid rods of this length between (0, 0, 0) and (span, 0, 0), equal masses at their joints, at
// rest under gravity along -y: all its points, ends included. Needs span < links * length.
std::vector<Point> hanging_chain(int links, double length, double span);

} // namespace reference
#endif
