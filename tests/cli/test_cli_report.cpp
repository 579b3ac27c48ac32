// pliant report: what it prints and writes. Of times only that there are some.

#include "program_run.h"

#include "check.h"

#include <cstdio>

using nlohmann::json;

static size_t count_of(const std::string& text, const std::string& part) {
    size_t count = 0;
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
        ++count;
    }
    return count;
}

static void test_report_is_one_page_without_network(void**) {
    const std::string folder = cli::scratch("report");
    const cli::Result result = cli::run("report --quick --out " + folder);
    assert_int_equal(result.status, 0);
    assert_true(result.output.find("/report/index.html") != std::string::npos);
    const std::string page = cli::read_file(folder + "/index.html");
    assert_true(page.rfind("<!DOCTYPE html>", 0) == 0);
    assert_int_equal(count_of(page, "</html>"), 1);
    const bool has_pictures = page.find("No pictures: ") == std::string::npos;
    assert_int_equal(count_of(page, "src=\"data:image/png;base64,iVBOR"), has_pictures ? 4 : 0);
    assert_int_equal(count_of(page, "src="), count_of(page, "src=\"data:"));
    assert_int_equal(count_of(page, "href="), count_of(page, "href=\"#"));
    assert_int_equal(count_of(page, "http"), count_of(page, "http://www.w3.org/2000/svg"));
    assert_int_equal(count_of(page, "<svg"), 5); // four plots and the map
    assert_int_equal(count_of(page, "<h2"), count_of(page, "</h2>"));
    assert_int_equal(count_of(page, "<figure"), count_of(page, "</figure>"));
    const json comparison = json::parse(cli::read_file(folder + "/data/compare.json"));
    assert_int_equal(comparison.at("scenes").size(), 4);
    assert_int_equal(comparison.at("scenes").at(0).at("one_step").at("unexplained_frames"), 0);
    // At its end conclusions, from the figures that were measured, and then the machine.
    const size_t last = page.rfind("<h2"), end = page.find("<h2 id=\"conclusions\"");
    assert_true(page.compare(last, 16, "<h2 id=\"machine\"") == 0);
    assert_true(end < last && page.find("<h2", end + 1) == last && page.find("id=\"costs\"") < end);
    const std::string conclusions = page.substr(end, last - end);
    assert_true(count_of(conclusions, "<li>") >= 8);
    assert_int_equal(count_of(conclusions, "<h3>"), 3); // better, dearer, which solver
    const json speed = json::parse(cli::read_file(folder + "/data/bench.json"));
    int touching = 0;
    for (const json& scene : speed.at("scenes")) {
        const int frames = scene.at("touching_frames");
        assert_int_equal(scene.at("frames"), 300);
        assert_in_range(frames, 0, 300);
        assert_int_equal(scene.at("touching_ratio").is_null(), frames == 0);
        touching += frames > 0 ? 1 : 0;
    }
    assert_true(touching >= 2); // the bunnies land
    const double mean = speed.at("touching_geometric_mean");
    char text[80];
    std::snprintf(text, sizeof text, mean < 10 ? "%.1f times as fast" : "%.0f times as fast", mean);
    assert_true(conclusions.find("While bodies touch, a step of the soft bodies is " + std::string(text)) !=
                std::string::npos);
    assert_true(conclusions.find("geometric mean of " + std::to_string(touching) + " scenes") != std::string::npos);
    assert_true(conclusions.find("rope, rms stretch: at equal error ") != std::string::npos);
    assert_true(conclusions.find("Extreme cases survived: btSoftBody ") != std::string::npos);
    if (has_pictures) { assert_true(page.find("None of them is in reference mode") != std::string::npos); }
    for (const char* scene : {"Bunny", "RopeAttach", "TetraBunny", "Cutting1"}) {
        assert_int_equal(count_of(page, std::string("<td>") + scene + "</td>"), 3);
    }
}

static void test_parts_can_be_chosen(void**) {
    const std::string folder = cli::scratch("costs");
    assert_int_equal(cli::run("report costs --quick --out " + folder).status, 0);
    const std::string page = cli::read_file(folder + "/index.html");
    assert_int_equal(count_of(page, "<h2"), 3); // costs, conclusions and machine
    assert_int_equal(count_of(cli::read_file(folder + "/data/costs.md"), "\n"), 2 + 4);
    const json costs = json::parse(cli::read_file(folder + "/data/costs.json"));
    assert_true(costs.at("scenes").at(3).at("scene") == "Cutting1");
    assert_int_equal(cli::run("report cost --out " + folder).status, 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts_can_be_chosen),
        cmocka_unit_test(test_report_is_one_page_without_network),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
