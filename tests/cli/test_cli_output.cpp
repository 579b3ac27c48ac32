// What the subcommands print and write when all goes well.

#include "program_run.h"

#include "check.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>
#include <vector>

using cli::scratch;
using nlohmann::json;

static std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) {
        lines.push_back(line);
    }
    return lines;
}

static void expect_keys(const json& object, const std::vector<std::string>& keys) {
    for (const std::string& key : keys) {
        if (!object.contains(key)) { fail_msg("no key %s in %s", key.c_str(), object.dump().c_str()); }
    }
}

static void test_cli_help_of_everything(void**) {
    for (const char* command : {"", "list ", "run ", "compare ", "bench ", "demo ", "view "}) {
        const cli::Result result = cli::run(command + std::string("--help"));
        assert_int_equal(result.status, 0);
        assert_true(result.output.find("Usage: pliant " + std::string(command)) != std::string::npos);
        assert_string_equal(result.errors.c_str(), "");
    }
    assert_string_equal(cli::run("--version").output.c_str(), "pliant 0.1.0\n");
}

static void test_cli_list_names_every_scene(void**) {
    const json document = cli::run_json("list --json");
    const json& scenes = document.at("scenes");
    const std::vector<std::string> text = lines_of(cli::run("list").output);
    assert_int_equal(text.size(), scenes.size());
    std::set<std::string> names;
    for (size_t i = 0; i < scenes.size(); ++i) {
        expect_keys(scenes[i],
                    {"name", "summary", "takes_mesh", "takes_tetra", "takes_resolution", "group", "picture_frame"});
        assert_string_equal(scenes[i].at("group").get<std::string>().c_str(), i < 33 ? "bullet" : "own");
        assert_true((text[i].find("(own scene)") != std::string::npos) == (i >= 33));
        const std::string name = scenes[i].at("name");
        assert_true(text[i].rfind(name + " ", 0) == 0);
        names.insert(name);
    }
    assert_int_equal(names.size(), scenes.size());
    for (const char* name : {"Cloth",
                             "Pressure",
                             "Volume",
                             "Ropes",
                             "RopeAttach",
                             "ClothAttach",
                             "Sticks",
                             "Bending",
                             "CapsuleCollision",
                             "Collide",
                             "Collide2",
                             "Collide3",
                             "Impact",
                             "Aero",
                             "Aero2",
                             "Friction",
                             "TorusMatch",
                             "Bunny",
                             "BunnyMatch",
                             "Torus",
                             "Cutting1",
                             "ClusterDeform",
                             "ClusterCollide1",
                             "ClusterCollide2",
                             "ClusterSocket",
                             "ClusterHinge",
                             "ClusterCombine",
                             "ClusterCar",
                             "ClusterRobot",
                             "ClusterStackSoft",
                             "ClusterStackMixed",
                             "TetraBunny",
                             "TetraCube"}) {
        assert_true(names.count(name) == 1);
    }
}

static void test_cli_run_prints_measures(void**) {
    for (const char* engine : {"bullet", "pliant"}) {
        const json run = cli::run_json("run bunny --frames 3 --json --engine " + std::string(engine));
        expect_keys(run, {"scene", "engine", "solver", "frames", "nodes", "links", "faces", "tetras", "clusters",
                          "ms_per_step", "finite", "max_stretch", "kinetic_energy", "state_hash"});
        assert_string_equal(run.at("scene").get<std::string>().c_str(), "Bunny");
        assert_string_equal(run.at("engine").get<std::string>().c_str(), engine);
        assert_string_equal(run.at("solver").get<std::string>().c_str(), "position-based");
        assert_int_equal(run.at("frames").get<int>(), 3);
        assert_int_equal(run.at("nodes").get<int>(), 453);
        assert_int_equal(run.at("faces").get<int>(), 902);
        assert_true(run.at("finite").get<bool>());
        assert_true(run.at("ms_per_step").get<double>() > 0.0);
        assert_true(run.at("kinetic_energy").get<double>() > 0.0);
        const std::string hash = run.at("state_hash");
        assert_int_equal(hash.size(), 16);
        assert_true(hash.find_first_not_of("0123456789abcdef") == std::string::npos);
        const json again = cli::run_json("run Bunny --frames 3 --json --threads 3 --engine " + std::string(engine));
        assert_string_equal(again.at("state_hash").get<std::string>().c_str(), hash.c_str());
    }
}

static void test_cli_run_tells_the_solver(void**) {
    const struct {
        const char *arguments, *solver;
        int substeps, iterations;
        double dt;
    } cases[] = {
        {"", "position-based", 1, 2, 1.0 / 60.0},
        {"--engine bullet --iterations 3", "position-based", 1, 3, 1.0 / 60.0},
        {"--solver implicit", "implicit", 1, 5, 1.0 / 60.0},
        {"--solver implicit --iterations 4 --dt 0.02", "implicit", 1, 4, 0.02},
        {"--solver xpbd", "xpbd", 10, 1, 1.0 / 60.0},
        {"--solver xpbd --substeps 7 --iterations 2 --dt 0.01", "xpbd", 7, 2, 0.01},
    };
    std::set<std::string> hashes;
    for (const auto& each : cases) {
        const json run = cli::run_json("run bunny --frames 3 --json " + std::string(each.arguments));
        assert_string_equal(run.at("solver").get<std::string>().c_str(), each.solver);
        assert_int_equal(run.at("substeps").get<int>(), each.substeps);
        assert_int_equal(run.at("iterations").get<int>(), each.iterations);
        assert_true(run.at("dt").get<double>() == each.dt);
        assert_true(run.at("finite").get<bool>());
        hashes.insert(run.at("state_hash").get<std::string>());
    }
    assert_true(hashes.size() >= 4); // in the air some are alike
}

static void test_cli_run_changes_the_scene(void**) {
    const json faces = cli::run_json("run TwistedCloth --resolution 12x8 --frames 5 --json");
    assert_int_equal(faces.at("nodes").get<int>(), 96);
    assert_string_equal(faces.at("self_collision").get<std::string>().c_str(), "faces");
    assert_string_equal(faces.at("solver").get<std::string>().c_str(), "xpbd");
    assert_int_equal(faces.at("crossings").get<int>(), 0);
    assert_true(faces.at("rms_speed").get<double>() > 0.0);
    const json without = cli::run_json("run TwistedCloth --resolution 12x8 --frames 5 --json --self-collision off");
    assert_string_equal(without.at("self_collision").get<std::string>().c_str(), "off");
    const json bullet = cli::run_json("run TwistedCloth --resolution 12 --frames 5 --json --engine bullet");
    assert_true(bullet.at("crossings").is_null());
    assert_string_equal(bullet.at("solver").get<std::string>().c_str(), "position-based");
}

static void test_cli_run_without_frames_goes_to_the_picture(void**) {
    const json list = cli::run_json("list --json");
    for (const json& each : list.at("scenes")) {
        if (each.at("name") != "Bending") { continue; }
        const int frames = each.at("picture_frame");
        assert_int_equal(cli::run_json("run Bending --json").at("frames").get<int>(), frames);
        assert_int_equal(cli::run_json("run Bending --json --dt 0.008333333").at("frames").get<int>(), 2 * frames);
    }
}

static void test_cli_run_takes_a_mesh(void**) {
    const std::string file = scratch("tetrahedron.obj");
    cli::write_file(file, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    const json run = cli::run_json("run TorusMatch --frames 2 --json --mesh " + file);
    assert_int_equal(run.at("nodes").get<int>(), 4);
    assert_int_equal(run.at("faces").get<int>(), 4);
    assert_int_equal(run.at("links").get<int>(), 6);
}

static void test_cli_run_writes_csv(void**) {
    const std::string file = scratch("run.csv");
    cli::write_file(file, "replaced");
    assert_int_equal(cli::run("run Bending --engine bullet --frames 5 --csv " + file).status, 0);
    const std::vector<std::string> lines = lines_of(cli::read_file(file));
    assert_int_equal(lines.size(), 6);
    assert_string_equal(lines[0].c_str(), "frame,time_s,ms,kinetic_energy_J,max_stretch,center_x,center_y,center_z");
    for (size_t i = 1; i < lines.size(); ++i) {
        assert_int_equal(std::count(lines[i].begin(), lines[i].end(), ','), 7);
        assert_true(lines[i].rfind(std::to_string(i) + ",", 0) == 0);
    }
}

static void test_cli_compare_prints_measures(void**) {
    const std::string file = scratch("compare.csv");
    const json document = cli::run_json("compare Bending aero2 Bending --frames 30 --json --csv " + file);
    const json& scenes = document.at("scenes");
    assert_int_equal(scenes.size(), 2);
    for (const json& row : scenes) {
        expect_keys(row,
                    {"scene", "solver", "substeps", "iterations", "dt", "nodes", "one_step", "free_run", "time_ratio"});
        expect_keys(row.at("one_step"), {"frames", "median", "p99", "maximum", "bit_equal_share",
                                         "frames_with_lone_contacts", "frames_above_limit", "unexplained_frames"});
        expect_keys(row.at("free_run"), {"error_30", "error_60", "error_300"});
        assert_int_equal(row.at("one_step").at("frames").get<int>(), 30);
        assert_true(row.at("free_run").at("error_30").is_number());
        assert_true(row.at("free_run").at("error_300").is_null());
    }
    assert_string_equal(scenes[1].at("scene").get<std::string>().c_str(), "Aero2");
    const std::vector<std::string> lines = lines_of(cli::read_file(file));
    assert_int_equal(lines.size(), 3);
    const auto commas = std::count(lines[0].begin(), lines[0].end(), ',');
    for (const std::string& line : lines) {
        assert_int_equal(std::count(line.begin(), line.end(), ','), commas);
    }

    const json other = cli::run_json("compare Bending --frames 30 --solver xpbd --json").at("scenes").at(0);
    assert_string_equal(other.at("solver").get<std::string>().c_str(), "xpbd");
    assert_true(other.at("one_step").is_null());
    assert_true(other.at("free_run").at("error_30").get<double>() > 0.0);

    const cli::Result text = cli::run("compare Bending --frames 2");
    assert_int_equal(text.status, 0);
    assert_true(text.output.find("Bending") != std::string::npos && text.output.find("bit-equal") != std::string::npos);
}

static void test_costs_tell_what_is_on(void**) {
    const json plain = cli::run_json("run Torus --frames 20 --json");
    assert_false(plain.contains("costs"));
    const json document = cli::run_json("run Torus --frames 20 --costs --json");
    assert_true(document.at("state_hash") == plain.at("state_hash"));
    const json& costs = document.at("costs");
    assert_int_equal(costs.at("features").size(), 5);
    size_t bytes = 0;
    double microseconds = 0.0, of_passes = 0.0;
    for (const json& feature : costs.at("features")) {
        bytes += feature.at("bytes").get<size_t>();
        microseconds += feature.at("microseconds").get<double>();
        assert_true(feature.at("is_needed") ==
                    (feature.at("feature") == "link colors" || feature.at("feature") == "iterated sweeps"));
    }
    for (const json& pass : costs.at("passes")) {
        of_passes += pass.at("microseconds").get<double>();
    }
    // 300 nodes, 2700 links of two materials, 600 faces; and what a body takes whatever its size
    const size_t base = 48 * 300 + 14 * 2700 + 12 * 600;
    assert_in_range(costs.at("bytes").get<size_t>(), base + bytes, base + bytes + 2000);
    assert_true(microseconds > 0.0 && microseconds < of_passes);
    check_near(of_passes, costs.at("microseconds").get<double>(), 1e-6 * of_passes);
    assert_int_equal(costs.at("features").size() + costs.at("left_out").size(), 44);
    const auto linked = costs.at("linked_bytes").get<size_t>();
    assert_in_range(linked, 50000, costs.at("core_bytes").get<size_t>() / 2);
    const std::vector<std::string> modules = costs.at("linked_modules");
    assert_int_equal(std::count(modules.begin(), modules.end(), "pbd_links_colored"), 1);
    assert_int_equal(std::count(modules.begin(), modules.end(), "cluster"), 0);
    const cli::Result bullet = cli::run("run Torus --engine bullet --costs");
    assert_int_equal(bullet.status, 1);
    const cli::Result text = cli::run("run Torus --frames 5 --costs");
    const size_t left_out = text.output.find("left out: ");
    assert_true(left_out != std::string::npos);
    assert_true(text.output.find("velocity links", left_out) != std::string::npos);
    assert_true(text.output.find("linked: " + std::to_string(linked) + " of the core's ") != std::string::npos);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_costs_tell_what_is_on),
        cmocka_unit_test(test_cli_help_of_everything),
        cmocka_unit_test(test_cli_list_names_every_scene),
        cmocka_unit_test(test_cli_run_prints_measures),
        cmocka_unit_test(test_cli_run_tells_the_solver),
        cmocka_unit_test(test_cli_run_changes_the_scene),
        cmocka_unit_test(test_cli_run_without_frames_goes_to_the_picture),
        cmocka_unit_test(test_cli_run_takes_a_mesh),
        cmocka_unit_test(test_cli_run_writes_csv),
        cmocka_unit_test(test_cli_compare_prints_measures),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
