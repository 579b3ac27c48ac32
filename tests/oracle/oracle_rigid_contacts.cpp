// Contacts with rigid bodies against btSoftBody: the contacts themselves, the solve and the impulses on the rigid body,
// bit for bit. The rigid shape is a lattice over Bullet's own distances; the order of the contacts is taken from
// Bullet.

#include "check.h"
#include "sample_mesh.h"

#include "oracle/bullet_shape.hpp"

#include <pliant/bullet_reference.h>
#include <pliant/contact.h>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <algorithm>

namespace {

constexpr float dt = 1.0f / 60.0f;

struct settings {
    float mass = 0; // of the rigid body
    float friction = 0.5f;
    int iterations = 1;
    int steps = 150;
    btVector3 velocity{0, 0, 0}, spin{0, 0, 0};
    btTransform pose = btTransform::getIdentity();
    bool is_kinematic = false;
    bool has_pins = false;
};

struct outcome {
    int contacts = 0;
    int exact_steps = 0;
};

class scene {
public:
    scene(const settings& s, btConvexShape& shape) : m_settings(s), m_info(twin::world_info()) {
        assert_int_equal(pli_context_create(nullptr, &m_context), PLI_OK);
        pli_world_def world_def = pli_world_def_default();
        world_def.reference_mode = true;
        assert_int_equal(pli_world_create(m_context, &world_def, &m_world), PLI_OK);
        pli_mesh* mesh = nullptr;
        assert_int_equal(sample_create_sheet(m_context, 9, 0.6f, s.has_pins ? 15 : 0, &mesh), PLI_OK);
        m_soft = twin::make_soft_body(m_info, mesh);
        pli_body_def def = pli_body_def_default();
        def.solver.position_iterations = s.iterations;
        assert_int_equal(pli_body_create(m_world, mesh, &def, &m_body), PLI_OK);
        pli_mesh_destroy(mesh);
        m_soft->m_cfg.piterations = s.iterations;
        m_soft->m_cfg.kDF = btScalar(0.7f);
        pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
        contacts.friction = 0.7f;
        assert_int_equal(pli_body_enable_rigid_contacts(m_body, &contacts), PLI_OK);

        btVector3 inertia(0, 0, 0);
        if (s.mass > 0) { shape.calculateLocalInertia(s.mass, inertia); }
        btRigidBody::btRigidBodyConstructionInfo info(s.mass, nullptr, &shape, inertia);
        info.m_startWorldTransform = s.pose;
        info.m_friction = s.friction;
        m_rigid = std::make_unique<btRigidBody>(info);
        if (s.is_kinematic) {
            m_rigid->setCollisionFlags(m_rigid->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
        }
        m_rigid->setLinearVelocity(s.velocity);
        m_rigid->setAngularVelocity(s.spin);
        pli_shape* lattice = twin::make_lattice(m_context, shape);
        pli_rigid_def rigid = pli_rigid_def_default();
        rigid.kind = s.is_kinematic ? PLI_RIGID_KINEMATIC : s.mass > 0 ? PLI_RIGID_DYNAMIC : PLI_RIGID_STATIC;
        rigid.state = twin::rigid_state(*m_rigid);
        rigid.friction = s.friction;
        rigid.shape_count = 1;
        rigid.shapes = &lattice;
        assert_int_equal(pli_rigid_create(m_world, &rigid, &m_proxy), PLI_OK);
        pli_shape_release(lattice);
    }
    ~scene() {
        pli_world_destroy(m_world);
        pli_context_destroy(m_context);
    }

    // Both engines make the same step from the same state.
    outcome run() {
        outcome result;
        for (int i = 0; i < m_settings.steps; ++i) {
            const pli_rigid_state state = twin::rigid_state(*m_rigid);
            assert_int_equal(pli_rigid_set_state(m_proxy, &state), PLI_OK);
            m_soft->predictMotion(dt);
            assert_int_equal(pli_world_predict(m_world, dt), PLI_OK);
            const btCollisionObjectWrapper wrapper(nullptr, m_rigid->getCollisionShape(), m_rigid.get(),
                                                   m_rigid->getWorldTransform(), -1, -1);
            m_soft->defaultCollisionHandler(&wrapper);
            assert_int_equal(pli_world_collide_rigid(m_world, m_body, m_proxy), PLI_OK);
            result.contacts += compare_contacts();
            m_soft->solveConstraints();
            m_soft->integrateMotion();
            assert_int_equal(pli_world_solve(m_world), PLI_OK);
            const twin::difference difference = twin::compare(*m_soft, m_body);
            check_near(difference.position, 0, 0);
            check_near(difference.velocity, 0, 0);
            const pli_rigid_state after = pli_rigid_get_state(m_proxy), expected = twin::rigid_state(*m_rigid);
            check_near(twin::distance(after.linear_velocity, expected.linear_velocity), 0, 0);
            check_near(twin::distance(after.angular_velocity, expected.angular_velocity), 0, 0);
            assert_int_equal(pli_rigid_was_touched(m_proxy), m_soft->m_rcontacts.size() > 0);
            ++result.exact_steps;
            move_rigid();
        }
        return result;
    }

private:
    // The same nodes have contacts, with the same numbers; ours come into Bullet's order.
    int compare_contacts() {
        const int count = pli_body_get_rigid_contacts(m_body, 0, nullptr);
        assert_int_equal(count, m_soft->m_rcontacts.size());
        std::vector<pli_rigid_contact> ours(static_cast<std::size_t>(count));
        pli_body_get_rigid_contacts(m_body, count, ours.data());
        std::vector<int> order;
        for (int i = 0; i < count; ++i) {
            const btSoftBody::RContact& theirs = m_soft->m_rcontacts[i];
            const int node = static_cast<int>(theirs.m_node - &m_soft->m_nodes[0]);
            const auto found = std::find_if(ours.begin(), ours.end(),
                                            [&](const pli_rigid_contact& contact) { return contact.node == node; });
            assert_true(found != ours.end());
            check_near(twin::distance(found->normal, twin::to_pliant(theirs.m_cti.m_normal)), 0, 0);
            order.push_back(static_cast<int>(found - ours.begin()));
        }
        assert_int_equal(pli_body_reorder_rigid_contacts(m_body, order.data(), count), PLI_OK);
        return count;
    }

    void move_rigid() {
        if (m_rigid->isStaticObject()) { return; }
        if (!m_settings.is_kinematic) {
            m_rigid->setLinearVelocity(m_rigid->getLinearVelocity() + btVector3(0, -10, 0) * dt);
        }
        btTransform next;
        m_rigid->predictIntegratedTransform(dt, next);
        m_rigid->setWorldTransform(next);
        m_rigid->updateInertiaTensor();
    }

    settings m_settings;
    btSoftBodyWorldInfo m_info;
    pli_context* m_context = nullptr;
    pli_world* m_world = nullptr;
    pli_body* m_body = nullptr;
    pli_rigid* m_proxy = nullptr;
    std::unique_ptr<btSoftBody> m_soft;
    std::unique_ptr<btRigidBody> m_rigid;
};

void check_scene(const settings& s, btConvexShape&& shape) {
    const outcome result = scene(s, shape).run();
    assert_int_equal(result.exact_steps, s.steps);
    print_message("           %d contacts in %d steps, all exact\n", result.contacts, result.exact_steps);
    assert_true(result.contacts > 100);
}

void test_rigid_contacts_static_sphere(void**) {
    settings s;
    s.iterations = 3;
    check_scene(s, btSphereShape(1));
}

void test_rigid_contacts_static_tilted_box(void**) {
    settings s;
    s.pose.setRotation(btQuaternion(btScalar(0.3), btScalar(0.4), btScalar(0.2)));
    s.iterations = 2;
    check_scene(s, btBoxShape(btVector3(2, btScalar(0.3), 2)));
}

void test_rigid_contacts_static_box_with_much_friction(void**) {
    settings s;
    s.friction = 3; // times 0.7: more than 1, sliding is reversed as in Bullet
    s.pose.setRotation(btQuaternion(0, btScalar(0.6), 0));
    check_scene(s, btBoxShape(btVector3(3, btScalar(0.3), 3)));
}

void test_rigid_contacts_dynamic_sphere(void**) {
    settings s;
    s.mass = 5;
    s.pose.setOrigin(btVector3(btScalar(0.2), 2, 0));
    s.velocity.setValue(1, -3, btScalar(0.5));
    s.spin.setValue(3, 2, 1);
    s.has_pins = true;
    s.iterations = 2;
    check_scene(s, btSphereShape(btScalar(0.8)));
}

void test_rigid_contacts_dynamic_box(void**) {
    settings s;
    s.mass = 20;
    s.pose.setOrigin(btVector3(0, btScalar(1.5), btScalar(0.1)));
    s.spin.setValue(0, 5, 1);
    s.has_pins = true;
    check_scene(s, btBoxShape(btVector3(btScalar(0.7), btScalar(0.3), btScalar(0.5))));
}

void test_rigid_contacts_kinematic_capsule(void**) {
    settings s;
    s.is_kinematic = true;
    s.velocity.setValue(btScalar(0.5), btScalar(0.2), 0);
    s.spin.setValue(0, 2, 0);
    check_scene(s, btCapsuleShape(btScalar(0.4), 2));
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_rigid_contacts_static_sphere),
        cmocka_unit_test(test_rigid_contacts_static_tilted_box),
        cmocka_unit_test(test_rigid_contacts_static_box_with_much_friction),
        cmocka_unit_test(test_rigid_contacts_dynamic_sphere),
        cmocka_unit_test(test_rigid_contacts_dynamic_box),
        cmocka_unit_test(test_rigid_contacts_kinematic_capsule),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
