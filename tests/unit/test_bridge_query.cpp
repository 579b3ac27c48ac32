// What the stock world's queries and its debug drawing see of soft bodies.
#include "check.h"
#include "test_bridge_world.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <LinearMath/btIDebugDraw.h>

#include <cmath>
#include <limits>

using namespace bridge_test;

namespace {

class CountingDrawer final : public btIDebugDraw {
public:
    void drawLine(const btVector3&, const btVector3&, const btVector3&) override { ++lines; }
    void drawTriangle(const btVector3&, const btVector3&, const btVector3&, const btVector3&, btScalar) override {
        ++triangles;
    }
    void drawContactPoint(const btVector3&, const btVector3&, btScalar, int, const btVector3&) override {}
    void reportErrorWarning(const char*) override {}
    void draw3dText(const btVector3&, const char*) override {}
    void setDebugMode(int) override {}
    int getDebugMode() const override { return DBG_DrawWireframe; }

    int lines = 0, triangles = 0;
};

struct CountingContacts final : public btCollisionWorld::ContactResultCallback {
    btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) override {
        ++count;
        if (point.getDistance() < deepest) {
            deepest = point.getDistance();
            deepest_point = point;
        }
        return 0;
    }
    int count = 0;
    btScalar deepest = 1;
    btManifoldPoint deepest_point;
};

struct PairContacts {
    PairContacts(const StockWorld& stock, btCollisionObject& a, btCollisionObject& b) {
        stock.world->contactPairTest(&a, &b, of_pair);
        stock.world->contactPairTest(&b, &a, of_swapped_pair);
        stock.world->contactTest(&a, of_a);
        stock.world->contactTest(&b, of_b);
    }
    CountingContacts of_pair, of_swapped_pair, of_a, of_b;
};

} // namespace

static void test_a_ray_hits_a_sheet_where_it_is(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    pliant::BridgeDef def;
    def.gravity = pli_vec3_make(0, -10, 0);
    pliant::Bridge bridge(*stock.world, def);
    pli_body* sheet = add_sheet(bridge, 2, 0, 9);
    for (int i = 0; i < 3; ++i) {
        const btScalar height = btScalar(center(sheet).y);
        const btVector3 from(btScalar(0.3), 3, btScalar(0.2)), to(btScalar(0.3), -1, btScalar(0.2));
        for (const bool down : {true, false}) {
            btCollisionWorld::ClosestRayResultCallback hit(down ? from : to, down ? to : from);
            stock.world->rayTest(hit.m_rayFromWorld, hit.m_rayToWorld, hit);
            assert_true(hit.hasHit());
            assert_ptr_equal(bridge.body(hit.m_collisionObject), sheet);
            check_near(hit.m_closestHitFraction, (down ? 3 - height : height + 1) / 4, 1e-6);
            // The normal looks back along the ray.
            check_near(hit.m_hitNormalWorld.y(), down ? 1 : -1, 1e-6);
        }
        stock.step(7);
    }
    const btVector3 past(btScalar(1.2), 3, 0), below(btScalar(1.2), -3, 0);
    btCollisionWorld::ClosestRayResultCallback miss(past, below);
    stock.world->rayTest(past, below, miss);
    assert_false(miss.hasHit());
}

static void test_a_ray_names_the_face(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 2, 0, 5);
    struct Faces final : btCollisionWorld::ClosestRayResultCallback {
        using ClosestRayResultCallback::ClosestRayResultCallback;
        btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool in_world) override {
            face = result.m_localShapeInfo->m_triangleIndex;
            return ClosestRayResultCallback::addSingleResult(result, in_world);
        }
        int face = -1;
    };
    const pli_body_view view = pli_body_get_view(sheet);
    for (int f = 0; f < view.face_count; ++f) {
        btVector3 middle(0, 0, 0);
        for (int i = 0; i < 3; ++i) {
            const pli_vec4& p = view.positions[view.face_nodes[3 * f + i]];
            middle += btVector3(btScalar(p.x), btScalar(p.y), btScalar(p.z)) / 3;
        }
        Faces hit(middle + btVector3(0, 1, 0), middle - btVector3(0, 1, 0));
        stock.world->rayTest(hit.m_rayFromWorld, hit.m_rayToWorld, hit);
        assert_int_equal(hit.face, f);
    }
}

static void test_a_sweep_stops_at_a_sheet(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 2, 0, 5, 0, 0, 0, 0.05f);
    btSphereShape ball(btScalar(0.25));
    const btVector3 from(0, 2, 0), to(0, -2, 0);
    btCollisionWorld::ClosestConvexResultCallback hit(from, to);
    const btQuaternion none = btQuaternion::getIdentity();
    stock.world->convexSweepTest(&ball, btTransform(none, from), btTransform(none, to), hit);
    assert_true(hit.hasHit());
    assert_ptr_equal(bridge.body(hit.m_hitCollisionObject), sheet);
    // The centre of the ball stops at its radius and the sheet's margin.
    check_near(2 - 4 * hit.m_closestHitFraction, 0.3, 0.01);
}

// From (-1, 0, 0) to (1, 0, 0), with a margin.
static pli_body* add_rope(pliant::Bridge& bridge, float margin) {
    pli_mesh* mesh = nullptr;
    pli_body* rope = nullptr;
    const pli_vec3 from = pli_vec3_make(-1, 0, 0), to = pli_vec3_make(1, 0, 0);
    assert_int_equal(pli_mesh_create_rope(bridge.context(), from, to, 3, 0, &mesh), PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.collision_margin = margin;
    assert_int_equal(bridge.add_body(mesh, &def, &rope), PLI_OK);
    pli_mesh_destroy(mesh);
    return rope;
}

// As capsules: beside the middle line the surface is lower, beyond the end it is round.
static void test_rays_hit_a_rope(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* rope = add_rope(bridge, 0.05f);
    const struct {
        double x, z, height; // of the surface; 0: none
    } rays[] = {{0.3, 0, 0.05}, {-0.7, 0.03, 0.04}, {0.3, 0.051, 0}, {1.03, 0, 0.04}, {1.06, 0, 0}};
    for (const auto& ray : rays) {
        const btVector3 from(btScalar(ray.x), 1, btScalar(ray.z)), to(btScalar(ray.x), -1, btScalar(ray.z));
        btCollisionWorld::ClosestRayResultCallback hit(from, to);
        stock.world->rayTest(from, to, hit);
        assert_true(hit.hasHit() == (ray.height > 0));
        if (!hit.hasHit()) { continue; }
        assert_ptr_equal(bridge.body(hit.m_collisionObject), rope);
        check_near(1 - 2 * hit.m_closestHitFraction, ray.height, 1e-5);
        check_near(hit.m_hitNormalWorld.y(), ray.height / 0.05, 1e-4);
    }
    // The nearest counts, whatever else is there.
    stock.add_body(new btBoxShape(btVector3(2, btScalar(0.01), 2)), 0, btVector3(0, btScalar(0.2), 0));
    btCollisionWorld::ClosestRayResultCallback above(btVector3(0, 1, 0), btVector3(0, -1, 0));
    stock.world->rayTest(above.m_rayFromWorld, above.m_rayToWorld, above);
    assert_null(bridge.body(above.m_collisionObject));
    btCollisionWorld::ClosestRayResultCallback below(btVector3(0, -1, 0), btVector3(0, 1, 0));
    stock.world->rayTest(below.m_rayFromWorld, below.m_rayToWorld, below);
    assert_ptr_equal(bridge.body(below.m_collisionObject), rope);
    check_near(2 * below.m_closestHitFraction, 0.95, 1e-5);
}

static void test_sweeps_stop_at_a_rope(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* rope = add_rope(bridge, 0.05f);
    btSphereShape ball(btScalar(0.25));
    btBoxShape box(btVector3(btScalar(0.2), btScalar(0.25), btScalar(0.2)));
    const btQuaternion none = btQuaternion::getIdentity();
    for (const btConvexShape* shape : {static_cast<btConvexShape*>(&ball), static_cast<btConvexShape*>(&box)}) {
        for (const double x : {-0.6, 0.1}) {
            const btVector3 from(btScalar(x), 2, 0), to(btScalar(x), -2, 0);
            btCollisionWorld::ClosestConvexResultCallback hit(from, to);
            stock.world->convexSweepTest(shape, btTransform(none, from), btTransform(none, to), hit);
            assert_true(hit.hasHit());
            assert_ptr_equal(bridge.body(hit.m_hitCollisionObject), rope);
            check_near(2 - 4 * hit.m_closestHitFraction, 0.3, 0.01);
            check_near(hit.m_hitNormalWorld.y(), 1, 1e-3);
        }
    }
    const btVector3 from(0, 2, btScalar(0.4)), to(0, -2, btScalar(0.4));
    btCollisionWorld::ClosestConvexResultCallback miss(from, to);
    stock.world->convexSweepTest(&ball, btTransform(none, from), btTransform(none, to), miss);
    assert_false(miss.hasHit());
}

static void test_contact_tests_find_a_sheet(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 2, 0, 5, 0, 0, 0, 0.05f);
    btCollisionObject& object = *bridge.object(sheet);
    btRigidBody& ball = stock.add_body(new btSphereShape(btScalar(0.25)), 1, btVector3(0, btScalar(0.23), 0));

    const PairContacts contacts(stock, object, ball);
    for (const CountingContacts* each :
         {&contacts.of_pair, &contacts.of_swapped_pair, &contacts.of_a, &contacts.of_b}) {
        assert_true(each->count > 0);
        check_near(each->deepest, 0.23 - 0.25 - 0.05, 1e-3);
    }
    // The normal looks from the second object to the first, on which the point A is.
    const btManifoldPoint &of_pair = contacts.of_pair.deepest_point, &swapped = contacts.of_swapped_pair.deepest_point;
    check_near(of_pair.m_normalWorldOnB.y(), -1, 1e-3);
    check_near(of_pair.getPositionWorldOnA().y(), 0.05, 1e-3);
    check_near(of_pair.getPositionWorldOnB().y(), -0.02, 1e-3);
    check_near(swapped.m_normalWorldOnB.y(), 1, 1e-3);
    check_near(swapped.getPositionWorldOnB().y(), 0.05, 1e-3);
    // Its index is that of a face near the middle.
    const pli_body_view view = pli_body_get_view(sheet);
    assert_in_range(of_pair.m_index0, 0, view.face_count - 1);
    assert_int_equal(of_pair.m_index0, swapped.m_index1);
    for (int i = 0; i < 3; ++i) {
        const pli_vec4& p = view.positions[view.face_nodes[3 * of_pair.m_index0 + i]];
        check_at_most(std::hypot(double(p.x), double(p.z)), 0.75);
    }
    // Nothing out of reach.
    ball.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(0.33), 0)));
    const PairContacts apart(stock, object, ball);
    assert_int_equal(apart.of_pair.count + apart.of_swapped_pair.count + apart.of_a.count, 0);
    // A game may look further.
    CountingContacts far;
    far.m_closestDistanceThreshold = btScalar(0.1);
    stock.world->contactPairTest(&object, &ball, far);
    check_near(far.deepest, 0.03, 1e-3);
}

// A game that knows no other way to move an object.
static void test_the_transform_of_a_soft_object_moves_the_body(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 2, 0, 5, 0, 0, 0, 0.05f);
    btCollisionObject& object = *bridge.object(sheet);
    btRigidBody& ball = stock.add_body(new btSphereShape(btScalar(0.25)), 0, btVector3(3, btScalar(1.23), 0));
    stock.step(2);
    assert_int_equal(pli_body_add_velocity(sheet, pli_vec3_make(1, 0, 0)), PLI_OK);
    const btTransform moved(btQuaternion(btVector3(0, 1, 0), SIMD_HALF_PI), btVector3(3, 1, 0));
    object.setWorldTransform(moved);
    stock.world->updateSingleAabb(&object); // as for any object that is moved between steps
    const auto height_under = [&](double x) {
        const btVector3 from(btScalar(x), 4, btScalar(0.1)), to(btScalar(x), -4, btScalar(0.1));
        btCollisionWorld::ClosestRayResultCallback hit(from, to);
        stock.world->rayTest(from, to, hit);
        const bool is_hit = hit.hasHit() && bridge.body(hit.m_collisionObject) == sheet;
        return is_hit ? 4 - 8 * double(hit.m_closestHitFraction) : -9;
    };
    const PairContacts contacts(stock, object, ball);
    check_near(contacts.of_pair.deepest, 0.23 - 0.25 - 0.05, 1e-3);
    stock.world->removeRigidBody(&ball);
    for (int i = 0; i < 3; ++i) {
        check_near(height_under(2.2), 1, 1e-5);
        check_near(height_under(0), -9, 0);
        stock.step(1);
        assert_true(object.getWorldTransform() == btTransform::getIdentity());
        assert_int_equal(bridge.step_status(), PLI_OK);
    }
    check_near(center(sheet).x, 3, 1e-5);
    check_near(center(sheet).z, -3.0 / 60, 1e-5); // velocities turn with it
    check_near(pli_body_momentum(sheet).z, -1, 1e-4);

    // What cannot be is put back.
    const btScalar nowhere = std::numeric_limits<btScalar>::quiet_NaN();
    object.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(nowhere, 0, 0)));
    stock.step(1);
    assert_int_equal(bridge.step_status(), PLI_ERROR_NOT_FINITE);
    assert_true(object.getWorldTransform() == btTransform::getIdentity());
    check_near(height_under(2.2), 1, 1e-5);
}

// ------------------------------------------------------------------------------------------------- resting contacts

namespace {

struct Ground {
    const char* name;
    btScalar height; ///< of the place of the shape whose top is at 0
    std::unique_ptr<btCollisionShape> (*make)();
};

template <typename Shape, typename... Args> std::unique_ptr<btCollisionShape> made(Args... args) {
    return std::make_unique<Shape>(args...);
}

btTriangleMesh& ground_triangles() {
    static btTriangleMesh mesh;
    if (mesh.getNumTriangles() == 0) {
        const btVector3 a(-2, 0, -2), b(2, 0, -2), c(-2, 0, 2), d(2, 0, 2);
        mesh.addTriangle(a, c, b);
        mesh.addTriangle(b, c, d);
    }
    return mesh;
}

/// With children of its own.
struct Compound final : btCompoundShape {
    Compound() {
        for (const btScalar x : {btScalar(-1), btScalar(1)}) {
            addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(x, 0, 0)), &child);
        }
    }
    btBoxShape child{btVector3(1, 1, 2)};
};

const float flat_heights[64] = {};

const Ground grounds[] = {
    {"box", -1, [] { return made<btBoxShape>(btVector3(2, 1, 2)); }},
    {"sphere", -2, [] { return made<btSphereShape>(btScalar(2)); }},
    {"capsule", -1, [] { return made<btCapsuleShapeX>(btScalar(1), btScalar(4)); }},
    {"cylinder", -1, [] { return made<btCylinderShape>(btVector3(2, 1, 2)); }},
    {"cone", btScalar(-0.5), [] { return made<btConeShape>(btScalar(3), btScalar(1)); }},
    {"hull", -1,
     [] {
         auto hull = std::make_unique<btConvexHullShape>();
         for (int i = 0; i < 8; ++i) {
             hull->addPoint(btVector3((i & 1) != 0 ? 2 : -2, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 2 : -2));
         }
         return std::unique_ptr<btCollisionShape>(std::move(hull));
     }},
    {"plane", 0, [] { return made<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)); }},
    {"mesh", 0, [] { return made<btBvhTriangleMeshShape>(&ground_triangles(), true); }},
    {"heightfield", 0,
     [] { return made<btHeightfieldTerrainShape>(8, 8, flat_heights, btScalar(-1), btScalar(1), 1, false); }},
    {"compound", -1, [] { return made<Compound>(); }},
};

} // namespace

// What lies still is told in each step, by each test, in both orders.
static void test_contact_tests_tell_resting_contacts_in_every_step(void**) {
    for (const Ground& ground : grounds) {
        for (const bool is_rope : {false, true}) {
            StockWorld stock;
            pliant::Bridge bridge(*stock.world);
            btRigidBody& rigid = stock.add_body(ground.make().release(), 0, btVector3(0, ground.height, 0));
            pli_body* body = is_rope ? add_rope(bridge, 0.05f) : add_sheet(bridge, 1.5f, 0.15f, 9, 0, 0, 0, 0.02f);
            if (is_rope) {
                const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
                assert_int_equal(pli_body_enable_rigid_contacts(body, &contacts), PLI_OK);
                assert_int_equal(pli_body_transform(body, {pli_mat3_identity(), pli_vec3_make(0, 0.1f, 0)}), PLI_OK);
            }
            stock.step(60);
            int steps_in_core = 0, steps_told = 0;
            for (int i = 0; i < 99; ++i) {
                stock.step(1);
                steps_in_core += pli_body_get_rigid_contacts(body, 0, nullptr) > 0 ? 1 : 0;
                const PairContacts contacts(stock, *bridge.object(body), rigid);
                bool is_told = true;
                for (const CountingContacts* each :
                     {&contacts.of_pair, &contacts.of_swapped_pair, &contacts.of_a, &contacts.of_b}) {
                    is_told = is_told && each->count > 0 && each->deepest < btScalar(1e-3);
                }
                steps_told += is_told ? 1 : 0;
            }
            if (steps_in_core != 99 || steps_told != 99) {
                fail_msg("%s on a %s: contacts in %d of 99 steps, told in %d", is_rope ? "rope" : "sheet", ground.name,
                         steps_in_core, steps_told);
            }
        }
    }
}

static void test_contact_tests_find_soft_bodies_on_each_other(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 2, 0, 5, 0, 0, 0, 0.05f);
    pli_body* other = add_sheet(bridge, 1, 0.08f, 4, 0, 0, 0, 0.02f);
    pli_body* rope = add_rope(bridge, 0.05f);
    stock.step(1); // the broad phase gives bounds some room in a step only
    const PairContacts sheets(stock, *bridge.object(sheet), *bridge.object(other));
    for (const CountingContacts* each : {&sheets.of_pair, &sheets.of_swapped_pair, &sheets.of_a, &sheets.of_b}) {
        assert_true(each->count > 0);
    }
    check_near(sheets.of_pair.deepest, 0.08 - 0.05 - 0.02, 1e-3);
    const PairContacts rope_on_sheet(stock, *bridge.object(rope), *bridge.object(sheet));
    check_near(rope_on_sheet.of_pair.deepest, -0.1, 1e-3);
    check_near(rope_on_sheet.of_swapped_pair.deepest, -0.1, 1e-3);
}

static void test_debug_drawing_shows_faces_and_ropes(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    CountingDrawer drawer;
    stock.world->setDebugDrawer(&drawer);
    pli_body* sheet = add_sheet(bridge, 2, 0, 5);
    stock.world->debugDrawWorld();
    assert_int_equal(drawer.triangles, pli_body_get_view(sheet).face_count);
    assert_int_equal(bridge.remove_body(sheet), PLI_OK);

    pli_mesh* mesh = nullptr;
    const pli_vec3 from = pli_vec3_make(0, 0, 0), to = pli_vec3_make(1, 0, 0);
    assert_int_equal(pli_mesh_create_rope(bridge.context(), from, to, 8, 0, &mesh), PLI_OK);
    pli_body* rope = nullptr;
    assert_int_equal(bridge.add_body(mesh, nullptr, &rope), PLI_OK);
    pli_mesh_destroy(mesh);
    drawer.lines = drawer.triangles = 0;
    stock.world->debugDrawWorld();
    assert_int_equal(drawer.triangles, 0);
    assert_true(drawer.lines >= 9);
    stock.world->setDebugDrawer(nullptr);
}

static void test_the_collision_object_belongs_to_the_game(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 2, 0, 5);
    btCollisionObject* object = bridge.object(sheet);
    assert_null(object->getUserPointer());
    assert_int_equal(object->getUserIndex(), -1);
    object->setUserPointer(&stock);
    stock.step(2);
    assert_ptr_equal(object->getUserPointer(), &stock);
    // The margin of the shape is that of the body.
    check_near(object->getCollisionShape()->getMargin(), 0.1, 1e-7);
    object->getCollisionShape()->setMargin(btScalar(0.2));
    check_near(pli_body_get_collision_margin(sheet), 0.2, 1e-7);
    // Bounds: the nodes grown by the margin, and 0.02 m more in the broad phase.
    btVector3 low, high;
    stock.broadphase->getAabb(object->getBroadphaseHandle(), low, high);
    check_near(high.x() - low.x(), 2.24, 0.01);
}

int main() {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_ray_hits_a_sheet_where_it_is),
        cmocka_unit_test(test_a_ray_names_the_face),
        cmocka_unit_test(test_a_sweep_stops_at_a_sheet),
        cmocka_unit_test(test_rays_hit_a_rope),
        cmocka_unit_test(test_sweeps_stop_at_a_rope),
        cmocka_unit_test(test_contact_tests_find_a_sheet),
        cmocka_unit_test(test_the_transform_of_a_soft_object_moves_the_body),
        cmocka_unit_test(test_contact_tests_tell_resting_contacts_in_every_step),
        cmocka_unit_test(test_contact_tests_find_soft_bodies_on_each_other),
        cmocka_unit_test(test_debug_drawing_shows_faces_and_ropes),
        cmocka_unit_test(test_the_collision_object_belongs_to_the_game),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
