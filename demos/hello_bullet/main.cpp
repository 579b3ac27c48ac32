// A sheet falls over a box in a stock Bullet world and carries a ball that falls after it.
#include <btBulletDynamicsCommon.h>
#include <cstdio>
#include <pliant_bullet/pliant_bullet.h>

static int fail(const pliant::Bridge& bridge) {
    std::fprintf(stderr, "hello_bullet: %s\n", pli_last_error(bridge.context()));
    return 1;
}

int main() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);

    btBoxShape box_shape(btVector3(0.5f, 0.5f, 0.5f));
    btSphereShape ball_shape(0.25f);
    btRigidBody box(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &box_shape));
    btVector3 inertia;
    ball_shape.calculateLocalInertia(0.5f, inertia);
    btRigidBody ball(btRigidBody::btRigidBodyConstructionInfo(0.5f, nullptr, &ball_shape, inertia));
    ball.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 2, 0)));
    world.addRigidBody(&box);
    world.addRigidBody(&ball);

    // From here on Pliant: a bridge, a mesh, a body with contacts.
    pliant::Bridge bridge(world);
    pli_patch_def patch = pli_patch_def_default();
    patch.corner_00 = {-1, 1, -1};
    patch.corner_10 = {1, 1, -1};
    patch.corner_01 = {-1, 1, 1};
    patch.corner_11 = {1, 1, 1};
    patch.columns = patch.rows = 21;
    patch.diagonals = true;
    pli_mesh* mesh = nullptr;
    if (pli_mesh_create_patch(bridge.context(), &patch, &mesh) != PLI_OK) { return fail(bridge); }
    pli_mesh_set_total_mass(mesh, 1.0f);
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.05f;
    def.solver.position_iterations = 8;
    pli_body* sheet = nullptr;
    if (bridge.add_body(mesh, &def, &sheet) != PLI_OK) { return fail(bridge); }
    pli_mesh_destroy(mesh);
    const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    if (pli_body_enable_rigid_contacts(sheet, &contacts) != PLI_OK) { return fail(bridge); }

    for (int frame = 0; frame <= 120; ++frame) {
        if (frame % 20 == 0) {
            const pli_bounds bounds = pli_body_get_bounds(sheet);
            std::printf("t = %.2f s: sheet from y = %5.2f to %5.2f, ball at y = %5.2f\n", frame / 60.0,
                        double(bounds.min.y), double(bounds.max.y), double(ball.getWorldTransform().getOrigin().y()));
        }
        world.stepSimulation(1.0f / 60.0f);
    }
    world.removeRigidBody(&ball);
    world.removeRigidBody(&box);
    return 0;
}
