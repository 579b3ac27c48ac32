// A sheet, a ball and two players who push it; the input of one of them comes eight frames late.
#include <btBulletDynamicsCommon.h>
#include <pliant_bullet/pliant_bullet.h>
#include <pliant_bullet/snapshot.h>

#include <cstdio>
#include <stdexcept>

namespace {

// m/s, that a player adds to the ball along x in a frame.
using Input = float;

struct Game {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    btSphereShape ball_shape{0.3f};
    btBoxShape ground_shape{btVector3(5, 1, 5)};
    btRigidBody ball{btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &ball_shape, btVector3(0.04f, 0.04f, 0.04f))};
    btRigidBody ground{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &ground_shape)};
    pliant::Bridge bridge{world};
    pli_body* sheet = nullptr;

    Game() {
        world.getDispatchInfo().m_deterministicOverlappingPairs = true;
        ball.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 2, 0)));
        ball.setActivationState(DISABLE_DEACTIVATION);
        ground.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, -1, 0)));
        world.addRigidBody(&ball);
        world.addRigidBody(&ground);
        pli_patch_def patch = pli_patch_def_default();
        patch.corner_00 = {-1, 1, -1};
        patch.corner_10 = {1, 1, -1};
        patch.corner_01 = {-1, 1, 1};
        patch.corner_11 = {1, 1, 1};
        patch.columns = patch.rows = 21;
        patch.pins = PLI_PATCH_PIN_00 | PLI_PATCH_PIN_10 | PLI_PATCH_PIN_01 | PLI_PATCH_PIN_11;
        pli_mesh* mesh = nullptr;
        const bool is_made = pli_mesh_create_patch(bridge.context(), &patch, &mesh) == PLI_OK &&
                             pli_mesh_set_total_mass(mesh, 1) == PLI_OK &&
                             bridge.add_body(mesh, nullptr, &sheet) == PLI_OK &&
                             pli_body_enable_rigid_contacts(sheet, nullptr) == PLI_OK &&
                             pli_body_enable_rigid_face_contacts(sheet, nullptr) == PLI_OK;
        pli_mesh_destroy(mesh);
        if (!is_made) { throw std::runtime_error(pli_last_error(bridge.context())); }
    }
    ~Game() {
        world.removeRigidBody(&ball);
        world.removeRigidBody(&ground);
    }
};

void apply(btDiscreteDynamicsWorld& world, Input input) {
    btRigidBody* ball = btRigidBody::upcast(world.getCollisionObjectArray()[0]);
    ball->setLinearVelocity(ball->getLinearVelocity() + btVector3(input, 0, 0));
}

// Eight frames at most are stepped again when an input turns out to be another than was guessed.
class Rollback {
public:
    Rollback(btDiscreteDynamicsWorld& world, pliant::Bridge& bridge) : world_(world), bridge_(bridge) {}

    void step(Input guess) {
        Frame& frame = frames_[now_ % depth];
        frame.input = guess;
        if (frame.before.save(bridge_) != PLI_OK) { throw std::runtime_error("not saved"); }
        apply(world_, guess);
        world_.stepSimulation(1.0f / 60.0f, 0);
        ++now_;
    }

    // `input` is that of `frame`, at most eight frames ago.
    void correct(int frame, Input input) {
        const int end = now_;
        if (frames_[frame % depth].input == input) { return; }
        if (frames_[frame % depth].before.restore(bridge_) != PLI_OK) { throw std::runtime_error("not restored"); }
        now_ = frame;
        while (now_ < end) {
            step(now_ == frame ? input : frames_[now_ % depth].input);
        }
    }

private:
    static constexpr int depth = 8;
    struct Frame {
        pliant::BridgeSnapshot before;
        Input input;
    };
    btDiscreteDynamicsWorld& world_;
    pliant::Bridge& bridge_;
    Frame frames_[depth];
    int now_ = 0;
};

Input input_of(int frame) {
    return frame % 11 == 3 ? 0.4f : frame % 17 == 5 ? -0.3f : 0.0f;
}

} // namespace

int main() try {
    constexpr int frames = 180, late = 7;
    Game known, guessed;
    Rollback plain(known.world, known.bridge), rollback(guessed.world, guessed.bridge);
    for (int i = 0; i < frames; ++i) {
        plain.step(input_of(i));
    }
    for (int i = 0; i < frames + late; ++i) {
        if (i < frames) { rollback.step(0); }
        if (i >= late) { rollback.correct(i - late, input_of(i - late)); }
    }
    const btVector3 a = known.ball.getWorldTransform().getOrigin(), b = guessed.ball.getWorldTransform().getOrigin();
    const bool is_equal = a == b && pli_body_state_hash(known.sheet) == pli_body_state_hash(guessed.sheet);
    std::printf("after 3 s: ball at x = %.3f m and %.3f m, sheets %s\n", static_cast<double>(a.x()),
                static_cast<double>(b.x()), is_equal ? "equal" : "differ");
    return is_equal ? 0 : 1;
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
