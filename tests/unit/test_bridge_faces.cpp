// Face contacts through the bridge: Bullet moves its bodies before the soft bodies are solved.

#include "check.h"
#include "pierced.h"
#include "unit/test_bridge_world.h"

#include <pliant/contact.h>
#include <pliant/generate.h>

using namespace bridge_test;

namespace {

// 1 m x 1 m in cells of 10 cm, 0.2 kg, pinned at its corners, at y = 0.
pli_body* add_cloth(pliant::Bridge& bridge, bool with_faces) {
    pli_mesh* mesh = make_sheet(bridge.context(), 1, 0, 11, PLI_PATCH_PIN_CORNERS);
    assert_int_equal(pli_mesh_set_total_mass_from_faces(mesh, 0.2f), PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.005f;
    def.solver.position_iterations = 10;
    pli_body* body = nullptr;
    assert_int_equal(bridge.add_body(mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    const pli_rigid_contacts_def nodes = pli_rigid_contacts_def_default();
    assert_int_equal(pli_body_enable_rigid_contacts(body, &nodes), PLI_OK);
    const pli_rigid_face_contacts_def faces = pli_rigid_face_contacts_def_default();
    if (with_faces) { assert_int_equal(pli_body_enable_rigid_face_contacts(body, &faces), PLI_OK); }
    return body;
}

pli_vec3 place(const btRigidBody& body) {
    const btVector3& p = body.getWorldTransform().getOrigin();
    return pli_vec3_make(float(p.x()), float(p.y()), float(p.z()));
}

// Steps in which the centre of the body went through the cloth.
int run(StockWorld& stock, const pli_body* cloth, const btRigidBody& body, double seconds, btScalar dt) {
    int count = 0;
    for (int i = 0; i < int(seconds / double(dt) + 0.5); ++i) {
        const pierced_moment before = pierced_look(cloth, place(body));
        stock.step(1, dt);
        const pierced_moment after = pierced_look(cloth, place(body));
        count += pierced_face(cloth, &before, &after) != PLI_NULL_INDEX;
    }
    assert_false(pli_body_is_frozen(cloth));
    return count;
}

int shoot(btCollisionShape* shape, btScalar mass, btVector3 position, btScalar speed, btQuaternion rotation,
          btScalar dt, pliant::CollisionMode mode, bool with_faces) {
    StockWorld stock;
    pliant::BridgeDef def;
    def.mode = mode;
    pliant::Bridge bridge(*stock.world, def);
    const pli_body* cloth = add_cloth(bridge, with_faces);
    btRigidBody& body = stock.add_body(shape, mass, position, rotation);
    body.setLinearVelocity(btVector3(0, -speed, 0));
    return run(stock, cloth, body, 0.8, dt);
}

const btScalar spots[4][2] = {{btScalar(0.03), btScalar(0.02)},
                              {0, btScalar(0.05)},
                              {btScalar(0.003), btScalar(0.002)},
                              {btScalar(0.05), btScalar(0.05)}};

void test_balls_do_not_pass_a_coarse_cloth(void**) {
    for (int c = 0; c < 16; ++c) {
        const btScalar radius = (c & 1) != 0 ? btScalar(0.02) : btScalar(0.01);
        const btScalar mass = (c & 2) != 0 ? btScalar(1) : btScalar(0.001);
        const btScalar dt = btScalar(1) / ((c & 4) != 0 ? 120 : 60);
        const btScalar* spot = spots[(c + (c >> 2)) & 3];
        const btScalar height = radius + btScalar(0.035) + btScalar(0.007) * btScalar(c % 5);
        const int passed = shoot(new btSphereShape(radius), mass, btVector3(spot[0], height, spot[1]), 5,
                                 btQuaternion::getIdentity(), dt, pliant::CollisionMode::exact, true);
        if (passed != 0) { fail_msg("case %d: the ball passed", c); }
    }
}

void test_balls_pass_without_face_contacts(void**) {
    for (const btScalar mass : {btScalar(0.001), btScalar(1)}) {
        assert_int_not_equal(shoot(new btSphereShape(btScalar(0.01)), mass,
                                   btVector3(spots[0][0], btScalar(0.05), spots[0][1]), 5, btQuaternion::getIdentity(),
                                   btScalar(1) / 60, pliant::CollisionMode::exact, false),
                             0);
    }
}

// The lattice is for distances of nodes; faces meet the convex shape itself.
void test_balls_do_not_pass_in_reference_mode(void**) {
    for (const btScalar* spot : spots) {
        assert_int_equal(shoot(new btSphereShape(btScalar(0.02)), btScalar(0.05),
                               btVector3(spot[0], btScalar(0.06), spot[1]), 5, btQuaternion::getIdentity(),
                               btScalar(1) / 60, pliant::CollisionMode::reference, true),
                         0);
    }
}

void test_boxes_and_sticks_do_not_pass_a_coarse_cloth(void**) {
    const btQuaternion corner_down = shortestArcQuat(btVector3(1, 1, 1).normalized(), btVector3(0, -1, 0));
    const btScalar half = btScalar(0.05);
    for (int c = 0; c < 32; ++c) {
        const btScalar dt = btScalar(1) / ((c & 1) != 0 ? 120 : 60);
        const bool is_box = (c & 2) == 0;
        const btScalar* spot = spots[(c >> 2) & 3];
        const btScalar box_mass = (c & 16) != 0 ? 1 : btScalar(0.1);
        const int passed = is_box ? shoot(new btBoxShape(btVector3(half, half, half)), box_mass,
                                          btVector3(spot[0], btScalar(1.09), spot[1]), 0, corner_down, dt,
                                          pliant::CollisionMode::exact, true)
                                  : shoot(new btCapsuleShapeX(btScalar(0.005), btScalar(0.3)), btScalar(0.02),
                                          btVector3(spot[0], btScalar(0.04), spot[1]), 3, btQuaternion::getIdentity(),
                                          dt, pliant::CollisionMode::exact, true);
        if (passed != 0) { fail_msg("case %d: it passed", c); }
    }
}

// The step that holds the ball back also puts it where its new velocity would have brought it.
void test_a_held_ball_is_moved_back(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    pli_world_set_gravity(bridge.world(), pli_vec3_make(0, 0, 0));
    const pli_body* cloth = add_cloth(bridge, true);
    const btScalar radius = btScalar(0.01), mass = btScalar(0.01), dt = btScalar(1) / 60;
    btRigidBody& ball =
        stock.add_body(new btSphereShape(radius), mass, btVector3(btScalar(0.03), btScalar(0.05), btScalar(0.02)));
    ball.setLinearVelocity(btVector3(0, -6, 0));
    stock.step(1, dt);
    const double speed = -double(ball.getLinearVelocity().y());
    assert_true(speed > 0 && speed < 5.5);
    check_near(place(ball).y, 0.05 - speed / 60, 1e-6);
    check_near(pli_body_momentum(cloth).y + float(mass * ball.getLinearVelocity().y()), -0.06, 1e-6);
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_balls_do_not_pass_a_coarse_cloth),
        cmocka_unit_test(test_balls_pass_without_face_contacts),
        cmocka_unit_test(test_balls_do_not_pass_in_reference_mode),
        cmocka_unit_test(test_boxes_and_sticks_do_not_pass_a_coarse_cloth),
        cmocka_unit_test(test_a_held_ball_is_moved_back),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
