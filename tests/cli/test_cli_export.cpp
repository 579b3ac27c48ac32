// Files of `pliant run --export`, read by code that knows the formats and not the writers, beside a run of the same
// scene in this process.

#include "program_run.h"

#include "check.h"
#include "engines/engine.h"
#include "scenes/scene_choice.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

using cli::scratch;

static constexpr int frame_count = 6;

// States of soft bodies after 0 .. `frames` steps.
static std::vector<std::vector<demos::SoftState>> run_scene(const char* name, int frames) {
    const auto description = demos::Description::build(demos::choose_scene(name), demos::SceneOptions());
    const auto engine = demos::make_engine(demos::EngineKind::pliant, *description, demos::EngineOptions());
    std::vector<std::vector<demos::SoftState>> states;
    for (int frame = 0; frame <= frames; ++frame) {
        if (frame > 0) { engine->step(); }
        states.emplace_back();
        for (int i = 0; i < engine->soft_count(); ++i) {
            states.back().push_back(engine->soft(i));
        }
    }
    return states;
}

static std::string export_scene(const char* name, const char* format, int frames, const std::string& more = "") {
    const std::string folder = scratch(std::string(name) + "-" + format);
    const cli::Result result = cli::run("run " + std::string(name) + " --frames " + std::to_string(frames) +
                                        " --export " + folder + " --format " + format + " " + more);
    if (result.status != 0) { fail_msg("export of %s as %s: %s", name, format, result.errors.c_str()); }
    return folder + "/";
}

static size_t file_count(const std::string& folder, const std::string& beginning, const std::string& ending) {
    size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if (name.rfind(beginning, 0) == 0 && entry.path().extension() == ending) { ++count; }
    }
    return count;
}

static void expect_same(const std::vector<float>& read, const std::vector<pli_vec3>& expected) {
    assert_int_equal(read.size(), 3 * expected.size());
    for (size_t i = 0; i < expected.size(); ++i) {
        const float values[3] = {expected[i].x, expected[i].y, expected[i].z};
        for (size_t k = 0; k < 3; ++k) {
            if (read[3 * i + k] != values[k]) {
                fail_msg("node %d, coordinate %d: %.9g, not %.9g", static_cast<int>(i), static_cast<int>(k),
                         static_cast<double>(read[3 * i + k]), static_cast<double>(values[k]));
            }
        }
    }
}

// ------------------------------------------------------------------------------------------------------------- OBJ

struct Obj {
    std::vector<float> points, normals;
    std::vector<int> triangles, lines; // from 0
};

static Obj read_obj(const std::string& path) {
    if (!cli::exists(path)) { fail_msg("no file %s", path.c_str()); }
    Obj obj;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string kind, word;
        words >> kind;
        while (words >> word) {
            if (kind == "v") { obj.points.push_back(std::strtof(word.c_str(), nullptr)); }
            if (kind == "vn") { obj.normals.push_back(std::strtof(word.c_str(), nullptr)); }
            if (kind == "f") {
                const std::string index = word.substr(0, word.find('/'));
                assert_string_equal(word.c_str(), (index + "//" + index).c_str());
                obj.triangles.push_back(std::stoi(index) - 1);
            }
            if (kind == "l") { obj.lines.push_back(std::stoi(word) - 1); }
        }
    }
    return obj;
}

static void test_cli_export_obj_of_cloth(void**) {
    const std::string folder = export_scene("Cloth", "obj", frame_count);
    const auto states = run_scene("Cloth", frame_count);
    for (int frame = 0; frame <= frame_count; ++frame) {
        const Obj obj = read_obj(folder + "soft0_cloth_00000" + std::to_string(frame) + ".obj");
        const demos::SoftState& soft = states[static_cast<size_t>(frame)][0];
        expect_same(obj.points, soft.positions);
        assert_true(obj.triangles == soft.face_nodes);
        assert_int_equal(obj.lines.size(), 0);
        assert_int_equal(obj.normals.size(), obj.points.size());
        for (size_t i = 0; i < obj.normals.size(); i += 3) {
            const float* n = &obj.normals[i];
            check_near(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1, 1e-5);
        }
    }
    assert_int_equal(file_count(folder, "soft0_", ".obj"), frame_count + 1);
    assert_int_equal(file_count(folder, "rigid", ".obj"), 11 * (frame_count + 1));
}

// A box of 24 corners, since each of its sides has normals of its own, falls freely.
static void test_cli_export_rigid_bodies(void**) {
    const std::string folder = export_scene("Cloth", "obj", 2, "--export-every 2");
    const Obj first = read_obj(folder + "rigid2_box_000000.obj"), last = read_obj(folder + "rigid2_box_000002.obj");
    assert_int_equal(first.points.size(), 3 * 24);
    assert_int_equal(first.triangles.size(), 3 * 12);
    assert_true(first.triangles == last.triangles);
    for (size_t i = 0; i < first.points.size(); i += 3) {
        // Bullet moves a body by v dt after v += g dt: 1 and 2 parts of g dt^2.
        check_near(last.points[i + 1] - first.points[i + 1], -3.0 * 10.0 / 3600.0, 1e-4);
    }
}

static void test_cli_export_ropes_as_lines(void**) {
    const std::string folder = export_scene("Ropes", "obj", 1);
    const auto states = run_scene("Ropes", 1);
    assert_int_equal(states[1].size(), 15);
    for (size_t i = 0; i < states[1].size(); ++i) {
        const demos::SoftState& soft = states[1][i];
        const Obj obj = read_obj(folder + "soft" + std::to_string(i) + "_rope_000001.obj");
        expect_same(obj.points, soft.positions);
        assert_true(obj.lines == soft.link_nodes);
        assert_int_equal(obj.triangles.size() + obj.normals.size(), 0);
    }
}

static void test_cli_export_follows_cuts(void**) {
    const int frames = 35;
    const std::string folder = export_scene("Cutting1", "obj", frames, "--export-from 29 --export-every 3");
    const auto states = run_scene("Cutting1", frames);
    assert_true(states[35][0].positions.size() > states[29][0].positions.size());
    for (const int frame : {29, 32, 35}) {
        const Obj obj = read_obj(folder + "soft0_cloth_0000" + std::to_string(frame) + ".obj");
        expect_same(obj.points, states[static_cast<size_t>(frame)][0].positions);
        assert_true(obj.triangles == states[static_cast<size_t>(frame)][0].face_nodes);
    }
    assert_int_equal(file_count(folder, "soft0_", ".obj"), 3);
}

// ------------------------------------------------------------------------------------------------------------- PC2

static uint32_t word_at(const std::string& bytes, size_t at) {
    uint32_t word = 0;
    for (size_t i = 0; i < 4; ++i) {
        word |= static_cast<uint32_t>(static_cast<unsigned char>(bytes.at(at + i))) << (8 * i);
    }
    return word;
}

static float float_at(const std::string& bytes, size_t at) {
    const uint32_t word = word_at(bytes, at);
    float value;
    std::memcpy(&value, &word, sizeof value);
    return value;
}

static void test_cli_export_pc2(void**) {
    const std::string folder = export_scene("Cloth", "pc2", frame_count, "--export-from 2 --export-every 2");
    const auto states = run_scene("Cloth", frame_count);
    const std::string bytes = cli::read_file(folder + "soft0_cloth.pc2");
    const size_t nodes = states[0][0].positions.size(), header = 32;
    assert_int_equal(bytes.size(), header + 3 * nodes * 12);
    assert_memory_equal(bytes.data(), "POINTCACHE2\0", 12);
    assert_int_equal(word_at(bytes, 12), 1);
    assert_int_equal(word_at(bytes, 16), nodes);
    check_near(float_at(bytes, 20), 2, 0);
    check_near(float_at(bytes, 24), 2, 0);
    assert_int_equal(word_at(bytes, 28), 3);
    for (size_t sample = 0; sample < 3; ++sample) {
        std::vector<float> read;
        for (size_t i = 0; i < 3 * nodes; ++i) {
            read.push_back(float_at(bytes, header + 4 * (sample * 3 * nodes + i)));
        }
        expect_same(read, states[2 + 2 * sample][0].positions);
    }
    const Obj mesh = read_obj(folder + "soft0_cloth.obj");
    expect_same(mesh.points, states[2][0].positions);
    assert_true(mesh.triangles == states[2][0].face_nodes);
    assert_int_equal(file_count(folder, "", ".pc2"), 12);
}

static void expect_failure(const std::string& arguments, int status, const std::string& message,
                           const std::string& environment = "") {
    const cli::Result result = cli::run(arguments, environment);
    if (result.status != status || result.errors.find(message) == std::string::npos || !result.output.empty()) {
        fail_msg("pliant %s: exit status %d, stderr '%s' (wanted '%s')", arguments.c_str(), result.status,
                 result.errors.c_str(), message.c_str());
    }
}

static void test_cli_export_pc2_refuses_cuts(void**) {
    const std::string folder = scratch("cut-pc2");
    expect_failure("run Cutting1 --frames 40 --format pc2 --export " + folder, 1,
                   "pc2 keeps the number of nodes, but soft0_cloth has ");
    assert_int_equal(file_count(folder, "", ".pc2") + file_count(folder, "", ".obj"), 0);
}

// ------------------------------------------------------------------------------------------------------------- VTK

// Numbers of the array of this name.
static std::vector<float> array_of(const std::string& text, const std::string& name) {
    const size_t array = text.find("Name=\"" + name + "\"");
    if (array == std::string::npos) { fail_msg("no array %s", name.c_str()); }
    const size_t begin = text.find('>', array) + 1;
    std::istringstream words(text.substr(begin, text.find("</DataArray>", begin) - begin));
    std::vector<float> values;
    for (std::string word; words >> word;) {
        values.push_back(std::strtof(word.c_str(), nullptr));
    }
    return values;
}

struct Cells {
    const std::vector<int>& nodes;
    size_t corners;
    int type; // VTK's number
};

static void expect_cells(const std::string& text, const std::vector<Cells>& kinds) {
    std::vector<int> nodes, ends, kinds_of_cells;
    for (const Cells& kind : kinds) {
        for (size_t i = 0; i < kind.nodes.size(); ++i) {
            nodes.push_back(kind.nodes[i]);
            if ((i + 1) % kind.corners != 0) { continue; }
            ends.push_back(static_cast<int>(nodes.size()));
            kinds_of_cells.push_back(kind.type);
        }
    }
    assert_true(!ends.empty());
    const auto is_read = [&](const char* name, const std::vector<int>& expected) {
        const std::vector<float> read = array_of(text, name);
        return std::vector<int>(read.begin(), read.end()) == expected;
    };
    assert_true(is_read("connectivity", nodes));
    assert_true(is_read("offsets", ends));
    assert_true(is_read("types", kinds_of_cells));
    assert_int_equal(array_of(text, "stretch").size(), ends.size());
    assert_true(text.find("NumberOfCells=\"" + std::to_string(ends.size()) + "\"") != std::string::npos);
}

static void test_cli_export_vtk(void**) {
    struct Case {
        const char *scene, *body;
    };
    for (const Case& the_case :
         {Case{"Cloth", "soft0_cloth"}, Case{"TetraCube", "soft0_cube"}, Case{"Ropes", "soft14_rope"}}) {
        const std::string folder = export_scene(the_case.scene, "vtk", frame_count, "--export-every 3");
        const auto states = run_scene(the_case.scene, frame_count);
        for (const size_t frame : {size_t(0), size_t(3), size_t(6)}) {
            const demos::SoftState& soft = states[frame][the_case.body[4] == '1' ? 14 : 0];
            const std::string text = cli::read_file(folder + the_case.body + "_00000" + std::to_string(frame) + ".vtu");
            expect_same(array_of(text, "position"), soft.positions);
            expect_same(array_of(text, "velocity"), soft.velocities);
            const bool is_rope = soft.face_nodes.empty();
            const std::vector<int> none;
            expect_cells(
                text, {{soft.tetra_nodes, 4, 10}, {soft.face_nodes, 3, 5}, {is_rope ? soft.link_nodes : none, 2, 3}});
            if (is_rope) {
                const std::vector<float> stretch = array_of(text, "stretch");
                for (size_t i = 0; i < stretch.size(); ++i) {
                    const pli_vec3 a = soft.positions[static_cast<size_t>(soft.link_nodes[2 * i])],
                                   b = soft.positions[static_cast<size_t>(soft.link_nodes[2 * i + 1])];
                    const double x = static_cast<double>(a.x) - static_cast<double>(b.x),
                                 y = static_cast<double>(a.y) - static_cast<double>(b.y),
                                 z = static_cast<double>(a.z) - static_cast<double>(b.z);
                    check_near(stretch[i], sqrt(x * x + y * y + z * z) / static_cast<double>(soft.rest_lengths[i]) - 1,
                               1e-5);
                }
            }
        }
        const std::string collection = cli::read_file(folder + the_case.body + ".pvd");
        const size_t file = collection.find("file=\"" + std::string(the_case.body) + "_000003.vtu\"");
        assert_true(file != std::string::npos);
        const std::string time = "timestep=\"";
        check_near(std::atof(collection.c_str() + collection.rfind(time, file) + time.size()), 3.0 / 60.0, 1e-7);
        assert_int_equal(file_count(folder, the_case.body, ".vtu"), 3);
    }
}

// ------------------------------------------------------------------------------------------------------- bad inputs

static void test_cli_export_errors(void**) {
    const std::string file = scratch("a-file");
    cli::write_file(file, "kept");
    expect_failure("run Cloth --frames 1000000 --export " + file, 1, "a-file");
    assert_string_equal(cli::read_file(file).c_str(), "kept");
    expect_failure("run Cloth --frames 1000000 --export /proc/pliant", 1, "cannot make the folder /proc/pliant: ");
    expect_failure("run Cloth --frames 1000000 --export /proc", 1, "cannot write /proc/");
    expect_failure("run Cloth --export x --format stl", 2, "--format: stl not in {obj,pc2,vtk}");
    expect_failure("run Cloth --format obj", 2, "--format requires --export");
    expect_failure("run Cloth --export x --export-every 0", 2, "--export-every: Value 0 not in range 1 to 1000000");
    expect_failure("run Cloth --frames 3 --export x --export-from 4", 1, "--export-from 4 is after the last frame, 3");
    for (const char* format : {"obj", "pc2", "vtk"}) { // no file may be longer than 2 kB: as a full disk
        const std::string folder = scratch(std::string("full-") + format);
        expect_failure("run Cloth --frames 2 --export " + folder + " --format " + format, 1, "File too large",
                       "trap '' XFSZ; ulimit -f 4;");
        assert_false(cli::exists(folder + "/soft0_cloth_000000.obj") || cli::exists(folder + "/soft0_cloth.pc2") ||
                     cli::exists(folder + "/soft0_cloth_000000.vtu"));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cli_export_obj_of_cloth),
        cmocka_unit_test(test_cli_export_rigid_bodies),
        cmocka_unit_test(test_cli_export_ropes_as_lines),
        cmocka_unit_test(test_cli_export_follows_cuts),
        cmocka_unit_test(test_cli_export_pc2),
        cmocka_unit_test(test_cli_export_pc2_refuses_cuts),
        cmocka_unit_test(test_cli_export_vtk),
        cmocka_unit_test(test_cli_export_errors),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
