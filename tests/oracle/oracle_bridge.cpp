// The bridge in reference mode against btSoftRigidDynamicsWorld: the same scene in both worlds, step by step. The
// scenes of bit-equal tests have results that do not depend on the order of contacts, which in Bullet follows
// addresses.
#include "../unit/test_bridge_world.h"
#include "bullet_twin.hpp"
#include "check.h"

#include "pliant_bullet/import.h"
#include <pliant/bullet_reference.h>

#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <algorithm>
#include <functional>

using namespace bridge_test;

namespace {

constexpr bool is_single = sizeof(btScalar) == sizeof(float);

// Bullet's soft world with the interface of StockWorld.
class SoftWorld : public StockWorld {
public:
    explicit SoftWorld(btVector3 gravity) : StockWorld(gravity) {
        world.reset();
        configuration = std::make_unique<btSoftBodyRigidBodyCollisionConfiguration>();
        dispatcher = std::make_unique<btCollisionDispatcher>(configuration.get());
        broadphase = std::make_unique<btDbvtBroadphase>();
        auto made = std::make_unique<btSoftRigidDynamicsWorld>(dispatcher.get(), broadphase.get(), solver.get(),
                                                               configuration.get());
        soft_world = made.get();
        world = std::move(made);
        world->setGravity(gravity);
        info = &soft_world->getWorldInfo();
        info->m_gravity = gravity;
        info->m_sparsesdf.Reset();
    }
    ~SoftWorld() {
        for (const auto& body : soft_bodies) {
            soft_world->removeSoftBody(body.get());
        }
    }
    btSoftBody& add(const pli_mesh* mesh, float margin, int iterations) {
        soft_bodies.push_back(twin::make_soft_body(*info, mesh));
        btSoftBody& body = *soft_bodies.back();
        body.getCollisionShape()->setMargin(btScalar(margin));
        body.m_cfg.piterations = iterations;
        soft_world->addSoftBody(&body);
        return body;
    }

    btSoftRigidDynamicsWorld* soft_world;
    btSoftBodyWorldInfo* info;
    std::vector<std::unique_ptr<btSoftBody>> soft_bodies;
};

// One scene in both worlds.
struct Pair {
    explicit Pair(btVector3 gravity = btVector3(0, -10, 0)) : stock(gravity), soft(gravity) {
        pliant::BridgeDef def;
        def.mode = pliant::CollisionMode::reference;
        def.gravity = twin::to_pliant(gravity);
        bridge = std::make_unique<pliant::Bridge>(*stock.world, def);
    }
    ~Pair() { pli_mesh_destroy(mesh); }
    void build(const std::function<void(StockWorld&)>& scene) {
        scene(stock);
        scene(soft);
    }
    void add_mesh(pli_mesh* made, float margin, int iterations) {
        assert_non_null(made);
        mesh = made;
        pli_body_def def = pli_body_def_default();
        def.collision_margin = margin;
        def.solver.position_iterations = iterations;
        assert_int_equal(bridge->add_body(mesh, &def, &body), PLI_OK);
        const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
        assert_int_equal(pli_body_enable_rigid_contacts(body, &contacts), PLI_OK);
        twin_body = &soft.add(mesh, margin, iterations);
    }
    void step() {
        stock.step(1);
        soft.step(1);
        assert_int_equal(bridge->step_status(), PLI_OK);
    }
    // Largest difference of pose and velocities over the rigid bodies.
    double rigid_difference() const {
        double largest = 0;
        for (std::size_t i = 0; i < stock.bodies.size(); ++i) {
            const btRigidBody &a = *stock.bodies[i], &b = *soft.bodies[i];
            const auto add = [&](const btVector3& u, const btVector3& v) {
                largest = std::fmax(largest, static_cast<double>((u - v).length()));
            };
            add(a.getWorldTransform().getOrigin(), b.getWorldTransform().getOrigin());
            for (int k = 0; k < 3; ++k) {
                add(a.getWorldTransform().getBasis()[k], b.getWorldTransform().getBasis()[k]);
            }
            add(a.getLinearVelocity(), b.getLinearVelocity());
            add(a.getAngularVelocity(), b.getAngularVelocity());
        }
        return largest;
    }
    void copy_state_to_pliant() { assert_int_equal(twin::copy_state(*twin_body, body), PLI_OK); }

    StockWorld stock;
    SoftWorld soft;
    std::unique_ptr<pliant::Bridge> bridge;
    pli_mesh* mesh = nullptr;
    pli_body* body = nullptr;
    btSoftBody* twin_body = nullptr;
};

pli_mesh* sheet_for(const Pair& pair, float size, float y, int resolution, int pins = 0) {
    return make_sheet(pair.bridge->context(), size, y, resolution, pins);
}

// What was measured over a run.
struct Run {
    twin::difference soft;
    double rigid = 0;
    int contacts = 0;
};

void include(twin::difference& largest, const twin::difference& other) {
    largest.position = std::fmax(largest.position, other.position);
    largest.velocity = std::fmax(largest.velocity, other.velocity);
}

// Pliant's contacts in the order that Bullet has chosen. One rigid body of one shape: a contact per node.
void take_over_contact_order(const btSoftBody& from, pli_body* to) {
    const int count = pli_body_get_rigid_contacts(to, 0, nullptr);
    std::vector<pli_rigid_contact> contacts(static_cast<std::size_t>(count));
    (void)pli_body_get_rigid_contacts(to, count, contacts.data());
    std::vector<int> order;
    for (int i = 0; i < from.m_rcontacts.size(); ++i) {
        const int node = static_cast<int>(from.m_rcontacts[i].m_node - &from.m_nodes[0]);
        for (int k = 0; k < count; ++k) {
            if (contacts[static_cast<std::size_t>(k)].node == node) { order.push_back(k); }
        }
    }
    assert_int_equal(order.size(), count);
    assert_int_equal(pli_body_reorder_rigid_contacts(to, order.data(), count), PLI_OK);
}

// Both from the same start, never synchronised; the differences are those at the end.
Run free_run(Pair& pair, int steps) {
    Run result;
    pair.bridge->set_before_solve([&] { result.contacts += pli_body_get_rigid_contacts(pair.body, 0, nullptr); });
    for (int i = 0; i < steps; ++i) {
        pair.step();
    }
    result.soft = twin::compare(*pair.twin_body, pair.body);
    result.rigid = pair.rigid_difference();
    return result;
}

// Each step from Bullet's state, contacts in Bullet's order; the differences are the largest of all steps.
Run step_by_step(Pair& pair, int steps) {
    Run result;
    pair.bridge->set_before_solve([&] {
        result.contacts += pli_body_get_rigid_contacts(pair.body, 0, nullptr);
        take_over_contact_order(*pair.twin_body, pair.body);
    });
    for (int i = 0; i < steps; ++i) {
        pair.copy_state_to_pliant();
        for (std::size_t k = 0; k < pair.stock.bodies.size(); ++k) {
            btRigidBody& to = *pair.stock.bodies[k];
            const btRigidBody& from = *pair.soft.bodies[k];
            if (from.isStaticOrKinematicObject()) { continue; }
            to.setCenterOfMassTransform(from.getCenterOfMassTransform());
            to.setLinearVelocity(from.getLinearVelocity());
            to.setAngularVelocity(from.getAngularVelocity());
        }
        pair.soft.step(1);
        pair.stock.step(1);
        assert_int_equal(pair.bridge->step_status(), PLI_OK);
        include(result.soft, twin::compare(*pair.twin_body, pair.body));
        result.rigid = std::fmax(result.rigid, pair.rigid_difference());
    }
    return result;
}

// A run against static shapes, where every node keeps its contacts in the order of the shapes. Bit-equal in single
// precision. The core has no more than that: in double precision each step starts from Bullet's state and is compared,
// and as a node at the very limit of a contact or of sticking moves by millimetres on either side, the median counts.
void check_static(Pair& pair, int steps, int least_contacts) {
    if (is_single) {
        const Run result = free_run(pair, steps);
        assert_true(result.contacts > least_contacts);
        check_at_most(result.soft.position, 0);
        check_at_most(result.soft.velocity, 0);
        return;
    }
    int contacts = 0;
    std::vector<double> positions;
    for (int i = 0; i < steps; ++i) {
        pair.copy_state_to_pliant();
        pair.step();
        contacts += pli_body_get_rigid_contacts(pair.body, 0, nullptr);
        positions.push_back(twin::compare(*pair.twin_body, pair.body).position);
    }
    assert_true(contacts > least_contacts);
    std::sort(positions.begin(), positions.end());
    check_at_most(positions[positions.size() / 2], 1e-6);
    check_at_most(positions.back(), 1e-2);
}

btVector3 v3(double x, double y, double z) {
    return btVector3(btScalar(x), btScalar(y), btScalar(z));
}

btQuaternion turned(double x, double y, double z, double angle) {
    return btQuaternion(v3(x, y, z), btScalar(angle));
}

// Hills of 0.3 m on a grid of 1 m.
float hill(int x, int z) {
    return 0.15f * static_cast<float>((x * 7 + z * 13 + 40) % 3 - 1);
}

} // namespace

// ------------------------------------------------------------------------------------------------ static shapes

static void test_a_sheet_on_a_tilted_box(void**) {
    Pair pair;
    pair.build([](StockWorld& w) { w.add_box(v3(2, 1, 2), 0, v3(0, -1, 0), turned(1, 0, 0.5, 0.3)); });
    pair.add_mesh(sheet_for(pair, 3, 0.7f, 15), 0.25f, 3);
    check_static(pair, 150, 1000);
}

static void test_a_sheet_on_round_shapes(void**) {
    const std::function<btCollisionShape*()> shapes[] = {
        [] { return new btSphereShape(1); },
        [] { return new btCapsuleShapeX(btScalar(0.6), 2); },
        [] { return new btCylinderShapeZ(v3(0.8, 0.8, 1.5)); },
        [] { return new btConeShape(1, 2); },
        [] {
            auto* hull = new btConvexHullShape;
            for (int i = 0; i < 12; ++i) {
                hull->addPoint(v3((i * 5) % 7 - 3, (i * 3) % 5 - 3, (i * 11) % 8 - 4) * btScalar(0.4));
            }
            return hull;
        },
    };
    for (const auto& make : shapes) {
        Pair pair;
        pair.build([&](StockWorld& w) { w.add_body(make(), 0, v3(0, -1, 0), turned(0, 1, 0, 0.7)); });
        pair.add_mesh(sheet_for(pair, 3, 0.5f, 15), 0.25f, 3);
        check_static(pair, 100, 100);
    }
}

static void test_a_sheet_on_a_triangle_mesh(void**) {
    btTriangleMesh mesh;
    for (int x = -4; x < 4; ++x) {
        for (int z = -4; z < 4; ++z) {
            const btVector3 a = v3(x, double(hill(x, z)), z), b = v3(x + 1, double(hill(x + 1, z)), z);
            const btVector3 c = v3(x, double(hill(x, z + 1)), z + 1), d = v3(x + 1, double(hill(x + 1, z + 1)), z + 1);
            mesh.addTriangle(a, c, b);
            mesh.addTriangle(b, c, d);
        }
    }
    Pair pair;
    pair.build([&](StockWorld& w) {
        w.add_body(new btBvhTriangleMeshShape(&mesh, true), 0, v3(0.1, -0.2, 0.3), turned(0.1, 1, 0, 0.4));
    });
    pair.add_mesh(sheet_for(pair, 3, 0.9f, 13), 0.25f, 3);
    check_static(pair, 120, 1000);
}

static void test_a_sheet_on_a_heightfield(void**) {
    std::vector<float> heights;
    for (int z = 0; z < 9; ++z) {
        for (int x = 0; x < 9; ++x) {
            heights.push_back(hill(x, z));
        }
    }
    Pair pair;
    pair.build([&](StockWorld& w) {
        w.add_body(new btHeightfieldTerrainShape(9, 9, heights.data(), btScalar(-1), btScalar(1), 1, false), 0,
                   v3(0, 0, 0), turned(0, 1, 0, 0.2));
    });
    pair.add_mesh(sheet_for(pair, 3, 0.9f, 13), 0.25f, 3);
    check_static(pair, 120, 1000);
}

static void test_a_sheet_on_a_plane(void**) {
    Pair pair;
    pair.build([](StockWorld& w) {
        w.add_body(new btStaticPlaneShape(v3(0.2, 1, 0).normalized(), btScalar(0.1)), 0, v3(0, 0, 0));
    });
    pair.add_mesh(sheet_for(pair, 3, 1.2f, 13), 0.25f, 3);
    check_static(pair, 120, 1000);
}

static void test_a_sheet_on_a_compound(void**) {
    Pair pair;
    pair.build([](StockWorld& w) {
        auto* compound = new btCompoundShape;
        for (int i = -2; i <= 2; ++i) {
            btCollisionShape* child = nullptr;
            if (i % 2 == 0) {
                child = new btBoxShape(v3(0.4, 0.3, 1));
            } else {
                child = new btSphereShape(btScalar(0.5));
            }
            w.shapes.emplace_back(child);
            compound->addChildShape(btTransform(turned(1, 0, 0, 0.2 * i), v3(0.9 * i, 0, 0)), child);
        }
        w.add_body(compound, 0, v3(0, -0.2, 0), turned(0, 0, 1, 0.1));
    });
    pair.add_mesh(sheet_for(pair, 3, 0.7f, 15), 0.25f, 3);
    check_static(pair, 120, 1000);
}

static void test_a_kinematic_box_under_a_sheet(void**) {
    Pair pair;
    pair.build([](StockWorld& w) {
        btRigidBody& box = w.add_box(v3(2, 0.5, 2), 0, v3(0, -0.5, 0));
        box.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        box.setActivationState(DISABLE_DEACTIVATION);
    });
    pair.add_mesh(sheet_for(pair, 2, 0.3f, 11), 0.25f, 3);
    for (int i = 0; i < 60; ++i) {
        const btTransform pose(turned(0, 1, 0, 0.01 * i), v3(0.01 * i, -0.5, 0.3 * std::sin(0.1 * i)));
        for (StockWorld* w : {&pair.stock, static_cast<StockWorld*>(&pair.soft)}) {
            w->bodies[0]->getMotionState()->setWorldTransform(pose);
        }
        if (!is_single) { pair.copy_state_to_pliant(); }
        pair.step();
        const twin::difference difference = twin::compare(*pair.twin_body, pair.body);
        check_at_most(difference.position, is_single ? 0 : 2e-6);
        check_at_most(difference.velocity, is_single ? 0 : 2e-4);
    }
}

// Bullet makes the triangles of a plane around the soft body's bounds, which it takes before pose matching.
static void test_pose_matching_above_a_plane(void**) {
    if (!is_single) { return; }
    Pair pair;
    pair.build([](StockWorld& w) {
        w.add_body(new btStaticPlaneShape(v3(0.2, 1, 0.1).normalized(), btScalar(0.1)), 0, v3(0, 0, 0));
    });
    pair.add_mesh(sheet_for(pair, 2, 0.4f, 9), 0.25f, 2);
    assert_int_equal(pli_body_enable_pose_matching(pair.body, 0.2f), PLI_OK);
    pair.twin_body->m_cfg.kMT = btScalar(0.2);
    pair.twin_body->setPose(false, true);
    for (int i = 0; i < pair.twin_body->m_nodes.size(); ++i) {
        pair.twin_body->m_nodes[i].m_x *= btScalar(1 + 0.02 * (i % 17)); // bounds shrink with the matching
    }
    pair.copy_state_to_pliant();
    check_static(pair, 60, 300);
}

// Of a cylinder that is not round, Bullet's bounds do not hold all of the shape: the boxes of nodes decide what meets
// it. The children of a compound have their bounds asked once more.
static void test_a_sheet_on_cylinders_with_wrong_bounds(void**) {
    if (!is_single) { return; }
    for (const bool is_compound : {false, true}) {
        Pair pair;
        pair.build([&](StockWorld& w) {
            btCollisionShape* cylinder = new btCylinderShape(v3(1.2, 0.6, 0.3));
            if (is_compound) {
                w.shapes.emplace_back(cylinder);
                auto* compound = new btCompoundShape;
                compound->addChildShape(btTransform(turned(1, 0, 0, 0.2), v3(0.3, 0, 0)), cylinder);
                cylinder = compound;
            }
            w.add_body(cylinder, 0, v3(0, -0.2, 0), turned(0, 0, 1, 0.3));
        });
        pair.add_mesh(sheet_for(pair, 3, 0.9f, 17), 0.25f, 2);
        const pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
        assert_int_equal(pli_body_enable_rigid_contacts(pair.body, &contacts), PLI_OK);
        assert_int_equal(pli_body_enable_bullet_node_boxes(pair.body), PLI_OK);
        check_static(pair, 80, 100);
    }
}

// Stiffer than what Pliant would allow, and short of the explosion.
static void test_volume_conservation_without_a_limit(void**) {
    if (!is_single) { return; }
    Pair pair;
    pli_mesh* ball = nullptr;
    assert_int_equal(
        pli_mesh_create_ellipsoid(pair.bridge->context(), pli_vec3_make(0, 3, 0), pli_vec3_make(1, 1, 1), 100, &ball),
        PLI_OK);
    pair.add_mesh(ball, 0.25f, 2);
    const float coefficient = 3e4f;
    assert_int_equal(pli_body_enable_volume_conservation(pair.body, coefficient), PLI_OK);
    pair.twin_body->m_cfg.kVC = coefficient;
    pair.twin_body->setPose(true, false);
    for (int i = 0; i < 10; ++i) {
        const pli_vec3 moved = twin::to_pliant(pair.twin_body->m_nodes[i].m_x * btScalar(1.01));
        pair.twin_body->m_nodes[i].m_x = twin::to_bullet(moved);
        assert_int_equal(pli_body_set_node_position(pair.body, i, moved), PLI_OK);
    }
    const Run result = free_run(pair, 3);
    check_at_most(result.soft.position, 0);
    check_at_most(result.soft.velocity, 0);
}

// ----------------------------------------------------------------------------------------------- dynamic bodies

static void test_a_box_on_a_rope(void**) {
    Pair pair;
    pair.build([](StockWorld& w) { w.add_box(v3(0.5, 0.4, 0.3), 5, v3(4, 3, 0), turned(0, 0, 1, 0.2)); });
    pli_mesh* rope = nullptr;
    assert_int_equal(pli_mesh_create_rope(pair.bridge->context(), pli_vec3_make(0, 3, 0), pli_vec3_make(3.5f, 3, 0), 8,
                                          PLI_ROPE_PIN_FIRST, &rope),
                     PLI_OK);
    pair.add_mesh(rope, 0.25f, 4);
    pli_anchor_def def = pli_anchor_def_default();
    def.node = 9;
    def.rigid = pair.bridge->rigid(*pair.stock.bodies[0]);
    assert_int_equal(pli_body_add_anchor(pair.body, &def, nullptr), PLI_OK);
    pair.twin_body->appendAnchor(9, pair.soft.bodies[0].get());
    // Bullet and Pliant both swing it for two seconds; the other nodes of the rope meet the box.
    const Run result = is_single ? free_run(pair, 120) : step_by_step(pair, 120);
    assert_true(pair.stock.bodies[0]->getWorldTransform().getOrigin().x() < 3);
    check_at_most(result.soft.position, is_single ? 0 : 2e-6);
    check_at_most(result.soft.velocity, is_single ? 0 : 2e-4);
    check_at_most(result.rigid, is_single ? 0 : 2e-5);
}

static void test_a_box_falls_into_a_pinned_sheet(void**) {
    Pair pair;
    pair.build([](StockWorld& w) { w.add_box(v3(0.4, 0.3, 0.5), 1, v3(0.1, 1, 0), turned(0.3, 0.2, 1, 0.5)); });
    pair.add_mesh(sheet_for(pair, 4, 0, 17, PLI_PATCH_PIN_CORNERS), 0.25f, 3);
    const Run result = step_by_step(pair, 90);
    assert_true(result.contacts > 100);
    check_at_most(result.soft.position, is_single ? 0 : 2e-6);
    check_at_most(result.soft.velocity, is_single ? 0 : 2e-4);
    check_at_most(result.rigid, is_single ? 0 : 2e-5);
}

// The order of a step: bounds in the broad phase are those of the predicted positions, and rigid bodies that do not
// touch the soft one are not disturbed.
static void test_the_broad_phase_sees_what_it_sees_in_bullet(void**) {
    Pair pair;
    pair.build([](StockWorld& w) {
        w.add_box(v3(5, 1, 5), 0, v3(0, -1, 0));
        w.add_box(v3(0.3, 0.3, 0.3), 1, v3(3, 0.5, 3), turned(1, 1, 0, 0.5));
        w.add_box(v3(0.3, 0.3, 0.3), 1, v3(3.1, 1.5, 3), turned(1, 0, 0, 0.2));
    });
    pair.add_mesh(sheet_for(pair, 2, 0.7f, 9), 0.25f, 3);
    for (int i = 0; i < 60; ++i) {
        if (!is_single) { pair.copy_state_to_pliant(); }
        pair.step();
        btVector3 low[2], high[2];
        btCollisionObject* object = pair.bridge->object(pair.body);
        pair.stock.broadphase->getAabb(object->getBroadphaseHandle(), low[0], high[0]);
        pair.soft.broadphase->getAabb(pair.twin_body->getBroadphaseHandle(), low[1], high[1]);
        check_at_most((low[0] - low[1]).length() + (high[0] - high[1]).length(), is_single ? 0 : 2e-6);
        assert_int_equal(pair.stock.world->getPairCache()->getNumOverlappingPairs(),
                         pair.soft.world->getPairCache()->getNumOverlappingPairs());
        check_at_most(pair.rigid_difference(), 0);
    }
}

static void test_rigid_bodies_sleep_as_in_bullet(void**) {
    Pair pair;
    pair.build([](StockWorld& w) {
        w.add_box(v3(8, 1, 8), 0, v3(0, -1, 0));
        w.add_box(v3(0.3, 0.3, 0.3), 1, v3(0, 0.3, 0)); // under the sheet
        w.add_box(v3(0.3, 0.3, 0.3), 1, v3(6, 0.3, 0)); // beside it
    });
    pair.add_mesh(sheet_for(pair, 2, 1.5f, 9), 0.25f, 3);
    for (int i = 0; i < 300; ++i) {
        pair.step();
        assert_int_equal(pair.stock.bodies[1]->isActive(), pair.soft.bodies[1]->isActive());
        assert_int_equal(pair.stock.bodies[2]->isActive(), pair.soft.bodies[2]->isActive());
    }
    assert_true(pair.stock.bodies[1]->isActive());
    assert_false(pair.stock.bodies[2]->isActive());
}

// ------------------------------------------------------------------------------------------------------ import

static void test_an_imported_body_goes_on_as_in_bullet(void**) {
    Pair pair;
    pair.build([](StockWorld& w) {
        w.add_box(v3(2, 1, 2), 0, v3(0, -1, 0), turned(0, 0, 1, 0.2));
        w.add_box(v3(0.2, 0.2, 0.2), 1, v3(0, 2, 0));
    });
    pli_mesh* source = sheet_for(pair, 2, 0.6f, 9);
    pair.mesh = source;
    btSoftBody& soft = pair.soft.add(source, 0.2f, 2);
    btSoftBody::Material* weak = soft.appendMaterial();
    weak->m_kLST = btScalar(0.25);
    for (int i = 0; i < soft.m_links.size(); i += 3) {
        soft.m_links[i].m_material = weak;
    }
    soft.updateConstants();
    soft.setTotalMass(btScalar(0.7));
    soft.m_cfg.aeromodel = btSoftBody::eAeroModel::V_TwoSided;
    soft.m_cfg.kDG = btScalar(0.02);
    soft.m_cfg.kLF = btScalar(0.01);
    soft.m_cfg.kDP = btScalar(0.01);
    soft.m_cfg.kDF = btScalar(0.8);
    soft.m_windVelocity.setValue(1, 0, btScalar(0.5));
    soft.appendAnchor(0, pair.soft.bodies[1].get(), false, btScalar(0.9));
    soft.m_collisionDisabledObjects.push_back(pair.soft.bodies[1].get());
    soft.updateArea();
    pair.twin_body = &soft;
    // Some steps of Bullet alone, then both.
    pair.soft.step(10);
    pair.stock.step(10);

    pliant::ImportedBody parameters{};
    pli_mesh* mesh = nullptr;
    assert_int_equal(pliant::import_soft_body(pair.bridge->context(), soft, &mesh, &parameters), PLI_OK);
    const pli_mesh_view view = pli_mesh_get_view(mesh), wanted = pli_mesh_get_view(source);
    assert_int_equal(view.node_count, wanted.node_count);
    assert_int_equal(view.link_count, wanted.link_count);
    assert_int_equal(view.face_count, wanted.face_count);
    assert_int_equal(view.material_count, 2);
    assert_int_equal(view.links[3].material, 1);
    check_near(pli_mesh_total_mass(mesh), 0.7, 1e-5);
    assert_int_equal(parameters.anchors.size(), 1);
    assert_int_equal(parameters.ignored.size(), 1);
    assert_int_equal(parameters.aero.model, PLI_AERO_VERTEX_TWO_SIDED);
    check_near(parameters.rest_lengths[0], soft.m_links[0].m_rl, 1e-7);
    check_near(parameters.def.collision_margin, 0.2, 1e-7);
    pli_mesh_destroy(mesh);

    // The rigid bodies of the bridge's world take the place of the other world's.
    soft.m_anchors[0].m_body = pair.stock.bodies[1].get();
    soft.m_collisionDisabledObjects[0] = pair.stock.bodies[1].get();
    assert_int_equal(pliant::import_soft_body(*pair.bridge, soft, &pair.body), PLI_OK);
    soft.m_anchors[0].m_body = pair.soft.bodies[1].get();
    soft.m_collisionDisabledObjects[0] = pair.soft.bodies[1].get();
    for (std::size_t k = 0; k < 2; ++k) {
        pair.stock.bodies[k]->setCenterOfMassTransform(pair.soft.bodies[k]->getCenterOfMassTransform());
        pair.stock.bodies[k]->setLinearVelocity(pair.soft.bodies[k]->getLinearVelocity());
        pair.stock.bodies[k]->setAngularVelocity(pair.soft.bodies[k]->getAngularVelocity());
    }
    pair.step();
    const twin::difference one_step = twin::compare(soft, pair.body);
    check_at_most(one_step.position, 1e-6);
    check_at_most(one_step.velocity, 1e-4);
    const Run result = free_run(pair, 20);
    assert_true(result.contacts > 100);
    check_at_most(result.soft.position, 1e-3);
}

static void test_a_body_that_pliant_refuses_is_not_imported(void**) {
    Pair pair;
    pair.mesh = sheet_for(pair, 2, 0.6f, 5);
    btSoftBody& soft = pair.soft.add(pair.mesh, 0.2f, 1);
    soft.m_materials[0]->m_kLST = 0;
    pli_body* body = nullptr;
    assert_int_equal(pliant::import_soft_body(*pair.bridge, soft, &body), PLI_ERROR_INVALID_VALUE);
    assert_null(body);
    assert_int_equal(pair.stock.world->getNumCollisionObjects(), 0);
    assert_int_equal(pliant::import_soft_body(*pair.bridge, soft, nullptr), PLI_ERROR_NULL_ARGUMENT);
}

int main() {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_sheet_on_a_tilted_box),
        cmocka_unit_test(test_a_sheet_on_round_shapes),
        cmocka_unit_test(test_a_sheet_on_a_triangle_mesh),
        cmocka_unit_test(test_a_sheet_on_a_heightfield),
        cmocka_unit_test(test_a_sheet_on_a_plane),
        cmocka_unit_test(test_a_sheet_on_a_compound),
        cmocka_unit_test(test_a_kinematic_box_under_a_sheet),
        cmocka_unit_test(test_pose_matching_above_a_plane),
        cmocka_unit_test(test_a_sheet_on_cylinders_with_wrong_bounds),
        cmocka_unit_test(test_volume_conservation_without_a_limit),
        cmocka_unit_test(test_a_box_on_a_rope),
        cmocka_unit_test(test_a_box_falls_into_a_pinned_sheet),
        cmocka_unit_test(test_the_broad_phase_sees_what_it_sees_in_bullet),
        cmocka_unit_test(test_rigid_bodies_sleep_as_in_bullet),
        cmocka_unit_test(test_an_imported_body_goes_on_as_in_bullet),
        cmocka_unit_test(test_a_body_that_pliant_refuses_is_not_imported),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
