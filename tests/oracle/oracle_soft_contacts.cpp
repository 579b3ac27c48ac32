// Contacts of nodes with faces of another soft body against btSoftBody (VF_SS): the same pairs from Bullet's boxes, the
// same contacts and the same solve, bit for bit. The order of the contacts is taken from Bullet.

#include "check.h"
#include "sample_mesh.h"

#include "oracle/bullet_twin.hpp"

#include <pliant/bullet_reference.h>
#include <pliant/contact.h>

#include <algorithm>

namespace {

constexpr float dt = 1.0f / 60.0f;

struct pair_member {
    std::unique_ptr<btSoftBody> soft;
    pli_body* body = nullptr;
};

class scene {
public:
    scene() : m_info(twin::world_info()) {
        assert_int_equal(pli_context_create(nullptr, &m_context), PLI_OK);
        assert_int_equal(pli_world_create(m_context, nullptr, &m_world), PLI_OK);
    }
    ~scene() {
        pli_world_destroy(m_world);
        pli_context_destroy(m_context);
    }
    pli_context* context() const { return m_context; }

    void add(pli_mesh* mesh, float friction, float hardness, int iterations, pli_vec3 velocity) {
        pair_member& member = m_members[m_count++];
        member.soft = twin::make_soft_body(m_info, mesh);
        pli_body_def def = pli_body_def_default();
        def.collision_margin = 0.25f; // Bullet's
        def.solver.position_iterations = iterations;
        assert_int_equal(pli_body_create(m_world, mesh, &def, &member.body), PLI_OK);
        pli_mesh_destroy(mesh);
        btSoftBody& soft = *member.soft;
        soft.m_cfg.piterations = iterations;
        soft.m_cfg.kDF = friction;
        soft.m_cfg.kSHR = hardness;
        soft.m_cfg.collisions = btSoftBody::fCollision::VF_SS;
        soft.initializeFaceTree();
        soft.addVelocity(twin::to_bullet(velocity));
        pli_body_add_velocity(member.body, velocity);
        pli_soft_contacts_def contacts = pli_soft_contacts_def_default();
        contacts.friction = friction;
        contacts.hardness = hardness;
        contacts.bullet_boxes = true;
        assert_int_equal(pli_body_enable_soft_contacts(member.body, &contacts), PLI_OK);
    }

    // Steps both engines; every step must be exact. Returns the number of contacts.
    int run(int steps) {
        int contacts = 0;
        for (int i = 0; i < steps; ++i) {
            for (pair_member& member : m_members) {
                member.soft->predictMotion(dt);
            }
            assert_int_equal(pli_world_predict(m_world, dt), PLI_OK);
            m_members[0].soft->defaultCollisionHandler(m_members[1].soft.get());
            assert_int_equal(pli_world_collide_bodies(m_world, m_members[0].body, m_members[1].body), PLI_OK);
            contacts += compare_contacts(m_members[0], m_members[1]);
            contacts += compare_contacts(m_members[1], m_members[0]);
            for (pair_member& member : m_members) {
                member.soft->solveConstraints();
            }
            for (pair_member& member : m_members) {
                member.soft->integrateMotion();
            }
            assert_int_equal(pli_world_solve(m_world), PLI_OK);
            for (pair_member& member : m_members) {
                const twin::difference difference = twin::compare(*member.soft, member.body);
                check_near(difference.position, 0, 0);
                check_near(difference.velocity, 0, 0);
            }
        }
        return contacts;
    }

private:
    static int compare_contacts(pair_member& nodes, pair_member& faces) {
        const int count = pli_body_get_soft_contacts(nodes.body, 0, nullptr);
        assert_int_equal(count, nodes.soft->m_scontacts.size());
        std::vector<pli_soft_contact> ours(static_cast<std::size_t>(count));
        pli_body_get_soft_contacts(nodes.body, count, ours.data());
        std::vector<int> order;
        for (int i = 0; i < count; ++i) {
            const btSoftBody::SContact& theirs = nodes.soft->m_scontacts[i];
            const int node = static_cast<int>(theirs.m_node - &nodes.soft->m_nodes[0]);
            const int face = static_cast<int>(theirs.m_face - &faces.soft->m_faces[0]);
            const auto found = std::find_if(ours.begin(), ours.end(), [&](const pli_soft_contact& contact) {
                return contact.node == node && contact.face == face;
            });
            assert_true(found != ours.end());
            assert_ptr_equal(found->face_body, faces.body);
            check_near(twin::distance(found->normal, twin::to_pliant(theirs.m_normal)), 0, 0);
            check_near(found->margin, theirs.m_margin, 0);
            const pli_vec3 weights = {found->weights[0], found->weights[1], found->weights[2]};
            check_near(twin::distance(weights, twin::to_pliant(theirs.m_weights)), 0, 0);
            order.push_back(static_cast<int>(found - ours.begin()));
        }
        assert_int_equal(pli_body_reorder_soft_contacts(nodes.body, order.data(), count), PLI_OK);
        return count;
    }

    btSoftBodyWorldInfo m_info;
    pli_context* m_context = nullptr;
    pli_world* m_world = nullptr;
    pair_member m_members[2];
    int m_count = 0;
};

pli_mesh* sheet(pli_context* context, int nodes, float y, int pins) {
    pli_mesh* mesh = nullptr;
    assert_int_equal(sample_create_sheet(context, nodes, y, pins, &mesh), PLI_OK);
    return mesh;
}

pli_mesh* ball(pli_context* context, pli_vec3 radii, pli_vec3 centre) {
    pli_mesh* mesh = nullptr;
    assert_int_equal(sample_create_ellipsoid(context, radii, &mesh), PLI_OK);
    assert_int_equal(pli_mesh_translate(mesh, centre), PLI_OK);
    return mesh;
}

void test_soft_contacts_ball_on_pinned_sheet(void**) {
    scene s;
    s.add(sheet(s.context(), 9, 0, 15), 0.4f, 1, 2, pli_vec3_make(0, 0, 0));
    s.add(ball(s.context(), pli_vec3_make(0.8f, 0.8f, 0.8f), pli_vec3_make(0.1f, 1.3f, 0.2f)), 0.1f, 0.7f, 3,
          pli_vec3_make(0.5f, -2, 0));
    const int contacts = s.run(120);
    print_message("           %d contacts, all exact\n", contacts);
    assert_true(contacts > 1000);
}

void test_soft_contacts_sheet_falls_on_sheet(void**) {
    scene s;
    s.add(sheet(s.context(), 9, 0, 15), 0.2f, 1, 1, pli_vec3_make(0, 0, 0));
    s.add(sheet(s.context(), 6, 0.7f, 0), 0.5f, 1, 1, pli_vec3_make(0.3f, 0, -0.2f));
    const int contacts = s.run(120);
    print_message("           %d contacts, all exact\n", contacts);
    assert_true(contacts > 1000);
}

void test_soft_contacts_fast_ball_hits_ball(void**) {
    scene s;
    s.add(ball(s.context(), pli_vec3_make(0.8f, 0.5f, 0.8f), pli_vec3_make(0, 0, 0)), 0.2f, 0.5f, 4,
          pli_vec3_make(0, 3, 0));
    s.add(ball(s.context(), pli_vec3_make(0.4f, 0.9f, 0.6f), pli_vec3_make(2.5f, 0.3f, 0)), 0.9f, 1, 2,
          pli_vec3_make(-12, 0, 0));
    const int contacts = s.run(60);
    print_message("           %d contacts, all exact\n", contacts);
    assert_true(contacts > 300);
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_soft_contacts_ball_on_pinned_sheet),
        cmocka_unit_test(test_soft_contacts_sheet_falls_on_sheet),
        cmocka_unit_test(test_soft_contacts_fast_ball_hits_ball),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
