// The camera of the viewer, however it is turned, moved and zoomed, stays above the ground and goes on looking at its
// target.
#include "check.h"
#include "viewer/orbit.h"

#include <random>

namespace {

render::Camera start(pli_vec3 target, float distance, float pitch) {
    render::Camera camera = render::turned_camera(215, pitch, 1.5f);
    camera.distance = distance;
    camera.eye = pli_vec3_sub(target, pli_vec3_scale(camera.forward, distance));
    return camera;
}

pli_vec3 target_of(const render::Camera& camera) {
    return pli_vec3_add(camera.eye, pli_vec3_scale(camera.forward, camera.distance));
}

} // namespace

static void test_turning_down_ends_above_the_ground(void**) {
    viewer::Orbit orbit;
    orbit.stay_above(1);
    orbit.look_from(start(pli_vec3_make(0, 3, 0), 10, -20));
    orbit.turn(0, -1000); // up to the mouse, down for the camera
    const render::Camera low = orbit.camera(1.5f);
    check_near(low.eye.y, 1.05, 1e-3);
    check_near(target_of(low).y, 3, 1e-4);
    // Without a ground it goes below.
    viewer::Orbit free;
    free.look_from(start(pli_vec3_make(0, 3, 0), 10, -20));
    free.turn(0, -1000);
    check_at_most(free.camera(1.5f).eye.y, -6);
    // It comes up again at once.
    orbit.turn(0, 10);
    assert_true(orbit.camera(1.5f).eye.y > low.eye.y + 0.3f);
}

static void test_no_way_leads_below_the_ground(void**) {
    std::mt19937 random(1);
    const auto number = [&](float low, float high) {
        return low + (high - low) * static_cast<float>(random() % 1000) / 1000;
    };
    viewer::Orbit orbit;
    orbit.stay_above(0);
    orbit.look_from(start(pli_vec3_make(0, 1, 0), 6, -20));
    for (int i = 0; i < 10000; ++i) {
        switch (random() % 3) {
        case 0:
            orbit.turn(number(-100, 100), number(-100, 100));
            break;
        case 1:
            orbit.pan(number(-50, 50), number(-50, 50), 720);
            break;
        default:
            orbit.zoom(number(-3, 3));
        }
        assert_true(orbit.camera(1.5f).eye.y > 0);
    }
}

int main() {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_turning_down_ends_above_the_ground),
        cmocka_unit_test(test_no_way_leads_below_the_ground),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
