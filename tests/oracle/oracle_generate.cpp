// Generators, orders, masses and motions of meshes against btSoftBody: everything must have the same bits.

#include <pliant/bullet_reference.h>
#include <pliant/generate.h>

#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <cstring>
#include <functional>
#include <memory>
#include <vector>

#include "check.h" // last: cmocka defines fail() as a macro

namespace {

using soft_ptr = std::unique_ptr<btSoftBody>;
using mesh_ptr = std::unique_ptr<pli_mesh, decltype(&pli_mesh_destroy)>;

pli_context* context = nullptr;
btSoftBodyWorldInfo world_info;

int setup(void**) {
    return pli_context_create(nullptr, &context) == PLI_OK ? 0 : -1;
}

int teardown(void**) {
    const size_t left = pli_context_allocated_bytes(context);
    pli_context_destroy(context);
    return left == 0 ? 0 : -1;
}

btVector3 to_bullet(pli_vec3 v) {
    return btVector3(v.x, v.y, v.z);
}

bool same_bits(float a, float b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

void check_same(const btSoftBody& soft, const pli_mesh* mesh) {
    const pli_mesh_view view = pli_mesh_get_view(mesh);
    assert_int_equal(view.node_count, soft.m_nodes.size());
    assert_int_equal(view.link_count, soft.m_links.size());
    assert_int_equal(view.face_count, soft.m_faces.size());
    assert_int_equal(view.tetra_count, soft.m_tetras.size());
    const btSoftBody::Node* first = view.node_count > 0 ? &soft.m_nodes[0] : nullptr;
    for (int i = 0; i < view.node_count; ++i) {
        const btSoftBody::Node& node = soft.m_nodes[i];
        const pli_vec3 p = view.positions[i];
        if (!same_bits(p.x, node.m_x.x()) || !same_bits(p.y, node.m_x.y()) || !same_bits(p.z, node.m_x.z())) {
            fail_msg("node %d is (%.9g %.9g %.9g), Bullet has (%.9g %.9g %.9g)", i, double(p.x), double(p.y),
                     double(p.z), double(node.m_x.x()), double(node.m_x.y()), double(node.m_x.z()));
        }
        if (!same_bits(view.inverse_masses[i], node.m_im)) {
            fail_msg("inverse mass %d is %.9g, Bullet has %.9g", i, double(view.inverse_masses[i]), double(node.m_im));
        }
    }
    for (int i = 0; i < view.link_count; ++i) {
        const btSoftBody::Link& link = soft.m_links[i];
        assert_int_equal(view.links[i].nodes[0], link.m_n[0] - first);
        assert_int_equal(view.links[i].nodes[1], link.m_n[1] - first);
        assert_int_equal(view.links[i].is_bending, link.m_bbending != 0);
    }
    for (int i = 0; i < view.face_count; ++i) {
        for (int k = 0; k < 3; ++k) {
            assert_int_equal(view.faces[i].nodes[k], soft.m_faces[i].m_n[k] - first);
        }
    }
    for (int i = 0; i < view.tetra_count; ++i) {
        for (int k = 0; k < 4; ++k) {
            assert_int_equal(view.tetras[i].nodes[k], soft.m_tetras[i].m_n[k] - first);
        }
    }
}

// The same mesh in both libraries.
struct pair {
    soft_ptr soft;
    mesh_ptr mesh;
    void check() const { check_same(*soft, mesh.get()); }
};

mesh_ptr take(const std::function<pli_status(pli_mesh**)>& create) {
    pli_mesh* mesh = nullptr;
    assert_int_equal(create(&mesh), PLI_OK);
    return mesh_ptr(mesh, pli_mesh_destroy);
}

pair make_patch(pli_patch_def def) {
    return {soft_ptr(btSoftBodyHelpers::CreatePatch(world_info, to_bullet(def.corner_00), to_bullet(def.corner_10),
                                                    to_bullet(def.corner_01), to_bullet(def.corner_11), def.columns,
                                                    def.rows, def.pins, def.diagonals)),
            take([&](pli_mesh** mesh) { return pli_mesh_create_patch(context, &def, mesh); })};
}

// Two torus-like strips of a grid in space, closed in one direction, so that there are two components.
void fill_surface(int rings, int around, std::vector<pli_vec3>& points, std::vector<int>& triangles) {
    for (int part = 0; part < 2; ++part) {
        const int base = static_cast<int>(points.size());
        for (int i = 0; i < rings; ++i) {
            for (int k = 0; k < around; ++k) {
                const float a = 6.2831853f * static_cast<float>(i) / static_cast<float>(rings);
                const float b = 6.2831853f * static_cast<float>(k) / static_cast<float>(around);
                const float r = 2.0f + 0.5f * std::cos(b);
                points.push_back(pli_vec3_make(r * std::cos(a), 0.5f * std::sin(b) + 3.0f * static_cast<float>(part),
                                               r * std::sin(a)));
            }
        }
        for (int i = 0; i < rings; ++i) {
            for (int k = 0; k < around; ++k) {
                const int next_i = (i + 1) % rings, next_k = (k + 1) % around;
                const int a = base + i * around + k, b = base + i * around + next_k;
                const int c = base + next_i * around + k, d = base + next_i * around + next_k;
                const int cell[6] = {a, b, c, b, d, c};
                triangles.insert(triangles.end(), cell, cell + 6);
            }
        }
    }
}

pair make_surface(int rings, int around, bool shuffle) {
    std::vector<pli_vec3> points;
    std::vector<int> triangles;
    fill_surface(rings, around, points, triangles);
    std::vector<btScalar> coordinates;
    for (const pli_vec3& p : points) {
        coordinates.insert(coordinates.end(), {p.x, p.y, p.z});
    }
    const int count = static_cast<int>(triangles.size()) / 3;
    return {soft_ptr(
                btSoftBodyHelpers::CreateFromTriMesh(world_info, coordinates.data(), triangles.data(), count, shuffle)),
            take([&](pli_mesh** mesh) {
                return pli_mesh_create_from_triangles(context, static_cast<int>(points.size()), points.data(), count,
                                                      triangles.data(), shuffle, mesh);
            })};
}

// A block of cells of five tetrahedra; links by Bullet's own appendLink with its check for duplicates.
pair make_block(int n) {
    std::vector<pli_vec3> points;
    std::vector<int> tetras;
    for (int x = 0; x <= n; ++x) {
        for (int y = 0; y <= n; ++y) {
            for (int z = 0; z <= n; ++z) {
                points.push_back(pli_vec3_make(0.31f * static_cast<float>(x * x), 0.7f * static_cast<float>(y),
                                               -0.13f * static_cast<float>(z + x)));
            }
        }
    }
    const int side = n + 1;
    for (int x = 0; x < n; ++x) {
        for (int y = 0; y < n; ++y) {
            for (int z = 0; z < n; ++z) {
                int c[8];
                for (int i = 0; i < 8; ++i) {
                    c[i] = ((x + (i & 1)) * side + y + ((i >> 1) & 1)) * side + z + (i >> 2);
                }
                const int five[20] = {c[0], c[1], c[2], c[4], c[3], c[2], c[1], c[7], c[5], c[1],
                                      c[7], c[4], c[6], c[7], c[2], c[4], c[1], c[2], c[7], c[4]};
                tetras.insert(tetras.end(), five, five + 20);
            }
        }
    }
    std::vector<btVector3> positions;
    for (const pli_vec3& p : points) {
        positions.push_back(to_bullet(p));
    }
    soft_ptr soft(new btSoftBody(&world_info, static_cast<int>(points.size()), positions.data(), nullptr));
    for (size_t i = 0; i < tetras.size(); i += 4) {
        const int* t = &tetras[i];
        soft->appendTetra(t[0], t[1], t[2], t[3]);
        const int ends[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
        for (const auto& e : ends) {
            soft->appendLink(t[e[0]], t[e[1]], nullptr, true);
        }
    }
    return {std::move(soft), take([&](pli_mesh** mesh) {
                return pli_mesh_create_from_tetras(context, static_cast<int>(points.size()), points.data(),
                                                   static_cast<int>(tetras.size() / 4), tetras.data(), mesh);
            })};
}

pli_patch_def skewed_patch(int columns, int rows, int pins, bool diagonals) {
    pli_patch_def def = pli_patch_def_default();
    def.corner_00 = pli_vec3_make(-4.1f, 0.3f, -3.9f);
    def.corner_10 = pli_vec3_make(5.7f, -0.9f, -4.4f);
    def.corner_01 = pli_vec3_make(-3.3f, 1.1f, 6.1f);
    def.corner_11 = pli_vec3_make(4.9f, 2.3f, 7.7f);
    def.columns = columns;
    def.rows = rows;
    def.pins = pins;
    def.diagonals = diagonals;
    return def;
}

void test_rope(void**) {
    const pli_vec3 from = pli_vec3_make(-10.1f, 0.7f, 3.3f), to = pli_vec3_make(10.3f, 5.9f, -1.7f);
    for (int inner : {0, 1, 2, 8, 16, 61, 1000}) {
        for (int pins = 0; pins < 4; ++pins) {
            const pair p = {
                soft_ptr(btSoftBodyHelpers::CreateRope(world_info, to_bullet(from), to_bullet(to), inner, pins)),
                take([&](pli_mesh** mesh) { return pli_mesh_create_rope(context, from, to, inner, pins, mesh); })};
            p.check();
        }
    }
}

void test_patch(void**) {
    const int sizes[][2] = {{2, 2}, {2, 5}, {5, 2}, {9, 9}, {10, 30}, {31, 31}};
    for (const auto& size : sizes) {
        for (int pins = 0; pins < 16; ++pins) {
            for (int diagonals = 0; diagonals < 2; ++diagonals) {
                make_patch(skewed_patch(size[0], size[1], pins, diagonals != 0)).check();
            }
        }
    }
}

void test_patch_uv(void**) {
    const int sizes[][2] = {{2, 2}, {3, 2}, {2, 3}, {10, 7}, {31, 30}};
    for (const auto& size : sizes) {
        const size_t count = static_cast<size_t>(12 * (size[0] - 1) * (size[1] - 1));
        for (int pins = 0; pins < 512; pins += pins < 16 ? 1 : 31) {
            const pli_patch_def def = skewed_patch(size[0], size[1], pins, (pins & 1) != 0);
            std::vector<float> uv(count, -1.0f), expected(count, -2.0f);
            const pair p = {
                soft_ptr(btSoftBodyHelpers::CreatePatchUV(
                    world_info, to_bullet(def.corner_00), to_bullet(def.corner_10), to_bullet(def.corner_01),
                    to_bullet(def.corner_11), def.columns, def.rows, def.pins, def.diagonals, expected.data())),
                take([&](pli_mesh** mesh) { return pli_mesh_create_patch_uv(context, &def, uv.data(), mesh); })};
            p.check();
            assert_memory_equal(uv.data(), expected.data(), count * sizeof(float));
        }
    }
}

void test_triangles_and_double_shuffle(void**) {
    make_surface(30, 10, false).check();
    const pair p = make_surface(30, 10, true);
    p.check();
    for (int i = 0; i < 3; ++i) {
        p.soft->randomizeConstraints();
        assert_int_equal(pli_mesh_shuffle_links(p.mesh.get()), PLI_OK);
        p.check();
    }
}

// Two and more in a chain, so that later ones see the links of earlier ones.
void check_chained_bending(const pair& p, std::initializer_list<int> distances) {
    for (int distance : distances) {
        int added = -1;
        const int expected = p.soft->generateBendingConstraints(distance);
        assert_int_equal(pli_mesh_append_bending_links(p.mesh.get(), distance, 0, &added), PLI_OK);
        assert_int_equal(added, expected);
        p.check();
    }
    p.soft->randomizeConstraints();
    pli_mesh_shuffle_links(p.mesh.get());
    p.check();
}

void test_bending(void**) {
    check_chained_bending(make_patch(skewed_patch(13, 9, 0, true)), {2, 3, 4});
    check_chained_bending(make_patch(skewed_patch(13, 9, 0, false)), {2, 3, 4});
    check_chained_bending(make_patch(skewed_patch(13, 9, 0, false)), {4, 3, 2});
    check_chained_bending(make_patch(skewed_patch(13, 9, 0, false)), {5, 100, 3});
    check_chained_bending(make_surface(12, 7, true), {2, 3, 4});
    check_chained_bending(make_surface(12, 7, true), {3, 2});
    check_chained_bending(make_block(3), {2, 3, 4});
}

void test_interleave(void**) {
    const pair patch = make_patch(skewed_patch(12, 15, 0, true));
    btSoftBodyHelpers::ReoptimizeLinkOrder(patch.soft.get());
    assert_int_equal(pli_mesh_interleave_links(patch.mesh.get()), PLI_OK);
    patch.check();
    const pair surface = make_surface(20, 8, true);
    surface.soft->generateBendingConstraints(2);
    pli_mesh_append_bending_links(surface.mesh.get(), 2, 0, nullptr);
    surface.soft->appendLink(3, 4); // a second link between the same nodes
    pli_mesh_append_link(surface.mesh.get(), 3, 4, 0, nullptr);
    for (int i = 0; i < 2; ++i) {
        btSoftBodyHelpers::ReoptimizeLinkOrder(surface.soft.get());
        assert_int_equal(pli_mesh_interleave_links(surface.mesh.get()), PLI_OK);
        surface.check();
    }
}

void test_masses(void**) {
    const pair patch = make_patch(skewed_patch(12, 15, PLI_PATCH_PIN_CORNERS, true));
    assert_true(same_bits(pli_mesh_total_mass(patch.mesh.get()), patch.soft->getTotalMass()));
    patch.soft->setMass(17, 0.37f);
    pli_mesh_set_node_mass(patch.mesh.get(), 17, 0.37f);
    for (float mass : {1.0f, 0.1f, 23.7f}) {
        patch.soft->setTotalMass(mass);
        assert_int_equal(pli_mesh_set_total_mass(patch.mesh.get(), mass), PLI_OK);
        patch.check();
        assert_true(same_bits(pli_mesh_total_mass(patch.mesh.get()), patch.soft->getTotalMass()));
    }
    const pair surface = make_surface(30, 10, true);
    for (float mass : {50.0f, 0.3f}) {
        surface.soft->setTotalMass(mass, true);
        assert_int_equal(pli_mesh_set_total_mass_from_faces(surface.mesh.get(), mass), PLI_OK);
        surface.check();
    }
    surface.soft->setTotalDensity(btFabs(13.0f) * (surface.soft->getVolume() > 0 ? 1.0f : -1.0f));
    assert_int_equal(pli_mesh_set_density_from_faces(surface.mesh.get(), 13.0f), PLI_OK);
    surface.check();
    const pair block = make_block(4);
    block.soft->setVolumeMass(300);
    assert_int_equal(pli_mesh_set_total_mass_from_tetras(block.mesh.get(), 300), PLI_OK);
    block.check();
}

void test_motions_and_volume(void**) {
    const pair p = make_surface(30, 10, true);
    assert_true(same_bits(pli_mesh_volume(p.mesh.get()), p.soft->getVolume()));
    const pli_quat q = pli_quat_from_yaw_pitch_roll(0.4f, -1.2f, 2.9f);
    const pli_transform motion = pli_transform_make(q, pli_vec3_make(3.1f, -7.7f, 0.9f));
    p.soft->transform(btTransform(btQuaternion(q.x, q.y, q.z, q.w), btVector3(3.1f, -7.7f, 0.9f)));
    assert_int_equal(pli_mesh_transform(p.mesh.get(), motion), PLI_OK);
    p.check();
    p.soft->scale(btVector3(1.7f, 0.3f, 2.9f));
    assert_int_equal(pli_mesh_scale(p.mesh.get(), pli_vec3_make(1.7f, 0.3f, 2.9f)), PLI_OK);
    p.check();
    p.soft->rotate(btQuaternion(0.9f, 0.8f, 0.7f));
    assert_int_equal(pli_mesh_rotate(p.mesh.get(), pli_quat_from_yaw_pitch_roll(0.9f, 0.8f, 0.7f)), PLI_OK);
    p.check();
    p.soft->translate(btVector3(0.1f, 1000.3f, -2.2f));
    assert_int_equal(pli_mesh_translate(p.mesh.get(), pli_vec3_make(0.1f, 1000.3f, -2.2f)), PLI_OK);
    p.check();
    assert_true(same_bits(pli_mesh_volume(p.mesh.get()), p.soft->getVolume()));
    make_block(3).check();
}

// Bullet's hull leaves out 2 of the 515 points (it drops what is closer than 0.1 % of the diagonal); the others are the
// same up to the rounding of its scaling to and fro.
void test_ellipsoid_nodes(void**) {
    const pli_vec3 center = pli_vec3_make(35, 25, 0), radii = pli_vec3_make(3, 3.5f, 2.5f);
    const soft_ptr soft(btSoftBodyHelpers::CreateEllipsoid(world_info, to_bullet(center), to_bullet(radii), 512));
    const mesh_ptr mesh =
        take([&](pli_mesh** made) { return pli_mesh_create_ellipsoid(context, center, radii, 515, made); });
    const pli_mesh_view view = pli_mesh_get_view(mesh.get());
    assert_int_equal(soft->m_nodes.size(), 513);
    assert_int_equal(view.node_count, 515);
    assert_int_equal(view.link_count, 3 * 515 - 6);
    assert_int_equal(view.face_count, 2 * 515 - 4);
    for (int i = 0; i < soft->m_nodes.size(); ++i) {
        float nearest = 1e30f;
        for (int k = 0; k < view.node_count; ++k) {
            nearest = std::fmin(nearest, (soft->m_nodes[i].m_x - to_bullet(view.positions[k])).length());
        }
        check_at_most(nearest, 5e-6); // an ulp of 35 is 4e-6
    }
    check_near(pli_mesh_volume(mesh.get()), soft->getVolume(), 0.002f * soft->getVolume());
    assert_true(pli_mesh_volume(mesh.get()) > soft->getVolume());
}

} // namespace

int main() {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rope),
        cmocka_unit_test(test_patch),
        cmocka_unit_test(test_patch_uv),
        cmocka_unit_test(test_triangles_and_double_shuffle),
        cmocka_unit_test(test_bending),
        cmocka_unit_test(test_interleave),
        cmocka_unit_test(test_masses),
        cmocka_unit_test(test_motions_and_volume),
        cmocka_unit_test(test_ellipsoid_nodes),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
