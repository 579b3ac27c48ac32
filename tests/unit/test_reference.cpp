// What error against run time is measured against: closed forms, agreement of two methods, and steps that are short
// enough for the scenes.

#include "measure/workprec/scene_parts.h"

#include <algorithm>
#include <cmath>

#include "check.h"

using reference::Network;
using reference::Point;

static double distance(const Point& a, const Point& b) {
    return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

static double largest_distance(const std::vector<Point>& a, const std::vector<Point>& b) {
    assert_int_equal(a.size(), b.size());
    double largest = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        largest = std::max(largest, distance(a[i], b[i]));
    }
    return largest;
}

// Two rods hang in the shape of a V; many rods come near the curve a cosh(x / a).
static void chain_has_the_shape_of_a_catenary(void**) {
    const std::vector<Point> two = reference::hanging_chain(2, 1, 1.2);
    check_near(two[1].x, 0.6, 1e-12);
    check_near(two[1].y, -0.8, 1e-12);
    const int links = 4000;
    const double span = 1.2, length = 2;
    const std::vector<Point> fine = reference::hanging_chain(links, length / links, span);
    check_near(fine.back().x, span, 1e-12);
    check_near(fine.back().y, 0, 1e-12);
    double low = 0.01, high = 10; // length = 2 a sinh(span / (2 a))
    for (int i = 0; i < 200; ++i) {
        const double a = 0.5 * (low + high);
        (2 * a * std::sinh(span / (2 * a)) > length ? low : high) = a;
    }
    const double sag = low * (std::cosh(span / (2 * low)) - 1);
    check_near(fine[links / 2].y, -sag, 1e-6);
}

static void weight_on_a_spring_swings_as_a_cosine(void**) {
    Network network;
    network.positions = {{0, 0, 0}, {0, -1, 0}};
    network.masses = {0, 2};
    network.springs = {{0, 1, 200, 1}};
    const double rate = std::sqrt(200.0 / 2), sag = 2 * 10.0 / 200;
    const auto path = reference::trajectory(network, 0.1, 20, 200);
    for (size_t i = 0; i < path.size(); ++i) {
        const double time = 0.1 * static_cast<double>(i + 1);
        check_near(path[i][1].y, -1 - sag * (1 - std::cos(rate * time)), 1e-10);
    }
    check_near(reference::rest(network)[1].y, -1 - sag, 1e-10);
}

static const demos::PrecisionScene& scene_named(const char* name) {
    for (const demos::PrecisionScene& each : demos::precision_scenes()) {
        if (each.name == name) { return each; }
    }
    fail_msg("no scene %s", name);
    return demos::precision_scenes().front();
}

// The springs of the scene are stiff enough to stand for rods.
static void rope_rests_on_the_catenary(void**) {
    const std::vector<Point> rest = reference::rest(demos::network_of(scene_named("rope")));
    check_at_most(largest_distance(rest, reference::hanging_chain(20, 0.1, 1.2)), 5e-5);
}

// A sheet between two edges hangs like the rope; its links give way by less than a thousandth.
static void sheet_rests_near_the_catenary(void**) {
    const Network network = demos::network_of(scene_named("sheet"));
    const std::vector<Point> rest = reference::rest(network), chain = reference::hanging_chain(16, 0.1, 0.96);
    double largest = 0;
    for (size_t i = 0; i < rest.size(); ++i) {
        Point expected = chain[i % 17];
        expected.z = network.positions[i].z;
        largest = std::max(largest, distance(rest[i], expected));
    }
    check_at_most(largest, 2e-3);
}

// From other positions to the same rest, nearer than a hundredth of the smallest error that is plotted, 5e-7 of 2 m.
static void rests_are_converged(void**) {
    for (const char* name : {"sheet", "stretched", "cube"}) {
        Network network = demos::network_of(scene_named(name));
        const std::vector<Point> rest = reference::rest(network);
        for (size_t i = 0; i < rest.size(); ++i) {
            const double bump = 0.005 * std::sin(static_cast<double>(7 * i));
            if (network.masses[i] > 0.0) { network.positions[i].y += bump; }
        }
        check_at_most(largest_distance(rest, reference::rest(network)), 1e-8);
        check_at_most(reference::energy(network, rest), reference::energy(network, network.positions));
    }
}

// Half the step changes the trajectory by less than a hundredth of the smallest error that is plotted, 4e-3 of 2 m.
static void swing_is_converged(void**) {
    Network network = demos::network_of(scene_named("swing"));
    network.masses.back() += 1;
    const auto coarse = reference::trajectory(network, 0.1, 10, 4000),
               fine = reference::trajectory(network, 0.1, 10, 8000);
    check_at_most(largest_distance(coarse.back(), fine.back()), 1e-6);
    check_near(reference::energy(network, network.positions), 0, 1e-9);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chain_has_the_shape_of_a_catenary),
        cmocka_unit_test(weight_on_a_spring_swings_as_a_cosine),
        cmocka_unit_test(rope_rests_on_the_catenary),
        cmocka_unit_test(sheet_rests_near_the_catenary),
        cmocka_unit_test(rests_are_converged),
        cmocka_unit_test(swing_is_converged),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
