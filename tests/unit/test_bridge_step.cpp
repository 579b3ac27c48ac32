// When the bridge steps, what it steps, and how it lives beside the Bullet world.
#include "check.h"
#include "failing_allocator.h"
#include "test_bridge_world.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolverMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <LinearMath/btThreads.h>

#include <pliant/threads.h>
#include <pliant_bullet/task_scheduler.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

using namespace bridge_test;

namespace {

constexpr btScalar dt = btScalar(1) / btScalar(60);

// A sheet that falls on a static box with a movable ball on it.
pli_body* build_scene(StockWorld& stock, pliant::Bridge& bridge) {
    stock.add_box(btVector3(btScalar(0.4), btScalar(0.4), btScalar(0.4)), 0, btVector3(0, 0, 0));
    stock.add_body(new btSphereShape(btScalar(0.2)), btScalar(0.3),
                   btVector3(btScalar(0.1), btScalar(1.2), btScalar(0.05)));
    return add_sheet(bridge, 2, 0.8f, 9);
}

} // namespace

static void test_free_fall_takes_one_step_per_internal_step(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1, 0, 3);
    stock.world->stepSimulation(dt, 0);
    const float expected = -10.0f * static_cast<float>(dt * dt);
    check_near(center(sheet).y, expected, 1e-7);
    // Less than a fixed step has passed: nothing moves. Then two sub-steps at once.
    stock.world->stepSimulation(dt / 4, 4, dt);
    check_near(center(sheet).y, expected, 1e-7);
    stock.world->stepSimulation(2 * dt, 4, dt);
    check_near(center(sheet).y, 6 * expected, 1e-6);
    // A variable step.
    const btScalar small = btScalar(0.004);
    stock.world->stepSimulation(small, 0);
    check_near(center(sheet).y, 6 * expected + static_cast<float>((-30 * dt - 10 * small) * small), 1e-6);
}

static void test_sub_steps_equal_single_steps(void**) {
    std::uint64_t hashes[2];
    for (int variant = 0; variant < 2; ++variant) {
        StockWorld stock;
        pliant::Bridge bridge(*stock.world);
        pli_body* sheet = build_scene(stock, bridge);
        if (variant == 0) { stock.step(120, dt); }
        // A little more than two steps, so that rounding of the sum does not lose one.
        for (int i = 0; variant == 1 && i < 60; ++i) {
            stock.world->stepSimulation(i == 0 ? 2 * dt + dt / 100 : 2 * dt, 2, dt);
        }
        hashes[variant] = pli_body_state_hash(sheet);
    }
    assert_int_equal(hashes[0], hashes[1]);
}

static void test_a_world_without_bodies_steps(void**) {
    StockWorld stock;
    stock.add_box(btVector3(1, 1, 1), 1, btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    stock.step(3);
    assert_int_equal(bridge.step_status(), PLI_OK);
    assert_false(pli_world_is_stepping(bridge.world()));
}

static void test_bodies_come_and_go_between_steps(void**) {
    StockWorld stock;
    stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    stock.add_box(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)), 1, btVector3(0, 2, 0));
    pliant::Bridge bridge(*stock.world);
    std::vector<pli_body*> bodies;
    for (int i = 0; i < 30; ++i) {
        pli_body* added = add_sheet(bridge, 1, 0.5f + 0.1f * static_cast<float>(i % 5), 5);
        assert_non_null(added);
        bodies.push_back(added);
        stock.step(3);
        if (i % 3 == 2) {
            assert_int_equal(bridge.remove_body(bodies[bodies.size() / 2]), PLI_OK);
            bodies.erase(bodies.begin() + static_cast<std::ptrdiff_t>(bodies.size() / 2));
        }
    }
    assert_int_equal(pli_world_body_count(bridge.world()), 20);
    stock.step(100);
    for (const pli_body* body : bodies) {
        assert_true(lowest(body) > 0);
    }
}

static void test_rigid_bodies_come_and_go_between_steps(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 2, 0.5f, 9);
    // New bodies often get the address of the one before.
    for (int i = 0; i < 20; ++i) {
        std::unique_ptr<btCollisionShape> shape;
        if (i % 2 == 0) {
            shape = std::make_unique<btBoxShape>(btVector3(1, btScalar(0.2), 1));
        } else {
            shape = std::make_unique<btSphereShape>(btScalar(0.4));
        }
        btRigidBody::btRigidBodyConstructionInfo info(i % 4 == 3 ? 1 : 0, nullptr, shape.get(), btVector3(1, 1, 1));
        auto body = std::make_unique<btRigidBody>(info);
        body->setWorldTransform(
            btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(lowest(sheet)) - btScalar(0.3), 0)));
        stock.world->addRigidBody(body.get());
        stock.step(5);
        stock.world->removeRigidBody(body.get());
    }
    assert_int_equal(bridge.step_status(), PLI_OK);
    assert_false(pli_body_is_frozen(sheet));
}

static void test_an_inactive_object_does_not_move(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1, 0, 3);
    pli_body* other = add_sheet(bridge, 1, 0, 3, 0, 5);
    bridge.object(sheet)->forceActivationState(DISABLE_SIMULATION);
    stock.step(10);
    check_near(center(sheet).y, 0, 0);
    assert_true(center(other).y < -0.1f);
    bridge.object(sheet)->forceActivationState(ACTIVE_TAG);
    stock.step(10);
    assert_true(center(sheet).y < -0.1f);
    // Out of the world it rests too.
    stock.world->removeCollisionObject(bridge.object(sheet));
    const float y = center(sheet).y;
    stock.step(10);
    check_near(center(sheet).y, y, 0);
    assert_int_equal(bridge.remove_body(sheet), PLI_OK);
}

static void test_two_worlds_do_not_touch(void**) {
    StockWorld stock[3];
    std::unique_ptr<pliant::Bridge> bridges[3];
    pli_body* sheets[3];
    for (int i = 0; i < 3; ++i) {
        bridges[i] = std::make_unique<pliant::Bridge>(*stock[i].world);
        sheets[i] = build_scene(stock[i], *bridges[i]);
    }
    // The first two step in turn, the third alone.
    for (int i = 0; i < 60; ++i) {
        stock[0].step(1);
        stock[1].step(1);
    }
    stock[2].step(60);
    assert_int_equal(pli_body_state_hash(sheets[0]), pli_body_state_hash(sheets[2]));
    assert_int_equal(pli_body_state_hash(sheets[1]), pli_body_state_hash(sheets[2]));
}

static void test_two_bridges_share_a_world(void**) {
    StockWorld stock;
    stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    auto first = std::make_unique<pliant::Bridge>(*stock.world);
    pliant::Bridge second(*stock.world);
    pli_body* a = add_sheet(*first, 1, 0.3f, 5);
    pli_body* b = add_sheet(second, 1, 0.3f, 5);
    stock.step(60);
    check_near(lowest(a), 0.1, 0.01);
    check_near(lowest(b), 0.1, 0.01);
    assert_null(second.body(first->object(a)));
    assert_ptr_equal(first->body(first->object(a)), a);
    assert_ptr_equal(pliant::Bridge::from_object(first->object(a)), a);
    assert_int_equal(second.remove_body(a), PLI_ERROR_INVALID_VALUE);
    assert_string_equal(pli_last_error(second.context()),
                        "pliant::Bridge::remove_body: the body is not one of this bridge");
    first.reset();
    stock.step(60);
    check_near(lowest(b), 0.1, 0.01);
}

static void test_the_before_solve_hook_sees_contacts_and_end_of_step_poses(void**) {
    StockWorld stock;
    stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1, 0.05f, 5);
    int calls = 0, contacts = 0;
    pli_status added = PLI_OK, removed = PLI_OK;
    bridge.set_before_solve([&] {
        ++calls;
        contacts = pli_body_get_rigid_contacts(sheet, 0, nullptr);
        // A step in progress refuses changes of the set of bodies.
        pli_body* body = nullptr;
        pli_mesh* mesh = make_sheet(bridge.context(), 1, 0, 3);
        added = bridge.add_body(mesh, nullptr, &body);
        removed = bridge.remove_body(sheet);
        assert_string_equal(pli_last_error(bridge.context()),
                            "pliant::Bridge::remove_body: not allowed inside of a step");
        pli_mesh_destroy(mesh);
    });
    stock.step(3);
    assert_int_equal(calls, 3);
    assert_int_equal(contacts, 25);
    assert_int_equal(added, PLI_ERROR_WRONG_STATE);
    assert_int_equal(removed, PLI_ERROR_WRONG_STATE);
}

static void test_queries_between_steps_do_not_step(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1, 0, 3);
    stock.step(2);
    const std::uint64_t hash = pli_body_state_hash(sheet);
    stock.world->updateAabbs();
    stock.world->performDiscreteCollisionDetection();
    assert_false(pli_world_is_stepping(bridge.world()));
    assert_int_equal(pli_body_state_hash(sheet), hash);
    stock.step(1);
    assert_int_not_equal(pli_body_state_hash(sheet), hash);
}

static void test_errors_are_reported_and_leave_nothing_behind(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    pli_body* body = nullptr;
    assert_int_equal(bridge.add_body(nullptr, nullptr, &body), PLI_ERROR_NULL_ARGUMENT);
    pli_mesh* empty = nullptr;
    assert_int_equal(pli_mesh_create(bridge.context(), &empty), PLI_OK);
    assert_int_equal(bridge.add_body(empty, nullptr, &body), PLI_ERROR_INVALID_MESH);
    assert_int_not_equal(pli_last_error(bridge.context())[0], 0);
    pli_mesh_destroy(empty);
    pli_mesh* mesh = make_sheet(bridge.context(), 1, 0, 3);
    assert_int_equal(bridge.add_body(mesh, nullptr, nullptr), PLI_ERROR_NULL_ARGUMENT);
    pli_body_def def{};
    assert_int_equal(bridge.add_body(mesh, &def, &body), PLI_ERROR_INVALID_DEF);
    assert_null(body);
    assert_int_equal(stock.world->getNumCollisionObjects(), 0);
    assert_int_equal(pli_world_body_count(bridge.world()), 0);
    assert_int_equal(bridge.remove_body(nullptr), PLI_OK);
    assert_null(bridge.object(nullptr));
    assert_null(bridge.body(nullptr));
    assert_null(pliant::Bridge::from_object(nullptr));

    bridge.detach();
    assert_int_equal(bridge.add_body(mesh, nullptr, &body), PLI_ERROR_WRONG_STATE);
    assert_string_equal(pli_last_error(bridge.context()),
                        "pliant::Bridge::add_body: the bridge has left its Bullet world, or that is gone");
    pli_mesh_destroy(mesh);
    stock.step(1);
}

// Its scale belongs to the shape.
static void test_an_object_whose_basis_is_scaled_is_refused(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    add_sheet(bridge, 1, 0.51f, 3);
    btRigidBody& box = stock.add_box(btVector3(1, btScalar(0.5), 1), 0, btVector3(0, 0, 0));
    stock.step(1, dt);
    assert_int_equal(bridge.step_status(), PLI_OK);
    box.getWorldTransform().setBasis(btMatrix3x3::getIdentity().scaled(btVector3(2, 1, 1)));
    stock.step(1, dt);
    assert_int_equal(bridge.step_status(), PLI_ERROR_INVALID_VALUE);
    assert_non_null(std::strstr(pli_last_error(bridge.context()), "pose.rotation is scaled"));
}

static void test_a_bridge_with_a_bad_definition_answers_every_call(void**) {
    StockWorld stock;
    pliant::BridgeDef def;
    def.gravity = pli_vec3_make(NAN, 0, 0);
    pliant::Bridge bridge(*stock.world, def);
    assert_int_equal(bridge.status(), PLI_ERROR_NOT_FINITE);
    assert_null(bridge.world());
    pli_body* body = nullptr;
    assert_int_equal(bridge.add_body(nullptr, nullptr, &body), PLI_ERROR_NOT_FINITE);
    assert_int_equal(bridge.remove_body(nullptr), PLI_ERROR_NOT_FINITE);
    assert_int_equal(bridge.step_status(), PLI_ERROR_NOT_FINITE);
    btRigidBody& box = stock.add_box(btVector3(1, 1, 1), 1, btVector3(0, 0, 0));
    assert_null(bridge.rigid(box));
    bridge.forget(box);
    bridge.refresh(box);
    stock.step(2);
    def = pliant::BridgeDef();
    for (const float thickness : {-1.0f, 0.0f, 2 * PLI_MAX_COORDINATE, INFINITY, NAN}) {
        def.surface_thickness = thickness;
        const pliant::Bridge refused(*stock.world, def);
        assert_int_equal(refused.status(), PLI_ERROR_INVALID_VALUE);
        assert_non_null(std::strstr(pli_last_error(refused.context()), "surface_thickness is "));
    }
}

static void test_the_bridge_may_use_a_context_of_the_game(void**) {
    pli_context* context = nullptr;
    assert_int_equal(pli_context_create(nullptr, &context), PLI_OK);
    const size_t before = pli_context_allocated_bytes(context);
    {
        StockWorld stock;
        pliant::BridgeDef def;
        def.context = context;
        pliant::Bridge bridge(*stock.world, def);
        assert_ptr_equal(bridge.context(), context);
        build_scene(stock, bridge);
        stock.step(30);
        assert_true(pli_context_allocated_bytes(context) > before);
    }
    assert_int_equal(pli_context_allocated_bytes(context), before);
    pli_context_destroy(context);
}

// What the core says goes into the status of the step; what is missing of a shape comes when there is memory again.
static void test_steps_without_memory_say_so_and_later_ones_make_up(void**) {
    constexpr int steps = 45;
    for (const auto mode : {pliant::CollisionMode::exact, pliant::CollisionMode::reference}) {
        std::vector<std::uint64_t> hashes;
        long places = 0;
        int reported = 0;
        float height = 0;
        for (long run = 0; run <= 2 * places; ++run) { // the first with enough memory
            failing_allocator allocator;
            pli_context* context = failing_context(&allocator);
            {
                StockWorld stock;
                pliant::BridgeDef def;
                def.context = context;
                def.mode = mode;
                pliant::Bridge bridge(*stock.world, def);
                pli_body* sheet = build_scene(stock, bridge);
                allocator.calls = 0;
                allocator.fail_at = (run + 1) / 2;
                allocator.fails_for_good = run % 2 == 0; // until it is told
                bool has_deviated = false;
                for (std::size_t step = 0; step < steps; ++step) {
                    const long before = allocator.failed;
                    stock.step(1);
                    if (bridge.step_status() != PLI_OK) {
                        assert_int_equal(bridge.step_status(), PLI_ERROR_OUT_OF_MEMORY);
                        assert_non_null(std::strstr(pli_last_error(context), "no memory"));
                        assert_true(allocator.failed != before);
                        has_deviated = true;
                        allocator.fail_at = 0;
                    }
                    const std::uint64_t hash = pli_body_state_hash(sheet);
                    if (run == 0) { hashes.push_back(hash); }
                    if (!has_deviated) { assert_int_equal(hash, hashes[step]); }
                }
                if (run == 0) {
                    places = allocator.calls;
                    height = center(sheet).y;
                }
                reported += has_deviated ? 1 : 0;
                check_near(center(sheet).y, height, 0.1);
            }
            pli_context_destroy(context);
            assert_int_equal(allocator.alive, 0);
        }
        print_message("           %d allocations, %d reported\n", static_cast<int>(places), reported);
        assert_true(reported >= 5);
    }
}

namespace {

// Hands ranges out backwards in small parts, and counts them.
struct CountingScheduler final : btITaskScheduler {
    CountingScheduler() : btITaskScheduler("counting") {}
    int getMaxNumThreads() const override { return 1; }
    int getNumThreads() const override { return 1; }
    void setNumThreads(int) override {}
    void parallelFor(int begin, int end, int grain, const btIParallelForBody& body) override {
        for (int part_end = end; part_end > begin; part_end -= grain) {
            body.forLoop(std::max(part_end - grain, begin), part_end);
            ++parts;
        }
    }
    btScalar parallelSum(int, int, int, const btIParallelSumBody&) override { return 0; }

    int parts = 0;
};

} // namespace

static void test_a_task_scheduler_of_bullet_gives_threads(void**) {
    CountingScheduler scheduler;
    std::uint64_t hashes[3];
    for (int variant = 0; variant < 3; ++variant) {
        pli_context_def context_def = pli_context_def_default();
        if (variant > 0) { context_def.parallel_for = pliant::bullet_parallel_for; }
        if (variant == 1) { context_def.parallel_user = static_cast<btITaskScheduler*>(&scheduler); }
        pli_context* context = nullptr;
        assert_int_equal(pli_context_create(&context_def, &context), PLI_OK);
        {
            StockWorld stock;
            pliant::BridgeDef def;
            def.context = context;
            pliant::Bridge bridge(*stock.world, def);
            pli_body* sheet = add_sheet(bridge, 2, 0.5f, 80);
            assert_int_equal(pli_body_enable_colored_links(sheet), PLI_OK);
            stock.step(3);
            hashes[variant] = pli_body_state_hash(sheet);
        }
        pli_context_destroy(context);
    }
    assert_true(scheduler.parts > 0);
    assert_true(hashes[1] == hashes[0] && hashes[2] == hashes[0]);
}

// Sheets on two floors of one shape, which Bullet lets one thread at a time read.
static void test_threads_share_a_gimpact_mesh(void**) {
    std::uint64_t hashes[2];
    for (int with_threads = 0; with_threads < 2; ++with_threads) {
        pli_threads* threads = nullptr;
        assert_int_equal(pli_threads_create(4, &threads), PLI_OK);
        pli_context_def context_def = pli_context_def_default();
        if (with_threads) { context_def.parallel_for = pli_threads_parallel_for; }
        context_def.parallel_user = threads;
        pli_context* context = nullptr;
        assert_int_equal(pli_context_create(&context_def, &context), PLI_OK);
        {
            btTriangleMesh mesh;
            for (int i = 0; i < 400; ++i) {
                const btVector3 a(btScalar(i % 20 - 10), 0, btScalar(i / 20 - 10)), x(1, 0, 0), z(0, 0, 1);
                mesh.addTriangle(a, a + x + z, a + x);
                mesh.addTriangle(a, a + z, a + x + z);
            }
            StockWorld stock;
            auto* shape = new btGImpactMeshShape(&mesh);
            shape->updateBound();
            stock.add_body(shape, 0, btVector3(0, 0, 0));
            btRigidBody other(0, nullptr, shape);
            other.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(-0.01), 0)));
            stock.world->addRigidBody(&other);
            pliant::BridgeDef def;
            def.context = context;
            pliant::Bridge bridge(*stock.world, def);
            for (int i = 0; i < 8; ++i) {
                assert_non_null(add_sheet(bridge, 2, 0.11f, 20, 0, 2.1f * static_cast<float>(i) - 7));
            }
            stock.step(30);
            assert_int_equal(bridge.step_status(), PLI_OK);
            hashes[with_threads] = 0;
            for (int i = 0; i < pli_world_body_count(bridge.world()); ++i) {
                const pli_body* sheet = pli_world_get_body(bridge.world(), i);
                hashes[with_threads] = 31 * hashes[with_threads] + pli_body_state_hash(sheet);
            }
            check_near(lowest(pli_world_get_body(bridge.world(), 0)), 0.1, 0.01);
            stock.world->removeRigidBody(&other);
        }
        pli_context_destroy(context);
        pli_threads_destroy(threads);
    }
    assert_true(hashes[0] == hashes[1]);
}

static void test_a_steady_step_allocates_nothing_in_the_core(void**) {
    StockWorld stock;
    stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    pliant::Bridge bridge(*stock.world);
    add_sheet(bridge, 1, 0.2f, 9);
    stock.step(60);
    const std::uint64_t before = pli_context_allocation_count(bridge.context());
    stock.step(60);
    assert_int_equal(pli_context_allocation_count(bridge.context()), before);
}

static void test_bridge_and_world_may_go_in_any_order(void**) {
    // The bridge first, in the middle of its contacts; the world goes on.
    {
        StockWorld stock;
        auto bridge = std::make_unique<pliant::Bridge>(*stock.world);
        build_scene(stock, *bridge);
        stock.step(30);
        bridge.reset();
        assert_int_equal(stock.world->getNumCollisionObjects(), 2);
        stock.step(30);
    }
    // The world first, after detach().
    {
        auto stock = std::make_unique<StockWorld>();
        pliant::Bridge bridge(*stock->world);
        pli_body* sheet = build_scene(*stock, bridge);
        stock->step(30);
        bridge.detach();
        stock.reset();
        assert_true(center(sheet).y < 0.8f);
        assert_int_equal(bridge.remove_body(sheet), PLI_OK);
    }
    // The world first, without a word: noticed as long as the bridge has a body in it.
    {
        auto stock = std::make_unique<StockWorld>();
        pliant::Bridge bridge(*stock->world);
        build_scene(*stock, bridge);
        stock->step(30);
        stock->world.reset();
        stock->world = std::make_unique<btDiscreteDynamicsWorld>(stock->dispatcher.get(), stock->broadphase.get(),
                                                                 stock->solver.get(), stock->configuration.get());
    }
}

// Debian's Bullet is built without threads; its classes for them run, and the bridge orders pairs as for threads.
static void test_a_parallel_dispatcher_works_and_is_deterministic(void**) {
    StockWorld serial;
    pliant::Bridge serial_bridge(*serial.world);
    pli_body* serial_sheet = build_scene(serial, serial_bridge);
    serial.step(90);

    btITaskScheduler* before = btGetTaskScheduler();
    btSetTaskScheduler(btGetSequentialTaskScheduler());
    std::uint64_t hashes[2];
    pli_vec3 centers[2];
    for (int i = 0; i < 2; ++i) {
        btConstraintSolverPoolMt pool(2);
        btSequentialImpulseConstraintSolverMt solver;
        StockWorld stock;
        stock.world.reset();
        stock.dispatcher = std::make_unique<btCollisionDispatcherMt>(stock.configuration.get());
        stock.world = std::make_unique<btDiscreteDynamicsWorldMt>(stock.dispatcher.get(), stock.broadphase.get(), &pool,
                                                                  &solver, stock.configuration.get());
        pliant::Bridge bridge(*stock.world);
        pli_body* sheet = build_scene(stock, bridge);
        stock.step(90);
        hashes[i] = bridge.step_status() == PLI_OK ? pli_body_state_hash(sheet) : 0;
        centers[i] = center(sheet);
    }
    btSetTaskScheduler(before);
    assert_int_not_equal(hashes[0], 0);
    assert_int_equal(hashes[0], hashes[1]);
    check_near(centers[0].y, center(serial_sheet).y, 0.1);
}

static void test_soft_bodies_fall_by_the_gravity_of_the_bullet_world(void**) {
    StockWorld stock;
    stock.world->setGravity(btVector3(0, btScalar(-1.6), 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1, 0, 3);
    stock.step(1);
    check_near(center(sheet).y, -1.6f * static_cast<float>(dt * dt), 1e-8);
    stock.world->setGravity(btVector3(0, btScalar(3.2), 0));
    stock.step(1);
    check_near(center(sheet).y, 0, 1e-8);
    // Bullet takes anything, and soft bodies keep what they had.
    stock.world->setGravity(btVector3(0, btScalar(1e30), 0));
    stock.step(1);
    assert_int_equal(bridge.step_status(), PLI_ERROR_INVALID_VALUE);
    check_near(pli_world_get_gravity(bridge.world()).y, 3.2f, 0);
    // The game's own.
    assert_int_equal(pli_world_set_gravity(bridge.world(), pli_vec3_make(0, -2, 0)), PLI_OK);
    stock.world->setGravity(btVector3(0, -10, 0));
    stock.step(1);
    check_near(pli_world_get_gravity(bridge.world()).y, -2, 0);
    pliant::BridgeDef def;
    def.gravity = pli_vec3_make(0, -3, 0);
    pliant::Bridge other(*stock.world, def);
    add_sheet(other, 1, 0, 3);
    stock.step(1);
    check_near(pli_world_get_gravity(other.world()).y, -3, 0);
}

static bool has_coloured_links(const pli_body* body) {
    pli_feature_cost features[32];
    const int count = pli_body_get_features(body, 32, features);
    return std::any_of(features, features + count,
                       [](const pli_feature_cost& each) { return std::strcmp(each.name, "colored links") == 0; });
}

static void test_links_are_coloured_outside_of_reference_mode(void**) {
    for (const auto mode : {pliant::CollisionMode::exact, pliant::CollisionMode::reference}) {
        StockWorld stock;
        pliant::BridgeDef def;
        def.mode = mode;
        pliant::Bridge bridge(*stock.world, def);
        pli_body* sheet = add_sheet(bridge, 1, 0, 9);
        assert_int_equal(has_coloured_links(sheet), mode == pliant::CollisionMode::exact);
        assert_int_equal(pli_body_disable_colored_links(sheet), PLI_OK);
        assert_false(has_coloured_links(sheet));
        stock.step(1);
        assert_int_equal(bridge.step_status(), PLI_OK);
    }
}

// A soft and a rigid body fall side by side, and are drawn between fixed steps.
// It meets the box after as many steps as it may wait, and takes each step from then on.
static void test_a_body_with_an_update_interval_carries_a_box(void**) {
    double heights[2];
    for (int run = 0; run < 2; ++run) {
        StockWorld stock;
        pliant::Bridge bridge(*stock.world);
        const int pins = PLI_PATCH_PIN_00 | PLI_PATCH_PIN_10 | PLI_PATCH_PIN_01 | PLI_PATCH_PIN_11;
        pli_body* sheet = bridge_test::add_sheet(bridge, 2, 0, 21, pins, 0, 0, 0.05f);
        assert_non_null(sheet);
        pli_solver_settings settings = pli_body_get_solver_settings(sheet);
        settings.position_iterations = 8;
        settings.velocity_damping = 0.01f;
        assert_int_equal(pli_body_set_solver_settings(sheet, &settings), PLI_OK);
        const btRigidBody& box = stock.add_box(btVector3(0.2f, 0.1f, 0.2f), 1, btVector3(0, 0.3f, 0));
        assert_int_equal(pli_body_set_update_interval(sheet, run == 0 ? 1 : 8), PLI_OK);
        stock.step(600);
        heights[run] = static_cast<double>(box.getWorldTransform().getOrigin().y());
    }
    check_near(heights[0], -0.63, 0.03);
    check_near(heights[1], heights[0], 0.03);
}

static void test_interpolated_bodies_fall_beside_motion_states(void**) {
    for (const bool is_late : {true, false}) {
        StockWorld stock;
        pliant::Bridge bridge(*stock.world);
        check_near(bridge.interpolation(), 1, 0);
        stock.world->setLatencyMotionStateInterpolation(is_late);
        btRigidBody& ball = stock.add_body(new btSphereShape(btScalar(0.1)), 1, btVector3(5, 0, 0));
        pli_body* sheet = add_sheet(bridge, 1, 0, 3);
        float drawn[3];
        pli_vertex_buffer_def buffer = pli_vertex_buffer_def_default();
        buffer.vertices = drawn;
        buffer.vertex_count = 1;
        buffer.stride = sizeof drawn;
        buffer.normal_offset = -1;
        float shares = 0;
        for (int i = 0; i < 24; ++i) {
            stock.world->stepSimulation(btScalar(1) / btScalar(144), 4, dt);
            const float share = bridge.interpolation() - (is_late ? 0.0f : 1.0f);
            assert_true(share >= 0 && share <= 1);
            shares += share;
            if (i < 4) { continue; }
            btTransform place;
            ball.getMotionState()->getWorldTransform(place);
            assert_int_equal(pli_body_write_vertices(sheet, &buffer, bridge.interpolation()), PLI_OK);
            check_near(drawn[1], place.getOrigin().y(), 1e-5);
        }
        check_near(shares / 24, 0.45, 0.1);
        // A clock that goes back, and one that is broken, take no step; what is drawn stays at its begin.
        for (const btScalar broken : {btScalar(-0.1), btScalar(NAN)}) {
            assert_int_equal(stock.world->stepSimulation(broken, 4, dt), 0);
            check_near(bridge.interpolation(), is_late ? 0 : 1, 0);
            assert_int_equal(pli_body_write_vertices(sheet, &buffer, bridge.interpolation()), PLI_OK);
        }
    }
}

int main() {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_free_fall_takes_one_step_per_internal_step),
        cmocka_unit_test(test_sub_steps_equal_single_steps),
        cmocka_unit_test(test_a_world_without_bodies_steps),
        cmocka_unit_test(test_bodies_come_and_go_between_steps),
        cmocka_unit_test(test_rigid_bodies_come_and_go_between_steps),
        cmocka_unit_test(test_an_inactive_object_does_not_move),
        cmocka_unit_test(test_two_worlds_do_not_touch),
        cmocka_unit_test(test_two_bridges_share_a_world),
        cmocka_unit_test(test_the_before_solve_hook_sees_contacts_and_end_of_step_poses),
        cmocka_unit_test(test_queries_between_steps_do_not_step),
        cmocka_unit_test(test_errors_are_reported_and_leave_nothing_behind),
        cmocka_unit_test(test_an_object_whose_basis_is_scaled_is_refused),
        cmocka_unit_test(test_a_bridge_with_a_bad_definition_answers_every_call),
        cmocka_unit_test(test_the_bridge_may_use_a_context_of_the_game),
        cmocka_unit_test(test_steps_without_memory_say_so_and_later_ones_make_up),
        cmocka_unit_test(test_a_task_scheduler_of_bullet_gives_threads),
        cmocka_unit_test(test_threads_share_a_gimpact_mesh),
        cmocka_unit_test(test_a_steady_step_allocates_nothing_in_the_core),
        cmocka_unit_test(test_bridge_and_world_may_go_in_any_order),
        cmocka_unit_test(test_a_parallel_dispatcher_works_and_is_deterministic),
        cmocka_unit_test(test_soft_bodies_fall_by_the_gravity_of_the_bullet_world),
        cmocka_unit_test(test_links_are_coloured_outside_of_reference_mode),
        cmocka_unit_test(test_a_body_with_an_update_interval_carries_a_box),
        cmocka_unit_test(test_interpolated_bodies_fall_beside_motion_states),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
