// pliant bench: what it prints and writes. Times are of no interest here, only that there are some.

#include "program_run.h"

#include "check.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

using nlohmann::json;

static void expect_keys(const json& object, const std::vector<std::string>& keys) {
    for (const std::string& key : keys) {
        if (!object.contains(key)) { fail_msg("no key %s in %s", key.c_str(), object.dump().c_str()); }
    }
}

static void expect_positive(const json& number) {
    assert_true(number.is_number());
    assert_true(std::isfinite(number.get<double>()) && number.get<double>() > 0.0);
}

static void expect_engine(const json& engine) {
    expect_keys(engine, {"median_ms", "minimum_ms", "mean_ms", "predict_ms", "collide_ms", "solve_ms", "world_step_ms",
                         "setup_ms", "rms_stretch", "max_stretch", "finite", "bytes_per_node", "allocations_per_step",
                         "last_allocating_frame"});
    for (const char* key : {"median_ms", "minimum_ms", "mean_ms", "world_step_ms", "setup_ms", "bytes_per_node"}) {
        expect_positive(engine.at(key));
    }
    assert_true(engine.at("finite").get<bool>());
    assert_true(engine.at("minimum_ms").get<double>() <= engine.at("median_ms").get<double>());
    assert_true(engine.at("median_ms").get<double>() <= engine.at("world_step_ms").get<double>());
}

static void test_bench_prints_figures_of_each_scene(void**) {
    const std::string file = cli::scratch("bench.csv");
    const json document = cli::run_json("bench bunny TetraCube Impact --quick --frames 20 --json --csv " + file);
    expect_positive(document.at("geometric_mean"));
    expect_positive(document.at("reference_geometric_mean"));
    const json& scenes = document.at("scenes");
    assert_int_equal(scenes.size(), 3);
    for (const json& row : scenes) {
        expect_keys(row,
                    {"scene", "nodes", "links", "clusters", "bodies", "ratio", "reference_ratio", "world_step_ratio",
                     "pliant", "reference", "bullet", "ns_per_link", "ns_per_contact", "ns_per_cluster", "stages"});
        for (const char* key : {"ratio", "reference_ratio", "world_step_ratio", "ns_per_link"}) {
            expect_positive(row.at(key));
        }
        for (const char* engine : {"pliant", "reference", "bullet"}) {
            expect_engine(row.at(engine));
        }
    }
    assert_string_equal(scenes[0].at("scene").get<std::string>().c_str(), "Bunny");
    assert_int_equal(scenes[0].at("nodes").get<int>(), 453);
    assert_true(scenes[0].at("ns_per_cluster").is_null());
    expect_positive(scenes[1].at("ns_per_cluster"));
    std::istringstream lines(cli::read_file(file));
    std::ptrdiff_t commas = 0;
    int count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
        const auto here = std::count(line.begin(), line.end(), ',');
        if (count == 0) { commas = here; }
        assert_int_equal(here, commas);
    }
    assert_int_equal(count, 4);
}

static void test_bench_shows_stages(void**) {
    const json document = cli::run_json("bench Cloth --quick --frames 12 --json");
    bool has_links = false;
    for (const json& stage : document.at("scenes")[0].at("stages")) {
        assert_true(stage.at("microseconds").get<double>() >= 0.0);
        has_links = has_links || (stage.at("stage") == "position" && stage.at("feature") == "links");
    }
    assert_true(has_links);
    const cli::Result text = cli::run("bench Cloth --quick --frames 12");
    assert_int_equal(text.status, 0);
    assert_true(text.output.find("us per step") != std::string::npos);
    assert_true(text.output.find("rigid contacts") != std::string::npos);
}

static void test_bench_runs_a_series(void**) {
    const json scenes = cli::run_json("bench --series bodies --quick --frames 3 --json").at("scenes");
    assert_int_equal(scenes.size(), 4);
    int bodies = 1;
    for (const json& row : scenes) {
        assert_int_equal(row.at("bodies").get<int>(), bodies);
        assert_int_equal(row.at("nodes").get<int>(), 100 * bodies);
        assert_true(row.at("reference").is_null());
        expect_positive(row.at("ratio"));
        bodies *= 10;
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bench_prints_figures_of_each_scene),
        cmocka_unit_test(test_bench_shows_stages),
        cmocka_unit_test(test_bench_runs_a_series),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
