// Contacts of clusters against btSoftBody (CL_RS, CL_SS), bit for bit, with distances by Bullet's GJK and EPA: the same
// pairs, the drift and the friction of each contact, the impulses on rigid bodies and on other clusters.

#include "oracle/bullet_clusters.hpp"

#include "sample_mesh.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

namespace {

pli_mesh* ball(pli_context* context, pli_vec3 radii, pli_vec3 centre) {
    pli_mesh* mesh = nullptr;
    assert_int_equal(sample_create_ellipsoid(context, radii, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_translate(mesh, centre), PLI_OK);
    return mesh;
}

void keep_shape(twin::soft_twin& soft, float matching) {
    for (int i = 0; i < pli_body_cluster_count(soft.pliant); ++i) {
        pli_cluster_settings settings;
        assert_int_equal(pli_body_get_cluster_settings(soft.pliant, i, &settings), PLI_OK);
        settings.matching = matching;
        twin::cluster_scene::set_cluster(soft, i, settings);
    }
}

void run_static_box(bool synchronize) {
    twin::cluster_scene s;
    btBoxShape box(btVector3(5, 1, 5));
    const btQuaternion tilt(btVector3(1, 0, 1).normalized(), btScalar(0.2));
    s.add_rigid(box, 0, btTransform(tilt, btVector3(0, -1, 0)), 0.15f);
    twin::soft_twin& soft = s.add(ball(s.context(), {1, 0.8f, 1}, {0, 1.6f, 0}), 8, 2);
    keep_shape(soft, 0.1f);
    s.enable_contacts(soft, pli_cluster_contacts_def_default());
    s.set_velocity(soft, {2, 0, 1}, 0.5f, 3);
    const int contacts = s.run(150, synchronize);
    print_message("           %d contacts\n", contacts);
    assert_true(contacts > 150);
}

void test_static_box_equals_bullet(void**) {
    run_static_box(false);
}

void test_static_box_synchronized_equals_bullet(void**) {
    run_static_box(true);
}

void test_dynamic_sphere_equals_bullet(void**) {
    twin::cluster_scene s;
    btSphereShape sphere(btScalar(0.7));
    twin::rigid_twin& rigid =
        s.add_rigid(sphere, 8, btTransform(btQuaternion::getIdentity(), btVector3(0, 3, 0)), 0.6f);
    rigid.bullet->setAngularVelocity(btVector3(2, 0, 5));
    pli_mesh* mesh = nullptr;
    assert_int_equal(sample_create_sheet(s.context(), 9, 0, 15, &mesh), PLI_OK);
    twin::soft_twin& cloth = s.add(mesh, 12, 4);
    pli_cluster_contacts_def def = pli_cluster_contacts_def_default();
    def.friction = 0.4f;
    def.dynamic_hardness = 0.2f;
    def.dynamic_split = 0.3f;
    s.enable_contacts(cloth, def);
    const int contacts = s.run(300);
    print_message("           %d contacts\n", contacts);
    assert_true(contacts > 20);
}

void test_compound_equals_bullet(void**) {
    twin::cluster_scene s;
    btBoxShape box(btVector3(btScalar(0.3), btScalar(0.3), 3));
    btCapsuleShape capsule(btScalar(0.3), 2);
    btCompoundShape compound;
    compound.addChildShape(btTransform(btQuaternion(btVector3(0, 1, 0), btScalar(0.3)), btVector3(1, 0, 0)), &box);
    compound.addChildShape(btTransform(btQuaternion(btVector3(1, 0, 0), btScalar(1.5)), btVector3(-1, 0, 0)), &capsule);
    s.add_rigid(compound, 0, btTransform(btQuaternion::getIdentity(), btVector3(0, -1, 0)), 0.5f);
    twin::rigid_twin& falling =
        s.add_rigid(compound, 12, btTransform(btQuaternion::getIdentity(), btVector3(0, 4, 0)), 0.5f);
    falling.bullet->setAngularVelocity(btVector3(0, 1, 0));
    twin::soft_twin& soft = s.add(ball(s.context(), {2, 0.8f, 2}, {0, 1, 0}), 12, 3);
    keep_shape(soft, 0.05f);
    s.enable_contacts(soft, pli_cluster_contacts_def_default());
    const int contacts = s.run(150);
    print_message("           %d contacts\n", contacts);
    assert_true(contacts > 500);
}

void run_two_bodies(bool synchronize) {
    twin::cluster_scene s;
    btBoxShape floor(btVector3(10, 1, 10));
    s.add_rigid(floor, 0, btTransform(btQuaternion::getIdentity(), btVector3(0, -2, 0)), 1);
    twin::soft_twin& lower = s.add(ball(s.context(), {1, 1, 1}, {0, 0.5f, 0}), 6, 2);
    twin::soft_twin& upper = s.add(ball(s.context(), {0.7f, 0.7f, 1}, {0.4f, 2.5f, 0.2f}), 3, 1);
    keep_shape(lower, 0.1f);
    keep_shape(upper, 0.05f);
    pli_cluster_contacts_def def = pli_cluster_contacts_def_default();
    s.enable_contacts(lower, def);
    def.friction = 0.7f;
    def.soft_hardness = 0.9f;
    def.soft_split = 0.2f;
    s.enable_contacts(upper, def);
    s.set_velocity(upper, {-0.5f, -2, 0}, 0.3f, 9);
    // CL_RS and CL_SS are different masks, so both work at a time.
    const int contacts = s.run(150, synchronize);
    print_message("           %d contacts\n", contacts);
    assert_true(contacts > 250);
}

void test_two_bodies_equal_bullet(void**) {
    run_two_bodies(false);
}

void test_two_bodies_synchronized_equal_bullet(void**) {
    run_two_bodies(true);
}

// A cluster with a pinned node does not meet what is static, but meets what is dynamic.
void test_pinned_clusters_equal_bullet(void**) {
    twin::cluster_scene s;
    btBoxShape box(btVector3(1, btScalar(0.5), 1));
    s.add_rigid(box, 0, btTransform(btQuaternion::getIdentity(), btVector3(0, 0, 0)));
    s.add_rigid(box, 5, btTransform(btQuaternion::getIdentity(), btVector3(2, 2, 2)));
    pli_mesh* mesh = nullptr;
    assert_int_equal(sample_create_sheet(s.context(), 9, 0.8f, PLI_PATCH_PIN_11, &mesh), PLI_OK);
    twin::soft_twin& cloth = s.add(mesh, 4, 3);
    s.enable_contacts(cloth, pli_cluster_contacts_def_default());
    const int contacts = s.run(100);
    print_message("           %d contacts\n", contacts);
    assert_true(contacts > 100);
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_static_box_equals_bullet),
        cmocka_unit_test(test_static_box_synchronized_equals_bullet),
        cmocka_unit_test(test_dynamic_sphere_equals_bullet),
        cmocka_unit_test(test_compound_equals_bullet),
        cmocka_unit_test(test_two_bodies_equal_bullet),
        cmocka_unit_test(test_two_bodies_synchronized_equal_bullet),
        cmocka_unit_test(test_pinned_clusters_equal_bullet),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
