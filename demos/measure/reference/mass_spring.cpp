#include "mass_spring.h"

#include <cmath>
#include <cstddef>

namespace reference {

namespace {

Point operator+(const Point& a, const Point& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Point operator-(const Point& a, const Point& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Point operator*(double s, const Point& a) {
    return {s * a.x, s * a.y, s * a.z};
}
double dot(const Point& a, const Point& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

using Points = std::vector<Point>;

double dot(const Points& a, const Points& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        sum += dot(a[i], b[i]);
    }
    return sum;
}

// a + s b
Points plus(const Points& a, double s, const Points& b) {
    Points sum(a.size());
    for (size_t i = 0; i < a.size(); ++i) {
        sum[i] = a[i] + s * b[i];
    }
    return sum;
}

size_t index(int node) {
    return static_cast<size_t>(node);
}

// Forces, none on pinned nodes, N.
Points forces(const Network& network, const Points& positions) {
    Points sum(positions.size());
    for (size_t i = 0; i < positions.size(); ++i) {
        sum[i] = network.masses[i] * network.gravity;
    }
    for (const Spring& spring : network.springs) {
        const Point d = positions[index(spring.b)] - positions[index(spring.a)];
        const double length = std::sqrt(dot(d, d));
        const Point force = (spring.stiffness * (length - spring.length) / length) * d;
        sum[index(spring.a)] = sum[index(spring.a)] + force;
        sum[index(spring.b)] = sum[index(spring.b)] - force;
    }
    for (size_t i = 0; i < positions.size(); ++i) {
        if (!(network.masses[i] > 0.0)) { sum[i] = {}; }
    }
    return sum;
}

} // namespace

std::vector<Point> accelerations(const Network& network, const Points& positions) {
    Points result = forces(network, positions);
    for (size_t i = 0; i < result.size(); ++i) {
        if (network.masses[i] > 0.0) { result[i] = (1.0 / network.masses[i]) * result[i]; }
    }
    return result;
}

namespace {

struct State {
    Points x, v;
};

void runge_kutta(const Network& network, State& state, double h) {
    const Points a1 = accelerations(network, state.x);
    const Points v2 = plus(state.v, 0.5 * h, a1);
    const Points a2 = accelerations(network, plus(state.x, 0.5 * h, state.v));
    const Points v3 = plus(state.v, 0.5 * h, a2);
    const Points a3 = accelerations(network, plus(state.x, 0.5 * h, v2));
    const Points v4 = plus(state.v, h, a3);
    const Points a4 = accelerations(network, plus(state.x, h, v3));
    for (size_t i = 0; i < state.x.size(); ++i) {
        state.x[i] = state.x[i] + (h / 6) * (state.v[i] + 2 * v2[i] + 2 * v3[i] + v4[i]);
        state.v[i] = state.v[i] + (h / 6) * (a1[i] + 2 * a2[i] + 2 * a3[i] + a4[i]);
    }
}

// The second derivative of the energy times a direction; `shift` (N/m) is added to it, and where springs are pressed
// what would let them buckle is left out unless `is_exact`.
Points stiffness_times(const Network& network, const Points& positions, const Points& direction, double shift,
                       bool is_exact) {
    Points sum(positions.size());
    for (size_t i = 0; i < sum.size(); ++i) {
        sum[i] = shift * direction[i];
    }
    for (const Spring& spring : network.springs) {
        const Point d = positions[index(spring.b)] - positions[index(spring.a)];
        const double length = std::sqrt(dot(d, d));
        const Point u = (1.0 / length) * d;
        const Point e = direction[index(spring.b)] - direction[index(spring.a)];
        double across = spring.stiffness * (1 - spring.length / length);
        if (!is_exact && across < 0.0) { across = 0.0; }
        const double along = dot(u, e);
        const Point part = (spring.stiffness * along) * u + across * (e - along * u);
        sum[index(spring.a)] = sum[index(spring.a)] - part;
        sum[index(spring.b)] = sum[index(spring.b)] + part;
    }
    for (size_t i = 0; i < sum.size(); ++i) {
        if (!(network.masses[i] > 0.0)) { sum[i] = {}; }
    }
    return sum;
}

// Conjugate gradients; stops where the energy has no curvature.
Points newton_direction(const Network& network, const Points& positions, const Points& force, double shift,
                        bool is_exact) {
    Points solution(force.size()), residual = force, direction = force;
    double squared = dot(residual, residual);
    const double goal = 1e-16 * squared;
    for (size_t i = 0; i < 6 * force.size() && squared > goal; ++i) {
        const Points image = stiffness_times(network, positions, direction, shift, is_exact);
        const double curvature = dot(direction, image);
        if (!(curvature > 0.0)) { return i == 0 ? force : solution; }
        const double step = squared / curvature;
        solution = plus(solution, step, direction);
        residual = plus(residual, -step, image);
        const double next = dot(residual, residual);
        direction = plus(residual, next / squared, direction);
        squared = next;
    }
    return solution;
}

} // namespace

double energy(const Network& network, const Points& positions) {
    double sum = 0;
    for (size_t i = 0; i < positions.size(); ++i) {
        sum -= network.masses[i] * dot(network.gravity, positions[i]);
    }
    for (const Spring& spring : network.springs) {
        const Point d = positions[index(spring.b)] - positions[index(spring.a)];
        const double stretch = std::sqrt(dot(d, d)) - spring.length;
        sum += 0.5 * spring.stiffness * stretch * stretch;
    }
    return sum;
}

std::vector<Points> trajectory(const Network& network, double interval, int samples, int steps) {
    State state{network.positions, Points(network.positions.size())};
    std::vector<Points> result;
    for (int sample = 0; sample < samples; ++sample) {
        for (int i = 0; i < steps; ++i) {
            runge_kutta(network, state, interval / steps);
        }
        result.push_back(state.x);
    }
    return result;
}

Points rest(const Network& network, double tolerance) {
    Points positions = network.positions;
    double weight = 0, stiffest = 0;
    for (const double mass : network.masses) {
        weight += mass * std::sqrt(dot(network.gravity, network.gravity));
    }
    for (const Spring& spring : network.springs) {
        stiffest = std::fmax(stiffest, spring.stiffness);
    }
    const auto largest = [](const Points& list) {
        double result = 0;
        for (const Point& p : list) {
            result = std::fmax(result, std::sqrt(dot(p, p)));
        }
        return result;
    };
    double shift = 1e-3 * stiffest;
    Points force = forces(network, positions);
    for (int i = 0; i < 2000 && largest(force) > tolerance * weight; ++i) {
        const bool is_exact = largest(force) < 1e-3 * weight;
        const Points direction = newton_direction(network, positions, force, is_exact ? 0.0 : shift, is_exact);
        const double slope = dot(force, direction), here = energy(network, positions);
        double step = 1;
        while (step > 1e-9 && energy(network, plus(positions, step, direction)) > here - 1e-4 * step * slope) {
            step *= 0.5;
        }
        // Near the end the energy no longer shows what is better.
        if (is_exact && step < 1) { step = 1; }
        shift = step < 1 ? 2 * shift : 0.3 * shift;
        positions = plus(positions, step, direction);
        force = forces(network, positions);
    }
    return positions;
}

} // namespace reference
