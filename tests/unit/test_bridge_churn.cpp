// Random objects of Bullet and random soft bodies with anchors to them come and go, between steps, in tick callbacks,
// in actions and in the bridges' own hook, objects without a word to the bridges.
//   test_bridge_churn [OPERATIONS [SEEDS [FIRST_SEED]]]
#include "check.h"
#include "test_bridge_slot.h"
#include "test_bridge_world.h"

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolverMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <LinearMath/btThreads.h>

#include <malloc.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <random>
#include <vector>

using namespace bridge_test;

namespace {

int operation_count = 500, seed_count = 6, first_seed = 1;

enum Moment { between_steps, before_step, in_action, in_hook, after_step, moment_count };

/// An object of Bullet, in a place where others were before it and will be after it.
struct Place {
    Slot slot;
    std::unique_ptr<btCollisionObject> heap; ///< when it is not in the slot; its memory goes back to the heap
    std::unique_ptr<btCollisionShape> shape;
    btCollisionObject* object = nullptr;
    int serial = 0;
    bool is_in_world() const { return object != nullptr && object->getWorldArrayIndex() >= 0; }
};

struct Tie {
    int serial;        ///< of the object
    bool was_seen;     ///< by the bridge, in the world
    bool was_away;     ///< out of the world, if only between two looks of the bridge
    int deleted_after; ///< steps, when it was a rigid body; -1: not
};

struct Soft {
    pli_body* body;
    std::vector<Tie> ties;
    int anchor_count; ///< at the start of the step
    /// Something happened while its bridge was in no step, so that its event may be cleared by the step to come.
    bool is_uncertain;
};

class Churn {
public:
    explicit Churn(int seed) : random_(static_cast<unsigned>(seed)) {
        const bool is_parallel = seed % 4 == 0;
        broadphase_ = make_broadphase(seed % 3);
        if (is_parallel) {
            dispatcher_ = std::make_unique<btCollisionDispatcherMt>(&configuration_);
            world_ = std::make_unique<btDiscreteDynamicsWorldMt>(dispatcher_.get(), broadphase_.get(), &pool_,
                                                                 &parallel_solver_, &configuration_);
        } else {
            dispatcher_ = std::make_unique<btCollisionDispatcher>(&configuration_);
            world_ = std::make_unique<btDiscreteDynamicsWorld>(dispatcher_.get(), broadphase_.get(), &solver_,
                                                               &configuration_);
        }
        world_->setWorldUserInfo(this);
        const auto before = [](btDynamicsWorld* w, btScalar) {
            of(w).act(before_step);
            of(w).note_anchors(); // what was lost until now is told now, and the step clears it
        };
        world_->setInternalTickCallback(before, this, true);
        world_->setInternalTickCallback([](btDynamicsWorld* w, btScalar) { of(w).act(after_step); }, this, false);
        world_->addAction(&action_);
        for (Mesh& mesh : meshes_) {
            mesh.make();
        }
        make_bridge(0);
        make_bridge(1);
    }

    ~Churn() {
        // Everything in a random order.
        const bool world_first = pick(2) == 0;
        if (pick(2) == 0) { end_bridge(0); }
        if (world_first) {
            for (Place& place : places_) {
                end(place, false);
            }
            world_.reset();
        }
        end_bridge(1);
        end_bridge(0);
        for (Place& place : places_) {
            end(place, false);
        }
    }

    void run(int operations) {
        const int warm = operations / 5;
        churn(warm);
        const std::size_t before = empty_heap_size();
        churn(operations - warm);
        const std::size_t after = empty_heap_size();
        // Lists of Bullet's keep the room that they once had.
        if (after > before + 65536) { fail_msg("%zu bytes after %d operations, %zu after all", before, warm, after); }
    }

    int changes = 0; ///< objects and soft bodies that came or went
    int deletions = 0, anchors = 0, losses = 0, steps = 0, softs_in_steps = 0, refusals = 0;

private:
    static constexpr int place_count = 16, soft_count = 2, bridge_count = 2;

    void churn(int operations) {
        while (operations > 0) {
            for (int i = pick(8); i >= 0 && operations > 0; --i, --operations) {
                operate(between_steps);
            }
            // Some wait for their moment inside of the step.
            for (int i = pick(8); i > 0 && operations > 0; --i, --operations) {
                ++pending_[1 + pick(moment_count - 1)];
            }
            step();
        }
    }

    /// Of the process, 0 where it is not known, with nothing in the world but two bridges.
    std::size_t empty_heap_size() {
        for (int i = 0; i < bridge_count; ++i) {
            renew_bridge(i);
        }
        for (Place& place : places_) {
            end(place, false);
        }
        step();
        return mallinfo2().uordblks;
    }

    struct Mesh {
        void make() {
            const btVector3 a(-1, 0, -1), b(1, 0, -1), c(-1, 0, 1), d(1, 0, 1);
            triangles.addTriangle(a, c, b);
            triangles.addTriangle(b, c, d);
        }
        btTriangleMesh triangles;
    };

    class Action final : public btActionInterface {
    public:
        explicit Action(Churn& churn) : churn_(churn) {}
        void updateAction(btCollisionWorld*, btScalar) override {
            churn_.note_seen();
            churn_.act(in_action);
        }
        void debugDraw(btIDebugDraw*) override {}

    private:
        Churn& churn_;
    };

    struct BridgeOf {
        std::unique_ptr<pliant::Bridge> bridge;
        std::vector<Soft> softs;
    };

    static Churn& of(btDynamicsWorld* world) { return *static_cast<Churn*>(world->getWorldUserInfo()); }

    std::unique_ptr<btBroadphaseInterface> make_broadphase(int kind) const {
        if (kind == 1) {
            return std::make_unique<btAxisSweep3>(btVector3(-100, -1000, -100), btVector3(100, 100, 100), 512);
        }
        if (kind == 2) { return std::make_unique<btSimpleBroadphase>(512); }
        return std::make_unique<btDbvtBroadphase>();
    }

    int pick(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }
    btScalar number(double low, double high) {
        return btScalar(low + (high - low) * static_cast<double>(random_() % 1000) / 1000);
    }
    Place& any_place() { return places_[static_cast<std::size_t>(pick(place_count))]; }

    void make_bridge(int index) {
        pliant::BridgeDef def;
        def.mode = pick(2) == 0 ? pliant::CollisionMode::exact : pliant::CollisionMode::reference;
        def.prepares_rigids_ahead = pick(3) > 0;
        BridgeOf& made = bridges_[index];
        made.bridge = std::make_unique<pliant::Bridge>(*world_, def);
        made.bridge->set_before_solve([this] { act(in_hook); });
    }

    void renew_bridge(int index) {
        end_bridge(index);
        make_bridge(index);
    }

    void end_bridge(int index) {
        bridges_[index].softs.clear();
        bridges_[index].bridge.reset();
    }

    // ---- what happens

    void act(Moment moment) {
        const bool may_be_early = pending_[moment] > 0 && (moment == in_action || moment == in_hook);
        for (; pending_[moment] > 0; --pending_[moment]) {
            operate(moment);
        }
        for (BridgeOf& of : bridges_) {
            if (!may_be_early || !of.bridge || pli_world_is_stepping(of.bridge->world())) { continue; }
            for (Soft& soft : of.softs) {
                soft.is_uncertain = true;
            }
        }
    }

    void operate(Moment moment) {
        Place& place = any_place();
        const int kind = pick(24);
        // What is told before a step has its event there, and the step clears it.
        const bool is_told = pick(10) == 0 && moment != before_step;
        if (kind < 7) {
            if (place.object == nullptr || pick(3) == 0) {
                end(place, is_told);
                renew(place);
            }
            return;
        }
        if (kind < 10) {
            end(place, is_told);
            return;
        }
        if (kind < 12) {
            if (place.is_in_world()) {
                remove(place);
            } else if (place.object != nullptr) {
                add(place);
            }
            return;
        }
        if (kind == 12) {
            if (place.object != nullptr) { any_bridge().refresh(*place.object); }
            return;
        }
        if (kind == 13) {
            // Away and back.
            if (place.is_in_world()) {
                world_->removeCollisionObject(place.object);
                add(place);
            }
            return;
        }
        if (kind == 14) {
            world_->performDiscreteCollisionDetection();
            return;
        }
        if (moment != between_steps && kind < 17) {
            end(place, false);
            return;
        }
        operate_on_bridge(pick(bridge_count), place, kind, moment);
    }

    pliant::Bridge& any_bridge() { return *bridges_[pick(bridge_count)].bridge; }

    // Inside of its step a bridge refuses what would change its bodies.
    void operate_on_bridge(int index, Place& place, int kind, Moment moment) {
        BridgeOf& of = bridges_[index];
        const bool is_refused = pli_world_is_stepping(of.bridge->world());
        const pli_status expected = is_refused ? PLI_ERROR_WRONG_STATE : PLI_OK;
        refusals += is_refused ? 1 : 0;
        if (kind < 21 || of.softs.empty()) {
            if (static_cast<int>(of.softs.size()) < soft_count) { add_soft(of, is_refused, moment); }
            if (place.object != nullptr && !of.softs.empty()) { anchor(of, place, is_refused); }
        } else if (kind == 21) {
            const auto soft = of.softs.begin() + pick(static_cast<int>(of.softs.size()));
            assert_int_equal(of.bridge->remove_body(soft->body), expected);
            if (!is_refused) {
                of.softs.erase(soft);
                ++changes;
            }
        } else if (kind == 22) {
            if (place.object != nullptr && !is_refused) { begin_anew(place); }
            if (place.object != nullptr) { (void)of.bridge->use_sampled_mesh(*place.object, coarse()); }
            move_soft(of);
        } else if (pick(4) == 0 && moment != in_hook) { // which is a function of the bridge
            renew_bridge(index);
        }
    }

    // Handed to a bridge while it is out of the world an object begins anew.
    void begin_anew(const Place& place) {
        if (place.is_in_world()) { return; }
        for_ties(place.serial, [](Tie& tie) { tie.was_seen = false; });
    }

    void move_soft(BridgeOf& of) {
        if (of.softs.empty()) { return; }
        Soft& soft = of.softs[static_cast<std::size_t>(pick(static_cast<int>(of.softs.size())))];
        btCollisionObject& object = *of.bridge->object(soft.body);
        object.setWorldTransform(btTransform(btQuaternion(btVector3(0, 1, 0), number(-1, 1)),
                                             btVector3(number(-0.1, 0.1), number(0, 0.2), number(-0.1, 0.1))));
    }

    static pli_sampled_mesh_def coarse() {
        pli_sampled_mesh_def def = pli_sampled_mesh_def_default();
        def.cell_size = 0.2f;
        return def;
    }

    void add_soft(BridgeOf& of, bool is_refused, Moment moment) {
        const auto height = static_cast<float>(number(0, 2));
        pli_body* body = add_sheet(*of.bridge, 2, height, 4, PLI_PATCH_PIN_CORNERS * pick(2), 0, 0, 0.05f);
        if (is_refused) {
            assert_null(body);
            return;
        }
        assert_non_null(body);
        ++changes;
        softs_in_steps += moment != between_steps ? 1 : 0;
        if (pick(8) == 0) {
            const pli_rigid_face_contacts_def faces = pli_rigid_face_contacts_def_default();
            assert_int_equal(pli_body_enable_rigid_face_contacts(body, &faces), PLI_OK);
        }
        const pli_implicit_def implicit = pli_implicit_def_default();
        if (pick(4) == 0) { assert_int_equal(pli_body_enable_implicit(body, &implicit), PLI_OK); }
        of.softs.push_back({body, {}, 0, false});
    }

    void anchor(BridgeOf& of, Place& place, bool is_refused) {
        Soft& soft = of.softs[static_cast<std::size_t>(pick(static_cast<int>(of.softs.size())))];
        pli_anchor_def def = pli_anchor_def_default();
        def.node = pick(16);
        if (is_refused) {
            assert_null(of.bridge->rigid(*place.object));
            return;
        }
        begin_anew(place);
        def.rigid = of.bridge->rigid(*place.object);
        if (def.rigid == nullptr) { // what anchors have thrown beyond the limits
            assert_true(std::strstr(pli_last_error(of.bridge->context()), "pli_rigid_create") != nullptr);
            return;
        }
        assert_int_equal(pli_body_add_anchor(soft.body, &def, nullptr), PLI_OK);
        soft.ties.push_back({place.serial, place.is_in_world(), false, -1});
        ++soft.anchor_count;
        ++anchors;
    }

    // ---- objects

    std::unique_ptr<btCollisionShape> make_shape(int kind) {
        const btScalar size = number(0.2, 0.6);
        switch (kind) {
        case 0:
            return std::make_unique<btBoxShape>(btVector3(size, size, size));
        case 1:
            return std::make_unique<btSphereShape>(size);
        case 2:
            return std::make_unique<btCapsuleShape>(size, size); // btConeShape reads what it never set
        case 3: {
            auto flat = std::make_unique<btConvexHullShape>();
            for (int i = 0; i < 4; ++i) {
                flat->addPoint(btVector3((i & 1) != 0 ? size : -size, 0, (i & 2) != 0 ? size : -size));
            }
            return flat;
        }
        case 4:
            return std::make_unique<btCylinderShape>(btVector3(size, size, size));
        default:
            return std::make_unique<btBvhTriangleMeshShape>(&meshes_[pick(2)].triangles, true);
        }
    }

    template <typename T, typename... Args> T& make_object(Place& place, Args&&... args) {
        if (pick(3) > 0) { return place.slot.make<T>(std::forward<Args>(args)...); }
        auto made = std::make_unique<T>(std::forward<Args>(args)...);
        T& object = *made;
        place.heap = std::move(made);
        return object;
    }

    void renew(Place& place) {
        const int shape = pick(6), kind = pick(8);
        place.shape = make_shape(shape);
        place.serial = ++serial_;
        if (kind < 6) {
            const btScalar mass = kind < 4 && shape != 5 ? 1 : 0;
            const btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, place.shape.get(), btVector3(1, 1, 1));
            place.object = &make_object<btRigidBody>(place, info);
            if (kind == 5) { place.object->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT); }
        } else if (kind == 6) {
            place.object = &make_object<btGhostObject>(place);
        } else {
            place.object = &make_object<btCollisionObject>(place);
        }
        place.object->setCollisionShape(place.shape.get());
        place.object->setWorldTransform(
            btTransform(btQuaternion::getIdentity(), btVector3(number(-1, 1), number(-0.5, 2), number(-1, 1))));
        if (pick(4) > 0) { add(place); }
    }

    void add(Place& place) {
        ++changes;
        btRigidBody* body = btRigidBody::upcast(place.object);
        if (body != nullptr) {
            world_->addRigidBody(body);
        } else {
            world_->addCollisionObject(place.object);
        }
    }

    void remove(Place& place) {
        ++changes;
        world_->removeCollisionObject(place.object);
        for_ties(place.serial, [](Tie& tie) { tie.was_away = true; });
    }

    void end(Place& place, bool is_told) {
        if (place.object == nullptr) { return; }
        for (BridgeOf& of : bridges_) {
            if (is_told && of.bridge) { of.bridge->forget(*place.object); }
        }
        if (place.is_in_world()) { remove(place); }
        const bool is_rigid = btRigidBody::upcast(place.object) != nullptr;
        // Of other objects Bullet tells no number: the next one at the address may take over anchors.
        for_ties(place.serial, [&](Tie& tie) {
            tie.was_away = true;
            if (is_rigid) { tie.deleted_after = steps; }
        });
        place.slot.clear();
        place.heap.reset();
        place.object = nullptr;
        place.shape.reset();
        ++deletions;
    }

    template <typename Do> void for_ties(int serial, Do&& call) {
        for (BridgeOf& of : bridges_) {
            for (Soft& soft : of.softs) {
                for (Tie& tie : soft.ties) {
                    if (tie.serial == serial) { call(tie); }
                }
            }
        }
    }

    // ---- checks

    void note_seen() {
        for (const Place& place : places_) {
            if (place.is_in_world()) {
                for_ties(place.serial, [](Tie& tie) { tie.was_seen = true; });
            }
        }
    }

    void note_anchors() {
        for (BridgeOf& of : bridges_) {
            for (Soft& soft : of.softs) {
                soft.anchor_count = pli_body_anchor_count(soft.body);
                soft.is_uncertain = false;
            }
        }
    }

    void step() {
        ++steps;
        world_->stepSimulation(btScalar(1) / 60, 0);
        for (Place& place : places_) {
            assert_true(place.slot.is_untouched());
        }
        for (BridgeOf& of : bridges_) {
            for (const Soft& soft : of.softs) {
                check(*of.bridge, soft);
            }
            // Anchors that pull in different directions may blow a body up.
            for (auto soft = of.softs.begin(); soft != of.softs.end();) {
                const bool is_frozen = pli_body_is_frozen(soft->body);
                if (is_frozen) { assert_int_equal(of.bridge->remove_body(soft->body), PLI_OK); }
                soft = is_frozen ? of.softs.erase(soft) : std::next(soft);
            }
        }
    }

    // A tie surely holds when its object was never away, and surely does not when it was seen and has been deleted
    // before this step.
    void check(const pliant::Bridge& bridge, const Soft& soft) {
        int least = 0, most = 0;
        for (const Tie& tie : soft.ties) {
            least += tie.was_away ? 0 : 1;
            most += tie.was_seen && tie.deleted_after >= 0 && tie.deleted_after < steps ? 0 : 1;
        }
        const int count = pli_body_anchor_count(soft.body);
        assert_in_range(count, least, most);
        int event_count = 0, told = 0;
        const pli_event* events = pli_world_get_events(bridge.world(), &event_count);
        for (int i = 0; i < event_count; ++i) {
            told += events[i].kind == PLI_EVENT_ANCHORS_LOST && events[i].body == soft.body ? 1 : 0;
        }
        if (!soft.is_uncertain) { assert_int_equal(told, count < soft.anchor_count ? 1 : 0); }
        losses += soft.anchor_count - count;
    }

    std::mt19937 random_;
    btDefaultCollisionConfiguration configuration_;
    std::unique_ptr<btBroadphaseInterface> broadphase_;
    std::unique_ptr<btCollisionDispatcher> dispatcher_;
    btSequentialImpulseConstraintSolver solver_;
    btConstraintSolverPoolMt pool_{2};
    btSequentialImpulseConstraintSolverMt parallel_solver_;
    Mesh meshes_[2];
    std::unique_ptr<btDiscreteDynamicsWorld> world_;
    Action action_{*this};
    BridgeOf bridges_[bridge_count];
    std::array<Place, place_count> places_;
    int pending_[moment_count] = {};
    int serial_ = 0;
};

} // namespace

static void test_objects_come_and_go_at_any_moment(void**) {
    btITaskScheduler* before = btGetTaskScheduler();
    btSetTaskScheduler(btGetSequentialTaskScheduler());
    int operations = 0, deletions = 0, losses = 0, added = 0, refusals = 0;
    for (int seed = first_seed; seed < first_seed + seed_count; ++seed) {
        Churn churn(seed);
        churn.run(operation_count);
        print_message("           seed %d: %d steps, %d came or went, %d deletions, %d anchors, %d lost in steps, %d "
                      "soft bodies added in steps, %d calls refused\n",
                      seed, churn.steps, churn.changes, churn.deletions, churn.anchors, churn.losses,
                      churn.softs_in_steps, churn.refusals);
        operations += operation_count;
        deletions += churn.deletions;
        losses += churn.losses;
        added += churn.softs_in_steps;
        refusals += churn.refusals;
    }
    assert_true(deletions > operations / 10 && losses > operations / 100);
    assert_true(added > operations / 200 && refusals > operations / 200);
    btSetTaskScheduler(before);
}

int main(int argc, char** argv) {
    if (argc > 1) { operation_count = std::atoi(argv[1]); }
    if (argc > 2) { seed_count = std::atoi(argv[2]); }
    if (argc > 3) { first_seed = std::atoi(argv[3]); }
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_objects_come_and_go_at_any_moment)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
