// A rope in a Bullet world, which proves that the bridge's headers are found and that it links and runs.

#include <pliant_bullet/pliant_bullet.h>

#include <btBulletDynamicsCommon.h>

int main() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);

    pliant::Bridge bridge(world);
    pli_mesh* mesh = nullptr;
    pli_body* rope = nullptr;
    if (bridge.status() != PLI_OK ||
        pli_mesh_create_rope(bridge.context(), pli_vec3_make(0, 5, 0), pli_vec3_make(5, 5, 0), 8, PLI_ROPE_PIN_FIRST,
                             &mesh) != PLI_OK ||
        bridge.add_body(mesh, nullptr, &rope) != PLI_OK) {
        return 1;
    }
    pli_mesh_destroy(mesh);
    for (int i = 0; i < 60; ++i) {
        world.stepSimulation(1.0f / 60.0f, 0);
    }
    const pli_body_view view = pli_body_get_view(rope);
    return bridge.step_status() == PLI_OK && view.positions[0].y == 5 && view.positions[9].y < 3 ? 0 : 1;
}
