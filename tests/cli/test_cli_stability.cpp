// pliant stability: what it prints and writes.

#include "program_run.h"

#include "check.h"

#include <cstring>
#include <sstream>

using nlohmann::json;

static const json& cell(const json& document, const std::string& name, const char* solver) {
    for (const json& each : document.at("cells")) {
        if (each.at("case") == name && each.at("solver") == solver) { return each; }
    }
    fail_msg("no cell of %s with %s", name.c_str(), solver);
    return document;
}

static void test_forces_of_nan_are_refused(void**) {
    const std::string folder = cli::scratch("map");
    const json document = cli::run_json("stability input --json --out " + folder);
    assert_int_equal(document.at("cells").size(), 2 * 5);
    const json& bullet = cell(document, "force of NaN on a node", "btSoftBody");
    assert_true(bullet.at("verdict") == "NaN" && !bullet.at("survives").get<bool>() && bullet.at("value").is_null());
    for (const char* solver : {"position-based", "implicit", "gradients", "xpbd"}) {
        const json& refused = cell(document, "force of NaN on a node", solver);
        assert_true(refused.at("verdict") == "refused" && refused.at("survives").get<bool>());
        assert_non_null(std::strstr(refused.at("note").get<std::string>().c_str(), "not finite"));
        const json& huge = cell(document, "force of 1e30 N on a node", solver);
        assert_true(huge.at("verdict") == "ok" && huge.at("value").get<double>() < 0.01);
    }
    std::istringstream lines(cli::read_file(folder + "/stability.csv"));
    int count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
        if (count == 0) { assert_string_equal(line.substr(0, 26).c_str(), "group,case,solver,verdict,"); }
    }
    assert_int_equal(count, 1 + 2 * 5);
    const std::string picture = cli::read_file(folder + "/stability.svg");
    assert_true(picture.rfind("<svg", 0) == 0 && picture.find("force of NaN on a node") != std::string::npos);
}

static void test_groups_are_named(void**) {
    const cli::Result text = cli::run("stability gravity");
    assert_int_equal(text.status, 0);
    assert_true(text.output.find("hanging sheet, 1000 m/s2") != std::string::npos);
    assert_true(text.output.find(" of 2") != std::string::npos);
    assert_true(cli::run("stability gravity --jobs 1").output == text.output);
    assert_int_equal(cli::run("stability gravity --jobs 0").status, 2);
    assert_true(cli::run("stability --help").output.find("all but heavy and random") != std::string::npos);
    const cli::Result unknown = cli::run("stability gravitas");
    assert_int_equal(unknown.status, 1);
    assert_true(unknown.errors.find("no group of cases named gravitas; there are: stiffness, mass ratio") !=
                std::string::npos);
    assert_true(unknown.errors.find("input, heavy, random") != std::string::npos);
}

// btSoftBody loses some of these cases, as Pliant in reference mode would.
static void test_random_cases_follow_from_seed_and_number(void**) {
    const json document = cli::run_json("stability random --seed 1 --count 5 --json");
    const json& cells = document.at("cells");
    assert_int_equal(cells.size(), 5 * 5);
    int lost = 0;
    for (const json& each : cells) {
        assert_true(each.at("group") == "random");
        if (each.at("solver") == "btSoftBody") {
            lost += each.at("survives").get<bool>() ? 0 : 1;
        } else if (!each.at("survives").get<bool>()) {
            fail_msg("%s", each.dump().c_str());
        }
    }
    assert_true(lost > 0);
    assert_true(cli::run_json("stability random --count 5 --json") == document);
    const json other = cli::run_json("stability random --seed 2 --count 1 --json");
    assert_true(other.at("cells")[0].at("case") != cells[0].at("case"));
    assert_int_equal(cli::run("stability gravity --seed 2").status, 2);
    assert_int_equal(cli::run("stability random --count 0").status, 2);
}

static void test_soak_counts_what_it_survives(void**) {
    const json soak = cli::run_json("stability --soak 0.001 --seed 7 --json");
    assert_int_equal(soak.at("seed"), 7);
    assert_true(soak.at("sequences") >= 50 && soak.at("long_sequences") >= 30 && soak.at("calls") >= 1000);
    assert_true(soak.at("steps") > 0 && soak.at("cuts") > 0 && soak.at("refused") > 0);
    const cli::Result text = cli::run("stability --soak 0 --seed 7");
    assert_int_equal(text.status, 0);
    assert_true(text.output.find("50 sequences\n") != std::string::npos);
    assert_int_equal(cli::run("stability --seed 7").status, 2);
    assert_int_equal(cli::run("stability --soak -1").status, 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_forces_of_nan_are_refused),
        cmocka_unit_test(test_groups_are_named),
        cmocka_unit_test(test_random_cases_follow_from_seed_and_number),
        cmocka_unit_test(test_soak_counts_what_it_survives),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
