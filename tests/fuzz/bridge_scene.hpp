#ifndef TESTS_FUZZ_BRIDGE_SCENE_HPP
#define TESTS_FUZZ_BRIDGE_SCENE_HPP

// The Bullet world that the fuzzer of files of bridges reads into, and whose files it begins with.

#include "../unit/test_bridge_world.h"

#include <pliant_bullet/snapshot.h>

#include <cstdlib>

namespace fuzz {

inline void require(bool holds) {
    if (!holds) { std::abort(); }
}

// A box on a sheet that is anchored to a kinematic one, a compound on a floor, a box on a rope.
struct Scene {
    bridge_test::StockWorld stock;
    pliant::Bridge bridge;

    /// `has_axes`: with the broad phase of axes.
    Scene(pli_context* context, bool has_axes)
        : stock(btVector3(0, -10, 0), make_broad_phase(has_axes)), bridge(*stock.world, make_def(context)) {
        stock.world->getDispatchInfo().m_deterministicOverlappingPairs = true;
        stock.add_box(btVector3(5, 1, 5), 0, btVector3(0, -1, 0));
        const btVector3 half(btScalar(0.2), btScalar(0.1), btScalar(0.2));
        stock.add_box(half, btScalar(0.5), btVector3(0, btScalar(0.66), 0));
        btRigidBody& lift = stock.add_box(half, 0, btVector3(btScalar(-0.9), btScalar(0.5), 0));
        lift.setCollisionFlags(lift.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
        auto* compound = new btCompoundShape;
        for (const btScalar x : {btScalar(-0.3), btScalar(0.3)}) {
            stock.shapes.emplace_back(new btBoxShape(half));
            compound->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(x, 0, 0)),
                                    stock.shapes.back().get());
        }
        stock.add_body(compound, 1, btVector3(2, btScalar(0.1), 0));
        btRigidBody& hung = stock.add_box(half, 1, btVector3(-2, btScalar(0.4), 0));

        pli_body* sheet = bridge_test::add_sheet(bridge, 1, 0.5f, 5, PLI_PATCH_PIN_10 | PLI_PATCH_PIN_11, 0, 0, 0.05f);
        require(sheet != nullptr);
        require(pli_body_enable_contact_events(sheet, nullptr) == PLI_OK);
        hang(sheet, lift, 0);
        pli_mesh* mesh = nullptr;
        pli_body* body = nullptr;
        require(pli_mesh_create_rope(context, pli_vec3_make(-2, 1, 0), pli_vec3_make(-2, 0.5f, 0), 3,
                                     PLI_ROPE_PIN_FIRST, &mesh) == PLI_OK);
        require(pli_mesh_set_total_mass(mesh, 0.1f) == PLI_OK);
        require(bridge.add_body(mesh, nullptr, &body) == PLI_OK);
        pli_mesh_destroy(mesh);
        require(pli_body_enable_xpbd(body, nullptr) == PLI_OK && pli_body_enable_xpbd_links(body, nullptr) == PLI_OK);
        hang(body, hung, pli_body_get_view(body).node_count - 1);
    }

    std::vector<unsigned char> file() const {
        std::vector<unsigned char> bytes;
        require(pliant::BridgeSnapshot::write_file(bridge, bytes) == PLI_OK);
        return bytes;
    }

private:
    static std::unique_ptr<btBroadphaseInterface> make_broad_phase(bool has_axes) {
        const btVector3 corner(100, 100, 100);
        if (has_axes) { return std::make_unique<btAxisSweep3>(-corner, corner, 64); }
        return std::make_unique<btDbvtBroadphase>();
    }
    static pliant::BridgeDef make_def(pli_context* context) {
        pliant::BridgeDef def;
        def.context = context;
        return def;
    }
    void hang(pli_body* body, btRigidBody& to, int node) {
        pli_anchor_def anchor = pli_anchor_def_default();
        anchor.rigid = bridge.rigid(to);
        anchor.node = node;
        require(pli_body_add_anchor(body, &anchor, nullptr) == PLI_OK);
    }
};

} // namespace fuzz

#endif
