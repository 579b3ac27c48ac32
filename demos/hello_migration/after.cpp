// The game of before.cpp on Pliant.
#include <array>
#include <btBulletDynamicsCommon.h>
#include <cstdio>
#include <memory>
#include <pliant_bullet/pliant_bullet.h>
#include <stdexcept>
#include <vector>

using Vertex = std::array<float, 6>; // position and normal, as the renderer has them

class Game {
public:
    Game() {
        world.setGravity(btVector3(0, -10, 0));
        add_box(btVector3(10, 1, 10), 0, btVector3(0, -1, 0));
        bar = &add_box(btVector3(3, 0.1f, 0.1f), 0, btVector3(0, 3, 0));
        lamp = &add_box(btVector3(0.2f, 0.2f, 0.2f), 2, btVector3(2.5f, 1.3f, 0));
        add_curtain();
        add_rope();
        add_ball();
    }
    ~Game() {
        for (auto& body : bodies) {
            world.removeRigidBody(body.get());
        }
    }

    // Positions and normals for the renderer.
    void draw(const pli_body* body, std::vector<Vertex>& vertices) const {
        vertices.resize(size_t(pli_body_get_view(body).node_count));
        pli_vertex_buffer_def buffer = pli_vertex_buffer_def_default();
        buffer.vertices = vertices.data();
        buffer.vertex_count = int(vertices.size());
        check(pli_body_write_vertices(body, &buffer, bridge.interpolation()));
    }

    pli_body *curtain = nullptr, *rope = nullptr, *ball = nullptr;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    pliant::Bridge bridge{world};
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    btRigidBody *bar = nullptr, *lamp = nullptr;

private:
    btRigidBody& add_box(const btVector3& half, btScalar mass, const btVector3& at) {
        shapes.push_back(std::make_unique<btBoxShape>(half));
        btVector3 inertia(0, 0, 0);
        if (mass > 0) { shapes.back()->calculateLocalInertia(mass, inertia); }
        bodies.push_back(std::make_unique<btRigidBody>(mass, nullptr, shapes.back().get(), inertia));
        bodies.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), at));
        world.addRigidBody(bodies.back().get());
        return *bodies.back();
    }

    void check(pli_status status) const {
        if (status != PLI_OK) { throw std::runtime_error(pli_last_error(bridge.context())); }
    }

    // The mesh goes, a body with contacts stays.
    pli_body* add(pli_mesh* mesh, float mass, int iterations) {
        pli_body* body = nullptr;
        pli_body_def def = pli_body_def_default();
        def.solver.position_iterations = iterations;
        check(pli_mesh_set_total_mass(mesh, mass));
        check(bridge.add_body(mesh, &def, &body));
        pli_mesh_destroy(mesh);
        check(pli_body_enable_rigid_contacts(body, nullptr));
        check(pli_body_enable_soft_contacts(body, nullptr));
        return body;
    }

    void add_curtain() {
        pli_patch_def patch = pli_patch_def_default();
        patch.corner_00 = {-2, 3, 0}, patch.corner_10 = {1, 3, 0};
        patch.corner_01 = {-2, 1, 0}, patch.corner_11 = {1, 1, 0};
        patch.columns = 31, patch.rows = 21;
        pli_mesh* mesh = nullptr;
        check(pli_mesh_create_patch(bridge.context(), &patch, &mesh));
        curtain = add(mesh, 1, 8);
        check(pli_body_enable_normals(curtain));
        const int hooks[] = {0, 5, 10, 15, 20, 25, 30};
        check(pli_body_attach_nodes(curtain, hooks, 7, bridge.rigid(*bar)));
        check(pli_body_ignore_rigid(curtain, bridge.rigid(*bar), true));
    }

    void add_rope() {
        pli_mesh* mesh = nullptr;
        check(pli_mesh_create_rope(bridge.context(), {2.5f, 3, 0}, {2.5f, 1.5f, 0}, 14, PLI_ROPE_PIN_FIRST, &mesh));
        rope = add(mesh, 0.5f, 20);
        pli_anchor_def anchor = pli_anchor_def_default();
        anchor.node = 15;
        anchor.rigid = bridge.rigid(*lamp);
        check(pli_body_add_anchor(rope, &anchor, nullptr));
    }

    void add_ball() {
        pli_mesh* mesh = nullptr;
        check(pli_mesh_create_ellipsoid(bridge.context(), {-0.5f, 1.2f, 3}, {0.5f, 0.5f, 0.5f}, 200, &mesh));
        ball = add(mesh, 1, 8);
        check(pli_body_enable_pressure(ball, 20));
        check(pli_body_add_velocity(ball, {0, 0, -4}));
    }
};

int main() {
    Game game;
    std::vector<Vertex> vertices;
    const btCollisionObject* curtain = game.bridge.object(game.curtain);
    for (int frame = 0; frame <= 300; ++frame) {
        game.draw(game.curtain, vertices);
        const btVector3 from(-0.5f, 2.2f, -5), to(-0.5f, 2.2f, 5); // under the mouse
        btCollisionWorld::ClosestRayResultCallback seen(from, to);
        game.world.rayTest(from, to, seen);
        if (frame % 60 == 0) {
            const Vertex& hem = vertices[vertices.size() - 16];
            std::printf("%d s: hem at z = %5.2f m, lamp at y = %.2f m, the mouse is on the %s\n", frame / 60,
                        double(hem[2]), double(game.lamp->getWorldTransform().getOrigin().y()),
                        seen.m_collisionObject == curtain ? "curtain" : "other things");
        }
        game.world.stepSimulation(1.0f / 60.0f, 0);
    }
    return 0;
}
