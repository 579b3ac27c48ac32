#ifndef DEMOS_REFERENCE_MASS_SPRING_H
#define DEMOS_REFERENCE_MASS_SPRING_H

// Masses and springs in double precision: trajectories by the classical Runge-Kutta method, rest by Newton's.

#include "catenary.h"

#include <vector>

namespace reference {

struct Spring {
    int a = 0, b = 0;
    double stiffness = 0; // N/m
    double length = 0;    // m, at rest
};

struct Network {
    std::vector<Point> positions;
    std::vector<double> masses; // kg; 0: pinned
    std::vector<Spring> springs;
    Point gravity{0, -10, 0};
};

// Positions after each of `samples` intervals, from rest; `steps` per interval.
std::vector<std::vector<Point>> trajectory(const Network& network, double interval, int samples, int steps);

// Where the network comes to rest, from its present positions, until no node's force exceeds `tolerance` times the
// weight of the whole. The state it finds is stable.
std::vector<Point> rest(const Network& network, double tolerance = 1e-10);

// By springs and gravity, m/s^2; zero for pinned masses.
std::vector<Point> accelerations(const Network& network, const std::vector<Point>& positions);

// J, springs and gravity.
double energy(const Network& network, const std::vector<Point>& positions);

} // namespace reference
#endif
