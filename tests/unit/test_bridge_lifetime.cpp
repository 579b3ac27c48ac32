// What the bridge does when objects, and the Bullet world, go without a word.
#include "check.h"
#include "test_bridge_slot.h"
#include "test_bridge_world.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>

#include <functional>
#include <optional>

using namespace bridge_test;

namespace {

constexpr btScalar dt = btScalar(1) / btScalar(60);

void call_once(std::function<void()>& function) {
    if (function) { std::exchange(function, nullptr)(); }
}

/// Calls a function in a step, before the bridges that are made after it.
class Action final : public btActionInterface {
public:
    explicit Action(StockWorld& stock) : stock_(stock) { stock.world->addAction(this); }
    ~Action() override { stock_.world->removeAction(this); }
    void updateAction(btCollisionWorld*, btScalar) override { call_once(call); }
    void debugDraw(btIDebugDraw*) override {}

    std::function<void()> call;

private:
    StockWorld& stock_;
};

/// A sheet of 16 nodes that hangs on a box by one of them.
class Hanging {
public:
    explicit Hanging(btScalar mass = 1) : info(mass, nullptr, &shape, btVector3(1, 1, 1)) {}
    ~Hanging() {
        if (!slot.is_empty() && object->getWorldArrayIndex() >= 0) { remove(); }
    }

    btRigidBody& make() { return slot.make<btRigidBody>(info); }
    btRigidBody& box() { return *static_cast<btRigidBody*>(object); }
    void add_box() {
        object = &make();
        stock.world->addRigidBody(&box());
    }
    void add_sheet() { sheet = bridge_test::add_sheet(bridge, 1, 5, 4); }
    void anchor() {
        pli_anchor_def def = pli_anchor_def_default();
        def.rigid = bridge.rigid(box());
        assert_non_null(def.rigid);
        assert_int_equal(pli_body_add_anchor(sheet, &def, nullptr), PLI_OK);
    }
    void remove() { stock.world->removeCollisionObject(object); }
    void remove_and_delete() {
        remove();
        slot.clear();
    }
    /// In the world, and stepped.
    void begin() {
        add_box();
        add_sheet();
        anchor();
        stock.step(2);
        assert_int_equal(lost(), 0);
    }
    /// Events of the last step that tell of anchors lost.
    int lost() const {
        int count = 0, found = 0;
        const pli_event* events = pli_world_get_events(bridge.world(), &count);
        for (int i = 0; i < count; ++i) {
            assert_int_equal(events[i].kind, PLI_EVENT_ANCHORS_LOST);
            found += events[i].body == sheet ? 1 : 0;
        }
        return found;
    }
    void check_lost_in_last_step() {
        assert_int_equal(bridge.step_status(), PLI_OK);
        assert_int_equal(pli_body_anchor_count(sheet), 0);
        assert_int_equal(lost(), 1);
        assert_true(slot.is_untouched());
        stock.step(3);
        assert_int_equal(lost(), 0);
        assert_true(slot.is_untouched());
        assert_false(pli_body_is_frozen(sheet));
    }

    btBoxShape shape{btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2))};
    btRigidBody::btRigidBodyConstructionInfo info;
    Slot slot;
    btCollisionObject* object = nullptr;
    StockWorld stock;
    Action action{stock};
    pliant::Bridge bridge{*stock.world};
    pli_body* sheet = nullptr;
};

float falling_speed(const pli_body* body) {
    return -pli_body_momentum(body).y / pli_body_total_mass(body);
}

} // namespace

// -------------------------------------------------------------------------------------- objects that are not there

static void test_anchors_to_a_body_that_is_not_in_the_world_hold_nothing(void**) {
    Hanging h;
    h.object = &h.make();
    h.add_sheet();
    h.anchor();
    h.stock.step(10);
    check_near(falling_speed(h.sheet), 10.0 / 6, 1e-3);
    assert_int_equal(pli_body_anchor_count(h.sheet), 1);
    // From its first step in the world on they hold.
    h.stock.world->addRigidBody(&h.box());
    h.stock.step(1);
    assert_true(pli_rigid_was_touched(h.bridge.rigid(h.box())));
    assert_int_equal(h.lost(), 0);
    assert_int_equal(pli_body_anchor_count(h.sheet), 1);
}

static void test_a_body_deleted_before_its_first_step_is_not_touched(void**) {
    for (const bool is_added : {false, true}) {
        Hanging h;
        h.object = &h.make();
        h.add_sheet();
        if (is_added) { h.stock.world->addRigidBody(&h.box()); }
        h.anchor();
        if (is_added) { h.remove(); }
        h.slot.clear();
        h.stock.step(1);
        assert_true(h.slot.is_untouched());
        assert_int_equal(bool(h.lost()), is_added); // of what was never there nothing is known
        h.stock.step(9);
        check_near(falling_speed(h.sheet), 10.0 / 6, 1e-3);
    }
}

static void test_an_object_in_the_place_of_a_body_that_was_never_in_the_world_is_not_taken_for_it(void**) {
    for (int kind = 0; kind < 3; ++kind) {
        Hanging h;
        h.object = &h.make();
        h.add_sheet();
        h.anchor();
        if (kind == 0) { h.object = &h.make(); }
        if (kind == 1) { h.object = &h.slot.make<btGhostObject>(); }
        if (kind == 2) { h.object = &h.slot.make<btCollisionObject>(); }
        h.object->setCollisionShape(&h.shape);
        if (kind == 0) { h.box().setGravity(btVector3(0, 0, 0)); }
        h.stock.world->addCollisionObject(h.object);
        h.stock.step(1);
        h.check_lost_in_last_step();
        if (kind == 0) { check_near(h.box().getLinearVelocity().length(), 0, 0); }
    }
}

// With an object of another kind, or of the same, at the address.
static void test_anchors_of_a_body_deleted_between_steps_go_in_the_next_step(void**) {
    for (int kind = 0; kind < 4; ++kind) {
        for (const bool is_taken_up : {false, true}) {
            Hanging h;
            h.begin();
            h.remove_and_delete();
            if (kind == 1) { h.object = &h.make(); }
            if (kind == 2) { h.object = &h.slot.make<btGhostObject>(); }
            if (kind == 3) { h.object = &h.slot.make<btCollisionObject>(); }
            if (kind > 0) {
                h.object->setCollisionShape(&h.shape);
                h.stock.world->addCollisionObject(h.object);
            }
            // The new body gets anchors of its own; those of the old one are not among them.
            const bool has_new_anchor = is_taken_up && kind == 1;
            if (has_new_anchor) {
                h.anchor();
                assert_int_equal(pli_body_anchor_count(h.sheet), 2);
            }
            h.stock.step(1);
            if (has_new_anchor) {
                assert_int_equal(h.lost(), 1);
                assert_int_equal(pli_body_anchor_count(h.sheet), 1);
                assert_true(h.box().getLinearVelocity().length() > 0);
                h.stock.step(5);
                assert_int_equal(h.lost(), 0);
                assert_int_equal(pli_body_anchor_count(h.sheet), 1);
                continue;
            }
            h.check_lost_in_last_step();
            if (kind == 1) { check_near(h.box().getLinearVelocity().length(), 0, 0); }
        }
    }
}

static void test_a_body_that_is_put_back_between_steps_keeps_its_anchors(void**) {
    Hanging h;
    h.begin();
    for (int i = 0; i < 5; ++i) {
        h.remove();
        h.stock.world->addRigidBody(&h.box());
        h.stock.step(1);
        assert_int_equal(h.lost(), 0);
        assert_int_equal(pli_body_anchor_count(h.sheet), 1);
        assert_true(pli_rigid_was_touched(h.bridge.rigid(h.box())));
    }
    // Away for a step they are lost, and new ones may be made.
    h.remove();
    h.stock.step(1);
    h.check_lost_in_last_step();
    h.stock.world->addRigidBody(&h.box());
    h.anchor();
    h.stock.step(1);
    assert_int_equal(pli_body_anchor_count(h.sheet), 1);
    assert_true(pli_rigid_was_touched(h.bridge.rigid(h.box())));
}

// ---------------------------------------------------------------------------------------------------- inside of steps

static void test_a_body_deleted_in_an_action_takes_its_anchors_in_that_step(void**) {
    for (int kind = 0; kind < 4; ++kind) {
        Hanging h;
        h.begin();
        h.action.call = [&] {
            h.remove_and_delete();
            if (kind == 1) { h.object = &h.make(); }
            if (kind == 2) { h.object = &h.slot.make<btGhostObject>(); }
            if (kind > 0 && kind < 3) {
                h.object->setCollisionShape(&h.shape);
                h.stock.world->addCollisionObject(h.object);
            }
            // A search for pairs of the game's own in the middle of the step.
            if (kind == 3) { h.stock.world->performDiscreteCollisionDetection(); }
        };
        const float before = falling_speed(h.sheet);
        h.stock.step(1);
        check_near(falling_speed(h.sheet), static_cast<double>(before) + 1.0 / 6, 1e-3);
        h.check_lost_in_last_step();
        if (kind == 1) { check_near(h.box().getLinearVelocity().length(), 0, 0); }
    }
}

static void test_a_body_removed_and_put_back_in_an_action_keeps_its_anchors(void**) {
    Hanging h;
    h.begin();
    h.action.call = [&] {
        h.remove();
        h.stock.world->addRigidBody(&h.box());
    };
    h.stock.step(1);
    assert_int_equal(h.lost(), 0);
    assert_int_equal(pli_body_anchor_count(h.sheet), 1);
    assert_true(pli_rigid_was_touched(h.bridge.rigid(h.box())));
}

static void test_forget_inside_a_step_holds_at_once(void**) {
    for (const bool is_deleted : {false, true}) {
        for (const bool in_hook : {false, true}) {
            Hanging h;
            h.begin();
            const auto forget = [&] {
                h.bridge.forget(h.box());
                h.box().setLinearVelocity(btVector3(0, 3, 0));
                h.box().setAngularVelocity(btVector3(0, 0, 0));
                if (is_deleted) { h.remove_and_delete(); }
            };
            if (in_hook) {
                h.bridge.set_before_solve([&, forget] {
                    forget();
                    h.bridge.set_before_solve(nullptr);
                });
            } else {
                h.action.call = forget;
            }
            const float before = falling_speed(h.sheet);
            h.stock.step(1);
            check_near(falling_speed(h.sheet), static_cast<double>(before) + 1.0 / 6, 1e-3);
            if (!is_deleted) {
                check_near(h.box().getLinearVelocity().y(), 3, 0);
                check_near(h.box().getAngularVelocity().length(), 0, 0);
            }
            h.check_lost_in_last_step();
        }
    }
}

// Contacts are not anchors: what is forgotten and stays in the world is met again.
static void test_a_forgotten_floor_carries_on(void**) {
    StockWorld stock;
    Action action(stock);
    btRigidBody& floor = stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1, 0.2f, 5);
    for (int i = 0; i < 120; ++i) {
        if (i % 30 == 0) {
            action.call = [&] { bridge.forget(floor); };
        }
        stock.step(1);
    }
    assert_int_equal(bridge.step_status(), PLI_OK);
    check_near(lowest(sheet), 0.1, 0.02);
}

static Hanging* ticking;

static void test_a_body_deleted_in_a_tick_callback_takes_its_anchors(void**) {
    for (const bool is_before : {false, true}) {
        Hanging h;
        h.begin();
        ticking = &h;
        const auto tick = [](btDynamicsWorld*, btScalar) {
            if (ticking != nullptr) { std::exchange(ticking, nullptr)->remove_and_delete(); }
        };
        h.stock.world->setInternalTickCallback(tick, nullptr, is_before);
        h.stock.step(is_before ? 1 : 2);
        h.check_lost_in_last_step();
    }
}

// Faces ask the shape again when their contacts are solved: Bullet's GJK, or a terrain's triangles.
static void test_a_body_and_its_shape_may_be_deleted_by_callbacks_of_the_bridge(void**) {
    for (int variant = 0; variant < 8; ++variant) {
        const bool in_profile = (variant & 1) != 0, is_anchored = (variant & 2) != 0, is_cone = (variant & 4) != 0;
        StockWorld stock(btVector3(0, 0, 0));
        pliant::BridgeDef def;
        def.mode = pliant::CollisionMode::exact;
        pliant::Bridge bridge(*stock.world, def);
        pli_body* sheet = add_sheet(bridge, 2, 0, 6, 0, 0, 0, 0.05f);
        const pli_rigid_face_contacts_def faces = pli_rigid_face_contacts_def_default();
        assert_int_equal(pli_body_enable_rigid_face_contacts(sheet, &faces), PLI_OK);
        std::vector<float> heights(4 * 4, 0.0f);
        std::optional<btConeShape> cone;
        std::optional<btHeightfieldTerrainShape> terrain;
        btCollisionShape* shape = nullptr;
        if (is_cone) {
            shape = &cone.emplace(btScalar(0.6), btScalar(0.5));
        } else {
            shape = &terrain.emplace(4, 4, heights.data(), btScalar(-1), btScalar(1), 1, false);
        }
        Slot slot;
        const btRigidBody::btRigidBodyConstructionInfo info(is_cone ? 1 : 0, nullptr, shape, btVector3(1, 1, 1));
        btRigidBody& rigid = slot.make<btRigidBody>(info);
        rigid.setWorldTransform(
            btTransform(btQuaternion::getIdentity(), btVector3(0, is_cone ? btScalar(-0.2) : 0, 0)));
        rigid.setLinearVelocity(btVector3(0, is_cone ? 2 : 0, 0));
        stock.world->addRigidBody(&rigid);
        if (is_anchored) {
            pli_anchor_def anchor = pli_anchor_def_default();
            anchor.rigid = bridge.rigid(rigid);
            assert_int_equal(pli_body_add_anchor(sheet, &anchor, nullptr), PLI_OK);
        }
        std::function<void()> end = [&] {
            stock.world->removeRigidBody(&rigid);
            slot.clear();
            cone.reset();
            terrain.reset();
        };
        stock.step(3);
        assert_true(pli_rigid_was_touched(bridge.rigid(rigid)));
        if (in_profile) {
            const auto profile = [](const char* stage, const char*, bool begins, void* user) {
                if (begins && std::strcmp(stage, "solve") == 0) {
                    call_once(*static_cast<std::function<void()>*>(user));
                }
            };
            assert_int_equal(pli_world_set_profile(bridge.world(), profile, &end), PLI_OK);
        } else {
            bridge.set_before_solve([&] { call_once(end); });
        }
        stock.step(1);
        assert_true(slot.is_empty() && slot.is_untouched());
        assert_int_equal(pli_body_anchor_count(sheet), 0);
        stock.step(3);
        assert_true(slot.is_untouched());
        assert_int_equal(bridge.step_status(), PLI_OK);
        assert_false(pli_body_is_frozen(sheet));
    }
}

// Both tick callbacks are outside of the bridge's step; actions that come before the bridge's are inside of it, those
// after it are not.
static void test_soft_bodies_come_and_go_in_ticks_and_actions(void**) {
    enum { before_tick, after_tick, earlier_action, later_action, moment_count };
    for (int moment = 0; moment < moment_count; ++moment) {
        StockWorld stock(btVector3(0, 0, 0));
        std::optional<Action> early;
        early.emplace(stock);
        pliant::BridgeDef def;
        def.gravity = pli_vec3_make(0, -10, 0);
        pliant::Bridge bridge(*stock.world, def);
        Action late(stock);
        btRigidBody& box = stock.add_box(btVector3(1, 1, 1), 1, btVector3(0, 10, 0));
        pli_body* kept = add_sheet(bridge, 1, 5, 4);
        pli_body* leaves = add_sheet(bridge, 1, 3, 4);
        pli_body* comes = nullptr;
        const bool is_refused = moment == earlier_action;
        std::function<void()> change = [&] {
            assert_int_equal(bridge.remove_body(leaves), is_refused ? PLI_ERROR_WRONG_STATE : PLI_OK);
            comes = add_sheet(bridge, 1, 1, 4);
            assert_int_equal(comes == nullptr, is_refused);
            pli_anchor_def anchor = pli_anchor_def_default();
            anchor.rigid = bridge.rigid(box);
            assert_int_equal(anchor.rigid == nullptr, is_refused);
            if (!is_refused) { assert_int_equal(pli_body_add_anchor(comes, &anchor, nullptr), PLI_OK); }
        };
        stock.step(1);
        if (moment <= after_tick) {
            const auto tick = [](btDynamicsWorld* world, btScalar) {
                call_once(*static_cast<std::function<void()>*>(world->getWorldUserInfo()));
            };
            stock.world->setInternalTickCallback(tick, &change, moment == before_tick);
        } else {
            (moment == earlier_action ? *early : late).call = change;
        }
        stock.step(1);
        assert_int_equal(pli_world_body_count(bridge.world()), 2);
        check_near(falling_speed(kept), 2 * 10.0 / 60, 1e-3);
        if (is_refused) { check_near(falling_speed(leaves), 2 * 10.0 / 60, 1e-3); }
        // What came before the step has made it already.
        if (!is_refused) { assert_int_equal(falling_speed(comes) > 0, moment == before_tick); }
        stock.step(1);
        assert_int_equal(bridge.step_status(), PLI_OK);
        if (!is_refused) { assert_true(pli_rigid_was_touched(bridge.rigid(box))); }
    }
}

// As Bullet's examples do at the end with whatever is in the world. Inside of a step the body ends with that.
static void test_a_game_may_delete_the_object_of_a_body(void**) {
    enum { between, inside, at_the_end, moment_count };
    for (int moment = 0; moment < moment_count; ++moment) {
        StockWorld stock(btVector3(0, 0, 0));
        Action early(stock);
        pliant::BridgeDef def;
        def.gravity = pli_vec3_make(0, -10, 0);
        auto bridge = std::make_unique<pliant::Bridge>(*stock.world, def);
        stock.add_box(btVector3(1, 1, 1), 0, btVector3(0, 0, 0));
        pli_body* leaves = add_sheet(*bridge, 1, 1.1f, 4);
        pli_body* kept = add_sheet(*bridge, 1, 5, 4);
        stock.step(1);
        const std::function<void()> end = [&] {
            btCollisionObject* object = bridge->object(leaves);
            stock.world->removeCollisionObject(object);
            delete object;
            assert_int_equal(pli_world_body_count(bridge->world()), moment == inside ? 2 : 1);
            assert_int_equal(bridge->remove_body(leaves),
                             moment == inside ? PLI_ERROR_WRONG_STATE : PLI_ERROR_INVALID_VALUE);
        };
        if (moment == inside) {
            early.call = end;
        } else {
            end();
        }
        if (moment == at_the_end) {
            btCollisionObject* object = bridge->object(kept);
            stock.world->removeCollisionObject(object);
            delete object;
            assert_int_equal(pli_world_body_count(bridge->world()), 0);
            bridge.reset();
            stock.step(1);
            continue;
        }
        stock.step(1);
        assert_int_equal(bridge->step_status(), PLI_OK);
        assert_int_equal(pli_world_body_count(bridge->world()), 1);
        assert_int_equal(stock.world->getNumCollisionObjects(), 2);
        check_near(falling_speed(kept), 2 * 10.0 / 60, 1e-3);
    }
}

// ---------------------------------------------------------------------------------------------------- the Bullet world

namespace {

/// A Bullet world in a slot, with nothing in it.
class BareWorld {
public:
    btDiscreteDynamicsWorld& make() {
        return slot.make<btDiscreteDynamicsWorld>(&dispatcher, &broadphase, &solver, &configuration);
    }

    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    Slot slot;
};

} // namespace

// In the bridge's hook, in a callback of the core, and in an action that comes before the bridge's.
static void test_a_bridge_may_be_detached_inside_a_step(void**) {
    for (int variant = 0; variant < 3; ++variant) {
        StockWorld stock;
        struct Action : btActionInterface {
            void updateAction(btCollisionWorld*, btScalar) override {
                if (bridge != nullptr) { bridge->detach(); }
            }
            void debugDraw(btIDebugDraw*) override {}
            pliant::Bridge* bridge = nullptr;
        } action;
        stock.world->addAction(&action);
        pliant::Bridge bridge(*stock.world);
        stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
        btRigidBody& box = stock.add_box(btVector3(1, 1, 1), 1, btVector3(0, 1, 0));
        pli_body* sheet = add_sheet(bridge, 1, 2.1f, 5);
        pli_anchor_def anchor = pli_anchor_def_default();
        anchor.rigid = bridge.rigid(box);
        assert_int_equal(pli_body_add_anchor(sheet, &anchor, nullptr), PLI_OK);
        stock.step(3);
        if (variant == 0) {
            bridge.set_before_solve([&] { bridge.detach(); });
        }
        if (variant == 1) {
            const auto profile = [](const char* stage, const char*, bool begins, void* user) {
                if (begins && std::strcmp(stage, "solve") == 0) { static_cast<pliant::Bridge*>(user)->detach(); }
            };
            assert_int_equal(pli_world_set_profile(bridge.world(), profile, &bridge), PLI_OK);
        }
        if (variant == 2) { action.bridge = &bridge; }
        stock.step(1);
        assert_int_equal(stock.world->getNumCollisionObjects(), 2);
        const std::uint64_t hash = pli_body_state_hash(sheet);
        stock.step(3);
        assert_true(pli_body_state_hash(sheet) == hash);
        assert_int_equal(bridge.remove_body(sheet), PLI_OK);
        stock.world->removeAction(&action);
    }
}

// In the bridge's hook, and in callbacks of the core within the solve and the prediction: with the end of its part.
static void test_a_bridge_may_be_destroyed_by_what_it_calls(void**) {
    for (int variant = 0; variant < 3; ++variant) {
        StockWorld stock;
        auto bridge = std::make_unique<pliant::Bridge>(*stock.world);
        stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
        btRigidBody& box = stock.add_box(btVector3(1, 1, 1), 1, btVector3(0, 1, 0));
        pli_body* sheet = add_sheet(*bridge, 1, 2.1f, 5);
        pli_anchor_def anchor = pli_anchor_def_default();
        anchor.rigid = bridge->rigid(box);
        assert_int_equal(pli_body_add_anchor(sheet, &anchor, nullptr), PLI_OK);
        stock.step(3);
        std::function<void()> end = [&] {
            bridge.reset();
            assert_int_equal(stock.world->getNumCollisionObjects(), 3);
            assert_true(pli_body_get_view(sheet).node_count == 25);
        };
        const auto profile = [](const char* stage, const char*, bool begins, void* user) {
            if (begins && std::strcmp(stage, "solve") == 0) { call_once(*static_cast<std::function<void()>*>(user)); }
        };
        const auto profile_any = [](const char*, const char*, bool, void* user) {
            call_once(*static_cast<std::function<void()>*>(user));
        };
        if (variant == 0) {
            bridge->set_before_solve([&] { call_once(end); });
        } else {
            pli_profile_fn* const chosen = variant == 1 ? +profile : +profile_any;
            assert_int_equal(pli_world_set_profile(bridge->world(), chosen, &end), PLI_OK);
        }
        stock.step(1);
        assert_true(bridge == nullptr);
        assert_int_equal(stock.world->getNumCollisionObjects(), 2);
        stock.step(3);
        pliant::Bridge next(*stock.world);
        sheet = add_sheet(next, 1, 2.3f, 5);
        stock.step(30);
        assert_int_equal(next.step_status(), PLI_OK);
        check_near(lowest(sheet), 2.1, 0.02);
    }
}

static void test_a_bullet_world_may_go_before_a_bridge_without_bodies(void**) {
    enum { none, removed_body, body_taken_out, detached, count };
    for (int variant = 0; variant < count; ++variant) {
        BareWorld bare;
        btDiscreteDynamicsWorld& world = bare.make();
        auto bridge = std::make_unique<pliant::Bridge>(world);
        if (variant == removed_body || variant == body_taken_out) {
            pli_body* sheet = add_sheet(*bridge, 1, 0, 3);
            world.stepSimulation(dt, 0);
            if (variant == removed_body) { assert_int_equal(bridge->remove_body(sheet), PLI_OK); }
            if (variant == body_taken_out) { world.removeCollisionObject(bridge->object(sheet)); }
        }
        bare.slot.clear();
        if (variant == detached) { bridge->detach(); }
        bridge.reset();
        assert_true(bare.slot.is_untouched());
        // Another one at the place of the first.
        btDiscreteDynamicsWorld& next = bare.make();
        pliant::Bridge second(next);
        pli_body* sheet = add_sheet(second, 1, 0, 3);
        next.stepSimulation(dt, 0);
        check_near(center(sheet).y, -10.0 / 3600, 1e-7);
    }
}

static void test_a_bridge_without_bodies_may_go_before_its_bullet_world(void**) {
    BareWorld bare;
    btDiscreteDynamicsWorld& world = bare.make();
    for (int i = 0; i < 4; ++i) {
        pliant::Bridge bridge(world);
        if (i % 2 == 0) { continue; }
        pli_body* sheet = add_sheet(bridge, 1, 0, 3);
        world.stepSimulation(dt, 0);
        check_near(center(sheet).y, -10.0 / 3600, 1e-7);
        assert_int_equal(bridge.remove_body(sheet), PLI_OK);
    }
    world.stepSimulation(dt, 0);
    bare.slot.clear();
}

static void test_a_bridge_whose_bullet_world_has_gone_answers_calls(void**) {
    BareWorld bare;
    btDiscreteDynamicsWorld& world = bare.make();
    pliant::Bridge bridge(world);
    pli_body* sheet = add_sheet(bridge, 1, 0, 3);
    btBoxShape shape(btVector3(1, 1, 1));
    btRigidBody box(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, btVector3(1, 1, 1)));
    world.addRigidBody(&box);
    world.stepSimulation(dt, 0);
    bare.slot.clear();

    pli_mesh* mesh = make_sheet(bridge.context(), 1, 0, 3);
    pli_body* other = nullptr;
    assert_int_equal(bridge.add_body(mesh, nullptr, &other), PLI_ERROR_WRONG_STATE);
    pli_mesh_destroy(mesh);
    assert_non_null(bridge.rigid(box));
    bridge.refresh(box);
    bridge.forget(box);
    btVector3 low, high;
    btCollisionShape& soft = *bridge.object(sheet)->getCollisionShape();
    soft.getAabb(btTransform::getIdentity(), low, high);
    assert_true(low.x() < btScalar(-0.5));
    struct Counter final : btTriangleCallback {
        void processTriangle(btVector3*, int, int) override { ++count; }
        int count = 0;
    } counter;
    static_cast<btConcaveShape&>(soft).processAllTriangles(&counter, low, high);
    assert_int_equal(counter.count, 8);
    assert_int_equal(bridge.remove_body(sheet), PLI_OK);
    assert_true(bare.slot.is_untouched());
}

int main() {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_anchors_to_a_body_that_is_not_in_the_world_hold_nothing),
        cmocka_unit_test(test_a_body_deleted_before_its_first_step_is_not_touched),
        cmocka_unit_test(test_an_object_in_the_place_of_a_body_that_was_never_in_the_world_is_not_taken_for_it),
        cmocka_unit_test(test_anchors_of_a_body_deleted_between_steps_go_in_the_next_step),
        cmocka_unit_test(test_a_body_that_is_put_back_between_steps_keeps_its_anchors),
        cmocka_unit_test(test_a_body_deleted_in_an_action_takes_its_anchors_in_that_step),
        cmocka_unit_test(test_a_body_removed_and_put_back_in_an_action_keeps_its_anchors),
        cmocka_unit_test(test_forget_inside_a_step_holds_at_once),
        cmocka_unit_test(test_a_forgotten_floor_carries_on),
        cmocka_unit_test(test_a_body_deleted_in_a_tick_callback_takes_its_anchors),
        cmocka_unit_test(test_a_body_and_its_shape_may_be_deleted_by_callbacks_of_the_bridge),
        cmocka_unit_test(test_soft_bodies_come_and_go_in_ticks_and_actions),
        cmocka_unit_test(test_a_game_may_delete_the_object_of_a_body),
        cmocka_unit_test(test_a_bridge_may_be_detached_inside_a_step),
        cmocka_unit_test(test_a_bridge_may_be_destroyed_by_what_it_calls),
        cmocka_unit_test(test_a_bullet_world_may_go_before_a_bridge_without_bodies),
        cmocka_unit_test(test_a_bridge_without_bodies_may_go_before_its_bullet_world),
        cmocka_unit_test(test_a_bridge_whose_bullet_world_has_gone_answers_calls),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
