// Soft bodies on kinematic bodies that a game moves: they touch them where they are drawn.

#include "check.h"
#include "test_bridge_world.h"

#include <pliant/anchor.h>
#include <pliant/contact.h>
#include <pliant/drawing.h>
#include <pliant/implicit.h>
#include <pliant/xpbd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace {

using bridge_test::StockWorld;

enum class Solver { position_based, xpbd, implicit };
enum class Manner { motion_state, transform, tick };
constexpr float margin = 0.02f;                       // m
constexpr btScalar step = btScalar(1) / btScalar(60); // s

/// What the tick callback moves, and how fast; m/s.
btRigidBody* ticked = nullptr;
btScalar ticked_speed = 0;

/// A sheet that lies on a lift, 1 kg.
struct Lift {
    StockWorld stock;
    pliant::Bridge bridge{*stock.world};
    btRigidBody* body = nullptr;
    pli_body* sheet = nullptr;
    Manner manner;
    btScalar half;
    btScalar height = 0;

    Lift(Manner by, Solver solver, bool has_faces, btScalar half_height = btScalar(0.5), float above = margin)
        : manner(by), half(half_height) {
        body = &stock.add_box(btVector3(2, half, 2), 0, btVector3(0, -half, 0));
        body->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        body->setActivationState(DISABLE_DEACTIVATION);
        if (manner != Manner::motion_state) { body->setMotionState(nullptr); }
        sheet = bridge_test::add_sheet(bridge, 1, above, 9, 0, 0, 0, margin);
        if (solver == Solver::xpbd) {
            assert_int_equal(pli_body_enable_xpbd(sheet, nullptr), PLI_OK);
            assert_int_equal(pli_body_enable_xpbd_links(sheet, nullptr), PLI_OK);
        }
        if (solver == Solver::implicit) { assert_int_equal(pli_body_enable_implicit(sheet, nullptr), PLI_OK); }
        if (has_faces) { assert_int_equal(pli_body_enable_rigid_face_contacts(sheet, nullptr), PLI_OK); }
    }
    /// A frame of so many sub-steps, at so many m/s.
    void frame(btScalar speed, int sub_steps) {
        height += speed * step * btScalar(sub_steps);
        btTransform pose = btTransform::getIdentity();
        pose.setOrigin(btVector3(0, height - half, 0));
        if (manner == Manner::motion_state) { body->getMotionState()->setWorldTransform(pose); }
        if (manner == Manner::transform) { body->setWorldTransform(pose); }
        ticked = body;
        ticked_speed = speed;
        const auto move = [](btDynamicsWorld*, btScalar dt) { ticked->translate(btVector3(0, ticked_speed * dt, 0)); };
        stock.world->setInternalTickCallback(manner == Manner::tick ? btInternalTickCallback(move) : nullptr, nullptr,
                                             true);
        // A little more than the sub-steps take, so that rounding never costs one.
        stock.world->stepSimulation(step * (btScalar(sub_steps) + btScalar(1e-4)), sub_steps, step);
    }
    /// Nodes as they are drawn at the end of the frame.
    std::vector<btVector3> drawn() const {
        const auto count = static_cast<std::size_t>(pli_body_get_view(sheet).node_count);
        std::vector<float> places(3 * count);
        pli_vertex_buffer_def def = pli_vertex_buffer_def_default();
        def.vertices = places.data();
        def.vertex_count = static_cast<int>(count);
        def.stride = 3 * sizeof(float);
        def.normal_offset = -1;
        assert_int_equal(pli_body_write_vertices(sheet, &def, 1), PLI_OK);
        std::vector<btVector3> nodes;
        for (std::size_t i = 0; i < count; ++i) {
            nodes.emplace_back(btScalar(places[3 * i]), btScalar(places[3 * i + 1]), btScalar(places[3 * i + 2]));
        }
        return nodes;
    }
    /// The largest distance of a node from the margin around the lift, as it is drawn.
    double off() const {
        const pli_body_view view = pli_body_get_view(sheet);
        const btScalar top = body->getWorldTransform().getOrigin().y() + half + btScalar(margin);
        double most = 0;
        for (int i = 0; i < view.node_count; ++i) {
            most = std::max(most, std::abs(double(btScalar(view.positions[i].y) - top)));
        }
        return most;
    }
};

/// Also while it gathers speed, at 5 m/s^2, but for what a tick callback does before Bullet sees any.
void test_a_sheet_lies_on_a_lift_where_it_is_drawn(void**) {
    double most_of_all = 0, most_at_end = 0;
    for (int i = 0; i < 3 * 3 * 2 * 2 * 3; ++i) {
        const Manner manner = std::array{Manner::motion_state, Manner::transform, Manner::tick}[std::size_t(i % 3)];
        const Solver solver =
            std::array{Solver::position_based, Solver::xpbd, Solver::implicit}[std::size_t(i / 3 % 3)];
        const bool has_faces = i / 9 % 2 == 1;
        const int sub_steps = i / 18 % 2 + 1;
        const btScalar top_speed = std::array{btScalar(-3), btScalar(3), btScalar(8)}[std::size_t(i / 36)];
        Lift lift(manner, solver, has_faces);
        double most = 0;
        for (int k = 0; k < 150; ++k) {
            const btScalar speed = btScalar(std::min(k, 96)) / 96 * top_speed;
            lift.frame(speed, sub_steps);
            most = std::max(most, lift.off());
        }
        assert_int_equal(lift.bridge.step_status(), PLI_OK);
        most_of_all = std::max(most_of_all, most);
        most_at_end = std::max(most_at_end, lift.off());
    }
    print_message("at most %.2g m off, %.2g at the end\n", most_of_all, most_at_end);
    check_at_most(most_of_all, 5e-3);
    check_at_most(most_at_end, 1e-5);
}

/// At 15 frames per second Bullet has a lift of 5 m/s up to 25 cm ahead, where a thin one touches nothing that lies on
/// it. A sheet lies on it all the same, or falls onto one of 2 or 3 m/s from 30 cm.
void test_thin_lifts_are_met_on_their_way(void**) {
    double most_at_rest = 0, most_after_fall = 0, most_through = 0;
    for (int i = 0; i < 2 * 3 * 2 * 2; ++i) {
        const Manner manner = i % 2 == 0 ? Manner::motion_state : Manner::transform;
        const Solver solver =
            std::array{Solver::position_based, Solver::xpbd, Solver::implicit}[std::size_t(i / 2 % 3)];
        const bool falls = i / 6 % 2 == 1;
        const btScalar speed = falls ? btScalar(2 + i / 12) : i / 12 == 0 ? btScalar(-5) : btScalar(5);
        Lift lift(manner, solver, false, btScalar(0.05), falls ? margin + 0.3f : float(margin));
        for (int k = 0; k < 60; ++k) {
            lift.frame(falls ? speed : btScalar(std::min(k, 30)) / btScalar(30) * speed, 4);
            if (!falls) { most_at_rest = std::max(most_at_rest, lift.off()); }
            const btScalar top = lift.body->getWorldTransform().getOrigin().y() + lift.half + btScalar(margin);
            most_through = std::max(most_through, static_cast<double>(top - btScalar(bridge_test::lowest(lift.sheet))));
        }
        assert_int_equal(lift.bridge.step_status(), PLI_OK);
        most_after_fall = std::max(most_after_fall, lift.off());
    }
    print_message("at most %.2g m off where it lies, %.2g at the end, %.2g m too low\n", most_at_rest, most_after_fall,
                  most_through);
    check_at_most(most_at_rest, 1e-5);
    check_at_most(most_after_fall, 1e-5);
    check_at_most(most_through, 1e-5);
}

/// One of 10 cm that comes up at 20 or 30 m/s, 33 or 50 cm in a step, is past a sheet where Bullet looks for pairs with
/// it.
void test_fast_lifts_are_met_in_the_last_step_of_a_frame(void**) {
    double most = 0;
    for (int i = 0; i < 2 * 3 * 2 * 2; ++i) {
        const Solver solver =
            std::array{Solver::position_based, Solver::xpbd, Solver::implicit}[std::size_t(i / 2 % 3)];
        const int sub_steps = i / 6 % 2 + 1;
        Lift lift(i % 2 == 0 ? Manner::motion_state : Manner::transform, solver, true, btScalar(0.05), 4.15f);
        for (int k = 0; k < 40; ++k) {
            lift.frame(i / 12 == 0 ? 20 : 30, sub_steps);
            const btScalar top = lift.body->getWorldTransform().getOrigin().y() + lift.half + btScalar(margin);
            most = std::max(most, static_cast<double>(top - btScalar(bridge_test::lowest(lift.sheet))));
        }
        assert_int_equal(lift.bridge.step_status(), PLI_OK);
    }
    print_message("at most %.2g m too low\n", most);
    check_at_most(most, 0.0135); // above the core of the lift, if not by the whole margin
}

/// Sheets that step in every fourth step only, of which Bullet has moved the lift through the first: they lie on it, or
/// hang from it by one edge, where it is drawn.
void test_sheets_that_step_less_often_go_along(void**) {
    double most_lying = 0, most_held = 0;
    for (int i = 0; i < 2 * 3 * 2 * 2; ++i) {
        const bool is_held = i % 2 == 1;
        const Solver solver =
            std::array{Solver::position_based, Solver::xpbd, Solver::implicit}[std::size_t(i / 2 % 3)];
        const int sub_steps = i / 6 % 2 + 1;
        const btScalar top_speed = i / 12 == 0 ? btScalar(-5) : btScalar(5);
        Lift lift(Manner::motion_state, solver, false);
        constexpr std::array<int, 9> edge{0, 1, 2, 3, 4, 5, 6, 7, 8};
        if (is_held) {
            assert_int_equal(pli_body_attach_nodes(lift.sheet, edge.data(), 9, lift.bridge.rigid(*lift.body)), PLI_OK);
        }
        assert_int_equal(pli_body_set_update_interval(lift.sheet, 4), PLI_OK);
        for (int k = 0; k < 120; ++k) {
            lift.frame(btScalar(std::min(k, 60)) / btScalar(60) * top_speed, sub_steps);
        }
        const std::vector<btVector3> nodes = lift.drawn();
        for (std::size_t node = 0; node < (is_held ? edge.size() : nodes.size()); ++node) {
            const btScalar above = nodes[node].y() - lift.body->getWorldTransform().getOrigin().y() - lift.half;
            double& most = is_held ? most_held : most_lying;
            most = std::max(most, std::abs(static_cast<double>(above - btScalar(margin))));
        }
    }
    print_message("at most %.2g m off where they lie, %.2g where they are held\n", most_lying, most_held);
    check_at_most(most_lying, 0.02);
    check_at_most(most_held, 1e-5);
}

/// 5 kg, which Bullet itself lets go through the platform: only the cloth holds it.
void test_a_crate_on_cloth_rides_on_a_lift(void**) {
    constexpr float half = 0.15f;
    double most = 0, upright = 1;
    for (int i = 0; i < 36; ++i) {
        const Manner manner = std::array{Manner::motion_state, Manner::transform, Manner::tick}[std::size_t(i % 3)];
        const Solver solver =
            std::array{Solver::position_based, Solver::xpbd, Solver::implicit}[std::size_t(i / 3 % 3)];
        Lift lift(manner, solver, i / 9 % 2 == 1);
        btRigidBody& crate =
            lift.stock.add_box(btVector3(half, half, half), 5, btVector3(0, btScalar(2 * margin + half), 0));
        crate.setIgnoreCollisionCheck(lift.body, true);
        crate.setActivationState(DISABLE_DEACTIVATION);
        const btScalar top_speed = i / 18 == 0 ? btScalar(-3) : btScalar(3);
        for (int k = 0; k < 150; ++k) {
            lift.frame(btScalar(std::min(k, 96)) / 96 * top_speed, 1);
            const btTransform pose = crate.getWorldTransform();
            const double above = static_cast<double>(pose.getOrigin().y() - lift.height);
            most = std::max(most, std::abs(above - static_cast<double>(half + 2 * margin)));
            upright = std::min(upright, static_cast<double>(pose.getBasis()[1][1]));
        }
        assert_int_equal(lift.bridge.step_status(), PLI_OK);
    }
    print_message("at most %.2g m off, upright to %.2g\n", most, 1 - upright);
    check_at_most(most, 0.003);
    check_near(upright, 1, 1e-3);
}

/// A lift 8 m up that is placed after it was made, without a motion state, which Bullet takes for 480 m/s in the first
/// step. A sheet lies on it, and another one is held to it by its edge.
void test_a_lift_that_was_placed_stands_still(void**) {
    for (int i = 0; i < 2 * 3; ++i) {
        const Solver solver = std::array{Solver::position_based, Solver::xpbd, Solver::implicit}[std::size_t(i % 3)];
        const bool is_held = i < 3;
        StockWorld stock;
        btBoxShape shape(btVector3(2, 0.5f, 2));
        btRigidBody lift(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &shape));
        lift.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 8, 0)));
        lift.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        stock.world->addRigidBody(&lift);
        pliant::Bridge bridge(*stock.world);
        pli_body* sheet = bridge_test::add_sheet(bridge, 1, is_held ? 12 : 8.5f + margin, 9, 0, 0, 0, margin);
        if (solver == Solver::xpbd) {
            assert_int_equal(pli_body_enable_xpbd(sheet, nullptr), PLI_OK);
            assert_int_equal(pli_body_enable_xpbd_links(sheet, nullptr), PLI_OK);
        }
        if (solver == Solver::implicit) { assert_int_equal(pli_body_enable_implicit(sheet, nullptr), PLI_OK); }
        const std::array edge{0, 1, 2, 3, 4, 5, 6, 7, 8};
        if (is_held) { assert_int_equal(pli_body_attach_nodes(sheet, edge.data(), 9, bridge.rigid(lift)), PLI_OK); }
        double fastest = 0;
        for (int k = 0; k < 10; ++k) {
            stock.step(1);
            for (int node = 0; node < pli_body_get_view(sheet).node_count; ++node) {
                const pli_vec4 v = pli_body_get_view(sheet).velocities[node];
                fastest = std::max(fastest, std::sqrt(double(v.x * v.x + v.y * v.y + v.z * v.z)));
            }
        }
        print_message("solver %d, %s: at most %.3f m/s\n", int(solver), is_held ? "held" : "lies", fastest);
        check_at_most(fastest, is_held ? 3 : 0.01); // m/s; the free edge of what is held falls
        stock.world->removeRigidBody(&lift);
    }
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_a_lift_that_was_placed_stands_still),
        cmocka_unit_test(test_a_sheet_lies_on_a_lift_where_it_is_drawn),
        cmocka_unit_test(test_thin_lifts_are_met_on_their_way),
        cmocka_unit_test(test_fast_lifts_are_met_in_the_last_step_of_a_frame),
        cmocka_unit_test(test_sheets_that_step_less_often_go_along),
        cmocka_unit_test(test_a_crate_on_cloth_rides_on_a_lift),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
