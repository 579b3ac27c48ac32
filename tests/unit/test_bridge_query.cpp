// What the stock world's queries and its debug drawing see of soft bodies.
#include "check.h"
#include "test_bridge_world.h"

#include <LinearMath/btIDebugDraw.h>

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
        deepest = std::min(deepest, point.getDistance());
        return 0;
    }
    int count = 0;
    btScalar deepest = 0;
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
    // Between spheres and triangles Bullet takes no account of the triangles' margin.
    btRigidBody& ball = stock.add_body(new btSphereShape(btScalar(0.25)), 1, btVector3(0, btScalar(0.23), 0));

    CountingContacts of_ball, of_sheet, of_pair, of_swapped_pair;
    stock.world->contactTest(&ball, of_ball);
    assert_true(of_ball.count > 0);
    check_near(of_ball.deepest, -0.02, 1e-3);
    stock.world->contactTest(&object, of_sheet);
    assert_true(of_sheet.count > 0);
    stock.world->contactPairTest(&ball, &object, of_pair);
    assert_true(of_pair.count > 0);
    check_near(of_pair.deepest, -0.02, 1e-3);
    stock.world->contactPairTest(&object, &ball, of_swapped_pair);
    assert_true(of_swapped_pair.count > 0);
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
        cmocka_unit_test(test_debug_drawing_shows_faces_and_ropes),
        cmocka_unit_test(test_the_collision_object_belongs_to_the_game),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
