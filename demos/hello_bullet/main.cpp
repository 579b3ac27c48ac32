// A sheet falls over a box in a stock Bullet world and carries a ball that falls after it.
#include <btBulletDynamicsCommon.h>
#include <cstdio>
#include <pliant_bullet/pliant_bullet.h>

// A sheet of 2 m by 2 m, 1 m above the origin; null on failure.
static pli_body* add_sheet(pliant::Bridge& bridge) {
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = {-1, 1, -1};
    patch.corner_10 = {1, 1, -1};
    patch.corner_01 = {-1, 1, 1};
    patch.corner_11 = {1, 1, 1};
    patch.columns = patch.rows = 21;
    pli_mesh* mesh = nullptr;
    pli_body* sheet = nullptr;
    pli_body_def body = pli_body_def_default();
    body.collision_margin = 0.05f;
    body.solver.position_iterations = 8;
    const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    if (pli_mesh_create_patch(bridge.context(), &patch, &mesh) == PLI_OK &&
        pli_mesh_set_total_mass(mesh, 1) == PLI_OK && bridge.add_body(mesh, &body, &sheet) == PLI_OK) {
        pli_body_enable_rigid_contacts(sheet, &contacts);
    }
    pli_mesh_destroy(mesh); // the body has a copy
    return sheet;
}

int main() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);

    btBoxShape box_shape(btVector3(0.5f, 0.5f, 0.5f));
    btRigidBody box(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &box_shape));
    world.addRigidBody(&box);

    btSphereShape ball_shape(0.25f);
    btVector3 inertia;
    ball_shape.calculateLocalInertia(0.5f, inertia);
    btRigidBody ball(btRigidBody::btRigidBodyConstructionInfo(0.5f, nullptr, &ball_shape, inertia));
    ball.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 2, 0)));
    world.addRigidBody(&ball);

    pliant::Bridge bridge(world);
    const pli_body* sheet = add_sheet(bridge);
    if (sheet == nullptr) {
        std::fprintf(stderr, "hello_bullet: %s\n", pli_last_error(bridge.context()));
        return 1;
    }
    for (int step = 0; step <= 120; ++step) {
        if (step % 20 == 0) {
            const pli_bounds bounds = pli_body_get_bounds(sheet);
            std::printf("%.2f s: sheet from y = %5.2f to %5.2f m, ball at y = %5.2f m\n", step / 60.0,
                        double(bounds.min.y), double(bounds.max.y), double(ball.getWorldTransform().getOrigin().y()));
        }
        world.stepSimulation(1.0f / 60.0f);
    }
    world.removeRigidBody(&ball);
    world.removeRigidBody(&box);
    return 0;
}
