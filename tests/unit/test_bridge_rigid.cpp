// Soft bodies and movable rigid bodies: both ways, waking, filters, anchors.
#include "check.h"
#include "test_bridge_slot.h"
#include "test_bridge_world.h"

#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <BulletSoftBody/btSoftBody.h>

#include <optional>

using namespace bridge_test;

namespace {

btVector3 momentum_of(const btRigidBody& body) {
    return body.getLinearVelocity() / body.getInvMass();
}

btVector3 total_momentum(const btRigidBody& rigid, const pli_body* soft) {
    const pli_vec3 p = pli_body_momentum(soft);
    return momentum_of(rigid) + btVector3(btScalar(p.x), btScalar(p.y), btScalar(p.z));
}

pli_body* add_rope(pliant::Bridge& bridge, pli_vec3 from, pli_vec3 to, int pins) {
    pli_mesh* mesh = nullptr;
    if (pli_mesh_create_rope(bridge.context(), from, to, 8, pins, &mesh) != PLI_OK) { return nullptr; }
    pli_body_def def = pli_body_def_default();
    def.solver.position_iterations = 8;
    pli_body* rope = nullptr;
    const pli_status status = bridge.add_body(mesh, &def, &rope);
    pli_mesh_destroy(mesh);
    return status == PLI_OK ? rope : nullptr;
}

pli_status anchor(pli_body* body, int node, pli_rigid* rigid, bool disable_collision = false) {
    pli_anchor_def def = pli_anchor_def_default();
    def.node = node;
    def.rigid = rigid;
    def.disable_collision = disable_collision;
    return pli_body_add_anchor(body, &def, nullptr);
}

} // namespace

static void test_a_pinned_sheet_catches_a_ball(void**) {
    StockWorld stock;
    btRigidBody& ball = stock.add_body(new btSphereShape(btScalar(0.3)), btScalar(0.5), btVector3(0, 3, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 3, 1, 21, PLI_PATCH_PIN_CORNERS);
    pli_solver_settings settings = pli_body_get_solver_settings(sheet);
    settings.velocity_damping = 0.02f;
    assert_int_equal(pli_body_set_solver_settings(sheet, &settings), PLI_OK);
    float fastest_up = 0, lowest_ball = 3;
    for (int i = 0; i < 600; ++i) {
        stock.step(1);
        fastest_up = std::max(fastest_up, static_cast<float>(ball.getLinearVelocity().y()));
        lowest_ball = std::min(lowest_ball, static_cast<float>(ball.getWorldTransform().getOrigin().y()));
    }
    assert_int_equal(bridge.step_status(), PLI_OK);
    // It falls at more than 5 m/s, is thrown back up and ends up resting in the sheet.
    assert_true(fastest_up > 0.3f);
    assert_true(lowest_ball > -0.5f);
    assert_true(lowest_ball < 1.0f);
    check_near(ball.getLinearVelocity().y(), 0, 0.4);
    check_at_most(lowest(sheet), ball.getWorldTransform().getOrigin().y());
}

static void test_momentum_is_conserved_when_a_ball_hits_a_free_sheet(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    btRigidBody& ball = stock.add_body(new btSphereShape(btScalar(0.3)), 1, btVector3(btScalar(0.1), 1, 0));
    ball.setLinearVelocity(btVector3(0, -2, btScalar(0.2)));
    pliant::BridgeDef def;
    def.gravity = pli_vec3_make(0, 0, 0);
    pliant::Bridge bridge(*stock.world, def);
    pli_body* sheet = add_sheet(bridge, 2, 0, 15);
    const btVector3 before = total_momentum(ball, sheet);
    stock.step(60);
    const btVector3 after = total_momentum(ball, sheet);
    assert_true(ball.getLinearVelocity().y() > btScalar(-1.5));
    check_at_most((after - before).length() / before.length(), 1e-5);
}

// Bullet's continuous collision would stop the ball at the sheet as at a wall.
static void test_momentum_is_conserved_with_continuous_collision(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    btRigidBody& ball = stock.add_body(new btSphereShape(btScalar(0.3)), 1, btVector3(btScalar(0.1), 2, 0));
    ball.setLinearVelocity(btVector3(0, -9, 0));
    ball.setCcdMotionThreshold(btScalar(0.01));
    ball.setCcdSweptSphereRadius(btScalar(0.2));
    pliant::BridgeDef def;
    def.gravity = pli_vec3_make(0, 0, 0);
    pliant::Bridge bridge(*stock.world, def);
    pli_body* sheet = add_sheet(bridge, 2, 0, 15);
    const btVector3 before = total_momentum(ball, sheet);
    stock.step(30);
    assert_true(pli_body_momentum(sheet).y < -0.5f);
    check_at_most((total_momentum(ball, sheet) - before).length() / before.length(), 1e-5);
    // Sweeps of the game see the sheet.
    btSphereShape probe(btScalar(0.1));
    const pli_vec3 c = center(sheet);
    const btVector3 middle{btScalar(c.x), btScalar(c.y), btScalar(c.z)};
    const btVector3 above = middle + btVector3(0, 5, 0), below = middle - btVector3(0, 5, 0);
    btCollisionWorld::ClosestConvexResultCallback hit(above, below);
    hit.m_collisionFilterMask = btBroadphaseProxy::AllFilter;
    stock.world->convexSweepTest(&probe, btTransform(btQuaternion::getIdentity(), above),
                                 btTransform(btQuaternion::getIdentity(), below), hit);
    assert_true(hit.hasHit());
}

static void test_momentum_is_conserved_with_a_box_on_a_rope(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    btRigidBody& box = stock.add_box(btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.3)), 2, btVector3(0, -2, 0));
    box.setAngularVelocity(btVector3(btScalar(0.3), 0, 1));
    box.setLinearVelocity(btVector3(0, -1, 0));
    pliant::BridgeDef def;
    def.gravity = pli_vec3_make(0, 0, 0);
    pliant::Bridge bridge(*stock.world, def);
    pli_body* rope = add_rope(bridge, pli_vec3_make(0, 2, 0), pli_vec3_make(0.2f, -1.7f, 0), 0);
    assert_int_equal(anchor(rope, 9, bridge.rigid(box)), PLI_OK);
    const btVector3 before = total_momentum(box, rope);
    stock.step(60);
    // Rounding of positions at 2 m is 1e-5 m/s per node and step.
    check_at_most((total_momentum(box, rope) - before).length() / before.length(), 1e-4);
    assert_true(pli_body_momentum(rope).y < -0.1f);
}

static void test_a_box_hangs_on_a_rope(void**) {
    StockWorld stock;
    btRigidBody& box = stock.add_box(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)), 1, btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* rope = add_rope(bridge, pli_vec3_make(0, 2.2f, 0), pli_vec3_make(0, 0.2f, 0), PLI_ROPE_PIN_FIRST);
    pli_rigid* proxy = bridge.rigid(box);
    assert_non_null(proxy);
    assert_ptr_equal(bridge.rigid(box), proxy);
    assert_int_equal(anchor(rope, 9, proxy), PLI_OK);
    stock.step(600);
    // The weight of the box stretches a rope that is solved to a finite number of iterations.
    check_near(box.getWorldTransform().getOrigin().y(), 0, 0.35);
    // The anchor gives the box the velocity that gravity takes in the next step.
    check_near(box.getLinearVelocity().y(), 1.0 / 6, 0.05);
    // The box never sleeps on an anchor, as with btSoftBody.
    assert_true(box.isActive());
    const pli_body_view view = pli_body_get_view(rope);
    check_near(view.positions[9].y, box.getWorldTransform().getOrigin().y() + btScalar(0.2), 0.03);
}

static void test_anchors_go_with_their_rigid_body(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    pli_body* rope = add_rope(bridge, pli_vec3_make(0, 2, 0), pli_vec3_make(0, 0, 0), PLI_ROPE_PIN_FIRST);
    btBoxShape shape(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)));
    const btRigidBody::btRigidBodyConstructionInfo info(1, nullptr, &shape, btVector3(1, 1, 1));
    {
        // Removed and deleted without a word: the next step notices.
        btRigidBody box(info);
        stock.world->addRigidBody(&box);
        assert_int_equal(anchor(rope, 9, bridge.rigid(box)), PLI_OK);
        stock.step(2);
        assert_int_equal(pli_body_anchor_count(rope), 1);
        stock.world->removeRigidBody(&box);
    }
    stock.step(2);
    assert_int_equal(pli_body_anchor_count(rope), 0);
    {
        btRigidBody box(info);
        stock.world->addRigidBody(&box);
        assert_int_equal(anchor(rope, 9, bridge.rigid(box)), PLI_OK);
        stock.step(2);
        bridge.forget(box);
        assert_int_equal(pli_body_anchor_count(rope), 0);
        stock.step(2);
        stock.world->removeRigidBody(&box);
    }
    stock.step(2);
    // Removed and added again between two steps: the anchor holds.
    btRigidBody box(info);
    stock.world->addRigidBody(&box);
    assert_int_equal(anchor(rope, 9, bridge.rigid(box)), PLI_OK);
    stock.step(2);
    stock.world->removeRigidBody(&box);
    stock.world->addRigidBody(&box);
    stock.step(2);
    assert_int_equal(pli_body_anchor_count(rope), 1);
    stock.world->removeRigidBody(&box);
}

// The ball falls on the sheet in step 40 or so.
static uint64_t allocations_of_fall(bool prepares_ahead) {
    StockWorld stock;
    stock.add_body(new btSphereShape(btScalar(0.3)), btScalar(0.5), btVector3(0, 3, 0));
    pliant::BridgeDef def;
    def.prepares_rigids_ahead = prepares_ahead;
    pliant::Bridge bridge(*stock.world, def);
    pli_body* sheet = add_sheet(bridge, 3, 1, 11, PLI_PATCH_PIN_CORNERS);
    stock.step(1);
    const uint64_t before = pli_context_allocation_count(bridge.context());
    stock.step(20);
    assert_int_equal(pli_context_allocation_count(bridge.context()), before);
    stock.step(60);
    assert_true(lowest(sheet) < 0.9f);
    return pli_context_allocation_count(bridge.context()) - before;
}

static void test_rigid_bodies_are_prepared_ahead(void**) {
    assert_int_equal(allocations_of_fall(true), 0);
    assert_true(allocations_of_fall(false) > 0);
}

// Far from everything, and out of the filter.
static void test_what_is_prepared_goes_with_its_object(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    add_sheet(bridge, 3, 1, 11);
    stock.add_box(btVector3(1, 1, 1), 0, btVector3(0, -50, 0));
    stock.step(1);
    const size_t bytes = pli_context_allocated_bytes(bridge.context());
    btBoxShape shape(btVector3(1, 1, 1));
    btCollisionObject post;
    post.setCollisionShape(&shape);
    post.getWorldTransform().setOrigin(btVector3(50, 0, 0));
    stock.world->addCollisionObject(&post, 1, 0);
    stock.step(1);
    assert_int_equal(pli_context_allocated_bytes(bridge.context()), bytes);
    stock.world->removeCollisionObject(&post);
    stock.world->addCollisionObject(&post);
    stock.step(1);
    assert_true(pli_context_allocated_bytes(bridge.context()) > bytes);
    bridge.forget(post);
    assert_int_equal(pli_context_allocated_bytes(bridge.context()), bytes);
    stock.step(1);
    assert_true(pli_context_allocated_bytes(bridge.context()) > bytes);
    stock.world->removeCollisionObject(&post);
    stock.step(1);
    assert_int_equal(pli_context_allocated_bytes(bridge.context()), bytes);
}

// Between two steps another object, with another shape, comes to the place of the first in memory.
static void test_an_object_at_an_old_address_is_seen_as_it_is(void**) {
    for (const btScalar half_size : {btScalar(0.5), btScalar(2)}) {
        StockWorld stock;
        pliant::Bridge bridge(*stock.world);
        pli_body* sheet = add_sheet(bridge, 1, 1.2f, 5);
        std::optional<btBoxShape> shape;
        std::optional<btCollisionObject> object;
        for (const btScalar size : {btScalar(0.25), half_size}) {
            object.reset();
            shape.emplace(btVector3(3, size, 3));
            object.emplace();
            object->setCollisionShape(&*shape);
            object->getWorldTransform().setOrigin(btVector3(0, -size, 0));
            stock.world->addCollisionObject(&*object);
            stock.step(1);
            if (size < half_size) { stock.world->removeCollisionObject(&*object); }
        }
        stock.step(120);
        assert_int_equal(bridge.step_status(), PLI_OK);
        check_near(lowest(sheet), 0.0, 0.3);
        stock.world->removeCollisionObject(&*object);
    }
}

// The same where no bounds overlapped, in a broad phase that gives the same id again.
static void test_an_object_at_an_old_address_is_prepared_ahead(void**) {
    const btVector3 far_corner(100, 100, 100);
    StockWorld stock(btVector3(0, 0, 0), std::make_unique<btAxisSweep3>(-far_corner, far_corner));
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1, 10, 5);
    btBoxShape shape(btVector3(1, 1, 1));
    Slot slot;
    for (int i = 0; i < 2; ++i) {
        auto& box = slot.make<btRigidBody>(btScalar(0), nullptr, &shape);
        stock.world->addRigidBody(&box);
        stock.step(2);
        assert_int_equal(pli_world_rigid_count(bridge.world()), 1);
        if (i == 0) { stock.world->removeRigidBody(&box); }
    }
    for (const btScalar way : {btScalar(-9), btScalar(9)}) {
        const btTransform moved(btQuaternion::getIdentity(), btVector3(0, way, 0));
        bridge.object(sheet)->setWorldTransform(moved);
        stock.step(2);
        assert_int_equal(pli_world_rigid_count(bridge.world()), 1);
    }
    stock.world->removeCollisionObject(stock.world->getCollisionObjectArray()[1]);
}

// A floor of 10 m with its top at `height`, in a place of memory.
static btCollisionShape& make_floor(Slot& slot, int kind, btTriangleMesh& mesh, btScalar height) {
    const btVector3 corners[4] = {btVector3(-5, height, -5), btVector3(5, height, -5), btVector3(5, height, 5),
                                  btVector3(-5, height, 5)};
    mesh.addTriangle(corners[0], corners[2], corners[1]);
    mesh.addTriangle(corners[0], corners[3], corners[2]);
    switch (kind) {
    case 0:
        return slot.make<btBvhTriangleMeshShape>(&mesh, true);
    case 1: {
        auto& shape = slot.make<btGImpactMeshShape>(&mesh);
        shape.updateBound();
        return shape;
    }
    case 2:
        return slot.make<btStaticPlaneShape>(btVector3(0, 1, 0), height);
    default: {
        // Both within the same bounds: a ramp down to -2, and a block up to 2.
        auto& hull = slot.make<btConvexHullShape>();
        for (const btScalar z : {btScalar(-5), btScalar(5)}) {
            hull.addPoint(btVector3(-5, -2, z));
            hull.addPoint(btVector3(5, -2, z));
            hull.addPoint(btVector3(-5, 2, z));
            hull.addPoint(height > 0 ? btVector3(5, 2, z) : btVector3(btScalar(-4.9), 2, z));
        }
        return hull;
    }
    }
}

// A game deletes a shape and gives its body another one, which mostly comes to lie where the first was.
static void test_a_shape_at_an_old_address_is_seen_as_it_is(void**) {
    for (int kind = 0; kind < 4; ++kind) {
        StockWorld stock;
        pliant::Bridge bridge(*stock.world);
        pli_body* sheet = add_sheet(bridge, 1, 3.2f, 5);
        Slot slot;
        btTriangleMesh first, second;
        btRigidBody body(0, nullptr, &make_floor(slot, kind, first, 0));
        stock.world->addRigidBody(&body);
        stock.step(2);
        body.setCollisionShape(&make_floor(slot, kind, second, 2));
        stock.step(200);
        assert_int_equal(bridge.step_status(), PLI_OK);
        check_near(lowest(sheet), 2.1, 0.05);
        stock.world->removeRigidBody(&body);
    }
}

static void test_a_gimpact_mesh_may_change_in_place(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1, 2, 5);
    btScalar points[4][3] = {{-5, 0, -5}, {5, 0, -5}, {5, 0, 5}, {-5, 0, 5}};
    int corners[6] = {0, 2, 1, 0, 3, 2};
    btTriangleIndexVertexArray triangles(2, corners, 3 * sizeof corners[0], 4, points[0], sizeof points[0]);
    btGImpactMeshShape shape(&triangles);
    shape.updateBound();
    btRigidBody body(0, nullptr, &shape);
    stock.world->addRigidBody(&body);
    stock.step(2);
    for (auto& point : points) {
        point[1] = btScalar(0.8);
    }
    shape.postUpdate();
    shape.updateBound();
    stock.step(200);
    assert_int_equal(bridge.step_status(), PLI_OK);
    check_near(lowest(sheet), 0.9, 0.01);
    stock.world->removeRigidBody(&body);
}

// Games mirror props by a negative scale, which turns the triangles over.
static void test_mirrored_meshes_are_met_from_outside(void**) {
    for (int variant = 0; variant < 6; ++variant) {
        const bool is_asked = variant >= 4, scales_mesh = (variant & 1) != 0, is_closed = variant / 2 == 1;
        StockWorld stock;
        pliant::Bridge bridge(*stock.world);
        btTriangleMesh mesh;
        const btVector3 top[4] = {btVector3(-5, 0, -5), btVector3(5, 0, -5), btVector3(5, 0, 5), btVector3(-5, 0, 5)};
        const btVector3 down(0, -1, 0);
        mesh.addTriangle(top[0], top[2], top[1]);
        mesh.addTriangle(top[0], top[3], top[2]);
        for (int i = 0; i < 4 && is_closed; ++i) {
            const btVector3 &a = top[i], &b = top[(i + 1) % 4];
            mesh.addTriangle(a, b, a + down);
            mesh.addTriangle(b, b + down, a + down);
            if (i % 2 == 0) { mesh.addTriangle(a + down, b + down, top[(i + 2) % 4] + down); }
        }
        const btVector3 mirror(-1, 1, 1), one(1, 1, 1);
        btBvhTriangleMeshShape shape(&mesh, true);
        if (scales_mesh) { shape.setLocalScaling(mirror); }
        btScaledBvhTriangleMeshShape scaled(&shape, scales_mesh ? one : mirror);
        btGImpactMeshShape gimpact(&mesh);
        gimpact.setLocalScaling(mirror);
        gimpact.updateBound();
        btRigidBody body(0, nullptr, is_asked ? static_cast<btCollisionShape*>(&gimpact) : &scaled);
        stock.world->addRigidBody(&body);
        pli_body* sheet = add_sheet(bridge, 1, 0.3f, 5);
        stock.step(120);
        assert_int_equal(bridge.step_status(), PLI_OK);
        check_near(lowest(sheet), 0.1, 0.01);
        stock.world->removeRigidBody(&body);
    }
}

static void test_filters_hold(void**) {
    enum { by_mask, by_ignore_flag, by_no_response, by_pliant, by_anchor, by_nothing, count };
    for (int filter = 0; filter < count; ++filter) {
        StockWorld stock;
        btRigidBody& floor = stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
        pliant::Bridge bridge(*stock.world);
        // The floor is in the group of static objects.
        const int mask = filter == by_mask ? ~btBroadphaseProxy::StaticFilter : btBroadphaseProxy::AllFilter;
        pli_body* sheet = add_sheet(bridge, 1, 0.3f, 5, 0, 0, 0, 0.1f, btBroadphaseProxy::DefaultFilter, mask);
        if (filter == by_ignore_flag) { bridge.object(sheet)->setIgnoreCollisionCheck(&floor, true); }
        if (filter == by_no_response) {
            floor.setCollisionFlags(floor.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
        }
        if (filter == by_pliant) { assert_int_equal(pli_body_ignore_rigid(sheet, bridge.rigid(floor), true), PLI_OK); }
        btRigidBody& weight = stock.add_box(btVector3(1, 1, 1), 1, btVector3(20, 0, 0));
        if (filter == by_anchor) {
            assert_int_equal(anchor(sheet, 0, bridge.rigid(weight)), PLI_OK);
            assert_int_equal(anchor(sheet, 1, bridge.rigid(floor), true), PLI_OK);
            assert_true(pli_body_ignores_rigid(sheet, bridge.rigid(floor)));
            continue;
        }
        stock.step(120);
        if (filter == by_nothing) {
            check_near(lowest(sheet), 0.1, 0.01);
        } else {
            assert_true(highest(sheet) < -5);
        }
    }
}

static void test_contact_events_name_objects(void**) {
    for (const bool is_sensor : {false, true}) {
        StockWorld stock;
        btRigidBody& floor = stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
        if (is_sensor) {
            floor.setCollisionFlags(floor.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
        }
        pliant::Bridge bridge(*stock.world);
        pli_body* sheet = add_sheet(bridge, 1, 0.3f, 5);
        assert_int_equal(pli_body_enable_contact_events(sheet, nullptr), PLI_OK);
        int begun = 0, persisting = 0, ended = 0;
        float pushed = 0;
        for (int i = 0; i < 300; ++i) {
            stock.step(1);
            int count = 0;
            const pli_contact_event* begin = pli_body_get_contact_events(sheet, PLI_CONTACT_BEGIN, &count);
            for (int k = 0; k < count; ++k) {
                assert_ptr_equal(bridge.object(begin[k].rigid), &floor);
                assert_ptr_equal(begin[k].user_data, &floor);
                assert_true(begin[k].is_sensor == is_sensor);
            }
            begun += count;
            (void)pli_body_get_contact_events(sheet, PLI_CONTACT_END, &count);
            ended += count;
            const pli_contact_event* goes_on = pli_body_get_contact_events(sheet, PLI_CONTACT_PERSIST, &count);
            if (i < 240) { continue; }
            persisting += count;
            pushed += count > 0 ? goes_on->impulse.y / 60 : 0;
        }
        if (is_sensor) { // it falls through
            assert_int_equal(begun, 1);
            assert_int_equal(ended, 1);
            continue;
        }
        assert_int_equal(begun, ended + 1);
        assert_int_equal(persisting, 60); // in every step
        check_near(pushed, pli_body_total_mass(sheet) * 10 / 60,
                   0.01 * static_cast<double>(pli_body_total_mass(sheet)) / 6);
    }
}

// A game sticks a sheet to what an event names, and the two part company with the bounds of the body.
static void test_anchors_hold_to_what_an_event_names(void**) {
    for (const bool prepares_ahead : {false, true}) {
        StockWorld stock(btVector3(0, 0, 0));
        pliant::BridgeDef def;
        def.prepares_rigids_ahead = prepares_ahead;
        pliant::Bridge bridge(*stock.world, def);
        const btVector3 half(btScalar(0.3), btScalar(0.3), btScalar(0.3));
        btRigidBody& box = stock.add_box(half, 5, btVector3(0, btScalar(-0.3), 0));
        box.setAngularFactor(0);
        pli_body* sheet = add_sheet(bridge, 2, 0.09f, 9);
        assert_int_equal(pli_body_enable_contact_events(sheet, nullptr), PLI_OK);
        stock.step(2);
        int count = 0;
        const pli_contact_event* events = pli_body_get_contact_events(sheet, PLI_CONTACT_BEGIN, &count);
        if (count == 0) { events = pli_body_get_contact_events(sheet, PLI_CONTACT_PERSIST, &count); }
        assert_int_equal(count, 1);
        assert_int_equal(anchor(sheet, 40, events[0].rigid, true), PLI_OK);
        const auto offset = [&] {
            const pli_vec4 node = pli_body_get_view(sheet).positions[40];
            return btVector3(btScalar(node.x), btScalar(node.y), btScalar(node.z)) -
                   box.getWorldTransform().getOrigin();
        };
        const btVector3 before = offset();
        stock.step(30);
        box.setLinearVelocity(btVector3(2, 0, 0));
        stock.step(60);
        check_at_most((offset() - before).length(), 0.1);
        box.getWorldTransform().setOrigin(btVector3(20, 0, 0));
        stock.step(60);
        assert_int_equal(pli_body_anchor_count(sheet), 1);
        check_at_most((offset() - before).length(), 0.05);
        assert_true(center(sheet).x > 15);
    }
}

static void test_a_sleeping_box_wakes_under_a_falling_sheet(void**) {
    StockWorld stock;
    stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
    btRigidBody& box =
        stock.add_box(btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.3)), 1, btVector3(0, btScalar(0.3), 0));
    stock.step(300);
    assert_int_equal(box.getActivationState(), ISLAND_SLEEPING);
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 2, 1.5f, 15);
    stock.step(5);
    assert_int_equal(box.getActivationState(), ISLAND_SLEEPING);
    stock.step(60);
    assert_true(box.isActive());
    // While soft contacts act on it, it stays awake.
    stock.step(300);
    assert_true(box.isActive());
    assert_true(highest(sheet) > 0.5f);
    // Alone again it falls asleep.
    assert_int_equal(bridge.remove_body(sheet), PLI_OK);
    stock.step(300);
    assert_int_equal(box.getActivationState(), ISLAND_SLEEPING);
}

static void test_an_anchored_sleeping_box_wakes(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    btRigidBody& box = stock.add_box(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)), 1, btVector3(3, 0, 0));
    box.forceActivationState(ISLAND_SLEEPING);
    pliant::BridgeDef def;
    def.gravity = pli_vec3_make(0, -10, 0);
    pliant::Bridge bridge(*stock.world, def);
    pli_body* rope = add_rope(bridge, pli_vec3_make(0, 0, 0), pli_vec3_make(2.8f, 0, 0), PLI_ROPE_PIN_FIRST);
    assert_int_equal(anchor(rope, 9, bridge.rigid(box), true), PLI_OK);
    stock.step(1);
    assert_true(box.isActive());
    stock.step(120);
    assert_true(box.getLinearVelocity().length() > 0);
}

static void test_a_kinematic_box_drags_a_sheet_by_friction(void**) {
    float distance[2];
    for (int rough = 0; rough < 2; ++rough) {
        StockWorld stock;
        btRigidBody& box = stock.add_box(btVector3(2, btScalar(0.5), 2), 0, btVector3(0, btScalar(-0.5), 0));
        box.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        box.setActivationState(DISABLE_DEACTIVATION);
        box.setFriction(rough != 0 ? 5 : 0);
        pliant::Bridge bridge(*stock.world);
        pli_body* sheet = add_sheet(bridge, 1, 0.09f, 7);
        for (int i = 0; i < 60; ++i) {
            btTransform pose = box.getWorldTransform();
            pose.getOrigin().setX(btScalar(i + 1) / btScalar(60));
            box.getMotionState()->setWorldTransform(pose);
            stock.step(1);
        }
        distance[rough] = center(sheet).x;
        check_near(lowest(sheet), 0.1, 0.03);
    }
    check_near(distance[0], 0, 1e-3);
    check_near(distance[1], 1, 0.05);
}

// Bullet's restitution times that of the soft body; 0 is the default of both.
static void test_a_sheet_bounces_off_a_box_as_both_allow(void**) {
    float highest[2] = {};
    for (int springy = 0; springy < 2; ++springy) {
        StockWorld stock;
        stock.add_box(btVector3(2, btScalar(0.5), 2), 0, btVector3(0, btScalar(-0.5), 0))
            .setRestitution(springy != 0 ? btScalar(0.8) : btScalar(0));
        pliant::Bridge bridge(*stock.world);
        pli_body* sheet = add_sheet(bridge, 1, 0.6f, 7);
        assert_int_equal(pli_body_enable_restitution(sheet, 1), PLI_OK);
        bool has_met = false;
        for (int i = 0; i < 60; ++i) {
            stock.step(1);
            has_met = has_met || center(sheet).y < 0.15f;
            if (has_met) { highest[springy] = std::max(highest[springy], center(sheet).y - 0.1f); }
        }
    }
    check_at_most(highest[0], 0.05);
    check_near(highest[1], 0.64 * 0.5, 0.07); // of the fall of 0.5 m; steps of 1/60 s
}

static void test_a_body_may_change_its_kind(void**) {
    StockWorld stock;
    btRigidBody& box = stock.add_box(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)), 0, btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1, 0.7f, 7);
    stock.step(30);
    check_near(box.getWorldTransform().getOrigin().y(), 0, 0);
    stock.world->removeRigidBody(&box);
    box.setMassProps(1, btVector3(1, 1, 1));
    stock.world->addRigidBody(&box);
    box.activate(true);
    stock.step(10);
    // It falls with the sheet on top, which is not slower.
    assert_true(box.getWorldTransform().getOrigin().y() < btScalar(-0.05));
    assert_int_equal(pli_rigid_get_kind(bridge.rigid(box)), PLI_RIGID_DYNAMIC);
    assert_false(pli_body_is_frozen(sheet));
}

// No step says that something is wrong.
static void test_an_anchored_body_may_change_its_kind(void**) {
    StockWorld stock;
    btRigidBody& box = stock.add_box(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)), 1, btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* rope = add_rope(bridge, pli_vec3_make(0, 2.2f, 0), pli_vec3_make(0, 0.2f, 0), PLI_ROPE_PIN_FIRST);
    assert_int_equal(anchor(rope, 9, bridge.rigid(box)), PLI_OK);
    for (int change = 0; change < 4; ++change) {
        const bool is_dynamic = change % 2 == 1;
        for (int i = 0; i < 30; ++i) {
            stock.step(1);
            assert_int_equal(bridge.step_status(), PLI_OK);
        }
        box.setMassProps(btScalar(is_dynamic ? 1 : 0), btVector3(1, 1, 1) * btScalar(is_dynamic ? 0.03 : 0));
        box.setLinearVelocity(btVector3(0, 0, 0));
        box.activate(true);
        const btVector3 place = box.getWorldTransform().getOrigin();
        stock.step(1);
        assert_int_equal(bridge.step_status(), PLI_OK);
        if (!is_dynamic) { assert_true(box.getWorldTransform().getOrigin() == place); }
        assert_int_equal(pli_rigid_get_kind(bridge.rigid(box)), is_dynamic ? PLI_RIGID_DYNAMIC : PLI_RIGID_STATIC);
    }
}

// Bullet does not move it, and impulses must not gather in its velocity.
static void test_a_disabled_body_carries_as_a_static_one(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    const btVector3 half(btScalar(0.8), btScalar(0.3), btScalar(0.8));
    btRigidBody& box = stock.add_box(half, btScalar(0.02), btVector3(0, 0, 0));
    box.forceActivationState(DISABLE_SIMULATION);
    pli_body* sheet = add_sheet(bridge, 1, 0.5f, 9);
    assert_int_equal(anchor(sheet, 40, bridge.rigid(box)), PLI_OK);
    stock.step(120);
    check_near(lowest(sheet), 0.4, 0.02);
    check_at_most(box.getLinearVelocity().length(), 0);
    assert_int_equal(pli_rigid_get_kind(bridge.rigid(box)), PLI_RIGID_STATIC);
    box.forceActivationState(ACTIVE_TAG);
    stock.step(1);
    assert_int_equal(pli_rigid_get_kind(bridge.rigid(box)), PLI_RIGID_DYNAMIC);
    check_at_most(box.getLinearVelocity().length(), 10);
    stock.step(60);
    assert_true(box.getWorldTransform().getOrigin().y() < -3);
}

static void test_factors_hold(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    btRigidBody& ball = stock.add_body(new btSphereShape(btScalar(0.3)), 1, btVector3(0, 1, 0));
    ball.setLinearFactor(btVector3(1, 0, 1));
    pliant::BridgeDef def;
    def.gravity = pli_vec3_make(0, 5, 0);
    pliant::Bridge bridge(*stock.world, def);
    add_sheet(bridge, 2, 0, 15);
    stock.step(90);
    check_near(ball.getLinearVelocity().y(), 0, 0);
    // From now on the sheet takes it along.
    ball.setLinearFactor(btVector3(1, 1, 1));
    stock.step(10);
    assert_true(ball.getLinearVelocity().y() > btScalar(0.1));
}

static void test_soft_bodies_meet_each_other(void**) {
    StockWorld stock;
    pliant::Bridge bridge(*stock.world);
    pli_body* trampoline = add_sheet(bridge, 3, 0, 21, PLI_PATCH_PIN_CORNERS);
    pli_body* falling = add_sheet(bridge, 1, 0.6f, 7);
    pli_body* passing = add_sheet(bridge, 1, 0.8f, 7);
    pli_soft_contacts_def contacts = pli_soft_contacts_def_default();
    for (pli_body* body : {trampoline, falling}) {
        assert_int_equal(pli_body_enable_soft_contacts(body, &contacts), PLI_OK);
    }
    stock.step(180);
    assert_int_equal(bridge.step_status(), PLI_OK);
    assert_true(center(falling).y > center(trampoline).y - 0.7f);
    assert_true(center(passing).y < -10);
}

static void test_soft_bodies_meet_from_when_both_look(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    pliant::BridgeDef def;
    def.gravity = pli_vec3_make(0, 0, 0);
    pliant::Bridge bridge(*stock.world, def);
    pli_body* lower = add_sheet(bridge, 1, 0, 7);
    pli_body* upper = add_sheet(bridge, 1, 0.01f, 7);
    btCollisionObject& lower_object = *bridge.object(lower);
    btCollisionObject& upper_object = *bridge.object(upper);
    const auto contacts_after_step = [&] {
        stock.step(1);
        assert_int_equal(bridge.step_status(), PLI_OK);
        return pli_body_get_soft_contacts(lower, 0, nullptr) + pli_body_get_soft_contacts(upper, 0, nullptr);
    };
    const auto takes_up_pair = [&] {
        const btBroadphasePairArray& pairs = stock.broadphase->getOverlappingPairCache()->getOverlappingPairArray();
        assert_int_equal(pairs.size(), 1);
        return pairs[0].m_algorithm != nullptr;
    };
    const pli_soft_contacts_def contacts = pli_soft_contacts_def_default();
    assert_int_equal(contacts_after_step(), 0);
    assert_false(takes_up_pair());
    assert_int_equal(pli_body_enable_soft_contacts(lower, &contacts), PLI_OK);
    assert_int_equal(contacts_after_step(), 0);
    assert_false(takes_up_pair());
    assert_int_equal(pli_body_enable_soft_contacts(upper, &contacts), PLI_OK);
    assert_true(contacts_after_step() > 0);
    assert_true(takes_up_pair());

    // Bullet's own way to part two objects holds, and its end too.
    lower_object.setIgnoreCollisionCheck(&upper_object, true);
    assert_int_equal(contacts_after_step(), 0);
    lower_object.setIgnoreCollisionCheck(&upper_object, false);
    assert_true(contacts_after_step() > 0);
    assert_int_equal(pli_body_disable_soft_contacts(upper), PLI_OK);
    assert_int_equal(contacts_after_step(), 0);
}

static void test_a_foreign_soft_body_is_left_alone(void**) {
    btSoftBodyWorldInfo info;
    StockWorld stock;
    info.m_broadphase = stock.broadphase.get();
    info.m_dispatcher = stock.dispatcher.get();
    info.m_sparsesdf.Initialize();
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 1, 0, 5);
    const btVector3 points[3] = {btVector3(0, 0, 0), btVector3(1, 0, 0), btVector3(0, 0, 1)};
    btSoftBody soft(&info, 3, points, nullptr);
    soft.appendFace(0, 1, 2);
    stock.world->addCollisionObject(&soft);
    stock.step(10);
    assert_int_equal(bridge.step_status(), PLI_OK);
    assert_true(center(sheet).y < -0.1f);
    stock.world->removeCollisionObject(&soft);
}

// ------------------------------------------------------------------------------------- triangle meshes, sampled

namespace {

constexpr int mesh_rings = 12, mesh_segments = 24;

// A pear of 2 m height, round the y axis, faces outward.
class PearMesh {
public:
    explicit PearMesh(int removed = 0) {
        const int points = mesh_rings * mesh_segments;
        const double pi = 3.14159265358979;
        for (int i = 0; i < mesh_rings; ++i) {
            const double polar = pi * (i + 1) / (mesh_rings + 1);
            const double radius = std::sin(polar) * (0.65 - 0.25 * std::cos(polar));
            for (int j = 0; j < mesh_segments; ++j) {
                const double turn = 2 * pi * j / mesh_segments;
                add_point(radius * std::cos(turn), std::cos(polar), radius * std::sin(turn));
            }
        }
        add_point(0, 1, 0);
        add_point(0, -1, 0);
        for (int j = 0; j < mesh_segments; ++j) {
            const int next = (j + 1) % mesh_segments, last = (mesh_rings - 1) * mesh_segments;
            add_triangle(points, next, j);
            add_triangle(points + 1, last + j, last + next);
            for (int i = 0; i + 1 < mesh_rings; ++i) {
                const int a = i * mesh_segments + j, b = i * mesh_segments + next;
                add_triangle(a, b, a + mesh_segments);
                add_triangle(b, b + mesh_segments, a + mesh_segments);
            }
        }
        indices.resize(indices.size() - static_cast<std::size_t>(3 * removed));
        mesh = std::make_unique<btTriangleIndexVertexArray>(static_cast<int>(indices.size() / 3), indices.data(),
                                                            static_cast<int>(3 * sizeof(int)), points + 2,
                                                            coordinates.data(), static_cast<int>(3 * sizeof(btScalar)));
    }

    std::vector<btScalar> coordinates;
    std::vector<int> indices;
    std::unique_ptr<btTriangleIndexVertexArray> mesh;

private:
    void add_point(double x, double y, double z) {
        for (const double c : {x, y, z}) {
            coordinates.push_back(static_cast<btScalar>(c));
        }
    }
    void add_triangle(int a, int b, int c) { indices.insert(indices.end(), {a, b, c}); }
};

float deepest_in(const pli_rigid* rigid, const pli_shape* shape, const pli_body* body) {
    const pli_transform pose = pli_rigid_get_state(rigid).pose;
    const pli_body_view view = pli_body_get_view(body);
    float deepest = 10;
    for (int i = 0; i < view.node_count; ++i) {
        const pli_vec4 p = view.positions[i];
        const pli_vec3 local = pli_transform_inverse_point(pose, pli_vec3_make(p.x, p.y, p.z));
        deepest = std::min(deepest, pli_shape_distance(shape, local, nullptr));
    }
    return deepest;
}

pli_shape* exact_pear(pli_context* context, const PearMesh& pear) {
    std::vector<pli_vec3> points;
    for (std::size_t i = 0; i < pear.coordinates.size(); i += 3) {
        points.push_back(pli_vec3_make(static_cast<float>(pear.coordinates[i]),
                                       static_cast<float>(pear.coordinates[i + 1]),
                                       static_cast<float>(pear.coordinates[i + 2])));
    }
    pli_shape* shape = nullptr;
    assert_int_equal(pli_shape_create_triangle_mesh(context, static_cast<int>(points.size()), points.data(),
                                                    static_cast<int>(pear.indices.size() / 3), pear.indices.data(),
                                                    0.1f, &shape),
                     PLI_OK);
    return shape;
}

} // namespace

// The pear turns slowly under the sheet, in either mode.
static void test_a_sheet_falls_on_a_kinematic_sampled_mesh(void**) {
    for (const pliant::CollisionMode mode : {pliant::CollisionMode::exact, pliant::CollisionMode::reference}) {
        StockWorld stock;
        PearMesh pear;
        btRigidBody& body = stock.add_body(new btBvhTriangleMeshShape(pear.mesh.get(), true), 0, btVector3(1, 0, 2));
        body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
        body.setActivationState(DISABLE_DEACTIVATION);
        body.setFriction(1);
        pliant::BridgeDef def;
        def.mode = mode;
        pliant::Bridge bridge(*stock.world, def);
        pli_sampled_mesh_def sampling = pli_sampled_mesh_def_default();
        sampling.cell_size = 0.06f;
        assert_int_equal(bridge.use_sampled_mesh(body, sampling), PLI_OK);
        pli_body* sheet = add_sheet(bridge, 1.6f, 1.3f, 21, 0, 1, 2, 0.05f);
        pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
        contacts.static_hardness = 1;
        contacts.friction = 1;
        assert_int_equal(pli_body_disable_rigid_contacts(sheet), PLI_OK);
        assert_int_equal(pli_body_enable_rigid_contacts(sheet, &contacts), PLI_OK);
        pli_shape* shape = exact_pear(bridge.context(), pear);
        float deepest = 1;
        for (int i = 0; i < 70; ++i) {
            btTransform pose(btQuaternion(btVector3(0, 1, 0), btScalar(0.005) * btScalar(i)), btVector3(1, 0, 2));
            body.getMotionState()->setWorldTransform(pose);
            stock.step(1);
            assert_int_equal(bridge.step_status(), PLI_OK);
            deepest = std::min(deepest, deepest_in(bridge.rigid(body), shape, sheet));
        }
        pli_shape_release(shape);
        assert_true(deepest > -0.05f);
        assert_true(highest(sheet) > 0.9f);
        assert_true(lowest(sheet) > -0.5f);
    }
}

// Movable: a convex mesh, with a scaling.
static void test_momentum_is_conserved_when_a_sampled_mesh_hits_a_free_sheet(void**) {
    StockWorld stock(btVector3(0, 0, 0));
    PearMesh pear;
    auto* shape = new btConvexTriangleMeshShape(pear.mesh.get());
    shape->setLocalScaling(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)));
    btRigidBody& body = stock.add_body(shape, 1, btVector3(btScalar(0.1), 1, 0));
    body.setLinearVelocity(btVector3(0, -2, btScalar(0.2)));
    pliant::BridgeDef def;
    def.gravity = pli_vec3_make(0, 0, 0);
    pliant::Bridge bridge(*stock.world, def);
    pli_body* sheet = add_sheet(bridge, 2, 0, 21);
    assert_int_equal(bridge.use_sampled_mesh(body), PLI_OK);
    const btVector3 before = total_momentum(body, sheet);
    stock.step(60);
    const btVector3 after = total_momentum(body, sheet);
    assert_true(body.getLinearVelocity().y() > btScalar(-1.5));
    check_at_most((after - before).length() / before.length(), 1e-5);
}

static void test_use_of_sampled_meshes_is_refused_where_there_is_no_solid(void**) {
    StockWorld stock;
    PearMesh pear;
    constexpr int some = mesh_rings * mesh_segments * 2 - 20;
    PearMesh shred(some);
    btRigidBody& box = stock.add_box(btVector3(1, 1, 1), 1, btVector3(0, 0, 0));
    btRigidBody& closed = stock.add_body(new btBvhTriangleMeshShape(pear.mesh.get(), true), 0, btVector3(3, 0, 0));
    btRigidBody& open = stock.add_body(new btBvhTriangleMeshShape(shred.mesh.get(), true), 0, btVector3(6, 0, 0));
    pliant::Bridge bridge(*stock.world);
    assert_int_equal(bridge.use_sampled_mesh(box), PLI_ERROR_INVALID_VALUE);
    assert_string_equal(pli_last_error(bridge.context()),
                        "pliant::Bridge::use_sampled_mesh: the object has no shape of triangles");
    assert_int_equal(bridge.use_sampled_mesh(open), PLI_ERROR_INVALID_MESH);
    assert_non_null(bridge.rigid(open)); // as it was
    pli_sampled_mesh_def tiny = pli_sampled_mesh_def_default();
    tiny.cell_size = 0.001f;
    assert_int_equal(bridge.use_sampled_mesh(closed, tiny), PLI_ERROR_INVALID_VALUE);
    assert_int_equal(bridge.use_sampled_mesh(closed), PLI_OK);
    assert_int_equal(bridge.use_sampled_mesh(closed, tiny), PLI_ERROR_INVALID_VALUE);
    bridge.forget(closed);
    bridge.detach();
    assert_int_equal(bridge.use_sampled_mesh(closed), PLI_ERROR_WRONG_STATE);
    assert_string_equal(pli_last_error(bridge.context()),
                        "pliant::Bridge::use_sampled_mesh: the bridge has left its Bullet world");
}

static void test_a_proxy_that_is_refused_has_a_reason(void**) {
    StockWorld stock;
    btRigidBody& box = stock.add_box(btVector3(1, 1, 1), 1, btVector3(0, 0, 0));
    pliant::Bridge bridge(*stock.world);
    (void)add_sheet(bridge, 1, 5, 3);
    btCollisionObject shapeless;
    assert_null(bridge.rigid(shapeless));
    assert_string_equal(pli_last_error(bridge.context()), "pliant::Bridge::rigid: the object has no shape");
    bridge.set_before_solve([&] {
        assert_null(bridge.rigid(box));
        assert_string_equal(pli_last_error(bridge.context()), "pliant::Bridge::rigid: not allowed inside of a step");
    });
    stock.step(1);
    bridge.detach();
    assert_null(bridge.rigid(box));
    assert_string_equal(pli_last_error(bridge.context()),
                        "pliant::Bridge::rigid: the bridge has left its Bullet world");
}

/// Contacts press through the centre of a ball, however it has turned since they were found.
static void test_a_turning_ball_on_a_sheet_keeps_its_spin(void**) {
    StockWorld stock;
    btRigidBody& ball =
        stock.add_body(new btSphereShape(btScalar(0.2)), 5, btVector3(btScalar(0.05), btScalar(1.2), 0));
    pliant::Bridge bridge(*stock.world);
    pli_body* sheet = add_sheet(bridge, 2, 0.8f, 21, PLI_PATCH_PIN_CORNERS);
    assert_int_equal(pli_body_enable_implicit(sheet, nullptr), PLI_OK);
    assert_int_equal(pli_body_enable_tethers(sheet, nullptr), PLI_OK);
    pli_rigid_contacts_def contacts = pli_rigid_contacts_def_default();
    contacts.friction = 0;
    assert_int_equal(pli_body_enable_rigid_contacts(sheet, &contacts), PLI_OK);
    ball.setAngularVelocity(btVector3(0, 0, 1));
    ball.setActivationState(DISABLE_DEACTIVATION);
    stock.step(300);
    const float spin = static_cast<float>(ball.getAngularVelocity().length());
    const float height = static_cast<float>(ball.getWorldTransform().getOrigin().y());
    print_message("spin %.4f rad/s, height %.3f m\n", double(spin), double(height));
    check_near(spin, 1, 0.01);
    assert_true(height > 0.3f);
}

int main() {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_pinned_sheet_catches_a_ball),
        cmocka_unit_test(test_momentum_is_conserved_when_a_ball_hits_a_free_sheet),
        cmocka_unit_test(test_momentum_is_conserved_with_continuous_collision),
        cmocka_unit_test(test_momentum_is_conserved_with_a_box_on_a_rope),
        cmocka_unit_test(test_a_box_hangs_on_a_rope),
        cmocka_unit_test(test_anchors_go_with_their_rigid_body),
        cmocka_unit_test(test_rigid_bodies_are_prepared_ahead),
        cmocka_unit_test(test_what_is_prepared_goes_with_its_object),
        cmocka_unit_test(test_an_object_at_an_old_address_is_seen_as_it_is),
        cmocka_unit_test(test_an_object_at_an_old_address_is_prepared_ahead),
        cmocka_unit_test(test_a_shape_at_an_old_address_is_seen_as_it_is),
        cmocka_unit_test(test_a_gimpact_mesh_may_change_in_place),
        cmocka_unit_test(test_mirrored_meshes_are_met_from_outside),
        cmocka_unit_test(test_filters_hold),
        cmocka_unit_test(test_contact_events_name_objects),
        cmocka_unit_test(test_anchors_hold_to_what_an_event_names),
        cmocka_unit_test(test_a_sleeping_box_wakes_under_a_falling_sheet),
        cmocka_unit_test(test_an_anchored_sleeping_box_wakes),
        cmocka_unit_test(test_a_kinematic_box_drags_a_sheet_by_friction),
        cmocka_unit_test(test_a_sheet_bounces_off_a_box_as_both_allow),
        cmocka_unit_test(test_a_body_may_change_its_kind),
        cmocka_unit_test(test_an_anchored_body_may_change_its_kind),
        cmocka_unit_test(test_a_disabled_body_carries_as_a_static_one),
        cmocka_unit_test(test_factors_hold),
        cmocka_unit_test(test_soft_bodies_meet_each_other),
        cmocka_unit_test(test_soft_bodies_meet_from_when_both_look),
        cmocka_unit_test(test_a_foreign_soft_body_is_left_alone),
        cmocka_unit_test(test_a_sheet_falls_on_a_kinematic_sampled_mesh),
        cmocka_unit_test(test_momentum_is_conserved_when_a_sampled_mesh_hits_a_free_sheet),
        cmocka_unit_test(test_use_of_sampled_meshes_is_refused_where_there_is_no_solid),
        cmocka_unit_test(test_a_proxy_that_is_refused_has_a_reason),
        cmocka_unit_test(test_a_turning_ball_on_a_sheet_keeps_its_spin),
    };

    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
