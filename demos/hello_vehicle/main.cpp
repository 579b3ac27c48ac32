// A car drives over a carpet, and a character walks into a curtain and pushes it with a body of its own.
#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Character/btKinematicCharacterController.h>
#include <BulletDynamics/Vehicle/btRaycastVehicle.h>
#include <LinearMath/btThreads.h>
#include <btBulletDynamicsCommon.h>
#include <cstdio>
#include <pliant_bullet/pliant_bullet.h>
#include <pliant_bullet/task_scheduler.h>
#include <pliant_bullet/vehicle_raycaster.h>

namespace {

constexpr int soft_group = 64; // of soft bodies alone

// A sheet from `corner` along two sides; null on failure.
pli_body* add_sheet(pliant::Bridge& bridge, pli_vec3 corner, pli_vec3 side, pli_vec3 other_side, int pins) {
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = corner;
    patch.corner_10 = pli_vec3_add(corner, side);
    patch.corner_01 = pli_vec3_add(corner, other_side);
    patch.corner_11 = pli_vec3_add(patch.corner_10, other_side);
    patch.columns = patch.rows = 25;
    patch.pins = pins;
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.03f;
    def.solver.position_iterations = 8;
    pli_mesh* mesh = nullptr;
    pli_body* cloth = nullptr;
    if (pli_mesh_create_patch(bridge.context(), &patch, &mesh) == PLI_OK &&
        pli_mesh_set_total_mass(mesh, 1) == PLI_OK && bridge.add_body(mesh, &def, &cloth, soft_group) == PLI_OK) {
        pli_body_enable_rigid_contacts(cloth, nullptr);
    }
    pli_mesh_destroy(mesh);
    return cloth;
}

// Drives for three seconds; steps of wheels without ground.
int drive(btDiscreteDynamicsWorld& world, btRigidBody* chassis) {
    btRaycastVehicle::btVehicleTuning tuning;
    pliant::VehicleRaycaster raycaster(world); // or (world, pliant::VehicleRaycaster::SoftBodies::ground)
    btRaycastVehicle vehicle(tuning, chassis, &raycaster);
    vehicle.setCoordinateSystem(0, 1, 2);
    for (int i = 0; i < 4; ++i) {
        const btVector3 place(i % 2 == 0 ? -0.6f : 0.6f, 0, i / 2 == 0 ? 0.8f : -0.8f);
        vehicle.addWheel(place, btVector3(0, -1, 0), btVector3(-1, 0, 0), 0.4f, 0.3f, tuning, i < 2);
    }
    world.addVehicle(&vehicle);
    int without_ground = 0;
    for (int step = 0; step < 240; ++step) {
        for (int wheel = 0; wheel < 4; ++wheel) {
            vehicle.applyEngineForce(step < 60 ? 0 : 200, wheel);
        }
        world.stepSimulation(1.0f / 60.0f, 0);
        for (int wheel = 0; wheel < 4 && step >= 60; ++wheel) {
            without_ground += vehicle.getWheelInfo(wheel).m_raycastInfo.m_isInContact ? 0 : 1;
        }
    }
    world.removeVehicle(&vehicle);
    return without_ground;
}

// Walks 2 m along x, into a curtain.
void walk(btDiscreteDynamicsWorld& world, btPairCachingGhostObject& ghost, btRigidBody& pusher,
          btConvexShape* capsule) {
    world.addCollisionObject(&ghost, btBroadphaseProxy::CharacterFilter, ~soft_group);
    world.addRigidBody(&pusher, btBroadphaseProxy::KinematicFilter, soft_group);
    btKinematicCharacterController character(&ghost, capsule, 0.1f, btVector3(0, 1, 0));
    world.addAction(&character);
    character.setWalkDirection(btVector3(0.02f, 0, 0)); // m per step
    for (int step = 0; step < 100; ++step) {
        pusher.setWorldTransform(ghost.getWorldTransform());
        world.stepSimulation(1.0f / 60.0f, 0);
    }
    world.removeAction(&character);
    world.removeRigidBody(&pusher);
    world.removeCollisionObject(&ghost);
}

} // namespace

int main() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btGhostPairCallback ghosts;
    broadphase.getOverlappingPairCache()->setInternalGhostPairCallback(&ghosts);
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    btBoxShape ground_shape(btVector3(50, 1, 50));
    btRigidBody ground(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &ground_shape));
    ground.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, -1, 0)));
    world.addRigidBody(&ground);

    btITaskScheduler* scheduler = btGetSequentialTaskScheduler(); // or the game's own
    pli_context* context = nullptr;
    pli_context_def def = pli_context_def_default();
    def.parallel_for = pliant::bullet_parallel_for;
    def.parallel_user = scheduler;
    if (pli_context_create(&def, &context) != PLI_OK) { return 1; }
    pliant::BridgeDef bridge_def;
    bridge_def.context = context;
    {
        pliant::Bridge bridge(world, bridge_def);
        const pli_body* carpet = add_sheet(bridge, {-1.5f, 0.04f, 3}, {0, 0, 3}, {3, 0, 0}, 0);
        const pli_body* curtain = add_sheet(bridge, {12, 2.1f, 1}, {0, 0, -2}, {0, -2, 0}, 1 | 2);
        if (carpet == nullptr || curtain == nullptr) {
            std::fprintf(stderr, "hello_vehicle: %s\n", pli_last_error(context));
            return 1;
        }

        btBoxShape chassis_shape(btVector3(0.6f, 0.2f, 1));
        btVector3 inertia;
        chassis_shape.calculateLocalInertia(400, inertia);
        btRigidBody chassis(btRigidBody::btRigidBodyConstructionInfo(400, nullptr, &chassis_shape, inertia));
        chassis.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 0.9f, 0)));
        chassis.setActivationState(DISABLE_DEACTIVATION);
        world.addRigidBody(&chassis);
        const int without_ground = drive(world, &chassis);
        std::printf("the car is at z = %.1f m, wheels without ground: %d\n",
                    double(chassis.getWorldTransform().getOrigin().z()), without_ground);
        world.removeRigidBody(&chassis);

        btCapsuleShape capsule(0.3f, 1);
        btPairCachingGhostObject ghost;
        ghost.setCollisionShape(&capsule);
        ghost.setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT);
        ghost.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(10.5f, 0.9f, 0)));
        btRigidBody pusher(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &capsule));
        pusher.setCollisionFlags(pusher.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
        pusher.setActivationState(DISABLE_DEACTIVATION);
        pusher.setWorldTransform(ghost.getWorldTransform());
        walk(world, ghost, pusher, &capsule);
        std::printf("the character is at x = %.1f m, the curtain reaches x = %.1f m\n",
                    double(ghost.getWorldTransform().getOrigin().x()), double(pli_body_get_bounds(curtain).max.x));
    }
    world.removeRigidBody(&ground);
    return pli_context_destroy(context) == PLI_OK ? 0 : 1;
}
