// What a user does to scenes that run: rays, dragging, cutting, balls; on both engines.

#include "scene_records.h"

#include <cmath>

#include "check.h"
#include "measure/measure.h"

using demos::EngineKind;
using demos::RayHit;

namespace {

constexpr EngineKind both[] = {EngineKind::pliant, EngineKind::bullet};
using EnginePointer = std::unique_ptr<demos::Engine>;

void step(demos::Engine& engine, int count) {
    for (int i = 0; i < count; ++i) {
        engine.step();
    }
}

float distance(pli_vec3 a, pli_vec3 b) {
    return pli_vec3_length(pli_vec3_sub(a, b));
}

RayHit cast_down(const demos::Engine& engine, float x, float z) {
    return engine.cast_ray({x, 20, z}, {x, -20, z}, 0.05f);
}

} // namespace

// The sheet of Cutting1 is at y = 2, nodes are 0.8 m apart, the ground ends at y = -10.5 or so.
static void rays_meet_what_is_first(void**) {
    const auto description = describe("Cutting1");
    for (const EngineKind kind : both) {
        const EnginePointer engine = demos::make_engine(kind, *description, {});
        const RayHit cloth = cast_down(*engine, 1.9f, -2.1f);
        assert_int_equal(cloth.soft, 0);
        assert_int_equal(cloth.rigid, -1);
        check_near(cloth.point.y, 2, 1e-4);
        check_near(cloth.fraction, 18.0 / 40.0, 1e-5);
        assert_true(distance(engine->node_position(0, cloth.node), cloth.point) < 0.57f);
        const RayHit ground = cast_down(*engine, 7, 0);
        assert_int_equal(ground.soft, -1);
        assert_int_equal(ground.rigid, 0);
        assert_false(engine->grab(ground)); // it does not move
        const RayHit nothing = engine->cast_ray({0, 20, 0}, {0, 30, 0}, 0.05f);
        assert_false(nothing.is_hit());
        assert_false(engine->grab(nothing));
    }
}

static void ropes_are_met_beside(void**) {
    const auto description = describe("Ropes");
    for (const EngineKind kind : both) {
        const EnginePointer engine = demos::make_engine(kind, *description, {});
        const pli_vec3 node = engine->node_position(3, 7);
        const auto cast = [&](float aside, float radius) {
            return engine->cast_ray({node.x, node.y + 5, node.z + aside}, {node.x, node.y - 5, node.z + aside}, radius);
        };
        const RayHit hit = cast(0.08f, 0.1f);
        assert_int_equal(hit.soft, 3);
        assert_int_equal(hit.node, 7);
        assert_true(cast(0.12f, 0.1f).soft != 3);
    }
}

static void a_node_follows_the_hand(void**) {
    const auto description = describe("Cutting1");
    for (const EngineKind kind : both) {
        const EnginePointer engine = demos::make_engine(kind, *description, {});
        const RayHit hit = cast_down(*engine, 0.4f, 0.4f);
        assert_true(engine->grab(hit));
        const pli_vec3 goal = pli_vec3_add(engine->grip(), {0, 3, 0});
        engine->drag(goal);
        step(*engine, 40);
        assert_true(distance(engine->grip(), goal) < 0.4f);
        engine->let_go();
        step(*engine, 40); // it falls back
        assert_true(engine->node_position(0, hit.node).y < goal.y - 2.0f);
    }
}

static void a_pinned_node_stays(void**) {
    const auto description = describe("Cutting1");
    for (const EngineKind kind : both) {
        const EnginePointer engine = demos::make_engine(kind, *description, {});
        const RayHit hit = cast_down(*engine, 5.95f, -5.95f);
        const pli_vec3 before = engine->node_position(0, hit.node);
        assert_true(engine->grab(hit));
        engine->drag({0, 9, 0});
        step(*engine, 10);
        assert_true(distance(engine->node_position(0, hit.node), before) < 1e-6f);
    }
}

// The first of the bodies above the sheet.
static void a_rigid_body_follows_the_hand(void**) {
    const auto description = describe("Cloth");
    for (const EngineKind kind : both) {
        const EnginePointer engine = demos::make_engine(kind, *description, {});
        const pli_vec3 start = engine->rigid(1).pose.origin;
        const RayHit hit = engine->cast_ray({start.x, start.y, 50}, {start.x, start.y, -50}, 0.05f);
        assert_int_equal(hit.rigid, 1);
        assert_true(engine->grab(hit));
        const pli_vec3 goal = pli_vec3_add(hit.point, {-12, 2, 0});
        engine->drag(goal);
        step(*engine, 120);
        const pli_vec3 pulled = engine->rigid(1).pose.origin; // it hangs by the end of a bar
        assert_true(pulled.x < -7.0f);
        check_near(distance(pulled, goal), distance(start, hit.point), 0.3);
        engine->let_go();
        step(*engine, 60);
        assert_true(engine->rigid(1).pose.origin.y < goal.y - 3.0f);
    }
}

static void a_ball_is_cut_out(void**) {
    const auto description = describe("Cutting1");
    for (const EngineKind kind : both) {
        const EnginePointer engine = demos::make_engine(kind, *description, {});
        const demos::SoftState before = engine->soft(0);
        assert_int_equal(demos::part_count(before), 1);
        engine->cut_sphere(0, {0, 2, 0}, 1);
        const demos::SoftState after = engine->soft(0);
        assert_true(after.positions.size() >= before.positions.size() + 12);
        assert_true(after.face_nodes.size() > before.face_nodes.size());
        assert_int_equal(demos::part_count(after), 2);
        assert_true(engine->contacts(0).empty());
        step(*engine, 20);
        assert_true(demos::measure(*engine).finite);
    }
}

static void a_sweep_parts_the_sheet(void**) {
    const auto description = describe("Cutting1");
    const EnginePointer engine = demos::make_engine(EngineKind::pliant, *description, {});
    const size_t links = engine->soft(0).rest_lengths.size();
    pli_vec3 first[2] = {{-7, 20, 0.3f}, {-7, -20, 0.3f}};
    for (int i = 1; i <= 14; ++i) { // in pieces, as a mouse does it
        const float x = -7.0f + static_cast<float>(i);
        const pli_vec3 second[2] = {{x, 20, 0.3f}, {x, -20, 0.3f}};
        engine->cut_swept(first, second);
        first[0] = second[0];
        first[1] = second[1];
    }
    const demos::SoftState after = engine->soft(0);
    assert_int_equal(demos::part_count(after), 2);
    assert_true(after.rest_lengths.size() > links);
    step(*engine, 20);
    assert_true(demos::measure(*engine).finite);
}

static void what_cannot_be_cut_is_named(void**) {
    const auto tetras = describe("TetraCube"), clusters = describe("ClusterDeform"), sheet = describe("Cutting1");
    const EnginePointer bullet = demos::make_engine(EngineKind::bullet, *clusters, {});
    assert_true(error_of([&] {
                    bullet->cut_sphere(0, {0, 0, 0}, 1);
                }).find("does not outlive a cut") != std::string::npos);
    const EnginePointer pliant = demos::make_engine(EngineKind::pliant, *tetras, {});
    const uint64_t hash = demos::measure(*pliant).state_hash;
    const pli_vec3 middle = pliant->node_position(0, 0);
    assert_true(error_of([&] { pliant->cut_sphere(0, middle, 1); }).find("tetrahedra") != std::string::npos);
    assert_true(demos::measure(*pliant).state_hash == hash);
    const EnginePointer other = demos::make_engine(EngineKind::bullet, *sheet, {});
    const pli_vec3 ray[2] = {{0, 1, 0}, {0, -1, 0}};
    assert_string_equal(error_of([&] { other->cut_swept(ray, ray); }).c_str(),
                        "btSoftBody cannot be cut along a swept ray");
}

static void balls_hit_the_sheet(void**) {
    const auto description = describe("Cutting1");
    for (const EngineKind kind : both) {
        const EnginePointer engine = demos::make_engine(kind, *description, {}),
                            calm = demos::make_engine(kind, *description, {});
        const int described = engine->rigid_count();
        engine->shoot({0, 6, 0}, {0, -15, 0}, 0.7f, 20);
        assert_int_equal(engine->rigid_count(), described + 1);
        check_near(engine->rigid_record(described).shape.radius, 0.7, 1e-6);
        step(*engine, 25);
        step(*calm, 25);
        const int middle = 8 * 16 + 8;
        assert_true(engine->node_position(0, middle).y < calm->node_position(0, middle).y - 0.5f);
        assert_true(engine->rigid(described).pose.origin.y < 2.0f);
        for (int i = 1; i < demos::most_balls; ++i) {
            engine->shoot({100, 6, static_cast<float>(i)}, {0, 0, 0}, 0.1f, 1);
        }
        assert_string_equal(error_of([&] {
                                engine->shoot({0, 6, 0}, {0, 0, 0}, 0.1f, 1);
                            }).c_str(),
                            "there are 64 balls already");
        step(*engine, 1);
        assert_true(demos::measure(*engine).finite);
    }
}

static void marks_are_where_the_bodies_are(void**) {
    const auto description = describe("ClusterDeform");
    for (const EngineKind kind : both) {
        const EnginePointer engine = demos::make_engine(kind, *description, {});
        const std::vector<demos::ClusterMark> clusters = engine->clusters(0);
        assert_int_equal(clusters.size(), engine->soft(0).cluster_count);
        assert_int_equal(clusters[0].nodes.size(), 300); // the first one has all nodes
    }
    const auto bunny = describe("Bunny");
    for (const EngineKind kind : both) {
        const EnginePointer engine = demos::make_engine(kind, *bunny, {});
        assert_true(engine->contacts(0).empty());
        step(*engine, 100);
        const std::vector<demos::ContactMark> contacts = engine->contacts(0);
        assert_true(contacts.size() > 3);
        for (const demos::ContactMark& contact : contacts) {
            check_near(pli_vec3_length(contact.normal), 1, 1e-4);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_meet_what_is_first),       cmocka_unit_test(ropes_are_met_beside),
        cmocka_unit_test(a_node_follows_the_hand),       cmocka_unit_test(a_pinned_node_stays),
        cmocka_unit_test(a_rigid_body_follows_the_hand), cmocka_unit_test(a_ball_is_cut_out),
        cmocka_unit_test(a_sweep_parts_the_sheet),       cmocka_unit_test(what_cannot_be_cut_is_named),
        cmocka_unit_test(balls_hit_the_sheet),           cmocka_unit_test(marks_are_where_the_bodies_are),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
