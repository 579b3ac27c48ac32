// Times at equal error, on points made by hand.

#include "measure/workprec/workprec.h"

#include <cmath>
#include <limits>

#include "check.h"

using demos::Family;
using demos::PrecisionPoint;

static PrecisionPoint point(Family family, double cost, double error, bool on_front = true) {
    PrecisionPoint result;
    result.setting.family = family;
    result.cost = cost;
    result.errors = {error};
    result.front = {on_front};
    return result;
}

// Time as 1 / error in both, four times as much in one of them; points of the fronts are not at the same errors.
static void parallel_fronts_have_one_ratio(void**) {
    const std::vector<PrecisionPoint> points{
        point(Family::bt_soft_body, 4, 1e-1),       point(Family::bt_soft_body, 40, 1e-2),
        point(Family::bt_soft_body, 100, 1, false), point(Family::position_colored, 0.5, 2e-1),
        point(Family::position_colored, 20, 5e-3),
    };
    const std::optional<demos::TimeRatio> ratio = time_ratio(points, Family::position_colored, 0);
    assert_true(ratio.has_value());
    check_near(ratio->least, 4, 1e-9);
    check_near(ratio->median, 4, 1e-9);
    check_near(ratio->most, 4, 1e-9);
}

// A front that starts with a smaller error costs as much for larger ones.
static void better_front_counts_from_its_cheapest_point(void**) {
    const std::vector<PrecisionPoint> points{point(Family::bt_soft_body, 1, 1e-1),
                                             point(Family::bt_soft_body, 10, 1e-2), point(Family::xpbd, 2, 1e-4)};
    const std::optional<demos::TimeRatio> ratio = time_ratio(points, Family::xpbd, 0);
    assert_true(ratio.has_value());
    check_near(ratio->least, 0.5, 1e-9);
    check_near(ratio->median, 0.5 * std::sqrt(10.0), 1e-9);
    check_near(ratio->most, 5, 1e-9);
}

static void no_ratio_without_a_common_error(void**) {
    const std::vector<PrecisionPoint> points{point(Family::bt_soft_body, 1, 1e-2), point(Family::jacobi, 1, 2e-2),
                                             point(Family::xpbd, 1, std::numeric_limits<double>::infinity(), false)};
    assert_false(time_ratio(points, Family::jacobi, 0).has_value());
    assert_false(time_ratio(points, Family::xpbd, 0).has_value());
    assert_false(time_ratio(points, Family::gradients, 0).has_value());
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parallel_fronts_have_one_ratio),
        cmocka_unit_test(better_front_counts_from_its_cheapest_point),
        cmocka_unit_test(no_ratio_without_a_common_error),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
