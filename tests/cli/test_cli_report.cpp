// pliant report: what it prints and writes. Of times only that there are some.

#include "program_run.h"

#include "check.h"

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
    for (const char* scene : {"Bunny", "RopeAttach", "TetraBunny", "Cutting1"}) {
        assert_int_equal(count_of(page, std::string("<td>") + scene + "</td>"), 3);
    }
}

static void test_parts_can_be_chosen(void**) {
    const std::string folder = cli::scratch("costs");
    assert_int_equal(cli::run("report costs --quick --out " + folder).status, 0);
    const std::string page = cli::read_file(folder + "/index.html");
    assert_int_equal(count_of(page, "<h2"), 2); // machine and costs
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
