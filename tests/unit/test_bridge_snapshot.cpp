// Soft and rigid bodies of a Bullet world go back together.

#include "test_bridge_world.h"

#include "check.h"

#include <pliant/cut.h>
#include <pliant_bullet/snapshot.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

using bridge_test::make_sheet;
using bridge_test::StockWorld;
using pliant::Bridge;
using pliant::BridgeSnapshot;

namespace {

constexpr int box_count = 6;

// A stack of boxes on a sheet that hangs by anchors and lies on the ground.
struct Scene {
    StockWorld stock;
    std::unique_ptr<Bridge> bridge;
    std::vector<btRigidBody*> boxes;
    pli_body* sheet = nullptr;
    pli_anchor_id held{};

    explicit Scene(std::unique_ptr<btBroadphaseInterface> broadphase = std::make_unique<btDbvtBroadphase>())
        : stock(btVector3(0, -10, 0), std::move(broadphase)) {
        stock.world->getDispatchInfo().m_deterministicOverlappingPairs = true;
        stock.add_box(btVector3(10, 1, 10), 0, btVector3(0, -1, 0));
        for (int i = 0; i < box_count; ++i) {
            const auto n = static_cast<btScalar>(i);
            boxes.push_back(&stock.add_box(btVector3(btScalar(0.2), btScalar(0.1), btScalar(0.2)), btScalar(0.5),
                                           btVector3(btScalar(0.03) * n, btScalar(1.2) + btScalar(0.25) * n, 0)));
        }
        bridge = std::make_unique<Bridge>(*stock.world);
        pli_mesh* mesh = make_sheet(bridge->context(), 2, 0.8f, 15);
        pli_body_def def = pli_body_def_default();
        def.collision_margin = 0.03f;
        def.solver.position_iterations = 6;
        assert_int_equal(bridge->add_body(mesh, &def, &sheet), PLI_OK);
        pli_mesh_destroy(mesh);
        assert_int_equal(pli_body_enable_rigid_contacts(sheet, nullptr), PLI_OK);
        assert_int_equal(pli_body_enable_rigid_face_contacts(sheet, nullptr), PLI_OK);
        pli_anchor_def anchor = pli_anchor_def_default();
        anchor.rigid = bridge->rigid(*boxes[1]);
        assert_int_equal(pli_body_add_anchor(sheet, &anchor, &held), PLI_OK);
    }

    struct State {
        std::uint64_t sheet;
        std::array<btTransform, box_count> poses;
        std::array<btVector3, box_count> velocities;
        bool operator==(const State& o) const {
            return sheet == o.sheet && poses == o.poses && velocities == o.velocities;
        }
    };
    State state() const {
        State result{};
        result.sheet = pli_body_state_hash(sheet);
        for (std::size_t i = 0; i < box_count; ++i) {
            result.poses[i] = boxes[i]->getWorldTransform();
            result.velocities[i] = boxes[i]->getLinearVelocity();
        }
        return result;
    }
};

// Each eight frames are stepped again, from the first or from a later one of them.
void go_back_and_forward(Scene& scene) {
    std::array<BridgeSnapshot, 8> snapshots;
    for (int frame = 0; frame < 60; ++frame) {
        std::array<Scene::State, 8> states;
        for (std::size_t k = 0; k < 8; ++k) {
            assert_int_equal(snapshots[k].save(*scene.bridge), PLI_OK);
            scene.stock.step(1);
            states[k] = scene.state();
        }
        const std::size_t from = static_cast<std::size_t>(frame) % 8;
        if (snapshots[from].restore(*scene.bridge) != PLI_OK) {
            fail_msg("round %d from %zu: %s", frame, from, pli_last_error(scene.bridge->context()));
        }
        for (std::size_t k = from; k < 8; ++k) {
            scene.stock.step(1);
            if (!(scene.state() == states[k])) {
                fail_msg("round %d from frame %zu: frame %zu differs", frame, from, k);
            }
        }
        if (frame % 25 == 24) { scene.boxes[2]->applyCentralImpulse(btVector3(btScalar(0.6), btScalar(1.2), 0)); }
    }
}

} // namespace

// Bodies fall asleep, and a push wakes them.
static void eight_frames_back_and_forward_again(void**) {
    const btVector3 corner(100, 100, 100);
    Scene scene(std::make_unique<btAxisSweep3>(-corner, corner));
    go_back_and_forward(scene);
}

// What sleeps together depends on pairs that this broad phase finds by their past.
static void the_same_with_trees_where_nothing_sleeps(void**) {
    Scene scene;
    for (btRigidBody* box : scene.boxes) {
        box->setActivationState(DISABLE_DEACTIVATION);
    }
    go_back_and_forward(scene);
}

static void expect_error(const pliant::Bridge& bridge, const char* end) {
    const std::string wanted = std::string("pliant::BridgeSnapshot::") + end;
    assert_string_equal(pli_last_error(bridge.context()), wanted.c_str());
}

static void what_the_game_has_changed_comes_back(void**) {
    Scene scene;
    scene.stock.step(50);
    BridgeSnapshot snapshot;
    assert_int_equal(snapshot.bytes(), 0);
    assert_int_equal(snapshot.restore(*scene.bridge), PLI_ERROR_INVALID_VALUE);
    expect_error(*scene.bridge, "restore: the snapshot is empty");
    assert_int_equal(snapshot.save(*scene.bridge), PLI_OK);
    assert_true(snapshot.bytes() > 225 * 48);
    scene.stock.step(30);
    const Scene::State later = scene.state();
    scene.boxes[0]->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(5, 5, 5)));
    scene.boxes[3]->forceActivationState(DISABLE_SIMULATION);
    scene.stock.world->setGravity(btVector3(0, 5, 0));
    assert_int_equal(pli_body_remove_anchor(scene.sheet, scene.held), PLI_OK);
    scene.stock.step(30);
    if (snapshot.restore(*scene.bridge) != PLI_OK) { fail_msg("%s", pli_last_error(scene.bridge->context())); }
    assert_int_equal(pli_body_anchor_count(scene.sheet), 1);
    scene.stock.step(30);
    assert_true(scene.state() == later);
}

// Made anew, as another process would.
static void another_world_goes_on_from_a_file(void**) {
    const btVector3 corner(100, 100, 100);
    Scene scene(std::make_unique<btAxisSweep3>(-corner, corner));
    scene.stock.step(40);
    assert_int_equal(pli_body_cut_swept(scene.sheet, pli_vec3_make(-0.1f, 3, -1), pli_vec3_make(-0.1f, -3, -1),
                                        pli_vec3_make(-0.1f, 3, 0.2f), pli_vec3_make(-0.1f, -3, 0.2f), nullptr),
                     PLI_OK);
    scene.stock.step(20);
    std::vector<unsigned char> bytes;
    assert_int_equal(BridgeSnapshot::write_file(*scene.bridge, bytes), PLI_OK);
    std::array<Scene::State, 60> states;
    for (Scene::State& state : states) {
        scene.stock.step(1);
        state = scene.state();
    }
    for (int round = 0; round < 2; ++round) { // a world at its start, and the one that has gone on
        Scene made(std::make_unique<btAxisSweep3>(-corner, corner));
        Scene& anew = round == 0 ? made : scene;
        if (BridgeSnapshot::read_file(*anew.bridge, bytes.data(), bytes.size()) != PLI_OK) {
            fail_msg("%s", pli_last_error(anew.bridge->context()));
        }
        for (std::size_t k = 0; k < states.size(); ++k) {
            anew.stock.step(1);
            if (!(anew.state() == states[k])) { fail_msg("round %d: frame %zu differs", round, k); }
        }
    }
}

static void files_that_are_wrong_are_refused(void**) {
    Scene scene;
    scene.stock.step(30);
    std::vector<unsigned char> bytes;
    assert_int_equal(BridgeSnapshot::write_file(*scene.bridge, bytes), PLI_OK);
    const Scene::State before = scene.state();
    for (std::size_t size = 0; size < bytes.size(); size += size < 100 ? 1 : 997) {
        assert_int_equal(BridgeSnapshot::read_file(*scene.bridge, bytes.data(), size), PLI_ERROR_FILE_FORMAT);
    }
    assert_int_equal(BridgeSnapshot::read_file(*scene.bridge, bytes.data(), 200), PLI_ERROR_FILE_FORMAT);
    expect_error(*scene.bridge, "read_file: it is cut short");
    assert_int_equal(BridgeSnapshot::read_file(*scene.bridge, nullptr, 100), PLI_ERROR_NULL_ARGUMENT);
    expect_error(*scene.bridge, "read_file: bytes is null");
    for (std::size_t at = 0; at < bytes.size(); at += at < 100 ? 1 : 997) {
        bytes[at] ^= 4;
        const pli_status status = BridgeSnapshot::read_file(*scene.bridge, bytes.data(), bytes.size());
        assert_true(status == PLI_ERROR_FILE_FORMAT || status == PLI_ERROR_INVALID_VALUE);
        bytes[at] ^= 4;
        if (at == 0) { expect_error(*scene.bridge, "read_file: it is no file of a bridge"); }
        if (at == 8) { expect_error(*scene.bridge, "read_file: it has the format of another version"); }
    }
    bytes.back() ^= 4;
    assert_int_equal(BridgeSnapshot::read_file(*scene.bridge, bytes.data(), bytes.size()), PLI_ERROR_FILE_FORMAT);
    expect_error(*scene.bridge, "read_file: its checksum is wrong, it is cut short or damaged");
    bytes.back() ^= 4;
    scene.stock.world->removeRigidBody(scene.boxes[5]);
    assert_int_equal(BridgeSnapshot::read_file(*scene.bridge, bytes.data(), bytes.size()), PLI_ERROR_INVALID_VALUE);
    expect_error(*scene.bridge, "read_file: the Bullet world has other objects");
    assert_true(scene.state() == before);
    scene.stock.world->addRigidBody(scene.boxes[5]);
}

// Of a file of a bridge, whose header ends with them: the checksum of what follows the core's file, of this size.
static void seal(std::vector<unsigned char>& bytes) {
    std::uint64_t core_size = 0, sum = 14695981039346656037u;
    std::memcpy(&core_size, bytes.data() + 32, sizeof core_size);
    for (std::size_t i = 48 + static_cast<std::size_t>(core_size); i < bytes.size(); ++i) {
        sum = (sum ^ bytes[i]) * 1099511628211u;
    }
    std::memcpy(bytes.data() + 40, &sum, sizeof sum);
}

// Bullet would wait for ever until the time in its accumulator is one of a step again.
static void a_file_with_an_endless_time_or_gravity_is_refused(void**) {
    Scene scene;
    scene.stock.step(30);
    std::vector<unsigned char> bytes;
    assert_int_equal(BridgeSnapshot::write_file(*scene.bridge, bytes), PLI_OK);
    const Scene::State before = scene.state();
    // From its end: the seed, the time, gravity.
    const std::size_t time = bytes.size() - 8 - sizeof(btScalar), gravity = time - sizeof(btVector3);
    for (const std::size_t at : {time, gravity}) {
        for (const btScalar number : {btScalar(NAN), btScalar(INFINITY)}) {
            std::vector<unsigned char> changed = bytes;
            std::memcpy(changed.data() + at, &number, sizeof number);
            seal(changed);
            const pli_status status = BridgeSnapshot::read_file(*scene.bridge, changed.data(), changed.size());
            assert_int_equal(status, PLI_ERROR_FILE_FORMAT);
            expect_error(*scene.bridge, "read_file: its time or gravity is out of range");
            assert_true(scene.state() == before);
        }
    }
    std::vector<unsigned char> sealed = bytes;
    seal(sealed);
    assert_true(sealed == bytes);
}

// A game that turns a body by its transform alone leaves its inertia behind, until the next step.
static void inertia_comes_back_as_it_was(void**) {
    bridge_test::StockWorld stock;
    btRigidBody& stick = stock.add_box(btVector3(1, btScalar(0.1), btScalar(0.1)), 1, btVector3(0, 3, 0));
    pliant::Bridge bridge(*stock.world);
    assert_non_null(bridge_test::add_sheet(bridge, 1, 1, 5));
    stock.step(2);
    const btQuaternion turn(btVector3(0, 0, 1), btScalar(0.7));
    stick.setWorldTransform(btTransform(turn, btVector3(0, 3, 0)));
    const btMatrix3x3 before = stick.getInvInertiaTensorWorld();
    pliant::BridgeSnapshot moment;
    assert_int_equal(moment.save(bridge), PLI_OK);
    std::vector<unsigned char> file;
    assert_int_equal(pliant::BridgeSnapshot::write_file(bridge, file), PLI_OK);
    for (int i = 0; i < 2; ++i) {
        stock.step(3);
        assert_false(stick.getInvInertiaTensorWorld() == before);
        const bool is_file = i == 1;
        const pli_status status =
            is_file ? pliant::BridgeSnapshot::read_file(bridge, file.data(), file.size()) : moment.restore(bridge);
        assert_int_equal(status, PLI_OK);
        assert_true(stick.getInvInertiaTensorWorld() == before);
    }
}

// Sensors are met where the body begins to tell its contacts, and snapshots of before fit.
static void a_sensor_may_be_entered_in_between(void**) {
    bridge_test::StockWorld stock;
    btRigidBody& sensor = stock.add_box(btVector3(1, btScalar(0.2), 1), 0, btVector3(0, 1, 0));
    sensor.setCollisionFlags(sensor.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = bridge_test::add_sheet(bridge, 1, 1.5f, 7);
    assert_int_equal(pli_body_enable_contact_events(sheet, nullptr), PLI_OK);
    stock.step(2);
    pliant::BridgeSnapshot before;
    assert_int_equal(before.save(bridge), PLI_OK);
    int count = 0;
    for (int i = 0; i < 30 && count == 0; ++i) {
        stock.step(1);
        (void)pli_body_get_contact_events(sheet, PLI_CONTACT_BEGIN, &count);
    }
    assert_int_equal(count, 1);
    const std::uint64_t hash = pli_body_state_hash(sheet);
    assert_int_equal(before.restore(bridge), PLI_OK);
    assert_true(pli_body_state_hash(sheet) != hash);
}

static void other_objects_are_refused(void**) {
    Scene scene;
    scene.stock.step(10);
    BridgeSnapshot snapshot;
    assert_int_equal(snapshot.save(*scene.bridge), PLI_OK);
    std::vector<unsigned char> file;
    assert_int_equal(BridgeSnapshot::write_file(*scene.bridge, file), PLI_OK);
    assert_int_equal(BridgeSnapshot::read_file(*scene.bridge, file.data(), file.size()), PLI_OK);
    assert_int_equal(snapshot.restore(*scene.bridge), PLI_ERROR_INVALID_VALUE);
    expect_error(*scene.bridge, "restore: the Bullet world has other objects, or has read a file since");
    assert_int_equal(snapshot.save(*scene.bridge), PLI_OK);
    scene.stock.world->removeRigidBody(scene.boxes[5]);
    const Scene::State before = scene.state();
    assert_int_equal(snapshot.restore(*scene.bridge), PLI_ERROR_INVALID_VALUE);
    expect_error(*scene.bridge, "restore: the Bullet world has other objects, or has read a file since");
    assert_true(scene.state() == before);
    scene.stock.world->addRigidBody(scene.boxes[5]); // another to the broad phase
    assert_int_equal(snapshot.restore(*scene.bridge), PLI_ERROR_INVALID_VALUE);
    scene.stock.step(5);
    assert_int_equal(scene.bridge->remove_body(scene.sheet), PLI_OK);
    assert_int_equal(snapshot.save(*scene.bridge), PLI_ERROR_WRONG_STATE);
    assert_int_equal(snapshot.bytes(), 0);
    scene.bridge->detach();
    assert_int_equal(snapshot.save(*scene.bridge), PLI_ERROR_WRONG_STATE);
}

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(eight_frames_back_and_forward_again),
        cmocka_unit_test(the_same_with_trees_where_nothing_sleeps),
        cmocka_unit_test(what_the_game_has_changed_comes_back),
        cmocka_unit_test(another_world_goes_on_from_a_file),
        cmocka_unit_test(files_that_are_wrong_are_refused),
        cmocka_unit_test(a_file_with_an_endless_time_or_gravity_is_refused),
        cmocka_unit_test(inertia_comes_back_as_it_was),
        cmocka_unit_test(a_sensor_may_be_entered_in_between),
        cmocka_unit_test(other_objects_are_refused),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
