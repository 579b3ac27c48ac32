// pliant workprec: what it prints and writes. Of times only that there are some.

#include "program_run.h"

#include "check.h"

#include <algorithm>
#include <limits>
#include <sstream>

using nlohmann::json;

// The smallest error of a solver.
static double best_error(const json& scene, const char* solver, size_t metric) {
    double best = std::numeric_limits<double>::infinity();
    for (const json& point : scene.at("points")) {
        const json& error = point.at("errors").at(metric);
        assert_true(point.at("ms_per_simulated_second").get<double>() > 0.0);
        if (point.at("solver") == solver && !error.is_null()) { best = std::min(best, error.get<double>()); }
    }
    return best;
}

static void test_rope_comes_near_the_catenary(void**) {
    const std::string folder = cli::scratch("precision");
    const json document = cli::run_json("workprec rope --quick --json --out " + folder);
    const json& scene = document.at("scenes").at(0);
    assert_true(scene.at("scene") == "rope" && scene.at("metrics").at(0).at("id") == "E2");
    check_at_most(best_error(scene, "btSoftBody", 0), 5e-4);
    check_at_most(best_error(scene, "position-based, coloured", 0), 5e-4);
    check_at_most(best_error(scene, "implicit, gradients", 0), 2e-4);
    check_at_most(best_error(scene, "xpbd", 0), 1e-4);
    std::istringstream lines(cli::read_file(folder + "/workprec.csv"));
    size_t count = 0;
    for (std::string line; std::getline(lines, line); ++count) {}
    assert_int_equal(count, 1 + 2 * scene.at("points").size());
    const std::string plot = cli::read_file(folder + "/workprec_rope_E2.svg");
    assert_true(plot.rfind("<svg", 0) == 0 && plot.find("btSoftBody") != std::string::npos);
}

// What one linearisation per step leaves, and what turning without friction loses.
static void test_steps_keep_what_they_should(void**) {
    const json scenes = cli::run_json("workprec residual spin --quick --json").at("scenes");
    assert_true(scenes.at(0).at("scene") == "spin" && scenes.at(1).at("scene") == "residual");
    check_near(best_error(scenes.at(1), "implicit, gradients", 0), 0.2, 0.02);
    check_at_most(best_error(scenes.at(0), "xpbd", 0), 0.01);
    check_at_most(best_error(scenes.at(0), "xpbd", 1), 0.01);
    check_at_most(best_error(scenes.at(0), "btSoftBody", 0), 0.1);
}

static void test_tables_name_the_cheapest_settings(void**) {
    const cli::Result text = cli::run("workprec rope --quick");
    assert_int_equal(text.status, 0);
    assert_true(text.output.find("rope, E3 rms stretch") != std::string::npos);
    assert_true(text.output.find("0.1 %") != std::string::npos);
    assert_true(text.output.find("ms (1/60 s, 4 x 1)") != std::string::npos);
    const cli::Result unknown = cli::run("workprec roped");
    assert_int_equal(unknown.status, 1);
    assert_true(unknown.errors.find("workprec has no scene named roped; it has: rope, swing") != std::string::npos);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rope_comes_near_the_catenary),
        cmocka_unit_test(test_steps_keep_what_they_should),
        cmocka_unit_test(test_tables_name_the_cheapest_settings),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
