// A sheet of cloth and the rigid shapes of a stock Bullet world.
#include "check.h"
#include "test_bridge_world.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btSdfCollisionShape.h>

#include <functional>

using namespace bridge_test;

namespace {

constexpr float margin = 0.1f;

// Rests a sheet of 1.6 m on whatever `build` puts below the height 0, and returns it. Its nodes over a flat top come to
// rest at the margin.
struct Rest {
    float low, high;
};

Rest rest_on(const std::function<void(StockWorld&)>& build, pliant::CollisionMode mode = pliant::CollisionMode::exact) {
    StockWorld stock;
    build(stock);
    pliant::BridgeDef def;
    def.mode = mode;
    pliant::Bridge bridge(*stock.world, def);
    assert_int_equal(bridge.status(), PLI_OK);
    pli_body* sheet = add_sheet(bridge, 1.6f, 0.5f, 7, 0, 0, 0, margin);
    assert_non_null(sheet);
    stock.step(300);
    assert_int_equal(bridge.step_status(), PLI_OK);
    assert_false(pli_body_is_frozen(sheet));
    return {lowest(sheet), highest(sheet)};
}

void check_rests_at(Rest rest, float height) {
    check_near(rest.low, height, 0.012);
    check_near(rest.high, height, 0.012);
}

// 8 x 8 m in cells of 1 m at height 0.
std::unique_ptr<btTriangleMesh> make_floor_mesh() {
    auto mesh = std::make_unique<btTriangleMesh>();
    for (int x = -4; x < 4; ++x) {
        for (int z = -4; z < 4; ++z) {
            const btVector3 a(btScalar(x), 0, btScalar(z)), b(btScalar(x + 1), 0, btScalar(z));
            const btVector3 c(btScalar(x), 0, btScalar(z + 1)), d(btScalar(x + 1), 0, btScalar(z + 1));
            mesh->addTriangle(a, c, b);
            mesh->addTriangle(b, c, d);
        }
    }
    return mesh;
}

} // namespace

static void test_a_sheet_rests_on_a_box(void**) {
    check_rests_at(rest_on([](StockWorld& w) { w.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0)); }), margin);
}

static void test_a_sheet_rests_on_a_turned_box(void**) {
    const btQuaternion quarter(btVector3(1, 0, 0), SIMD_HALF_PI);
    check_rests_at(rest_on([&](StockWorld& w) { w.add_box(btVector3(5, 5, 1), 0, btVector3(0, -1, 0), quarter); }),
                   margin);
}

static void test_a_sheet_rests_on_a_plane(void**) {
    check_rests_at(rest_on([](StockWorld& w) {
                       w.add_body(new btStaticPlaneShape(btVector3(0, 1, 0), -2), 0, btVector3(0, 2, 0));
                   }),
                   margin);
}

static void test_a_sheet_rests_on_a_triangle_mesh(void**) {
    const auto mesh = make_floor_mesh();
    check_rests_at(rest_on([&](StockWorld& w) {
                       w.add_body(new btBvhTriangleMeshShape(mesh.get(), true), 0, btVector3(0, 0, 0));
                   }),
                   margin);
}

static void test_a_sheet_rests_on_a_scaled_triangle_mesh(void**) {
    const auto mesh = make_floor_mesh();
    btBvhTriangleMeshShape source(mesh.get(), true);
    check_rests_at(rest_on([&](StockWorld& w) {
                       w.add_body(new btScaledBvhTriangleMeshShape(&source, btVector3(2, 2, 2)), 0, btVector3(0, 0, 0));
                   }),
                   margin);
}

static void test_a_sheet_rests_on_a_heightfield(void**) {
    std::vector<float> heights(9 * 9, 3.0f);
    // Bullet puts the middle of the range of heights at the origin.
    check_rests_at(rest_on([&](StockWorld& w) {
                       w.add_body(
                           new btHeightfieldTerrainShape(9, 9, heights.data(), btScalar(0), btScalar(4), 1, false), 0,
                           btVector3(0, -1, 0));
                   }),
                   margin);
}

// Bullet turns the triangles of the three axes to different sides, and a game may turn them over.
static void test_a_heightfield_is_met_from_above_along_each_axis(void**) {
    const std::vector<float> heights(9 * 9, 3.0f);
    for (int variant = 0; variant < 6; ++variant) {
        const int up = variant % 3;
        const btVector3 axes[3] = {btVector3(1, 0, 0), btVector3(0, 1, 0), btVector3(0, 0, 1)};
        const btVector3 y(0, 1, 0);
        const btQuaternion turn = shortestArcQuat(axes[up], y);
        check_rests_at(rest_on([&](StockWorld& w) {
                           auto* shape =
                               new btHeightfieldTerrainShape(9, 9, heights.data(), btScalar(0), btScalar(4), up, false);
                           shape->setFlipTriangleWinding(variant >= 3);
                           w.add_body(shape, 0, -y, turn);
                       }),
                       margin);
    }
}

static void test_a_sheet_rests_on_a_convex_hull(void**) {
    // Bullet adds the margin of a hull outside.
    check_rests_at(rest_on([](StockWorld& w) {
                       auto* hull = new btConvexHullShape;
                       for (int i = 0; i < 8; ++i) {
                           hull->addPoint(btVector3((i & 1) ? 3 : -3, (i & 2) ? 0 : -1, (i & 4) ? 3 : -3));
                       }
                       hull->setMargin(btScalar(0.05));
                       w.add_body(hull, 0, btVector3(0, btScalar(-0.05), 0));
                   }),
                   margin);
}

static void test_a_sheet_rests_on_a_cylinder(void**) {
    check_rests_at(
        rest_on([](StockWorld& w) { w.add_body(new btCylinderShape(btVector3(3, 1, 3)), 0, btVector3(0, -1, 0)); }),
        margin);
    const btQuaternion turn(btVector3(0, 0, 1), SIMD_HALF_PI);
    check_rests_at(rest_on([&](StockWorld& w) {
                       w.add_body(new btCylinderShapeX(btVector3(1, 3, 3)), 0, btVector3(0, -1, 0), turn);
                   }),
                   margin);
}

// The top of a shape with a single highest point holds the middle of the sheet.
static void test_a_sheet_drapes_over_round_shapes(void**) {
    const std::function<btCollisionShape*()> shapes[] = {
        [] { return new btSphereShape(1); },
        [] { return new btCapsuleShape(btScalar(0.5), 1); },
        [] {
            return new btMultiSphereShape(std::vector<btVector3>{btVector3(0, btScalar(0.5), 0)}.data(),
                                          std::vector<btScalar>{btScalar(0.5)}.data(), 1);
        },
    };
    for (const auto& make : shapes) {
        const Rest rest = rest_on([&](StockWorld& w) { w.add_body(make(), 0, btVector3(0, -1, 0)).setFriction(4); });
        // The few contacts carry the whole sheet and give way, with a hardness of 0.1.
        check_near(rest.high, margin, 0.06);
        assert_true(rest.low < -0.2f);
    }
}

static void test_a_sheet_rests_on_a_compound(void**) {
    check_rests_at(rest_on([](StockWorld& w) {
                       auto* compound = new btCompoundShape;
                       auto* inner = new btCompoundShape;
                       btCollisionShape* left = new btBoxShape(btVector3(1, 1, 2));
                       btCollisionShape* right = new btBoxShape(btVector3(1, btScalar(0.5), 2));
                       w.shapes.emplace_back(left);
                       w.shapes.emplace_back(right);
                       w.shapes.emplace_back(inner);
                       const btQuaternion none = btQuaternion::getIdentity();
                       inner->addChildShape(btTransform(none, btVector3(0, btScalar(0.5), 0)), right);
                       compound->addChildShape(btTransform(none, btVector3(-1, 0, 0)), left);
                       compound->addChildShape(btTransform(none, btVector3(1, 0, 0)), inner);
                       w.add_body(compound, 0, btVector3(0, -1, 0));
                   }),
                   margin);
}

// Bullet's lattice of 0.25 m, sampled at multiples of the voxel size, meets a face at a multiple exactly.
static void test_reference_mode_rests_on_a_box(void**) {
    check_rests_at(rest_on([](StockWorld& w) { w.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0)); },
                           pliant::CollisionMode::reference),
                   margin);
}

static void test_an_edited_shape_is_noticed(void**) {
    StockWorld stock;
    btRigidBody& box = stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1.6f, 0.3f, 7);
    stock.step(200);
    check_near(lowest(sheet), 0.1, 0.01);
    // Half as high: the sheet falls by half a metre.
    box.getCollisionShape()->setLocalScaling(btVector3(1, btScalar(0.5), 1));
    stock.world->updateSingleAabb(&box);
    stock.step(200);
    check_near(lowest(sheet), -0.4, 0.01);
}

static void test_an_empty_shape_and_a_shape_of_no_size_are_passed_through(void**) {
    StockWorld stock;
    stock.add_body(new btEmptyShape, 0, btVector3(0, 0, 0));
    stock.add_body(new btSphereShape(0), 0, btVector3(0, 0, 0));
    stock.add_body(new btCompoundShape, 0, btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1.6f, 0.2f, 7);
    stock.step(60);
    assert_true(highest(sheet) < -4);
}

// It is no error either that a shape yields no triangles.
static void test_a_shape_without_triangles_is_passed_through(void**) {
    StockWorld stock;
    stock.add_body(new btSdfCollisionShape, 0, btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1.6f, 0.01f, 7);
    for (int i = 0; i < 60; ++i) {
        stock.step(1);
        assert_int_equal(bridge.step_status(), PLI_OK);
    }
    assert_true(highest(sheet) < -4);
}

int main() {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_sheet_rests_on_a_box),
        cmocka_unit_test(test_a_sheet_rests_on_a_turned_box),
        cmocka_unit_test(test_a_sheet_rests_on_a_plane),
        cmocka_unit_test(test_a_sheet_rests_on_a_triangle_mesh),
        cmocka_unit_test(test_a_sheet_rests_on_a_scaled_triangle_mesh),
        cmocka_unit_test(test_a_sheet_rests_on_a_heightfield),
        cmocka_unit_test(test_a_heightfield_is_met_from_above_along_each_axis),
        cmocka_unit_test(test_a_sheet_rests_on_a_convex_hull),
        cmocka_unit_test(test_a_sheet_rests_on_a_cylinder),
        cmocka_unit_test(test_a_sheet_drapes_over_round_shapes),
        cmocka_unit_test(test_a_sheet_rests_on_a_compound),
        cmocka_unit_test(test_reference_mode_rests_on_a_box),
        cmocka_unit_test(test_an_edited_shape_is_noticed),
        cmocka_unit_test(test_an_empty_shape_and_a_shape_of_no_size_are_passed_through),
        cmocka_unit_test(test_a_shape_without_triangles_is_passed_through),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
