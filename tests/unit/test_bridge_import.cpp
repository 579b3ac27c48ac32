// What of a btSoftBody with clusters, joints and a rest shape comes into Pliant, and what is refused by name.
#include "pliant_bullet/import.h"

#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <cmath>
#include <cstring>

#include "check.h"
#include "test_bridge_world.h"

using namespace bridge_test;

namespace {

using Flags = btSoftBody::fCollision;

// A ball of radius 1 and 2 kg at a height, with clusters.
std::unique_ptr<btSoftBody> make_ball(btSoftBodyWorldInfo& info, btScalar height, int clusters) {
    std::unique_ptr<btSoftBody> ball(
        btSoftBodyHelpers::CreateEllipsoid(info, btVector3(0, height, 0), btVector3(1, 1, 1), 200));
    ball->setTotalMass(2);
    ball->getCollisionShape()->setMargin(btScalar(0.05));
    ball->generateClusters(clusters);
    return ball;
}

pli_vec3 xyz(const pli_vec4& v) {
    return pli_vec3_make(v.x, v.y, v.z);
}

// The largest extent along x less that along y.
float eccentricity(const pli_body* body) {
    const pli_bounds bounds = pli_body_get_bounds(body);
    return bounds.max.x - bounds.min.x - (bounds.max.y - bounds.min.y);
}

void stretch(btSoftBody& ball) {
    for (int i = 0; i < ball.m_nodes.size(); ++i) {
        ball.m_nodes[i].m_x.setX(ball.m_nodes[i].m_x.x() * btScalar(1.3));
    }
}

bool names(const std::vector<std::string>& list, const char* text) {
    for (const std::string& line : list) {
        if (line.find(text) != std::string::npos) { return true; }
    }
    return false;
}

} // namespace

static void test_a_body_with_cluster_contacts_lands(void**) {
    StockWorld stock;
    stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    pliant::Bridge bridge(*stock.world);
    btSoftBodyWorldInfo info;
    const std::unique_ptr<btSoftBody> ball = make_ball(info, 2, 8);
    ball->m_cfg.collisions = Flags::CL_RS | Flags::CL_SS | Flags::CL_SELF;
    ball->m_cfg.citerations = 6;
    ball->m_cfg.kSRHR_CL = btScalar(0.3);
    ball->m_clusters[1]->m_matching = btScalar(0.25);
    ball->m_clusters[2]->m_ldamping = btScalar(0.125);
    pliant::ImportedBody parameters{};
    pli_mesh* mesh = nullptr;
    assert_int_equal(pliant::import_soft_body(bridge.context(), *ball, &mesh, &parameters), PLI_OK);
    pli_mesh_destroy(mesh);
    assert_true(parameters.has_cluster_contacts && parameters.cluster_contacts.with_rigids &&
                parameters.cluster_contacts.with_bodies && parameters.cluster_contacts.with_self);
    check_near(parameters.cluster_contacts.dynamic_hardness, 0.3, 1e-6);
    assert_int_equal(parameters.cluster_iterations, 6);
    assert_true(parameters.not_taken.empty());

    pli_body* body = nullptr;
    assert_int_equal(pliant::import_soft_body(bridge, *ball, &body), PLI_OK);
    assert_int_equal(pli_body_cluster_count(body), ball->m_clusters.size());
    for (int i = 0; i < ball->m_clusters.size(); ++i) {
        pli_cluster_view view;
        pli_cluster_settings settings;
        assert_int_equal(pli_body_get_cluster(body, i, &view), PLI_OK);
        assert_int_equal(pli_body_get_cluster_settings(body, i, &settings), PLI_OK);
        assert_int_equal(view.node_count, ball->m_clusters[i]->m_nodes.size());
        check_near(settings.matching, ball->m_clusters[i]->m_matching, 1e-7);
        check_near(settings.linear_damping, ball->m_clusters[i]->m_ldamping, 1e-7);
        assert_int_equal(settings.collides, ball->m_clusters[i]->m_collide);
    }
    stock.step(240);
    assert_true(lowest(body) > -0.3f);
}

// A ball that is stretched when it is imported returns to what it was, by its clusters or by its pose.
static void test_rest_shapes_come_along(void**) {
    btSoftBodyWorldInfo info;
    for (const bool by_clusters : {true, false}) {
        StockWorld stock(btVector3(0, 0, 0));
        pliant::Bridge bridge(*stock.world);
        const std::unique_ptr<btSoftBody> ball = make_ball(info, 0, by_clusters ? 1 : 2);
        if (by_clusters) {
            ball->m_clusters[0]->m_matching = 1;
        } else {
            ball->setPose(false, true);
            ball->m_cfg.kMT = 1;
        }
        ball->m_cfg.piterations = 0; // no links
        stretch(*ball);
        pli_body* body = nullptr;
        assert_int_equal(pliant::import_soft_body(bridge, *ball, &body), PLI_OK);
        assert_true(eccentricity(body) > 0.5f); // it is as it was
        check_near(xyz(pli_body_get_view(body).positions[7]).x, ball->m_nodes[7].m_x.x(), 1e-6);
        stock.step(10);
        check_at_most(std::fabs(eccentricity(body)), 0.05);
    }
}

static void test_the_rest_volume_comes_along(void**) {
    btSoftBodyWorldInfo info;
    StockWorld stock(btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    const std::unique_ptr<btSoftBody> ball = make_ball(info, 0, 1);
    ball->setPose(true, false);
    ball->m_cfg.kVC = 20;
    ball->m_cfg.kDP = btScalar(0.05);
    for (int i = 0; i < ball->m_links.size(); ++i) {
        ball->m_links[i].m_material->m_kLST = btScalar(0.01);
    }
    stretch(*ball);
    pli_body* body = nullptr;
    assert_int_equal(pliant::import_soft_body(bridge, *ball, &body), PLI_OK);
    const double rest = double(ball->m_pose.m_volume);
    check_near(double(pli_body_volume(body)) / rest, 1.3, 0.01);
    stock.step(300);
    check_near(double(pli_body_volume(body)) / rest, 1, 0.03);
    ball->m_pose.m_volume *= 2;
    std::vector<std::string> not_taken;
    assert_int_equal(pliant::import_soft_body(bridge, *ball, &body, 1, -1, &not_taken), PLI_ERROR_INVALID_VALUE);
    assert_true(names(not_taken, "rest volume"));
    assert_non_null(std::strstr(pli_last_error(bridge.context()), "import_soft_body: cannot be taken over: "));
}

// After so many steps of 1/60 s in a world of btSoftBody's own.
static float lowest_of_bullet(btSoftBody& ball, btRigidBody& hook, int steps) {
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    btSoftBodyWorldInfo& info = world.getWorldInfo();
    info.m_dispatcher = &dispatcher;
    info.m_broadphase = &broadphase;
    info.m_sparsesdf.Initialize();
    ball.m_worldInfo = &info;
    btRigidBody twin(0, nullptr, hook.getCollisionShape());
    twin.setWorldTransform(hook.getWorldTransform());
    for (int i = 0; i < ball.m_joints.size(); ++i) {
        ball.m_joints[i]->m_bodies[1] = btSoftBody::Body(&twin);
    }
    world.addRigidBody(&twin);
    world.addSoftBody(&ball);
    for (int i = 0; i < steps; ++i) {
        world.stepSimulation(1 / btScalar(60), 0);
    }
    btScalar lowest = SIMD_INFINITY;
    for (int i = 0; i < ball.m_nodes.size(); ++i) {
        lowest = btMin(lowest, ball.m_nodes[i].m_x.y());
    }
    world.removeSoftBody(&ball);
    world.removeRigidBody(&twin);
    return static_cast<float>(lowest);
}

static void test_joints_come_along(void**) {
    btSoftBodyWorldInfo info;
    StockWorld stock;
    btRigidBody& hook = stock.add_box(btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.1)), 0, btVector3(0, 5, 0));
    pliant::Bridge bridge(*stock.world);
    const std::unique_ptr<btSoftBody> ball = make_ball(info, 2, 1);
    ball->m_clusters[0]->m_matching = btScalar(0.5);
    btSoftBody::LJoint::Specs ball_joint;
    ball_joint.position = btVector3(0, 3, 0);
    ball_joint.erp = btScalar(0.5);
    ball->appendLinearJoint(ball_joint, btSoftBody::Body(&hook));
    btSoftBody::AJoint::Specs hinge;
    hinge.axis = btVector3(0, 0, 1);
    ball->appendAngularJoint(hinge, btSoftBody::Body(&hook));
    pli_body* body = nullptr;
    std::vector<std::string> not_taken{"of before"};
    assert_int_equal(pliant::import_soft_body(bridge, *ball, &body, 1, -1, &not_taken), PLI_OK);
    assert_true(not_taken.empty());
    assert_int_equal(pli_body_joint_count(body), 2);
    stock.step(180);
    check_near(lowest(body), lowest_of_bullet(*ball, hook, 180), 1e-4);
}

static void test_what_cannot_be_taken_is_named(void**) {
    btSoftBodyWorldInfo info;
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    const std::unique_ptr<btSoftBody> ball = make_ball(info, 2, 1), other = make_ball(info, 2, 1);
    btSoftBody::LJoint::Specs ball_joint;
    ball_joint.position = btVector3(0, 2, 0);
    ball->appendLinearJoint(ball_joint, other.get());
    struct Motor final : btSoftBody::AJoint::IControl {
        btScalar Speed(btSoftBody::AJoint*, btScalar) override { return 1; }
    } motor;
    btSoftBody::AJoint::Specs hinge;
    hinge.axis = btVector3(0, 0, 1);
    hinge.icontrol = &motor;
    ball->appendAngularJoint(hinge, btSoftBody::Body());
    ball->appendLinearJoint(ball_joint, btSoftBody::Body());
    ball->m_joints[2]->m_refs[1] += btVector3(1, 0, 0);
    ball->m_cfg.collisions |= Flags::SDF_RDF;
    std::vector<std::string> not_taken;
    pli_body* body = nullptr;
    assert_int_equal(pliant::import_soft_body(bridge, *ball, &body, 1, -1, &not_taken), PLI_ERROR_INVALID_VALUE);
    assert_null(body);
    assert_int_equal(stock.world->getNumCollisionObjects(), 0);
    assert_int_equal(not_taken.size(), 4);
    assert_true(names(not_taken, "joint 0: its other end is a cluster of another btSoftBody"));
    assert_true(names(not_taken, "joint 1: it has an IControl"));
    assert_true(names(not_taken, "joint 2: its ends are apart"));
    assert_true(names(not_taken, "deformable bodies: 256"));
    assert_int_equal(pliant::import_soft_body(bridge, *ball, &body), PLI_ERROR_INVALID_VALUE);
}

int main() {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_body_with_cluster_contacts_lands), cmocka_unit_test(test_rest_shapes_come_along),
        cmocka_unit_test(test_the_rest_volume_comes_along),        cmocka_unit_test(test_joints_come_along),
        cmocka_unit_test(test_what_cannot_be_taken_is_named),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
