// Joints between clusters, rigid bodies and the world against btSoftBody, bit for bit.

#include "oracle/bullet_clusters.hpp"

#include "sample_mesh.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>

namespace {

pli_mesh* ball(pli_context* context, pli_vec3 radii, pli_vec3 centre) {
    pli_mesh* mesh = nullptr;
    assert_int_equal(sample_create_ellipsoid(context, radii, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_translate(mesh, centre), PLI_OK);
    return mesh;
}

btSoftBody::Body bullet_end(const twin::soft_twin* soft, const twin::rigid_twin* rigid) {
    if (soft != nullptr) { return btSoftBody::Body(soft->bullet->m_clusters[0]); }
    return rigid != nullptr ? btSoftBody::Body(rigid->bullet.get()) : btSoftBody::Body();
}

pli_joint_end pliant_end(const twin::soft_twin* soft, const twin::rigid_twin* rigid) {
    pli_joint_end end = {};
    if (soft != nullptr) { end.body = soft->pliant; }
    if (rigid != nullptr) { end.rigid = rigid->pliant; }
    return end;
}

void add_linear(twin::soft_twin& a, int cluster, const twin::soft_twin* b, const twin::rigid_twin* rigid,
                pli_vec3 position, pli_joint_softness softness) {
    btSoftBody::LJoint::Specs specs;
    specs.erp = softness.error_reduction;
    specs.cfm = softness.velocity_factor;
    specs.split = softness.split;
    specs.position = twin::to_bullet(position);
    a.bullet->appendLinearJoint(specs, a.bullet->m_clusters[cluster], bullet_end(b, rigid));
    pli_linear_joint_def def = pli_linear_joint_def_default();
    def.cluster = cluster;
    def.other = pliant_end(b, rigid);
    def.position = position;
    def.softness = softness;
    assert_int_equal(pli_body_add_linear_joint(a.pliant, &def, nullptr), PLI_OK);
}

// A motor that reaches `goal` with a limited change per iteration, and a steering angle that swings.
struct motor : btSoftBody::AJoint::IControl {
    float goal = 0, largest_change = 0;
    float angle = 0, angle_per_step = 0;
    bool steers = false;
    float pliant_angle = 0;

    float drive(float present) const {
        const float change = goal - present;
        return present + (change < -largest_change  ? -largest_change
                          : change > largest_change ? largest_change
                                                    : change);
    }
    void Prepare(btSoftBody::AJoint* joint) override {
        if (!steers) { return; }
        angle += angle_per_step;
        joint->m_refs[0][0] = std::cos(angle);
        joint->m_refs[0][2] = std::sin(angle);
    }
    btScalar Speed(btSoftBody::AJoint*, btScalar present) override { return drive(present); }

    pli_joint_controller controller() {
        pli_joint_controller result = {};
        result.speed = [](float present, void* user) { return static_cast<const motor*>(user)->drive(present); };
        if (steers) {
            result.steer = [](pli_vec3 axis, void* user) {
                motor* self = static_cast<motor*>(user);
                self->pliant_angle += self->angle_per_step;
                return pli_vec3_make(std::cos(self->pliant_angle), axis.y, std::sin(self->pliant_angle));
            };
        }
        result.user = this;
        return result;
    }
};

void add_angular(twin::soft_twin& a, const twin::soft_twin* b, const twin::rigid_twin* rigid, pli_vec3 axis,
                 pli_joint_softness softness, motor* control) {
    btSoftBody::AJoint::Specs specs;
    specs.erp = softness.error_reduction;
    specs.cfm = softness.velocity_factor;
    specs.split = softness.split;
    specs.axis = twin::to_bullet(axis);
    if (control != nullptr) { specs.icontrol = control; }
    a.bullet->appendAngularJoint(specs, a.bullet->m_clusters[0], bullet_end(b, rigid));
    pli_angular_joint_def def = pli_angular_joint_def_default();
    def.other = pliant_end(b, rigid);
    def.axis = axis;
    def.softness = softness;
    if (control != nullptr) { def.controller = control->controller(); }
    assert_int_equal(pli_body_add_angular_joint(a.pliant, &def, nullptr), PLI_OK);
}

pli_cluster_settings shape_keeping() {
    pli_cluster_settings result = {};
    result.matching = 0.05f;
    result.node_damping = 0.05f;
    result.collides = true;
    result.max_self_impulse = 100;
    result.self_impulse_factor = 1;
    return result;
}

void run_linear(bool synchronize) {
    twin::cluster_scene s;
    btBoxShape box(btVector3(1, btScalar(0.5), 2));
    twin::soft_twin& soft = s.add(ball(s.context(), {1, 1.5f, 1}, {0, 5, 0}), 4, 2);
    twin::cluster_scene::set_cluster(soft, 0, shape_keeping());
    twin::cluster_scene::set_cluster(soft, 2, shape_keeping());
    s.set_velocity(soft, {2, 0, 1}, 1, 3);
    const btQuaternion tilt(btVector3(1, 2, 3).normalized(), btScalar(0.7));
    twin::rigid_twin& weight = s.add_rigid(box, 20, btTransform(tilt, btVector3(2, 3, 1)));
    weight.bullet->setAngularVelocity(btVector3(1, -2, 1));
    add_linear(soft, 0, nullptr, nullptr, {0.2f, 7, 0}, {1, 1, 1});
    add_linear(soft, 2, nullptr, &weight, {1, 4, 0.5f}, {0.5f, 0.9f, 0.25f});
    add_linear(soft, 3, nullptr, &weight, {1.5f, 4, -0.5f}, {1, 0.5f, 0});
    s.run(150, synchronize);
}

void test_linear_joints_equal_bullet(void**) {
    run_linear(false);
}

void test_linear_joints_synchronized_equal_bullet(void**) {
    run_linear(true);
}

// Two bodies, one hung from the world, with different numbers of iterations.
void test_joints_between_bodies_equal_bullet(void**) {
    twin::cluster_scene s;
    twin::soft_twin& upper = s.add(ball(s.context(), {1, 1, 1}, {0, 5, 0}), 1, 1);
    twin::soft_twin& lower = s.add(ball(s.context(), {1, 0.5f, 1}, {1.5f, 4, 0}), 1, 3);
    pli_clusters_def def = pli_clusters_def_default();
    def.reference_mode = true;
    def.iterations = 7;
    assert_int_equal(pli_body_enable_clusters(lower.pliant, &def), PLI_OK);
    lower.bullet->m_cfg.citerations = 7;
    s.set_velocity(upper, {0, 0, 2}, 0.5f, 7);
    s.set_velocity(lower, {-1, 0, 0}, 0.5f, 8);
    twin::cluster_scene::set_cluster(upper, 0, shape_keeping());
    twin::cluster_scene::set_cluster(lower, 0, shape_keeping());
    add_linear(upper, 0, nullptr, nullptr, {0, 6, 0}, {1, 1, 0.5f});
    add_linear(upper, 0, &lower, nullptr, {0.7f, 4.5f, 0}, {1, 1, 1});
    add_angular(lower, &upper, nullptr, {0, 0, 1}, {1, 1, 0.5f}, nullptr);
    s.run(150);
}

void run_hinge(bool synchronize) {
    twin::cluster_scene s;
    btBoxShape box(btVector3(1, btScalar(0.5), 2));
    twin::soft_twin& body = s.add(ball(s.context(), {2, 1, 1}, {0, 5, 0}), 1, 2);
    twin::soft_twin& wheel = s.add(ball(s.context(), {0.5f, 1, 1}, {2, 4, 0}), 1, 1);
    twin::rigid_twin& rigid = s.add_rigid(box, 5, btTransform(btQuaternion::getIdentity(), btVector3(-3, 5, 0)));
    rigid.bullet->setAngularVelocity(btVector3(1, 0, 2));
    twin::cluster_scene::set_cluster(body, 0, shape_keeping());
    twin::cluster_scene::set_cluster(wheel, 0, shape_keeping());
    motor drive, steer;
    drive.goal = 5;
    drive.largest_change = 0.3f;
    steer.steers = true;
    steer.angle_per_step = 0.002f;
    add_linear(body, 0, &wheel, nullptr, {2, 4, 0}, {1, 1, 1});
    add_angular(body, &wheel, nullptr, {1, 0, 0}, {1, 1, 1}, &steer);
    add_angular(body, nullptr, &rigid, {1, 0, 0}, {0.7f, 0.8f, 0.3f}, &drive);
    s.run(150, synchronize);
    pli_cluster_view hub, other;
    assert_int_equal(pli_body_get_cluster(body.pliant, 0, &hub), PLI_OK);
    assert_int_equal(pli_body_get_cluster(wheel.pliant, 0, &other), PLI_OK);
    print_message("           body turns at %.3f, wheel at %.3f, rigid at %.3f rad/s\n",
                  static_cast<double>(hub.angular_velocity.x), static_cast<double>(other.angular_velocity.x),
                  static_cast<double>(rigid.bullet->getAngularVelocity().x()));
}

void test_driven_and_steered_hinges_equal_bullet(void**) {
    run_hinge(false);
}

void test_driven_and_steered_hinges_synchronized_equal_bullet(void**) {
    run_hinge(true);
}

// A cluster with a pinned node weighs 1e18 kg, and its joints move even the pinned node.
void test_joint_of_pinned_cluster_equals_bullet(void**) {
    twin::cluster_scene s;
    btBoxShape box(btVector3(1, 1, 1));
    pli_mesh* mesh = nullptr;
    assert_int_equal(sample_create_sheet(s.context(), 7, 3, PLI_PATCH_PIN_00, &mesh), PLI_OK);
    twin::soft_twin& cloth = s.add(mesh, 3, 2);
    twin::rigid_twin& rigid = s.add_rigid(box, 3, btTransform(btQuaternion::getIdentity(), btVector3(1, 2, 1)));
    for (int i = 0; i < pli_body_cluster_count(cloth.pliant); ++i) {
        twin::cluster_scene::set_cluster(cloth, i, shape_keeping());
    }
    s.set_velocity(cloth, {0, 0, 0}, 0.5f, 21);
    add_linear(cloth, 1, nullptr, &rigid, {1, 3, 1}, {1, 1, 0.5f});
    add_linear(cloth, 2, nullptr, &rigid, {-1, 3, 1}, {0.5f, 1, 1});
    s.run(150);
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_linear_joints_equal_bullet),
        cmocka_unit_test(test_linear_joints_synchronized_equal_bullet),
        cmocka_unit_test(test_joints_between_bodies_equal_bullet),
        cmocka_unit_test(test_driven_and_steered_hinges_equal_bullet),
        cmocka_unit_test(test_driven_and_steered_hinges_synchronized_equal_bullet),
        cmocka_unit_test(test_joint_of_pinned_cluster_equals_bullet),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
