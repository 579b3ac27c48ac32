// Anchors against btSoftBody, bit for bit, with the velocities of the rigid bodies.

#include "check.h"
#include "sample_mesh.h"

#include "oracle/bullet_twin.hpp"

extern "C" {
#include "body/rigid_impl.h"
}

#include <pliant/anchor.h>

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletSoftBody/btSoftBodyInternals.h>

#include <cstring>

namespace {

constexpr float dt = 1.0f / 60.0f;
constexpr int steps = 120;

// ---------------------------------------------------------------------------------------------- impulse matrix

void test_impulse_matrix_equals_bullet(void**) {
    twin::random_source random(3);
    for (int i = 0; i < 10000; ++i) {
        pli_mat3 inertia;
        for (pli_vec3& row : inertia.rows) {
            row = random.vector(0.1f);
        }
        for (pli_vec3* row : {&inertia.rows[0], &inertia.rows[1], &inertia.rows[2]}) {
            *row = random.vector(0.01f);
        }
        inertia.rows[0].x = random.uniform(0.1f, 2.0f);
        inertia.rows[1].y = random.uniform(0.1f, 2.0f);
        inertia.rows[2].z = random.uniform(0.1f, 2.0f);
        const float node = i % 5 == 0 ? 0.0f : random.uniform(0.01f, 100.0f);
        const float rigid = i % 7 == 1 ? 0.0f : random.uniform(0.01f, 10.0f);
        if (rigid == 0.0f) { inertia = pli_mat3{}; }
        const pli_vec3 offset = random.vector(3.0f);
        pli_rigid body{};
        body.state.inverse_mass = rigid;
        body.state.inverse_inertia_world = inertia;
        body.linear_factor = body.angular_factor = pli_vec3_make(1, 1, 1);
        pli_mat3 ours, with_factors;
        plii_effective_mass(dt, node, &body, false, offset, &ours);
        plii_effective_mass(dt, node, &body, true, offset, &with_factors);
        const pli_mat3 theirs =
            twin::to_pliant(ImpulseMatrix(twin::to_bullet(dt), twin::to_bullet(node), twin::to_bullet(rigid),
                                          twin::to_bullet(inertia), twin::to_bullet(offset)));
        assert_int_equal(std::memcmp(&ours, &theirs, sizeof ours), 0);
        assert_int_equal(std::memcmp(&with_factors, &theirs, sizeof theirs), 0);
    }
}

// ----------------------------------------------------------------------------------------------------- anchors

struct rigid_twin {
    btBoxShape shape{btVector3(1, 2, 3)};
    std::unique_ptr<btRigidBody> bullet;
    pli_rigid* pliant = nullptr;

    rigid_twin(pli_world* world, float mass, const btTransform& pose) {
        btVector3 inertia(0, 0, 0);
        if (mass > 0) { shape.calculateLocalInertia(twin::to_bullet(mass), inertia); }
        btRigidBody::btRigidBodyConstructionInfo info(twin::to_bullet(mass), nullptr, &shape, inertia);
        info.m_startWorldTransform = pose;
        bullet = std::make_unique<btRigidBody>(info);
        pli_rigid_def def = pli_rigid_def_default();
        def.kind = mass > 0 ? PLI_RIGID_DYNAMIC : PLI_RIGID_STATIC;
        def.state = twin::rigid_state(*bullet);
        assert_int_equal(pli_rigid_create(world, &def, &pliant), PLI_OK);
    }

    // Moves the Bullet body as its world would, and takes its state over.
    void move() {
        if (!bullet->isStaticObject()) {
            bullet->setLinearVelocity(bullet->getLinearVelocity() + btVector3(0, -10, 0) * twin::to_bullet(dt));
            btTransform next;
            bullet->predictIntegratedTransform(twin::to_bullet(dt), next);
            bullet->setCenterOfMassTransform(next);
        }
        const pli_rigid_state state = twin::rigid_state(*bullet);
        assert_int_equal(pli_rigid_set_state(pliant, &state), PLI_OK);
    }

    bool is_exact() const {
        const pli_rigid_state state = pli_rigid_get_state(pliant);
        return twin::distance(state.linear_velocity, twin::to_pliant(bullet->getLinearVelocity())) == 0 &&
               twin::distance(state.angular_velocity, twin::to_pliant(bullet->getAngularVelocity())) == 0;
    }
};

struct fixture {
    btSoftBodyWorldInfo info = twin::world_info();
    pli_context* context = nullptr;
    pli_world* world = nullptr;
    pli_body* body = nullptr;
    std::unique_ptr<btSoftBody> soft;
    std::unique_ptr<rigid_twin> box, other_box, wall;

    fixture() {
        assert_int_equal(pli_context_create(nullptr, &context), PLI_OK);
        pli_world_def def = pli_world_def_default();
        def.reference_mode = true; // anchors to what cannot yield lag as Bullet's do
        assert_int_equal(pli_world_create(context, &def, &world), PLI_OK);
        pli_mesh* mesh = nullptr;
        assert_int_equal(sample_create_sheet(context, 9, 5.0f, PLI_PATCH_PIN_00, &mesh), PLI_OK);
        soft = twin::make_soft_body(info, mesh);
        assert_int_equal(pli_body_create(world, mesh, nullptr, &body), PLI_OK);
        pli_mesh_destroy(mesh);
        pli_solver_settings settings = pli_body_get_solver_settings(body);
        settings.position_iterations = 3;
        assert_int_equal(pli_body_set_solver_settings(body, &settings), PLI_OK);
        soft->m_cfg.piterations = 3;

        const btQuaternion tilt(btVector3(1, 2, 3).normalized(), btScalar(0.7));
        box = std::make_unique<rigid_twin>(world, 5.0f, btTransform(tilt, btVector3(3, 5, 0)));
        other_box = std::make_unique<rigid_twin>(world, 0.5f, btTransform(tilt, btVector3(-1, 4, 3)));
        wall = std::make_unique<rigid_twin>(world, 0.0f, btTransform(tilt, btVector3(-3, 5, -2)));
        box->bullet->setAngularVelocity(btVector3(1, -2, 0.5));
        twin::random_source random(9);
        for (int i = 0; i < soft->m_nodes.size(); ++i) {
            if (soft->m_nodes[i].m_im > 0) { soft->m_nodes[i].m_v = twin::to_bullet(random.vector(2.0f)); }
        }
        assert_int_equal(twin::copy_state(*soft, body), PLI_OK);
    }
    ~fixture() {
        pli_world_destroy(world);
        pli_context_destroy(context);
    }
    fixture(const fixture&) = delete;
    fixture& operator=(const fixture&) = delete;

    pli_anchor_id add(int node, const rigid_twin& rigid, float influence, const pli_vec3* pivot) {
        pli_anchor_def def = pli_anchor_def_default();
        def.node = node;
        def.rigid = rigid.pliant;
        def.influence = influence;
        def.local_pivot = pivot;
        pli_anchor_id id = {};
        assert_int_equal(pli_body_add_anchor(body, &def, &id), PLI_OK);
        if (pivot != nullptr) {
            soft->appendAnchor(node, rigid.bullet.get(), twin::to_bullet(*pivot), false, twin::to_bullet(influence));
        } else {
            soft->appendAnchor(node, rigid.bullet.get(), false, twin::to_bullet(influence));
        }
        return id;
    }

    void check_steps(const char* what) {
        for (int i = 0; i < steps; ++i) {
            for (rigid_twin* rigid : {box.get(), other_box.get(), wall.get()}) {
                rigid->move();
            }
            twin::step(*soft, dt);
            assert_int_equal(pli_world_step(world, dt), PLI_OK);
            const twin::difference apart = twin::compare(*soft, body);
            if (!apart.is_exact()) {
                fail_msg("%s, step %d: node %d apart by %g m and %g m/s", what, i, apart.node, apart.position,
                         apart.velocity);
            }
            for (const rigid_twin* rigid : {box.get(), other_box.get(), wall.get()}) {
                if (!rigid->is_exact()) { fail_msg("%s, step %d: rigid velocities differ", what, i); }
            }
        }
    }
};

void test_anchors_equal_bullet(void**) {
    fixture f;
    const pli_vec3 pivot = pli_vec3_make(1, -2, 0.5f);
    f.add(80, *f.box, 1.0f, nullptr);
    f.add(72, *f.box, 0.5f, nullptr);
    f.add(8, *f.wall, 1.0f, nullptr);
    f.add(44, *f.other_box, 1.0f, &pivot);
    f.check_steps("default hardness");
    assert_int_equal(pli_body_set_anchor_hardness(f.body, 0.3f), PLI_OK);
    f.soft->m_cfg.kAHR = 0.3f;
    f.check_steps("hardness 0.3");
    assert_true(f.box->bullet->getLinearVelocity().length() > 0.01f);
}

// Two anchors on one node, one between a pinned node and a dynamic body; one removed, which leaves the order.
void test_shared_and_pinned_nodes_equal_bullet(void**) {
    fixture f;
    f.add(40, *f.box, 1.0f, nullptr);
    const pli_anchor_id removed = f.add(60, *f.box, 1.0f, nullptr);
    f.add(40, *f.other_box, 1.0f, nullptr);
    f.add(0, *f.other_box, 0.8f, nullptr);
    f.check_steps("all anchors");
    assert_int_equal(pli_body_remove_anchor(f.body, removed), PLI_OK);
    for (int i = 1; i + 1 < f.soft->m_anchors.size(); ++i) {
        f.soft->m_anchors[i] = f.soft->m_anchors[i + 1];
    }
    f.soft->m_anchors.pop_back();
    f.check_steps("one removed");
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_impulse_matrix_equals_bullet),
        cmocka_unit_test(test_anchors_equal_bullet),
        cmocka_unit_test(test_shared_and_pinned_nodes_equal_bullet),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
