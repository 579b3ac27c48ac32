// The window: what mouse and keys do in it, by scripts, and what it looks like. Needs Xvfb and a program that was built
// with windows; where one of them is missing, the tests are skipped and say so.

#include "decoded.h"
#include "program_run.h"
#include "virtual_screen.h"

#include "check.h"

#include <cmath>
#include <cstdio>

using cli::scratch;
using nlohmann::json;

static const cli::VirtualScreen* screen;

// Why there is nothing to run a test with; empty when there is.
static std::string missing;

static void find_window() {
    if (!screen->is_there()) {
        missing = "there is no Xvfb (Debian package xvfb)\n";
        return;
    }
    const cli::Result result = cli::run("view --frames 1 --width 320 --height 240", screen->environment());
    if (result.errors.find("built without windows") != std::string::npos) { missing = result.errors; }
}

static void need_window() {
    if (missing.empty()) { return; }
    std::printf("skipped: %s", missing.c_str());
    skip();
}

// The reports of a run with a small window.
static json view(const std::string& arguments, const std::string& script) {
    const std::string file = scratch("script.txt");
    cli::write_file(file, script);
    const cli::Result result =
        cli::run("view --json --width 640 --height 480 --script " + file + " " + arguments, screen->environment());
    if (result.status != 0 || !result.errors.empty()) {
        fail_msg("pliant view %s: exit status %d, stderr: %s", arguments.c_str(), result.status, result.errors.c_str());
    }
    const json document = json::parse(result.output, nullptr, false);
    if (document.is_discarded()) { fail_msg("pliant view %s: not one JSON document", arguments.c_str()); }
    return document.at("reports");
}

static const json& engine(const json& report, size_t index = 0) {
    return report.at("engines").at(index);
}

static const json& soft(const json& report, size_t index = 0) {
    return engine(report, index).at("softs").at(0);
}

// At rest above the ground, 3 frames from the start: no cut of the scene's own script yet.
static void test_cli_view_click_cuts_a_disc(void**) {
    need_window();
    for (const char* name : {"pliant", "bullet"}) {
        const json reports =
            view(std::string("Cutting1 --frames 4 --engine ") + name, "3 report\n"
                                                                      "3 press control left node 0 136\n"
                                                                      "3 release left\n"
                                                                      "3 report\n");
        assert_int_equal(reports.size(), 3);
        assert_int_equal(soft(reports[0]).at("nodes").get<int>(), 256);
        assert_int_equal(soft(reports[0]).at("links").get<int>(), 705);
        assert_int_equal(soft(reports[0]).at("parts").get<int>(), 1);
        // A circle of radius 1 crosses about twenty edges of a mesh of 0.8 m; both sides get a node for each.
        const int nodes = soft(reports[1]).at("nodes").get<int>(), links = soft(reports[1]).at("links").get<int>();
        assert_true(nodes >= 256 + 24 && nodes <= 256 + 60);
        assert_true(links >= 705 + 50 && links <= 705 + 120);
        assert_int_equal(soft(reports[1]).at("parts").get<int>(), 2);
        assert_string_equal(reports[1].at("message").get<std::string>().c_str(), "");
    }
}

// From edge to edge of the sheet, in four movements of the mouse.
static void test_cli_view_drag_with_shift_cuts(void**) {
    need_window();
    const char* script = "2 press shift left node 0 112\n"
                         "2 move by -60 -30\n"
                         "2 release left\n"
                         "2 report\n"
                         "2 move node 0 112\n"
                         "2 move by -9 -4\n"
                         "2 press shift left by 0 0\n"
                         "2 move node 0 116\n"
                         "2 move node 0 120\n"
                         "2 move node 0 124\n"
                         "2 move node 0 127\n"
                         "2 move by 9 4\n"
                         "2 release left\n";
    const json reports = view("Cutting1 --frames 3", script);
    assert_int_equal(soft(reports[0]).at("parts").get<int>(), 1);
    assert_int_equal(soft(reports[1]).at("parts").get<int>(), 2);
    assert_true(soft(reports[1]).at("links").get<int>() > 705);
    const json refused = view("Cutting1 --frames 3 --engine bullet", script);
    assert_string_equal(refused[1].at("message").get<std::string>().c_str(),
                        "btSoftBody cannot be cut along a swept ray");
    assert_int_equal(soft(refused[1]).at("nodes").get<int>(), 256);
}

static void test_cli_view_mouse_pulls_a_node(void**) {
    need_window();
    const json reports = view("Cutting1 --frames 22 --engine both", "1 report node 0 136\n"
                                                                    "1 press left node 0 136\n"
                                                                    "2 move by 0 -40\n"
                                                                    "3 move by 0 -40\n"
                                                                    "20 report node 0 136\n"
                                                                    "20 release left\n"
                                                                    "20 steps 8\n"
                                                                    "20 report node 0 136\n");
    for (size_t i = 0; i < 2; ++i) {
        const auto height = [&](size_t report) { return engine(reports[report], i).at("node").at(1).get<double>(); };
        assert_true(height(1) > height(0) + 1.0);
        assert_true(height(2) < height(1) - 0.3);
    }
}

static void test_cli_view_mouse_turns_the_camera(void**) {
    need_window();
    const std::string before = scratch("before.png"), after = scratch("after.png");
    view("Bunny --frames 2 --png " + before, "");
    const json reports = view("Bunny --frames 2 --png " + after, "1 press left 600 40\n"
                                                                 "1 move by -120 0\n"
                                                                 "1 release left\n"
                                                                 "1 wheel 3 600 40\n");
    assert_int_equal(reports[0].at("frame").get<int>(), 2);
    assert_true(cli::read_file(before) != cli::read_file(after));
    const Decoded near(after), far(before);
    assert_true(near.warm_share(330, 640) > 1.3 * far.warm_share(330, 640)); // three steps nearer: 1.37 times as large
}

static void test_cli_view_arrow_keys_drive_the_car(void**) {
    need_window();
    const auto run = [](const std::string& keys) {
        return view("ClusterCar --frames 1", keys + "0 steps 240\n0 report\n")[0];
    };
    const auto place = [](const json& report, size_t axis) { return soft(report).at("middle").at(axis).get<double>(); };
    const json forward = run("0 key up down\n"), back = run("0 key down down\n");
    check_near(forward.at("controls").at("drive (rad/s)").get<double>(), 3, 1e-6);
    assert_true(place(forward, 0) < place(back, 0) - 15.0); // it looks along -x
    const json left = run("0 key up down\n0 key left down\n"), right = run("0 key up down\n0 key right down\n");
    assert_true(place(left, 2) > place(right, 2) + 1.0);
    // Let go of, the wheels turn freely again.
    const json free =
        view("ClusterCar --frames 1", "0 key up down\n0 steps 60\n0 key up up\n0 steps 60\n0 report\n")[0];
    check_near(free.at("controls").at("drive (rad/s)").get<double>(), 0, 0);
}

static void test_cli_view_slider_turns_the_wind(void**) {
    need_window();
    const json reports = view("Aero2 --frames 1", "0 steps 60\n0 report\n0 set 0 180\n0 steps 120\n0 report\n");
    assert_true(soft(reports[0]).at("middle").at(2).get<double>() < -1.0);
    assert_true(soft(reports[1]).at("middle").at(2).get<double>() > 1.0);
    check_near(reports[1].at("controls").at("wind direction (degrees)").get<double>(), 180, 0);
}

static void test_cli_view_keys(void**) {
    need_window();
    const json reports = view("Bending --frames 12", "2 key space\n"
                                                     "4 key .\n"
                                                     "6 report\n" // 2 steps, then 1
                                                     "6 key r\n"
                                                     "6 report\n"
                                                     "6 key space\n"
                                                     "7 key n\n"
                                                     "7 report\n"
                                                     "8 key p\n"
                                                     "8 key p\n"
                                                     "9 key b\n"
                                                     "9 report\n"
                                                     "10 scene Bunny\n"
                                                     "10 key f\n10 key w\n10 key c\n10 key h\n");
    const json list = cli::run_json("list --json").at("scenes");
    size_t bending = 0;
    while (list[bending].at("name") != "Bending") {
        ++bending;
    }
    assert_int_equal(reports[0].at("frame").get<int>(), 3);
    assert_int_equal(reports[1].at("frame").get<int>(), 0);
    assert_true(reports[2].at("scene") == list[bending + 1].at("name"));
    assert_true(reports[3].at("scene") == list[bending - 1].at("name"));
    assert_string_equal(reports[4].at("scene").get<std::string>().c_str(), "Bunny");
    assert_int_equal(reports[4].at("frame").get<int>(), 2);
}

// Back by keys and along the bar, on from there as it was; a ball in the past ends the frames that came after.
static void test_cli_view_timeline(void**) {
    need_window();
    const json reports = view("Cutting1 --frames 3", "1 steps 99\n"
                                                     "1 report\n" // frame 100
                                                     "1 key ,\n"
                                                     "1 report\n" // 99
                                                     "1 key pageup\n"
                                                     "1 report\n" // 39
                                                     "1 go 20\n"
                                                     "1 report\n" // 20
                                                     "1 steps 79\n"
                                                     "1 report\n" // 99 again
                                                     "1 key end\n"
                                                     "1 report\n" // 100 again
                                                     "1 key home\n"
                                                     "1 key pagedown\n"
                                                     "1 move node 0 136\n"
                                                     "1 key b\n"
                                                     "1 report\n" // 60, with a ball
                                                     "1 key ,\n"
                                                     "1 report\n" // 59, without
                                                     "2 key .\n"
                                                     "2 key t\n");
    const int frames[] = {100, 99, 39, 20, 99, 100, 60, 59, 60};
    const int last[] = {100, 100, 100, 100, 100, 100, 60, 60, 60};
    const size_t rigids[] = {1, 1, 1, 1, 1, 1, 2, 1, 2};
    assert_int_equal(reports.size(), 9);
    for (size_t i = 0; i < 9; ++i) {
        assert_int_equal(reports[i].at("frame").get<int>(), frames[i]);
        assert_int_equal(reports[i].at("last_frame").get<int>(), last[i]);
        assert_int_equal(engine(reports[i]).at("rigids").size(), rigids[i]);
        assert_string_equal(reports[i].at("message").get<std::string>().c_str(), "");
    }
    const auto place = [&](size_t i) { return soft(reports[i]).at("middle"); };
    assert_true(place(0) == place(5) && place(1) == place(4));
    assert_true(place(0) != place(1) && place(2) != place(3));
    const json beside = view("Cutting1 --frames 3 --engine both", "1 key ,\n1 report\n"); // btSoftBody goes on
    assert_int_equal(beside[0].at("frame").get<int>(), 1);
}

static void test_cli_view_shoots_balls(void**) {
    need_window();
    const json reports = view("Cutting1 --frames 2 --engine both", "1 move node 0 136\n"
                                                                   "1 report\n"
                                                                   "1 key b\n"
                                                                   "1 steps 50\n"
                                                                   "1 report\n");
    for (size_t i = 0; i < 2; ++i) {
        assert_int_equal(engine(reports[0], i).at("rigids").size(), 1);
        assert_int_equal(engine(reports[1], i).at("rigids").size(), 2);
        const json ball = engine(reports[1], i).at("rigids").at(1);
        assert_true(std::hypot(ball.at(0).get<double>(), ball.at(2).get<double>()) < 12.0); // it is near the sheet
    }
}

static void test_cli_view_picture_has_panel_and_scene(void**) {
    need_window();
    const std::string file = scratch("view.png");
    const cli::Result result = cli::run("view Bunny --engine both --frames 3 --png " + file, screen->environment());
    assert_int_equal(result.status, 0);
    assert_string_equal(result.output.c_str(), "");
    const Decoded picture(file);
    assert_int_equal(picture.width, 1280);
    assert_int_equal(picture.height, 720);
    assert_true(picture.color_count() > 1000);
    assert_true(picture.warm_share(0, 320) < 0.001);
    assert_true(picture.warm_share(330, 804) > 0.01);  // Pliant
    assert_true(picture.warm_share(804, 1280) > 0.01); // Bullet
    int dark = 0, light = 0;                           // plate and letters of the panel
    for (int y = 0; y < 720; ++y) {
        for (int x = 0; x < 320; ++x) {
            const int green = picture.at(x, y)[1];
            dark += green < 60 ? 1 : 0;
            light += green > 200 ? 1 : 0;
        }
    }
    assert_true(dark > 150000);
    assert_true(light > 1500);
}

static void expect_failure(const std::string& arguments, int status, const std::string& message,
                           const std::string& environment) {
    const cli::Result result = cli::run("view " + arguments, environment);
    if (result.status != status || result.errors.find(message) == std::string::npos ||
        result.errors.find('\n') != result.errors.size() - 1) {
        fail_msg("pliant view %s: exit status %d (wanted %d), stderr '%s' (wanted '%s')", arguments.c_str(),
                 result.status, status, result.errors.c_str(), message.c_str());
    }
}

static void test_cli_view_failures(void**) {
    need_window();
    expect_failure("Bunny --frames 1", 1, "a window needs a display", "env -u DISPLAY -u WAYLAND_DISPLAY");
    expect_failure("Bunny --png x.png", 1, "--png and --json need --frames", screen->environment());
    expect_failure("Bunnny", 1, "did you mean Bunny?", screen->environment());
    expect_failure("Cloth --mesh " PLIANT_DATA_DIR "/bunny.obj", 1, "scene Cloth has no triangle mesh",
                   screen->environment());
    expect_failure("Bunny --resolution 20", 2, "--resolution", screen->environment());
    expect_failure("--engine physx", 2, "physx not in {pliant,bullet,both}", screen->environment());
    expect_failure("--width 5", 2, "--width", screen->environment());
    const std::string file = scratch("script.txt");
    const std::pair<const char*, const char*> wrong[] = {
        {"1 fly", ":1: nothing is called fly"},
        {"# comment\n\n3 key q", ":3: there is no key q"},
        {"1 press middel 3 4", ":1: there is no button middel"},
        {"1 press left 3", ":1: y is missing"},
        {"1 press left x 3", ":1: x is no number: x"},
        {"-1 report", ":1: the frame is no whole number"},
        {"1 key n extra", ":1: there is more than expected: extra"},
        {"2 report\n1 report", ":2: frames must not go back"},
        {"# comment\n0 set 0 1", "script.txt:2: the scene has no control 0"},
        {"0 press left node 0 100000", "script.txt:1: there is no node 100000"},
        {"0 report\n2 press left node 7 0", "script.txt:2: the scene has no soft body 7"},
        {"0 scene Bunnny", "script.txt:1: there is no scene named Bunnny; did you mean Bunny?"},
    };
    for (const auto& [script, message] : wrong) {
        cli::write_file(file, script);
        expect_failure("Bunny --frames 3 --script " + file, 1, message, screen->environment());
    }
    expect_failure("Bunny --frames 3 --script " + scratch("missing.txt"), 1, "missing.txt: No such file",
                   screen->environment());
}

int main(void) {
    const cli::VirtualScreen started;
    screen = &started;
    find_window();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cli_view_click_cuts_a_disc),
        cmocka_unit_test(test_cli_view_drag_with_shift_cuts),
        cmocka_unit_test(test_cli_view_mouse_pulls_a_node),
        cmocka_unit_test(test_cli_view_mouse_turns_the_camera),
        cmocka_unit_test(test_cli_view_arrow_keys_drive_the_car),
        cmocka_unit_test(test_cli_view_slider_turns_the_wind),
        cmocka_unit_test(test_cli_view_keys),
        cmocka_unit_test(test_cli_view_timeline),
        cmocka_unit_test(test_cli_view_shoots_balls),
        cmocka_unit_test(test_cli_view_picture_has_panel_and_scene),
        cmocka_unit_test(test_cli_view_failures),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
