// A capsule with a cape walks through boxes: 60 steps and 144 frames a second; what the cape touches is told.
#include <btBulletDynamicsCommon.h>
#include <cstdio>
#include <deque>
#include <pliant_bullet/pliant_bullet.h>

int main() {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    btCapsuleShape capsule(0.3f, 1.2f);
    btBoxShape brick(btVector3(0.2f, 0.2f, 0.2f)), slab(btVector3(20, 1, 20));
    std::deque<btRigidBody> bodies;
    const auto add = [&](const char* name, btScalar mass, btCollisionShape& shape, btVector3 place) {
        btRigidBody& body = bodies.emplace_back(mass, nullptr, &shape, btVector3(0.05f, 0.05f, 0.05f) * mass);
        body.translate(place);
        body.setUserPointer(const_cast<char*>(name));
        world.addRigidBody(&body);
    };
    add("the walker", 0, capsule, btVector3(0, 0.9f, 0));
    add("the ground", 0, slab, btVector3(0, -1, 0));
    for (int i = 1; i <= 5; ++i) {
        add("a box", 2, brick, btVector3(btScalar(i), 0.2f, btScalar(i % 3 - 1) * 0.4f));
    }
    bodies[0].setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    const auto walk = [](btDynamicsWorld* stepped, btScalar dt) { // before each step
        static_cast<btRigidBody*>(stepped->getWorldUserInfo())->translate(btVector3(1.5f * dt, 0, 0));
    };
    world.setInternalTickCallback(walk, &bodies[0], true);
    pliant::Bridge bridge(world);
    pli_patch_def patch = pli_patch_def_default(); // from the shoulders down
    patch.corner_00 = {-0.33f, 1.4f, -0.3f}, patch.corner_10 = {-0.33f, 1.4f, 0.3f};
    patch.corner_01 = {-0.5f, 0.3f, -0.5f}, patch.corner_11 = {-0.5f, 0.3f, 0.5f}, patch.columns = 12, patch.rows = 24;
    const int collar[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}; // the first row
    float vertices[12 * 24][6];                                  // positions and normals, the renderer's
    pli_vertex_buffer_def buffer = pli_vertex_buffer_def_default();
    buffer.vertices = vertices, buffer.vertex_count = 12 * 24;
    pli_mesh* mesh = nullptr;
    pli_body* cape = nullptr;
    bool is_fine = pli_mesh_create_patch(bridge.context(), &patch, &mesh) == PLI_OK &&
                   pli_mesh_set_total_mass(mesh, 0.6f) == PLI_OK && bridge.add_body(mesh, nullptr, &cape) == PLI_OK &&
                   pli_body_attach_nodes(cape, collar, 12, bridge.rigid(bodies[0])) == PLI_OK &&
                   pli_body_enable_rigid_contacts(cape, nullptr) == PLI_OK && pli_body_enable_normals(cape) == PLI_OK &&
                   pli_body_enable_tethers(cape, nullptr) == PLI_OK &&
                   pli_body_enable_contact_events(cape, nullptr) == PLI_OK;
    pli_mesh_destroy(mesh);
    for (int frame = 1, count = 0; is_fine && frame <= 4 * 144; ++frame) {
        const bool has_stepped = world.stepSimulation(1.0f / 144) > 0;
        const pli_contact_event* begun = pli_body_get_contact_events(cape, PLI_CONTACT_BEGIN, &count);
        for (int i = 0; has_stepped && i < count; ++i) {
            const void* name = bridge.object(begun[i].rigid)->getUserPointer();
            std::printf("%.2f s: the cape touches %s\n", frame / 144.0, static_cast<const char*>(name));
        }
        is_fine = pli_body_write_vertices(cape, &buffer, bridge.interpolation()) == PLI_OK;
        if (frame % 144 == 0) { std::printf("%d s: hem at x = %.2f m\n", frame / 144, double(vertices[276][0])); }
    }
    return is_fine ? 0 : std::fprintf(stderr, "hello_cape: %s\n", pli_last_error(bridge.context()));
}
