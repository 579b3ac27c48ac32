// A small game with soft bodies of Bullet: a curtain and a lamp on a rope hang from a bar, a ball rolls into the
// curtain. after.cpp is the same game on Pliant.
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <array>
#include <btBulletDynamicsCommon.h>
#include <cstdio>
#include <memory>
#include <vector>

using Vertex = std::array<float, 6>; // position and normal, as the renderer has them

class Game {
public:
    Game() {
        world.setGravity(btVector3(0, -10, 0));
        world.getWorldInfo().m_gravity = world.getGravity();
        world.getWorldInfo().m_dispatcher = &dispatcher;
        world.getWorldInfo().m_broadphase = &broadphase;
        world.getWorldInfo().m_sparsesdf.Initialize();
        add_box(btVector3(10, 1, 10), 0, btVector3(0, -1, 0));
        bar = &add_box(btVector3(3, 0.1f, 0.1f), 0, btVector3(0, 3, 0));
        lamp = &add_box(btVector3(0.2f, 0.2f, 0.2f), 2, btVector3(2.5f, 1.3f, 0));
        add_curtain();
        add_rope();
        add_ball();
    }
    ~Game() {
        for (btSoftBody* each : {curtain, rope, ball}) {
            world.removeSoftBody(each);
            delete each;
        }
        for (auto& body : bodies) {
            world.removeRigidBody(body.get());
        }
    }

    // Positions and normals for the renderer.
    static void draw(const btSoftBody& body, std::vector<Vertex>& vertices) {
        vertices.resize(size_t(body.m_nodes.size()));
        for (int i = 0; i < body.m_nodes.size(); ++i) {
            const btSoftBody::Node& node = body.m_nodes[i];
            for (int k = 0; k < 3; ++k) {
                vertices[size_t(i)][size_t(k)] = float(node.m_x[k]);
                vertices[size_t(i)][size_t(k) + 3] = float(node.m_n[k]);
            }
        }
    }

    btSoftBody *curtain = nullptr, *rope = nullptr, *ball = nullptr;
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
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

    void add_curtain() {
        curtain = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-2, 3, 0), btVector3(1, 3, 0),
                                                 btVector3(-2, 1, 0), btVector3(1, 1, 0), 31, 21, 0, true);
        curtain->setTotalMass(1);
        curtain->getCollisionShape()->setMargin(0.05f);
        curtain->m_cfg.piterations = 8;
        curtain->m_cfg.kDP = 0.005f;
        curtain->m_cfg.collisions |= btSoftBody::fCollision::VF_SS;
        for (int i = 0; i < 31; i += 5) {
            curtain->appendAnchor(i, bar, true);
        }
        world.addSoftBody(curtain);
    }

    void add_rope() {
        rope =
            btSoftBodyHelpers::CreateRope(world.getWorldInfo(), btVector3(2.5f, 3, 0), btVector3(2.5f, 1.5f, 0), 14, 1);
        rope->setTotalMass(0.5f);
        rope->m_cfg.piterations = 20;
        rope->appendAnchor(rope->m_nodes.size() - 1, lamp);
        world.addSoftBody(rope);
    }

    void add_ball() {
        ball = btSoftBodyHelpers::CreateEllipsoid(world.getWorldInfo(), btVector3(-0.5f, 1.2f, 3),
                                                  btVector3(0.5f, 0.5f, 0.5f), 200);
        ball->setTotalMass(1, true);
        ball->getCollisionShape()->setMargin(0.05f);
        ball->m_cfg.piterations = 8;
        ball->m_cfg.kPR = 20;
        ball->m_cfg.collisions |= btSoftBody::fCollision::VF_SS;
        ball->setVelocity(btVector3(0, 0, -4));
        world.addSoftBody(ball);
    }
};

int main() {
    Game game;
    std::vector<Vertex> vertices;
    for (int frame = 0; frame <= 300; ++frame) {
        Game::draw(*game.curtain, vertices);
        const btVector3 from(-0.5f, 2.2f, -5), to(-0.5f, 2.2f, 5); // under the mouse
        btCollisionWorld::ClosestRayResultCallback seen(from, to);
        game.world.rayTest(from, to, seen);
        if (frame % 60 == 0) {
            const Vertex& hem = vertices[vertices.size() - 16];
            std::printf("%d s: hem at z = %5.2f m, lamp at y = %.2f m, the mouse is on the %s\n", frame / 60,
                        double(hem[2]), double(game.lamp->getWorldTransform().getOrigin().y()),
                        seen.m_collisionObject == game.curtain ? "curtain" : "other things");
        }
        game.world.stepSimulation(1.0f / 60.0f, 0);
    }
    return 0;
}
