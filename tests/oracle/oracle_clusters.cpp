// Clusters against btSoftBody, bit for bit: generation, frames, matching, damping, pinned nodes.

#include "oracle/bullet_clusters.hpp"

#include "sample_mesh.h"

namespace {

pli_mesh* ball(pli_context* context, pli_vec3 radii) {
    pli_mesh* mesh = nullptr;
    assert_int_equal(sample_create_ellipsoid(context, radii, &mesh), PLI_OK);
    return mesh;
}

pli_mesh* sheet(pli_context* context, int nodes, int pins) {
    pli_mesh* mesh = nullptr;
    assert_int_equal(sample_create_sheet(context, nodes, 2, pins, &mesh), PLI_OK);
    return mesh;
}

pli_mesh* rope(pli_context* context) {
    pli_mesh* mesh = nullptr;
    assert_int_equal(
        pli_mesh_create_rope(context, pli_vec3_make(-4, 3, 0), pli_vec3_make(4, 2, 1), 30, PLI_ROPE_PIN_FIRST, &mesh),
        PLI_OK);
    return mesh;
}

// A row of cubes of five tetrahedra each, sheared.
pli_mesh* tetras(pli_context* context) {
    std::vector<pli_vec3> points;
    for (int i = 0; i < 5; ++i) {
        for (int k = 0; k < 4; ++k) {
            const float x = static_cast<float>(i), y = static_cast<float>(k & 1), z = static_cast<float>(k / 2);
            points.push_back(pli_vec3_make(x + 0.2f * y, y, z - 0.1f * x));
        }
    }
    std::vector<int> indices;
    for (int i = 0; i < 4; ++i) {
        const int near = 4 * i, far = near + 4;
        const int one[5][4] = {{near, near + 1, near + 2, far},
                               {near + 3, near + 2, near + 1, far + 3},
                               {far + 1, far, far + 3, near + 1},
                               {far + 2, far + 3, far, near + 2},
                               {near + 1, near + 2, far, far + 3}};
        for (const auto& tetra : one) {
            indices.insert(indices.end(), tetra, tetra + 4);
        }
    }
    pli_mesh* mesh = nullptr;
    assert_int_equal(pli_mesh_create_from_tetras(context, static_cast<int>(points.size()), points.data(),
                                                 static_cast<int>(indices.size() / 4), indices.data(), &mesh),
                     PLI_OK);
    return mesh;
}

pli_cluster_settings settings(float matching, float node, float linear, float angular) {
    pli_cluster_settings result = {};
    result.matching = matching;
    result.node_damping = node;
    result.linear_damping = linear;
    result.angular_damping = angular;
    result.collides = true;
    result.max_self_impulse = 100;
    result.self_impulse_factor = 1;
    return result;
}

void test_generated_clusters_equal_bullet(void**) {
    twin::cluster_scene s;
    for (const int count : {1, 3, 8, 16, 64, 1000}) {
        const int on_ball = pli_body_cluster_count(s.add(ball(s.context(), {2, 1, 3}), count).pliant);
        const int on_sheet = pli_body_cluster_count(s.add(sheet(s.context(), 17, PLI_PATCH_PIN_00), count).pliant);
        const int on_rope = pli_body_cluster_count(s.add(rope(s.context()), count).pliant);
        print_message("           k = %d: %d, %d and %d clusters\n", count, on_ball, on_sheet, on_rope);
    }
}

void test_stopped_generation_equals_bullet(void**) {
    twin::cluster_scene s;
    twin::soft_twin& made = s.add(ball(s.context(), {2, 1, 3}), 7);
    for (const int iterations : {1, 2, 5, 17, 40}) {
        made.bullet->generateClusters(7, iterations);
        assert_int_equal(pli_body_generate_clusters(made.pliant, 7, iterations, nullptr), PLI_OK);
        twin::check_clusters(*made.bullet, made.pliant);
    }
}

void test_clusters_of_elements_equal_bullet(void**) {
    twin::cluster_scene s;
    twin::soft_twin& solid = s.add(tetras(s.context()), 0);
    assert_int_equal(pli_body_cluster_count(solid.pliant), 20);
    twin::soft_twin& surface = s.add(ball(s.context(), {1, 1, 1}), 0);
    assert_int_equal(pli_body_cluster_count(surface.pliant), surface.bullet->m_faces.size());
    twin::cluster_scene::set_cluster(solid, 3, settings(0.3f, 0.1f, 0, 0));
    s.set_velocity(solid, {0, 0, 0}, 3, 5);
    s.set_velocity(surface, {0, 0, 0}, 1, 6);
    s.run(150);
}

// Matching, and all three kinds of damping, in clusters that share nodes; some with pinned nodes.
void build_steps(twin::cluster_scene& s) {
    twin::soft_twin& soft = s.add(ball(s.context(), {1, 2, 1}), 6, 2);
    const int clusters = pli_body_cluster_count(soft.pliant);
    for (int i = 0; i < clusters; ++i) {
        const float scale = static_cast<float>(i + 1) / static_cast<float>(clusters);
        twin::cluster_scene::set_cluster(soft, i, settings(0.2f * scale, 0.3f * scale, 0.1f * scale, 0.2f * scale));
    }
    s.set_velocity(soft, {1, 2, 0}, 4, 11);
    twin::soft_twin& cloth = s.add(sheet(s.context(), 5, PLI_PATCH_PIN_00 | PLI_PATCH_PIN_10), 4, 3);
    for (int i = 0; i < pli_body_cluster_count(cloth.pliant); ++i) {
        twin::cluster_scene::set_cluster(cloth, i, settings(i % 2 == 0 ? 0.1f : 0.0f, 0.2f, 0.05f, 0.1f));
    }
    s.set_velocity(cloth, {0, 0, 0}, 2, 12);
}

void test_steps_equal_bullet(void**) {
    twin::cluster_scene s;
    build_steps(s);
    s.run(150);
}

void test_synchronized_steps_equal_bullet(void**) {
    twin::cluster_scene s;
    build_steps(s);
    s.run(150, true);
}

// Turned inside out, frames are reflections on both sides.
void test_inverted_cluster_equals_bullet(void**) {
    twin::cluster_scene s;
    twin::soft_twin& soft = s.add(ball(s.context(), {1, 2, 1}), 1, 2);
    twin::cluster_scene::set_cluster(soft, 0, settings(0.1f, 0, 0, 0));
    for (int i = 0; i < soft.bullet->m_nodes.size(); ++i) {
        soft.bullet->m_nodes[i].m_x.setX(-soft.bullet->m_nodes[i].m_x.x());
    }
    assert_int_equal(twin::copy_state(*soft.bullet, soft.pliant), PLI_OK);
    s.run(50);
    pli_cluster_view view;
    assert_int_equal(pli_body_get_cluster(soft.pliant, 0, &view), PLI_OK);
    const pli_mat3 r = view.frame.rotation;
    check_near(pli_vec3_dot(r.rows[0], pli_vec3_cross(r.rows[1], r.rows[2])), -1, 1e-5);
}

// Nodes in a line, and pinned nodes of 1e18 kg, may have an inertia that Bullet cannot invert: the cluster's turning is
// no number then, which keeps it from damping nodes.
void test_clusters_without_an_inverse_damp_no_nodes(void**) {
    for (const int pins : {0, int{PLI_ROPE_PIN_FIRST}}) {
        twin::cluster_scene s;
        s.compares_clusters = false;
        pli_mesh* line = nullptr;
        assert_int_equal(
            pli_mesh_create_rope(s.context(), pli_vec3_make(0, 0, 0), pli_vec3_make(4, 0, 0), 13, pins, &line), PLI_OK);
        twin::soft_twin& soft = s.add(line, 1, 2);
        twin::cluster_scene::set_cluster(soft, 0, settings(0, 0.5f, 0.1f, 0.1f));
        assert_false(std::isfinite(soft.bullet->m_clusters[0]->m_locii[0].x()));
        s.set_velocity(soft, {1, 0, 2}, 0, 7);
        s.run(30);
    }
}

} // namespace

int main() {
    const CMUnitTest tests[] = {
        cmocka_unit_test(test_generated_clusters_equal_bullet),
        cmocka_unit_test(test_stopped_generation_equals_bullet),
        cmocka_unit_test(test_clusters_of_elements_equal_bullet),
        cmocka_unit_test(test_steps_equal_bullet),
        cmocka_unit_test(test_synchronized_steps_equal_bullet),
        cmocka_unit_test(test_inverted_cluster_equals_bullet),
        cmocka_unit_test(test_clusters_without_an_inverse_damp_no_nodes),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
