// Vehicles and characters among soft bodies: wheels keep the ground, sweeps see what they are to see.
#include "check.h"
#include "test_bridge_world.h"

#include <pliant_bullet/vehicle_raycaster.h>

#include <functional>

using namespace bridge_test;

namespace {

constexpr int soft_group = 64;
constexpr float cloth_height = 0.04f, cloth_margin = 0.03f; // m
constexpr btScalar wheel_radius = btScalar(0.3);

struct Drive {
    int steps_without_ground = 0; // of wheels
    btScalar way = 0;             // m
    btScalar highest_contact = 0;
};

// Over a floor with a cloth of 3 m on it, which begins 2 m ahead.
Drive drive(const std::function<std::unique_ptr<btVehicleRaycaster>(btDynamicsWorld&)>& make_raycaster) {
    StockWorld stock;
    stock.add_box(btVector3(50, 1, 50), 0, btVector3(0, -1, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* cloth = add_sheet(bridge, 3, cloth_height, 25, 0, 0, 4.5f, cloth_margin);
    assert_non_null(cloth);

    btRigidBody& chassis =
        stock.add_box(btVector3(btScalar(0.6), btScalar(0.2), btScalar(1)), 400, btVector3(0, btScalar(0.9), 0));
    chassis.setActivationState(DISABLE_DEACTIVATION);
    const std::unique_ptr<btVehicleRaycaster> raycaster = make_raycaster(*stock.world);
    btRaycastVehicle::btVehicleTuning tuning;
    tuning.m_suspensionStiffness = 40;
    btRaycastVehicle vehicle(tuning, &chassis, raycaster.get());
    vehicle.setCoordinateSystem(0, 1, 2);
    for (int i = 0; i < 4; ++i) {
        const btVector3 place(btScalar(i % 2 == 0 ? -0.6 : 0.6), 0, btScalar(i / 2 == 0 ? 0.8 : -0.8));
        vehicle.addWheel(place, btVector3(0, -1, 0), btVector3(-1, 0, 0), btScalar(0.4), wheel_radius, tuning, i < 2);
    }
    stock.world->addVehicle(&vehicle);
    stock.step(60);
    const btScalar start = chassis.getWorldTransform().getOrigin().z();
    Drive drive;
    for (int i = 0; i < 240; ++i) {
        for (int wheel = 0; wheel < 4; ++wheel) {
            vehicle.applyEngineForce(200, wheel);
        }
        stock.step(1);
        for (int wheel = 0; wheel < 4; ++wheel) {
            const auto& info = vehicle.getWheelInfo(wheel).m_raycastInfo;
            if (!info.m_isInContact) {
                ++drive.steps_without_ground;
            } else {
                drive.highest_contact = std::max(drive.highest_contact, info.m_contactPointWS.y());
            }
        }
    }
    drive.way = chassis.getWorldTransform().getOrigin().z() - start;
    stock.world->removeVehicle(&vehicle);
    return drive;
}

Drive drive_with(pliant::VehicleRaycaster::SoftBodies soft_bodies) {
    return drive([soft_bodies](btDynamicsWorld& world) {
        return std::make_unique<pliant::VehicleRaycaster>(world, soft_bodies);
    });
}

} // namespace

static void test_wheels_keep_the_ground_below_a_cloth(void**) {
    const Drive seen = drive_with(pliant::VehicleRaycaster::SoftBodies::ignored);
    assert_int_equal(seen.steps_without_ground, 0);
    assert_true(seen.way > 8);
    check_near(seen.highest_contact, 0, 0.005);
    // Bullet's own loses it, which is what this one is for.
    const Drive lost =
        drive([](btDynamicsWorld& world) { return std::make_unique<btDefaultVehicleRaycaster>(&world); });
    assert_true(lost.steps_without_ground > 20);
}

static void test_wheels_roll_on_a_cloth(void**) {
    const Drive seen = drive_with(pliant::VehicleRaycaster::SoftBodies::ground);
    assert_int_equal(seen.steps_without_ground, 0);
    assert_true(seen.way > 8);
    check_near(seen.highest_contact, cloth_height, 0.02);
}

static void test_wheels_see_through_what_pushes_nothing(void**) {
    StockWorld stock;
    stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    btRigidBody& trigger = stock.add_box(btVector3(1, btScalar(0.1), 1), 0, btVector3(0, btScalar(0.3), 0));
    trigger.setCollisionFlags(trigger.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
    pliant::Bridge bridge(*stock.world);
    pli_body* cloth = add_sheet(bridge, 2, 1, 5);
    bridge.object(cloth)->setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
    const btVector3 from(btScalar(0.1), 2, btScalar(0.2)), to(btScalar(0.1), -2, btScalar(0.2));
    for (const auto soft_bodies :
         {pliant::VehicleRaycaster::SoftBodies::ignored, pliant::VehicleRaycaster::SoftBodies::ground}) {
        pliant::VehicleRaycaster raycaster(*stock.world, soft_bodies);
        btVehicleRaycaster::btVehicleRaycasterResult result;
        assert_non_null(raycaster.castRay(from, to, result));
        check_near(result.m_distFraction, 0.5, 1e-6);
    }
}

static void test_a_ray_of_a_wheel_has_a_filter(void**) {
    StockWorld stock;
    stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    pliant::Bridge bridge(*stock.world);
    assert_non_null(add_sheet(bridge, 2, 1, 5, 0, 0, 0, 0.1f, soft_group, -1));
    using SoftBodies = pliant::VehicleRaycaster::SoftBodies;
    const btVector3 from(btScalar(0.1), 2, btScalar(0.2)), to(btScalar(0.1), -2, btScalar(0.2));
    btVehicleRaycaster::btVehicleRaycasterResult result;
    pliant::VehicleRaycaster raycaster(*stock.world, SoftBodies::ground);
    assert_non_null(raycaster.castRay(from, to, result));
    check_near(result.m_distFraction, 0.25, 1e-6);
    check_near(result.m_hitNormalInWorld.y(), 1, 1e-6);
    raycaster.filter_mask = ~soft_group;
    assert_non_null(raycaster.castRay(from, to, result));
    check_near(result.m_distFraction, 0.5, 1e-6);
    raycaster.filter_mask = soft_group;
    pliant::VehicleRaycaster blind(*stock.world);
    blind.filter_mask = soft_group;
    assert_non_null(raycaster.castRay(from, to, result));
    assert_null(blind.castRay(from, to, result));
    assert_null(raycaster.castRay(from, btVector3(btScalar(0.1), btScalar(1.5), btScalar(0.2)), result));
}

// What character controllers do, with the mask of their ghost object.
static void test_a_sweep_does_not_see_what_its_mask_leaves_out(void**) {
    StockWorld stock;
    stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* cloth = add_sheet(bridge, 2, 1, 9, 0, 0, 0, 0.1f, soft_group, -1);
    assert_non_null(cloth);
    btCapsuleShape capsule(btScalar(0.3), btScalar(1));
    const btVector3 start(0, 3, 0), end(0, 0, 0);
    for (const bool sees_cloth : {true, false}) {
        btCollisionWorld::ClosestConvexResultCallback hit(start, end);
        hit.m_collisionFilterGroup = btBroadphaseProxy::CharacterFilter;
        hit.m_collisionFilterMask = sees_cloth ? -1 : ~soft_group;
        stock.world->convexSweepTest(&capsule, btTransform(btQuaternion::getIdentity(), start),
                                     btTransform(btQuaternion::getIdentity(), end), hit);
        assert_true(hit.hasHit());
        assert_true((bridge.body(hit.m_hitCollisionObject) == cloth) == sees_cloth);
        check_near(hit.m_closestHitFraction * 3, sees_cloth ? 3 - 1.8 : 3 - 0.8, 0.15);
    }
}

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_wheels_keep_the_ground_below_a_cloth),
        cmocka_unit_test(test_wheels_roll_on_a_cloth),
        cmocka_unit_test(test_wheels_see_through_what_pushes_nothing),
        cmocka_unit_test(test_a_ray_of_a_wheel_has_a_filter),
        cmocka_unit_test(test_a_sweep_does_not_see_what_its_mask_leaves_out),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
