// Pose matching and polar decomposition against btSoftBody and btPolarDecomposition, bit for bit.

#include "check.h"
#include "sample_mesh.h"

#include "oracle/bullet_twin.hpp"

extern "C" {
#include "math/rotation_fit.h"
}

#include <pliant/pose.h>

#include <LinearMath/btPolarDecomposition.h>

#include <cstring>

namespace {

constexpr float dt = 1.0f / 60.0f;

// ------------------------------------------------------------------------------------------ polar decomposition

pli_mat3 bullet_polar(const pli_mat3& a) {
    btMatrix3x3 u, h;
    btPolarDecomposition().decompose(twin::to_bullet(a), u, h);
    return twin::to_pliant(u);
}

double orthogonality_error(const pli_mat3& u) {
    double largest = 0;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            const double error = static_cast<double>(pli_vec3_dot(u.rows[i], u.rows[k])) - (i == k ? 1.0 : 0.0);
            if (std::isnan(error)) { return std::numeric_limits<double>::infinity(); }
            largest = std::fmax(largest, std::fabs(error));
        }
    }
    return largest;
}

bool same_bits(const pli_mat3& a, const pli_mat3& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

// Random matrices of different size and condition, with exactly singular ones: wherever Bullet's result is finite ours
// has the same bits, and elsewhere ours is a rotation.
void test_polar_equals_bullet(void**) {
    twin::random_source random(11);
    int orthogonal = 0, unfinished = 0, repaired = 0;
    for (int i = 0; i < 100000; ++i) {
        pli_mat3 a;
        const float size = std::pow(10.0f, random.uniform(-5.0f, 5.0f));
        for (pli_vec3& row : a.rows) {
            row = pli_vec3_scale(random.vector(1.0f), size);
        }
        if (i % 4 == 0) { // the third row tends to a multiple of the first
            const float flatness = i % 8 == 0 ? 0.0f : std::pow(10.0f, random.uniform(-7.0f, 0.0f));
            a.rows[2] = pli_vec3_add(pli_vec3_scale(a.rows[0], 2.0f), pli_vec3_scale(a.rows[2], flatness));
        }
        const pli_mat3 ours = plii_polar_factor(a, pli_mat3_identity());
        const pli_mat3 theirs = bullet_polar(a);
        const double error = orthogonality_error(theirs);
        if (std::isfinite(error)) {
            assert_true(same_bits(ours, theirs));
            (error <= 1e-5 ? orthogonal : unfinished) += 1;
        } else {
            check_at_most(orthogonality_error(ours), 1e-5);
            repaired += 1;
        }
    }
    print_message("same bits: %d orthogonal, %d not; repaired: %d\n", orthogonal, unfinished, repaired);
    assert_true(orthogonal > 50000);
    assert_true(unfinished > 10000);
    assert_true(repaired > 1000);
}

// ------------------------------------------------------------------------------------------------ pose matching

struct fixture {
    btSoftBodyWorldInfo info = twin::world_info();
    pli_context* context = nullptr;
    pli_world* world = nullptr;
    pli_body* body = nullptr;
    std::unique_ptr<btSoftBody> soft;

    fixture(int pinned_node, float matching) {
        assert_int_equal(pli_context_create(nullptr, &context), PLI_OK);
        pli_world_def def = pli_world_def_default();
        def.reference_mode = true; // pinned bodies keep no shape
        assert_int_equal(pli_world_create(context, &def, &world), PLI_OK);
        pli_mesh* mesh = nullptr;
        assert_int_equal(sample_create_ellipsoid(context, pli_vec3_make(1.0f, 1.3f, 0.8f), &mesh), PLI_OK);
        twin::random_source random(23);
        for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
            assert_int_equal(pli_mesh_set_node_mass(mesh, i, i == pinned_node ? 0.0f : random.uniform(0.1f, 2.0f)),
                             PLI_OK);
        }
        soft = twin::make_soft_body(info, mesh);
        pli_body_def body_def = pli_body_def_default();
        body_def.solver.position_iterations = 1; // as in Bullet
        assert_int_equal(pli_body_create(world, mesh, &body_def, &body), PLI_OK);
        pli_mesh_destroy(mesh);
        assert_int_equal(pli_body_enable_pose_matching(body, matching), PLI_OK);
        soft->setPose(false, true);
        soft->m_cfg.kMT = matching;
        for (int i = 0; i < SAMPLE_SPHERE_NODES; ++i) {
            btSoftBody::Node& node = soft->m_nodes[i];
            if (node.m_im > 0) {
                node.m_x += twin::to_bullet(random.vector(0.2f));
                node.m_v += btVector3(0, 0, 5).cross(node.m_x) + twin::to_bullet(random.vector(3.0f));
            }
        }
        assert_int_equal(twin::copy_state(*soft, body), PLI_OK);
    }
    ~fixture() {
        pli_world_destroy(world);
        pli_context_destroy(context);
    }
    fixture(const fixture&) = delete;
    fixture& operator=(const fixture&) = delete;

    void step() {
        twin::step(*soft, dt);
        assert_int_equal(pli_world_step(world, dt), PLI_OK);
    }
};

// Both run freely from one state, pose included.
void test_pose_matching_equals_bullet(void**) {
    for (const int pinned : {-1, 30}) {
        for (const float matching : {0.0f, 0.05f, 0.6f}) {
            fixture f(pinned, matching);
            for (int i = 0; i < 150; ++i) {
                f.step();
                const twin::difference apart = twin::compare(*f.soft, f.body);
                if (!apart.is_exact()) {
                    fail_msg("step %d, matching %g: node %d apart by %g m", i, static_cast<double>(matching),
                             apart.node, apart.position);
                }
                pli_transform pose;
                assert_int_equal(pli_body_get_pose(f.body, &pose), PLI_OK);
                assert_true(same_bits(pose.rotation, twin::to_pliant(f.soft->m_pose.m_rot)));
                assert_true(twin::distance(pose.origin, twin::to_pliant(f.soft->m_pose.m_com)) == 0);
            }
        }
    }
}

void test_the_comparison_sees_pose_matching(void**) {
    fixture f(30, 0.05f);
    assert_int_equal(pli_body_disable_pose_matching(f.body), PLI_OK);
    f.step();
    assert_false(twin::compare(*f.soft, f.body).is_exact());
}

void test_taking_the_pose_anew_equals_bullet(void**) {
    fixture f(30, 0.05f);
    for (int i = 0; i < 10; ++i) {
        f.step();
    }
    // setPose also takes new rest lengths in Bullet, which enabling does not in Pliant: keep those of before.
    std::vector<btScalar> rest_lengths;
    for (int i = 0; i < f.soft->m_links.size(); ++i) {
        rest_lengths.push_back(f.soft->m_links[i].m_rl);
    }
    f.soft->setPose(false, true);
    for (int i = 0; i < f.soft->m_links.size(); ++i) {
        btSoftBody::Link& link = f.soft->m_links[i];
        link.m_rl = rest_lengths[static_cast<std::size_t>(i)];
        link.m_c1 = link.m_rl * link.m_rl;
    }
    f.soft->m_cfg.kMT = 0.2f;
    assert_int_equal(pli_body_enable_pose_matching(f.body, 0.2f), PLI_OK);
    for (int i = 0; i < 50; ++i) {
        f.step();
    }
    assert_true(twin::compare(*f.soft, f.body).is_exact());
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_polar_equals_bullet),
        cmocka_unit_test(test_pose_matching_equals_bullet),
        cmocka_unit_test(test_the_comparison_sees_pose_matching),
        cmocka_unit_test(test_taking_the_pose_anew_equals_bullet),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
