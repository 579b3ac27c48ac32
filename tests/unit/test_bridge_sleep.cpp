// Sleep in a Bullet world: soft bodies and rigid bodies fall asleep together and wake together.

#include "check.h"
#include "test_bridge_slot.h"
#include "test_bridge_world.h"

#include <array>
#include <cmath>

namespace {

using bridge_test::StockWorld;

struct Pile {
    static constexpr int softs = 10;

    StockWorld stock;
    pliant::Bridge bridge{*stock.world};
    std::vector<pli_body*> sheets;
    std::vector<btRigidBody*> boxes;

    /// Five stacks, each a sheet on a box, and a box and a sheet on that.
    Pile() {
        stock.add_box(btVector3(20, 1, 20), 0, btVector3(0, -1, 0));
        for (int i = 0; i < softs / 2; ++i) {
            const auto x = static_cast<float>(3 * i);
            for (int layer = 0; layer < 2; ++layer) {
                const float y = 0.3f + 0.8f * static_cast<float>(layer);
                boxes.push_back(&stock.add_box(btVector3(0.5, 0.25, 0.5), 2, btVector3(x, y, 0)));
                pli_body* sheet = bridge_test::add_sheet(bridge, 1.2f, y + 0.4f, 7, 0, x, 0, 0.03f);
                assert_non_null(sheet);
                pli_solver_settings settings = pli_body_get_solver_settings(sheet);
                settings.velocity_damping = 0.03f;
                assert_int_equal(pli_body_set_solver_settings(sheet, &settings), PLI_OK);
                assert_int_equal(pli_body_enable_colored_links(sheet), PLI_OK);
                assert_int_equal(pli_body_enable_sleep(sheet, nullptr), PLI_OK);
                sheets.push_back(sheet);
            }
        }
    }

    int asleep() const {
        int count = 0;
        for (const pli_body* sheet : sheets) {
            count += pli_body_is_asleep(sheet);
        }
        for (const btRigidBody* box : boxes) {
            count += !box->isActive();
        }
        return count;
    }
    int all() const { return static_cast<int>(sheets.size() + boxes.size()); }
    double fastest() const {
        double most = 0;
        for (const pli_body* sheet : sheets) {
            const pli_body_view view = pli_body_get_view(sheet);
            for (int i = 0; i < view.node_count; ++i) {
                const pli_vec4 v = view.velocities[i];
                most = std::fmax(most, std::sqrt(double(v.x * v.x + v.y * v.y + v.z * v.z)));
            }
        }
        return most;
    }
    /// Frames until all sleep. A stack that a ball has hit may topple first.
    int fall_asleep() {
        int frame = 0;
        while (asleep() < all() && frame < 1200) {
            stock.step(1);
            ++frame;
        }
        assert_int_equal(asleep(), all());
        return frame;
    }
};

void test_a_pile_falls_asleep(void**) {
    Pile pile;
    int at_rest = 0, frame = 0;
    for (; pile.asleep() < pile.all() && frame < 600; ++frame) {
        pile.stock.step(1);
        if (pile.fastest() > 0.1) { at_rest = frame; }
    }
    print_message("slow from frame %d on, all %d asleep in frame %d\n", at_rest, pile.all(), frame);
    assert_int_equal(pile.asleep(), pile.all());
    check_at_most(frame - at_rest, 180); // three seconds
    std::vector<std::uint64_t> hashes;
    for (const pli_body* sheet : pile.sheets) {
        hashes.push_back(pli_body_state_hash(sheet));
    }
    const btTransform pose = pile.boxes[1]->getWorldTransform();
    pile.stock.step(120);
    for (std::size_t i = 0; i < hashes.size(); ++i) {
        assert_true(pli_body_state_hash(pile.sheets[i]) == hashes[i]);
    }
    assert_true(pile.boxes[1]->getWorldTransform() == pose);
    assert_int_equal(pile.bridge.status(), PLI_OK);
}

void test_a_ball_wakes_what_it_hits_and_what_leans_on_it(void**) {
    Pile pile;
    pile.fall_asleep();
    btRigidBody& ball = pile.stock.add_body(new btSphereShape(0.2f), 1, btVector3(0, 3, 0));
    ball.setLinearVelocity(btVector3(0, -8, 0));
    const std::uint64_t before = pli_body_state_hash(pile.sheets[1]);
    int woken = 0;
    float gap = 0;
    for (int frame = 1; frame <= 60 && woken == 0; ++frame) {
        gap = float(ball.getWorldTransform().getOrigin().y()) - 0.2f - bridge_test::highest(pile.sheets[1]);
        pile.stock.step(1);
        if (pli_body_state_hash(pile.sheets[1]) != before) { woken = frame; }
    }
    print_message("moves in frame %d, the ball was %.3f m above it\n", woken, double(gap));
    assert_true(woken > 0);
    assert_true(gap > 0); // it wakes before the ball is in it
    pile.stock.step(2);
    assert_false(pli_body_is_asleep(pile.sheets[0]) || pli_body_is_asleep(pile.sheets[1]));
    assert_true(pile.boxes[0]->isActive() && pile.boxes[1]->isActive());
    for (std::size_t i = 2; i < pile.sheets.size(); ++i) {
        assert_true(pli_body_is_asleep(pile.sheets[i])); // the other stacks
    }
    pile.stock.step(30);
    assert_true(ball.getWorldTransform().getOrigin().y() > btScalar(1.2));
    pile.fall_asleep();
}

void test_calls_wake_and_so_does_the_game(void**) {
    Pile pile;
    pile.fall_asleep();
    assert_int_equal(pli_body_add_velocity(pile.sheets[0], pli_vec3_make(0, 1, 0)), PLI_OK);
    pile.stock.step(2);
    assert_false(pli_body_is_asleep(pile.sheets[0]) || pli_body_is_asleep(pile.sheets[1]));
    assert_true(pile.boxes[0]->isActive() && pile.boxes[1]->isActive());
    assert_true(pli_body_is_asleep(pile.sheets[2]));

    pile.boxes[2]->activate();
    pile.boxes[2]->applyCentralImpulse(btVector3(4, 0, 0));
    pile.stock.step(2);
    assert_false(pli_body_is_asleep(pile.sheets[2]));

    btRigidBody& lift = pile.stock.add_box(btVector3(0.3f, 0.3f, 0.3f), 0, btVector3(8, 0.5f, 0));
    lift.setCollisionFlags(lift.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    lift.setActivationState(DISABLE_DEACTIVATION);
    assert_true(pli_body_is_asleep(pile.sheets[7]));
    for (int i = 0; i < 40; ++i) {
        btTransform pose = lift.getWorldTransform();
        pose.getOrigin().setX(pose.getOrigin().x() + btScalar(0.02));
        lift.getMotionState()->setWorldTransform(pose);
        pile.stock.step(1);
    }
    assert_false(pli_body_is_asleep(pile.sheets[7]));
    assert_int_equal(pile.bridge.status(), PLI_OK);
}

struct Weight {
    StockWorld stock;
    pliant::Bridge bridge{*stock.world};
    btRigidBody* body = nullptr;
    pli_body* rope = nullptr;

    /// At the end of a rope, some way off where `is_far`.
    Weight(bool is_xpbd, bool is_far, int mask = -1) {
        const float x = is_far ? 1.5f : 1.1f;
        body = &stock.add_body(new btSphereShape(0.1f), 1, btVector3(x, 3, 0));
        body->setDamping(0.9f, 0.9f);
        pli_mesh* mesh = nullptr;
        assert_int_equal(pli_mesh_create_rope(bridge.context(), pli_vec3_make(0, 3, 0), pli_vec3_make(1, 3, 0), 8,
                                              PLI_ROPE_PIN_FIRST, &mesh),
                         PLI_OK);
        assert_int_equal(pli_mesh_set_total_mass(mesh, 0.1f), PLI_OK);
        pli_body_def def = pli_body_def_default();
        def.solver.velocity_damping = 0.05f;
        def.collision_margin = 0.02f;
        assert_int_equal(bridge.add_body(mesh, &def, &rope, 1, mask), PLI_OK);
        pli_mesh_destroy(mesh);
        if (is_xpbd) {
            assert_int_equal(pli_body_enable_xpbd(rope, nullptr), PLI_OK);
            assert_int_equal(pli_body_enable_xpbd_links(rope, nullptr), PLI_OK);
        } else {
            assert_int_equal(pli_body_enable_tethers(rope, nullptr), PLI_OK);
        }
        const int last = 9;
        assert_int_equal(pli_body_attach_nodes(rope, &last, 1, bridge.rigid(*body)), PLI_OK);
        assert_int_equal(pli_body_enable_sleep(rope, nullptr), PLI_OK);
        pli_rigid* held[2] = {};
        assert_int_equal(pli_body_get_held_rigids(rope, 2, held), 1);
        assert_ptr_equal(held[0], bridge.rigid(*body));
    }
    bool is_asleep() const { return pli_body_is_asleep(rope) && !body->isActive(); }
};

// A weight falls asleep with the rope that holds it, as it hangs, and a push wakes both.
void test_a_weight_sleeps_on_its_rope(void**) {
    for (int c = 0; c < 4; ++c) {
        Weight weight((c & 1) != 0, (c & 2) != 0);
        int frame = 0;
        for (; frame < 900 && !weight.is_asleep(); ++frame) {
            weight.stock.step(1);
        }
        print_message("case %d: asleep in frame %d\n", c, frame);
        check_at_most(frame, 899);
        weight.stock.step(1);
        const std::uint64_t hash = pli_body_state_hash(weight.rope);
        const btTransform pose = weight.body->getWorldTransform();
        for (int i = 0; i < 120; ++i) {
            weight.stock.step(1);
            assert_true(weight.is_asleep() && pli_body_state_hash(weight.rope) == hash);
            assert_true(weight.body->getWorldTransform() == pose);
        }
        weight.body->activate();
        weight.body->applyCentralImpulse(btVector3(0, 0, 2));
        weight.stock.step(5);
        assert_true(!pli_body_is_asleep(weight.rope) && weight.body->isActive());
        assert_true(weight.body->getWorldTransform().getOrigin().z() > btScalar(0.05));
        assert_int_equal(weight.bridge.status(), PLI_OK);
    }
}

// Bodies that do not meet are in no island of Bullet's together: the rope stays awake, as the weight does, and both
// hang still.
void test_a_weight_that_does_not_meet_its_rope_keeps_it_awake(void**) {
    Weight weight(false, true, 0);
    weight.stock.step(600);
    for (int i = 0; i < 300; ++i) {
        const btVector3 before = weight.body->getWorldTransform().getOrigin();
        weight.stock.step(1);
        assert_false(pli_body_is_asleep(weight.rope));
        check_at_most((weight.body->getWorldTransform().getOrigin() - before).length() * 60, 0.01); // m/s
    }
}

// A lift that begins to move takes the sheet along that has fallen asleep on it: down, and sideways, by friction. Also
// one with the flag of static objects, which Bullet gives to all of mass 0.
void test_what_sleeps_on_a_lift_goes_along(void**) {
    for (int variant = 0; variant < 8; ++variant) {
        const bool goes_down = (variant & 2) == 0, has_sub_steps = (variant & 1) != 0;
        StockWorld stock;
        pliant::Bridge bridge(*stock.world);
        btRigidBody& lift = stock.add_box(btVector3(3, 1, 3), 0, btVector3(0, -1, 0));
        const int kept = variant < 4 ? 0 : lift.getCollisionFlags();
        lift.setCollisionFlags(kept | btCollisionObject::CF_KINEMATIC_OBJECT);
        lift.setActivationState(DISABLE_DEACTIVATION);
        pli_body* sheet = bridge_test::add_sheet(bridge, 1, 0.1f, 7);
        assert_int_equal(pli_body_enable_sleep(sheet, nullptr), PLI_OK);
        for (int i = 0; i < 600 && !pli_body_is_asleep(sheet); ++i) {
            stock.step(1);
        }
        assert_true(pli_body_is_asleep(sheet));
        const btScalar dt = btScalar(1) / 60, frame = has_sub_steps ? 2 * dt : dt;
        const btVector3 velocity = goes_down ? btVector3(0, btScalar(-0.6), 0) : btVector3(btScalar(0.6), 0, 0);
        for (btScalar time = 0; time < btScalar(0.99); time += frame) {
            btTransform pose = lift.getWorldTransform();
            pose.setOrigin(pose.getOrigin() + velocity * frame);
            lift.getMotionState()->setWorldTransform(pose);
            stock.world->stepSimulation(frame, has_sub_steps ? 2 : 0, dt);
        }
        const btVector3 way = lift.getWorldTransform().getOrigin() - btVector3(0, -1, 0);
        const pli_vec3 center = bridge_test::center(sheet);
        check_near(center.y, way.y() + btScalar(0.1), 0.02);
        check_near(center.x, way.x(), goes_down ? 0.02 : 0.2);
    }
}

// A sheet that sleeps on a table falls, or goes through, when that is put elsewhere, shrinks, or becomes a sensor.
void test_what_sleeps_on_a_table_that_goes_away_wakes(void**) {
    enum class Change { none, moved, sensor, smaller, removed };
    for (int variant = 0; variant < 10; ++variant) {
        const bool is_kinematic = variant >= 5;
        const auto change = static_cast<Change>(variant % 5);
        StockWorld stock;
        pliant::Bridge bridge(*stock.world);
        stock.add_box(btVector3(20, 1, 20), 0, btVector3(0, -5, 0));
        btRigidBody& table = stock.add_box(btVector3(3, 1, 3), 0, btVector3(0, -1, 0));
        if (is_kinematic) { table.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT); }
        pli_body* sheet = bridge_test::add_sheet(bridge, 1, 0.1f, 7);
        assert_int_equal(pli_body_enable_sleep(sheet, nullptr), PLI_OK);
        for (int i = 0; i < 600 && !pli_body_is_asleep(sheet); ++i) {
            stock.step(1);
        }
        assert_true(pli_body_is_asleep(sheet));
        stock.step(30);
        assert_true(pli_body_is_asleep(sheet));
        const btTransform away(btQuaternion::getIdentity(), btVector3(0, -3, 0));
        if (change == Change::moved) {
            table.setWorldTransform(away);
            table.setInterpolationWorldTransform(away);
            table.getMotionState()->setWorldTransform(away);
        }
        if (change == Change::sensor) {
            table.setCollisionFlags(table.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
        }
        if (change == Change::smaller) { table.getCollisionShape()->setLocalScaling(btVector3(1, btScalar(0.5), 1)); }
        if (change == Change::removed) { stock.world->removeRigidBody(&table); }
        stock.step(60);
        const double fallen = 0.1 - static_cast<double>(bridge_test::center(sheet).y);
        constexpr std::array<double, 5> ways = {0, 2, 4, 0.5, 4};
        check_near(fallen, ways[static_cast<std::size_t>(change)], 2e-3);
        if (change == Change::none) { assert_true(pli_body_is_asleep(sheet)); }
    }
}

// What the game has disabled while it slept does not move when a call changes it.
void test_a_disabled_sleeper_stays_where_it_is(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    pli_body* sheet = bridge_test::add_sheet(bridge, 1, 0.1f, 5);
    assert_int_equal(pli_body_enable_sleep(sheet, nullptr), PLI_OK);
    for (int i = 0; i < 600 && !pli_body_is_asleep(sheet); ++i) {
        stock.step(1);
    }
    assert_true(pli_body_is_asleep(sheet));
    bridge.object(sheet)->forceActivationState(DISABLE_SIMULATION);
    stock.step(2);
    const float height = bridge_test::highest(sheet);
    assert_int_equal(pli_body_add_velocity(sheet, pli_vec3_make(0, 5, 0)), PLI_OK);
    stock.step(3);
    check_near(bridge_test::highest(sheet), height, 0);
    bridge.object(sheet)->forceActivationState(ACTIVE_TAG);
    stock.step(3);
    assert_true(bridge_test::highest(sheet) > height + 0.1f);
}

struct NoContacts : btCollisionWorld::ContactResultCallback {
    btScalar addSingleResult(btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) override {
        return 0;
    }
};

// A sheet that rests, and may be asked for its bounds when the game has deleted what it holds.
void test_what_a_resting_body_holds_may_be_deleted(void**) {
    for (int asked_by = 0; asked_by < 3; ++asked_by) {
        StockWorld stock;
        pliant::Bridge bridge(*stock.world);
        stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
        pli_body* sheet = bridge_test::add_sheet(bridge, 1, 0.1f, 5, 0, 3, 3);
        assert_int_equal(pli_body_enable_sleep(sheet, nullptr), PLI_OK);
        btBoxShape shape(btVector3(0.1f, 0.1f, 0.1f));
        bridge_test::Slot slot;
        btRigidBody& box = slot.make<btRigidBody>(btScalar(1), nullptr, &shape, btVector3(0.01f, 0.01f, 0.01f));
        box.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(3.6f, 0.1f, 3.6f)));
        stock.world->addRigidBody(&box);
        pli_anchor_def anchor = pli_anchor_def_default();
        anchor.node = 24;
        anchor.rigid = bridge.rigid(box);
        assert_int_equal(pli_body_add_anchor(sheet, &anchor, nullptr), PLI_OK);
        for (int i = 0; i < 600 && !pli_body_is_resting(sheet); ++i) {
            stock.step(1);
        }
        assert_true(pli_body_is_resting(sheet));
        btVector3 low, high;
        const btCollisionObject& object = *bridge.object(sheet);
        object.getCollisionShape()->getAabb(object.getWorldTransform(), low, high);
        assert_true(high.x() >= box.getWorldTransform().getOrigin().x());
        stock.world->removeRigidBody(&box);
        slot.clear();
        NoContacts contacts;
        if (asked_by == 0) { stock.world->contactTest(bridge.object(sheet), contacts); }
        if (asked_by == 1) { stock.world->updateAabbs(); }
        object.getCollisionShape()->getAabb(object.getWorldTransform(), low, high);
        check_near(low.x(), pli_body_get_bounds(sheet).min.x, 1e-6);
        check_near(high.x(), pli_body_get_bounds(sheet).max.x, 1e-6);
        stock.step(3);
        assert_true(slot.is_untouched());
        assert_int_equal(pli_body_anchor_count(sheet), 0);
    }
}

// The user data of a rigid body that the game makes in the core's world is the game's.
void test_a_resting_body_may_hold_a_rigid_body_of_the_core(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    pli_body* sheet = bridge_test::add_sheet(bridge, 1, 0.1f, 5);
    assert_int_equal(pli_body_enable_sleep(sheet, nullptr), PLI_OK);
    std::vector<float> tag(64, 1e5f);
    pli_rigid_def def = pli_rigid_def_default();
    def.kind = PLI_RIGID_DYNAMIC;
    def.state.inverse_mass = 1;
    def.user_data = tag.data();
    pli_anchor_def anchor = pli_anchor_def_default();
    assert_int_equal(pli_rigid_create(bridge.world(), &def, &anchor.rigid), PLI_OK);
    assert_int_equal(pli_body_add_anchor(sheet, &anchor, nullptr), PLI_OK);
    for (int i = 0; i < 600 && !pli_body_is_resting(sheet); ++i) {
        stock.step(1);
    }
    assert_true(pli_body_is_resting(sheet));
    stock.step(1);
    btVector3 low, high;
    const btCollisionObject& object = *bridge.object(sheet);
    object.getCollisionShape()->getAabb(object.getWorldTransform(), low, high);
    check_near(high.x(), pli_body_get_bounds(sheet).max.x, 1e-6);
    check_near(high.y(), pli_body_get_bounds(sheet).max.y, 1e-6);
}

// Without sleep enabled Bullet's bodies stay awake under a soft body, and a soft body that the game deactivates
// freezes.
void test_nothing_sleeps_that_was_not_asked_to(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    stock.add_box(btVector3(20, 1, 20), 0, btVector3(0, -1, 0));
    const btRigidBody& box = stock.add_box(btVector3(0.5, 0.25, 0.5), 2, btVector3(0, 0.3f, 0));
    pli_body* sheet = bridge_test::add_sheet(bridge, 1.2f, 0.7f, 7, 0, 0, 0, 0.03f);
    stock.step(300);
    assert_false(pli_body_is_asleep(sheet));
    assert_true(box.isActive());
    bridge.object(sheet)->forceActivationState(DISABLE_SIMULATION);
    stock.step(1);
    assert_true(pli_body_is_frozen(sheet));
    bridge.object(sheet)->forceActivationState(ACTIVE_TAG);
    stock.step(1);
    assert_false(pli_body_is_frozen(sheet));
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_a_pile_falls_asleep),
        cmocka_unit_test(test_a_ball_wakes_what_it_hits_and_what_leans_on_it),
        cmocka_unit_test(test_calls_wake_and_so_does_the_game),
        cmocka_unit_test(test_a_weight_sleeps_on_its_rope),
        cmocka_unit_test(test_a_weight_that_does_not_meet_its_rope_keeps_it_awake),
        cmocka_unit_test(test_what_sleeps_on_a_lift_goes_along),
        cmocka_unit_test(test_what_sleeps_on_a_table_that_goes_away_wakes),
        cmocka_unit_test(test_a_disabled_sleeper_stays_where_it_is),
        cmocka_unit_test(test_what_a_resting_body_holds_may_be_deleted),
        cmocka_unit_test(test_a_resting_body_may_hold_a_rigid_body_of_the_core),
        cmocka_unit_test(test_nothing_sleeps_that_was_not_asked_to),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
