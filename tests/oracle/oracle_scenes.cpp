// The scenes against btSoftBody: step by step from the same state, and as whole runs.

#include <cstring>

#include "measure/compare.h"
#include "measure/contact_match.h"
#include "scene_records.h"

#include "check.h"
#include "measure/measure.h"

using namespace demos;

// Far enough that each scene is in the thick of its contacts.
static const int frames = 150;

static void each_step_is_bit_equal(void**) {
    for (int i = 0; i < scene_demo_count; ++i) {
        const DescriptionPointer description = Description::build(*scene_list[i], {});
        const OneStep result = compare_one_step(*description, frames, {});
        if (result.bit_equal_share < 1.0 || result.frames_with_lone_contacts > 0) {
            fail_msg("%s: %g of the frames are bit-equal, largest error %g, %d frames with lone contacts",
                     scene_list[i]->name, result.bit_equal_share, result.maximum, result.frames_with_lone_contacts);
        }
        assert_int_equal(result.frames, frames);
        assert_int_equal(result.errors.size(), frames);
        check_at_most(result.maximum, 0.0);
        assert_int_equal(result.frames_above_limit + result.unexplained_frames, 0);
    }
}

// Nearest points from the core's own search in place of Bullet's.
static void clusters_are_near_with_own_nearest_points(void**) {
    for (const char* name : {"ClusterDeform", "ClusterSocket", "ClusterCollide1", "TetraCube"}) {
        const DescriptionPointer description = describe(name);
        const OneStep result = compare_one_step(*description, frames, {}, Witness::pliant);
        check_at_most(result.median, 1e-7);
        assert_true(result.bit_equal_share < 1.0);
    }
}

static int contact_count(const PliantEngine& engine) {
    int count = 0;
    for (int i = 0; i < engine.soft_count(); ++i) {
        count += pli_body_get_cluster_contacts(engine.body(i), 0, nullptr);
    }
    return count;
}

// So that the steps above are equal because of their contacts and not for want of them.
static void clusters_have_contacts(void**) {
    for (const char* name :
         {"ClusterDeform", "ClusterCollide1", "ClusterCollide2", "ClusterStackMixed", "TetraBunny", "ClusterCar"}) {
        const DescriptionPointer description = describe(name);
        PliantEngine engine(*description, EngineOptions{true, true});
        int contacts = 0;
        for (int frame = 0; frame < frames; ++frame) {
            engine.step();
            contacts += contact_count(engine);
        }
        if (contacts < 50) { fail_msg("%s: %d contacts", name, contacts); }
    }
}

static bool same_topology(const SoftState& a, const SoftState& b) {
    return a.positions.size() == b.positions.size() && a.link_nodes == b.link_nodes && a.face_nodes == b.face_nodes &&
           a.inverse_masses == b.inverse_masses;
}

static void cuts_give_the_same_topology(void**) {
    const DescriptionPointer description = describe("Cutting1");
    BulletEngine reference(*description);
    PliantEngine pliant(*description, EngineOptions{true});
    size_t nodes = reference.soft(0).positions.size();
    int cuts = 0;
    for (int frame = 1; frame <= frames; ++frame) {
        reference.step();
        pliant.step();
        const SoftState expected = reference.soft(0), actual = pliant.soft(0);
        if (!same_topology(expected, actual)) { fail_msg("the engines differ at frame %d", frame); }
        cuts += expected.positions.size() > nodes ? 1 : 0;
        nodes = expected.positions.size();
    }
    assert_int_equal(cuts, 3);
}

static bool same_bits(const std::vector<pli_vec3>& a, const std::vector<pli_vec3>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(pli_vec3)) == 0;
}

// Only the order of contacts is taken over, no state. In these scenes free runs part because of it; all but RopeAttach
// do so within the frames of this test.
static void whole_runs_are_bit_equal_in_bullets_order(void**) {
    for (const char* name : {"Cloth", "RopeAttach", "Sticks", "Collide", "Collide2", "Collide3"}) {
        const DescriptionPointer description = describe(name);
        BulletEngine reference(*description);
        PliantEngine pliant(*description, EngineOptions{true});
        ContactMatcher matcher(reference, pliant);
        int lone = 0;
        pliant.bridge().set_before_solve([&] { lone += matcher.match(); });
        for (int frame = 1; frame <= frames; ++frame) {
            reference.step();
            pliant.step();
            for (int k = 0; k < reference.soft_count(); ++k) {
                const SoftState expected = reference.soft(k), actual = pliant.soft(k);
                if (!same_bits(expected.positions, actual.positions) ||
                    !same_bits(expected.velocities, actual.velocities)) {
                    fail_msg("%s: soft body %d differs at frame %d", name, k, frame);
                }
            }
        }
        assert_int_equal(lone, 0);
    }
}

static void free_runs_without_contacts_stay_equal(void**) {
    for (const char* name : {"Aero2", "Ropes", "RopeAttach", "ClothAttach"}) {
        const DescriptionPointer description = describe(name);
        const Comparison result = compare(*description, 60, {});
        assert_string_equal(result.scene.c_str(), name);
        check_near(result.free_run.error_30, 0.0, 0.0);
        check_near(result.free_run.error_60, 0.0, 0.0);
        check_near(result.free_run.error_300, -1.0, 0.0);
        assert_true(result.bullet_ms > 0.0 && result.pliant_ms > 0.0 && result.nodes > 0);
    }
}

static void progress_counts_both_parts(void**) {
    const DescriptionPointer description = describe("Bending");
    std::vector<int> seen;
    compare(*description, 3, [&](int frame, int total) {
        assert_int_equal(total, 6);
        seen.push_back(frame);
    });
    assert_true(seen == std::vector<int>({1, 2, 3, 4, 5, 6}));
}

// --------------------------------------------------------------------------------- that differences would be seen

static void sheet_build(scene_builder* builder, bool has_contacts) {
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = {-1, 0.3f, -1}, patch.corner_10 = {1, 0.3f, -1};
    patch.corner_01 = {-1, 0.3f, 1}, patch.corner_11 = {1, 0.3f, 1};
    patch.columns = patch.rows = 5;
    pli_mesh* mesh = nullptr;
    scene_check(builder, pli_mesh_create_patch(scene_context(builder), &patch, &mesh));
    scene_soft_def def = scene_soft_def_default();
    def.has_rigid_contacts = has_contacts;
    scene_add_soft(builder, mesh, &def);
    scene_rigid_def ground = scene_rigid_def_default();
    ground.shape = scene_box({5, 1, 5});
    ground.pose.origin = {0, -1, 0};
    scene_add_rigid(builder, &ground);
}

static void lone_contacts_are_counted(void**) {
    const scene with = test_scene([](scene_builder* builder) { sheet_build(builder, true); });
    const scene without = test_scene([](scene_builder* builder) { sheet_build(builder, false); });
    const DescriptionPointer contacts = Description::build(with, {}), none = Description::build(without, {});
    for (const bool bullet_has_them : {true, false}) {
        BulletEngine reference(bullet_has_them ? *contacts : *none);
        PliantEngine pliant(bullet_has_them ? *none : *contacts, EngineOptions{true});
        ContactMatcher matcher(reference, pliant);
        int lone = 0;
        pliant.bridge().set_before_solve([&] { lone = matcher.match(); });
        for (int frame = 0; frame < 15; ++frame) {
            reference.step();
            pliant.step();
        }
        assert_int_equal(lone, 25);
    }
}

// Exact mode does not interpolate distances on a lattice as btSoftBody does.
static void exact_mode_differs(void**) {
    const DescriptionPointer description = describe("Pressure");
    BulletEngine reference(*description);
    PliantEngine pliant(*description, {});
    for (int frame = 0; frame < 120; ++frame) {
        reference.step();
        pliant.step();
    }
    assert_true(measure(reference).state_hash != measure(pliant).state_hash);
}

static void nothing_to_compare_is_an_error(void**) {
    const DescriptionPointer bending = describe("Bending");
    assert_string_equal(error_of([&] { compare(*bending, 0, {}); }).c_str(), "a comparison needs one frame at least");
    const scene empty = test_scene([](scene_builder*) {});
    const DescriptionPointer description = Description::build(empty, {});
    assert_string_equal(error_of([&] { compare(*description, 1, {}); }).c_str(),
                        "the scene has no soft bodies to compare");
}

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(each_step_is_bit_equal),
        cmocka_unit_test(clusters_are_near_with_own_nearest_points),
        cmocka_unit_test(clusters_have_contacts),
        cmocka_unit_test(cuts_give_the_same_topology),
        cmocka_unit_test(whole_runs_are_bit_equal_in_bullets_order),
        cmocka_unit_test(free_runs_without_contacts_stay_equal),
        cmocka_unit_test(progress_counts_both_parts),
        cmocka_unit_test(lone_contacts_are_counted),
        cmocka_unit_test(exact_mode_differs),
        cmocka_unit_test(nothing_to_compare_is_an_error),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
