// What the object files say a program links is what a linker takes.

#include "measure/core_modules.h"
#include "scene_records.h"

#include <algorithm>
#include <fstream>
#include <regex>
#include <set>

#include "check.h" // after what has functions named fail

namespace {

// "path/libpliant.a(world.c.o)"
std::vector<std::string> modules_in_map(const char* path) {
    std::set<std::string> found;
    const std::regex member("libpliant\\.a\\(([a-z0-9_]+)\\.c\\.o\\)");
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::smatch match;
        if (std::regex_search(line, match, member)) { found.insert(match[1]); }
    }
    return {found.begin(), found.end()};
}

bool has(const std::vector<std::string>& names, const char* name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

} // namespace

static void modules_are_those_that_a_linker_takes(void**) {
    const demos::LinkedCore linked =
        demos::linked_core({"pli_context_create", "pli_world_create", "pli_world_step", "pli_mesh_create_patch",
                            "pli_body_create", "pli_rigid_create", "pli_shape_create_plane"},
                           {"rigid contacts"});
    const std::vector<std::string> expected = modules_in_map(CLOTH_MAP);
    assert_true(expected.size() > 10);
    assert_true(linked.modules == expected);
    assert_true(has(linked.modules, "node_rigid_contacts"));
    assert_false(has(linked.modules, "force_pressure"));
    assert_true(linked.bytes > 10000);
    assert_true(linked.bytes < demos::core_bytes() / 2);
}

static void more_features_link_more(void**) {
    const size_t without = demos::linked_core({"pli_world_step"}, {"links"}).bytes;
    const size_t with = demos::linked_core({"pli_world_step"}, {"links", "pressure"}).bytes;
    assert_true(with > without);
    assert_int_equal(demos::linked_core({"pli_world_step"}, {"links", "links"}).bytes, without);
}

static void features_are_known_by_the_names_of_the_core(void**) {
    const std::vector<std::string> names = demos::core_features();
    assert_true(names.size() > 30);
    for (const char* name : {"links", "clusters", "XPBD solver", "rigid contacts", "self-collision of faces"}) {
        assert_true(has(names, name));
    }
    assert_false(has(names, "bullet")); // a solver, which is no feature
    assert_int_equal(std::set<std::string>(names.begin(), names.end()).size(), names.size());
    assert_string_equal(error_of([] { (void)demos::linked_core({}, {"magic"}); }).c_str(), "the core has no magic");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(modules_are_those_that_a_linker_takes),
        cmocka_unit_test(more_features_link_more),
        cmocka_unit_test(features_are_known_by_the_names_of_the_core),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
