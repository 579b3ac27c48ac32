// A game that is compiled without run-time type information, as many are, with classes derived from those of Bullet.
#include "check.h"
#include "test_bridge_world.h"

#include <pliant_bullet/vehicle_raycaster.h>

using namespace bridge_test;

namespace {

struct Floor final : btRigidBody {
    using btRigidBody::btRigidBody;
    ~Floor() override {}
};

struct Trigger final : btCollisionObject {
    Trigger() { m_internalType = CO_USER_TYPE; }
    ~Trigger() override {}
};

} // namespace

static void test_objects_without_type_information_are_met(void**) {
    StockWorld stock;
    btBoxShape shape(btVector3(5, 1, 5));
    Floor floor(btScalar(0), nullptr, &shape);
    floor.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, -1, 0)));
    stock.world->addRigidBody(&floor);
    Trigger trigger;
    trigger.setCollisionShape(&shape);
    trigger.setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
    stock.world->addCollisionObject(&trigger);
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1, 0.5f, 5);
    stock.step(120);
    assert_int_equal(bridge.step_status(), PLI_OK);
    check_near(lowest(sheet), 0.1, 0.01);
    assert_null(bridge.body(&floor));
    assert_null(pliant::Bridge::from_object(&trigger));
    assert_ptr_equal(pliant::Bridge::from_object(bridge.object(sheet)), sheet);
    trigger.getWorldTransform().setOrigin(btVector3(0, 50, 0));
    stock.world->updateSingleAabb(&trigger);
    pliant::VehicleRaycaster raycaster(*stock.world);
    btVehicleRaycaster::btVehicleRaycasterResult result;
    assert_ptr_equal(raycaster.castRay(btVector3(0, 1, 0), btVector3(0, -1, 0), result), &floor);
    stock.world->removeCollisionObject(&trigger);
    stock.world->removeRigidBody(&floor);
}

int main() {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_objects_without_type_information_are_met),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
