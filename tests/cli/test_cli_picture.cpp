// Pictures: of the right size, and with something to see in them.

#include "decoded.h"
#include "program_run.h"

#include "check.h"

#include <array>

using cli::scratch;

static void expect_scene(const Decoded& picture) {
    assert_true(picture.color_count() > 1000);
    const std::array<int, 3> sky = picture.at(picture.width - 2, 1),
                             ground = picture.at(picture.width / 2, picture.height - 2);
    assert_true(sky[2] > 180 && sky[2] >= sky[0]); // light, blueish
    assert_true(ground[0] > 60 && ground[0] < 235);
}

static void test_cli_run_writes_a_picture(void**) {
    const std::string file = scratch("bunny.png");
    for (const char* frames : {"1", "80"}) { // in the air, and on the ground
        const cli::Result result =
            cli::run("run BunnyMatch --engine bullet --frames " + std::string(frames) + " --png " + file);
        assert_int_equal(result.status, 0);
        assert_true(result.output.find(file) != std::string::npos);
        const Decoded picture(file);
        assert_int_equal(picture.width, 1280);
        assert_int_equal(picture.height, 720);
        expect_scene(picture);
        const double warm = picture.warm_share(0, picture.width);
        assert_true(warm > 0.01 && warm < 0.6);
    }
    assert_string_equal(cli::scratch_files().c_str(), "bunny.png ");
}

static void test_cli_picture_shows_ropes_and_boxes(void**) {
    const std::string file = scratch("rope.png");
    assert_int_equal(cli::run("run RopeAttach --engine bullet --frames 10 --png " + file).status, 0);
    const Decoded picture(file);
    expect_scene(picture);
    assert_true(picture.warm_share(0, picture.width) > 0.001); // two thin ropes
}

static void test_cli_demo_makes_a_page(void**) {
    const std::string folder = scratch("page");
    const cli::Result result = cli::run("demo --frames 2 --out " + folder);
    if (result.status != 0) { fail_msg("exit status %d: %s", result.status, result.errors.c_str()); }
    const size_t end = result.output.find_last_not_of('\n'), begin = result.output.rfind('\n', end) + 1;
    const std::string page = result.output.substr(begin, end + 1 - begin);
    assert_true(page[0] == '/');
    const std::string html = cli::read_file(page);
    for (const char* name : {"bunny", "ropeattach", "tetrabunny", "cutting1"}) {
        const std::string file = std::string(name) + ".png";
        assert_true(html.find("src=\"" + file + "\"") != std::string::npos);
        const Decoded picture(folder + "/" + file);
        assert_int_equal(picture.width, 1600);
        assert_int_equal(picture.height, 720);
        expect_scene(picture);
        assert_true(picture.warm_share(0, 800) > 0.001);
        assert_true(picture.warm_share(800, 1600) > 0.001);
    }
    for (const char* name : {"Bunny", "RopeAttach", "TetraBunny", "Cutting1"}) {
        assert_true(html.find(name) != std::string::npos && result.output.find(name) != std::string::npos);
    }
    assert_true(html.find("http") == std::string::npos); // nothing from the network
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cli_run_writes_a_picture),
        cmocka_unit_test(test_cli_picture_shows_ropes_and_boxes),
        cmocka_unit_test(test_cli_demo_makes_a_page),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
