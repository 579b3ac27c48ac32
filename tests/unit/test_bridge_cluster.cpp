// Clusters through the bridge: contacts with every kind of Bullet's shapes, pushing both ways, joints, and the
// distances by Bullet's GJK.
#include "check.h"
#include "test_bridge_world.h"

#include "pliant_bullet/cluster_distance.h"

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>

#include <cmath>

using namespace bridge_test;

namespace {

// A torus round the y axis.
pli_mesh* make_torus(pli_context* context, float radius, float tube, pli_vec3 centre) {
    constexpr int rings = 16, segments = 8;
    std::vector<pli_vec3> points;
    std::vector<int> triangles;
    const float turn = 6.2831853f;
    for (int i = 0; i < rings; ++i) {
        for (int k = 0; k < segments; ++k) {
            const float a = turn * static_cast<float>(i) / rings, b = turn * static_cast<float>(k) / segments;
            const float r = radius + tube * std::cos(b);
            points.push_back(pli_vec3_add(centre, pli_vec3_make(r * std::cos(a), tube * std::sin(b), r * std::sin(a))));
            const int next = (i + 1) % rings * segments, above = (k + 1) % segments;
            const int corners[6] = {i * segments + k,     i * segments + above, next + k,
                                    i * segments + above, next + above,         next + k};
            triangles.insert(triangles.end(), corners, corners + 6);
        }
    }
    pli_mesh* mesh = nullptr;
    assert_int_equal(pli_mesh_create_from_triangles(context, static_cast<int>(points.size()), points.data(),
                                                    static_cast<int>(triangles.size() / 3), triangles.data(), false,
                                                    &mesh),
                     PLI_OK);
    return mesh;
}

// Takes the mesh. Keeps its shape.
pli_body* add_clusters(pliant::Bridge& bridge, pli_mesh* mesh, float mass, int clusters,
                       const pli_cluster_contacts_def& contacts) {
    assert_int_equal(pli_mesh_set_total_mass(mesh, mass), PLI_OK);
    pli_body_def def = pli_body_def_default();
    def.collision_margin = 0.05f;
    def.solver.position_iterations = 4;
    def.solver.velocity_damping = 0.02f;
    pli_body* body = nullptr;
    assert_int_equal(bridge.add_body(mesh, &def, &body), PLI_OK);
    pli_mesh_destroy(mesh);
    assert_int_equal(pli_body_generate_clusters(body, clusters, 100, nullptr), PLI_OK);
    for (int i = 0; i < pli_body_cluster_count(body); ++i) {
        pli_cluster_settings settings;
        assert_int_equal(pli_body_get_cluster_settings(body, i, &settings), PLI_OK);
        settings.matching = 0.3f;
        assert_int_equal(pli_body_set_cluster_settings(body, i, &settings), PLI_OK);
    }
    assert_int_equal(pli_body_enable_cluster_contacts(body, &contacts), PLI_OK);
    return body;
}

float speed_of(const pli_body* body) {
    return std::sqrt(2 * pli_body_kinetic_energy(body) / pli_body_total_mass(body));
}

// ------------------------------------------------------------------------------------------------ pushing both ways

void test_a_torus_and_a_stack_of_boxes_push_each_other(void**) {
    for (const auto mode : {pliant::CollisionMode::exact, pliant::CollisionMode::reference}) {
        StockWorld stock;
        stock.add_box(btVector3(20, 1, 20), 0, btVector3(0, -1, 0));
        for (int i = 0; i < 5; ++i) {
            stock.add_box(btVector3(btScalar(0.4), btScalar(0.25), btScalar(0.4)), 1,
                          btVector3(0, btScalar(0.25) + btScalar(0.5) * btScalar(i), 0));
        }
        pliant::BridgeDef def;
        def.mode = mode;
        pliant::Bridge bridge(*stock.world, def);
        pli_body* torus = add_clusters(bridge, make_torus(bridge.context(), 0.8f, 0.3f, pli_vec3_make(-4, 0.6f, 0)), 8,
                                       8, pli_cluster_contacts_def_default());
        assert_int_equal(pli_body_add_velocity(torus, pli_vec3_make(8, 0, 0)), PLI_OK);
        stock.step(300);
        assert_int_equal(bridge.step_status(), PLI_OK);
        assert_false(pli_body_is_frozen(torus));
        // The stack is down, the torus was slowed by it, and everything lies on the floor.
        btScalar highest_box = 0, farthest = 0;
        for (std::size_t i = 1; i < stock.bodies.size(); ++i) {
            const btVector3 x = stock.bodies[i]->getWorldTransform().getOrigin();
            highest_box = std::max(highest_box, x.y());
            farthest = std::max(farthest, x.x());
            assert_true(x.y() > 0);
        }
        print_message("           highest box at %.2f m, farthest at %.2f m; torus at (%.2f, %.2f) m, lowest %.3f m\n",
                      static_cast<double>(highest_box), static_cast<double>(farthest),
                      static_cast<double>(center(torus).x), static_cast<double>(center(torus).y),
                      static_cast<double>(lowest(torus)));
        assert_true(highest_box < 2);
        assert_true(farthest > 1);
        assert_true(center(torus).x < 6);
        check_near(lowest(torus), 0.05, 0.1);
    }
}

// Boxes of Bullet lie on a soft cushion.
void test_a_box_rests_on_a_cushion(void**) {
    StockWorld stock;
    stock.add_box(btVector3(20, 1, 20), 0, btVector3(0, -1, 0));
    btRigidBody& box = stock.add_box(btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.3)), 2, btVector3(0, 2, 0));
    pliant::Bridge bridge(*stock.world);
    pli_cluster_contacts_def contacts = pli_cluster_contacts_def_default();
    contacts.dynamic_hardness = 1;
    pli_body* torus =
        add_clusters(bridge, make_torus(bridge.context(), 0.8f, 0.4f, pli_vec3_make(0, 0.6f, 0)), 20, 1, contacts);
    stock.step(300);
    const btVector3 before = box.getWorldTransform().getOrigin();
    stock.step(60);
    const btVector3 x = box.getWorldTransform().getOrigin();
    print_message("           box at (%.2f, %.2f, %.2f) m, moved by %.3f m in 1 s; top of the torus at %.3f m\n",
                  static_cast<double>(x.x()), static_cast<double>(x.y()), static_cast<double>(x.z()),
                  static_cast<double>((x - before).length()), static_cast<double>(highest(torus)));
    // The hull of a torus has no hole.
    check_near(x.y(), highest(torus) + 0.35f, 0.05);
    check_at_most((x - before).length(), 0.02);
    check_at_most(speed_of(torus), 0.1);
}

void test_a_joint_holds_a_box(void**) {
    StockWorld stock;
    btRigidBody& box = stock.add_box(btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.3)), 2, btVector3(2, 4, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* torus = add_clusters(bridge, make_torus(bridge.context(), 0.8f, 0.3f, pli_vec3_make(0, 4, 0)), 8, 1,
                                   pli_cluster_contacts_def_default());
    pli_linear_joint_def joint = pli_linear_joint_def_default();
    joint.position = pli_vec3_make(0, 4, 0);
    assert_int_equal(pli_body_add_linear_joint(torus, &joint, nullptr), PLI_OK);
    joint.other.rigid = bridge.rigid(box);
    joint.position = pli_vec3_make(1.4f, 4, 0);
    assert_int_equal(pli_body_add_linear_joint(torus, &joint, nullptr), PLI_OK);
    stock.step(600);
    assert_int_equal(bridge.step_status(), PLI_OK);
    const btVector3 x = box.getWorldTransform().getOrigin();
    print_message("           the box hangs at (%.2f, %.2f, %.2f) m\n", static_cast<double>(x.x()),
                  static_cast<double>(x.y()), static_cast<double>(x.z()));
    assert_true(box.isActive());
    assert_true(x.length() > 1);
    check_at_most((x - btVector3(0, 4, 0)).length(), 2.2);
    bridge.forget(box);
    assert_int_equal(pli_body_joint_count(torus), 1);
}

// -------------------------------------------------------------------------------------------------------- all shapes

btCollisionShape* make_compound() {
    auto* compound = new btCompoundShape;
    static btBoxShape box(btVector3(1, btScalar(0.5), 5));
    for (int i = 0; i < 5; ++i) {
        compound->addChildShape(
            btTransform(btQuaternion::getIdentity(), btVector3(btScalar(2 * i - 4), btScalar(-0.5), 0)), &box);
    }
    return compound;
}

btCollisionShape* make_heightfield() {
    static float heights[11 * 11] = {};
    return new btHeightfieldTerrainShape(11, 11, heights, 1, -1, 1, 1, PHY_FLOAT, false);
}

btCollisionShape* make_mesh() {
    static const btScalar points[4][3] = {{-5, 0, -5}, {5, 0, -5}, {5, 0, 5}, {-5, 0, 5}};
    static const int triangles[6] = {0, 2, 1, 0, 3, 2};
    static btTriangleIndexVertexArray arrays(2, const_cast<int*>(triangles), 3 * sizeof(int), 4,
                                             const_cast<btScalar*>(&points[0][0]), 3 * sizeof(btScalar));
    return new btBvhTriangleMeshShape(&arrays, false);
}

btCollisionShape* make_hull() {
    auto* hull = new btConvexHullShape;
    for (int i = 0; i < 8; ++i) {
        hull->addPoint(btVector3((i & 1) != 0 ? 5 : -5, (i & 2) != 0 ? btScalar(-0.04) : -1, (i & 4) != 0 ? 5 : -5));
    }
    return hull;
}

// All floors have their top at y = 0.
void check_floor(const char* name, btCollisionShape* shape, pliant::CollisionMode mode, bool with_bullet_distance) {
    StockWorld stock;
    stock.add_body(shape, 0, btVector3(0, 0, 0));
    pliant::BridgeDef def;
    def.mode = mode;
    pliant::Bridge bridge(*stock.world, def);
    pli_cluster_contacts_def contacts = pli_cluster_contacts_def_default();
    if (with_bullet_distance) {
        contacts.distance = pliant::bullet_cluster_distance;
        contacts.distance_user = &bridge;
    }
    pli_body* torus =
        add_clusters(bridge, make_torus(bridge.context(), 0.8f, 0.3f, pli_vec3_make(0.2f, 1, 0.1f)), 8, 4, contacts);
    int least = 1000;
    bridge.set_before_solve([&] {
        const int count = pli_body_get_cluster_contacts(torus, 0, nullptr);
        least = count < least ? count : least;
    });
    stock.step(240);
    least = 1000;
    double speed = 0; // mean: on slabs the torus trembles by up to 0.8 m/s
    for (int i = 0; i < 60; ++i) {
        stock.step(1);
        speed += static_cast<double>(speed_of(torus)) / 60;
    }
    assert_int_equal(bridge.step_status(), PLI_OK);
    print_message("           %s: %d contacts, lowest at %.3f m, %.3f m/s\n", name, least,
                  static_cast<double>(lowest(torus)), speed);
    assert_false(pli_body_is_frozen(torus));
    // Slabs are 0.1 m thick.
    const bool is_slab = mode == pliant::CollisionMode::reference && shape->isConcave();
    check_near(lowest(torus), is_slab ? 0.15 : 0.05, 0.04);
    check_at_most(speed, 0.6);
}

void test_every_kind_of_floor_holds_a_torus(void**) {
    const auto exact = pliant::CollisionMode::exact;
    const auto plane = [] { return new btStaticPlaneShape(btVector3(0, 1, 0), 0); };
    const auto box = [] {
        auto* compound = new btCompoundShape;
        static btBoxShape child(btVector3(5, 1, 5));
        compound->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(0, -1, 0)), &child);
        return compound;
    };
    const auto cylinder = [] {
        auto* compound = new btCompoundShape;
        static btCylinderShape child(btVector3(5, 1, 5));
        compound->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(0, -1, 0)), &child);
        return compound;
    };
    check_floor("box", box(), exact, false);
    check_floor("cylinder", cylinder(), exact, false);
    check_floor("hull", make_hull(), exact, false);
    check_floor("plane", plane(), exact, false);
    check_floor("compound", make_compound(), exact, false);
    check_floor("heightfield", make_heightfield(), exact, false);
    check_floor("triangle mesh", make_mesh(), exact, false);
}

void test_reference_mode_holds_a_torus(void**) {
    const auto reference = pliant::CollisionMode::reference;
    for (const bool with_bullet_distance : {false, true}) {
        check_floor("hull", make_hull(), reference, with_bullet_distance);
        check_floor("compound", make_compound(), reference, with_bullet_distance);
        check_floor("triangle mesh", make_mesh(), reference, with_bullet_distance);
    }
}

// The core's own distances and those of Bullet, for the same pairs. Both are distances of points of the two sides, so
// the smaller is the better one; Bullet's search sometimes ends a little early.
void test_distances_equal_those_of_bullet(void**) {
    StockWorld stock;
    stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0), btQuaternion(btVector3(1, 0, 0), btScalar(0.1)));
    stock.add_body(new btSphereShape(btScalar(0.5)), 1, btVector3(0, 2, 0));
    pliant::BridgeDef def;
    def.mode = pliant::CollisionMode::reference;
    pliant::Bridge bridge(*stock.world, def);
    pli_cluster_contacts_def contacts_def = pli_cluster_contacts_def_default();
    contacts_def.disable_contact_cache = true;
    pli_body* torus = add_clusters(bridge, make_torus(bridge.context(), 0.8f, 0.3f, pli_vec3_make(0.2f, 1, 0.1f)), 8, 6,
                                   contacts_def);
    int compared = 0;
    double longer = 0, shorter = 0;
    bridge.set_before_solve([&] {
        std::vector<pli_cluster_contact> contacts(64);
        const int count = pli_body_get_cluster_contacts(torus, 64, contacts.data());
        for (int i = 0; i < count && i < 64; ++i) {
            const pli_cluster_contact& ours = contacts[static_cast<std::size_t>(i)];
            // Further contacts of the same pair are at nodes.
            const bool is_first = i == 0 || contacts[static_cast<std::size_t>(i - 1)].cluster != ours.cluster ||
                                  contacts[static_cast<std::size_t>(i - 1)].rigid != ours.rigid;
            pli_cluster_contact theirs = ours;
            if (!is_first || ours.distance < 0.01f) { continue; }
            assert_true(pliant::bullet_cluster_distance(torus, &theirs, &bridge));
            longer = std::fmax(longer, static_cast<double>(ours.distance - theirs.distance));
            shorter = std::fmax(shorter, static_cast<double>(theirs.distance - ours.distance));
            assert_true(pli_vec3_dot(ours.normal, theirs.normal) > 0.999f);
            ++compared;
        }
    });
    stock.step(200);
    print_message("           %d distances, longer by at most %.3g m, shorter by %.3g m\n", compared, longer, shorter);
    assert_true(compared > 100);
    check_at_most(longer, 1e-5);
    check_at_most(shorter, 5e-3);
    pli_rigid_def foreign_def = pli_rigid_def_default();
    pli_cluster_contact foreign = {};
    assert_int_equal(pli_rigid_create(bridge.world(), &foreign_def, &foreign.rigid), PLI_OK);
    assert_false(pliant::bullet_cluster_distance(torus, &foreign, &bridge));
    assert_false(pliant::bullet_cluster_distance(torus, &foreign, nullptr));
    pli_rigid_destroy(foreign.rigid);
    pli_cluster_contact unknown = {};
    assert_false(pliant::bullet_cluster_distance(torus, &unknown, nullptr));
    unknown.cluster = 99;
    assert_false(pliant::bullet_cluster_distance(torus, &unknown, &bridge));
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_a_torus_and_a_stack_of_boxes_push_each_other),
        cmocka_unit_test(test_a_box_rests_on_a_cushion),
        cmocka_unit_test(test_a_joint_holds_a_box),
        cmocka_unit_test(test_every_kind_of_floor_holds_a_torus),
        cmocka_unit_test(test_reference_mode_holds_a_torus),
        cmocka_unit_test(test_distances_equal_those_of_bullet),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
