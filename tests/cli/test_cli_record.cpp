// pliant run --record, pliant replay and pliant diverge.

#include "program_run.h"

#include "measure/recording.h"
#include "scene_records.h"

#include "check.h"

#include <cstring>

using cli::scratch;

static std::string record(const std::string& name, const std::string& arguments) {
    const std::string path = scratch(name);
    const cli::Result result = cli::run("run " + arguments + " --record " + path);
    if (result.status != 0) { fail_msg("%s: %s", arguments.c_str(), result.errors.c_str()); }
    return path;
}

static void a_recording_is_played_again(void** unused) {
    (void)unused;
    const std::string path = record("cloth", "Cloth --frames 100 --keyframes 40");
    for (const int from : {0, 39, 40, 95}) {
        const nlohmann::json told = cli::run_json("replay " + path + " --verify --json --from " + std::to_string(from));
        assert_true(told.at("equal").get<bool>());
        assert_int_equal(told.at("frames").get<int>(), 100);
        assert_int_equal(told.at("keyframe").get<int>(), from / 40 * 40);
    }
    const nlohmann::json with_this_build = cli::run_json("diverge " + path + " --json");
    assert_true(with_this_build.at("equal").get<bool>());
}

// Position of a node: 12 bytes.
static void it_is_small(void** unused) {
    (void)unused;
    const size_t size = cli::read_file(record("small", "Cloth --frames 300")).size();
    const nlohmann::json run = cli::run_json("run Cloth --frames 1 --json");
    const size_t raw = 300 * 12 * run.at("nodes").get<size_t>();
    if (size > raw / 20) { fail_msg("%zu bytes for %zu of positions", size, raw); }
}

static void what_parts_is_found(void** unused) {
    (void)unused;
    const std::string a = record("a", "Cloth --frames 30 --keyframes 10");
    const std::string b = record("b", "Cloth --frames 30 --keyframes 10 --iterations 2");
    const cli::Result result = cli::run("diverge " + a + " " + b + " --json");
    assert_int_equal(result.status, 1);
    const nlohmann::json told = nlohmann::json::parse(result.output);
    assert_false(told.at("equal").get<bool>());
    assert_int_equal(told.at("first_unequal_frame").get<int>(), 1);
    assert_int_equal(told.at("body").get<int>(), 0);
    assert_true(told.at("node").get<int>() >= 0);
    assert_int_equal(cli::run("diverge " + a + " " + a).status, 0);

    std::string bytes = cli::read_file(a);
    const size_t hashes = bytes.find("hashes") + 6 + 2; // key, then CBOR's head of 240 bytes
    bytes[hashes + 8 * 24] ^= 1;
    cli::write_file(scratch("changed"), bytes);
    for (const char* from : {"", " --from 28"}) { // also between the keyframe and the frame
        const cli::Result replay = cli::run("replay " + scratch("changed") + " --verify --json" + from);
        assert_int_equal(replay.status, 1);
        assert_int_equal(nlohmann::json::parse(replay.output).at("first_unequal_frame").get<int>(), 25);
    }
}

// Of 20 frames, with a keyframe after ten, before which something is planted.
static std::string record_with(const std::string& name, const char* which, void (*plant)(demos::PliantEngine&)) {
    const std::unique_ptr<demos::Description> description = describe(which);
    demos::EngineOptions options;
    options.ordered_pairs = true;
    options.solver.kind = demos::SolverKind::position_based;
    demos::PliantEngine engine(*description, options);
    demos::RecordedSettings settings;
    settings.scene = which;
    settings.solver = "position-based";
    demos::Recorder recorder(settings, 0);
    for (int i = 1; i <= 20; ++i) {
        engine.step();
        recorder.add_frame(engine);
        if (i != 10) { continue; }
        plant(engine);
        recorder.add_keyframe(engine);
    }
    cli::write_file(scratch(name), recorder.recording().to_bytes());
    return scratch(name);
}

static void expect_feature(const char* which, const char* feature, void (*plant)(demos::PliantEngine&)) {
    const std::string a = record_with("plain", which, [](demos::PliantEngine&) {});
    const std::string b = record_with("planted", which, plant);
    assert_int_equal(cli::run("diverge " + a + " " + a).status, 0);
    const cli::Result result = cli::run("diverge " + a + " " + b + " --json");
    assert_int_equal(result.status, 1);
    const nlohmann::json told = nlohmann::json::parse(result.output);
    assert_int_equal(told.at("first_unequal_frame").get<int>(), 11);
    assert_int_equal(told.at("body").get<int>(), 0);
    assert_false(told.at("is_rigid").get<bool>());
    assert_true(told.at("node").get<int>() >= 0);
    assert_true(told.at("is_played").get<bool>());
    assert_string_equal(told.at("feature").get<std::string>().c_str(), feature);
}

static void the_feature_that_differs_is_named(void** unused) {
    (void)unused;
    expect_feature("Aero", "vertex aerodynamics",
                   [](demos::PliantEngine& engine) { engine.set_wind(0, pli_vec3_make(3, 0, 5)); });
    expect_feature("Pressure", "pressure", [](demos::PliantEngine& engine) {
        assert_int_equal(pli_body_enable_pressure(engine.body(0), 500), PLI_OK);
    });
}

static void expect_error(const std::string& arguments, const char* message) {
    const cli::Result result = cli::run(arguments);
    assert_int_not_equal(result.status, 0);
    if (result.errors.find(message) == std::string::npos) { fail_msg("%s", result.errors.c_str()); }
}

static void what_is_wrong_is_told(void** unused) {
    (void)unused;
    const std::string path = record("short", "Cloth --frames 5 --keyframes 5");
    const std::string bytes = cli::read_file(path);
    cli::write_file(scratch("cut"), bytes.substr(0, bytes.size() / 2));
    expect_error("replay " + scratch("cut"), "is no recording, or it is damaged");
    expect_error("replay " + scratch("none"), "cannot read");
    expect_error("diverge " + scratch("") + " " + path, ": it is a folder");
    expect_error("replay " + path + " --from 6", "--from 6 is after the last frame, 5");
    expect_error("run Cloth --frames 1 --engine bullet --record " + scratch("x"), "--record is of scenes on Pliant");
    std::string damaged = bytes;
    damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 1); // in the keyframe
    cli::write_file(scratch("damaged"), damaged);
    expect_error("replay " + scratch("damaged") + " --from 5", "the keyframe does not fit");
}

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_recording_is_played_again), cmocka_unit_test(it_is_small),
        cmocka_unit_test(what_parts_is_found),         cmocka_unit_test(the_feature_that_differs_is_named),
        cmocka_unit_test(what_is_wrong_is_told),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
