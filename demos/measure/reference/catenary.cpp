// In a hanging chain of rods the horizontal force is the same in all of them, and the vertical one changes by the
// weight of a joint from rod to rod. What is left is one number, the horizontal force, found by bisection.

#include "catenary.h"

#include <cmath>

namespace reference {

// Vertical force in a rod over the weight of a joint; the chain is symmetric.
static double rise(int rod, int links) {
    return rod - 0.5 * (links - 1);
}

static double width(int links, double length, double horizontal) {
    double sum = 0;
    for (int rod = 0; rod < links; ++rod) {
        sum += length * horizontal / std::hypot(horizontal, rise(rod, links));
    }
    return sum;
}

std::vector<Point> hanging_chain(int links, double length, double span) {
    double low = 0, high = 1;
    while (width(links, length, high) < span) {
        high *= 2;
    }
    for (int i = 0; i < 200; ++i) {
        const double middle = 0.5 * (low + high);
        (width(links, length, middle) < span ? low : high) = middle;
    }
    std::vector<Point> points{{}};
    for (int rod = 0; rod < links; ++rod) {
        const double force = std::hypot(high, rise(rod, links));
        Point next = points.back();
        next.x += length * high / force;
        next.y += length * rise(rod, links) / force;
        points.push_back(next);
    }
    return points;
}

} // namespace reference
