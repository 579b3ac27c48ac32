// A stock Bullet world with what rigid things the bridge's tests need. Owns all of it.
#pragma once

#include "pliant_bullet/pliant_bullet.h"

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

namespace bridge_test {

class StockWorld {
public:
    explicit StockWorld(btVector3 gravity = btVector3(0, -10, 0),
                        std::unique_ptr<btBroadphaseInterface> made = std::make_unique<btDbvtBroadphase>())
        : broadphase(std::move(made)) {
        world->setGravity(gravity);
    }
    ~StockWorld() {
        while (world->getNumCollisionObjects() > 0) {
            world->removeCollisionObject(world->getCollisionObjectArray()[world->getNumCollisionObjects() - 1]);
        }
    }

    /// mass 0: static
    btRigidBody& add_body(btCollisionShape* shape, btScalar mass, btVector3 position,
                          btQuaternion rotation = btQuaternion::getIdentity()) {
        shapes.emplace_back(shape);
        btVector3 inertia(0, 0, 0);
        if (mass > 0) { shape->calculateLocalInertia(mass, inertia); }
        states.push_back(std::make_unique<btDefaultMotionState>(btTransform(rotation, position)));
        bodies.push_back(std::make_unique<btRigidBody>(mass, states.back().get(), shape, inertia));
        world->addRigidBody(bodies.back().get());
        return *bodies.back();
    }
    btRigidBody& add_box(btVector3 half_extents, btScalar mass, btVector3 position,
                         btQuaternion rotation = btQuaternion::getIdentity()) {
        return add_body(new btBoxShape(half_extents), mass, position, rotation);
    }
    void step(int count, btScalar dt = btScalar(1) / btScalar(60)) {
        for (int i = 0; i < count; ++i) {
            world->stepSimulation(dt, 0);
        }
    }

    std::unique_ptr<btDefaultCollisionConfiguration> configuration =
        std::make_unique<btDefaultCollisionConfiguration>(small_pools());
    std::unique_ptr<btCollisionDispatcher> dispatcher = std::make_unique<btCollisionDispatcher>(configuration.get());
    std::unique_ptr<btBroadphaseInterface> broadphase;
    std::unique_ptr<btSequentialImpulseConstraintSolver> solver =
        std::make_unique<btSequentialImpulseConstraintSolver>();
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btMotionState>> states;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    std::unique_ptr<btDiscreteDynamicsWorld> world = std::make_unique<btDiscreteDynamicsWorld>(
        dispatcher.get(), broadphase.get(), solver.get(), configuration.get());

private:
    /// Bullet's own are of some megabytes, which a fuzzer would spend its time on.
    static btDefaultCollisionConstructionInfo small_pools() {
        btDefaultCollisionConstructionInfo info;
        info.m_defaultMaxPersistentManifoldPoolSize = info.m_defaultMaxCollisionAlgorithmPoolSize = 64;
        return info;
    }
};

/// A horizontal square sheet of `size` m at height `y`, around `center`, with `resolution` nodes per side, 1 kg in all.
inline pli_mesh* make_sheet(pli_context* context, float size, float y, int resolution, int pins = 0, float x = 0,
                            float z = 0) {
    pli_patch_def def = pli_patch_def_default();
    const float h = size / 2;
    def.corner_00 = pli_vec3_make(x - h, y, z - h);
    def.corner_10 = pli_vec3_make(x + h, y, z - h);
    def.corner_01 = pli_vec3_make(x - h, y, z + h);
    def.corner_11 = pli_vec3_make(x + h, y, z + h);
    def.columns = def.rows = resolution;
    def.pins = pins;
    def.diagonals = true;
    pli_mesh* mesh = nullptr;
    if (pli_mesh_create_patch(context, &def, &mesh) != PLI_OK) { return nullptr; }
    return pli_mesh_set_total_mass(mesh, 1.0f) == PLI_OK ? mesh : nullptr;
}

/// Such a sheet in the bridge's world, with rigid contacts. Null on any failure.
inline pli_body* add_sheet(pliant::Bridge& bridge, float size, float y, int resolution, int pins = 0, float x = 0,
                           float z = 0, float margin = 0.1f, int group = 1, int mask = -1) {
    pli_mesh* mesh = make_sheet(bridge.context(), size, y, resolution, pins, x, z);
    pli_body_def def = pli_body_def_default();
    def.collision_margin = margin;
    def.solver.position_iterations = 4;
    pli_body* body = nullptr;
    const pli_status added = bridge.add_body(mesh, &def, &body, group, mask);
    pli_mesh_destroy(mesh);
    if (added != PLI_OK) { return nullptr; }
    const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    return pli_body_enable_rigid_contacts(body, &contacts) == PLI_OK ? body : nullptr;
}

inline float lowest(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    float y = view.positions[0].y;
    for (int i = 1; i < view.node_count; ++i) {
        y = view.positions[i].y < y ? view.positions[i].y : y;
    }
    return y;
}
inline float highest(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    float y = view.positions[0].y;
    for (int i = 1; i < view.node_count; ++i) {
        y = view.positions[i].y > y ? view.positions[i].y : y;
    }
    return y;
}
inline pli_vec3 center(const pli_body* body) {
    const pli_body_view view = pli_body_get_view(body);
    pli_vec3 sum = pli_vec3_make(0, 0, 0);
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 p = view.positions[i];
        sum = pli_vec3_add(sum, pli_vec3_make(p.x, p.y, p.z));
    }
    return pli_vec3_scale(sum, 1.0f / static_cast<float>(view.node_count));
}

} // namespace bridge_test
