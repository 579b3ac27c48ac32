// Anchors to dynamic bodies of a Bullet world: where they hold, and what energy they leave.

#include "check.h"
#include "test_bridge_world.h"

#include "pliant_bullet/snapshot.h"

#include <pliant/implicit.h>
#include <pliant/tether.h>
#include <pliant/xpbd.h>

#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

namespace {

using bridge_test::StockWorld;

enum class Solver { position_based, xpbd, implicit };
constexpr int last_node = 9;
constexpr float lever = 0.5f; // m, from the anchor to the centre of the weight

void use_solver(pli_body* body, Solver solver) {
    if (solver == Solver::xpbd) {
        assert_int_equal(pli_body_enable_xpbd(body, nullptr), PLI_OK);
        assert_int_equal(pli_body_enable_xpbd_links(body, nullptr), PLI_OK);
    }
    if (solver == Solver::implicit) { assert_int_equal(pli_body_enable_implicit(body, nullptr), PLI_OK); }
}

/// A level rope of 1 m and 0.1 kg with a ball of 1 kg on a lever at its end.
struct Pendulum {
    StockWorld stock;
    pliant::Bridge bridge{*stock.world};
    btRigidBody* weight = nullptr;
    pli_body* rope = nullptr;

    explicit Pendulum(Solver solver) {
        weight = &stock.add_body(new btSphereShape(0.1f), 1, btVector3(1 + lever, 3, 0));
        weight->setActivationState(DISABLE_DEACTIVATION);
        pli_mesh* mesh = nullptr;
        assert_int_equal(pli_mesh_create_rope(bridge.context(), pli_vec3_make(0, 3, 0), pli_vec3_make(1, 3, 0), 8,
                                              PLI_ROPE_PIN_FIRST, &mesh),
                         PLI_OK);
        assert_int_equal(pli_mesh_set_total_mass(mesh, 0.1f), PLI_OK);
        assert_int_equal(bridge.add_body(mesh, nullptr, &rope), PLI_OK);
        pli_mesh_destroy(mesh);
        if (solver == Solver::position_based) { assert_int_equal(pli_body_enable_tethers(rope, nullptr), PLI_OK); }
        use_solver(rope, solver);
        assert_int_equal(pli_body_attach_nodes(rope, &last_node, 1, bridge.rigid(*weight)), PLI_OK);
    }
    /// J, of the weight, of which the rope is a tenth.
    double energy() const {
        const btVector3 v = weight->getLinearVelocity(), w = weight->getAngularVelocity();
        return double(btScalar(0.5) * v.length2() + btScalar(0.002) * w.length2() +
                      10 * weight->getWorldTransform().getOrigin().y());
    }
    /// m, of the node from its point of the weight.
    double gap() const {
        const pli_vec4 node = pli_body_get_view(rope).positions[last_node];
        const btVector3 point = weight->getWorldTransform() * btVector3(-lever, 0, 0);
        return double((btVector3(node.x, node.y, node.z) - point).length());
    }
};

/// But for what the rope gives it as it falls, 1 J at most.
void test_a_pendulum_gains_no_energy(void**) {
    for (const Solver solver : {Solver::position_based, Solver::xpbd, Solver::implicit}) {
        Pendulum pendulum(solver);
        const double start = pendulum.energy();
        double most = start, widest = 0;
        for (int i = 0; i < 600; ++i) {
            pendulum.stock.step(1);
            most = std::max(most, pendulum.energy());
            widest = std::max(widest, pendulum.gap());
        }
        print_message("solver %d: %.2f J at the start, at most %.2f J, gap %.2g m\n", int(solver), start, most, widest);
        check_at_most(most, start + 1);
        check_at_most(widest, solver == Solver::position_based ? 0.1 : 1e-3);
        assert_int_equal(pendulum.bridge.status(), PLI_OK);
    }
}

/// A door of 20 kg with cloth of 0.2 kg along its edge, as it turns on a hinge of Bullet without friction, and a bell
/// of 100 kg with a rope of 0.1 kg, as it swings. Neither gets faster, nor off its hinge, in 20 s.
void test_what_turns_on_a_hinge_gains_no_speed(void**) {
    for (int i = 0; i < 2 * 3; ++i) {
        const Solver solver = std::array{Solver::position_based, Solver::xpbd, Solver::implicit}[std::size_t(i % 3)];
        const bool is_door = i < 3;
        StockWorld stock;
        const btVector3 half = is_door ? btVector3(0.5f, 1, 0.05f) : btVector3(0.3f, 0.3f, 0.3f);
        btRigidBody& box = stock.add_box(half, is_door ? 20 : 100, btVector3(0, 3, 0));
        const btVector3 pivot = is_door ? btVector3(-0.5f, 0, 0) : btVector3(0, 0.3f, 0);
        const btVector3 spin = is_door ? btVector3(0, 3, 0) : btVector3(0, 0, 2);
        box.setAngularVelocity(spin);
        box.setLinearVelocity(spin.cross(-pivot));
        box.setActivationState(DISABLE_DEACTIVATION);
        btHingeConstraint hinge(box, pivot, is_door ? btVector3(0, 1, 0) : btVector3(0, 0, 1));
        stock.world->addConstraint(&hinge);
        pliant::Bridge bridge(*stock.world);
        pli_patch_def patch = pli_patch_def_default();
        patch.corner_00 = pli_vec3_make(0.5f, 4, 0);
        patch.corner_10 = pli_vec3_make(0.5f, 2.2f, 0);
        patch.corner_01 = pli_vec3_make(1, 4, 0);
        patch.corner_11 = pli_vec3_make(1, 2.2f, 0);
        patch.columns = 10;
        patch.rows = 5;
        const pli_vec3 top = pli_vec3_make(0.3f, 2.7f, 0), end = pli_vec3_make(0.3f, 0.7f, 0);
        pli_mesh* mesh = nullptr;
        pli_body* soft = nullptr;
        assert_int_equal(is_door ? pli_mesh_create_patch(bridge.context(), &patch, &mesh)
                                 : pli_mesh_create_rope(bridge.context(), top, end, 14, 0, &mesh),
                         PLI_OK);
        assert_int_equal(pli_mesh_set_total_mass(mesh, is_door ? 0.2f : 0.1f), PLI_OK);
        assert_int_equal(bridge.add_body(mesh, nullptr, &soft), PLI_OK);
        pli_mesh_destroy(mesh);
        use_solver(soft, solver);
        const std::array edge{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
        assert_int_equal(pli_body_attach_nodes(soft, edge.data(), is_door ? 10 : 1, bridge.rigid(box)), PLI_OK);
        double fastest = 0, widest = 0;
        for (int k = 0; k < 1200; ++k) {
            stock.step(1);
            if (k >= 600) { fastest = std::max(fastest, double(box.getAngularVelocity().length())); }
            const btVector3 held = box.getWorldTransform() * pivot;
            widest = std::max(widest, double((held - btVector3(pivot.x(), 3 + pivot.y(), 0)).length()));
        }
        print_message("%s, solver %d: at most %.3f rad/s from %.0f, %.2g m off\n", is_door ? "door" : "bell",
                      int(solver), fastest, double(spin.length()), widest);
        check_at_most(fastest, double(spin.length()));
        check_at_most(widest, 0.004);
        stock.world->removeConstraint(&hinge);
    }
}

/// A tyre of 6 kg, held by its inner ring to a rim of 8 kg that turns on an axle of Bullet. It neither wobbles nor gets
/// faster nor off its axle in 5 s.
void test_a_wheel_turns_on_its_axle(void**) {
    constexpr int around = 32, across = 12;
    std::vector<pli_vec3> points;
    std::vector<int> triangles, inner;
    for (int i = 0; i < around; ++i) {
        for (int j = 0; j < across; ++j) {
            const float turn = 6.2831853f * float(i) / around, roll = 6.2831853f * float(j) / across;
            const float radius = 0.3f + 0.1f * std::cos(roll);
            points.push_back({radius * std::cos(turn), radius * std::sin(turn), 0.1f * std::sin(roll)});
            const int next = (i + 1) % around * across, up = (j + 1) % across;
            for (const int node : {i * across + j, next + j, next + up, i * across + j, next + up, i * across + up}) {
                triangles.push_back(node);
            }
            if (std::cos(roll) < -0.6f) { inner.push_back(i * across + j); }
        }
    }
    for (const int rate : {60, 240}) {
        for (const bool keeps_volume : {false, true}) {
            StockWorld stock;
            btRigidBody& rim =
                stock.add_body(new btCylinderShapeZ(btVector3(0.25f, 0.25f, 0.06f)), 8, btVector3(0, 0, 0));
            rim.setActivationState(DISABLE_DEACTIVATION);
            rim.setAngularVelocity(btVector3(0, 0, 10));
            btHingeConstraint axle(rim, btVector3(0, 0, 0), btVector3(0, 0, 1));
            stock.world->addConstraint(&axle);
            pliant::Bridge bridge(*stock.world);
            pli_mesh* mesh = nullptr;
            pli_body* tyre = nullptr;
            assert_int_equal(pli_mesh_create_from_triangles(bridge.context(), int(points.size()), points.data(),
                                                            int(triangles.size() / 3), triangles.data(), true, &mesh),
                             PLI_OK);
            assert_int_equal(pli_mesh_set_total_mass(mesh, 6), PLI_OK);
            assert_int_equal(pli_mesh_append_bending_links(mesh, 2, 0, nullptr), PLI_OK);
            assert_int_equal(bridge.add_body(mesh, nullptr, &tyre), PLI_OK);
            pli_mesh_destroy(mesh);
            use_solver(tyre, Solver::xpbd);
            if (keeps_volume) { assert_int_equal(pli_body_enable_xpbd_volume(tyre, nullptr), PLI_OK); }
            assert_int_equal(pli_body_attach_nodes(tyre, inner.data(), int(inner.size()), bridge.rigid(rim)), PLI_OK);
            std::vector<pli_vec3> velocities;
            for (const pli_vec3& point : points) {
                velocities.push_back({-10 * point.y, 10 * point.x, 0});
            }
            assert_int_equal(pli_body_set_state(tyre, points.data(), velocities.data()), PLI_OK);
            double fastest = 0, wobble = 0, widest = 0;
            for (int k = 0; k < 5 * rate; ++k) {
                stock.step(1, btScalar(1) / btScalar(rate));
                const btVector3 spin = rim.getAngularVelocity();
                fastest = std::max(fastest, double(spin.z()));
                wobble = std::max(wobble, double(std::hypot(spin.x(), spin.y())));
                widest = std::max(widest, double(rim.getWorldTransform().getOrigin().length()));
            }
            print_message("%d Hz, volume %d: at most %.3f rad/s from 10, wobble %.2g rad/s, %.2g m off\n", rate,
                          keeps_volume, fastest, wobble, widest);
            check_at_most(fastest, 10);
            check_at_most(wobble, 0.05);
            check_at_most(widest, 0.002);
            stock.world->removeConstraint(&axle);
        }
    }
}

/// Three crates of 10 kg under each other on ropes of 0.1 kg and 0.6 m with tethers, the lowest thrown aside at 3 m/s:
/// none gets farther down than the ropes are long, nor gets energy.
void test_crates_hang_from_crates(void**) {
    for (const Solver solver : {Solver::position_based, Solver::xpbd}) {
        StockWorld stock;
        pliant::Bridge bridge(*stock.world);
        btRigidBody* above = nullptr;
        for (int i = 0; i < 3; ++i) {
            const float top = 5 - float(i);
            pli_mesh* mesh = nullptr;
            pli_body* rope = nullptr;
            const pli_vec3 from = pli_vec3_make(0, top, 0), to = pli_vec3_make(0, top - 0.6f, 0);
            assert_int_equal(
                pli_mesh_create_rope(bridge.context(), from, to, 8, i == 0 ? PLI_ROPE_PIN_FIRST : 0, &mesh), PLI_OK);
            assert_int_equal(pli_mesh_set_total_mass(mesh, 0.1f), PLI_OK);
            assert_int_equal(bridge.add_body(mesh, nullptr, &rope), PLI_OK);
            pli_mesh_destroy(mesh);
            use_solver(rope, solver);
            assert_int_equal(pli_body_enable_tethers(rope, nullptr), PLI_OK);
            btRigidBody& crate = stock.add_box(btVector3(0.2f, 0.2f, 0.2f), 10, btVector3(0, top - 0.8f, 0));
            crate.setActivationState(DISABLE_DEACTIVATION);
            const std::array ends{0, last_node};
            assert_int_equal(pli_body_attach_nodes(rope, &ends[1], 1, bridge.rigid(crate)), PLI_OK);
            if (above != nullptr) {
                assert_int_equal(pli_body_attach_nodes(rope, ends.data(), 1, bridge.rigid(*above)), PLI_OK);
            }
            above = &crate;
        }
        above->setLinearVelocity(btVector3(3, 0, 0));
        double lowest = 9, most = 0;
        for (int i = 0; i < 600; ++i) {
            stock.step(1);
            double energy = 0;
            for (const auto& crate : stock.bodies) {
                const btVector3 v = crate->getLinearVelocity(), w = crate->getAngularVelocity();
                energy += double(5 * v.length2() + btScalar(0.133) * w.length2() +
                                 100 * crate->getWorldTransform().getOrigin().y());
            }
            most = std::max(most, energy);
            lowest = std::min(lowest, double(above->getWorldTransform().getOrigin().y()));
        }
        print_message("solver %d: lowest %.3f m of 2.2, at most %.1f J of 1005\n", int(solver), lowest, most);
        check_at_most(-lowest, -2.15);
        check_at_most(most, 1005);
    }
}

/// Motors of Bullet turn two leaves of 5 kg apart, which a rope of 0.1 kg ties at their tips.
void test_leaves_that_a_rope_ties_stand_still(void**) {
    for (const Solver solver : {Solver::xpbd, Solver::implicit}) {
        StockWorld stock;
        pliant::Bridge bridge(*stock.world);
        pli_mesh* mesh = nullptr;
        pli_body* rope = nullptr;
        assert_int_equal(
            pli_mesh_create_rope(bridge.context(), pli_vec3_make(-0.1f, 1, 0), pli_vec3_make(0.1f, 1, 0), 6, 0, &mesh),
            PLI_OK);
        assert_int_equal(pli_mesh_set_total_mass(mesh, 0.1f), PLI_OK);
        assert_int_equal(bridge.add_body(mesh, nullptr, &rope), PLI_OK);
        pli_mesh_destroy(mesh);
        use_solver(rope, solver);
        std::vector<btHingeConstraint> hinges;
        hinges.reserve(2);
        for (const float side : {-1.0f, 1.0f}) {
            btRigidBody& leaf = stock.add_box(btVector3(0.4f, 0.8f, 0.03f), 5, btVector3(0.5f * side, 1, 0));
            leaf.setActivationState(DISABLE_DEACTIVATION);
            hinges.emplace_back(leaf, btVector3(0.4f * side, 0, 0), btVector3(0, 1, 0));
            hinges.back().enableAngularMotor(true, -side, 0.05f);
            stock.world->addConstraint(&hinges.back());
            const int end = side < 0 ? 0 : 7;
            assert_int_equal(pli_body_attach_nodes(rope, &end, 1, bridge.rigid(leaf)), PLI_OK);
        }
        stock.step(600);
        double least = 9, most = -9;
        for (int k = 0; k < 300; ++k) {
            stock.step(1);
            least = std::min(least, double(hinges[0].getHingeAngle()));
            most = std::max(most, double(hinges[0].getHingeAngle()));
        }
        print_message("solver %d: leaves turned by %.4f to %.4f rad\n", int(solver), least, most);
        assert_true(least > 0.15 && most < 0.35);
        check_at_most(most - least, 0.002);
        stock.world->removeConstraint(&hinges[0]);
        stock.world->removeConstraint(&hinges[1]);
    }
}

/// Both ropes of a bridge of 6 m, 2 kg each, in one body, with tethers; 20 planks of 5 kg, each held at two nodes of
/// each.
struct PlankBridge {
    static constexpr int side = 61; // nodes
    StockWorld stock;
    pliant::Bridge bridge{*stock.world};
    pli_body* ropes = nullptr;
    std::vector<btRigidBody*> planks;
    std::vector<btVector3> pivots; // of nodes that are held, in planks, four each
    std::vector<int> held;

    explicit PlankBridge(Solver solver) {
        pli_mesh* mesh = nullptr;
        assert_int_equal(pli_mesh_create(bridge.context(), &mesh), PLI_OK);
        for (int i = 0; i < 2 * side; ++i) {
            const int k = i % side;
            const pli_vec3 place = pli_vec3_make(0.1f * float(k) - 3, 2, i < side ? -0.5f : 0.5f);
            const bool is_end = k == 0 || k == side - 1;
            assert_int_equal(pli_mesh_append_node(mesh, place, is_end ? 0 : 2.0f / side, nullptr), PLI_OK);
            if (k > 0) { assert_int_equal(pli_mesh_append_link(mesh, i - 1, i, 0, nullptr), PLI_OK); }
        }
        pli_body_def def = pli_body_def_default();
        def.collision_margin = 0.05f;
        def.solver.position_iterations = 10;
        assert_int_equal(bridge.add_body(mesh, &def, &ropes), PLI_OK);
        pli_mesh_destroy(mesh);
        use_solver(ropes, solver);
        for (int i = 1; i + 2 < side; i += 3) {
            planks.push_back(&stock.add_box(btVector3(0.1f, 0.03f, 0.5f), 5, btVector3(0.1f * float(i + 1) - 3, 2, 0)));
            for (const int node : {i, i + 2, side + i, side + i + 2}) {
                pli_anchor_def anchor = pli_anchor_def_default();
                anchor.node = node;
                anchor.rigid = bridge.rigid(*planks.back());
                anchor.disable_collision = true;
                assert_int_equal(pli_body_add_anchor(ropes, &anchor, nullptr), PLI_OK);
                held.push_back(node);
                const pli_vec4 place = pli_body_get_view(ropes).positions[node];
                pivots.push_back(planks.back()->getWorldTransform().inverse() * btVector3(place.x, place.y, place.z));
            }
        }
        assert_int_equal(pli_body_enable_tethers(ropes, nullptr), PLI_OK);
        stock.add_box(btVector3(2, 0.5f, 1), 0, btVector3(-5.1f, 1.55f, 0));
    }
    /// m, of nodes from their points of the planks, at most.
    double gap() const {
        double most = 0;
        for (std::size_t i = 0; i < held.size(); ++i) {
            const pli_vec4 node = pli_body_get_view(ropes).positions[held[i]];
            const btVector3 point = planks[i / 4]->getWorldTransform() * pivots[i];
            most = std::max(most, double((btVector3(node.x, node.y, node.z) - point).length()));
        }
        return most;
    }
};

/// At 1.5 m/s, from the left to the middle; with 4 sub-steps, as docs/manual/ropes.md advises.
void test_a_bridge_of_planks_bears_a_person(void**) {
    for (const Solver solver : {Solver::position_based, Solver::xpbd, Solver::implicit}) {
        PlankBridge bridge(solver);
        btRigidBody& person = bridge.stock.add_body(new btCapsuleShape(0.3f, 1.2f), 80, btVector3(-4, 2.95f, 0));
        person.setAngularFactor(0);
        person.setActivationState(DISABLE_DEACTIVATION);
        for (int i = 0; i < 8 * 240; ++i) {
            const btVector3 v = person.getLinearVelocity(), at = person.getWorldTransform().getOrigin();
            const btScalar wanted = std::min(btScalar(1.5), -2 * at.x());
            person.applyCentralForce(btVector3(800 * (wanted - v.x()), 0, -800 * v.z() - 800 * at.z()));
            bridge.stock.step(1, btScalar(1) / btScalar(240));
        }
        const btVector3 at = person.getWorldTransform().getOrigin();
        double under = 1e9; // the plank that is nearest along the bridge
        double height = 0;
        for (const btRigidBody* plank : bridge.planks) {
            const btVector3 place = plank->getWorldTransform().getOrigin();
            if (std::abs(double(place.x() - at.x())) > under) { continue; }
            under = std::abs(double(place.x() - at.x()));
            height = double(place.y());
        }
        print_message("solver %d: person at x = %.2f m, %.3f m above a plank, nodes %.2g m off\n", int(solver),
                      double(at.x()), double(at.y()) - height, bridge.gap());
        check_near(at.x(), 0, 0.2);
        check_near(double(at.y()) - height, 0.93, 0.06);
        check_at_most(bridge.gap(), 0.01);
    }
}

/// A seat on four ropes of 2 m and 0.25 kg in one body, with tethers, and a child of 30 kg who stands on it.
struct Swing {
    static constexpr int links = 10;
    StockWorld stock;
    pliant::Bridge bridge{*stock.world};
    btRigidBody *seat = nullptr, *child = nullptr;
    pli_body* ropes = nullptr;

    /// Mass of the seat in kg, height in m from which the child comes.
    Swing(Solver solver, float mass, float height = 0) {
        stock.world->getDispatchInfo().m_deterministicOverlappingPairs = true;
        seat = &stock.add_box(btVector3(0.3f, 0.03f, 0.15f), mass, btVector3(0, 1, 0));
        child = &stock.add_body(new btCapsuleShape(0.15f, 0.6f), 30, btVector3(0, 1.48f + height, 0));
        child->setAngularFactor(0);
        pli_mesh* mesh = nullptr;
        assert_int_equal(pli_mesh_create(bridge.context(), &mesh), PLI_OK);
        for (int i = 0; i < 4 * (links + 1); ++i) {
            const int rope = i / (links + 1), k = i % (links + 1);
            const float share = float(k) / links, x = rope % 2 == 0 ? -0.3f : 0.3f, z = rope < 2 ? -0.12f : 0.12f;
            const pli_vec3 place = pli_vec3_make(x, 3 - 2 * share, z * share);
            assert_int_equal(pli_mesh_append_node(mesh, place, k == 0 ? 0 : 0.25f / links, nullptr), PLI_OK);
            if (k > 0) { assert_int_equal(pli_mesh_append_link(mesh, i - 1, i, 0, nullptr), PLI_OK); }
        }
        pli_body_def def = pli_body_def_default();
        def.solver.position_iterations = 10;
        assert_int_equal(bridge.add_body(mesh, &def, &ropes), PLI_OK);
        pli_mesh_destroy(mesh);
        use_solver(ropes, solver);
        for (int rope = 0; rope < 4; ++rope) {
            const int node = rope * (links + 1) + links;
            assert_int_equal(pli_body_attach_nodes(ropes, &node, 1, bridge.rigid(*seat)), PLI_OK);
        }
        assert_int_equal(pli_body_enable_tethers(ropes, nullptr), PLI_OK);
        for (btRigidBody* body : {seat, child}) {
            body->setActivationState(DISABLE_DEACTIVATION);
            assert_int_equal(pli_body_ignore_rigid(ropes, bridge.rigid(*body), true), PLI_OK);
        }
    }
    /// m, of the child from the seat.
    double gap() const {
        return double((seat->getWorldTransform().inverse() * child->getWorldTransform().getOrigin()).y()) - 0.48;
    }
};

/// Bullet's contacts know that ropes hold the seat: the child sinks in by what is gone after a step, and stays.
void test_a_child_stands_on_a_swing(void**) {
    struct Trial {
        Solver solver;
        float mass, height;
        int sub_steps;
    };
    for (const auto& [solver, mass, height, sub_steps] :
         {Trial{Solver::xpbd, 8, 0, 1}, Trial{Solver::implicit, 8, 0, 1}, Trial{Solver::xpbd, 3, 0, 4},
          Trial{Solver::implicit, 3, 0, 4}, Trial{Solver::xpbd, 3, 0.5f, 4}, Trial{Solver::implicit, 3, 0.5f, 4},
          Trial{Solver::xpbd, 6, 0.5f, 1}, Trial{Solver::position_based, 3, 0.5f, 1}}) {
        Swing swing(solver, mass, height);
        double deepest = 0, highest = 0, fastest = 0;
        for (int k = 0; k < 600 * sub_steps; ++k) {
            swing.stock.step(1, btScalar(1) / btScalar(60 * sub_steps));
            if (k < 60 * sub_steps) { continue; } // landing
            deepest = std::min(deepest, swing.gap());
            highest = std::max(highest, swing.gap());
            if (k >= 480 * sub_steps) {
                fastest = std::max(fastest, double(swing.child->getLinearVelocity().length()));
            }
        }
        print_message("solver %d, seat of %.0f kg, %d sub-steps, from %.1f m: %.3f to %.3f m off, child %.3f m/s\n",
                      int(solver), double(mass), sub_steps, double(height), deepest, highest, fastest);
        check_at_most(-deepest, 0.01);
        check_at_most(highest, 0.005);
        check_at_most(fastest, 0.02);
    }
}

/// Steps after a snapshot, and after a file, know what the ropes held in the one before.
void test_a_swing_goes_on_from_a_snapshot(void**) {
    Swing swing(Solver::xpbd, 8);
    swing.stock.step(30);
    pliant::BridgeSnapshot snapshot;
    std::vector<unsigned char> file;
    assert_int_equal(snapshot.save(swing.bridge), PLI_OK);
    assert_int_equal(pliant::BridgeSnapshot::write_file(swing.bridge, file), PLI_OK);
    std::array<btTransform, 4> ends;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        if (i == 1) { assert_int_equal(snapshot.restore(swing.bridge), PLI_OK); }
        if (i == 2) { swing.stock.step(30); }
        if (i >= 2) {
            assert_int_equal(pliant::BridgeSnapshot::read_file(swing.bridge, file.data(), file.size()), PLI_OK);
        }
        swing.stock.step(30);
        ends[i] = swing.seat->getWorldTransform();
        assert_true(ends[i] == ends[0]);
    }
}

/// Joints that leave everything free have Bullet's solver see what holds the planks, and take no part in it.
void test_a_hold_alone_changes_nothing(void**) {
    for (const Solver solver : {Solver::xpbd, Solver::implicit}) {
        PlankBridge alone(solver), joined(solver);
        std::vector<std::unique_ptr<btGeneric6DofConstraint>> joints;
        for (btRigidBody* plank : joined.planks) {
            const btTransform middle = btTransform::getIdentity();
            joints.push_back(std::make_unique<btGeneric6DofConstraint>(*plank, middle, true));
            for (int axis = 0; axis < 6; ++axis) {
                joints.back()->setLimit(axis, 1, -1);
            }
            joined.stock.world->addConstraint(joints.back().get());
        }
        alone.stock.step(60);
        joined.stock.step(60);
        double off = 0;
        for (std::size_t i = 0; i < alone.planks.size(); ++i) {
            const btVector3 a = alone.planks[i]->getWorldTransform().getOrigin(),
                            b = joined.planks[i]->getWorldTransform().getOrigin();
            check_near((a - b).length(), 0, 0.02); // NaN too
            off = std::max(off, double((a - b).length()));
        }
        print_message("solver %d: planks %.2g m off\n", int(solver), off);
        for (const auto& joint : joints) {
            joined.stock.world->removeConstraint(joint.get());
        }
    }
}

/// 50 kg on a point-to-point joint under a box of 5 kg at the end of a rope, as they swing.
void test_a_joint_bears_what_a_rope_holds(void**) {
    for (const Solver solver : {Solver::xpbd, Solver::implicit}) {
        StockWorld stock;
        btRigidBody &box = stock.add_box(btVector3(0.1f, 0.1f, 0.1f), 5, btVector3(0, 2, 0)),
                    &weight = stock.add_box(btVector3(0.2f, 0.2f, 0.2f), 50, btVector3(0, 1.5f, 0));
        btPoint2PointConstraint joint(box, weight, btVector3(0, -0.1f, 0), btVector3(0, 0.4f, 0));
        stock.world->addConstraint(&joint, true);
        weight.setLinearVelocity(btVector3(1, 0, 0));
        pliant::Bridge bridge(*stock.world);
        pli_mesh* mesh = nullptr;
        pli_body* rope = nullptr;
        const pli_vec3 from = pli_vec3_make(0, 4, 0), to = pli_vec3_make(0, 2.1f, 0);
        assert_int_equal(pli_mesh_create_rope(bridge.context(), from, to, 9, PLI_ROPE_PIN_FIRST, &mesh), PLI_OK);
        assert_int_equal(pli_mesh_set_total_mass(mesh, 0.5f), PLI_OK);
        assert_int_equal(bridge.add_body(mesh, nullptr, &rope), PLI_OK);
        pli_mesh_destroy(mesh);
        use_solver(rope, solver);
        const int end = 10;
        assert_int_equal(pli_body_attach_nodes(rope, &end, 1, bridge.rigid(box)), PLI_OK);
        assert_int_equal(pli_body_enable_tethers(rope, nullptr), PLI_OK);
        const auto energy = [&weight] {
            return double(25 * weight.getLinearVelocity().length2() + 500 * weight.getWorldTransform().getOrigin().y());
        };
        const double start = energy();
        double most = start, widest = 0;
        for (int i = 0; i < 1200; ++i) {
            box.activate();
            stock.step(1);
            most = std::max(most, energy());
            const btVector3 off =
                box.getWorldTransform() * btVector3(0, -0.1f, 0) - weight.getWorldTransform() * btVector3(0, 0.4f, 0);
            if (i >= 60) { widest = std::max(widest, double(off.length())); }
        }
        print_message("solver %d: joint %.4f m off, energy at most %.2f J above the start\n", int(solver), widest,
                      most - start);
        check_at_most(widest, 0.02);
        check_at_most(most, start + 1);
        assert_int_equal(stock.world->getNumConstraints(), 1);
        stock.world->removeConstraint(&joint);
    }
}

/// Runs before the bridge's part of a step, while Bullet's list still has what the ropes hold.
struct EarlyAction : btActionInterface {
    std::function<void()> run;
    void updateAction(btCollisionWorld*, btScalar) override {
        if (run) { run(); }
    }
    void debugDraw(btIDebugDraw*) override {}
};

/// Whatever becomes of the ropes and the bridge, between steps the Bullet world has the game's constraints alone.
void test_no_hold_is_left_in_the_world(void**) {
    for (int i = 0; i < 5; ++i) {
        StockWorld stock;
        EarlyAction action;
        stock.world->addAction(&action);
        btRigidBody &box = stock.add_box(btVector3(0.1f, 0.1f, 0.1f), 5, btVector3(0, 2, 0)),
                    &weight = stock.add_box(btVector3(0.2f, 0.2f, 0.2f), 50, btVector3(0, 1.5f, 0));
        btPoint2PointConstraint joint(box, weight, btVector3(0, -0.1f, 0), btVector3(0, 0.4f, 0));
        stock.world->addConstraint(&joint, true);
        auto bridge = std::make_unique<pliant::Bridge>(*stock.world);
        pli_body* rope = nullptr;
        for (int k = 0; k < 2; ++k) {
            pli_mesh* mesh = nullptr;
            const float z = float(k);
            assert_int_equal(pli_mesh_create_rope(bridge->context(), pli_vec3_make(0, 4, z), pli_vec3_make(0, 2.1f, z),
                                                  9, PLI_ROPE_PIN_FIRST, &mesh),
                             PLI_OK);
            pli_body* made = nullptr;
            assert_int_equal(bridge->add_body(mesh, nullptr, &made), PLI_OK);
            rope = k == 0 ? made : rope;
            pli_mesh_destroy(mesh);
        }
        use_solver(rope, Solver::xpbd);
        const int end = 10;
        assert_int_equal(pli_body_attach_nodes(rope, &end, 1, bridge->rigid(box)), PLI_OK);
        int most = 0;
        action.run = [&] { most = std::max(most, stock.world->getNumConstraints()); };
        stock.step(30);
        assert_int_equal(most, 2);
        if (i == 0) { stock.step(1, 5e-7f); } // too short for the core
        if (i == 1) {                         // nobody asks for the bounds of soft bodies
            for (int k = 0; k < 2; ++k) {
                stock.world->removeCollisionObject(bridge->object(pli_world_get_body(bridge->world(), k)));
            }
        }
        if (i == 2) {
            action.run = [&] { bridge.reset(); };
        }
        if (i == 3) {
            action.run = [&] { bridge->detach(); };
        }
        btTransform stopped;
        if (i == 4) { // what was lent to it is not taken from it any more
            action.run = [&] {
                box.setCollisionFlags(box.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
                box.setLinearVelocity(btVector3(0, 0, 0));
                box.setAngularVelocity(btVector3(0, 0, 0));
                stopped = box.getWorldTransform();
                action.run = nullptr;
            };
            stock.step(1);
            print_message("a box that becomes kinematic in a step: %.2g m/s, %.2g m off\n",
                          double(box.getLinearVelocity().length()),
                          double((box.getWorldTransform().getOrigin() - stopped.getOrigin()).length()));
            assert_true(box.getLinearVelocity().isZero());
            assert_true(box.getWorldTransform() == stopped);
        }
        for (int k = 0; k < 30; ++k) {
            stock.step(1);
            assert_int_equal(stock.world->getNumConstraints(), 1);
            assert_ptr_equal(stock.world->getConstraint(0), &joint);
        }
        stock.world->removeConstraint(&joint);
    }
}

/// A rope of 3 m and 3 kg between two cars of 1000 kg on little friction, the first pulled by 8 kN until it goes at 5
/// m/s: the solvers that docs/manual/ropes.md advises stretch it by 3 to 5 %.
void test_a_tow_rope_pulls_a_car(void**) {
    for (const bool is_implicit : {true, false}) {
        StockWorld stock;
        const btVector3 half(1.5f, 0.4f, 0.8f);
        stock.add_box(btVector3(50, 1, 50), 0, btVector3(0, -1, 0)).setFriction(1);
        btRigidBody *second = &stock.add_box(half, 1000, btVector3(0, 0.4f, 0)),
                    *first = &stock.add_box(half, 1000, btVector3(6, 0.4f, 0));
        first->setFriction(0.1f);
        second->setFriction(0.1f);
        pliant::Bridge bridge(*stock.world);
        const int ends[2] = {0, 15};
        const pli_vec3 from = pli_vec3_make(1.5f, 0.4f, 0), to = pli_vec3_make(4.5f, 0.4f, 0);
        pli_mesh* mesh = nullptr;
        pli_body* rope = nullptr;
        assert_int_equal(pli_mesh_create_rope(bridge.context(), from, to, 15, 0, &mesh), PLI_OK);
        assert_int_equal(pli_mesh_set_total_mass(mesh, 3), PLI_OK);
        assert_int_equal(bridge.add_body(mesh, nullptr, &rope), PLI_OK);
        pli_mesh_destroy(mesh);
        pli_implicit_def springs = pli_implicit_def_default();
        springs.stiffness = 1e6f;
        springs.finishing_iterations = 100;
        pli_xpbd_def xpbd = pli_xpbd_def_default();
        xpbd.substeps = 40;
        assert_int_equal(is_implicit ? pli_body_enable_implicit(rope, &springs) : pli_body_enable_xpbd(rope, &xpbd),
                         PLI_OK);
        if (!is_implicit) { assert_int_equal(pli_body_enable_xpbd_links(rope, nullptr), PLI_OK); }
        assert_int_equal(pli_body_attach_nodes(rope, &ends[0], 1, bridge.rigid(*second)), PLI_OK);
        assert_int_equal(pli_body_attach_nodes(rope, &ends[1], 1, bridge.rigid(*first)), PLI_OK);
        double longest = 0;
        for (int i = 0; i < 480; ++i) {
            first->activate(true);
            if (i >= 60) {
                const btScalar force = 20000 * (5 - first->getLinearVelocity().x());
                first->applyCentralForce(btVector3(std::min(force, btScalar(8000)), 0, 0));
            }
            stock.step(1);
            const btVector3 apart = first->getWorldTransform() * btVector3(-1.5f, 0, 0) -
                                    second->getWorldTransform() * btVector3(1.5f, 0, 0);
            longest = std::max(longest, double(apart.length()));
        }
        print_message("%s: at most %.3f m long, second car %.3f m/s\n", is_implicit ? "implicit" : "XPBD", longest,
                      double(second->getLinearVelocity().x()));
        check_at_most(longest, 3.16);
        check_near(second->getLinearVelocity().x(), 4.9, 0.2);
    }
}

btRigidBody& add_kinematic_box(StockWorld& stock, float half_width) {
    btRigidBody& box = stock.add_box(btVector3(half_width, 0.1f, 0.1f), 0, btVector3(0, 3, 0));
    box.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    box.setActivationState(DISABLE_DEACTIVATION);
    return box;
}

/// A kinematic box, which Bullet moves before the bridge looks at it.
void test_a_node_is_where_a_fast_box_is(void**) {
    StockWorld stock;
    btRigidBody& box = add_kinematic_box(stock, 0.1f);
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = bridge_test::add_sheet(bridge, 1, 3, 5);
    const int node = 12;
    assert_int_equal(pli_body_attach_nodes(sheet, &node, 1, bridge.rigid(box)), PLI_OK);
    for (int i = 1; i <= 60; ++i) {
        btTransform pose = box.getWorldTransform();
        pose.getOrigin().setX(btScalar(i) * btScalar(0.1)); // 6 m/s
        box.getMotionState()->setWorldTransform(pose);
        stock.step(1);
        check_near(pli_body_get_view(sheet).positions[node].x, box.getWorldTransform().getOrigin().x(), 1e-5);
    }
}

/// A dynamic box in flight, which Bullet moves before the bridge solves, takes a rope along.
void test_a_node_is_where_a_box_in_flight_is(void**) {
    for (const Solver solver : {Solver::position_based, Solver::xpbd, Solver::implicit}) {
        StockWorld stock(btVector3(0, 0, 0));
        btRigidBody& box = stock.add_box(btVector3(0.5f, 0.5f, 0.5f), 100, btVector3(0, 0, 0));
        pliant::Bridge bridge(*stock.world);
        pli_mesh* mesh = nullptr;
        pli_body* rope = nullptr;
        assert_int_equal(
            pli_mesh_create_rope(bridge.context(), pli_vec3_make(0, 0.5f, 0), pli_vec3_make(0, 2.5f, 0), 9, 0, &mesh),
            PLI_OK);
        assert_int_equal(bridge.add_body(mesh, nullptr, &rope), PLI_OK);
        pli_mesh_destroy(mesh);
        use_solver(rope, solver);
        const int node = 0;
        assert_int_equal(pli_body_attach_nodes(rope, &node, 1, bridge.rigid(box)), PLI_OK);
        box.setLinearVelocity(btVector3(13, 0, 0));
        assert_int_equal(pli_body_add_velocity(rope, pli_vec3_make(13, 0, 0)), PLI_OK);
        for (int i = 0; i < 60; ++i) {
            stock.step(1);
            check_near(pli_body_get_view(rope).positions[node].x, box.getWorldTransform().getOrigin().x(), 1e-4);
        }
    }
}

/// A box that carries a sheet and is put elsewhere, and the sheet with it: neither moves.
void test_a_sheet_goes_along_where_its_box_appears_elsewhere(void**) {
    const btTransform far(btQuaternion(btVector3(0, 1, 0), btScalar(1.5)), btVector3(50, 3, 0)),
        near(btQuaternion::getIdentity(), btVector3(btScalar(0.5), 3, 0));
    for (int i = 0; i < 6; ++i) {
        const Solver solver = std::array{Solver::position_based, Solver::implicit, Solver::xpbd}[std::size_t(i / 2)];
        const btTransform& there = i % 2 == 0 ? far : near;
        StockWorld stock;
        btRigidBody& box = add_kinematic_box(stock, 0.6f);
        pliant::Bridge bridge(*stock.world);
        pli_body* sheet = bridge_test::add_sheet(bridge, 1, 3, 5);
        use_solver(sheet, solver);
        const int nodes[] = {0, 1, 2, 3, 4};
        assert_int_equal(pli_body_attach_nodes(sheet, nodes, 5, bridge.rigid(box)), PLI_OK);
        stock.step(60);
        const double energy = double(pli_body_kinetic_energy(sheet)), stretch = double(pli_body_max_stretch(sheet));
        pli_transform moved = pli_transform_identity();
        const btTransform way = there * box.getWorldTransform().inverse();
        for (int k = 0; k < 3; ++k) {
            const btVector3 row = way.getBasis().getRow(k);
            moved.rotation.rows[k] = pli_vec3_make(float(row.x()), float(row.y()), float(row.z()));
        }
        moved.origin =
            pli_vec3_make(float(way.getOrigin().x()), float(way.getOrigin().y()), float(way.getOrigin().z()));
        box.getMotionState()->setWorldTransform(there);
        box.setWorldTransform(there);
        box.setInterpolationWorldTransform(there);
        assert_int_equal(pli_body_transform(sheet, moved), PLI_OK);
        stock.step(3);
        print_message("solver %d: %.3g J and stretch %.3g before, %.3g J and %.3g after\n", int(solver), energy,
                      stretch, double(pli_body_kinetic_energy(sheet)), double(pli_body_max_stretch(sheet)));
        check_at_most(double(pli_body_kinetic_energy(sheet)), energy + 0.3);
        check_at_most(double(pli_body_max_stretch(sheet)), stretch + 0.01);
    }
}

/// A rope on a box that rests, or walks as a kinematic one does.
struct Hung {
    StockWorld stock;
    pliant::Bridge bridge{*stock.world};
    btRigidBody* box = nullptr;
    pli_body* rope = nullptr;

    Hung(Solver solver, bool walks) {
        box = &stock.add_box(btVector3(0.1f, 0.1f, 0.1f), 0, btVector3(0, 3, 0));
        if (walks) { box->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT); }
        box->setActivationState(DISABLE_DEACTIVATION);
        pli_mesh* mesh = nullptr;
        const pli_vec3 from = pli_vec3_make(0, 3, 0), to = pli_vec3_make(1, 3, 0);
        assert_int_equal(pli_mesh_create_rope(bridge.context(), from, to, 8, 0, &mesh), PLI_OK);
        assert_int_equal(bridge.add_body(mesh, nullptr, &rope), PLI_OK);
        pli_mesh_destroy(mesh);
        use_solver(rope, solver);
        const int node = 0;
        assert_int_equal(pli_body_attach_nodes(rope, &node, 1, bridge.rigid(*box)), PLI_OK);
    }
    void step() {
        btTransform pose;
        box->getMotionState()->getWorldTransform(pose);
        if (box->isKinematicObject()) { pose.getOrigin() += btVector3(0.03f, 0, 0); } // 1.8 m/s
        box->getMotionState()->setWorldTransform(pose);
        stock.step(1);
    }
    void shift(const btVector3& way) {
        btTransform pose = box->getWorldTransform();
        pose.getOrigin() += way;
        box->setWorldTransform(pose);
        box->setInterpolationWorldTransform(pose);
        box->getMotionState()->setWorldTransform(pose);
        bridge.object(rope)->setWorldTransform(btTransform(btQuaternion::getIdentity(), way));
    }
};

/// Games do so far from the origin: everything is 1 km elsewhere from one step to the next.
void test_a_world_may_shift_its_origin(void**) {
    const btVector3 way(1024, 0, -1024);
    for (int i = 0; i < 6; ++i) {
        const Solver solver = std::array{Solver::position_based, Solver::implicit, Solver::xpbd}[std::size_t(i / 2)];
        Hung stays(solver, i % 2 == 1), goes(solver, i % 2 == 1);
        double off = 0;
        for (int k = 0; k < 30; ++k) {
            if (k == 29) { goes.shift(way); }
            stays.step();
            goes.step();
        }
        for (int node = 0; node <= last_node; ++node) {
            const pli_vec4 a = pli_body_get_view(stays.rope).positions[node],
                           b = pli_body_get_view(goes.rope).positions[node];
            off = std::max(off, double((btVector3(b.x - a.x, b.y - a.y, b.z - a.z) - way).length()));
        }
        print_message("solver %d, %s: off by %.2g m after it\n", int(solver), i % 2 == 1 ? "walks" : "rests", off);
        check_at_most(off, 1e-3); // places are rounded to 0.1 mm there
    }
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_a_pendulum_gains_no_energy),
        cmocka_unit_test(test_what_turns_on_a_hinge_gains_no_speed),
        cmocka_unit_test(test_a_wheel_turns_on_its_axle),
        cmocka_unit_test(test_crates_hang_from_crates),
        cmocka_unit_test(test_leaves_that_a_rope_ties_stand_still),
        cmocka_unit_test(test_a_bridge_of_planks_bears_a_person),
        cmocka_unit_test(test_a_child_stands_on_a_swing),
        cmocka_unit_test(test_a_swing_goes_on_from_a_snapshot),
        cmocka_unit_test(test_a_hold_alone_changes_nothing),
        cmocka_unit_test(test_a_joint_bears_what_a_rope_holds),
        cmocka_unit_test(test_no_hold_is_left_in_the_world),
        cmocka_unit_test(test_a_tow_rope_pulls_a_car),
        cmocka_unit_test(test_a_node_is_where_a_fast_box_is),
        cmocka_unit_test(test_a_node_is_where_a_box_in_flight_is),
        cmocka_unit_test(test_a_sheet_goes_along_where_its_box_appears_elsewhere),
        cmocka_unit_test(test_a_world_may_shift_its_origin),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
